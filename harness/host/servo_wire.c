/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/servo_wire.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

struct wire_kind {
    const char *name;
    void (*read)(const struct servo_wire *wire, struct wire_answer *answer);
    uint32_t (*write)(const struct servo_wire *wire, uint32_t status_word,
                      const struct wire_order *order);
};

#define TGZ_REVOLUTION 4294967296.0 /* increments on the wire, divided by 0x608F for CiA 402 */
#define CSP            8            /* cyclic synchronous position, 0x6060 */

/* --- CiA 402 --- */

enum {
    CONTROL_DISABLE_VOLTAGE = 0x00,
    CONTROL_SHUTDOWN = 0x06,
    CONTROL_SWITCH_ON = 0x07,
    CONTROL_ENABLE = 0x0F,
    CONTROL_FAULT_RESET = 0x80
};
enum { STATUS_FAULT = 0x08, STATUS_ENABLED = 0x27 };

/* Digital inputs and outputs of a TGZ begin at bit 16; the first and every other one is axis 1's.
 */
enum { SHARED = 16, SHARED_INPUTS = 4, SHARED_OUTPUTS = 3 };

static uint32_t gather(uint32_t value, unsigned axis)
{
    uint32_t bits = 0;
    for (unsigned i = 0; i < SHARED_INPUTS; i++)
        bits |= (value >> (SHARED + 2 * i + axis) & 1) << i;
    return bits;
}

static uint32_t scatter(uint32_t value, unsigned axis, uint32_t bits)
{
    for (unsigned i = 0; i < SHARED_OUTPUTS; i++) {
        const unsigned at = SHARED + 2 * i + axis;
        value = (value & ~(UINT32_C(1) << at)) | (bits >> i & 1) << at;
    }
    return value;
}

static void cia402_read(const struct servo_wire *wire, struct wire_answer *answer)
{
    const uint32_t status = (uint32_t)bus_entry_get(wire->status);
    answer->status_word = status;
    if ((status & STATUS_FAULT) != 0 && (status & 0x4F) != 0x4F)
        answer->state = WIRE_FAULT;
    else
        answer->state = (status & 0x6F) == STATUS_ENABLED ? WIRE_ENABLED : WIRE_READY;
    const uint32_t inputs = (uint32_t)bus_entry_get(wire->inputs);
    answer->inputs = wire->shared ? gather(inputs, wire->axis) : inputs;
}

/* The next command on the way from where the drive is to where it shall be. */
static uint32_t control_word(uint32_t status, const struct wire_order *order)
{
    if ((status & 0x4F) == STATUS_FAULT)
        return order->reset_fault ? CONTROL_FAULT_RESET : CONTROL_DISABLE_VOLTAGE;
    if (!order->enable)
        return CONTROL_SHUTDOWN;
    switch (status & 0x6F) {
    case 0x21:
        return CONTROL_SWITCH_ON;
    case 0x23:
    case 0x27:
        return CONTROL_ENABLE;
    case 0x07:
        return CONTROL_DISABLE_VOLTAGE;
    default:
        return CONTROL_SHUTDOWN;
    }
}

static uint32_t cia402_write(const struct servo_wire *wire, uint32_t status,
                             const struct wire_order *order)
{
    const uint32_t word = control_word(status, order);
    bus_entry_set(wire->control, word);
    bus_entry_set(wire->mode, CSP);
    bus_entry_set(wire->outputs, wire->shared ? scatter((uint32_t)bus_entry_get(wire->outputs),
                                                        wire->axis, order->outputs)
                                              : order->outputs);
    return word;
}

static const struct wire_kind cia402 = { "CiA 402", cia402_read, cia402_write };

