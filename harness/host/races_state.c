/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What module code may write, and copies of it (races.h). */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "host/host_parts.h"

#define OWN_RANGES   16
#define TOUCHED_LONG 64 /* pieces that are still worth being remembered for the next call */

static void add_range(struct races *races, char *at, size_t size, int memory, bool compared)
{
    if (races->range_count == RACES_RANGES)
        return;
    races->ranges[races->range_count++] =
        (struct races_range){ (uint64_t)at, size, races->piece_count };
    for (size_t offset = 0; offset < size; offset += RACES_PIECE) {
        const size_t rest = (size - offset) & ~(size_t)7;
        if (races->pieces != NULL)
            races->pieces[races->piece_count] =
                (struct races_piece){ .at = at + offset,
                                      .size = rest < RACES_PIECE ? rest : RACES_PIECE,
                                      .memory = memory,
                                      .compared = compared };
        races->piece_count++;
    }
}

/* The console writes TGM_ODS, in the order in which it is spoken to. */
static void add_ranges(const struct host *host, struct races *races)
{
    void *at;
    size_t size;
    races->piece_count = races->range_count = 0;
    for (int i = 0; i < HOST_MEMORIES && catalogue_memory(host->catalogue, (size_t)i) != NULL; i++)
        add_range(races, host->memory[i], host->memory_bytes[i], i,
                  strcmp(catalogue_memory(host->catalogue, (size_t)i)->name, "TGM_ODS") != 0);
    for (unsigned i = 0; i < OWN_RANGES && machine_own_data(host->machine, i, &at, &size); i++)
        add_range(races, at, size, -1, true);
}

static bool open_arenas(struct races *races)
{
    const size_t bytes = races->piece_count * RACES_PIECE;
    bool there = (races->start = calloc(1, bytes)) != NULL;
    there = (races->middle = calloc(1, bytes)) != NULL && there;
    for (int entry = ENTRY_02; entry < ENTRY_COUNT; entry++) {
        struct races_order *order = &races->orders[entry];
        there = (order->first = calloc(1, bytes)) != NULL && there;
        there = (order->second = calloc(1, bytes)) != NULL && there;
        there = (order->owners = calloc(races->piece_count, RACES_WORDS)) != NULL && there;
    }
    return there;
}

int races_state_open(struct host *host)
{
    struct races *races = host->races;
    add_ranges(host, races);
    races->pieces = calloc(races->piece_count, sizeof *races->pieces);
    if (races->pieces == NULL)
        return -ENOMEM;
    add_ranges(host, races);
    races->touched = calloc(races->piece_count, sizeof *races->touched);
    races->is_touched = calloc(races->piece_count, sizeof *races->is_touched);
    races->host_start = malloc(sizeof *host);
    races->host_middle = malloc(sizeof *host);
    races->evidence_start = malloc(sizeof *host->evidence);
    races->evidence_middle = malloc(sizeof *host->evidence);
    return open_arenas(races) && races->touched != NULL && races->is_touched != NULL &&
                   races->host_start != NULL && races->host_middle != NULL &&
                   races->evidence_start != NULL && races->evidence_middle != NULL
               ? 0
               : -ENOMEM;
}

void races_state_close(struct races *races)
{
    for (int entry = 0; entry < ENTRY_COUNT; entry++) {
        free(races->orders[entry].first);
        free(races->orders[entry].second);
        free(races->orders[entry].owners);
    }
    free(races->evidence_middle);
    free(races->evidence_start);
    free(races->host_middle);
    free(races->host_start);
    free(races->is_touched);
    free(races->touched);
    free(races->middle);
    free(races->start);
    free(races->pieces);
}

static void put_back(const struct races *races, const char *arena)
{
    for (size_t i = 0; i < races->touched_count; i++) {
        const struct races_piece *piece = &races->pieces[races->touched[i]];
        memcpy(piece->at, arena + races->touched[i] * (size_t)RACES_PIECE, piece->size);
    }
}

void races_copy(const struct races *races, char *arena)
{
    for (size_t i = 0; i < races->touched_count; i++) {
        const struct races_piece *piece = &races->pieces[races->touched[i]];
        memcpy(arena + races->touched[i] * (size_t)RACES_PIECE, piece->at, piece->size);
    }
}

