/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * schedule.h - what happens when inside one Cycle_Time.
 *
 * The manual's timing charts (runtime.md 5.1) as data: one table per Cycle_Time, slots in time
 * order, the actions of a slot in the order of enum slot_action. Program_01..03 are not in the
 * tables: they get what is left of any slot, by priority (host.c).
 */
#ifndef HARNESS_HOST_SCHEDULE_H
#define HARNESS_HOST_SCHEDULE_H

#include <stddef.h>
#include <stdint.h>

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
    size_t slot_count;
    const struct slot *slots;
};

/* Table for a Cycle_Time in microseconds, NULL when there is none. */
const struct schedule *schedule_find(uint32_t cycle_us);

#endif
