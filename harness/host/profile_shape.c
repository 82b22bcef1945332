/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/profile_shape.h"

#include <stddef.h>

#define PI 3.14159265358979323846

/* x - sin x for 0 <= x <= pi/2, of full relative accuracy: its series up to x^23. */
static double excess(double x)
{
    static const double factors[] = { 1 / (2. * 3),   1 / (4. * 5),   1 / (6. * 7),
                                      1 / (8. * 9),   1 / (10. * 11), 1 / (12. * 13),
                                      1 / (14. * 15), 1 / (16. * 17), 1 / (18. * 19),
                                      1 / (20. * 21), 1 / (22. * 23) };
    const double square = x * x;
    double sum = 1;
    for (size_t i = sizeof factors / sizeof *factors; i-- > 1;)
        sum = 1 - sum * (square * factors[i]);
    return sum * square * x * factors[0];
}

double profile_sine(double h)
{
    const double x = PI * (h > 0.5 ? 1 - h : h);
    return x - excess(x);
}

/* The same for h half turns, 0..1. */
static double excess_of(double h)
{
    return h > 0.5 ? PI * h - profile_sine(h) : excess(PI * h);
}

static struct profile_shape cornered(double corner)
{
    return (struct profile_shape){ .corner = corner, .peak = 1 / (1 - 2 * corner * (1 - 2 / PI)) };
}

struct profile_shape profile_shape_of(uint32_t type, double percent)
{
    switch (type) {
    case 0:
    case 1:
    case 2:
        return cornered(0.5);
    case 4:
        return cornered(percent > 0 ? (percent < 100 ? percent / 200 : 0.5) : 0);
    case 5:
        return (struct profile_shape){ .sin2 = true, .peak = 2 };
    default:
        return cornered(0);
    }
}

static double first_half_rate(const struct profile_shape *shape, double u)
{
    if (shape->sin2) {
        const double sine = profile_sine(u);
        return 2 * sine * sine;
    }
    return u < shape->corner ? shape->peak * profile_sine(u / (2 * shape->corner)) : shape->peak;
}

/* 1 - cos y = 2 sin^2(y/2) */
static double corner_speed(const struct profile_shape *shape, double u)
{
    const double sine = profile_sine(u / (4 * shape->corner));
    return shape->peak * (4 * shape->corner / PI) * sine * sine;
}

static double corner_way(const struct profile_shape *shape, double u)
{
    const double scale = 2 * shape->corner / PI;
    return shape->peak * scale * scale * excess(u / scale);
}

static double first_half_speed(const struct profile_shape *shape, double u)
{
    const double corner = shape->corner;
    if (shape->sin2)
        return excess_of(2 * u) / (2 * PI);
    if (u < corner)
        return corner_speed(shape, u);
    return (corner > 0 ? corner_speed(shape, corner) : 0) + shape->peak * (u - corner);
}

static double first_half_way(const struct profile_shape *shape, double u)
{
    const double corner = shape->corner, after = u - corner, x = PI * u;
    if (shape->sin2) /* (x^2 - sin^2 x) / 2 pi^2 */
        return excess(x) * (x + profile_sine(u)) / (2 * PI * PI);
    if (after < 0)
        return corner_way(shape, u);
    const double straight = shape->peak * after * after / 2;
    if (corner > 0)
        return corner_way(shape, corner) + corner_speed(shape, corner) * after + straight;
    return straight;
}

double profile_shape_rate(const struct profile_shape *shape, double u)
{
    return first_half_rate(shape, u > 0.5 ? 1 - u : u);
}

double profile_shape_speed(const struct profile_shape *shape, double u)
{
    return u > 0.5 ? 1 - first_half_speed(shape, 1 - u) : first_half_speed(shape, u);
}

double profile_shape_way(const struct profile_shape *shape, double u)
{
    return u > 0.5 ? u - 0.5 + first_half_way(shape, 1 - u) : first_half_way(shape, u);
}

double profile_shape_onset(const struct profile_shape *shape, double part)
{
    double low = 0, high = shape->sin2 ? 0.5 : shape->corner;
    if (!(part > 0))
        return 0;
    if (part >= 1)
        return high;
    for (int i = 0; i < 60; i++) {
        const double middle = (low + high) / 2;
        if (first_half_rate(shape, middle) < part * shape->peak)
            low = middle;
        else
            high = middle;
    }
    return low;
}