static int cia402_open(struct servo_wire *wire, const struct bus *bus, size_t slave, unsigned axis,
                       char why[HOST_WHY])
{
    const uint16_t base = (uint16_t)(0x6000 + axis * 0x800);
    wire->kind = &cia402;
    wire->control = bus_find(bus, slave, BUS_OUTPUT, base + 0x40, 0);
    wire->mode = bus_find(bus, slave, BUS_OUTPUT, base + 0x60, 0);
    wire->target = bus_find(bus, slave, BUS_OUTPUT, base + 0x7A, 0);
    wire->status = bus_find(bus, slave, BUS_INPUT, base + 0x41, 0);
    wire->actual = bus_find(bus, slave, BUS_INPUT, base + 0x64, 0);
    wire->inputs = bus_find(bus, slave, BUS_INPUT, wire->shared ? 0x60FD : base + 0xFD, 0);
    wire->outputs = bus_find(bus, slave, BUS_OUTPUT, wire->shared ? 0x60FE : base + 0xFE, 1);
    if (wire->control.bits == 16 && wire->target.bits == 32 && wire->status.bits == 16 &&
        wire->actual.bits == 32)
        return 0;
    snprintf(
        why, HOST_WHY,
        "slave %zu (%s): 0x%04X, 0x%04X, 0x%04X and 0x%04X must be mapped for position control",
        slave + 1, bus_slave(bus, slave)->name, base + 0x40, base + 0x7A, base + 0x41, base + 0x64);
    return -ENOTSUP;
}

/* --- the native map of the TGZ (its manual: control and status of the fast protocol) --- */

enum { NATIVE_CLEAR = 1 << 0, NATIVE_POWER = 1 << 1, NATIVE_OUTPUTS = 28 };
enum {
    NATIVE_POWERED = 1 << 0,
    NATIVE_SOFTWARE = 1 << 2,
    NATIVE_NO_ERROR = 1 << 4,
    NATIVE_INPUTS = 28
};

static void native_read(const struct servo_wire *wire, struct wire_answer *answer)
{
    const uint32_t status = (uint32_t)bus_entry_get(wire->status);
    const uint32_t running = NATIVE_POWERED | NATIVE_SOFTWARE;
    answer->status_word = status;
    if ((status & NATIVE_NO_ERROR) == 0)
        answer->state = WIRE_FAULT;
    else
        answer->state = (status & running) == running ? WIRE_ENABLED : WIRE_READY;
    answer->inputs = status >> NATIVE_INPUTS;
}

static uint32_t native_write(const struct servo_wire *wire, uint32_t status,
                             const struct wire_order *order)
{
    const bool fault = (status & NATIVE_NO_ERROR) == 0;
    uint32_t word = (order->outputs & 7) << NATIVE_OUTPUTS;
    if (fault)
        word |= order->reset_fault ? NATIVE_CLEAR : 0;
    else if (order->enable)
        word |= NATIVE_POWER;
    bus_entry_set(wire->control, word);
    return word;
}

static const struct wire_kind native = { "native", native_read, native_write };

static unsigned native_register(unsigned number, unsigned axis)
{
    return number + 0x100 * axis;
}

static struct bus_entry native_find(const struct bus *bus, size_t slave,
                                    enum bus_direction direction, unsigned number, unsigned axis)
{
    return bus_find(bus, slave, direction, (uint16_t)native_register(number, axis), 0);
}

/* Angle and revolutions follow one another: together they are one position of 64 bits. */
static struct bus_entry native_position(const struct bus *bus, size_t slave,
                                        enum bus_direction direction, unsigned number,
                                        unsigned axis)
{
    struct bus_entry angle = native_find(bus, slave, direction, number, axis);
    const struct bus_entry turns = native_find(bus, slave, direction, number + 1, axis);
    if (angle.bits != 32 || turns.bits != 32 || turns.byte != angle.byte + 4)
        return (struct bus_entry){ 0 };
    angle.bits = 64;
    return angle;
}

static int native_open(struct servo_wire *wire, const struct bus *bus, size_t slave, unsigned axis,
                       char why[HOST_WHY])
{
    wire->kind = &native;
    wire->control = native_find(bus, slave, BUS_OUTPUT, 0x332D, axis);
    wire->target = native_position(bus, slave, BUS_OUTPUT, 0x332B, axis);
    wire->status = native_find(bus, slave, BUS_INPUT, 0x3325, axis);
    wire->actual = native_position(bus, slave, BUS_INPUT, 0x3310, axis);
    if (wire->control.bits == 32 && wire->target.bits == 64 && wire->status.bits == 32 &&
        wire->actual.bits == 64)
        return 0;
    snprintf(why, HOST_WHY, "slave %zu (%s): the native map of axis %u is not complete", slave + 1,
             bus_slave(bus, slave)->name, axis + 1);
    return -ENOTSUP;
}

