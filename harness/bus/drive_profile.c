/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Profile position and profile velocity: the drive makes its own trapezoids. */
#include "bus/drive.h"

#include <math.h>

enum { CW_AT_ONCE = 1 << 5, CW_RELATIVE = 1 << 6 };

/* The fastest that still stops in `distance`, counting in whole sub-steps. */
static double braking_speed(double distance, double deceleration)
{
    double half = deceleration * AXIS_STEP_S / 2;

    return sqrt(half * half + 2 * deceleration * distance) - half;
}

bool drive_travel(struct drive *drive, double position, double speed, double acceleration,
                  double deceleration)
{
    double distance = position - drive->demand;
    double ahead = distance < 0 ? -distance : distance;
    double limit = braking_speed(ahead, deceleration);
    double wanted = speed < limit ? speed : limit;
    double now = drive->demand_velocity < 0 ? -drive->demand_velocity : drive->demand_velocity;
    double rate = wanted < now ? deceleration : acceleration;

    if (ahead * drive->increments <= 1.0 && now <= 2 * deceleration * AXIS_STEP_S) {
        drive->demand = position;
        drive->demand_velocity = 0.0;
        drive_ramp(drive, 0.0, deceleration);
        return true;
    }
    drive_ramp(drive, distance < 0 ? -wanted : wanted, rate);
    return false;
}

static void pp_start(struct drive *drive)
{
    drive_demand_actual(drive);
    drive->target = drive_actual(drive);
    drive->moving = drive->buffered = false;
    /* A new-set-point bit that is already up is not an edge. */
    drive->acknowledged = drive->o.controlword & CW_MODE_4;
}

static int64_t pp_set_point(const struct drive *drive)
{
    if (drive->o.controlword & CW_RELATIVE)
        return drive->target + drive->o.target_position;
    return drive_unwrap(drive, drive->o.target_position, drive_actual(drive));
}

static void pp_command(struct drive *drive, uint64_t now_ns)
{
    bool asked = drive->o.controlword & CW_MODE_4;

    (void)now_ns;
    if (!asked) {
        /* The acknowledge falls when another set point could be taken. */
        if (!drive->buffered)
            drive->acknowledged = false;
        return;
    }
    if (drive->acknowledged)
        return;
    drive->acknowledged = true;
    if (drive->moving && !(drive->o.controlword & CW_AT_ONCE)) {
        drive->next_target = pp_set_point(drive);
        drive->buffered = true;
        return;
    }
    drive->target = pp_set_point(drive);
    drive->buffered = false;
    drive->moving = true;
}

static uint32_t profile_velocity(const struct drive_objects *o)
{
    return o->profile_velocity < o->max_profile_velocity ? o->profile_velocity
                                                         : o->max_profile_velocity;
}

static void pp_step(struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    double deceleration = drive_revolutions(drive, o->deceleration);
    double target = drive_within(drive, (double)drive->target * drive->per_increment);

    if (!drive->moving || (o->controlword & CW_HALT)) {
        drive_ramp(drive, 0.0, deceleration);
        return;
    }
    if (!drive_travel(drive, target, drive_revolutions(drive, profile_velocity(o)),
                      drive_revolutions(drive, o->acceleration), deceleration))
        return;
    drive->moving = drive->buffered;
    if (drive->buffered) {
        drive->target = drive->next_target;
        drive->buffered = false;
    }
}

static uint16_t pp_status(const struct drive *drive)
{
    int64_t away = drive->target - drive_actual(drive);
    int64_t window = drive->o.position_window;
    unsigned word = drive->acknowledged ? SW_MODE_12 : 0;

    if (drive->o.controlword & CW_HALT) {
        if (drive->demand_velocity == 0.0)
            word |= SW_TARGET_REACHED;
    } else if (!drive->moving && away <= window && away >= -window) {
        word |= SW_TARGET_REACHED;
    }
    return (uint16_t)word;
}

static void pv_start(struct drive *drive)
{
    drive_demand_actual(drive);
}

static void pv_command(struct drive *drive, uint64_t now_ns)
{
    (void)drive, (void)now_ns;
}

static double pv_target(const struct drive *drive)
{
    double limit = drive_revolutions(drive, drive->o.max_profile_velocity);
    double target = drive->o.target_velocity * drive->per_increment;

    if (drive->o.controlword & CW_HALT)
        return 0.0;
    return drive_inward(drive, target > limit ? limit : target < -limit ? -limit : target);
}

static void pv_step(struct drive *drive)
{
    double target = pv_target(drive);
    double now = drive->demand_velocity;
    bool faster = target > now ? now >= 0 : now <= 0;

    drive_ramp(drive, target,
               drive_revolutions(drive, faster ? drive->o.acceleration : drive->o.deceleration));
}

static uint16_t pv_status(const struct drive *drive)
{
    static const double zero = 0.02; /* rev/s */
    double v = drive->axis.velocity;
    unsigned word = v < zero && v > -zero ? SW_MODE_12 : 0;

    if (drive->demand_velocity == pv_target(drive))
        word |= SW_TARGET_REACHED;
    return (uint16_t)word;
}

const struct drive_mode drive_profile_position = { .number = DRIVE_PP,
                                                   .start = pp_start,
                                                   .command = pp_command,
                                                   .step = pp_step,
                                                   .status = pp_status };
const struct drive_mode drive_profile_velocity = { .number = DRIVE_PV,
                                                   .start = pv_start,
                                                   .command = pv_command,
                                                   .step = pv_step,
                                                   .status = pv_status };
