/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * device.h - what stands above a slave controller: the application side of a slave.
 *
 * A device type is one const row: identity and SII content as data, an object dictionary when it
 * speaks CoE, and a handful of callbacks. Adding a device is one file with such a row and one line
 * in devices.c; adding a terminal is one device file in terminals/ and one line there. Callbacks
 * run inside segment processing: they must not block, allocate or look at any clock but the one
 * they are given.
 */
#ifndef HARNESS_BUS_DEVICE_H
#define HARNESS_BUS_DEVICE_H

#include "bus/bus.h"
#include "bus/od.h"
#include "bus/sii.h"

/* Where a device sends its CoE emergencies: error code, error register, five bytes of its own.
 * `send` may be NULL. */
struct device_emergency {
    void (*send)(void *to, uint16_t code, uint8_t error_register, const uint8_t own[5]);
    void *to;
};

struct device_type;

/* What a device instance is born with. */
struct device_setup {
    const struct device_type *type;
    struct bus_identity identity; /* as it stands in the SII */
    uint64_t seed;                /* differs per slave; the only source of variation */
    uint32_t serial;
    uint16_t alias;
    struct device_emergency emergency;
    const struct bus_stimulus *stimuli;
    size_t stimulus_count;
};

struct device_type {
    const char *name;        /* as in bus_device.type */
    const char *description; /* one line for people */
    const struct sii_info *sii;
    size_t size; /* of an instance; zeroed memory is given to init */

    /* Device emulation: the controller copies AL control to AL status and nobody checks anything,
     * as in terminals without a processor. */
    bool al_emulation;
    bool dc;            /* has a distributed clock; without, its registers do not answer */
    bool dc_delay_only; /* with dc: of the clock there are the receive times of the ports only */

    /* NULL for devices without CoE; `od->pdo` then decides the process image sizes. */
    const struct od *od;

    const void *model; /* parameters of the type, for init; NULL: none */

    void (*init)(void *device, const struct device_setup *setup);
    /* Switched on again, off, or reset by the master: the dictionary has its initial values, the
     * rest is to become as after init(), except for what the machine behind it did. NULL: nothing
     * to do.
     */
    void (*power_on)(void *device, uint64_t now_ns);
    /* The AL state has become `state` (AL_* of registers.h). */
    void (*state)(void *device, unsigned state, uint64_t now_ns);
    /* Lets time pass up to now_ns. Results must not depend on how the time is cut into calls. */
    void (*step)(void *device, uint64_t now_ns);
    /* Begins step() for four devices with the same function here, where that is quicker together
     * than one by one; each still gets its step(). NULL: it is not. */
    void (*step_four)(void *const devices[4], const uint64_t now_ns[4]);
    /* New outputs arrived in OP. */
    void (*outputs)(void *device, const uint8_t *data, size_t length, uint64_t now_ns);
    /* Fills the input image; called after step(). */
    void (*inputs)(void *device, uint8_t *data, size_t length);
    /* A pulse of SYNC0 or SYNC1 (signal 0, 1) at now_ns. NULL: nobody waits for them. */
    void (*sync)(void *device, unsigned signal, uint64_t now_ns);
    /* The process data watchdog expired in OP. */
    void (*watchdog)(void *device, uint64_t now_ns);
    /* Level of the digital output pins for register 0x0F10; NULL when the device has none. */
    uint32_t (*pins)(const void *device);
    /* The outside world holds input `channel` at `value` from now on (bus_set_input). 0 or -EINVAL;
     * NULL: no inputs. */
    int (*set_input)(void *device, unsigned channel, int64_t value);
    unsigned input_count; /* channels of set_input */
    /* What input `channel` shows. 0 or -EINVAL; NULL: it cannot be told. */
    int (*get_input)(const void *device, unsigned channel, int64_t *value);
    /* The outside world lets go of input `channel` again: its stimuli count. NULL: it cannot. */
    void (*free_input)(void *device, unsigned channel);
    /* Something in the device breaks: axis `axis` (from 0) goes into fault reaction with the CiA
     * 402 error code. 0 or -EINVAL; NULL: cannot. */
    int (*fault)(void *device, unsigned axis, uint16_t code, uint64_t now_ns);
};

/* NULL past the end. */
const struct device_type *device_type(size_t index);
const struct device_type *device_type_find(const char *name);
/* The device file of a built-in terminal; NULL when `name` is none. */
const char *device_text(const char *name);

#endif
