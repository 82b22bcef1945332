/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * clock.h - the virtual clock that SOEM lives by: it moves when SOEM sleeps, waits or exchanges a
 * frame, and never by itself.
 *
 * SOEM's osal_* functions take no context, so the clock they mean is the one the calling thread
 * has entered. Whoever calls into SOEM enters its own clock before and restores the previous one
 * afterwards.
 */
#ifndef HARNESS_BUS_PORT_CLOCK_H
#define HARNESS_BUS_PORT_CLOCK_H

#include <stdint.h>

struct bus_clock {
    uint64_t now_ns; /* since bus_open() */
};

/* Returns the clock entered before, to be given back to this function. */
struct bus_clock *bus_clock_enter(struct bus_clock *clock);

static inline void bus_clock_reach(struct bus_clock *clock, uint64_t now_ns)
{
    if (clock->now_ns < now_ns)
        clock->now_ns = now_ns;
}

#endif