void races_keep_start(struct host *host)
{
    struct races *races = host->races;
    for (size_t i = 0; i < races->piece_count; i++)
        memcpy(races->start + i * RACES_PIECE, races->pieces[i].at, races->pieces[i].size);
    if (races->touched_count > TOUCHED_LONG) {
        races->touched_count = 0;
        memset(races->is_touched, 0, races->piece_count);
    }
    *races->host_start = *host;
    *races->evidence_start = *host->evidence;
    *races->host_middle = *host;
    *races->evidence_middle = *host->evidence;
    races->services = machine_services(host->machine);
}

static bool served(const struct host *host)
{
    return machine_services(host->machine) != host->races->services;
}

void races_keep_middle(struct host *host)
{
    struct races *races = host->races;
    races_copy(races, races->middle);
    if (!served(host))
        return;
    *races->host_middle = *host;
    *races->evidence_middle = *host->evidence;
    races->services = machine_services(host->machine);
}

void races_memory_of_start(const struct races *races)
{
    put_back(races, races->start);
}

void races_back_to_start(struct host *host)
{
    struct races *races = host->races;
    put_back(races, races->start);
    *host = *races->host_start;
    *host->evidence = *races->evidence_start;
    *races->host_middle = *host;
    *races->evidence_middle = *host->evidence;
    races->services = machine_services(host->machine);
}

void races_back_to_middle(struct host *host)
{
    struct races *races = host->races;
    put_back(races, races->middle);
    if (!served(host))
        return;
    *host = *races->host_middle;
    *host->evidence = *races->evidence_middle;
    races->services = machine_services(host->machine);
}

static void touch(struct races *races, size_t piece)
{
    if (races->is_touched[piece])
        return;
    races->is_touched[piece] = true;
    races->touched[races->touched_count++] = (uint32_t)piece;
}

bool races_find_touched(struct races *races)
{
    const size_t before = races->touched_count;
    for (size_t i = 0; i < races->piece_count; i++) {
        const struct races_piece *piece = &races->pieces[i];
        if (!races->is_touched[i] &&
            memcmp(piece->at, races->start + i * RACES_PIECE, piece->size) != 0)
            touch(races, i);
    }
    return races->touched_count > before;
}

static bool piece_at(const struct races *races, uint64_t address, size_t *piece)
{
    for (size_t i = 0; i < races->range_count; i++) {
        const struct races_range *range = &races->ranges[i];
        if (address - range->at >= range->size)
            continue;
        *piece = range->first + (address - range->at) / RACES_PIECE;
        return true;
    }
    return false;
}

void races_note_writes(struct host *host)
{
    struct code_operand operands[CODE_OPERANDS];
    const unsigned count = machine_next_operands(host->machine, operands);
    size_t piece;
    for (unsigned i = 0; i < count; i++) {
        if (!operands[i].write)
            continue;
        if (piece_at(host->races, operands[i].address, &piece))
            touch(host->races, piece);
        if (piece_at(host->races, operands[i].address + operands[i].size - 1, &piece))
            touch(host->races, piece);
    }
}

void races_own(const struct races *races, const char *arena, uint8_t *owners, uint8_t owner)
{
    for (size_t i = 0; i < races->touched_count; i++) {
        const size_t number = races->touched[i];
        const struct races_piece *piece = &races->pieces[number];
        const char *before = arena + number * RACES_PIECE;
        if (memcmp(piece->at, before, piece->size) == 0)
            continue;
        for (size_t word = 0; word < piece->size / 4; word++)
            if (memcmp(piece->at + word * 4, before + word * 4, 4) != 0)
                owners[number * RACES_WORDS + word] |= owner;
    }
}

bool races_word_at(const struct races *races, uint64_t address, size_t *piece, size_t *word)
{
    if (!piece_at(races, address, piece) || !races->is_touched[*piece])
        return false;
    *word = (address - (uint64_t)races->pieces[*piece].at) / 4;
    return *word < races->pieces[*piece].size / 4;
}
