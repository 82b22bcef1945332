/* SPDX-License-Identifier: MIT */
/* In place of musl's, which errs by more than 2 ulp. */
#include "pair.h"

double tanh(double x)
{
    const double size = fabs(x);
    struct pair sine, cosine;

    if (x != x)
        return x;
    if (size > 22) /* 1 to the last bit */
        return copysign(1, x);
    if (size < 0x1p-28)
        return x;
    if (size < 0.3) {
        sine = pair_sum(size, size * pair_sinh_series(size * size));
        cosine = pair_sum(1, pair_cosh_series(size * size));
    } else {
        struct pair up, down;
        pair_exp_both(size, &up, &down);
        sine = pair_sum(up.high, -down.high);
        sine.low += up.low - down.low;
        cosine = pair_sum(up.high, down.high);
        cosine.low += up.low + down.low;
    }
    const struct pair quotient = pair_quotient(sine, cosine);
    return copysign(quotient.high + quotient.low, x);
}
