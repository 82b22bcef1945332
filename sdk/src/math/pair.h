/* SPDX-License-Identifier: MIT */
/*
 * pair.h - a number as the sum of two doubles, for the few functions in which musl errs by more than one
 * unit in the last place. The second is small against the first: together they carry about 60
 * bits, so that the last step, high + low, makes nearly the only rounding error. Not for authors.
 *
 * Compiled by sdk/mk/math.sh with -ffp-contract=off and without -ffast-math, on which it depends.
 */
#ifndef TGM_SRC_MATH_PAIR_H
#define TGM_SRC_MATH_PAIR_H

#include "libm.h"
#include "exp_data.h"

struct pair {
    double high, low;
};

/* |a| >= |b|, or a is 0 */
static inline struct pair pair_sum(double a, double b)
{
    const double high = a + b;
    const double low = b - (high - a);
    return (struct pair){ high, low };
}

/* The upper 26 bits; what is left has 27, so that products of parts are exact. */
static inline double pair_upper(double x)
{
    return asdouble(asuint64(x) & (uint64_t)-1 << 27);
}

static inline struct pair pair_product(double a, double b)
{
    const double a1 = pair_upper(a), a2 = a - a1, b1 = pair_upper(b), b2 = b - b1;
    const double high = a * b;
    const double low = ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2;
    return (struct pair){ high, low };
}

static inline struct pair pair_quotient(struct pair a, struct pair b)
{
    const double high = a.high / b.high;
    const struct pair back = pair_product(high, b.high);
    const double low = ((a.high - back.high - back.low) + a.low - high * b.low) / b.high;
    return (struct pair){ high, low };
}

/* exp(x) / 2^*exponent, |x| < 1100; the reduction and the table are those of musl's exp.c. */
static inline struct pair pair_exp(double x, int *exponent)
{
    const double shifted = eval_as_double(x * __exp_data.invln2N + __exp_data.shift);
    const double whole = shifted - __exp_data.shift;
    const int k = (int)whole, n = 1 << EXP_TABLE_BITS, i = k & (n - 1);
    const double r = x + whole * __exp_data.negln2hiN + whole * __exp_data.negln2loN;
    const double *c = __exp_data.poly + EXP_POLY_ORDER - 5;
    const double scale = asdouble(__exp_data.tab[2 * i + 1] + ((uint64_t)i << (52 - EXP_TABLE_BITS)));
    const double rest = asdouble(__exp_data.tab[2 * i]) + r + r * r * (c[0] + r * c[1]) +
                        r * r * (r * r) * (c[2] + r * c[3]);
    *exponent = (k - i) / n;
    return pair_sum(scale, scale * rest);
}

/* 2^n, |n| < 1000 */
static inline double pair_power_of_two(int n)
{
    return asdouble((uint64_t)(1023 + n) << 52);
}

/* exp(x) and exp(-x), 0 <= x < 40 */
static inline void pair_exp_both(double x, struct pair *up, struct pair *down)
{
    int exponent;
    *up = pair_exp(x, &exponent);
    up->high *= pair_power_of_two(exponent);
    up->low *= pair_power_of_two(exponent);
    *down = pair_exp(-x, &exponent);
    down->high *= pair_power_of_two(exponent);
    down->low *= pair_power_of_two(exponent);
}

/* Beginnings of the power series, to 2^-64 for x * x = z < 1/8: sinh(x) / x - 1 and cosh(x) - 1. */
static inline double pair_sinh_series(double z)
{
    return z * (1.0 / 6 + z * (1.0 / 120 + z * (1.0 / 5040 + z * (1.0 / 362880 + z * (1.0 / 39916800 +
           z * (1.0 / 6227020800 + z / 1307674368000))))));
}

static inline double pair_cosh_series(double z)
{
    return z * (1.0 / 2 + z * (1.0 / 24 + z * (1.0 / 720 + z * (1.0 / 40320 + z * (1.0 / 3628800 +
           z * (1.0 / 479001600 + z / 87178291200))))));
}

#endif
