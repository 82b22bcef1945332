/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SERVO.Command: commands 1 to 7, which set the registers of SERVO.Pg and SERVO.Gear and wait for
 * what follows (docs/decisions.md, M2).
 */
#include "host/host_parts.h"

#include <math.h>

#define REFUSED (-1)

/* A parameter of 0 leaves the register as it is. */
static void take(double *reg, double parameter)
{
    if (parameter != 0)
        *reg = parameter;
}

/* Registers that are not signed in generation 5: a negative value is out of their range there, too.
 */
static GENERATION(int32_t, uint32_t) whole(double value)
{
    const int32_t number = value >= INT32_MAX   ? INT32_MAX
                           : value <= INT32_MIN ? INT32_MIN
                                                : (int32_t)value;
    return (GENERATION(int32_t, uint32_t))number;
}

static bool use_profile(struct host *host, SERVO *reg, uint32_t mode)
{
    if (!(reg->Pg.Acc > 0))
        return false;
    reg->Pg.Mode = mode;
    reg->Mode = host_modes(host)->pg;
    return true;
}

static bool begin_speed(struct host *host, struct axis *axis, const double *par)
{
    PG *pg = &axis->reg->Pg;
    pg->Speed = par[0];
    take(&pg->Acc, par[1]);
    take(&pg->Dec, par[2]);
    return use_profile(host, axis->reg, PG_MODE_SPEED);
}

static bool begin_position(struct host *host, struct axis *axis, const double *par)
{
    PG *pg = &axis->reg->Pg;
    pg->DPos = par[0];
    take(&pg->PosSpeed, par[1]);
    take(&pg->Acc, par[2]);
    take(&pg->Dec, par[3]);
    return pg->PosSpeed != 0 && use_profile(host, axis->reg, PG_MODE_POSITION);
}

static bool begin_relative(struct host *host, struct axis *axis, const double *par)
{
    const bool generated = (axis->motion.sources & MOTION_PG) != 0;
    const double here = generated ? axis->reg->Pg.APos : motion_start(host, axis);
    const double absolute[] = { here + par[0], par[1], par[2], par[3] };
    return begin_position(host, axis, absolute);
}

static bool begin_reference(struct host *host, struct axis *axis, const double *par)
{
    (void)host;
    motion_refer(axis, par[0]);
    return true;
}

/* An axis that is not enabled stands. */
static bool begin_stop(struct host *host, struct axis *axis, const double *par)
{
    PG *pg = &axis->reg->Pg;
    take(&pg->Dec, par[0]);
    if (!servo_runs(host, axis))
        return true;
    if (!(pg->Acc > 0))
        pg->Acc = pg->Dec;
    pg->Speed = 0;
    return use_profile(host, axis->reg, PG_MODE_SPEED);
}

static bool begin_gear(struct host *host, struct axis *axis, const double *par)
{
    GEAR *gear = &axis->reg->Gear;
    const GENERATION(int32_t, uint32_t) mode = whole(par[0]);
    if (mode != GEAR_MODE_LINEAR && mode != GEAR_MODE_CAM)
        return false;
    gear->SourceNumber = whole(par[1]);
    gear->SourcePosition = whole(par[2]);
    gear->In = (int32_t)whole(par[3]);
    gear->Out = (int32_t)whole(par[4]);
    gear->IncIn = par[5];
    gear->Offset = par[6];
    if (mode == GEAR_MODE_CAM) {
        gear->CamLine = whole(par[7]);
        gear->CamLen = whole(par[8]);
        gear->CamType = whole(par[9]);
        gear->CamTab = whole(par[10]);
        gear->CamScale = par[11];
        gear->CamIncPosition = par[12];
        gear->Shift = par[13];
        gear->IncShift = par[14];
    }
    gear->Mode = mode;
    axis->reg->Mode = host_modes(host)->gear;
    return true;
}

static bool begin_gear_cancel(struct host *host, struct axis *axis, const double *par)
{
    GEAR *gear = &axis->reg->Gear;
    (void)host;
    take(&gear->IncIn, par[0]);
    gear->In = 0;
    if (gear->Mode != GEAR_MODE_LINEAR || (axis->motion.sources & MOTION_GEAR) == 0)
        gear->Mode = GEAR_MODE_OFF;
    return true;
}

static bool done_profile(struct axis *axis)
{
    return (axis->motion.sources & MOTION_PG) != 0 && axis->motion.profile.ready;
}

static bool done_at_once(struct axis *axis)
{
    (void)axis;
    return true;
}

static bool done_stop(struct axis *axis)
{
    return axis->motion.sources == 0 || done_profile(axis);
}

static bool done_gear(struct axis *axis)
{
    const GEAR *gear = &axis->reg->Gear;
    if ((axis->motion.sources & MOTION_GEAR) == 0)
        return false;
    return gear->Mode == GEAR_MODE_LINEAR ? axis->motion.ratio_in == gear->In
                                          : gear->ActualShift == gear->Shift;
}

static bool done_gear_cancel(struct axis *axis)
{
    GEAR *gear = &axis->reg->Gear;
    if (gear->Mode == GEAR_MODE_LINEAR && axis->motion.ratio_in != 0)
        return false;
    gear->Mode = GEAR_MODE_OFF;
    return true;
}

static const struct command {
    unsigned parameters;
    bool (*begin)(struct host *host, struct axis *axis, const double *par); /* false: refused */
    bool (*done)(struct axis *axis);
} commands[] = {
    [COMMAND_CONTROL_PG_SPEED] = { 3, begin_speed, done_profile },
    [COMMAND_CONTROL_PG_ABSOLUTE] = { 4, begin_position, done_profile },
    [COMMAND_CONTROL_PG_RELATIVE] = { 4, begin_relative, done_profile },
    [COMMAND_CONTROL_SET_REFERENCE] = { 1, begin_reference, done_at_once },
    [COMMAND_CONTROL_STOP] = { 1, begin_stop, done_stop },
    [COMMAND_CONTROL_GEAR] = { 15, begin_gear, done_gear },
    [COMMAND_CONTROL_GEAR_CANCEL] = { 1, begin_gear_cancel, done_gear_cancel },
};

static bool begin(struct host *host, struct axis *axis, int32_t number)
{
    const double *par = axis->reg->Command.Par;
    if (number >= (int32_t)(sizeof commands / sizeof *commands))
        return false;
    for (unsigned i = 0; i < commands[number].parameters; i++)
        if (!isfinite(par[i]))
            return false;
    return commands[number].begin(host, axis, par);
}

static void finish(struct axis *axis, int32_t result)
{
    axis->reg->Command.Control = result;
    axis->motion.command = COMMAND_CONTROL_DONE;
}

void command_before(struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    const int32_t number = axis->reg->Command.Control;
    if (number <= COMMAND_CONTROL_DONE) {
        m->command = COMMAND_CONTROL_DONE;
        return;
    }
    if (number == m->command)
        return;
    m->command = number;
    m->command_started = false;
    if (!begin(host, axis, number))
        finish(axis, REFUSED);
}

void command_after(const struct host *host, struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    const bool runs = servo_runs(host, axis);
    if (m->command == COMMAND_CONTROL_DONE)
        return;
    if (m->command_started && !runs)
        finish(axis, REFUSED);
    else if (commands[m->command].done(axis))
        finish(axis, COMMAND_CONTROL_DONE);
    m->command_started = runs;
}
