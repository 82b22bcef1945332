/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_map.h - from a 64-bit key to a number. Private to code*.c and stack*.c.
 */
#ifndef HARNESS_IMAGE_CODE_MAP_H
#define HARNESS_IMAGE_CODE_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* All zero is an empty one. */
struct code_map {
    struct code_map_slot {
        uint64_t key;
        uint32_t value; /* plus 1; 0: free */
    } * slots;
    size_t room, count; /* room: 0 or a power of two */
};

bool code_map_get(const struct code_map *map, uint64_t key, uint32_t *value);
/* The key must not be there yet. False when memory ran out. value < UINT32_MAX. */
bool code_map_put(struct code_map *map, uint64_t key, uint32_t value);
void code_map_free(struct code_map *map);

#endif
