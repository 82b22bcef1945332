/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * census.h - what the code of a module consists of; private to stack.c and census*.c.
 *
 * The walks of stack.c end where the stack pointer is lost; this one goes on: it only asks where
 * control goes, and uses what those have learned of jumps through tables.
 */
#ifndef HARNESS_IMAGE_CENSUS_H
#define HARNESS_IMAGE_CENSUS_H

#include "image/code_map.h"
#include "image/image_private.h"

struct stack;

enum { CENSUS_SPECIALS = 256 };

/* Written by the child, untrusted in the parent. */
struct census {
    bool complete;
    uint64_t lost; /* when not complete */
    bool entry_idle;
    size_t special_count; /* at most CENSUS_SPECIALS */
    struct image_special specials[CENSUS_SPECIALS];
    struct image_user users[]; /* by import */
};

/* Instructions that control reaches, and by way of what. */
struct census_search {
    struct stack *stack;
    struct census *census;
    struct code_map seen; /* address << 1 | Thumb bit */
    uint64_t *waiting;    /* the same */
    size_t waiting_count;
    uint64_t *found; /* the same: all of them, in the order in which they were found */
    size_t found_count;
    uint64_t root;
    enum image_special_how how;
    bool exhausted;
};

/* census.c */
void census_take(struct stack *stack, const struct image_routine *routines, size_t count,
                 struct census *census);
void census_add(struct census *census, const struct image_special *special);

/* census_bytes.c: what reads like a system call where no instruction was found. */
void census_bytes(struct census_search *search);

/* census_users.c: who uses the imports, and whether an entry point does anything. */
void census_users(struct census_search *search);
bool census_is_idle(struct stack *stack, uint64_t vaddr);

#endif
