/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The SERVO register groups: drives seen and commanded through CiA 402 objects on the bus, and
 * virtual servos, which have none.
 *
 * What the manual leaves open is decided in docs/decisions.md: M1 (Mode), M5 (Offset, Correction,
 * PositionError), M6 (virtual servos), M7 (one increment of the register is one increment on the
 * wire).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

#define CSP                8 /* cyclic synchronous position, 0x6060 */
#define VIRTUAL_RESOLUTION (1u << 20)

enum {
    CONTROL_DISABLE_VOLTAGE = 0x00,
    CONTROL_SHUTDOWN = 0x06,
    CONTROL_SWITCH_ON = 0x07,
    CONTROL_ENABLE = 0x0F,
    CONTROL_FAULT_RESET = 0x80
};
enum { STATUS_FAULT = 0x08, STATUS_ENABLED = 0x27 };

/* The next register group; NULL when there is none left. */
static struct axis *axis_new(struct host *host, size_t slave, char why[HOST_WHY])
{
    const unsigned most = host->config.product->max_servo;
    SERVO *servos = host->memory[SHARED_MEMORY_SERVO];
    if (host->axis_count >= most || host->axis_count == HOST_AXES) {
        snprintf(why, HOST_WHY, "more servos than the %u that %s has", most,
                 host->config.product->title);
        return NULL;
    }
    struct axis *axis = &host->axes[host->axis_count];
    *axis = (struct axis){ .reg = &servos[host->axis_count], .slave = slave };
    axis->reg->Number = (uint32_t)host->axis_count++;
    return axis;
}

static void set_resolution(SERVO *reg, uint32_t resolution)
{
    reg->Resolution = resolution;
    reg->ResolutionBits =
        (resolution & (resolution - 1)) == 0 ? (uint32_t)__builtin_ctz(resolution) : 0;
}

static int axis_open(struct host *host, size_t slave, unsigned number, char why[HOST_WHY])
{
    const uint16_t base = (uint16_t)(0x6000 + number * 0x800);
    struct axis *axis = axis_new(host, slave, why);
    if (axis == NULL)
        return -E2BIG;
    host->taken[slave] = true;
    axis->control = bus_find(host->bus, slave, BUS_OUTPUT, base + 0x40, 0);
    axis->mode = bus_find(host->bus, slave, BUS_OUTPUT, base + 0x60, 0);
    axis->target = bus_find(host->bus, slave, BUS_OUTPUT, base + 0x7A, 0);
    axis->status = bus_find(host->bus, slave, BUS_INPUT, base + 0x41, 0);
    axis->mode_display = bus_find(host->bus, slave, BUS_INPUT, base + 0x61, 0);
    axis->actual = bus_find(host->bus, slave, BUS_INPUT, base + 0x64, 0);
    axis->inputs = bus_find(host->bus, slave, BUS_INPUT, base + 0xFD, 0);
    if (axis->control.bits != 16 || axis->target.bits != 32 || axis->status.bits != 16 ||
        axis->actual.bits != 32) {
        snprintf(
            why, HOST_WHY,
            "slave %zu (%s): 0x%04X, 0x%04X, 0x%04X and 0x%04X must be mapped for position control",
            slave + 1, bus_slave(host->bus, slave)->name, base + 0x40, base + 0x7A, base + 0x41,
            base + 0x64);
        return -ENOTSUP;
    }
    uint32_t resolution = 0, abort = 0;
    size_t size = sizeof resolution;
    if (bus_sdo_read(host->bus, slave, (uint16_t)(base + 0x8F), 1, &resolution, &size, &abort) !=
            0 ||
        resolution == 0) {
        snprintf(why, HOST_WHY,
                 "slave %zu (%s): encoder resolution 0x%04X:1 cannot be read (abort 0x%08X)",
                 slave + 1, bus_slave(host->bus, slave)->name, base + 0x8F, abort);
        return -EPROTO;
    }
    axis->reg->Node = (uint32_t)slave + 1;
    axis->reg->Axis = number + 1;
    axis->reg->Type = SERVO_TYPE_TGZ;
    set_resolution(axis->reg, resolution);
    axis->reg->ECATBusPosition = (uint32_t)slave;
    return 0;
}

static int virtual_open(struct host *host, const struct host_servo *servo, char why[HOST_WHY])
{
    struct axis *axis = axis_new(host, NO_SLAVE, why);
    if (axis == NULL)
        return -E2BIG;
    axis->reg->Node = servo->node;
    axis->reg->Axis = servo->axis;
    axis->reg->Type = SERVO_TYPE_VIRTUAL;
    set_resolution(axis->reg, servo->resolution != 0 ? servo->resolution : VIRTUAL_RESOLUTION);
    return 0;
}

/* A servo of the list: on the bus, unless it is virtual. */
static int listed_open(struct host *host, const struct host_servo *servo, char why[HOST_WHY])
{
    const size_t slave = (size_t)servo->node - 1; /* of node 0: none */
    const unsigned number = servo->axis > 0 ? servo->axis - 1 : 0;
    if (servo->type == SERVO_TYPE_VIRTUAL)
        return virtual_open(host, servo, why);
    if (host->bus == NULL || slave >= bus_slave_count(host->bus) ||
        number >= bus_slave(host->bus, slave)->axes) {
        snprintf(why, HOST_WHY, "servo %zu: node %u of the bus has no axis %u", host->axis_count,
                 servo->node, number + 1);
        return -ENODEV;
    }
    int r = axis_open(host, slave, number, why);
    if (r != 0)
        return r;
    SERVO *reg = host->axes[host->axis_count - 1].reg;
    reg->Type = servo->type;
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    reg->FeedbackType = (int32_t)servo->feedback;
#endif
    return 0;
}

