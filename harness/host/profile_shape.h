/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * profile_shape.h - how the speed goes from one value to another: the ramps of the profile
 * generator, in time 0..1 and speed 0..1.
 *
 * Every shape is point-symmetric about (1/2, 1/2). Two families cover the types of SERVO.Pg:
 *
 *   corners   the acceleration rises along a quarter of a sine, stays, and falls likewise. A corner
 * is the part of the ramp in which it rises: 0 is a trapezoid, 1/2 is harmonic (the acceleration is
 * half a sine), what lies between is a trapezoid with limited jerk. sin2      the acceleration is a
 * squared sine, so that the jerk is continuous, too.
 *
 * Only + - * / of doubles and our own sine: the same to the last bit on every machine. The values
 * are within 1e-14 of the exact ones, relative to themselves.
 */
#ifndef HARNESS_HOST_PROFILE_SHAPE_H
#define HARNESS_HOST_PROFILE_SHAPE_H

#include <stdbool.h>
#include <stdint.h>

struct profile_shape {
    bool sin2;
    double corner; /* 0..1/2; not with sin2 */
    double peak;   /* largest acceleration of the ramp: 1 for the trapezoid */
};

/* The shape of a PG.Type (docs/decisions.md, M8); types beyond 5 are trapezoids. The percentage
 * counts for type 4. */
struct profile_shape profile_shape_of(uint32_t type, double percent);

/* At u = 0..1: acceleration, speed and way. */
double profile_shape_rate(const struct profile_shape *shape, double u);
double profile_shape_speed(const struct profile_shape *shape, double u);
double profile_shape_way(const struct profile_shape *shape, double u);

/* Where in the first half of the ramp the acceleration is that part of its peak (0 below 0, the
 * place of the peak from 1 on). */
double profile_shape_onset(const struct profile_shape *shape, double part);

/* Sine of h half turns, h = 0..1, within 2.5e-16. */
double profile_sine(double h);

#endif
