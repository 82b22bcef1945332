/* SPDX-License-Identifier: MIT */
/* In place of musl's, which errs by up to 2 ulp. */
#include "pair.h"

double sinh(double x)
{
    const double size = fabs(x);
    struct pair up, down;
    int exponent;

    if (!(size < 720)) /* infinite, or no number */
        return x * 0x1p1023;
    if (size < 0x1p-28)
        return x;
    if (size < 0.3)
        return x + x * pair_sinh_series(x * x);
    if (size >= 40) {
        up = pair_exp(size, &exponent);
        return copysign(scalbn(up.high + up.low, exponent - 1), x);
    }
    pair_exp_both(size, &up, &down);
    const struct pair difference = pair_sum(up.high, -down.high);
    return copysign(0.5 * (difference.high + (difference.low + (up.low - down.low))), x);
}
