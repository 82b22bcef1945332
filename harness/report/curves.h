/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * curves.h - a recording of any length, made short enough for a picture.
 *
 * Rows that lie close together share a bucket, of which first, last, least and greatest value are
 * kept: no peak of a single cycle is lost, however long the recording. When the buckets are used
 * up, every two become one.
 */
#ifndef HARNESS_REPORT_CURVES_H
#define HARNESS_REPORT_CURVES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A curve has at most four points a bucket. */
#define CURVES_BUCKETS 2048

struct curves;

/* NULL when there is no memory. */
struct curves *curves_new(size_t count);
void curves_free(struct curves *curves);

/* A time and a value for every curve; times do not descend. Values that are no finite numbers are
 * holes. */
void curves_add(struct curves *curves, const double *row);

uint64_t curves_rows(const struct curves *curves);
/* Times of the first and of the last row. */
double curves_begin(const struct curves *curves);
double curves_end(const struct curves *curves);

/* Least and greatest value; false when there is none. */
bool curves_range(const struct curves *curves, size_t curve, double *least, double *greatest);
/* It has values, and all of them are 0 or 1. */
bool curves_binary(const struct curves *curves, size_t curve);

/* A NaN is a hole. */
typedef void curves_visit(void *argument, double time, double value);
void curves_walk(const struct curves *curves, size_t curve, curves_visit *visit, void *argument);

#endif
