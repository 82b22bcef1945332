/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/stimulus.h"
#include "bus/spread.h"

#define ONE  ((int64_t)1 << 31) /* amplitude 1 of a signal */
#define TURN ((int64_t)1 << 32) /* one period */

static int64_t clamp(int64_t value, int64_t most)
{
    return value > most ? most : value < -most ? -most : value;
}

/* Place in the period, 0 to TURN - 1. */
static int64_t turn(const struct bus_stimulus *s, uint64_t now_ns)
{
    uint64_t at = (now_ns - s->phase_ns) % s->period_ns;
    int64_t place = (int64_t)((double)at / (double)s->period_ns * (double)TURN);

    return place < TURN ? place : TURN - 1;
}

static int64_t triangle(int64_t place)
{
    if (place < TURN / 4)
        return 2 * place;
    if (place < TURN / 4 * 3)
        return 2 * ONE - 2 * place;
    return 2 * place - 4 * ONE;
}

/* sin(pi/2 x) for x in -1..1 by an odd polynomial of degree 7: off by less than 2e-6. */
static int64_t sine(int64_t place)
{
    static const int64_t factor[] = { 3373247961, -1387043932, 170583153, -9304792 };
    int64_t x = triangle(place), square = x * x >> 31, sum = 0;

    for (int i = 3; i >= 0; i--)
        sum = (sum * square >> 31) + factor[i];
    return clamp(sum * x >> 31, ONE);
}

/* Of seed, channel and period: every period another number, and no state to keep. */
static int64_t noise(const struct bus_stimulus *s, uint64_t seed, uint64_t now_ns)
{
    uint64_t place = seed + SPREAD_STEP * ((now_ns - s->phase_ns) / s->period_ns + 1) +
                     0xd1b54a32d192ed03u * (s->bit + 1);

    return (int64_t)(spread(place) >> 32) - ONE;
}

static int64_t wave(const struct bus_stimulus *s, uint64_t seed, uint64_t now_ns)
{
    switch (s->kind) {
    case BUS_SQUARE:
        return (now_ns - s->phase_ns) % s->period_ns < s->period_ns / 2 ? ONE : -ONE;
    case BUS_TRIANGLE:
        return triangle(turn(s, now_ns));
    case BUS_RAMP:
        return turn(s, now_ns) - ONE;
    case BUS_SINE:
        return sine(turn(s, now_ns));
    case BUS_NOISE:
        return noise(s, seed, now_ns);
    case BUS_CONSTANT:
        break;
    }
    return 0;
}

int64_t stimulus_value(const struct bus_stimulus *stimulus, uint64_t seed, uint64_t now_ns)
{
    int64_t offset = clamp(stimulus->offset, ONE);

    if (stimulus->kind == BUS_CONSTANT)
        return now_ns >= stimulus->phase_ns ? offset : 0;
    if (now_ns < stimulus->phase_ns || !stimulus->period_ns)
        return offset;
    return offset + (clamp(stimulus->amplitude, ONE) * wave(stimulus, seed, now_ns) >> 31);
}

bool stimulus_high(const struct bus_stimulus *stimulus, uint64_t seed, uint64_t now_ns)
{
    if (now_ns < stimulus->phase_ns)
        return false;
    if (stimulus->kind == BUS_CONSTANT)
        return stimulus->offset != 0;
    return stimulus->period_ns && wave(stimulus, seed, now_ns) > 0;
}

uint64_t stimulus_next(const struct bus_stimulus *stimulus, uint64_t now_ns)
{
    uint64_t period = stimulus->period_ns, at;

    if (now_ns < stimulus->phase_ns)
        return stimulus->phase_ns;
    if (stimulus->kind == BUS_CONSTANT || !period)
        return STIMULUS_NEVER;
    at = (now_ns - stimulus->phase_ns) % period;
    if (stimulus->kind == BUS_SQUARE)
        return now_ns - at + (at < period / 2 ? period / 2 : period);
    if (stimulus->kind == BUS_NOISE)
        return now_ns - at + period;
    return now_ns + 1;
}
