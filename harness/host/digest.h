/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * digest.h - what two runs are compared by.
 *
 * A digest follows the registers that a module may write (W or RW in the catalogue, and all of the
 * memories without a structure) through a run, in a fixed number of bytes. It tells whether two
 * runs did the same; if not, in which cycle they first differed, and in which register.
 *
 * How: the state of a cycle is two sums over all units (a unit is a register, or 8 bytes of a
 * memory without structure), modulo the prime 2^61-1: of h(unit, value), and of unit * h(unit,
 * value). Where exactly one unit differs, the quotient of the differences of the two is the number
 * of that unit. When several do, the trails tell in which lines of the catalogue: a trail is a hash
 * over all changes of a line's registers.
 */
#ifndef HARNESS_HOST_DIGEST_H
#define HARNESS_HOST_DIGEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/catalogue.h"

#define DIGEST_STATES   4096
#define DIGEST_TRAILS   2048
#define DIGEST_MEMORIES 16

/* All units at one moment. */
struct digest_state {
    uint64_t sum, where;
};

struct digest {
    uint32_t state_count;                      /* taken; 0: no digest was asked for */
    struct digest_state states[DIGEST_STATES]; /* [n]: when cycle n began */
    uint64_t trails[DIGEST_TRAILS];     /* of line n of the catalogue; the last DIGEST_MEMORIES
                                           are of memories without structure */
    uint64_t memories[DIGEST_MEMORIES]; /* all bytes of each when the last state was taken */
};

/* A register of the memory at an index of the catalogue. */
static inline uint64_t digest_unit(size_t memory, size_t offset)
{
    return (uint64_t)memory << 32 | offset;
}

/* The unit's value, the low `size` bytes of it, was `before` and is `after`. */
void digest_change(struct digest *digest, struct digest_state *state, size_t trail, uint64_t unit,
                   uint64_t before, uint64_t after);
uint64_t digest_bytes(const void *data, size_t size);

/* In what two runs differ. */
struct digest_difference {
    bool early; /* they differ before the last state */
    uint64_t
        cycle; /* early: the first that left other values behind; EVIDENCE_NO_CYCLE: Program_Ini */
    char name[160]; /* a register, exactly ("SERVO[0].WritePosition") or as a line of the register
                       list
                       ("SERVO[n].WritePosition"); "" when none is known */
    bool exact;     /* it is the only one that differs in that cycle */
    size_t line_count; /* lines of the catalogue that differ at some time */
    char memory[32];   /* the first memory whose bytes differ at the end, "" when none does */
};

/* False when there is no difference; when a digest is missing or one is shorter, as far as both go.
 */
bool digest_differ(const struct catalogue *catalogue, const struct digest *a,
                   const struct digest *b, struct digest_difference *out);

#endif
