/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Program_01 to Program_03 interrupted by what is above them.
 *
 * On the virtual clock at an instruction: a call takes as long as the slots that go by at that
 * place. On the real clock when the next slot is due. Program_04 and Program_05 run to completion.
 */
#include "bus/spread.h"
#include "host/host_parts.h"

#include <string.h>

/* A function of its own time that keeps running this long does not come back any more. */
#define REAL_HANG_NS UINT64_C(1000000000)

static bool is_background(enum entry entry)
{
    return entry == ENTRY_01 || entry == ENTRY_02 || entry == ENTRY_03;
}

static uint64_t draw(struct host *host, uint64_t below)
{
    return spread(host->config.seed + ++host->preempt.drawn * SPREAD_STEP) % below;
}

/* How many slots it is to the end of the next one in which Program_04 is called. */
static size_t slots_to_04(const struct host *host)
{
    const struct schedule *schedule = host->schedule;
    size_t count = 1;
    for (size_t i = host->slot; !(schedule->slots[i].actions & SLOT_PROGRAM_04); count++)
        i = (i + 1) % schedule->slot_count;
    return count;
}

static struct evidence_interrupt *record(struct host *host, uint64_t pc, uint64_t instructions)
{
    struct evidence *evidence = host->evidence;
    const uint64_t number = evidence->interrupt_count++;
    if (number >= EVIDENCE_INTERRUPTS)
        return NULL;
    struct evidence_interrupt *interrupt = &evidence->interrupts[number];
    *interrupt = (struct evidence_interrupt){
        .entry = evidence->entry, .cycle = evidence->cycle, .pc = pc, .instructions = instructions
    };
    return interrupt;
}

/* Slots go by, as many as are wanted, or as are due. */
static void let_by(struct host *host, size_t slots, uint64_t pc, uint64_t instructions)
{
    struct preempt *preempt = &host->preempt;
    struct evidence *evidence = host->evidence;
    const enum entry entry = evidence->entry, outer = preempt->interrupted;
    const unsigned called = preempt->called;
    struct evidence_interrupt *interrupt = record(host, pc, instructions);
    preempt->interrupted = entry;
    preempt->called = 0;
    if (host->real != NULL) {
        while (realtime_due(host->real, host_next_slot_ns(host)))
            host_slot(host);
    } else {
        while (slots-- > 0)
            host_slot(host);
    }
    if (interrupt != NULL)
        interrupt->by = preempt->called;
    preempt->called |= called;
    preempt->interrupted = outer;
    evidence->entry = entry;
    evidence->stage = EVIDENCE_CALLING;
}

static uint64_t at_instruction(void *argument, uint64_t pc, uint64_t instructions)
{
    struct host *host = argument;
    const uint64_t length = host->preempt.length[host->evidence->entry - ENTRY_01];
    if (host->config.preempt.mode == PREEMPT_AT) {
        let_by(host, slots_to_04(host), pc, instructions);
        return MACHINE_NEVER;
    }
    let_by(host, 1 + (size_t)draw(host, host->schedule->slot_count), pc, instructions);
    return draw(host, 2) == 0 ? MACHINE_NEVER : 1 + draw(host, length);
}

static uint64_t at_slot(void *argument, uint64_t pc, uint64_t instructions)
{
    struct host *host = argument;
    struct preempt *preempt = &host->preempt;
    const enum entry entry = host->evidence->entry;
    const size_t number = entry - ENTRY_01;
    const uint64_t begin = realtime_now(host->real);
    if (begin - preempt->begun_ns[number] - preempt->away_ns[number] > REAL_HANG_NS)
        return MACHINE_ABANDON;
    if (realtime_due(host->real, host_next_slot_ns(host)))
        let_by(host, 0, pc, instructions);
    preempt->away_ns[number] += realtime_now(host->real) - begin;
    realtime_alarm(host->real, host->machine, host_next_slot_ns(host));
    return MACHINE_NEVER;
}

static void plan_instruction(struct host *host, enum entry entry)
{
    const uint64_t length = host->preempt.length[entry - ENTRY_01];
    uint64_t after = host->config.preempt.at;
    if (host->config.preempt.mode == PREEMPT_SEEDED) /* the first call is measured */
        after = length > 0 ? draw(host, length) : MACHINE_NEVER / 2;
    machine_interrupt_next(host->machine, after, at_instruction, host);
}

void preempt_plan(struct host *host, enum entry entry)
{
    if (!is_background(entry))
        return;
    if (host->real != NULL) {
        host->preempt.begun_ns[entry - ENTRY_01] = realtime_now(host->real);
        host->preempt.away_ns[entry - ENTRY_01] = 0;
        machine_interrupt_next(host->machine, MACHINE_NEVER, at_slot, host);
        realtime_alarm(host->real, host->machine, host_next_slot_ns(host));
    } else if (host->config.preempt.mode == PREEMPT_SEEDED ||
               host->config.preempt.mode == PREEMPT_AT) {
        plan_instruction(host, entry);
    }
}

void preempt_plan_on(struct host *host, enum entry entry, uint64_t since_ns)
{
    if (host->real == NULL)
        return;
    host->preempt.away_ns[entry - ENTRY_01] += realtime_now(host->real) - since_ns;
    realtime_alarm(host->real, host->machine, host_next_slot_ns(host));
}

void preempt_done(struct host *host, enum entry entry)
{
    if (host->config.preempt.mode != PREEMPT_SEEDED || !is_background(entry))
        return;
    const uint64_t executed = machine_instructions(host->machine);
    uint64_t *length = &host->preempt.length[entry - ENTRY_01];
    if (executed > *length)
        *length = executed;
}
