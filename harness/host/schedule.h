/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * schedule.h - what happens when inside one Cycle_Time.
 *
 * The manual's timing charts (runtime.md 5.1) as data: one table per Cycle_Time, slots in time
 * order, the actions of a slot in the order of enum slot_action. TGMcontroller and TGZ+Motion have
 * tables of their own, which are ours (decision R5). Program_01..03 are not in the tables: on a PC
 * they get what is left of any slot, on the controllers they are called at ticks, by priority
 * (host.c).
 */
#ifndef HARNESS_HOST_SCHEDULE_H
#define HARNESS_HOST_SCHEDULE_H

#include <stddef.h>
#include <stdint.h>

#include "host/product.h"

/* In the order in which a slot carries them out. */
enum slot_action {
    SLOT_RECEIVE = 1, /* EtherCAT data of the previous send arrive; inputs are refreshed */
    SLOT_SEND = 2,    /* outputs are taken and sent to EtherCAT */
    SLOT_PROFILE = 4, /* profile generators of all servos */
    SLOT_PROGRAM_05 = 8,
    SLOT_PROGRAM_04 = 16,
    SLOT_OSCILLOSCOPE = 32
};

struct slot {
    uint32_t at_us;   /* from the start of the cycle */
    unsigned actions; /* enum slot_action, or-ed */
};

struct schedule {
    uint32_t cycle_us;
    uint32_t interpolator_us; /* step of the interpolators */
    size_t slot_count;
    const struct slot *slots;
};

/* Table for a Cycle_Time in microseconds, NULL when there is none. */
const struct schedule *schedule_find(enum schedule_kind kind, uint32_t cycle_us);

#define NEVER_DUE UINT64_MAX

/*
 * When a function that has just been called is due again, in ns since the first cycle: the first
 * multiple of its period after `ended_ns`, the time at which it returned; periods that went by in
 * the meantime are not made up for (R6). Where a product has ticks and less than its margin is left
 * until then, one tick later, so that lower functions get their turn (R5). Period 0: as fast as
 * possible, which is at every tick.
 */
uint64_t schedule_due(const struct product *product, uint32_t period_us, uint64_t ended_ns);

#endif
