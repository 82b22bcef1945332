/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * gear_motion.h - the arithmetic behind SERVO.Gear, without registers: linear gear, ramps, cam
 * tables (docs/decisions.md, M4).
 */
#ifndef HARNESS_HOST_GEAR_MOTION_H
#define HARNESS_HOST_GEAR_MOTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* One servo tick of a ramp; a step that is not > 0 arrives at once. */
double gear_ramp(double value, double wanted, double step);

/*
 * Linear gear: position follows the way of the source, times in / out. While the ratio stays,
 * position is calculated from where it began to hold, so that rounding does not add up.
 */
struct gear_link {
    bool holds; /* the four below are valid */
    double in, out;
    double source, position; /* where the ratio began to hold */
    double last_source, last_position;
};

/* The position now; the first step after gear_link_set() moves nothing. A source that is no number,
 * or an `out` of 0, holds the position, and what the source goes meanwhile is lost. */
double gear_link_step(struct gear_link *link, double source, double in, double out);
void gear_link_set(struct gear_link *link, double position);

/*
 * A cam: `length` doubles from byte `line` of a memory on, at any alignment. Between the points it
 * is linear; after the last point comes the first again, `increment` higher, and so on turn by turn
 * (0: a cam that returns).
 */
struct cam {
    const void *memory;
    size_t size;
    uint32_t line, length;
    double increment;
};

/* The pointer in the table: 0 <= it < length, and whole turns. False when it is no number, or too
 * large to have a place in the table, or the table has no points. */
bool cam_pointer(double unwrapped, uint32_t length, double *pointer, double *turns);

/* False, and *value as it was, when the table does not lie in the memory or a value is no number.
 */
bool cam_value(const struct cam *cam, double pointer, double turns, double *value);

/* Writes a double at a byte of the memory; false, and nothing written, when it does not lie there.
 */
bool cam_output(void *memory, size_t size, uint32_t address, double value);

#endif
