/* SPDX-License-Identifier: GPL-2.0-or-later */
/* SYNC0 and SYNC1: pulses at set system times of the slave's own clock. */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    CYCLIC = 1 << 0,
    SYNC0 = 1 << 1, /* and SYNC1 above it */
    AUTO_ACTIVATE = 1 << 3,
    EXTEND = 1 << 4, /* the start time was given with 32 bits */
    PLAUSIBILITY = 1 << 5,
    NEAR_FUTURE = 1 << 6, /* 2^31 ns instead of 2^63 */
    TEST_PULSE = 1 << 7,

    STATUS_IMPLAUSIBLE = 1 << 2,

    /* Nobody is told of pulses that come closer than this one by one. */
    CLOSEST_NS = 10000,
};

static uint64_t cycle0(const struct slave *slave)
{
    return get_u32(slave->memory + REG_DC_CYCLE0);
}

/* SYNC1 comes its own time after a SYNC0, and starts anew with the first SYNC0 after that. */
static uint64_t cycle1(const struct slave *slave)
{
    uint64_t shift = get_u32(slave->memory + REG_DC_CYCLE1);

    return cycle0(slave) ? (shift / cycle0(slave) + 1) * cycle0(slave) : 0;
}

static bool enabled(const struct slave *slave, unsigned signal)
{
    return slave->memory[REG_DC_ACTIVATION] & SYNC0 << signal;
}

static void pulse(struct slave *slave, unsigned signal)
{
    slave->sync.pending[signal] = false;
    if (slave->type->sync)
        slave->type->sync(slave->device, signal, slave->frame_ns);
    else if (get_u16(slave->memory + REG_DC_PULSE) == 0)
        slave->memory[REG_DC_SYNC_STATUS + signal] = 1; /* never acknowledged */
}

static void run_signal(struct slave *slave, unsigned signal, uint64_t cycle)
{
    uint64_t *next = &slave->sync.next[signal];
    uint64_t passed = dc_system_time(slave) - *next;

    if (*next == SLAVE_NEVER || (int64_t)passed < 0)
        return;
    *next = cycle ? *next + (passed / cycle + 1) * cycle : SLAVE_NEVER;
    if (enabled(slave, signal))
        pulse(slave, signal);
}

void sync_run(struct slave *slave)
{
    if (!slave->sync.running)
        return;
    run_signal(slave, 0, cycle0(slave));
    run_signal(slave, 1, cycle1(slave));
    sync_schedule(slave);
}

/* Pulses that nobody waits for are counted when somebody looks. */
void sync_schedule(struct slave *slave)
{
    struct dc_sync *sync = &slave->sync;

    sync->due_ns = SLAVE_NEVER;
    if (!sync->running || !slave->type->sync)
        return;
    for (unsigned signal = 0; signal < 2; signal++) {
        uint64_t due;

        if (sync->next[signal] == SLAVE_NEVER || !enabled(slave, signal))
            continue;
        due = dc_when(slave, sync->next[signal]);
        if (cycle0(slave) && cycle0(slave) < CLOSEST_NS && due < slave->frame_ns + CLOSEST_NS)
            due = slave->frame_ns + CLOSEST_NS;
        if (due <= slave->frame_ns)
            due = slave->frame_ns + 1;
        if (due < sync->due_ns)
            sync->due_ns = due;
    }
    if (sync->due_ns < slave->due_ns)
        slave->due_ns = sync->due_ns;
}

static uint64_t start_time(const struct slave *slave)
{
    uint64_t now = dc_system_time(slave), start = slave->sync.start;

    if (!(slave->memory[REG_DC_ACTIVATION] & EXTEND))
        return start;
    return now + (uint32_t)((uint32_t)start - (uint32_t)now);
}

/* A start time in the past is a start time in the far future: the counter has to come round. Only
 * the plausibility check starts at once instead. */
static void start(struct slave *slave)
{
    struct dc_sync *sync = &slave->sync;
    uint8_t activation = slave->memory[REG_DC_ACTIVATION];
    uint64_t now = dc_system_time(slave), first = start_time(slave), ahead = first - now;
    bool plausible = ahead < (activation & NEAR_FUTURE ? UINT64_C(1) << 31 : UINT64_C(1) << 63);

    slave->memory[REG_DC_ACTIVATION_STATUS] = plausible ? 0 : STATUS_IMPLAUSIBLE;
    if (!plausible && (activation & PLAUSIBILITY))
        first = now;
    sync->running = true;
    for (unsigned signal = 0; signal < 2; signal++) {
        sync->pending[signal] = enabled(slave, signal);
        sync->next[signal] = SLAVE_NEVER;
        slave->memory[REG_DC_SYNC_STATUS + signal] = 0;
    }
    if ((int64_t)(first - now) >= 0) {
        sync->next[0] = first;
        sync->next[1] = first + get_u32(slave->memory + REG_DC_CYCLE1);
    }
    sync_run(slave);
}

static void stop(struct slave *slave)
{
    struct dc_sync *sync = &slave->sync;

    sync->running = sync->pending[0] = sync->pending[1] = false;
    sync->next[0] = sync->next[1] = sync->due_ns = SLAVE_NEVER;
    slave->memory[REG_DC_ACTIVATION_STATUS] = 0;
}

void sync_reset(struct slave *slave)
{
    slave->sync.start = 0;
    stop(slave);
}

bool sync_write_activation(struct slave *slave, uint16_t address, const uint8_t *data,
                           size_t length)
{
    uint8_t *activation = slave->memory + address;

    (void)length;
    sync_run(slave);
    *activation = data[0] & (uint8_t)~TEST_PULSE;
    if (!(*activation & CYCLIC)) {
        stop(slave);
    } else if (!slave->sync.running) {
        start(slave);
    }
    for (unsigned signal = 0; signal < 2; signal++) {
        if ((data[0] & TEST_PULSE) && enabled(slave, signal))
            pulse(slave, signal);
    }
    sync_schedule(slave);
    return true;
}

bool sync_write_start(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    uint8_t *m = slave->memory, bytes[8];

    sync_run(slave);
    put_u64(bytes, slave->sync.start);
    memcpy(bytes + (address - REG_DC_START), data, length);
    slave->sync.start = get_u64(bytes);
    /* Complete with its last byte, or with the fourth where 32 bits do. */
    if ((m[REG_DC_ACTIVATION] & AUTO_ACTIVATE) && !slave->sync.running &&
        address + length >= REG_DC_START + (m[REG_DC_ACTIVATION] & EXTEND ? 4u : 8u)) {
        m[REG_DC_ACTIVATION] |= CYCLIC;
        start(slave);
    }
    return true;
}

bool sync_write_cycle(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    sync_run(slave);
    memcpy(slave->memory + address, data, length);
    sync_schedule(slave);
    return true;
}

/* While pulses run, their times are what is read where the start time was written. */
void sync_refresh(struct slave *slave, uint16_t address, size_t length)
{
    const struct dc_sync *sync = &slave->sync;
    uint8_t *status = slave->memory + REG_DC_ACTIVATION_STATUS;

    (void)address, (void)length;
    sync_run(slave);
    *status = (uint8_t)((*status & STATUS_IMPLAUSIBLE) | sync->pending[0] | sync->pending[1] << 1);
    put_u64(slave->memory + REG_DC_START,
            sync->next[0] != SLAVE_NEVER ? sync->next[0] : sync->start);
    if (sync->next[1] != SLAVE_NEVER)
        put_u64(slave->memory + REG_DC_NEXT1, sync->next[1]);
}
