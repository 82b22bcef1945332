/* SPDX-License-Identifier: GPL-2.0-or-later */
/* See races.h: which calls are tried, in what order things are done. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/spread.h"
#include "host/host_parts.h"

#define DEFAULT_CALLS 100
#define FIRST_CALLS   8     /* all of them: much happens once */
#define EVERY_POINT   256   /* so far every instruction, then ever fewer */
#define STEPS_MOST    50000 /* instructions of a call that are stepped */
#define ATTEMPTS      3     /* for pages that are written now and then only */

static uint64_t draw(struct host *host, uint64_t below)
{
    return spread(host->config.seed + ++host->races->drawn * SPREAD_STEP) % below;
}

int races_open(struct host *host, char why[MACHINE_WHY])
{
    if (host->config.preempt.mode != PREEMPT_TRIED || !machine_rehearses(host->machine))
        return 0;
    host->races = calloc(1, sizeof *host->races);
    if (host->races == NULL || races_state_open(host) != 0) {
        snprintf(why, MACHINE_WHY, "no memory");
        return -ENOMEM;
    }
    return 0;
}

void races_close(struct host *host)
{
    if (host->races == NULL)
        return;
    races_state_close(host->races);
    free(host->races);
    host->races = NULL;
}

/* A call for no other purpose than to see what it does. */
static bool call(struct host *host, enum entry entry, struct machine_outcome *outcome)
{
    host->evidence->entry = entry;
    machine_call(host->machine, host->entry_address[entry], host->plc_data_module[entry], outcome);
    return outcome->kind == MACHINE_RETURNED;
}

static bool may_interrupt(const struct host *host, enum entry entry, enum entry by)
{
    return by > entry && host->entry_address[by] != 0 && !host->evidence->calls[by].disabled &&
           !sleep_is(host, by);
}

/* One order without interrupt; who writes what in it. */
static bool play_order(struct host *host, const enum entry turns[2], const uint8_t owners[2],
                       struct races_order *order, char *arena)
{
    struct races *races = host->races;
    struct machine_outcome outcome;
    bool returned = true;
    for (int turn = 0; turn < 2 && returned; turn++) {
        races_copy(races, races->middle);
        returned = call(host, turns[turn], &outcome);
        races_own(races, races->middle, order->owners, owners[turn]);
    }
    races_copy(races, arena);
    races_back_to_start(host);
    return returned;
}

static void play_orders(struct host *host, enum entry by)
{
    struct races *races = host->races;
    struct races_order *order = &races->orders[by];
    const enum entry turns[] = { races->entry, by, races->entry };
    static const uint8_t owners[] = { RACES_OF_ENTRY, RACES_OF_OTHER, RACES_OF_ENTRY };
    for (size_t i = 0; i < races->touched_count; i++)
        memset(order->owners + races->touched[i] * (size_t)RACES_WORDS, 0, RACES_WORDS);
    order->judged = play_order(host, turns, owners, order, order->first);
    order->judged = order->judged && play_order(host, turns + 1, owners + 1, order, order->second);
}

static uint64_t at_write(void *argument, uint64_t pc, uint64_t instructions)
{
    (void)pc;
    races_note_writes(argument);
    return instructions < STEPS_MOST ? 1 : MACHINE_NEVER;
}

/* Finds the pages that a function writes to, also those that it leaves as they were: what is not
 * among them is not looked at until the end. */
static bool rehearse(struct host *host, enum entry entry)
{
    struct machine_outcome outcome;
    const uint64_t services = machine_services(host->machine);
    machine_interrupt_next(host->machine, 0, at_write, host);
    const bool returns = call(host, entry, &outcome);
    /* And what host services wrote for it, or it did itself when it was not watched any more. */
    if (machine_services(host->machine) != services || !returns ||
        machine_instructions(host->machine) >= STEPS_MOST)
        races_find_touched(host->races);
    races_back_to_start(host);
    return returns;
}

