/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/axis.h"

/* Loop gains in 1/s. The feed-forward is left a little short of one, as tuned drives are: at
 * constant speed the axis is about 0.3 ms of travel behind and never ahead. */
static const double position_gain = 120.0;
static const double velocity_gain = 900.0;
static const double feed_forward = 0.95;

static const double viscous = 0.6;        /* 1/s */
static const double coulomb = 0.3;        /* rev/s^2 */
static const double winding_brake = 20.0; /* 1/s */

static double clamp(double value, double limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

void axis_init(struct axis *axis, uint64_t seed)
{
    *axis = (struct axis){ 0 };
    /* 2^-20 rev is one increment. */
    axis->position = 0.5 + (double)(seed % 1048576u) / AXIS_INCREMENTS;
    axis->torque_limit = AXIS_PEAK_TORQUE;
}

static inline void read_switches(struct axis *axis)
{
    unsigned s = 0;

    if (axis->position <= AXIS_LIMIT_NEGATIVE)
        s |= AXIS_SWITCH_NEGATIVE;
    if (axis->position >= AXIS_LIMIT_POSITIVE)
        s |= AXIS_SWITCH_POSITIVE;
    if (axis->position <= AXIS_HOME)
        s |= AXIS_SWITCH_HOME;
    axis->switches = (uint8_t)s;
}

static inline void move(struct axis *axis, double motor, double damping, double friction)
{
    double free = axis->velocity + (motor - damping * axis->velocity) * AXIS_STEP_S;
    double drag = friction * AXIS_STEP_S;

    /* Dry friction can stop the axis within a step but never turn it round. */
    axis->velocity = free > drag ? free - drag : free < -drag ? free + drag : 0.0;
    axis->position += axis->velocity * AXIS_STEP_S;
    if (axis->position < AXIS_STOP_NEGATIVE) {
        axis->position = AXIS_STOP_NEGATIVE;
        axis->velocity = 0.0;
    } else if (axis->position > AXIS_STOP_POSITIVE) {
        axis->position = AXIS_STOP_POSITIVE;
        axis->velocity = 0.0;
    }
    read_switches(axis);
}

static inline void drive(struct axis *axis, double demand)
{
    double motor = clamp(demand, axis->torque_limit * AXIS_RATED_ACCELERATION);

    axis->limited |= motor < demand || motor > demand;
    axis->acceleration = motor;
    move(axis, motor, viscous, coulomb);
}

static inline void turn(struct axis *axis, double velocity)
{
    double reachable = clamp(velocity, AXIS_MAX_SPEED);

    axis->limited = reachable < velocity || reachable > velocity;
    drive(axis, velocity_gain * (reachable - axis->velocity));
}

static inline void follow(struct axis *axis, double position, double velocity)
{
    turn(axis, position_gain * (position - axis->position) + feed_forward * velocity);
}

void axis_follow(struct axis *axis, double position, double velocity)
{
    follow(axis, position, velocity);
}

static void line_step(struct axis_line *line)
{
    if (line->steps_left > 1) {
        line->demand += line->velocity * AXIS_STEP_S;
        line->steps_left--;
    } else if (line->steps_left == 1) {
        /* The end of the line exactly, whatever the steps have rounded. */
        line->demand = line->end;
        line->steps_left--;
    } else {
        line->velocity = 0.0;
    }
}

uint32_t axis_follow_line(struct axis *axis, struct axis_line *line, double window, uint32_t steps)
{
    struct axis moving = *axis; /* in registers */
    uint32_t done = 0;
    double error;

    do {
        line_step(line);
        follow(&moving, line->demand, line->velocity);
        error = line->demand - moving.position;
        done++;
    } while (done < steps && error <= window && error >= -window);
    *axis = moving;
    return done;
}

void axis_turn(struct axis *axis, double velocity)
{
    turn(axis, velocity);
}

void axis_push(struct axis *axis, double torque)
{
    axis->limited = false;
    drive(axis, torque * AXIS_RATED_ACCELERATION);
}

void axis_coast(struct axis *axis)
{
    axis->limited = false;
    axis->acceleration = 0.0;
    move(axis, 0.0, winding_brake, coulomb);
}

double axis_torque(const struct axis *axis)
{
    return axis->acceleration / AXIS_RATED_ACCELERATION;
}

/* Towards minus infinity, as an encoder counts. */
int64_t axis_increments(double revolutions)
{
    double scaled = revolutions * AXIS_INCREMENTS;
    int64_t whole = (int64_t)scaled;

    return whole - ((double)whole > scaled);
}
