/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Whether what an interrupt led to is of one of the uninterrupted orders (races.h). */
#include <string.h>

#include "host/host_parts.h"

#define TOLD_OF_A_POINT 4 /* more than a few words of the same point tell nothing new */

struct place {
    bool there;
    size_t piece, word;
};

/* The first word of each owner that is of the one order only, and of the other. */
struct tally {
    struct place first[4], second[4];
    unsigned told;
};

static const char *word_of(const char *arena, size_t piece, size_t word)
{
    return arena + piece * RACES_PIECE + word * 4;
}

static struct evidence_word describe(const struct host *host, size_t piece, size_t word)
{
    const struct races *races = host->races;
    const struct races_order *order = &races->orders[races->by];
    const struct races_piece *at = &races->pieces[piece];
    const size_t even = word & ~(size_t)1;
    struct evidence_word out = { .memory = at->memory, .bit = word % 2 * 32 };
    if (at->memory >= 0)
        out.offset = (uint64_t)(at->at + even * 4 - (char *)host->memory[at->memory]);
    else
        machine_vaddr(host->machine, at->at + even * 4, &out.offset);
    memcpy(&out.first, word_of(order->first, piece, even), sizeof out.first);
    memcpy(&out.second, word_of(order->second, piece, even), sizeof out.second);
    memcpy(&out.found, at->at + even * 4, sizeof out.found);
    return out;
}

static bool same_word(const struct evidence_word *a, const struct evidence_word *b)
{
    return a->memory == b->memory && a->offset == b->offset;
}

static bool same_race(const struct evidence_race *a, const struct evidence_race *b)
{
    return a->kind == b->kind && a->entry == b->entry && a->by == b->by && a->failed == b->failed &&
           same_word(&a->words[0], &b->words[0]) && same_word(&a->words[1], &b->words[1]);
}

/* What an instruction reads or writes, as far as both functions use it. */
static bool touches(const struct races *races, const struct evidence_race *race,
                    const struct host *host, const struct code_operand *operand,
                    struct evidence_word *shared, bool *exact)
{
    const struct races_order *order = &races->orders[races->by];
    size_t piece, word;
    for (size_t offset = 0; offset < operand->size; offset += 4) {
        if (!races_word_at(races, operand->address + offset, &piece, &word))
            continue;
        const uint8_t owners = order->owners[piece * RACES_WORDS + word];
        const bool both =
            (owners & RACES_TOUCHED) != 0 && (operand->write || (owners & RACES_OF_ENTRY) != 0);
        *shared = describe(host, piece, word);
        *exact = same_word(shared, &race->words[0]) ||
                 (race->kind == RACE_MIXED && same_word(shared, &race->words[1]));
        if (both || *exact)
            return true;
    }
    return false;
}

/* Before each instruction of the interrupting function. The register itself is better than another
 * that both use. */
static uint64_t seek(void *argument, uint64_t pc, uint64_t instructions)
{
    struct host *host = argument;
    const struct races *races = host->races;
    struct evidence_race *race = races->seeking;
    struct code_operand operands[CODE_OPERANDS];
    struct evidence_word shared;
    bool exact;
    const unsigned count = machine_next_operands(host->machine, operands);
    for (unsigned i = 0; i < count; i++) {
        if (!touches(races, race, host, &operands[i], &shared, &exact) ||
            (race->has_by_pc && !exact))
            continue;
        race->has_by_pc = true;
        race->by_pc = pc;
        race->by_writes = operands[i].write;
        race->shared = shared;
        if (exact)
            return MACHINE_NEVER;
    }
    return instructions < 100000 ? 1 : MACHINE_NEVER;
}

static uint64_t mark(void *argument, uint64_t pc, uint64_t instructions)
{
    struct host *host = argument;
    const struct races *races = host->races;
    struct code_operand operands[CODE_OPERANDS];
    const unsigned count = machine_next_operands(host->machine, operands);
    (void)pc;
    for (unsigned i = 0; i < count; i++)
        for (size_t offset = 0; offset < operands[i].size; offset += 4) {
            size_t piece, word;
            if (races_word_at(races, operands[i].address + offset, &piece, &word))
                races->orders[races->by].owners[piece * RACES_WORDS + word] |= RACES_TOUCHED;
        }
    return instructions < 100000 ? 1 : MACHINE_NEVER;
}

/* Both functions once more, watched: what the interrupted one touches; then where the other does
 * so, in the state in which it interrupts. */
