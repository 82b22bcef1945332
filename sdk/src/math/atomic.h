/* SPDX-License-Identifier: MIT */
/* atomic.h - the one function that musl's fma.c takes from its header of this name. */
#ifndef TGM_SRC_MATH_ATOMIC_H
#define TGM_SRC_MATH_ATOMIC_H

#include <stdint.h>

/* Zero bits above the highest set bit; value must not be 0. */
static inline int a_clz_64(uint64_t value)
{
    return __builtin_clzll(value);
}

#endif
