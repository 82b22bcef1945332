/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive.h"
#include "bus/registers.h"

#include <math.h>
#include <stddef.h>

/* Slower than this is standing still. */
static const double standstill = 0.01; /* rev/s */

enum { MOST_STEPS = 1000 }; /* at once */

static const struct drive_mode *const modes[] = {
    [DRIVE_PP] = &drive_profile_position,      [DRIVE_PV] = &drive_profile_velocity,
    [DRIVE_TQ] = &drive_profile_torque,        [DRIVE_HM] = &drive_homing,
    [DRIVE_IP] = &drive_interpolated_position, [DRIVE_CSP] = &drive_cyclic_position,
    [DRIVE_CSV] = &drive_cyclic_velocity,      [DRIVE_CST] = &drive_cyclic_torque,
};

static const struct drive_mode *find_mode(int number)
{
    return number >= 0 && (size_t)number < sizeof modes / sizeof *modes ? modes[number] : NULL;
}

bool drive_mode_supported(const struct drive *drive, int number)
{
    return find_mode(number) && (drive->model->modes & DRIVE_MODE(number));
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

double drive_within(const struct drive *drive, double position)
{
    return position > drive->high ? drive->high : position < drive->low ? drive->low : position;
}

double drive_inward(const struct drive *drive, double velocity)
{
    bool outward = (velocity > 0 && drive->axis.position >= drive->high) ||
                   (velocity < 0 && drive->axis.position <= drive->low);

    return outward ? 0.0 : velocity;
}

static double limit_at(const struct drive *drive, int32_t user, int32_t off, double never)
{
    return user == off ? never : (double)(drive->zero + user) * drive->per_increment;
}

void drive_limits(struct drive *drive)
{
    const struct drive_objects *o = &drive->o;

    drive->low = limit_at(drive, o->software_limit[0], INT32_MIN, -AXIS_NEVER);
    drive->high = limit_at(drive, o->software_limit[1], INT32_MAX, AXIS_NEVER);
    drive->axis.speed_limit =
        drive_lesser(o->max_motor_speed / 60.0, drive->model->axis->max_speed);
}

void drive_resolution(struct drive *drive, double increments)
{
    drive->increments = increments;
    drive->per_increment = 1.0 / increments;
    drive->zero = 0;
    drive->target = drive_actual(drive);
    drive_limits(drive);
    drive->stale = true;
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

static inline bool outside_window(const struct drive *drive)
{
    double error = drive->demand - drive->axis.position;
    double window = drive_window(drive);

    return drive->positioned && (error > window || error < -window);
}

void drive_watch_following_error(struct drive *drive)
{
    uint32_t allowed = (uint32_t)(drive->o.following_time * (1000000u / AXIS_STEP_NS));

    if (!outside_window(drive)) {
        drive->outside_steps = 0;
        return;
    }
    if (drive->outside_steps++ >= allowed)
        drive_fault(drive, drive->model->error_following);
}

static double stop_deceleration(const struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    bool slow = drive->machine.leaving ||
                (drive->machine.state == CIA402_QUICK_STOP_ACTIVE &&
                 (o->options.quick_stop == 1 || o->options.quick_stop == 5)) ||
                (drive->machine.state == CIA402_FAULT_REACTION && o->options.fault_reaction == 1);

    if (drive->machine.state == CIA402_FAULT_REACTION && drive->reaction > 0.0)
        return drive->reaction;
    return drive_revolutions(drive, slow ? o->deceleration : o->quick_deceleration);
}

static bool stands(const struct drive *drive)
{
    return drive->demand_velocity == 0.0 && drive->axis.velocity < standstill &&
           drive->axis.velocity > -standstill;
}

/* Running into a limit switch is a quick stop. Homing looks for the switches itself. */
static void watch_switches(struct drive *drive)
{
    unsigned s = drive->axis.switches;
    double v = drive->axis.velocity;
    bool into = ((s & AXIS_SWITCH_POSITIVE) && v > standstill) ||
                ((s & AXIS_SWITCH_NEGATIVE) && v < -standstill);

    if (!into || drive->o.limit_reaction != DRIVE_LIMIT_QUICK_STOP || drive->machine.leaving ||
        drive->o.mode_display == DRIVE_HM)
        return;
    if (!cia402_quick_stop(&drive->machine, &drive->o.options))
        return;
    if (!drive->positioned)
        drive_demand_actual(drive);
    drive->limit_stop = true;
    drive->limit_word = drive->o.controlword;
}

bool drive_coasts(const struct drive *drive)
{
    return !cia402_powered(&drive->machine) || drive->machine.state == CIA402_SWITCHED_ON;
}

static void step_once(struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode_display);

    drive->positioned = false;
    if (drive_coasts(drive)) {
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
    } else {
        drive_ramp(drive, 0.0, stop_deceleration(drive));
    }
    watch_switches(drive);
    if (drive->machine.state != CIA402_FAULT_REACTION)
        drive_watch_following_error(drive);
}

static bool limiting(const struct drive *drive)
{
    return drive->axis.limited ||
           (drive->axis.switches & (AXIS_SWITCH_NEGATIVE | AXIS_SWITCH_POSITIVE)) ||
           drive->demand >= drive->high || drive->demand <= drive->low;
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
    if (cia402_powered(&drive->machine) && limiting(drive))
        word |= SW_INTERNAL_LIMIT;
    return (uint16_t)word;
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
    o->velocity_actual = drive_rounded(drive->axis.velocity * drive->increments);
    o->following_error =
        drive->positioned ? (int32_t)(drive_increments(drive, drive->demand) - actual) : 0;
    o->digital_inputs = drive->axis.switches | drive->user_inputs;
    o->statusword = statusword(drive);
}

void drive_publish(struct drive *drive)
{
    struct drive_objects *o = &drive->o;

    drive_publish_cyclic(drive);
    if (!drive->rest_stale)
        return;
    drive->rest_stale = false;
    o->position_demand = user_position(drive, drive_increments(drive, drive->demand));
    o->velocity_demand = drive_rounded(drive->demand_velocity * drive->increments);
    o->torque_actual = (int16_t)drive_rounded(axis_torque(&drive->axis) * 1000.0);
}

static bool fault_gone(const struct drive *drive)
{
    return drive->o.error_code != drive->model->error_communication || drive->al_state == AL_OP;
}

static void select_mode(struct drive *drive)
{
    const struct drive_mode *mode = find_mode(drive->o.mode);

    /* 0 asks for nothing, numbers of modes we do not have are not followed: 0x6061 tells. */
    if (drive->o.mode == drive->o.mode_display || !mode ||
        !(drive->modes & DRIVE_MODE(drive->o.mode)))
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

    drive->stale = true;
    if (drive->limit_stop && drive->o.controlword == drive->limit_word)
        return;
    drive->limit_stop = false;
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
}

/* Modes with a position or speed of their own can ramp down on an error. */
static double emergency_ramp(const struct drive *drive, uint16_t code)
{
    static const uint32_t ramping = DRIVE_MODE(DRIVE_PP) | DRIVE_MODE(DRIVE_PV) |
                                    DRIVE_MODE(DRIVE_HM) | DRIVE_MODE(DRIVE_IP) |
                                    DRIVE_MODE(DRIVE_CSP);
    int bit = drive->model->error_bit ? drive->model->error_bit(code) : -1;
    int mode = drive->o.mode_display;

    if (bit < 0 || !(drive->o.error_mask >> bit & 1) || !mode || !(ramping & DRIVE_MODE(mode)))
        return 0.0;
    return drive->o.emergency_ramp / 60.0;
}

void drive_fault(struct drive *drive, uint16_t code)
{
    if (!cia402_fail(&drive->machine))
        return;
    drive->o.error_code = code;
    drive->failed_ns = drive->next_ns;
    drive->reaction = emergency_ramp(drive, code);
    drive->stale = true;
    drive_demand_actual(drive);
    if (drive->o.options.fault_reaction == 0 && drive->reaction <= 0.0)
        cia402_standstill(&drive->machine, &drive->o.options);
}

void drive_al_state(struct drive *drive, unsigned state)
{
    bool lost = drive->al_state == AL_OP && state != AL_OP;

    drive->al_state = state;
    if (lost && (drive->machine.state == CIA402_OPERATION_ENABLED ||
                 drive->machine.state == CIA402_QUICK_STOP_ACTIVE))
        drive_fault(drive, drive->model->error_communication);
    drive->arrived_ns = drive->interval_ns = 0;
    drive->stale = true;
}

/* As many sub-steps at once as the mode can do; their following errors but the last's are inside
 * the window. Somebody must look at the switches after every one when they stop the axis. */
static uint32_t run(struct drive *drive, uint32_t steps)
{
    const struct drive_mode *mode = find_mode(drive->o.mode_display);

    if (!mode || !mode->run || drive->machine.state != CIA402_OPERATION_ENABLED ||
        drive->machine.leaving || drive->outside_steps ||
        drive->o.limit_reaction != DRIVE_LIMIT_SHOWN) {
        bool coasting = drive_coasts(drive);

        step_once(drive);
        /* Once it stands, nothing moves it. */
        return coasting && drive->axis.velocity == 0.0 ? steps : 1;
    }
    steps = mode->run(drive, steps);
    if (outside_window(drive))
        drive_watch_following_error(drive);
    return steps;
}

void drive_step(struct drive *drive, uint64_t now_ns)
{
    uint32_t steps;

    if (now_ns < drive->next_ns)
        return;
    drive_take_torque_limits(drive);
    drive->stale = true;
    while (drive->next_ns <= now_ns) {
        uint64_t due = (now_ns - drive->next_ns) / AXIS_STEP_NS + 1;

        steps = run(drive, due > MOST_STEPS ? MOST_STEPS : (uint32_t)due);
        drive->next_ns += (uint64_t)steps * AXIS_STEP_NS;
    }
}

/* What the axis says about itself among the objects. */
static void describe(struct drive *drive)
{
    const struct axis_model *model = drive->model->axis;
    struct drive_objects *o = &drive->o;

    o->encoder[0] = model->resolution;
    o->encoder[1] = 1;
    o->rated_torque = (uint32_t)model->rated_torque;
    o->max_torque = (uint16_t)(drive->axis.peak * 1000.0);
    o->torque_high = o->torque_low = o->max_torque;
    o->max_motor_speed = (uint32_t)(model->max_speed * 60.0);
    o->limit_reaction =
        drive->model->stops_at_switches ? DRIVE_LIMIT_QUICK_STOP : DRIVE_LIMIT_SHOWN;
}

static void start(struct drive *drive)
{
    describe(drive);
    cia402_init(&drive->machine);
    drive->al_state = AL_INIT;
    drive->torque_high = drive->torque_low = -1;
    drive->modes = drive->model->modes;
    drive->o.mode_display = drive->o.mode;
    drive_resolution(drive, drive->model->axis->resolution);
    drive_demand_actual(drive);
}

void drive_init(struct drive *drive, const struct drive_model *model, uint64_t seed)
{
    drive->model = model;
    drive->next_ns = AXIS_STEP_NS;
    axis_init(&drive->axis, model->axis, seed);
    start(drive);
}

void drive_power_on(struct drive *drive, uint64_t now_ns)
{
    struct drive old = *drive;

    *drive = (struct drive){ .o = old.o,
                             .model = old.model,
                             .axis = old.axis,
                             .next_ns = old.next_ns,
                             .user_inputs = old.user_inputs };
    start(drive);
    drive_step(drive, now_ns);
}
