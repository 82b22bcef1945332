/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "osal.h"
#include "bus/fiber.h"
#include "bus/port/clock.h"

/* Any fixed moment will do for the start; it has to lie behind 2000-01-01, where distributed clocks
 * begin to count. This is 2025-01-01. */
enum { EPOCH_S = 1735689600, NS_PER_US = 1000, US_PER_S = 1000000 };

static _Thread_local struct bus_clock *current;

struct bus_clock *bus_clock_enter(struct bus_clock *clock)
{
    struct bus_clock *previous = current;

    current = clock;
    return previous;
}

void bus_clock_wait(struct bus_clock *clock, uint64_t until_ns)
{
    if (!clock->fiber || !fiber_inside(clock->fiber)) {
        bus_clock_reach(clock, until_ns);
        return;
    }
    clock->wake_ns = until_ns;
    do {
        fiber_yield(clock->fiber);
    } while (clock->now_ns < until_ns);
}

static ec_timet time_at(uint64_t us)
{
    ec_timet t = { (uint32)(EPOCH_S + us / US_PER_S), (uint32)(us % US_PER_S) };

    return t;
}

ec_timet osal_current_time(void)
{
    return time_at(current->now_ns / NS_PER_US);
}

int osal_usleep(uint32 usec)
{
    bus_clock_wait(current, current->now_ns + (uint64_t)usec * NS_PER_US);
    return 0;
}

void osal_timer_start(osal_timert *self, uint32 timeout_us)
{
    self->stop_time = time_at(current->now_ns / NS_PER_US + timeout_us);
}

boolean osal_timer_is_expired(osal_timert *self)
{
    ec_timet now = osal_current_time();

    if (now.sec != self->stop_time.sec)
        return now.sec > self->stop_time.sec;
    return now.usec >= self->stop_time.usec;
}
