/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive.h"
#include "bus/registers.h"

#include <stddef.h>

/* Slower than this is standing still. */
static const double standstill = 0.01; /* rev/s */

static const struct drive_mode *const modes[] = {
    &drive_cyclic_position,  &drive_cyclic_velocity,  &drive_cyclic_torque,
    &drive_profile_position, &drive_profile_velocity, &drive_homing,
};

static const struct drive_mode *find_mode(int number)
{
    for (size_t i = 0; i < sizeof modes / sizeof *modes; i++) {
        if (modes[i]->number == number)
            return modes[i];
    }
    return NULL;
}

bool drive_mode_supported(int number)
{
    return find_mode(number) != NULL;
}

double drive_revolutions(uint32_t increments)
{
    return (double)increments / AXIS_INCREMENTS;
}

int64_t drive_actual(const struct drive *drive)
{
    return axis_increments(drive->axis.position);
}

int64_t drive_unwrap(const struct drive *drive, int32_t user, int64_t near)
{
    uint32_t there = (uint32_t)user + (uint32_t)(uint64_t)drive->zero;

    return near + (int32_t)(there - (uint32_t)(uint64_t)near);
}

static int32_t user_position(const struct drive *drive, int64_t increments)
{
    return (int32_t)(uint32_t)(uint64_t)(increments - drive->zero);
}

void drive_demand_actual(struct drive *drive)
{
    drive->demand = drive->axis.position;
    drive->demand_velocity = drive->axis.velocity;
    drive->outside_steps = 0;
}

static double towards(double from, double to, double by)
{
    if (to > from)
        return to - from > by ? from + by : to;
    return from - to > by ? from - by : to;
}

void drive_ramp(struct drive *drive, double velocity, double acceleration)
{
    drive->demand_velocity = towards(drive->demand_velocity, velocity, acceleration * AXIS_STEP_S);
    drive->demand += drive->demand_velocity * AXIS_STEP_S;
    drive->positioned = true;
    axis_follow(&drive->axis, drive->demand, drive->demand_velocity);
}

static bool outside_window(const struct drive *drive)
{
    double error = drive->demand - drive->axis.position;
    double window = drive_revolutions(drive->o.following_window);

    return drive->positioned && drive->o.following_window != UINT32_MAX &&
           (error > window || error < -window);
}

static void watch_following_error(struct drive *drive)
{
    uint32_t allowed = (uint32_t)(drive->o.following_time * (1000000u / AXIS_STEP_NS));

    if (!outside_window(drive)) {
        drive->outside_steps = 0;
        return;
    }
    if (drive->outside_steps++ >= allowed)
        drive_fault(drive, DRIVE_ERROR_FOLLOWING);
}

static double stop_deceleration(const struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    bool slow = drive->machine.leaving ||
                (drive->machine.state == CIA402_QUICK_STOP_ACTIVE &&
                 (o->options.quick_stop == 1 || o->options.quick_stop == 5)) ||
                (drive->machine.state == CIA402_FAULT_REACTION && o->options.fault_reaction == 1);

    return drive_revolutions(slow ? o->deceleration : o->quick_deceleration);
}

static bool stands(const struct drive *drive)
{
    return drive->demand_velocity == 0.0 && drive->axis.velocity < standstill &&
           drive->axis.velocity > -standstill;
}

static void step_once(struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode_display);

    drive->positioned = false;
    if (!cia402_powered(&drive->machine) || drive->machine.state == CIA402_SWITCHED_ON) {
        axis_coast(&drive->axis);
        drive_demand_actual(drive);
        return;
    }
    if (cia402_stopping(&drive->machine)) {
        drive_ramp(drive, 0.0, stop_deceleration(drive));
        if (stands(drive))
            cia402_standstill(&drive->machine, &drive->o.options);
    } else if (mode) {
        mode->step(drive);
    }
    if (drive->machine.state != CIA402_FAULT_REACTION)
        watch_following_error(drive);
}

static uint16_t statusword(const struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode_display);
    unsigned word = cia402_status(&drive->machine);

    if (drive->al_state == AL_OP)
        word |= SW_REMOTE;
    if (drive->machine.state == CIA402_OPERATION_ENABLED && mode)
        word |= mode->status(drive);
    if (outside_window(drive) &&
        (drive->o.mode_display == DRIVE_CSP || drive->o.mode_display == DRIVE_PP))
        word |= SW_MODE_13;
    if (cia402_powered(&drive->machine) &&
        (drive->axis.limited ||
         (drive->axis.switches & (AXIS_SWITCH_NEGATIVE | AXIS_SWITCH_POSITIVE))))
        word |= SW_INTERNAL_LIMIT;
    return (uint16_t)word;
}

