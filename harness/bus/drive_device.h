/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * drive_device.h - a slave made of one or two drive axes: process image, object dictionary, error
 * history, inputs. A device type is one const row of struct drive_kind (dev_drive.c, dev_tgz.c).
 *
 * Inputs that the outside world can hold (bus_set_input), channel = 32 * axis + bit of 0x60FD:
 *   0, 1, 2   negative limit, positive limit, home switch, instead of the machine's own
 *   16 .. 31  user inputs, low when nobody holds them
 * Values are 0 and 1.
 */
#ifndef HARNESS_BUS_DRIVE_DEVICE_H
#define HARNESS_BUS_DRIVE_DEVICE_H

#include "bus/device.h"
#include "bus/drive.h"
#include "bus/drive_rest.h"

enum {
    DRIVE_AXES = 2,
    DRIVE_RX_MAPS = 8,
    DRIVE_TX_MAPS = 4,
    DRIVE_HISTORY = 64,          /* entries of 0x1003, at most */
    DRIVE_INPUTS = 32,           /* channels per axis */
    DRIVE_IMAGE_MAX = 0x100 / 3, /* three buffers in the 0x100 bytes between SM2 and SM3 */
};

struct drive_device;

struct drive_kind {
    const struct od *od;
    const struct sii_info *sii; /* its PDO lists are the default mapping and assignment */
    uint8_t axes;               /* that move; objects of others are there and dead */
    uint8_t history;            /* entries of 0x1003 */
    const struct drive_model *model[DRIVE_AXES];
    uint8_t (*error_register)(const struct drive_device *device); /* 0x1001 */
    uint32_t (*history_entry)(unsigned axis, uint16_t code);
};

struct drive_device {
    struct drive axis[DRIVE_AXES];
    const struct drive_kind *kind;
    struct device_setup setup;
    uint16_t reported[DRIVE_AXES]; /* error codes that history and emergencies know of */
    bool maps_rest;                /* the inputs have more than drive_publish_cyclic() gives */
    bool cruises;                  /* one axis with the default mapping (drive_cruise.h) */
    struct drive_rest rest;        /* of the first axis */
    uint8_t error_register;        /* 1001 */
    uint8_t history_count;         /* 1003 */
    uint32_t history[DRIVE_HISTORY];
    uint32_t identity[4]; /* 1018: vendor, product, revision, serial */
    struct pdo_assign assign[2];
    struct pdo_map rx[DRIVE_RX_MAPS], tx[DRIVE_TX_MAPS];
    struct pdo_image image[2];
};

/* Callbacks of struct device_type; device_type.model is the struct drive_kind. */
void drive_device_init(void *device, const struct device_setup *setup);
void drive_device_power_on(void *device, uint64_t now_ns);
void drive_device_state(void *device, unsigned al_state, uint64_t now_ns);
void drive_device_step(void *device, uint64_t now_ns);
void drive_device_step_four(void *const devices[4], const uint64_t now_ns[4]);
void drive_device_outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns);
void drive_device_inputs(void *device, uint8_t *data, size_t length);
int drive_device_set_input(void *device, unsigned channel, int64_t value);
int drive_device_get_input(const void *device, unsigned channel, int64_t *value);
void drive_device_free_input(void *device, unsigned channel);
int drive_device_fault(void *device, unsigned axis, uint16_t code, uint64_t now_ns);

/* Callbacks of struct od. */
uint32_t drive_device_check(void *device, uint16_t index, uint8_t subindex, int64_t value);
void drive_device_refresh(void *device);
void drive_device_written(void *device, uint16_t index, uint8_t subindex);

/* Error codes that appeared or went since the last call enter the history, oldest first, and leave
 * as emergencies. */
void drive_device_report(struct drive_device *device);
void drive_device_remember(struct drive_device *device, uint32_t entry);

enum { DRIVE_REGISTER_SECOND_AXIS = 0x80 }; /* of 0x1001 */

/* Ones and zeros of a word, one by one. */
uint32_t drive_with_bit(uint32_t word, unsigned bit, bool value);

/* An object of any axis: which, and its index on the first. */
unsigned drive_object_axis(uint16_t index);
uint16_t drive_object_base(uint16_t index);

/* The rules of CiA 301. */
uint8_t drive_error_register(const struct drive_device *device);
uint32_t drive_history_entry(unsigned axis, uint16_t code);

extern const struct od drive_od, drive_od_x2;
/* Default PDOs of the generic drives: axis 1, then axis 2. */
extern const struct sii_pdo drive_rx_pdos[DRIVE_RX_MAPS], drive_tx_pdos[DRIVE_TX_MAPS];

#define DRIVE_NAME    "Simulated servo drive CiA 402"
#define DRIVE_NAME_X2 "Simulated servo drive CiA 402, 2 axes"
/* Longer than a mailbox: masters must read it in segments. */
#define DRIVE_HARDWARE                                                                             \
    "simulation: an inertia of one revolution per revolution between two hard stops, with "        \
    "friction, a home switch, and 2^20 increments; no mains, no motor, no heat"

#endif
