/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Every function of <tgm/math.h> against MPFR: edge cases and random points in the ranges of the tables
 * below, fixed seed. Prints the worst error of each in ulp and the point where it was met; fails above 1.
 * Functions that ISO C calls exact must have none.
 *
 *     math_accuracy [POINTS per function, default 200000]
 */
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <mpfr.h>

#include "tgm/math.h"

#define signbit(x) __builtin_signbit(x)

#define PRECISION 200 /* bits of the reference; 1300 where the argument must be reduced exactly */
#define SEED      UINT64_C(0x746772616d6f7469)

static uint64_t seed;
static long points = 200000;

static uint64_t any_bits(void) /* splitmix64 */
{
    uint64_t z = seed += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double uniform(double from, double to)
{
    return from + (to - from) * ((double)(any_bits() >> 11) * 0x1p-53);
}

/* Even in the exponent, either sign: small and large get their share. */
static double spread(int from, int to)
{
    const int exponent = from + (int)(any_bits() % (uint64_t)(to - from + 1));
    const double x = ldexp(1.0 + (double)(any_bits() >> 12) * 0x1p-52, exponent);
    return any_bits() & 1 ? x : -x;
}

static const double edges[] = {
    0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.5, -2.5, 2.0, -2.0, 3.0, 4.0, 10.0, 100.0, 1e15, 1e22, -1e22,
    0x1p-1074, -0x1p-1074, 0x1p-1022, 0x1.fffffffffffffp-1023, 0x1.fffffffffffffp1023, -0x1.fffffffffffffp1023,
    0x1.fffffffffffffp-1, 0x1.0000000000001p0, 0x1p52, 0x1p53, 0x1.fffffffffffffp51, 0x1p-26, 0x1p-27, 0x1p-53,
    709.782712893384, 709.7827128933841, -745.1332191019411, -745.1332191019412, -708.3964185322641, 710.4758600739439,
    710.475860073944, 1024.0, 1023.9999999999999, -1074.0, -1075.0, 0x1.921fb54442d18p0, 0x1.921fb54442d18p1,
    0x1.921fb54442d18p2, 0x1.62e42fefa39efp-1, 0x1.5bf0a8b145769p1, 22.0, -22.0, 0.34657359027997264,
    0x1.6ac5b262ca1ffp849, /* a hard case of argument reduction */
    6381956970095103.0 * 0x1p797, /* and the hardest */
    __builtin_inf(), -__builtin_inf(), __builtin_nan(""),
};
#define EDGES (sizeof edges / sizeof edges[0])

typedef int reference1(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
typedef int reference2(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

struct range {
    int by_exponent; /* else uniform */
    double from, to; /* of the value or of its exponent */
};

static const struct range all = { 1, -1074, 1023 }, unit = { 0, -1, 1 }, small = { 1, -60, 0 };

struct function {
    const char *name;
    double (*f1)(double);
    reference1 *r1;
    double (*f2)(double, double);
    reference2 *r2;
    int exact;
    mpfr_prec_t precision;
    struct range range[4]; /* of x, each gets a share of the points; the same for y */
};

static int ref_round(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    (void)mode;
    return mpfr_round(y, x);
}

static int ref_floor(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    (void)mode;
    return mpfr_floor(y, x);
}

static int ref_ceil(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    (void)mode;
    return mpfr_ceil(y, x);
}

static int ref_trunc(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    (void)mode;
    return mpfr_trunc(y, x);
}

static int ref_abs(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    return mpfr_abs(y, x, mode);
}

static double lround_as_double(double x)
{
    return x >= -2147483648.0 && x <= 2147483647.0 ? (double)lround(x) : round(x);
}

static double llround_as_double(double x)
{
    return x >= -0x1p63 && x < 0x1p63 ? (double)llround(x) : round(x);
}

static double sine_of_both(double x)
{
    double sine, cosine;
    sincos(x, &sine, &cosine);
    return sine;
}

static double cosine_of_both(double x)
{
    double sine, cosine;
    sincos(x, &sine, &cosine);
    return cosine;
}

static double put_together(double x) /* frexp and ldexp, modf */
{
    int exponent = 0;
    double whole = 0;
    const double fraction = frexp(x, &exponent);
    const double rest = modf(x, &whole);
    const double size = fabs(fraction);
    if (x - x == 0 && x != 0 && !(size >= 0.5 && size < 1 && fabs(rest) < 1 && whole == trunc(x) && whole + rest == x))
        return 12345.0;
    return ldexp(fraction, exponent);
}

static int ref_same(mpfr_ptr y, mpfr_srcptr x, mpfr_rnd_t mode)
{
    return mpfr_set(y, x, mode);
}

static double scaled(double x, double n)
{
    return n >= -3000 && n <= 3000 ? scalbn(x, (int)n) : x;
}

static int ref_scaled(mpfr_ptr z, mpfr_srcptr x, mpfr_srcptr n, mpfr_rnd_t mode)
{
    const double by = mpfr_get_d(n, MPFR_RNDZ);
    return mpfr_mul_2si(z, x, by >= -3000 && by <= 3000 ? (long)by : 0, mode);
}

static double fused(double x, double y) /* cancels all but the rounding error of x * y */
{
    return fma(x, y, -(x * y));
}

static int ref_fused(mpfr_ptr z, mpfr_srcptr x, mpfr_srcptr y, mpfr_rnd_t mode)
{
    mpfr_t product;
    mpfr_init2(product, 53);
    mpfr_set_d(product, -(mpfr_get_d(x, MPFR_RNDN) * mpfr_get_d(y, MPFR_RNDN)), MPFR_RNDN);
    const int t = mpfr_fma(z, x, y, product, mode);
    mpfr_clear(product);
    return t;
}

/* The sign of a NaN counts for copysign, but MPFR's has none. */
static double signed_as(double size, double sign)
{
    return sign != sign ? copysign(size, 1) : copysign(size, sign);
}

static int ref_signed_as(mpfr_ptr z, mpfr_srcptr size, mpfr_srcptr sign, mpfr_rnd_t mode)
{
    return mpfr_nan_p(sign) ? mpfr_abs(z, size, mode) : mpfr_copysign(z, size, sign, mode);
}

#define ONE(name, reference, ...)   { #name, name, reference, NULL, NULL, 0, PRECISION, { __VA_ARGS__ } }
#define EXACT(name, reference, ...) { #name, name, reference, NULL, NULL, 1, PRECISION, { __VA_ARGS__ } }
#define ANGLE(name, reference)                                                                     \
    { #name, name, reference, NULL, NULL, 0, 1300, { { 0, -4, 4 }, { 0, -1000, 1000 }, all, { 1, -30, 30 } } }
#define TWO(name, reference, ...)   { #name, NULL, NULL, name, reference, 0, PRECISION, { __VA_ARGS__ } }
#define TWO_EXACT(name, reference, precision, ...)                                                 \
    { #name, NULL, NULL, name, reference, 1, precision, { __VA_ARGS__ } }

static const struct function functions[] = {
    ANGLE(sin, mpfr_sin),
    ANGLE(cos, mpfr_cos),
    ANGLE(tan, mpfr_tan),
    ANGLE(sine_of_both, mpfr_sin),
    ANGLE(cosine_of_both, mpfr_cos),
    ONE(asin, mpfr_asin, unit, unit, small, { 0, 0.95, 1 }),
    ONE(acos, mpfr_acos, unit, unit, small, { 0, 0.95, 1 }),
    ONE(atan, mpfr_atan, unit, { 0, -5, 5 }, small, all),
    TWO(atan2, mpfr_atan2, unit, { 0, -5, 5 }, { 1, -30, 30 }, all),
    ONE(sinh, mpfr_sinh, unit, { 0, -4, 4 }, { 0, -711, 711 }, small),
    ONE(cosh, mpfr_cosh, unit, { 0, -4, 4 }, { 0, -711, 711 }, small),
    ONE(tanh, mpfr_tanh, unit, { 0, -4, 4 }, { 0, -25, 25 }, small),
    ONE(exp, mpfr_exp, unit, { 0, -746, 710 }, { 0, -20, 20 }, small),
    ONE(exp2, mpfr_exp2, unit, { 0, -1076, 1025 }, { 0, -20, 20 }, small),
    ONE(expm1, mpfr_expm1, unit, { 0, -40, 710 }, { 0, -20, 20 }, small),
    ONE(log, mpfr_log, { 0, 0, 2 }, { 0, 0.9, 1.1 }, { 0, 0, 1000 }, all),
    ONE(log2, mpfr_log2, { 0, 0, 2 }, { 0, 0.9, 1.1 }, { 0, 0, 1000 }, all),
    ONE(log10, mpfr_log10, { 0, 0, 2 }, { 0, 0.9, 1.1 }, { 0, 0, 1000 }, all),
    ONE(log1p, mpfr_log1p, unit, { 0, -0.5, 3 }, small, all),
    TWO(pow, mpfr_pow, { 0, 0, 2 }, { 0, 0, 40 }, { 1, -9, 9 }, { 1, -3, 3 }),
    TWO(hypot, mpfr_hypot, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, all),
    ONE(cbrt, mpfr_cbrt, unit, { 0, 1, 8 }, { 0, -1000, 1000 }, all),
    EXACT(sqrt, mpfr_sqrt, { 0, 0, 1 }, { 0, 1, 4 }, { 0, 0, 1000 }, all),
    EXACT(fabs, ref_abs, unit, all, all, all),
    EXACT(floor, ref_floor, { 0, -4, 4 }, { 1, 0, 54 }, all, small),
    EXACT(ceil, ref_ceil, { 0, -4, 4 }, { 1, 0, 54 }, all, small),
    EXACT(round, ref_round, { 0, -4, 4 }, { 1, 0, 54 }, all, small),
    EXACT(trunc, ref_trunc, { 0, -4, 4 }, { 1, 0, 54 }, all, small),
    EXACT(rint, mpfr_rint, { 0, -4, 4 }, { 1, 0, 54 }, all, small),
    EXACT(lround_as_double, ref_round, { 0, -4, 4 }, { 0, -2e9, 2e9 }, { 1, 0, 30 }, small),
    EXACT(llround_as_double, ref_round, { 0, -4, 4 }, { 0, -2e9, 2e9 }, { 1, 0, 62 }, small),
    EXACT(put_together, ref_same, unit, all, all, all),
    TWO_EXACT(fmod, mpfr_fmod, 2200, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, { 1, -300, 300 }),
    TWO_EXACT(remainder, mpfr_remainder, 2200, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, { 1, -300, 300 }),
    TWO_EXACT(fmin, mpfr_min, PRECISION, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, all),
    TWO_EXACT(fmax, mpfr_max, PRECISION, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, all),
    TWO_EXACT(signed_as, ref_signed_as, PRECISION, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, all),
    TWO_EXACT(scaled, ref_scaled, PRECISION, { 0, -1000, 1000 }, { 0, -2100, 2100 }, { 1, -10, 10 }, { 1, -30, 10 }),
    TWO_EXACT(fused, ref_fused, 2200, unit, { 0, -1000, 1000 }, { 1, -30, 30 }, { 1, -500, 500 }),
};

/* Distance of a result from the exact value, in units of the last place of the double nearest to it. */
static double ulps(double result, mpfr_srcptr exact, mpfr_ptr work)
{
    const double nearest = mpfr_get_d(exact, MPFR_RNDN);
    if (nearest != nearest || result != result)
        return (nearest != nearest) == (result != result) ? 0 : 1e300;
    if (nearest == 0 && result == 0)
        return signbit(nearest) == signbit(result) ? 0 : 1e300;
    if (nearest != result && (nearest - nearest != 0 || result - result != 0)) /* one overflowed: is the other next to it? */
        return fabs(nearest) >= 0x1.fffffffffffffp1023 && fabs(result) >= 0x1.fffffffffffffp1023 &&
                       (nearest > 0) == (result > 0) ? 0.75 : 1e300;
    if (nearest - nearest != 0)
        return 0;
    int exponent = 0;
    frexp(nearest, &exponent);
    mpfr_set_d(work, result, MPFR_RNDN);
    mpfr_sub(work, work, exact, MPFR_RNDN);
    mpfr_mul_2si(work, work, -(exponent - 53 < -1074 ? -1074 : exponent - 53), MPFR_RNDN);
    return fabs(mpfr_get_d(work, MPFR_RNDN));
}

struct worst {
    double error, x, y;
    long points;
};

static void measure(const struct function *f, double x, double y, struct worst *worst, mpfr_t *v)
{
    double result;
    mpfr_set_d(v[0], x, MPFR_RNDN);
    if (f->f1 != NULL) {
        result = f->f1(x);
        f->r1(v[2], v[0], MPFR_RNDN);
    } else {
        result = f->f2(x, y);
        mpfr_set_d(v[1], y, MPFR_RNDN);
        f->r2(v[2], v[0], v[1], MPFR_RNDN);
    }
    const double error = f->exact && result == mpfr_get_d(v[2], MPFR_RNDN) ? 0 : ulps(result, v[2], v[3]);
    worst->points++;
    if (error > worst->error || worst->points == 1) {
        worst->error = error;
        worst->x = x;
        worst->y = y;
    }
}

static double draw(const struct range *r)
{
    return r->by_exponent ? spread((int)r->from, (int)r->to) : uniform(r->from, r->to);
}

static int judge(const struct function *f)
{
    struct worst worst = { 0 };
    mpfr_t v[4];
    for (int i = 0; i < 4; i++)
        mpfr_init2(v[i], f->precision);

    for (size_t i = 0; i < EDGES; i++)
        for (size_t j = 0; j < (f->f1 != NULL ? 1 : EDGES); j++)
            measure(f, edges[i], edges[j], &worst, v);
    for (long i = 0; i < points; i++) {
        const double x = draw(&f->range[i % 4]);
        measure(f, x, draw(&f->range[i / 4 % 4]), &worst, v);
    }
    for (int i = 0; i < 4; i++)
        mpfr_clear(v[i]);

    const int good = f->exact ? worst.error == 0 : worst.error <= 1.0;
    printf("%-18s %8ld points  worst %.4f ulp at %a", f->name, worst.points, worst.error, worst.x);
    if (f->f2 != NULL)
        printf(", %a", worst.y);
    printf("%s\n", good ? "" : f->exact ? "  NOT EXACT" : "  ABOVE 1");
    return good;
}

int main(int argc, char **argv)
{
    int failed = 0;
    if (argc > 1)
        points = atol(argv[1]);
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; i++) {
        seed = SEED;
        failed += !judge(&functions[i]);
    }
    printf("%zu passed, %d failed\n", sizeof functions / sizeof functions[0] - (size_t)failed, failed);
    return failed != 0;
}
