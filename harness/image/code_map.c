/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_map.c - open addressing. The keys are a module's choice, so each process salts the hash.
 */
#include "image/code_map.h"

#include <stdlib.h>

static size_t place_of(const struct code_map *map, uint64_t key)
{
    /* Where the slots lie is not the module's choice (ASLR), so it is salt enough. */
    uint64_t hash = (key ^ (uint64_t)(uintptr_t)map->slots) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
    hash *= 0xbf58476d1ce4e5b9u;
    return (size_t)(hash >> 20) & (map->room - 1);
}

/* The key's slot, or the free one where it would go. */
static struct code_map_slot *find(const struct code_map *map, uint64_t key)
{
    size_t place = place_of(map, key);
    while (map->slots[place].value != 0 && map->slots[place].key != key)
        place = (place + 1) & (map->room - 1);
    return &map->slots[place];
}

bool code_map_get(const struct code_map *map, uint64_t key, uint32_t *value)
{
    if (map->room == 0)
        return false;
    const struct code_map_slot *slot = find(map, key);
    if (slot->value == 0)
        return false;
    *value = slot->value - 1;
    return true;
}

static bool grow(struct code_map *map)
{
    struct code_map larger = { .room = map->room == 0 ? 64 : 2 * map->room, .count = map->count };
    larger.slots = calloc(larger.room, sizeof larger.slots[0]);
    if (larger.slots == NULL)
        return false;
    for (size_t i = 0; i < map->room; i++) {
        if (map->slots[i].value != 0)
            *find(&larger, map->slots[i].key) = map->slots[i];
    }
    free(map->slots);
    *map = larger;
    return true;
}

bool code_map_put(struct code_map *map, uint64_t key, uint32_t value)
{
    if (4 * map->count >= 3 * map->room && !grow(map))
        return false;
    *find(map, key) = (struct code_map_slot){ .key = key, .value = value + 1 };
    map->count++;
    return true;
}

void code_map_free(struct code_map *map)
{
    free(map->slots);
    *map = (struct code_map){ 0 };
}
