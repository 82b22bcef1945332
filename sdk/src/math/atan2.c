/* SPDX-License-Identifier: MIT */
/*
 * In place of musl's, which errs by up to 1.4 ulp: it rounds y / x before it takes the arc tangent.
 *
 * With 0 <= b <= a the two coordinates without sign, c the multiple of 1/32 nearest to b / a:
 *     atan(b / a) = atan(c) + atan(t), t = (b - c a) / (a + c b), |t| <= 1/64
 */
#include "pair.h"

#define STEPS 32

static const struct pair pi = { 0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53 };
static const struct pair half_pi = { 0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54 };

/* atan(i / 32) */
static const struct pair arcs[STEPS + 1] = {
    { 0x0p+0, 0x0p+0 },
    { 0x1.ffd55bba97625p-6, -0x1.5ec431444912cp-60 },
    { 0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60 },
    { 0x1.7ee182602f10fp-4, -0x1.cfb654c0c3d98p-58 },
    { 0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59 },
    { 0x1.3d6eee8c6626cp-3, 0x1.61a3b0ce9281bp-57 },
    { 0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58 },
    { 0x1.b90d7529260a2p-3, 0x1.17b10d2e0e5abp-61 },
    { 0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57 },
    { 0x1.18bf5a30bf178p-2, 0x1.30ca4748b1bf9p-57 },
    { 0x1.362773707ebccp-2, -0x1.963a544b672d8p-57 },
    { 0x1.530ad9951cd4ap-2, -0x1.2566480884082p-57 },
    { 0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56 },
    { 0x1.8b24d394a1b25p-2, 0x1.b6d0ba3748fa8p-56 },
    { 0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56 },
    { 0x1.c0db4c94ec9fp-2, -0x1.cc1ce70934c34p-56 },
    { 0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56 },
    { 0x1.f40dd0b541418p-2, -0x1.a3992dc382a23p-57 },
    { 0x1.0657e94db30dp-1, -0x1.d5b495f6349e6p-56 },
    { 0x1.1255d9bfbd2a9p-1, -0x1.2bdaee1c0ee35p-58 },
    { 0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58 },
    { 0x1.2958e59308e31p-1, -0x1.09e73b0c6c087p-56 },
    { 0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55 },
    { 0x1.3f13fb89e96f4p-1, 0x1.ecf8b492644fp-56 },
    { 0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56 },
    { 0x1.538f57b89061fp-1, -0x1.1bb74abda520cp-55 },
    { 0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57 },
    { 0x1.66d663923e087p-1, -0x1.6ea6febe8bbbap-56 },
    { 0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56 },
    { 0x1.78f6bbd5d315ep-1, 0x1.406a08980374p-55 },
    { 0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56 },
    { 0x1.89ff5ff57f1f8p-1, -0x1.55b9a5e177a1bp-55 },
    { 0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55 },
};

/* a and b so large that nothing below gets lost, b >= a * 2^-60. c has 6 bits, so its products with the
 * parts of a and b are exact. */
static struct pair arc_of_quotient(double b, double a)
{
    const int i = (int)(b / a * STEPS + 0.5);
    const double c = (double)i / STEPS;
    const double a1 = pair_upper(a), b1 = pair_upper(b);
    const double first = b - c * a1, second = c * (a - a1);
    const struct pair over = fabs(first) >= fabs(second) ? pair_sum(first, -second) : pair_sum(-second, first);
    struct pair under = pair_sum(a, c * b1);
    under = pair_sum(under.high, under.low + c * (b - b1));
    const struct pair t = pair_quotient(over, under);
    const double z = t.high * t.high;
    const double series = t.high * z * (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9))));
    const struct pair sum = pair_sum(arcs[i].high, t.high);
    return pair_sum(sum.high, sum.low + (arcs[i].low + t.low + series));
}

static struct pair subtract(struct pair from, struct pair what)
{
    const struct pair sum = pair_sum(from.high, -what.high);
    return pair_sum(sum.high, sum.low + (from.low - what.low));
}

double atan2(double y, double x)
{
    const int left = signbit(x);
    double a = fabs(x), b = fabs(y);

    if (a != a || b != b)
        return x + y;
    const int steep = b > a;
    if (steep) {
        a = fabs(y);
        b = fabs(x);
    }
    if (a == b && (a == 0 || isinf(a))) { /* as if on an axis or a diagonal */
        b = a == 0 ? 0 : 1;
        a = 1;
    } else if (isinf(a)) {
        b = 0;
        a = 1;
    }
    const double scale = a > 0x1p500 ? 0x1p-600 : a < 0x1p-500 ? 0x1p600 : 1;

    struct pair arc;
    if (b * scale < a * scale * 0x1p-60) {
        if (!steep && !left)
            return copysign(b / a, y);
        arc = (struct pair){ b * scale / (a * scale), 0 };
    } else {
        arc = arc_of_quotient(b * scale, a * scale);
    }
    if (steep)
        arc = subtract(half_pi, arc);
    if (left)
        arc = subtract(pi, arc);
    return copysign(arc.high + arc.low, y);
}
