/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * profile_motion.h - the profile generator behind SERVO.Pg, without registers: position and speed
 * in closed form, cycle after cycle (docs/decisions.md, M8).
 *
 * A plan is made when an input changes, from the state of the last cycle, and is then only
 * evaluated: nothing is summed up from cycle to cycle, so that a plan of an hour is as exact as one
 * of a second. A plan is a row of segments, ramps and stretches of constant speed. Its time counts
 * from the last cycle before it; motion begins in the cycle in which the input was seen.
 *
 *   positioning   ramp to PosSpeed, constant speed, ramp to 0 on the destination. A move too short
 *                 for PosSpeed has the highest speed from which it still can stop. What moves the
 *                 wrong way, or cannot stop in time, brakes to 0 first and comes back.
 *   speed         ramp to Speed; for the other direction, by way of 0.
 *
 * Growing speed is limited by the acceleration, falling speed by the deceleration. Type 1 brakes
 * with the acceleration, too; type 2 uses the smaller of both and has no constant speed: where
 * PosSpeed limits it, both ramps are made longer until they fill the way.
 *
 * Speed is always continuous. Acceleration is, where the type has corners, within a plan, and from
 * one plan to the next when the first ramp goes on in the direction of the present one.
 */
#ifndef HARNESS_HOST_PROFILE_MOTION_H
#define HARNESS_HOST_PROFILE_MOTION_H

#include <stdbool.h>
#include <stdint.h>

#include "host/profile_shape.h"

#define PROFILE_LARGEST 1e15 /* beyond it, and below its inverse, no input is usable */

struct profile_wanted {
    bool positioning;
    double destination;  /* inc; positioning only */
    double speed;        /* inc/s; positioning: its size counts; else the sign is the direction */
    double acceleration; /* inc/s2, > 0 */
    double deceleration; /* inc/s2; not > 0: as the acceleration */
    uint32_t type;
    double percent; /* jerk limit of type 4, 0..100 */
};

/* A stretch of a plan: part of a ramp, or constant speed (time is 0). */
struct profile_segment {
    double begins, lasts; /* s */
    double position;      /* at its begin */
    double from, change;  /* speed of the whole ramp at its begin, and what it adds */
    double time;          /* of the whole ramp, of which this is what follows `begun` */
    double begun, begun_way;
    bool braking;
};

struct profile {
    /* After the last step. */
    double position, speed, acceleration;
    bool ready;   /* the wanted destination, or speed, is reached */
    bool braking; /* on a ramp on which the speed falls */

    bool planned;
    struct profile_wanted wanted;
    struct profile_shape shape;
    struct profile_segment segments[5];
    unsigned count;
    double ends, end_position, end_speed;
    bool reaches; /* what is wanted, at its end */
    uint64_t step;
};

/* Stands, or moves, there; forgets the plan. */
void profile_set(struct profile *profile, double position, double speed);

/* One cycle. Wanted values that are not usable (no numbers, too large, no acceleration) leave the
 * plan in force; without one, nothing moves. */
void profile_step(struct profile *profile, const struct profile_wanted *wanted, double cycle);

/* The same motion, counted from elsewhere: positions and destination are `by` larger. */
void profile_shift(struct profile *profile, double by);

#endif
