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

/* Two selections that compile to one instruction each. */
static double clamp(double value, double limit)
{
    double below = limit < value ? limit : value;

    return -limit > below ? -limit : below;
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
    axis->switches = (uint8_t)((axis->position <= AXIS_LIMIT_NEGATIVE) * AXIS_SWITCH_NEGATIVE |
                               (axis->position >= AXIS_LIMIT_POSITIVE) * AXIS_SWITCH_POSITIVE |
                               (axis->position <= AXIS_HOME) * AXIS_SWITCH_HOME);
}

static inline void move(struct axis *axis, double motor, double damping, double friction)
{
    double free = axis->velocity + (motor - damping * axis->velocity) * AXIS_STEP_S;
    double drag = friction * AXIS_STEP_S;

    /* Dry friction can stop the axis within a step but never turn it round. */
    axis->velocity = free - clamp(free, drag);
    axis->position += axis->velocity * AXIS_STEP_S;
    if (axis->position < AXIS_STOP_NEGATIVE) {
        axis->position = AXIS_STOP_NEGATIVE;
        axis->velocity = 0.0;
    } else if (axis->position > AXIS_STOP_POSITIVE) {
        axis->position = AXIS_STOP_POSITIVE;
        axis->velocity = 0.0;
    }
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
    read_switches(axis);
}

uint32_t axis_follow_line(struct axis *axis, struct axis_line *line, double window, uint32_t steps)
{
    struct axis_line l = *line; /* in registers, like the axis */
    struct axis a = *axis;
    uint32_t done = 0;
    double error;

    do {
        if (l.steps_left > 1) {
            l.demand += l.velocity * AXIS_STEP_S;
            l.steps_left--;
        } else if (l.steps_left == 1) {
            /* The end of the line exactly, whatever the steps have rounded. */
            l.demand = l.end;
            l.steps_left--;
        } else {
            l.velocity = 0.0;
        }
        follow(&a, l.demand, l.velocity);
        error = l.demand - a.position;
        done++;
    } while (done < steps && error <= window && error >= -window);
    read_switches(&a);
    *axis = a;
    *line = l;
    return done;
}

void axis_turn(struct axis *axis, double velocity)
{
    turn(axis, velocity);
    read_switches(axis);
}

void axis_push(struct axis *axis, double torque)
{
    axis->limited = false;
    drive(axis, torque * AXIS_RATED_ACCELERATION);
    read_switches(axis);
}

void axis_coast(struct axis *axis)
{
    axis->limited = false;
    axis->acceleration = 0.0;
    move(axis, 0.0, winding_brake, coulomb);
    read_switches(axis);
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