/* Velocities beyond the object's 32 bits show as its limit. */
static int32_t rounded(double value)
{
    if (value >= INT32_MAX)
        return INT32_MAX;
    if (value <= INT32_MIN)
        return INT32_MIN;
    return (int32_t)(value < 0 ? value - 0.5 : value + 0.5);
}

void drive_publish(struct drive *drive)
{
    struct drive_objects *o = &drive->o;
    int64_t actual = drive_actual(drive), demand = axis_increments(drive->demand);

    if (!drive->stale)
        return;
    drive->stale = false;
    o->position_actual = user_position(drive, actual);
    o->position_demand = user_position(drive, demand);
    o->velocity_actual = rounded(drive->axis.velocity * AXIS_INCREMENTS);
    o->velocity_demand = rounded(drive->demand_velocity * AXIS_INCREMENTS);
    o->torque_actual = (int16_t)rounded(axis_torque(&drive->axis) * 1000.0);
    o->following_error = drive->positioned ? (int32_t)(demand - actual) : 0;
    o->digital_inputs = drive->axis.switches;
    o->statusword = statusword(drive);
}

static bool fault_gone(const struct drive *drive)
{
    return drive->o.error_code != DRIVE_ERROR_COMMUNICATION || drive->al_state == AL_OP;
}

static void select_mode(struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode);

    /* 0 asks for nothing, numbers of modes we do not have are not followed: 0x6061 tells. */
    if (!mode || drive->o.mode == drive->o.mode_display)
        return;
    drive->o.mode_display = drive->o.mode;
    if (drive->machine.state == CIA402_OPERATION_ENABLED)
        mode->start(drive);
}

void drive_command(struct drive *drive, uint64_t now_ns)
{
    enum cia402_state before = drive->machine.state;
    bool leaving = drive->machine.leaving;
    const struct drive_mode *mode;

    cia402_command(&drive->machine, drive->o.controlword, &drive->o.options, fault_gone(drive));
    if (before == CIA402_FAULT && drive->machine.state != CIA402_FAULT)
        drive->o.error_code = 0;
    select_mode(drive);
    mode = find_mode(drive->o.mode_display);
    /* Stopping from a mode without position demand starts from what the axis does. */
    if (cia402_stopping(&drive->machine) && before == CIA402_OPERATION_ENABLED && !leaving &&
        !drive->positioned)
        drive_demand_actual(drive);
    if (drive->machine.state == CIA402_OPERATION_ENABLED && mode) {
        if (before != CIA402_OPERATION_ENABLED || (leaving && !drive->machine.leaving))
            mode->start(drive);
        if (!drive->machine.leaving)
            mode->command(drive, now_ns);
    }
    drive->stale = true;
}

void drive_fault(struct drive *drive, uint16_t code)
{
    if (!cia402_fail(&drive->machine))
        return;
    drive->o.error_code = code;
    drive_demand_actual(drive);
    if (drive->o.options.fault_reaction == 0)
        cia402_standstill(&drive->machine, &drive->o.options);
}

void drive_al_state(struct drive *drive, unsigned state)
{
    bool lost = drive->al_state == AL_OP && state != AL_OP;

    drive->al_state = state;
    if (lost && (drive->machine.state == CIA402_OPERATION_ENABLED ||
                 drive->machine.state == CIA402_QUICK_STOP_ACTIVE))
        drive_fault(drive, DRIVE_ERROR_COMMUNICATION);
    drive->arrived_ns = drive->interval_ns = 0;
    drive->stale = true;
}

void drive_step(struct drive *drive, uint64_t now_ns)
{
    if (now_ns < drive->next_ns)
        return;
    drive->axis.torque_limit = drive->o.max_torque / 1000.0;
    drive->stale = true;
    for (; drive->next_ns <= now_ns; drive->next_ns += AXIS_STEP_NS)
        step_once(drive);
}

void drive_power_on(struct drive *drive, uint64_t now_ns)
{
    cia402_init(&drive->machine);
    drive->al_state = AL_INIT;
    drive_step(drive, now_ns);
    drive->o.mode_display = drive->o.mode;
    drive->homing = HOMING_IDLE;
    drive->moving = drive->acknowledged = drive->buffered = false;
    drive->arrived_ns = drive->interval_ns = 0;
    drive_demand_actual(drive);
    drive->stale = true;
}

void drive_init(struct drive *drive, uint64_t seed)
{
    axis_init(&drive->axis, seed);
    cia402_init(&drive->machine);
    drive->al_state = AL_INIT;
    drive->next_ns = AXIS_STEP_NS;
    drive->o.mode_display = drive->o.mode;
    drive_demand_actual(drive);
    drive->stale = true;
}
