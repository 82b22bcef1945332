/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * sketch.h - the course of a run in few bytes: what the axes did, cycle by cycle, as least and
 * greatest value of each of at most SKETCH_BUCKETS stretches of equal length. No peak of a single
 * cycle is lost, however long the run.
 */
#ifndef HARNESS_HOST_SKETCH_H
#define HARNESS_HOST_SKETCH_H

#include <stdint.h>

#define SKETCH_AXES    4
#define SKETCH_BUCKETS 256

/* Of each axis, then of all. */
enum sketch_curve { SKETCH_POSITION, SKETCH_WRITE_POSITION, SKETCH_LAG, SKETCH_OF_AXIS };
#define SKETCH_INSTRUCTIONS (SKETCH_AXES * SKETCH_OF_AXIS) /* of the call of Program_04 */
#define SKETCH_CURVES       (SKETCH_INSTRUCTIONS + 1)

/* All zero: nothing yet. NaN: the curve has no value there. */
struct sketch {
    uint64_t cycles;          /* taken in */
    uint32_t per_bucket;      /* cycles in a full bucket, a power of two; 0: none yet */
    uint32_t used;            /* buckets with at least one cycle */
    float now[SKETCH_CURVES]; /* of the cycle that is not over yet; NaN: nothing noted */
    float least[SKETCH_CURVES][SKETCH_BUCKETS], greatest[SKETCH_CURVES][SKETCH_BUCKETS];
};

static inline unsigned sketch_of_axis(unsigned axis, enum sketch_curve curve)
{
    return axis * SKETCH_OF_AXIS + curve;
}

/* The curve's value in this cycle; the latest counts. */
void sketch_note(struct sketch *sketch, unsigned curve, double value);
/* The cycle is over. */
void sketch_cycle(struct sketch *sketch);

/* Makes what a worker wrote safe to read. */
void sketch_clean(struct sketch *sketch);

#endif
