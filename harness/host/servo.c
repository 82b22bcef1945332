/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The SERVO register groups: drives seen and commanded through CiA 402 objects on the bus.
 *
 * What the manual leaves open is decided in docs/decisions.md: M1 (Mode), M5 (Offset, Correction,
 * PositionError), M7 (one increment of the register is one increment on the wire).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

#define CSP 8 /* cyclic synchronous position, 0x6060 */

enum {
    CONTROL_DISABLE_VOLTAGE = 0x00,
    CONTROL_SHUTDOWN = 0x06,
    CONTROL_SWITCH_ON = 0x07,
    CONTROL_ENABLE = 0x0F,
    CONTROL_FAULT_RESET = 0x80
};
enum { STATUS_FAULT = 0x08, STATUS_ENABLED = 0x27 };

static int axis_open(struct host *host, size_t slave, unsigned number, char why[HOST_WHY])
{
    if (host->axis_count == HOST_AXES) {
        snprintf(why, HOST_WHY, "more than %d servo axes on the bus", HOST_AXES);
        return -E2BIG;
    }
    const uint16_t base = (uint16_t)(0x6000 + number * 0x800);
    SERVO *servos = host->memory[SHARED_MEMORY_SERVO];
    struct axis *axis = &host->axes[host->axis_count];
    *axis = (struct axis){ .reg = &servos[host->axis_count], .slave = slave };
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
    axis->reg->Number = (uint32_t)host->axis_count;
    axis->reg->Node = (uint32_t)slave + 1;
    axis->reg->Axis = number + 1;
    axis->reg->Type = SERVO_TYPE_TGZ;
    axis->reg->Resolution = resolution;
    axis->reg->ResolutionBits =
        (resolution & (resolution - 1)) == 0 ? (uint32_t)__builtin_ctz(resolution) : 0;
    axis->reg->ECATBusPosition = (uint32_t)slave;
    host->axis_count++;
    return 0;
}

static int servo_open(struct host *host, char why[HOST_WHY])
{
    for (size_t slave = 0; host->bus != NULL && slave < bus_slave_count(host->bus); slave++)
        for (unsigned number = 0; number < bus_slave(host->bus, slave)->axes; number++) {
            int r = axis_open(host, slave, number, why);
            if (r != 0)
                return r;
        }
    return 0;
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

static void axis_receive(struct host *host, struct axis *axis)
{
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
        reg->Error = UINT32_C(0x80000000); /* "other": the drive's own code is not mapped (M13) */
    } else {
        reg->Status = (status & 0x6F) == STATUS_ENABLED ? SERVO_READY_ENABLE : SERVO_READY_DISABLE;
        reg->Error = 0;
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
static double set_point(struct axis *axis)
{
    SERVO *reg = axis->reg;
    if (reg->Mode == SERVO_MODE_USER)
        reg->WritePosition = reg->TransformedPosition;
    const double wanted = reg->WritePosition + reg->Offset + reg->Correction;
    return isfinite(wanted) && fabs(wanted) < 9.0e15 ? wanted : axis->sent;
}

static void axis_send(struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    const double cycle = host_cycle_seconds(host);
    const bool enable = reg->Mode != SERVO_MODE_OFF &&
                        (reg->Control & SERVO_DISABLE_TORQUE_BIT1) == 0 &&
                        reg->EtherCATState == ETHERCAT_STATE_OP;
    const bool follow = !enable || reg->Status != SERVO_READY_ENABLE;
    const double next = follow ? reg->Position : set_point(axis);
    const double speed = follow || axis->tracking ? 0 : (next - axis->sent) / cycle;
    reg->WriteSpeed = speed;
    reg->WriteAcc = (speed - axis->sent_speed) / cycle;
    axis->sent = next;
    axis->sent_speed = speed;
    axis->tracking = follow;

    const uint16_t word = control_word(reg, enable);
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
