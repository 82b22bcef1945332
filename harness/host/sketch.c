/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/sketch.h"

#include <math.h>

static void begin(struct sketch *sketch)
{
    sketch->per_bucket = 1;
    for (unsigned curve = 0; curve < SKETCH_CURVES; curve++)
        sketch->now[curve] = NAN;
}

void sketch_note(struct sketch *sketch, unsigned curve, double value)
{
    if (sketch->per_bucket == 0)
        begin(sketch);
    sketch->now[curve] = (float)value;
}

/* The other value where one is NaN, as fminf and fmaxf of the C library, which are calls. */
static float lesser(float a, float b)
{
    return b < a || a != a ? b : a;
}

static float larger(float a, float b)
{
    return b > a || a != a ? b : a;
}

static void halve(struct sketch *sketch)
{
    for (unsigned curve = 0; curve < SKETCH_CURVES; curve++) {
        float *least = sketch->least[curve], *greatest = sketch->greatest[curve];
        for (unsigned i = 0; i < SKETCH_BUCKETS / 2; i++) {
            least[i] = lesser(least[2 * i], least[2 * i + 1]);
            greatest[i] = larger(greatest[2 * i], greatest[2 * i + 1]);
        }
    }
    sketch->used = SKETCH_BUCKETS / 2;
    sketch->per_bucket *= 2;
}

static void next_bucket(struct sketch *sketch)
{
    if (sketch->used == SKETCH_BUCKETS)
        halve(sketch);
    for (unsigned curve = 0; curve < SKETCH_CURVES; curve++)
        sketch->least[curve][sketch->used] = sketch->greatest[curve][sketch->used] = NAN;
    sketch->used++;
}

void sketch_cycle(struct sketch *sketch)
{
    if (sketch->per_bucket == 0)
        begin(sketch);
    if (sketch->cycles % sketch->per_bucket == 0)
        next_bucket(sketch);
    const uint32_t last = sketch->used - 1;
    for (unsigned curve = 0; curve < SKETCH_CURVES; curve++) {
        const float value = isfinite(sketch->now[curve]) ? sketch->now[curve] : NAN;
        sketch->least[curve][last] = lesser(sketch->least[curve][last], value);
        sketch->greatest[curve][last] = larger(sketch->greatest[curve][last], value);
        sketch->now[curve] = NAN;
    }
    sketch->cycles++;
}

void sketch_clean(struct sketch *sketch)
{
    if (sketch->used > SKETCH_BUCKETS)
        sketch->used = SKETCH_BUCKETS;
    if (sketch->per_bucket == 0)
        sketch->used = 0;
}