static void attribute(struct host *host, struct evidence_race *race)
{
    struct races *races = host->races;
    struct machine_outcome outcome;
    races->seeking = race;
    races_memory_of_start(races);
    machine_interrupt_next(host->machine, 0, mark, host);
    machine_call(host->machine, host->entry_address[races->entry],
                 host->plc_data_module[races->entry], &outcome);
    races->services = 0; /* the host is no more as it was in the middle */
    races_back_to_middle(host);
    machine_interrupt_next(host->machine, 0, seek, host);
    machine_call(host->machine, host->entry_address[races->by], host->plc_data_module[races->by],
                 &outcome);
}

static void record(struct host *host, struct evidence_race *race)
{
    struct races *races = host->races;
    race->entry = races->entry;
    race->by = races->by;
    race->cycle = host->evidence->cycle;
    race->pc = races->pc;
    race->instructions = races->instructions;
    race->count = 1;
    races->total++;
    for (unsigned i = 0; i < races->count; i++)
        if (same_race(&races->found[i], race)) {
            races->found[i].count++;
            return;
        }
    if (races->count == EVIDENCE_RACES)
        return;
    if (race->kind != RACE_FAILED)
        attribute(host, race);
    races->found[races->count++] = *race;
}

void races_failed(struct host *host, enum entry who, const struct machine_outcome *outcome)
{
    struct evidence_race race = {
        .kind = RACE_FAILED, .failed = who, .outcome = outcome->kind, .fault = outcome->fault
    };
    race.fault.service = NULL;
    record(host, &race);
}

static void look_at_word(struct host *host, size_t piece, size_t word, struct tally *tally,
                         struct evidence_race told[TOLD_OF_A_POINT])
{
    const struct races *races = host->races;
    const struct races_order *order = &races->orders[races->by];
    const char *found = races->pieces[piece].at + word * 4;
    const bool first = memcmp(found, word_of(order->first, piece, word), 4) == 0;
    const bool second = memcmp(found, word_of(order->second, piece, word), 4) == 0;
    const unsigned owners = order->owners[piece * RACES_WORDS + word] & 3;
    const bool own = races->pieces[piece].memory < 0;
    if (!first && !second && (!own || owners == 3) && tally->told < TOLD_OF_A_POINT)
        told[tally->told++] = (struct evidence_race){ .kind = RACE_NEITHER,
                                                      .words = { describe(host, piece, word) } };
    if (own || first == second)
        return;
    struct place *place = first ? &tally->first[owners] : &tally->second[owners];
    if (!place->there)
        *place = (struct place){ true, piece, word };
}

static void look_at_words(struct host *host, struct tally *tally,
                          struct evidence_race told[TOLD_OF_A_POINT])
{
    const struct races *races = host->races;
    for (size_t i = 0; i < races->touched_count; i++) {
        const struct races_piece *piece = &races->pieces[races->touched[i]];
        if (!piece->compared)
            continue;
        for (size_t word = 0; word < piece->size / 4; word++)
            look_at_word(host, races->touched[i], word, tally, told);
    }
    for (int owners = 0; owners < 4 && tally->told == 0; owners++) {
        const struct place *first = &tally->first[owners], *second = &tally->second[owners];
        if (first->there && second->there)
            told[tally->told++] =
                (struct evidence_race){ .kind = RACE_MIXED,
                                        .words = { describe(host, first->piece, first->word),
                                                   describe(host, second->piece, second->word) } };
    }
}

/* Bytes as they are after one of the orders. The module's own data and the shared memories are not
 * asked to be of the same. */
static bool is_of(const struct races *races, const char *arena, bool own)
{
    for (size_t i = 0; i < races->touched_count; i++) {
        const size_t number = races->touched[i];
        const struct races_piece *piece = &races->pieces[number];
        if (piece->compared && (piece->memory < 0) == own &&
            memcmp(piece->at, arena + number * RACES_PIECE, piece->size) != 0)
            return false;
    }
    return true;
}

void races_compare(struct host *host)
{
    const struct races *races = host->races;
    const struct races_order *order = &races->orders[races->by];
    struct evidence_race told[TOLD_OF_A_POINT];
    struct tally tally = { .told = 0 };
    if ((is_of(races, order->first, false) || is_of(races, order->second, false)) &&
        (is_of(races, order->first, true) || is_of(races, order->second, true)))
        return;
    look_at_words(host, &tally, told);
    for (unsigned i = 0; i < tally.told; i++)
        record(host, &told[i]);
}