static bool rehearse_all(struct host *host)
{
    const enum entry entry = host->races->entry;
    for (enum entry by = ENTRY_02; by < ENTRY_COUNT; by++)
        if (may_interrupt(host, entry, by))
            rehearse(host, by);
    return rehearse(host, entry);
}

static void try_one(struct host *host, enum entry by)
{
    struct races *races = host->races;
    struct machine_outcome outcome;
    races->by = by;
    if (!call(host, by, &outcome)) {
        races_failed(host, by, &outcome);
    } else {
        host->evidence->entry = races->entry;
        machine_rehearse(host->machine, &outcome);
        if (outcome.kind != MACHINE_RETURNED)
            races_failed(host, races->entry, &outcome);
        else
            races_compare(host);
    }
    races_back_to_middle(host);
    races->tried_points++;
}

static uint64_t at_point(void *argument, uint64_t pc, uint64_t instructions)
{
    struct host *host = argument;
    struct races *races = host->races;
    if (instructions >= STEPS_MOST)
        return MACHINE_NEVER;
    races->pc = pc;
    races->instructions = instructions;
    races_keep_middle(host);
    for (enum entry by = ENTRY_02; by < ENTRY_COUNT; by++)
        if (may_interrupt(host, races->entry, by) && races->orders[by].judged)
            try_one(host, by);
    return instructions < EVERY_POINT ? 1 : 1 + draw(host, instructions / (EVERY_POINT / 2));
}

/* False when some page was written that had not been seen: it was not put back in between. */
static bool try_points(struct host *host)
{
    struct races *races = host->races;
    const unsigned count = races->count;
    const uint64_t points = races->tried_points, total = races->total;
    struct machine_outcome outcome;
    for (enum entry by = ENTRY_02; by < ENTRY_COUNT; by++)
        if (may_interrupt(host, races->entry, by))
            play_orders(host, by);
    machine_interrupt_next(host->machine, 0, at_point, host);
    call(host, races->entry, &outcome);
    const bool all = !races_find_touched(races);
    races_back_to_start(host);
    if (!all) {
        races->count = count;
        races->tried_points = points;
        races->total = total;
    }
    return all;
}

static void tell(struct host *host)
{
    const struct races *races = host->races;
    struct evidence *evidence = host->evidence;
    evidence->tried_calls = races->tried_calls;
    evidence->tried_points = races->tried_points;
    evidence->race_total = races->total;
    evidence->race_count = races->count;
    memcpy(evidence->races, races->found, sizeof evidence->races);
}

/* The first ones; then, by chance, so that there are about as many as wanted in the end. */
static bool is_chosen(struct host *host, enum entry entry)
{
    struct races *races = host->races;
    const struct host_preempt *config = &host->config.preempt;
    const size_t number = entry - ENTRY_01;
    const uint64_t calls = config->calls != 0 ? config->calls : DEFAULT_CALLS;
    if (races->off[number] || host->preempt.interrupted != ENTRY_INI ||
        host->cycle < races->next_cycle[number])
        return false;
    if (++races->calls[number] >= FIRST_CALLS)
        races->next_cycle[number] = host->cycle + 1 + draw(host, 1 + 2 * config->at / calls);
    return true;
}

void races_try(struct host *host, enum entry entry)
{
    struct races *races = host->races;
    if (races == NULL || entry < ENTRY_01 || entry > ENTRY_03 || !is_chosen(host, entry))
        return;
    races->entry = entry;
    races->trying = true;
    races_keep_start(host);
    /* A function that does not return is another rule's matter. */
    races->off[entry - ENTRY_01] = !rehearse_all(host);
    bool all = races->off[entry - ENTRY_01];
    for (int i = 0; i < ATTEMPTS && !all; i++)
        all = try_points(host);
    races->trying = false;
    races->tried_calls++;
    host->evidence->entry = entry;
    tell(host);
}
