/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive.h"
#include "bus/registers.h"

#include <math.h>
#include <stddef.h>

/* Slower than this is standing still. */
static const double standstill = 0.01; /* rev/s */

enum { MOST_STEPS = 1000 }; /* at once */

static const struct drive_mode *const modes[] = {
    [DRIVE_PP] = &drive_profile_position, [DRIVE_PV] = &drive_profile_velocity,
    [DRIVE_HM] = &drive_homing,           [DRIVE_CSP] = &drive_cyclic_position,
    [DRIVE_CSV] = &drive_cyclic_velocity, [DRIVE_CST] = &drive_cyclic_torque,
};

static const struct drive_mode *find_mode(int number)
{
    return number >= 0 && (size_t)number < sizeof modes / sizeof *modes ? modes[number] : NULL;
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

double drive_window(const struct drive *drive)
{
    return drive->o.following_window == UINT32_MAX ? INFINITY
                                                   : drive_revolutions(drive->o.following_window);
}

static bool outside_window(const struct drive *drive)
{
    double error = drive->demand - drive->axis.position;
    double window = drive_window(drive);

    return drive->positioned && (error > window || error < -window);
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
    double limited = value < INT32_MAX ? value : INT32_MAX;

    limited = limited > INT32_MIN ? limited : INT32_MIN;
    return (int32_t)(limited + copysign(0.5, limited));
}

void drive_publish_cyclic(struct drive *drive)
{
    struct drive_objects *o = &drive->o;
    int64_t actual;

    if (!drive->stale)
        return;
    drive->stale = false;
    drive->rest_stale = true;
    actual = drive_actual(drive);
    o->position_actual = user_position(drive, actual);
    o->velocity_actual = rounded(drive->axis.velocity * AXIS_INCREMENTS);
    o->following_error = drive->positioned ? (int32_t)(axis_increments(drive->demand) - actual) : 0;
    o->digital_inputs = drive->axis.switches;
    o->statusword = statusword(drive);
}

void drive_publish(struct drive *drive)
{
    struct drive_objects *o = &drive->o;

    drive_publish_cyclic(drive);
    if (!drive->rest_stale)
        return;
    drive->rest_stale = false;
    o->position_demand = user_position(drive, axis_increments(drive->demand));
    o->velocity_demand = rounded(drive->demand_velocity * AXIS_INCREMENTS);
    o->torque_actual = (int16_t)rounded(axis_torque(&drive->axis) * 1000.0);
}

static bool fault_gone(const struct drive *drive)
{
    return drive->o.error_code != DRIVE_ERROR_COMMUNICATION || drive->al_state == AL_OP;
}

static void select_mode(struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode);

    /* 0 asks for nothing, numbers of modes we do not have are not followed: 0x6061 tells. */
    if (drive->o.mode == drive->o.mode_display || !mode)
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

/* As many sub-steps at once as the mode can do; their following errors but the last's are inside
 * the window. */
static uint32_t run(struct drive *drive, uint32_t steps)
{
    const struct drive_mode *mode = find_mode(drive->o.mode_display);

    if (!mode || !mode->run || drive->machine.state != CIA402_OPERATION_ENABLED ||
        drive->machine.leaving || drive->outside_steps) {
        step_once(drive);
        return 1;
    }
    steps = mode->run(drive, steps);
    watch_following_error(drive);
    return steps;
}

void drive_step(struct drive *drive, uint64_t now_ns)
{
    uint32_t steps;

    if (now_ns < drive->next_ns)
        return;
    drive->axis.torque_limit = drive->o.max_torque / 1000.0;
    drive->stale = true;
    while (drive->next_ns <= now_ns) {
        uint64_t due = (now_ns - drive->next_ns) / AXIS_STEP_NS + 1;

        steps = run(drive, due > MOST_STEPS ? MOST_STEPS : (uint32_t)due);
        drive->next_ns += (uint64_t)steps * AXIS_STEP_NS;
    }
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
