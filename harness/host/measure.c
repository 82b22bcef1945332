/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Registers of what took how long, on the real clock: TG Motion's own work, the period of the loop
 * and how late it began. (The module's functions are in statistics.c.) Maxima go on from what the
 * register holds, so that who writes 0 there begins them anew; for the minimum 0 is no value.
 */
#include "host/host_parts.h"

#define US 1000

static void highest(uint32_t *reg, uint64_t ns)
{
    const uint32_t us = (uint32_t)(ns / US);
    if (us > *reg)
        *reg = us;
}

/* Of the cycle that is over, and anew. */
static void take(uint64_t *measured_ns, uint32_t *reg, uint32_t *most)
{
    *reg = (uint32_t)(*measured_ns / US);
    highest(most, *measured_ns);
    *measured_ns = 0;
}

static void cycle(struct host *host)
{
    struct measured *measured = &host->measured;
    MAIN *m = &host->system->Main;
    if (host->real == NULL)
        return;
    m->Servo_CycleTime = (uint32_t)(measured->servo_last_ns / US);
    highest(&m->Servo_MaxCycle_Time, measured->servo_last_ns);
    highest(&m->Max_Timer_Latency, measured->latency_ns);
    take(&measured->bus_ns, &m->ECAT_ElapsedTime, &m->Max_ECAT_ElapsedTime);
    for (size_t i = 0; i < MEASURED_INTERPOLATORS; i++)
        take(&measured->interpolator_ns[i], &m->Interpolator_CycleTime[i],
             &m->Max_Interpolator_Cycle_Time[i]);
    if (measured->period_ns == 0)
        return;
    m->Act_Timer_CycleTime = (uint32_t)(measured->period_ns / US);
    highest(&m->Max_Timer_CycleTime, measured->period_ns);
    if (m->Min_Timer_CycleTime == 0 || m->Act_Timer_CycleTime < m->Min_Timer_CycleTime)
        m->Min_Timer_CycleTime = m->Act_Timer_CycleTime;
}

const struct host_part host_measure = { .name = "measure", .cycle = cycle };
