/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What TG Motion measures of itself and of its bus: cycle times, frames, clocks (R21).
 *
 * On the simulated clock the main loop has exactly its period and code takes no time: execution
 * times are 0, so that recordings are the same on every machine. Where calls are timed
 * (machine_timing), they are what the calls took. A maximum that somebody sets to 0 begins anew.
 */
#include "host/host_parts.h"

#define CLOCK_PERIOD_NS 10000000 /* how often the clock of one slave is looked at */
#define AL_STATE        0x0F
#define AL_ERROR        0x10
#define CLOCK_REGISTER  0x092C /* difference from the system time, sign and magnitude */

static void extreme(uint32_t *least, uint32_t *most, uint32_t value)
{
    if (*most < value)
        *most = value;
    if (least != NULL && (*least == 0 || *least > value))
        *least = value;
}

void statistics_call(struct host *host, enum entry entry, uint64_t elapsed_ns)
{
    MAIN *m = &host->system->Main;
    uint32_t *const rows[ENTRY_COUNT][2] = {
        [ENTRY_01] = { &m->PLC_CycleTime_Prg1, &m->PLC_MaxCycleTime_Prg1 },
        [ENTRY_02] = { &m->PLC_CycleTime_Prg2, &m->PLC_MaxCycleTime_Prg2 },
        [ENTRY_03] = { &m->PLC_CycleTime_Prg3, &m->PLC_MaxCycleTime_Prg3 },
        [ENTRY_04] = { &m->PLC_CycleTime_Prg4, &m->PLC_MaxCycleTime_Prg4 },
    };
    const uint32_t us = (uint32_t)((elapsed_ns + 500) / 1000);
    if (rows[entry][0] == NULL)
        return;
    *rows[entry][0] = us;
    extreme(NULL, rows[entry][1], us);
}

static void statistics_cycle(struct host *host)
{
    MAIN *m = &host->system->Main;
    if (host->cycle == 0)
        return;
    m->Act_Timer_CycleTime = host->config.cycle_us;
    extreme(&m->Min_Timer_CycleTime, &m->Max_Timer_CycleTime, host->config.cycle_us);
}

static void count_frames(struct host *host)
{
    const struct bus_statistics now = bus_statistics(host->bus);
    ECAT_DRIVER *driver = &host->system->Ecat_Driver[0];
    driver->nPacketsSent = (uint32_t)now.sent;
    driver->nPacketsRecv = (uint32_t)now.received;
    driver->errRcv = (uint32_t)(now.sent - now.received);
    host->system->Main.EthPacketErrorCounter = driver->errRcv;
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
    host->system->Main.EthNumberOfPackets = (uint32_t)(now.sent - host->frames_sent);
#endif
    host->frames_sent = now.sent;
    if (host->has_clock) {
        host->system->Main.MasterClock = (int64_t)host->now_ns;
        host->system->Main.ReferenceClock = now.reference_ns - host->reference_zero;
        host->system->Main.MasterClockToReferenceClockDifference =
            host->system->Main.MasterClock - host->system->Main.ReferenceClock;
    }
}

static void clock_store(struct host *host, size_t slave, uint32_t difference)
{
    uint32_t all = 0;
    host->clock_difference[slave] = difference;
    for (size_t i = 0; i < bus_slave_count(host->bus); i++)
        all |= host->clock_difference[i];
    host->system->Main.SystemTimeDifferenceSum = all;
    for (size_t i = 0; i < host->axis_count; i++)
        if (host->axes[i].slave == slave)
            host->axes[i].reg->SysTimeDifference = difference;
    for (size_t i = 0; i < host->terminal_count; i++)
        if (host->terminals[i].slave == slave)
            host->terminals[i].reg->SysTimeDifference = difference;
}

/* The slaves with a clock, one after the other. */
static void ask_clock(struct host *host)
{
    const size_t count = bus_slave_count(host->bus);
    struct bus_job *job = &host->clock_job;
    if (host->clock_asked && !job->done)
        return;
    if (host->clock_asked && job->result == 0)
        clock_store(host, job->slave,
                    ((uint32_t)job->data[0] | (uint32_t)job->data[1] << 8 |
                     (uint32_t)job->data[2] << 16 | (uint32_t)job->data[3] << 24) &
                        0x7FFFFFFFu);
    host->clock_asked = false;
    if (host->now_ns < host->clock_due_ns)
        return;
    host->clock_due_ns = host->now_ns + CLOCK_PERIOD_NS;
    for (size_t i = 0; i < count; i++) {
        host->clock_slave = (host->clock_slave + 1) % count;
        if (bus_slave(host->bus, host->clock_slave)->has_clock &&
            !bus_slave(host->bus, host->clock_slave)->lost)
            break;
    }
    *job = (struct bus_job){
        .kind = BUS_REGISTER_READ, .slave = host->clock_slave, .index = CLOCK_REGISTER, .size = 4
    };
    host->clock_asked = true;
    bus_job_start(host->bus, job);
}

static void say_states(struct host *host)
{
    for (size_t i = 0; i < bus_slave_count(host->bus); i++) {
        const struct bus_slave *slave = bus_slave(host->bus, i);
        const uint16_t before = host->said_state[i];
        if (slave->al_state == before)
            continue;
        host->said_state[i] = slave->al_state;
        const bool expected = (slave->al_state & AL_ERROR) == 0 &&
                              (slave->al_state & AL_STATE) >= (before & AL_STATE); /* upwards */
        console_log(host, expected ? TGM_LOG_ETHERCAT : TGM_LOG_ETHERCAT_STATUS, CONSOLE_SLAVES,
                    expected ? CONSOLE_INFO : CONSOLE_WARNING,
                    "slave %zu (%s): AL state 0x%02X, before 0x%02X, code 0x%04X", i + 1,
                    slave->name, slave->al_state, before, slave->al_code);
    }
}

static int statistics_open(struct host *host, char why[HOST_WHY])
{
    (void)why;
    for (size_t i = 0; host->bus != NULL && i < bus_slave_count(host->bus); i++)
        host->has_clock = host->has_clock || bus_slave(host->bus, i)->has_clock;
    if (host->bus != NULL) {
        const bool on = host->config.clock != CLOCK_OFF;
        host->system->Main.Distributed_Clock = on;
        host->system->Main.StateDistributedClock = !on ? 0 : host->has_clock ? 1 : -1;
    }
    return 0;
}

static void statistics_receive(struct host *host)
{
    if (host->bus == NULL)
        return;
    if (host->reference_zero == 0 && host->exchanged)
        host->reference_zero = bus_statistics(host->bus).reference_ns - (int64_t)host->now_ns;
    count_frames(host);
    say_states(host);
    if (host->has_clock && host->exchanged)
        ask_clock(host);
}

const struct host_part host_statistics = { .name = "statistics",
                                           .open = statistics_open,
                                           .cycle = statistics_cycle,
                                           .receive = statistics_receive };
