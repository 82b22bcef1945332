/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * axis.h - the mechanics of one simulated axis with the innermost loops of its drive: an inertia
 * with friction between two hard stops, a velocity loop that makes torque, a position loop with
 * velocity feed-forward around it. Which motor and which machine says a const row of data.
 *
 * Moves in fixed steps of AXIS_STEP_NS; whoever owns the axis cuts time into them. Only additions,
 * multiplications and comparisons of doubles: identical everywhere as long as the compiler does not
 * fuse them (-ffp-contract=off).
 */
#ifndef HARNESS_BUS_AXIS_H
#define HARNESS_BUS_AXIS_H

#include <stdbool.h>
#include <stdint.h>

#define AXIS_STEP_NS 125000
#define AXIS_STEP_S  125e-6

/* Place of a stop or switch that is not there. */
#define AXIS_NEVER 1e300

/*
 * One motor with its load and its machine. Torques in mNm, angles in revolutions, so inertia is in
 * mNm s^2 per revolution: 2 pi / 10 of it make one kg cm^2. Loop gains in 1/s.
 *
 *   stop_negative    hard stop
 *   limit_negative   negative limit switch: active at and below
 *   home             home switch: active at and below; with home_cam active from -1/2 to 0 of every
 *                    revolution instead
 *   limit_positive   positive limit switch: active at and above
 *   stop_positive    hard stop
 *
 * The axis stands between `start` and one revolution above it at power-on (seed). Zero is where the
 * encoder counts zero.
 */
struct axis_model {
    double rated_torque, peak_torque; /* mNm */
    double inertia;                   /* mNm s^2/rev */
    double viscous;                   /* mNm s/rev */
    double coulomb;                   /* mNm */
    double winding_brake;             /* of the shorted windings without power, mNm s/rev */
    double max_speed;                 /* rev/s, limit of the speed demand */
    double position_gain, velocity_gain;
    /* Of one. Tuned drives leave it a little short: the axis is then behind and never ahead. */
    double feed_forward;
    double start;
    double stop_negative, limit_negative, home, limit_positive, stop_positive; /* rev */
    bool home_cam;
    /* No loops and no friction: the axis is where it is asked to be. */
    bool ideal;
    uint32_t resolution; /* increments per revolution in the objects of the drive */
};

/* drive-cia402's axis; one with forty times the load; a turntable without stops; an ideal one. */
extern const struct axis_model axis_servo, axis_heavy, axis_rotary, axis_ideal;

struct axis {
    const struct axis_model *model;
    double position;                /* rev */
    double velocity;                /* rev/s */
    double acceleration;            /* demanded from the motor, rev/s^2 */
    double torque_high, torque_low; /* limits as fractions of rated, both positive */
    double speed_limit;             /* rev/s */
    bool limited;                   /* the demand of the last step exceeded torque or speed */
    uint8_t switches;               /* AXIS_SWITCH_* */
    uint8_t held_mask, held;        /* switches that the outside world holds, and how */
    double rated, viscous, coulomb, winding_brake; /* accelerations: the model's by its inertia */
    double peak;                                   /* torque as a fraction of rated */
};

enum {
    AXIS_SWITCH_NEGATIVE = 1,
    AXIS_SWITCH_POSITIVE = 2,
    AXIS_SWITCH_HOME = 4,
    AXIS_SWITCHES = 7,
};

void axis_init(struct axis *axis, const struct axis_model *model, uint64_t seed);

/* One step each. Position in rev, velocity in rev/s, torque as a fraction of rated. */
void axis_follow(struct axis *axis, double position, double velocity);
void axis_turn(struct axis *axis, double velocity);
void axis_push(struct axis *axis, double torque);
/* Power off: the shorted windings brake it. */
void axis_coast(struct axis *axis);

/* The switches where the axis stands. */
void axis_look(struct axis *axis);
double axis_torque(const struct axis *axis); /* of rated */
/* A whole number, towards minus infinity as encoders count. */
static inline int64_t axis_floor(double value)
{
    int64_t whole = (int64_t)value;

    return whole - ((double)whole > value);
}

#endif
