/* SPDX-License-Identifier: MIT */
/* In place of musl's, which errs by a little more than 1 ulp. */
#include "pair.h"

double cosh(double x)
{
    const double size = fabs(x);
    struct pair up, down;
    int exponent;

    if (!(size < 720)) /* infinite, or no number */
        return size * 0x1p1023;
    if (size >= 40) {
        up = pair_exp(size, &exponent);
        return scalbn(up.high + up.low, exponent - 1);
    }
    pair_exp_both(size, &up, &down);
    const struct pair sum = pair_sum(up.high, down.high);
    return 0.5 * (sum.high + (sum.low + (up.low + down.low)));
}
