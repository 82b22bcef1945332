/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/axis_step.h"

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

void axis_follow(struct axis *axis, double position, double velocity)
{
    if (axis->model->ideal)
        axis_place(axis, position, velocity);
    else
        axis_follow_loop(axis, position, velocity);
    axis_read_switches(axis);
}

void axis_turn(struct axis *axis, double velocity)
{
    if (axis->model->ideal)
        axis_place(axis, axis->position + velocity * AXIS_STEP_S, velocity);
    else
        axis_reach(axis, velocity);
    axis_read_switches(axis);
}

void axis_push(struct axis *axis, double torque)
{
    axis->limited = false;
    axis_drive(axis, torque * axis->rated);
    axis_read_switches(axis);
}

void axis_coast(struct axis *axis)
{
    axis->limited = false;
    axis->acceleration = 0.0;
    if (axis->model->ideal)
        axis_place(axis, axis->position, 0.0);
    else
        axis_move(axis, 0.0, axis->winding_brake, axis->coulomb);
    axis_read_switches(axis);
}

void axis_look(struct axis *axis)
{
    axis_read_switches(axis);
}

double axis_torque(const struct axis *axis)
{
    return axis->acceleration / axis->rated;
}
