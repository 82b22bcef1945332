/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The cyclic synchronous modes. The master sends a set point every cycle; the drive walks from one
 * to the next in a straight line while the cycle lasts. */
#include "bus/axis_step.h"
#include "bus/drive.h"

#include <stddef.h>

/* A gap longer than this is not a cycle. */
#define LONGEST_CYCLE_NS 20000000u

static uint64_t configured_period(const struct drive_objects *o)
{
    uint64_t ns = o->period_value;

    for (int e = o->period_exponent; e > -9; e--)
        ns *= 10;
    return ns;
}

/* The cycle is what the drive measures between set points; 0x60C2 until there have been two. */
static void measure(struct drive *drive, uint64_t now_ns)
{
    uint64_t gap = now_ns - drive->arrived_ns;

    if (drive->arrived_ns && gap && gap <= LONGEST_CYCLE_NS)
        drive->interval_ns = gap;
    drive->arrived_ns = now_ns;
}

static uint32_t steps_per_cycle(const struct drive *drive)
{
    uint64_t period = drive->interval_ns ? drive->interval_ns : configured_period(&drive->o);
    uint32_t steps = (uint32_t)(period / AXIS_STEP_NS);

    return steps ? steps : 1;
}

static void hold_position(struct drive *drive)
{
    drive_demand_actual(drive);
    drive->target = drive_actual(drive);
    drive->steps_left = 0;
    drive->demand_velocity = 0.0;
}

static double position_set_point(struct drive *drive)
{
    if (drive->fine) {
        drive->target = drive_increments(drive, drive->fine_set_point);
        return drive->fine_set_point;
    }
    drive->target = drive_unwrap(drive, drive->o.target_position, drive->target);
    return (double)drive->target * drive->per_increment;
}

static bool out_of_reach(const struct drive *drive, double velocity)
{
    double limit = drive->axis.speed_limit;

    return drive->model->error_step && (velocity > limit || velocity < -limit);
}

static void csp_command(struct drive *drive, uint64_t now_ns)
{
    measure(drive, now_ns);
    drive->end = drive_within(drive, position_set_point(drive));
    drive->steps_left = steps_per_cycle(drive);
    drive->demand_velocity = (drive->end - drive->demand) / (drive->steps_left * AXIS_STEP_S);
    if (out_of_reach(drive, drive->demand_velocity))
        drive_fault(drive, drive->model->error_step);
}

static uint32_t csp_run(struct drive *drive, uint32_t steps)
{
    struct axis_line line = { .demand = drive->demand,
                              .velocity = drive->demand_velocity,
                              .end = drive->end,
                              .steps_left = drive->steps_left };
    uint32_t done = axis_follow_line(&drive->axis, &line, drive_window(drive), steps);

    drive->demand = line.demand;
    drive->demand_velocity = line.velocity;
    drive->steps_left = line.steps_left;
    drive->positioned = true;
    return done;
}

static void csp_step(struct drive *drive)
{
    csp_run(drive, 1);
}

static uint16_t csp_status(const struct drive *drive)
{
    int64_t away = drive->target - drive_actual(drive);
    int64_t window = drive->o.position_window;

    return (uint16_t)(SW_MODE_12 | (away <= window && away >= -window ? SW_TARGET_REACHED : 0));
}

static void csv_start(struct drive *drive)
{
    drive_demand_actual(drive);
    drive->target_velocity = drive->axis.velocity;
    drive->steps_left = 0;
}

static void csv_command(struct drive *drive, uint64_t now_ns)
{
    measure(drive, now_ns);
    drive->target_velocity =
        drive->fine ? drive->fine_set_point : drive->o.target_velocity * drive->per_increment;
    drive->steps_left = steps_per_cycle(drive);
}

static void csv_step(struct drive *drive)
{
    if (drive->steps_left) {
        drive->demand_velocity +=
            (drive->target_velocity - drive->demand_velocity) / drive->steps_left;
        drive->steps_left--;
    }
    drive->demand = drive->axis.position;
    axis_turn(&drive->axis, drive_inward(drive, drive->demand_velocity));
}

static void cst_start(struct drive *drive)
{
    drive_demand_actual(drive);
}

static void cst_command(struct drive *drive, uint64_t now_ns)
{
    (void)drive, (void)now_ns;
}

static void cst_step(struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    double torque =
        drive->fine ? drive->fine_set_point : (o->target_torque + o->torque_offset) / 1000.0;

    drive_demand_actual(drive);
    /* At a software limit the axis is held instead of being pushed further out. */
    if (torque != 0.0 && drive_inward(drive, torque) == 0.0)
        axis_turn(&drive->axis, 0.0);
    else
        axis_push(&drive->axis, torque);
}

static uint16_t follows(const struct drive *drive)
{
    (void)drive;
    return SW_MODE_12;
}

static bool interpolating(const struct drive *drive)
{
    return drive->o.controlword & CW_MODE_4;
}

/* As CSP, but set points count only while the master says so. */
static void ip_command(struct drive *drive, uint64_t now_ns)
{
    if (interpolating(drive))
        csp_command(drive, now_ns);
}

static uint16_t ip_status(const struct drive *drive)
{
    unsigned reached = csp_status(drive) & SW_TARGET_REACHED;

    return (uint16_t)(reached | (interpolating(drive) ? SW_MODE_12 : 0));
}

const struct drive_mode drive_cyclic_position = { .number = DRIVE_CSP,
                                                  .start = hold_position,
                                                  .command = csp_command,
                                                  .step = csp_step,
                                                  .status = csp_status,
                                                  .run = csp_run };
const struct drive_mode drive_cyclic_velocity = { .number = DRIVE_CSV,
                                                  .start = csv_start,
                                                  .command = csv_command,
                                                  .step = csv_step,
                                                  .status = follows };
const struct drive_mode drive_cyclic_torque = { .number = DRIVE_CST,
                                                .start = cst_start,
                                                .command = cst_command,
                                                .step = cst_step,
                                                .status = follows };
const struct drive_mode drive_interpolated_position = { .number = DRIVE_IP,
                                                        .start = hold_position,
                                                        .command = ip_command,
                                                        .step = csp_step,
                                                        .status = ip_status,
                                                        .run = csp_run };
const struct drive_mode drive_profile_torque = { .number = DRIVE_TQ,
                                                 .start = cst_start,
                                                 .command = cst_command,
                                                 .step = cst_step,
                                                 .status = follows };
