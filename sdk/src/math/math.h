/* SPDX-License-Identifier: MIT */
/*
 * math.h - what musl's src/math sees in place of its own <math.h>: the SDK's declarations and what only an
 * implementation needs. musl's own header would bring types that are generated for each machine (and wrong on
 * 64-bit Windows, where long has 32 bits); here every width comes from the compiler. Not for authors:
 * they include <tgm/math.h>.
 */
#ifndef TGM_SRC_MATH_H
#define TGM_SRC_MATH_H

#include "../../include/tgm/math.h"

#include "features.h"

#if __FLT_EVAL_METHOD__ == 2
typedef long double float_t;
typedef long double double_t;
#else
typedef float float_t;
typedef double double_t;
#endif

#define NAN       __builtin_nanf("")
#define INFINITY  __builtin_inff()
#define isnan(x)    __builtin_isnan(x)
#define isinf(x)    __builtin_isinf(x)
#define isfinite(x) __builtin_isfinite(x)
#define signbit(x)  __builtin_signbit(x)

double remquo(double x, double y, int *quotient);
float remquof(float x, float y, int *quotient);
double scalbln(double x, long n);

#endif
