/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The native maps of the TGZ: what their words mean to an axis, and what an axis shows in them. */
#include "bus/tgz.h"
#include "bus/registers.h"

static const double per_revolution = 4294967296.0; /* 2^32 */

static const struct {
    uint32_t d_mode, allowed;
    int8_t native; /* the mode that native set points are for; 0: none */
} d_modes[] = {
    { TGZ_MODE_POSITION, DRIVE_MODE(DRIVE_CSP) | DRIVE_MODE(DRIVE_IP), DRIVE_CSP },
    { TGZ_MODE_GENERATOR_SPEED, DRIVE_MODE(DRIVE_PV), 0 },
    { TGZ_MODE_GENERATOR_POSITION,
      DRIVE_MODE(DRIVE_PP) | DRIVE_MODE(DRIVE_HM) | DRIVE_MODE(DRIVE_PV), 0 },
    { TGZ_MODE_CURRENT, DRIVE_MODE(DRIVE_TQ) | DRIVE_MODE(DRIVE_CST), DRIVE_CST },
    { TGZ_MODE_SPEED, DRIVE_MODE(DRIVE_CSV), DRIVE_CSV },
};

enum { D_MODES = sizeof d_modes / sizeof *d_modes };

uint32_t tgz_allowed_modes(uint32_t d_mode)
{
    for (unsigned i = 0; i < D_MODES; i++) {
        if (d_modes[i].d_mode == d_mode)
            return d_modes[i].allowed;
    }
    return 0;
}

static int8_t native_mode(uint32_t d_mode)
{
    for (unsigned i = 0; i < D_MODES; i++) {
        if (d_modes[i].d_mode == d_mode)
            return d_modes[i].native;
    }
    return 0;
}

bool tgz_is_native(const struct tgz_device *tgz)
{
    return tgz->drive.assign[PDO_RX].pdo[0] == TGZ_RX_NATIVE;
}

static double zero(const struct drive *drive)
{
    return (double)drive->zero * drive->per_increment;
}

static double set_point(const struct drive *drive, const struct tgz_axis *reg)
{
    /* Revolutions and angle are the halves of one 64-bit number. */
    double value = reg->set_revolutions + reg->set_angle / per_revolution;

    switch (reg->d_mode) {
    case TGZ_MODE_POSITION:
        return value + zero(drive);
    case TGZ_MODE_SPEED:
        return value / 60.0;
    default:
        return reg->set_current * drive->axis.peak / TGZ_FULL_SCALE;
    }
}

/* The power stage goes on and off with one bit where CiA 402 takes steps. */
static uint16_t controlword(const struct drive *drive, uint32_t control)
{
    if (control & TGZ_CONTROL_CLEAR)
        return CW_FAULT_RESET;
    if (!(control & TGZ_CONTROL_POWER))
        return 0;
    if (drive->machine.state == CIA402_SWITCH_ON_DISABLED)
        return CW_VOLTAGE | CW_QUICK_STOP;
    return CW_SWITCH_ON | CW_VOLTAGE | CW_QUICK_STOP | CW_ENABLE;
}

void tgz_native_command(struct tgz_device *tgz, unsigned axis, uint64_t now_ns)
{
    struct drive *drive = &tgz->drive.axis[axis];
    const struct tgz_axis *reg = &tgz->reg[axis];
    int8_t mode = native_mode(reg->d_mode);

    drive->fine = mode != 0;
    drive->fine_set_point = set_point(drive, reg);
    if (mode)
        drive->o.mode = mode;
    drive->o.controlword = controlword(drive, reg->control);
    drive_command(drive, now_ns);
    if (drive->machine.state == CIA402_READY_TO_SWITCH_ON) {
        drive->o.controlword = controlword(drive, reg->control);
        drive_command(drive, now_ns);
    }
}

/* --- actual values --- */

/* Inputs 1, 3, 5, 7 or 2, 4, 6, 8 side by side. */
static uint32_t every_other(unsigned inputs, unsigned first)
{
    uint32_t bits = 0;

    for (unsigned i = 0; i < 4; i++)
        bits |= (inputs >> (2 * i + first) & 1u) << i;
    return bits;
}

static uint32_t status(const struct tgz_device *tgz, unsigned axis)
{
    const struct drive *drive = &tgz->drive.axis[axis];
    const struct tgz_axis *reg = &tgz->reg[axis];
    uint32_t word = TGZ_STATUS_INITIALISED | every_other(tgz->inputs, axis) << TGZ_STATUS_INPUTS;

    if (axis >= tgz->drive.kind->axes)
        return word;
    if (cia402_powered(&drive->machine))
        word |= TGZ_STATUS_POWER | TGZ_STATUS_BRAKE;
    if (!(reg->errors >> TGZ_ERROR_STO & 1))
        word |= TGZ_STATUS_HARDWARE;
    if (drive->machine.state == CIA402_OPERATION_ENABLED)
        word |= TGZ_STATUS_SOFTWARE;
    if (!drive->o.error_code)
        word |= TGZ_STATUS_NO_ERROR;
    if (drive->al_state == AL_OP && native_mode(reg->d_mode))
        word |= TGZ_STATUS_FIELDBUS;
    if (drive->reaction > 0.0 && drive->machine.state == CIA402_FAULT_REACTION)
        word |= TGZ_STATUS_RAMP;
    if (drive->reaction > 0.0 && drive->machine.state == CIA402_FAULT)
        word |= TGZ_STATUS_RAMPED;
    return word;
}

static int32_t nearest(double value)
{
    return (int32_t)(value < 0 ? value - 0.5 : value + 0.5);
}

static void publish_axis(struct tgz_device *tgz, unsigned axis)
{
    const struct drive *drive = &tgz->drive.axis[axis];
    struct tgz_axis *reg = &tgz->reg[axis];
    double torque = axis_torque(&drive->axis); /* within the peak */
    uint64_t place = (uint64_t)axis_floor((drive->axis.position - zero(drive)) * per_revolution);

    reg->angle = (uint32_t)place;
    reg->revolutions = (int32_t)(uint32_t)(place >> 32);
    reg->current = (int16_t)nearest(torque / drive->axis.peak * TGZ_FULL_SCALE);
    reg->iq_ma = nearest(torque * TGZ_RATED_CURRENT);
    reg->speed_rpm = nearest(drive->axis.velocity * 60.0);
}

void tgz_publish(struct tgz_device *tgz)
{
    for (unsigned i = 0; i < DRIVE_AXES; i++) {
        struct tgz_axis *reg = &tgz->reg[i];

        if (i < tgz->drive.kind->axes)
            publish_axis(tgz, i);
        reg->status = status(tgz, i);
        reg->status_low = (uint16_t)reg->status;
        reg->shown_analog = reg->analog;
        reg->shown_current = (uint32_t)(int32_t)reg->set_current;
        reg->shown_limit = reg->current_limit;
    }
    tgz->shown_inputs = tgz->inputs;
    tgz->shown_outputs = tgz->outputs;
}
