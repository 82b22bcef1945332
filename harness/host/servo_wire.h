/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * servo_wire.h - how a servo axis looks in the process data: a CiA 402 mapping, or the native map
 * of the TGZ. What SERVO has registers for goes through here; the rest of the host does not know
 * which of the two a drive has.
 *
 * Knows no layout of the shared memories.
 */
#ifndef HARNESS_HOST_SERVO_WIRE_H
#define HARNESS_HOST_SERVO_WIRE_H

#include "host/host.h"

#define NO_SLAVE SIZE_MAX /* of a virtual servo */

enum wire_state { WIRE_READY, WIRE_ENABLED, WIRE_FAULT };

/* What a drive says of one axis. */
struct wire_answer {
    enum wire_state state;
    uint32_t status_word;
    uint64_t position; /* raw: wraps */
    uint32_t inputs;
    uint32_t analog;
    int32_t current;
};

/* What it is told. */
struct wire_order {
    bool enable, reset_fault;
    int64_t position;
    uint32_t outputs;
    uint16_t limit; /* of the current: 0 none, 32767 no current */
};

struct wire_kind;

struct servo_wire {
    const struct wire_kind *kind;
    struct bus_entry control, mode, target, limit, outputs; /* bits == 0 when not mapped */
    struct bus_entry status, actual, inputs, analog, current;
    unsigned axis; /* of the drive, from 0 */
    bool shared;   /* both axes have every other one of the digital inputs and outputs (TGZ) */
    double per_revolution; /* increments on the wire */
    uint32_t resolution;   /* increments per revolution that the drive has by itself */
};

/* The slave with this Node: the one whose configured station alias it is, otherwise the one at that
 * place on the bus, from 1 (decision C2). NO_SLAVE when there is none. A drive inside the
 * controller has no Node: it is the first drive on the bus. */
size_t wire_slave(const struct plant *plant, const struct host_servo *servo);

/* Servo types of drives inside the controller: TGZ+Motion's, TGMcontroller's, both with other I/O.
 */
bool wire_is_internal(uint32_t type);

/* Axes of a TGZ, 0 when the slave is none. Both axes are in its maps even when it has one. */
unsigned wire_tgz_axes(const struct plant *plant, size_t slave);

/* Axes that can be servos; 0 for everything that is no drive. */
unsigned wire_axes(const struct bus *bus, const struct plant *plant, size_t slave);

/* Finds the axis (from 0) in the mapping, asks the drive for its resolution. 0, or negative errno
 * with a reason. */
int wire_open(struct servo_wire *wire, struct bus *bus, const struct plant *plant, size_t slave,
              unsigned axis, char why[HOST_WHY]);

/* What the drives must be told before SAFEOP: servo type 9 has the native map on a TGZ, type 99
 * that of CiA 402. Number of entries; at most WIRE_STARTUP a slave. */
#define WIRE_STARTUP 8
size_t wire_startup(const struct host_config *config, struct bus_startup *out, size_t room);

void wire_read(const struct servo_wire *wire, struct wire_answer *answer);
/* Digital outputs of a CiA 402 axis, object 0x60FE, are told over CoE, because they are not mapped:
 * false when they are, or have another way. */
bool wire_tells_outputs(const struct servo_wire *wire);

/* Returns the control word that went out. */
uint32_t wire_write(const struct servo_wire *wire, uint32_t status_word,
                    const struct wire_order *order);
/* From one raw position to another, wrapped as on this wire. */
int64_t wire_moved(const struct servo_wire *wire, uint64_t before, uint64_t now);

#endif
