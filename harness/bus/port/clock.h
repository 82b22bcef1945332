/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * clock.h - the virtual clock that SOEM lives by: it moves when SOEM sleeps, waits or exchanges a
 * frame, and never by itself. What waits on the bus's fiber does not move it: it yields, and is
 * resumed when the clock has come there.
 *
 * SOEM's osal_* functions take no context, so the clock they mean is the one the calling thread
 * has entered. Whoever calls into SOEM enters its own clock before and restores the previous one
 * afterwards.
 */
#ifndef HARNESS_BUS_PORT_CLOCK_H
#define HARNESS_BUS_PORT_CLOCK_H

#include <stdint.h>

#define BUS_CLOCK_NEVER UINT64_MAX

struct fiber;

struct bus_clock {
    uint64_t now_ns;     /* since bus_open() */
    struct fiber *fiber; /* NULL: nothing runs beside the caller */
    uint64_t wake_ns;    /* when the fiber wants to go on */
};

/* Returns the clock entered before, to be given back to this function. */
struct bus_clock *bus_clock_enter(struct bus_clock *clock);

/* For code that may run on the fiber: comes back when the clock has reached until_ns. */
void bus_clock_wait(struct bus_clock *clock, uint64_t until_ns);

static inline void bus_clock_reach(struct bus_clock *clock, uint64_t now_ns)
{
    if (clock->now_ns < now_ns)
        clock->now_ns = now_ns;
}

#endif
