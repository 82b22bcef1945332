/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/axis.h"

#define TRAVEL                                                                                     \
    .start = 0.5, .stop_negative = -3.5, .limit_negative = -3.0, .home = 0.0,                      \
    .limit_positive = 40.0, .stop_positive = 40.5

/* Rated torque accelerates by 600 rev/s^2. At constant speed the axis is about 0.3 ms of travel
 * behind. */
const struct axis_model axis_servo = {
    .rated_torque = 1200.0,
    .peak_torque = 3600.0,
    .inertia = 2.0, /* 3.2 kg cm^2 */
    .viscous = 1.2,
    .coulomb = 0.6,
    .winding_brake = 40.0,
    .max_speed = 100.0,
    .position_gain = 120.0,
    .velocity_gain = 900.0,
    .feed_forward = 0.95,
    TRAVEL,
    .resolution = 1 << 20,
};

/* The same motor with a load that rated torque accelerates by 15 rev/s^2 only. Loops as soft as
 * such a load wants them. */
const struct axis_model axis_heavy = {
    .rated_torque = 1200.0,
    .peak_torque = 3600.0,
    .inertia = 80.0,
    .viscous = 4.0,
    .coulomb = 60.0,
    .winding_brake = 40.0,
    .max_speed = 50.0,
    .position_gain = 25.0,
    .velocity_gain = 120.0,
    .feed_forward = 0.95,
    TRAVEL,
    .resolution = 1 << 20,
};

const struct axis_model axis_rotary = {
    .rated_torque = 8000.0,
    .peak_torque = 20000.0,
    .inertia = 64.0,
    .viscous = 16.0,
    .coulomb = 32.0,
    .winding_brake = 500.0,
    .max_speed = 10.0,
    .position_gain = 80.0,
    .velocity_gain = 600.0,
    .feed_forward = 0.98,
    .start = 0.0,
    .stop_negative = -AXIS_NEVER,
    .limit_negative = -AXIS_NEVER,
    .limit_positive = AXIS_NEVER,
    .stop_positive = AXIS_NEVER,
    .home_cam = true,
    .resolution = 1 << 20,
};

const struct axis_model axis_ideal = {
    .rated_torque = 1200.0,
    .peak_torque = 3600.0,
    .inertia = 2.0,
    .max_speed = 1e6,
    .start = 0.0,
    .stop_negative = -AXIS_NEVER,
    .limit_negative = -AXIS_NEVER,
    .limit_positive = AXIS_NEVER,
    .stop_positive = AXIS_NEVER,
    .home_cam = true,
    .ideal = true,
    .resolution = 1 << 20,
};

/* Two selections that compile to one instruction each. */
static double between(double low, double value, double high)
{
    double below = high < value ? high : value;

    return low > below ? low : below;
}

void axis_init(struct axis *axis, const struct axis_model *model, uint64_t seed)
{
    /* A seed counts in 2^-20 of the revolution. */
    *axis = (struct axis){
        .model = model,
        .position = model->start + (double)(seed % 1048576u) / 1048576.0,
        .torque_high = model->peak_torque / model->rated_torque,
        .torque_low = model->peak_torque / model->rated_torque,
        .peak = model->peak_torque / model->rated_torque,
        .speed_limit = model->max_speed,
        .rated = model->rated_torque / model->inertia,
        .viscous = model->viscous / model->inertia,
        .coulomb = model->coulomb / model->inertia,
        .winding_brake = model->winding_brake / model->inertia,
    };
}

static bool on_cam(double position)
{
    return position - (double)axis_floor(position) >= 0.5;
}

static inline void read_switches(struct axis *axis)
{
    const struct axis_model *m = axis->model;
    double at = axis->position;
    bool home = m->home_cam ? on_cam(at) : at <= m->home;
    unsigned s = (at <= m->limit_negative) * (unsigned)AXIS_SWITCH_NEGATIVE |
                 (at >= m->limit_positive) * (unsigned)AXIS_SWITCH_POSITIVE |
                 home * (unsigned)AXIS_SWITCH_HOME;

    axis->switches = (uint8_t)((s & ~axis->held_mask) | axis->held);
}

static inline void move(struct axis *axis, double motor, double damping, double friction)
{
    const struct axis_model *model = axis->model;
    double free = axis->velocity + (motor - damping * axis->velocity) * AXIS_STEP_S;
    double drag = friction * AXIS_STEP_S;

    /* Dry friction can stop the axis within a step but never turn it round. */
    axis->velocity = free - between(-drag, free, drag);
    axis->position += axis->velocity * AXIS_STEP_S;
    if (axis->position < model->stop_negative) {
        axis->position = model->stop_negative;
        axis->velocity = 0.0;
    } else if (axis->position > model->stop_positive) {
        axis->position = model->stop_positive;
        axis->velocity = 0.0;
    }
}

static inline void drive(struct axis *axis, double demand)
{
    double motor =
        between(-axis->torque_low * axis->rated, demand, axis->torque_high * axis->rated);

    axis->limited |= motor < demand || motor > demand;
    axis->acceleration = motor;
    move(axis, motor, axis->viscous, axis->coulomb);
}

static inline void turn(struct axis *axis, double velocity)
{
    double reachable = between(-axis->speed_limit, velocity, axis->speed_limit);

    axis->limited = reachable < velocity || reachable > velocity;
    drive(axis, axis->model->velocity_gain * (reachable - axis->velocity));
}

static void place(struct axis *axis, double position, double velocity)
{
    axis->limited = false;
    axis->acceleration = 0.0; /* nothing resists */
    axis->position = position;
    axis->velocity = velocity;
}

static inline void follow(struct axis *axis, double position, double velocity)
{
    const struct axis_model *model = axis->model;

    if (model->ideal)
        place(axis, position, velocity);
    else
        turn(axis,
             model->position_gain * (position - axis->position) + model->feed_forward * velocity);
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
    axis->position = a.position;
    axis->velocity = a.velocity;
    axis->acceleration = a.acceleration;
    axis->limited = a.limited;
    read_switches(axis);
    line->demand = l.demand;
    line->velocity = l.velocity;
    line->steps_left = l.steps_left;
    return done;
}

void axis_turn(struct axis *axis, double velocity)
{
    if (axis->model->ideal)
        place(axis, axis->position + velocity * AXIS_STEP_S, velocity);
    else
        turn(axis, velocity);
    read_switches(axis);
}

void axis_push(struct axis *axis, double torque)
{
    axis->limited = false;
    drive(axis, torque * axis->rated);
    read_switches(axis);
}

void axis_coast(struct axis *axis)
{
    axis->limited = false;
    axis->acceleration = 0.0;
    if (axis->model->ideal)
        place(axis, axis->position, 0.0);
    else
        move(axis, 0.0, axis->winding_brake, axis->coulomb);
    read_switches(axis);
}

void axis_look(struct axis *axis)
{
    read_switches(axis);
}

double axis_torque(const struct axis *axis)
{
    return axis->acceleration / axis->rated;
}