/* --- both --- */

unsigned wire_axes(const struct bus *bus, const struct plant *plant, size_t slave)
{
    const unsigned axes = wire_tgz_axes(plant, slave);
    return axes > 0 ? axes : bus_slave(bus, slave)->axes;
}

static int read_u32(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex,
                    uint32_t *value, char why[HOST_WHY])
{
    uint32_t abort = 0;
    size_t size = sizeof *value;
    *value = 0;
    if (bus_sdo_read(bus, slave, index, subindex, value, &size, &abort) == 0 && *value != 0)
        return 0;
    snprintf(why, HOST_WHY,
             "slave %zu (%s): encoder resolution 0x%04X:%u cannot be read (abort 0x%08X)",
             slave + 1, bus_slave(bus, slave)->name, index, subindex, abort);
    return -EPROTO;
}

static int read_resolution(struct servo_wire *wire, struct bus *bus, size_t slave, unsigned axis,
                           bool is_tgz, char why[HOST_WHY])
{
    const uint16_t index = (uint16_t)(0x608F + axis * 0x800);
    uint32_t encoder, turns;
    int r = read_u32(bus, slave, index, 1, &encoder, why);
    if (r == 0 && is_tgz)
        r = read_u32(bus, slave, index, 2, &turns, why);
    if (r != 0)
        return r;
    const double own = is_tgz ? TGZ_REVOLUTION * turns / encoder : encoder;
    if (own < 1 || own > UINT32_MAX) {
        snprintf(why, HOST_WHY, "slave %zu (%s): 0x%04X gives %g increments per revolution",
                 slave + 1, bus_slave(bus, slave)->name, index, own);
        return -ERANGE;
    }
    wire->resolution = (uint32_t)own;
    wire->per_revolution = wire->kind == &native ? TGZ_REVOLUTION : own;
    return 0;
}

static void find_tgz_values(struct servo_wire *wire, const struct bus *bus, size_t slave,
                            unsigned axis)
{
    const uint8_t subindex = (uint8_t)(axis + 1);
    wire->limit = bus_find(bus, slave, BUS_OUTPUT, 0x4011, subindex);
    wire->analog = bus_find(bus, slave, BUS_INPUT, 0x4002, subindex);
    wire->current = wire->kind == &native
                        ? bus_find(bus, slave, BUS_INPUT, 0x4012, subindex)
                        : bus_find(bus, slave, BUS_INPUT, (uint16_t)(0x6077 + axis * 0x800), 0);
}

int wire_open(struct servo_wire *wire, struct bus *bus, const struct plant *plant, size_t slave,
              unsigned axis, char why[HOST_WHY])
{
    const bool is_tgz = wire_tgz_axes(plant, slave) > 0;
    memset(wire, 0, sizeof *wire);
    wire->axis = axis;
    wire->shared = is_tgz;
    int r = is_tgz && bus_slave(bus, slave)->axes == 0 ? native_open(wire, bus, slave, axis, why)
                                                       : cia402_open(wire, bus, slave, axis, why);
    if (r == 0)
        r = read_resolution(wire, bus, slave, axis, is_tgz, why);
    if (r == 0 && is_tgz)
        find_tgz_values(wire, bus, slave, axis);
    return r;
}

bool wire_tells_outputs(const struct servo_wire *wire)
{
    return wire->kind == &cia402 && wire->outputs.bits == 0 && !wire->shared;
}

void wire_read(const struct servo_wire *wire, struct wire_answer *answer)
{
    wire->kind->read(wire, answer);
    answer->position = bus_entry_get(wire->actual);
    answer->analog = (uint32_t)bus_entry_get(wire->analog);
    answer->current = (int32_t)bus_entry_sign(wire->current);
}

uint32_t wire_write(const struct servo_wire *wire, uint32_t status_word,
                    const struct wire_order *order)
{
    bus_entry_set(wire->target, (uint64_t)order->position);
    bus_entry_set(wire->limit, order->limit);
    return wire->kind->write(wire, status_word, order);
}

int64_t wire_moved(const struct servo_wire *wire, uint64_t before, uint64_t now)
{
    const unsigned unused = 64u - wire->actual.bits;
    return (int64_t)((now - before) << unused) >> unused;
}
