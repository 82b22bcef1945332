/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Follows what changes in the memories from cycle to cycle (digest.h).
 *
 * A copy of each memory tells what has changed since the last look. The beginning of each memory is
 * looked at in every cycle, all of it now and then: a change far behind is seen a little late.
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OFTEN_BYTES = 16384, SELDOM_CYCLES = 64 };
#define MOST_BYTES ((size_t)4 << 20) /* what lies further behind is not looked at */

/* What a byte of an element belongs to. */
struct owner {
    uint16_t trail; /* of its line and 1, 0: nothing that a module may write */
    uint8_t size;   /* bytes of the register */
};

struct digester {
    struct digest_state now;
    uint32_t wanted;
    size_t lines;
    struct {
        char *copy;
        size_t size, stride;  /* bytes of the copy; of an element */
        struct owner *owners; /* by byte of an element; NULL: no structure */
    } memory[HOST_MEMORIES];
    const struct host *host; /* while lines are read */
};

static size_t index_of(const struct host *host, const struct catalogue_memory *memory)
{
    size_t i = 0;
    while (catalogue_memory(host->catalogue, i) != memory)
        i++;
    return i;
}

static void own(struct owner *owners, const struct catalogue_line *line, size_t dimension,
                size_t offset, uint16_t trail)
{
    if (dimension == line->array_count) {
        for (size_t i = 0; i < line->size; i++)
            owners[offset + i] = (struct owner){ trail, (uint8_t)scalar_size(line->type) };
        return;
    }
    for (size_t i = 0; i < line->arrays[dimension].count; i++)
        own(owners, line, dimension + 1, offset + i * line->arrays[dimension].stride, trail);
}

static void read_line(void *argument, const struct catalogue_line *line)
{
    struct digester *d = argument;
    const size_t number = d->lines++, memory = index_of(d->host, line->memory);
    if (number < DIGEST_TRAILS - DIGEST_MEMORIES && strchr(line->access, 'W') != NULL &&
        d->memory[memory].owners != NULL)
        own(d->memory[memory].owners, line, 0, line->offset, (uint16_t)(number + 1));
}

static int make_copies(struct host *host, struct digester *d)
{
    const struct catalogue_memory *memory;
    for (size_t i = 0; (memory = catalogue_memory(host->catalogue, i)) != NULL; i++) {
        const bool flat = strcmp(memory->type, "-") == 0;
        if (memory->pointer < 0)
            continue; /* no module reaches it */
        d->memory[i].size = host->memory_bytes[i] < MOST_BYTES ? host->memory_bytes[i] : MOST_BYTES;
        d->memory[i].stride = memory->size / memory->count;
        d->memory[i].copy = malloc(d->memory[i].size);
        if (!flat)
            d->memory[i].owners = calloc(d->memory[i].stride, sizeof(struct owner));
        if (d->memory[i].copy == NULL || (!flat && d->memory[i].owners == NULL))
            return -ENOMEM;
        memcpy(d->memory[i].copy, host->memory[i], d->memory[i].size);
    }
    return 0;
}

static int open_digest(struct host *host, char why[HOST_WHY])
{
    _Static_assert(HOST_MEMORIES == DIGEST_MEMORIES, "a digest has room for every memory");
    if (host->config.digest_cycles == 0)
        return 0;
    struct digester *d = calloc(1, sizeof *d);
    host->digester = d;
    if (d == NULL || make_copies(host, d) != 0) {
        snprintf(why, HOST_WHY, "no memory for a digest");
        return -ENOMEM;
    }
    d->wanted =
        host->config.digest_cycles < DIGEST_STATES ? host->config.digest_cycles : DIGEST_STATES;
    d->host = host;
    catalogue_walk(host->catalogue, read_line, d);
    return 0;
}

/* The registers in eight bytes that are not what they were. */
static void word_changed(struct host *host, size_t memory, size_t offset)
{
    struct digester *d = host->digester;
    struct digest *digest = &host->evidence->digest;
    const char *now = (const char *)host->memory[memory] + offset;
    char *before = d->memory[memory].copy + offset;
    for (size_t at = 0, size; at < 8; at += size) {
        struct owner owner = { (uint16_t)(DIGEST_TRAILS - DIGEST_MEMORIES + memory + 1), 8 };
        if (d->memory[memory].owners != NULL)
            owner = d->memory[memory].owners[(offset + at) % d->memory[memory].stride];
        size = owner.size != 0 && owner.size <= 8 - at ? owner.size : 1;
        if (owner.trail == 0 || memcmp(now + at, before + at, size) == 0)
            continue;
        uint64_t old = 0, new = 0;
        memcpy(&old, before + at, size);
        memcpy(&new, now + at, size);
        digest_change(digest, &d->now, owner.trail - 1u, digest_unit(memory, offset + at), old,
                      new);
    }
    memcpy(before, now, 8);
}

static void look(struct host *host, size_t memory, size_t size)
{
    const char *now = host->memory[memory], *before = host->digester->memory[memory].copy;
    enum { STEP = 512 };
    for (size_t at = 0; at < size; at += STEP) {
        const size_t step = size - at < STEP ? (size - at) & ~(size_t)7 : STEP;
        if (memcmp(now + at, before + at, step) == 0)
            continue;
        for (size_t word = at; word < at + step; word += 8)
            if (memcmp(now + word, before + word, 8) != 0)
                word_changed(host, memory, word);
    }
}

static void take(struct host *host, bool last)
{
    struct digester *d = host->digester;
    struct digest *digest = &host->evidence->digest;
    const bool all = last || digest->state_count % SELDOM_CYCLES == 0;
    for (size_t i = 0; i < HOST_MEMORIES; i++)
        if (d->memory[i].copy != NULL)
            look(host, i, all || d->memory[i].size < OFTEN_BYTES ? d->memory[i].size : OFTEN_BYTES);
    digest->states[digest->state_count++] = d->now;
    for (size_t i = 0; last && i < HOST_MEMORIES; i++)
        if (d->memory[i].copy != NULL)
            digest->memories[i] = digest_bytes(host->memory[i], d->memory[i].size);
}

/* While the PLC is loaded there is no such moment: those cycles have the state of the next one. */
static void cycle(struct host *host)
{
    const struct digester *d = host->digester;
    const struct digest *digest = &host->evidence->digest;
    if (d == NULL)
        return;
    while (digest->state_count < d->wanted && digest->state_count <= host->cycle)
        take(host, digest->state_count + 1 == d->wanted);
}

void digest_close(struct host *host)
{
    if (host->digester == NULL)
        return;
    for (size_t i = 0; i < HOST_MEMORIES; i++) {
        free(host->digester->memory[i].copy);
        free(host->digester->memory[i].owners);
    }
    free(host->digester);
    host->digester = NULL;
}

const struct host_part host_digest = { .name = "digest", .open = open_digest, .cycle = cycle };
