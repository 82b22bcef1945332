/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * axis.h - the mechanics of one simulated axis with the innermost loops of its drive: an inertia
 * with friction between two hard stops, a velocity loop that makes torque, a position loop with
 * velocity feed-forward around it.
 *
 * Moves in fixed steps of AXIS_STEP_NS; whoever owns the axis cuts time into them. Only additions,
 * multiplications and comparisons of doubles: identical everywhere as long as the compiler does not
 * fuse them (-ffp-contract=off).
 */
#ifndef HARNESS_BUS_AXIS_H
#define HARNESS_BUS_AXIS_H

#include <stdbool.h>
#include <stdint.h>

#define AXIS_STEP_NS    125000
#define AXIS_STEP_S     125e-6
#define AXIS_INCREMENTS 1048576.0 /* per revolution, 2^20 */

/*
 * The machine. Zero is where the encoder of the drive counts zero.
 *
 *   -3.5 rev   hard stop
 *   -3   rev   negative limit switch: active at and below
 *    0   rev   home switch: active at and below
 *   +0.5 .. +1.5 rev   where the axis stands at power-on (seed)
 *  +40   rev   positive limit switch: active at and above
 *  +40.5 rev   hard stop
 */
#define AXIS_STOP_NEGATIVE  (-3.5)
#define AXIS_LIMIT_NEGATIVE (-3.0)
#define AXIS_HOME           0.0
#define AXIS_LIMIT_POSITIVE 40.0
#define AXIS_STOP_POSITIVE  40.5

/* Motor and load: rated torque accelerates by 600 rev/s^2, peak is three times rated. */
#define AXIS_RATED_ACCELERATION 600.0
#define AXIS_PEAK_TORQUE        3.0
#define AXIS_MAX_SPEED          100.0 /* rev/s, limit of the speed demand */

struct axis {
    double position;     /* rev */
    double velocity;     /* rev/s */
    double acceleration; /* demanded from the motor, rev/s^2 */
    double torque_limit; /* of rated, 0 .. AXIS_PEAK_TORQUE */
    bool limited;        /* the demand of the last step exceeded torque or speed */
    uint8_t switches;    /* AXIS_SWITCH_* */
};

enum { AXIS_SWITCH_NEGATIVE = 1, AXIS_SWITCH_POSITIVE = 2, AXIS_SWITCH_HOME = 4 };

void axis_init(struct axis *axis, uint64_t seed);

/* One step each. Position in rev, velocity in rev/s, torque as a fraction of rated. */
void axis_follow(struct axis *axis, double position, double velocity);
/* Along a straight line of demands that ends exactly at `end`, then standing there. */
struct axis_line {
    double demand, velocity, end;
    uint32_t steps_left;
};
/* Up to `steps` steps of the line, at least one, ending behind the first whose following error is
 * beyond `window`. Returns the number done. */
uint32_t axis_follow_line(struct axis *axis, struct axis_line *line, double window, uint32_t steps);
void axis_turn(struct axis *axis, double velocity);
void axis_push(struct axis *axis, double torque);
/* Power off: the shorted windings brake it. */
void axis_coast(struct axis *axis);

double axis_torque(const struct axis *axis); /* of rated */
int64_t axis_increments(double revolutions);

#endif
