/* SPDX-License-Identifier: GPL-2.0-or-later */
/* coverage.h - which bytes of a module's code a run executed, a bit a byte. */
#ifndef HARNESS_HOST_COVERAGE_H
#define HARNESS_HOST_COVERAGE_H

#include <stdint.h>

/* Bytes of a module that are followed: those of its lowest addresses. */
#define COVERAGE_MOST 524288

/* All zero: nothing is known (a native machine). */
struct coverage {
    uint64_t begin, size; /* module address of the first bit; number of bits */
    uint8_t bits[COVERAGE_MOST / 8];
};

/* From a machine's own bits, of the module addresses begin to end. */
void coverage_take(struct coverage *coverage, const uint8_t *bits, uint64_t begin, uint64_t end);
/* What either of them executed, in the first; of one and the same module. */
void coverage_add(struct coverage *all, const struct coverage *one);

/* Executed bytes of the `size` from the address on. */
uint64_t coverage_count(const struct coverage *coverage, uint64_t address, uint64_t size);
/* The first of them that was not executed; address + size when all were. */
uint64_t coverage_gap(const struct coverage *coverage, uint64_t address, uint64_t size);

/* Makes what a worker wrote safe to read. */
void coverage_clean(struct coverage *coverage);

#endif
