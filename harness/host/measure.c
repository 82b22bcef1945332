/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Registers of what took how long, on the real clock: execution times, the period of the loop and
 * how late it began. Maxima go on from what the register holds, so that who writes 0 there begins
 * them anew; for the minimum 0 is no value.
 */
#include "host/host_parts.h"

#define US 1000

static void highest(uint32_t *reg, uint64_t ns)
{
    const uint32_t us = (uint32_t)(ns / US);
    if (us > *reg)
        *reg = us;
}

static void programs(MAIN *m, const struct measured *measured)
{
    const struct {
        uint32_t *time, *most;
    } registers[] = {
        { &m->PLC_CycleTime_Prg1, &m->PLC_MaxCycleTime_Prg1 },
        { &m->PLC_CycleTime_Prg2, &m->PLC_MaxCycleTime_Prg2 },
        { &m->PLC_CycleTime_Prg3, &m->PLC_MaxCycleTime_Prg3 },
        { &m->PLC_CycleTime_Prg4, &m->PLC_MaxCycleTime_Prg4 },
    };
    for (size_t i = 0; i < sizeof registers / sizeof *registers; i++) {
        *registers[i].time = (uint32_t)(measured->program_ns[ENTRY_01 + i] / US);
        highest(registers[i].most, measured->program_ns[ENTRY_01 + i]);
    }
}

static void cycle(struct host *host)
{
    const struct measured *measured = &host->measured;
    MAIN *m = &host->system->Main;
    if (host->real == NULL)
        return;
    m->Servo_CycleTime = (uint32_t)(measured->servo_last_ns / US);
    highest(&m->Servo_MaxCycle_Time, measured->servo_last_ns);
    programs(m, measured);
    highest(&m->Max_Timer_Latency, measured->latency_ns);
    if (measured->period_ns == 0)
        return;
    m->Act_Timer_CycleTime = (uint32_t)(measured->period_ns / US);
    highest(&m->Max_Timer_CycleTime, measured->period_ns);
    if (m->Min_Timer_CycleTime == 0 || m->Act_Timer_CycleTime < m->Min_Timer_CycleTime)
        m->Min_Timer_CycleTime = m->Act_Timer_CycleTime;
}

const struct host_part host_measure = { .name = "measure", .cycle = cycle };
