/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/angle.h"

#include <math.h>

#include "host/profile_shape.h"

/* 0 <= it < 2, of an angle that is not negative. */
static double without_turns(double h)
{
    return h - 2 * floor(h / 2);
}

double angle_sine(double h)
{
    const double rest = without_turns(fabs(h));
    const double sine = rest > 1 ? -profile_sine(rest - 1) : profile_sine(rest);
    return h < 0 ? -sine : sine;
}

double angle_cosine(double h)
{
    const double rest = without_turns(fabs(h));
    const double half = rest > 1 ? 2 - rest : rest;
    return half > 0.5 ? -profile_sine(half - 0.5) : profile_sine(0.5 - half);
}

/* Of the direction (1, t), 0 <= t <= 1: a guess that is right to 0.002, and what the sine of the
 * rest says. */
static double first_octant(double t)
{
    const double size = sqrt(1 + t * t), x = 1 / size, y = t / size;
    const double h = t * (0.25 + (1 - t) * (0.0779 + 0.0211 * t));
    const double rest = y * angle_cosine(h) - x * angle_sine(h), square = rest * rest;
    return h + rest * (1 + square * (1. / 6 + square * 3 / 40)) / ANGLE_PI;
}

double angle_of(double x, double y)
{
    const double across = fabs(x), up = fabs(y);
    double h;
    if (across == 0 && up == 0)
        return 0;
    h = up > across ? 0.5 - first_octant(across / up) : first_octant(up / across);
    if (x < 0)
        h = 1 - h;
    return y < 0 ? -h : h;
}
