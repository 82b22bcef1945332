/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * axis_step.h - what happens in one step of an axis, inline for the two that take many: axis.c
 * and the drive modes that follow a line. Everybody else calls axis.h.
 */
#ifndef HARNESS_BUS_AXIS_STEP_H
#define HARNESS_BUS_AXIS_STEP_H

#include "bus/axis.h"

/* Two selections that compile to one instruction each. */
static inline double axis_between(double low, double value, double high)
{
    double below = high < value ? high : value;

    return low > below ? low : below;
}

static inline bool axis_on_cam(double position)
{
    return position - (double)axis_floor(position) >= 0.5;
}

static inline void axis_read_switches(struct axis *axis)
{
    const struct axis_model *m = axis->model;
    double at = axis->position;
    bool home = m->home_cam ? axis_on_cam(at) : at <= m->home;
    unsigned s = (at <= m->limit_negative) * (unsigned)AXIS_SWITCH_NEGATIVE |
                 (at >= m->limit_positive) * (unsigned)AXIS_SWITCH_POSITIVE |
                 home * (unsigned)AXIS_SWITCH_HOME;

    axis->switches = (uint8_t)((s & ~axis->held_mask) | axis->held);
}

static inline void axis_move(struct axis *axis, double motor, double damping, double friction)
{
    const struct axis_model *model = axis->model;
    double free = axis->velocity + (motor - damping * axis->velocity) * AXIS_STEP_S;
    double drag = friction * AXIS_STEP_S;

    /* Dry friction can stop the axis within a step but never turn it round. */
    axis->velocity = free - axis_between(-drag, free, drag);
    axis->position += axis->velocity * AXIS_STEP_S;
    if (axis->position < model->stop_negative) {
        axis->position = model->stop_negative;
        axis->velocity = 0.0;
    } else if (axis->position > model->stop_positive) {
        axis->position = model->stop_positive;
        axis->velocity = 0.0;
    }
}

static inline void axis_drive(struct axis *axis, double demand)
{
    double motor =
        axis_between(-axis->torque_low * axis->rated, demand, axis->torque_high * axis->rated);

    axis->limited |= motor < demand || motor > demand;
    axis->acceleration = motor;
    axis_move(axis, motor, axis->viscous, axis->coulomb);
}

static inline void axis_reach(struct axis *axis, double velocity)
{
    double reachable = axis_between(-axis->speed_limit, velocity, axis->speed_limit);

    axis->limited = reachable < velocity || reachable > velocity;
    axis_drive(axis, axis->model->velocity_gain * (reachable - axis->velocity));
}

static inline void axis_place(struct axis *axis, double position, double velocity)
{
    axis->limited = false;
    axis->acceleration = 0.0; /* nothing resists */
    axis->position = position;
    axis->velocity = velocity;
}

/* The position loop. */
static inline void axis_follow_loop(struct axis *axis, double position, double velocity)
{
    const struct axis_model *model = axis->model;

    axis_reach(axis,
               model->position_gain * (position - axis->position) + model->feed_forward * velocity);
}

/* A straight line of demands that ends exactly at `end`, then standing there. */
struct axis_line {
    double demand, velocity, end;
    uint32_t steps_left;
};

static inline void axis_line_step(struct axis_line *line)
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

/* Up to `steps` steps of the line, at least one, ending behind the first whose following error is
 * beyond `window`. Returns the number done. */
static inline uint32_t axis_follow_line(struct axis *axis, struct axis_line *line, double window,
                                        uint32_t steps)
{
    struct axis_line l = *line; /* in registers, like the axis */
    struct axis a = *axis;
    uint32_t done = 0;
    double error;

    /* Two loops: what does not change in one can wait outside. */
    if (a.model->ideal) {
        do {
            axis_line_step(&l);
            axis_place(&a, l.demand, l.velocity);
        } while (++done < steps);
    } else {
        do {
            axis_line_step(&l);
            axis_follow_loop(&a, l.demand, l.velocity);
            error = l.demand - a.position;
        } while (++done < steps && error <= window && error >= -window);
    }
    axis->position = a.position;
    axis->velocity = a.velocity;
    axis->acceleration = a.acceleration;
    axis->limited = a.limited;
    axis_read_switches(axis);
    line->demand = l.demand;
    line->velocity = l.velocity;
    line->steps_left = l.steps_left;
    return done;
}

#endif
