/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/digest.h"

#include <stdio.h>
#include <string.h>

#include "bus/spread.h"
#include "host/evidence.h"

#define PRIME ((UINT64_C(1) << 61) - 1)

__extension__ typedef unsigned __int128 wide;

static uint64_t times(uint64_t a, uint64_t b)
{
    return (uint64_t)((wide)a * b % PRIME);
}

static uint64_t plus(uint64_t a, uint64_t b)
{
    return (a + b) % PRIME;
}

static uint64_t minus(uint64_t a, uint64_t b)
{
    return (a + PRIME - b) % PRIME;
}

/* By Fermat: a^(p-2). */
static uint64_t inverse(uint64_t a)
{
    uint64_t result = 1;
    for (uint64_t exponent = PRIME - 2; exponent != 0; exponent >>= 1) {
        if (exponent & 1)
            result = times(result, a);
        a = times(a, a);
    }
    return result;
}

static uint64_t hash(uint64_t unit, uint64_t value)
{
    return spread(spread(unit + SPREAD_STEP) ^ value) % PRIME;
}

void digest_change(struct digest *digest, struct digest_state *state, size_t trail, uint64_t unit,
                   uint64_t before, uint64_t after)
{
    const uint64_t step = minus(hash(unit, after), hash(unit, before));
    state->sum = plus(state->sum, step);
    state->where = plus(state->where, times(unit, step));
    digest->trails[trail] =
        spread(digest->trails[trail] ^ spread(unit + digest->state_count) ^ hash(unit, after));
}

uint64_t digest_bytes(const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t result = size, word;
    for (; size >= sizeof word; size -= sizeof word, bytes += sizeof word) {
        memcpy(&word, bytes, sizeof word);
        result = spread(result ^ word) + SPREAD_STEP;
    }
    for (; size > 0; size--)
        result = spread(result ^ *bytes++) + SPREAD_STEP;
    return result;
}

/* Finds lines by number and by place. */
struct search {
    size_t number; /* of the line that is visited */
    const struct digest *a, *b;
    struct digest_difference *out;
    const struct catalogue_memory *memory; /* NULL: no unit is known */
    size_t offset;
};

static void visit(void *argument, const struct catalogue_line *line)
{
    struct search *search = argument;
    const size_t number = search->number++;
    if (number < DIGEST_TRAILS - DIGEST_MEMORIES &&
        search->a->trails[number] != search->b->trails[number] && search->out->line_count++ == 0 &&
        search->memory == NULL)
        snprintf(search->out->name, sizeof search->out->name, "%s", line->name);
    if (search->memory == line->memory && catalogue_line_holds(line, search->offset))
        catalogue_line_name(line, search->offset, search->out->name, sizeof search->out->name);
}

/* The only unit that differs between two states, if it is only one. */
static bool single_unit(const struct catalogue *catalogue, const struct digest_state *a,
                        const struct digest_state *b, struct search *search)
{
    const uint64_t sum = minus(a->sum % PRIME, b->sum % PRIME);
    if (sum == 0)
        return false;
    const uint64_t unit = times(minus(a->where % PRIME, b->where % PRIME), inverse(sum));
    const size_t index = (size_t)(unit >> 32), offset = unit & UINT32_MAX;
    const struct catalogue_memory *memory = NULL;
    for (size_t i = 0; i <= index && index < DIGEST_MEMORIES; i++)
        if ((memory = catalogue_memory(catalogue, i)) == NULL)
            return false;
    if (memory == NULL)
        return false;
    search->memory = memory;
    search->offset = offset;
    return true;
}

static void name_flat(const struct catalogue *catalogue, const struct digest *a,
                      const struct digest *b, struct search *search)
{
    struct digest_difference *out = search->out;
    const struct catalogue_memory *memory = search->memory;
    if (memory != NULL && out->name[0] == '\0')
        snprintf(out->name, sizeof out->name, "byte %zu of %s", search->offset, memory->name);
    for (size_t i = 0; i < DIGEST_MEMORIES && (memory = catalogue_memory(catalogue, i)) != NULL;
         i++) {
        const size_t trail = DIGEST_TRAILS - DIGEST_MEMORIES + i;
        if (a->trails[trail] == b->trails[trail])
            continue;
        out->line_count++;
        if (out->name[0] == '\0')
            snprintf(out->name, sizeof out->name, "%s", memory->name);
    }
}

bool digest_differ(const struct catalogue *catalogue, const struct digest *a,
                   const struct digest *b, struct digest_difference *out)
{
    const uint32_t count = a->state_count < b->state_count ? a->state_count : b->state_count;
    const bool alike = a->state_count == b->state_count;
    struct search search = { .a = a, .b = b, .out = out };
    uint32_t n = 0;
    *out = (struct digest_difference){ .line_count = 0 };
    while (n < count && n < DIGEST_STATES && a->states[n].sum == b->states[n].sum &&
           a->states[n].where == b->states[n].where)
        n++;
    out->early = n < count;
    out->cycle = n == 0 ? EVIDENCE_NO_CYCLE : n - 1;
    if (out->early)
        out->exact = single_unit(catalogue, &a->states[n], &b->states[n], &search);
    if (out->early && alike) {
        catalogue_walk(catalogue, visit, &search);
        name_flat(catalogue, a, b, &search);
    }
    for (size_t i = 0; alike && i < DIGEST_MEMORIES && out->memory[0] == '\0'; i++)
        if (a->memories[i] != b->memories[i] && catalogue_memory(catalogue, i) != NULL)
            snprintf(out->memory, sizeof out->memory, "%s", catalogue_memory(catalogue, i)->name);
    return out->early || out->memory[0] != '\0';
}
