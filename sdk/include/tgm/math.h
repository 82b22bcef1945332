/* SPDX-License-Identifier: MIT */
/*
 * math.h - mathematical functions of a module: sin, sqrt, pow and their kind, without a C library.
 *
 * The functions have their ISO C names and meanings. Their code is that of musl, a C library under the
 * MIT licence, and for the four in which musl errs by more than one unit in the last place (atan2, sinh,
 * cosh, tanh) the SDK's own. sdk/mk/math.sh builds it for the module's target into libtgm_math.a, from
 * which the linker takes what is used:
 *
 *     MATH := yes             in the module's Makefile, before the include of module.mk
 *     #include <tgm/math.h>
 *
 * Including <math.h> as well, before or after, does no harm: the declarations agree.
 *
 * Common to all:
 * - Accuracy: less than 1 ulp (unit in the last place) from the exact result at each of the million points
 *   per function, over its whole range, at which tests/math_accuracy.c compares it with MPFR; exact where
 *   marked so. No proof for the points between them.
 * - No state: no errno, no thread-local storage, no writable data; any of the six functions may call
 *   them at any time, also while another was interrupted inside the same function.
 * - Bad arguments give what ISO C annex F says: a NaN (sqrt(-1), log(-1), acos(2), fmod(x, 0)), an infinity
 *   (log(0), exp(1000)) or a NaN passed through. Nothing traps and nothing is printed: a program that
 *   writes results to a drive tests them first.
 * - Time: tens of nanoseconds on a PC; sin, cos and tan of arguments above 1e6 take several times
 *   as long, fmod and remainder grow with the quotient's exponent (up to about 2 microseconds).
 * - Angles are in radians; the rounding mode is the default one, to nearest.
 */
#ifndef TGM_MATH_H
#define TGM_MATH_H

#ifdef __cplusplus
extern "C" {
#endif
#if defined(__cplusplus) && !defined(_WIN32) /* as each platform's <math.h> declares them */
#define TGM_MATH_NOTHROW noexcept
#elif defined(__GNUC__)
#define TGM_MATH_NOTHROW __attribute__((__nothrow__))
#else
#define TGM_MATH_NOTHROW
#endif

#define TGM_PI      3.14159265358979323846
#define TGM_DEGREES (180.0 / TGM_PI) /* degrees in one radian: x * TGM_DEGREES is x in degrees */

/* Angles. asin: [-pi/2, pi/2], acos: [0, pi], atan: (-pi/2, pi/2), atan2(y, x): the angle of the
 * point (x, y) in [-pi, pi], right in all quadrants and for (0, 0), where it is 0. asin and acos of
 * |x| > 1 are NaN: clamp a quotient of measured values first. */
double sin(double x) TGM_MATH_NOTHROW;
double cos(double x) TGM_MATH_NOTHROW;
double tan(double x) TGM_MATH_NOTHROW;
double asin(double x) TGM_MATH_NOTHROW;
double acos(double x) TGM_MATH_NOTHROW;
double atan(double x) TGM_MATH_NOTHROW;
double atan2(double y, double x) TGM_MATH_NOTHROW;
/* Both at once, for the price of little more than one; compilers call it on their own, too. */
void sincos(double x, double *sine, double *cosine) TGM_MATH_NOTHROW;

double sinh(double x) TGM_MATH_NOTHROW;
double cosh(double x) TGM_MATH_NOTHROW;
double tanh(double x) TGM_MATH_NOTHROW;

/* Exponentials and logarithms. expm1(x) is exp(x) - 1 and log1p(x) is log(1 + x), both also accurate near
 * 0. pow(x, y): x < 0 needs a whole y, else NaN; pow(x, 0) is 1 for every x. */
double exp(double x) TGM_MATH_NOTHROW;
double exp2(double x) TGM_MATH_NOTHROW;
double expm1(double x) TGM_MATH_NOTHROW;
double log(double x) TGM_MATH_NOTHROW;
double(log2)(double x) TGM_MATH_NOTHROW; /* in parentheses: newlib's <math.h> has a macro of this name */
double log10(double x) TGM_MATH_NOTHROW;
double log1p(double x) TGM_MATH_NOTHROW;
double pow(double x, double y) TGM_MATH_NOTHROW;

/* Roots. sqrt is correctly rounded; hypot(x, y) is the length of (x, y) and neither overflows nor
 * underflows on the way; cbrt also takes negative numbers. */
double sqrt(double x) TGM_MATH_NOTHROW;
double cbrt(double x) TGM_MATH_NOTHROW;
double hypot(double x, double y) TGM_MATH_NOTHROW;

/* To whole numbers, exact. round: halves away from zero; rint: halves to even; trunc: towards zero.
 * lround and llround convert as round does; their result is unspecified when it does not fit (long
 * has 32 bits on Windows and Arm), so clamp first. */
double floor(double x) TGM_MATH_NOTHROW;
double ceil(double x) TGM_MATH_NOTHROW;
double round(double x) TGM_MATH_NOTHROW;
double trunc(double x) TGM_MATH_NOTHROW;
double rint(double x) TGM_MATH_NOTHROW;
long lround(double x) TGM_MATH_NOTHROW;
long long llround(double x) TGM_MATH_NOTHROW;

/* Remainders, exact. fmod has the sign of x and is smaller than |y| (a modulo axis: add y when it is
 * negative); remainder is in [-|y|/2, |y|/2] (the short way round). */
double fmod(double x, double y) TGM_MATH_NOTHROW;
double remainder(double x, double y) TGM_MATH_NOTHROW;

/* Parts and signs, exact. fmin and fmax prefer a number to a NaN. frexp: x = result * 2^*exponent with
 * result in [0.5, 1); modf: the fraction, its whole part in *whole; scalbn and ldexp: x * 2^n. */
double fabs(double x) TGM_MATH_NOTHROW;
double fmin(double x, double y) TGM_MATH_NOTHROW;
double fmax(double x, double y) TGM_MATH_NOTHROW;
double copysign(double size, double sign) TGM_MATH_NOTHROW;
double frexp(double x, int *exponent) TGM_MATH_NOTHROW;
double modf(double x, double *whole) TGM_MATH_NOTHROW;
double scalbn(double x, int n) TGM_MATH_NOTHROW;
double ldexp(double x, int n) TGM_MATH_NOTHROW;

/* x * y + z with one rounding, exact before it. In software where the processor cannot: slow. */
double fma(double x, double y, double z) TGM_MATH_NOTHROW;

#ifdef __cplusplus
}
#endif

#endif