static int servo_open(struct host *host, char why[HOST_WHY])
{
    int r = 0;
    if (host->config.without_bus)
        return 0;
    for (unsigned i = 0; host->config.servos != NULL && i < host->config.servo_count && r == 0; i++)
        r = listed_open(host, &host->config.servos[i], why);
    if (host->config.servos != NULL || host->bus == NULL)
        return r;
    for (size_t slave = 0; slave < bus_slave_count(host->bus); slave++)
        for (unsigned number = 0; number < bus_slave(host->bus, slave)->axes; number++) {
            r = axis_open(host, slave, number, why);
            if (r != 0)
                return r;
        }
    return 0;
}

bool servo_wanted(const struct host *host, const struct axis *axis)
{
    return axis->reg->Mode != host_modes(host)->off &&
           (axis->reg->Control & SERVO_DISABLE_TORQUE_BIT1) == 0 &&
           axis->reg->EtherCATState == ETHERCAT_STATE_OP;
}

bool servo_runs(const struct host *host, const struct axis *axis)
{
    return axis->reg->Status == SERVO_READY_ENABLE && servo_wanted(host, axis);
}

/* Wire positions are 32 bits and wrap; the register counts on. */
static void receive_position(struct axis *axis, double cycle)
{
    SERVO *reg = axis->reg;
    const uint32_t raw = (uint32_t)bus_entry_get(axis->actual);
    double moved = (int32_t)(raw - axis->raw);
    if (!axis->seen) {
        reg->Position = (int32_t)raw;
        moved = 0;
        axis->seen = true;
    }
    axis->raw = raw;
    reg->Position += moved;
    reg->Speed = moved / cycle;
    reg->RefPosition = reg->Position - reg->Offset;
    reg->PositionError = axis->sent - reg->Position;
}

/* It is enabled, and goes where it was sent, one cycle later. */
static void virtual_receive(struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    const double moved = axis->sent - reg->Position;
    reg->EtherCATState = ETHERCAT_STATE_OP;
    reg->Status =
        axis->asked && servo_wanted(host, axis) ? SERVO_READY_ENABLE : SERVO_READY_DISABLE;
    reg->Position = axis->sent;
    reg->Speed = moved / host_cycle_seconds(host);
    reg->RefPosition = reg->Position - reg->Offset;
    reg->PositionError = 0;
}

static void axis_receive(struct host *host, struct axis *axis)
{
    if (axis->slave == NO_SLAVE) {
        virtual_receive(host, axis);
        return;
    }
    const struct bus_slave *slave = bus_slave(host->bus, axis->slave);
    SERVO *reg = axis->reg;
    reg->EtherCATState = slave->al_state & 0x0Fu;
    if (reg->EtherCATState < ETHERCAT_STATE_SAFEOP || !host->exchanged) {
        reg->Status = SERVO_NO_RESPONSE;
        return;
    }
    const uint16_t status = (uint16_t)bus_entry_get(axis->status);
    reg->StatusWord = status;
    reg->DigitalIn = (uint32_t)bus_entry_get(axis->inputs);
    if ((status & STATUS_FAULT) != 0 && (status & 0x4F) != 0x4F) {
        reg->Status = SERVO_FAULT;
        servo_faulty(host, axis);
    } else {
        reg->Status = (status & 0x6F) == STATUS_ENABLED ? SERVO_READY_ENABLE : SERVO_READY_DISABLE;
        servo_faultless(host, axis);
    }
    receive_position(axis, host_cycle_seconds(host));
}

static void servo_receive(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++)
        axis_receive(host, &host->axes[i]);
}

/* The next command on the way from where the drive is to where it shall be. */
static uint16_t control_word(const SERVO *reg, bool enable)
{
    const unsigned status = (unsigned)reg->StatusWord;
    if ((status & 0x4F) == STATUS_FAULT)
        return (reg->Control & SERVO_RESET_FAULT_BIT0) != 0 ? CONTROL_FAULT_RESET
                                                            : CONTROL_DISABLE_VOLTAGE;
    if (!enable)
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

/* A set-point that is no number never reaches the bus: the last good one stays (M5). */
static double set_point(const struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    if (reg->Mode == host_modes(host)->user)
        reg->WritePosition = reg->TransformedPosition;
    const double wanted = reg->WritePosition + reg->Offset + reg->Correction;
    return isfinite(wanted) && fabs(wanted) < 9.0e15 ? wanted : axis->sent;
}

static void axis_send(struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    const double cycle = host_cycle_seconds(host);
    const bool follow = !servo_runs(host, axis);
    const double next =
        follow ? reg->Position : safety_set_point(host, axis, set_point(host, axis));
    const double speed = follow || axis->tracking ? 0 : (next - axis->sent) / cycle;
    reg->WriteSpeed = speed;
    reg->WriteAcc = (speed - axis->sent_speed) / cycle;
    axis->sent = next;
    axis->sent_speed = speed;
    axis->tracking = follow;
    axis->asked = servo_wanted(host, axis);
    if (axis->slave == NO_SLAVE)
        return;

    const uint16_t word = control_word(reg, axis->asked);
    reg->ControlWord = word;
    bus_entry_set(axis->control, word);
    bus_entry_set(axis->mode, CSP);
    bus_entry_set(axis->target, (uint64_t)llround(next));
}

static void servo_send(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++)
        axis_send(host, &host->axes[i]);
}

const struct host_part host_servo = {
    .name = "servo", .open = servo_open, .receive = servo_receive, .send = servo_send
};
