/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The SERVO register groups: drives seen and commanded through the bus (servo_wire.h), and
 * virtual servos, which have none.
 *
 * What the manual leaves open is decided in docs/decisions.md: M1 (Mode), M5 (Offset, Correction,
 * PositionError), M6 (virtual servos), M7 (increments).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>

#define VIRTUAL_RESOLUTION  (1u << 20)
#define EXTERNAL_RESOLUTION 1024 /* of the encoder that a TGMcontroller has */

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

/* resolution: inc/rev that the configuration wants, 0: the drive's own. */
static int axis_open(struct host *host, size_t slave, unsigned number, uint32_t resolution,
                     char why[HOST_WHY])
{
    struct axis *axis = axis_new(host, slave, why);
    if (axis == NULL)
        return -E2BIG;
    host->taken[slave] = true;
    int r = wire_open(&axis->wire, host->bus, host->config.plant, slave, number, why);
    if (r != 0)
        return r;
    if (resolution == 0)
        resolution = axis->wire.resolution;
    axis->scale = axis->wire.per_revolution / resolution;
    axis->reg->Node = (uint32_t)slave + 1;
    axis->reg->Axis = number + 1;
    axis->reg->Type = SERVO_TYPE_TGZ;
    set_resolution(axis->reg, resolution);
    axis->reg->ECATBusPosition = (uint32_t)slave;
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    axis->reg->Revision = (int32_t)bus_slave(host->bus, slave)->revision;
#endif
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
    const size_t slave = wire_slave(host->config.plant, servo);
    const unsigned number = servo->axis > 0 ? servo->axis - 1 : 0;
    if (servo->type == SERVO_TYPE_VIRTUAL)
        return virtual_open(host, servo, why);
    if (host->bus == NULL || slave >= bus_slave_count(host->bus) ||
        number >= wire_axes(host->bus, host->config.plant, slave)) {
        snprintf(why, HOST_WHY, "servo %zu: node %u of the bus has no axis %u", host->axis_count,
                 servo->node, number + 1);
        return -ENODEV;
    }
    int r = axis_open(host, slave, number, servo->resolution, why);
    if (r != 0)
        return r;
    SERVO *reg = host->axes[host->axis_count - 1].reg;
    reg->Type = servo->type;
    reg->Node = servo->node;
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    reg->FeedbackType = (int32_t)servo->feedback;
    reg->ExtEncoderResolution = servo->type == SERVO_TYPE_TGM_CONTROLLER ? EXTERNAL_RESOLUTION : 0;
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
        for (unsigned number = 0; number < wire_axes(host->bus, host->config.plant, slave);
             number++) {
            r = axis_open(host, slave, number, 0, why);
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

/* Wire positions wrap; the register counts on. */
static void receive_position(struct axis *axis, uint64_t raw, double cycle)
{
    SERVO *reg = axis->reg;
    double moved = (double)wire_moved(&axis->wire, axis->raw, raw);
    if (!axis->seen) {
        axis->position = (double)wire_moved(&axis->wire, 0, raw);
        moved = 0;
        axis->seen = true;
    }
    axis->raw = raw;
    axis->position += moved;
    axis->actual = reg->Position = axis->position / axis->scale;
    reg->Speed = moved / axis->scale / cycle;
    reg->RefPosition = axis->actual - reg->Offset;
    reg->PositionError = axis->sent - axis->actual;
}

/* It is enabled, and goes where it was sent, one cycle later. */
static void virtual_receive(struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    const double moved = axis->sent - axis->actual;
    reg->EtherCATState = ETHERCAT_STATE_OP;
    reg->Status =
        axis->asked && servo_wanted(host, axis) ? SERVO_READY_ENABLE : SERVO_READY_DISABLE;
    axis->actual = reg->Position = axis->sent;
    reg->Speed = moved / host_cycle_seconds(host);
    reg->RefPosition = axis->actual - reg->Offset;
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
        reg->Position = axis->actual;
        return;
    }
    static const int32_t status_of[] = { [WIRE_READY] = SERVO_READY_DISABLE,
                                         [WIRE_ENABLED] = SERVO_READY_ENABLE,
                                         [WIRE_FAULT] = SERVO_FAULT };
    struct wire_answer answer;
    wire_read(&axis->wire, &answer);
    reg->StatusWord = (servo_word)answer.status_word;
    reg->DigitalIn = answer.inputs;
    reg->AnalogIn = answer.analog;
    reg->Current = answer.current;
    reg->Status = status_of[answer.state];
    if (answer.state == WIRE_FAULT)
        servo_faulty(host, axis);
    else
        servo_faultless(host, axis);
    receive_position(axis, answer.position, host_cycle_seconds(host));
}

static void servo_receive(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++)
        axis_receive(host, &host->axes[i]);
}

/* A set-point that is no number never reaches the bus: the last good one stays (M5). */
static double set_point(const struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    if (reg->Mode == host_modes(host)->user)
        reg->WritePosition = reg->TransformedPosition;
    const double wanted = reg->WritePosition + reg->Offset + reg->Correction;
    return isfinite(wanted) && fabs(wanted * axis->scale) < 9.0e15 ? wanted : axis->sent;
}

/* 16 bits on the wire, of which the drives have 15. */
static uint16_t current_limit(double wanted)
{
    return wanted > 0 ? (uint16_t)(wanted < 32767 ? wanted : 32767) : 0;
}

static void axis_send(struct host *host, struct axis *axis)
{
    SERVO *reg = axis->reg;
    const double cycle = host_cycle_seconds(host);
    const bool follow = !servo_runs(host, axis);
    const double next = follow ? axis->actual : safety_set_point(host, axis, set_point(host, axis));
    const double speed = follow || axis->tracking ? 0 : (next - axis->sent) / cycle;
    reg->WriteSpeed = speed;
    reg->WriteAcc = (speed - axis->sent_speed) / cycle;
    axis->sent = next;
    axis->sent_speed = speed;
    axis->tracking = follow;
    axis->asked = servo_wanted(host, axis);
    if (axis->slave == NO_SLAVE)
        return;

    const struct wire_order order = {
        .enable = axis->asked,
        .reset_fault = (reg->Control & SERVO_RESET_FAULT_BIT0) != 0,
        .position = llround(next * axis->scale),
        .outputs = reg->DigitalOut,
        .limit = current_limit(reg->LimitCurrent),
    };
    reg->ControlWord = (servo_word)wire_write(&axis->wire, (uint32_t)reg->StatusWord, &order);
}

static void servo_send(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++)
        axis_send(host, &host->axes[i]);
}

const struct host_part host_servo = {
    .name = "servo", .open = servo_open, .receive = servo_receive, .send = servo_send
};
