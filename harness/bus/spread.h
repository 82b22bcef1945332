/* SPDX-License-Identifier: GPL-2.0-or-later */
/* spread.h - numbers that look random and are not: the output step of splitmix64. */
#ifndef HARNESS_BUS_SPREAD_H
#define HARNESS_BUS_SPREAD_H

#include <stdint.h>

#define SPREAD_STEP 0x9e3779b97f4a7c15u

/* Neighbouring numbers come out far apart, in all bits. */
static inline uint64_t spread(uint64_t z)
{
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* The next number of the sequence that *state stands in. */
static inline uint64_t spread_next(uint64_t *state)
{
    return spread(*state += SPREAD_STEP);
}

#endif
