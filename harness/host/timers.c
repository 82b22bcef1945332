/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Ticks and TIMERS: what counts by itself (decisions R7, R8). */
#include "host/host_parts.h"

/* One step each millisecond; up counts for ever, down stops at 0. */
static void step(TIMERS *timers)
{
    for (int i = 0; i < MAX_TIMER_UP; i++) {
        timers->Timer_Up[i]++;
        timers->Timer_Down[i] -= timers->Timer_Down[i] > 0;
    }
}

static int open_timers(struct host *host, char why[HOST_WHY])
{
    const uint32_t first = host->config.counters;
    (void)why;
    host->system->Header.Life_Tick = first;
    host->system->Main.Servo_Tick = first;
    for (int i = 0; i < MAX_TIMER_UP; i++)
        host->system->Timers.Timer_Up[i] = first;
    return 0;
}

static void cycle(struct host *host)
{
    host->system->Header.Life_Tick++;
    host->system->Main.Servo_Tick++;
    for (const uint64_t ms = host->now_ns / 1000000; host->timer_ms < ms; host->timer_ms++)
        step(&host->system->Timers);
}

const struct host_part host_timers = { .name = "timers", .open = open_timers, .cycle = cycle };
