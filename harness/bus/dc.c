/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"
#include "bus/spread.h"

#include <string.h>

enum {
    CRYSTAL_PPB = 20000,  /* slaves differ by up to this, either way */
    TRIM_PPB = 200000,    /* what the control loop may do to the clock */
    LOCK_IN_NS = 1000000, /* beyond this the loop only pulls at its limit */
    PULL_SHIFT = 12,      /* binary digits of the pull behind the point */
    SETTLE = 16,          /* comparisons in which a difference is worked off */
    NS_PER_S = 1000000000,
    SLACK_NS = 2, /* rounding of a rate */
};

#define FAR_NS INT64_C(1000000000000)

void dc_init(struct slave *slave, uint64_t seed)
{
    struct dc *dc = &slave->dc;

    memset(dc, 0, sizeof *dc);
    /* Every slave was switched on at another moment. Kept well below 2^31 ns: SOEM compares port
     * times as signed 32-bit numbers. */
    dc->born_local = (int64_t)(seed % 500000000u);
    dc->drift_ppb = (int64_t)((seed >> 32) % (2 * CRYSTAL_PPB + 1)) - CRYSTAL_PPB;
    dc_power_on(slave);
}

void dc_power_on(struct slave *slave)
{
    struct dc *dc = &slave->dc;

    dc->anchor_ns = slave->frame_ns;
    dc->anchor_local = dc->born_local;
    dc->trim_ppb = dc->integral_ppb = dc->mean = 0;
    dc->compared_ns = 0;
}

/* Whole seconds apart, so that years do not overflow. */
static int64_t gained(int64_t passed, int64_t ppb)
{
    if (passed < NS_PER_S && passed >= 0)
        return passed * ppb / NS_PER_S;
    return passed / NS_PER_S * ppb + passed % NS_PER_S * ppb / NS_PER_S;
}

/* Against virtual time. */
static int64_t rate(const struct slave *slave)
{
    return slave->dc.drift_ppb + slave->dc.trim_ppb + slave->faults.drift_ppb;
}

int64_t dc_local_time(const struct slave *slave)
{
    const struct dc *dc = &slave->dc;
    int64_t passed = (int64_t)(slave->frame_ns - dc->anchor_ns);

    return dc->anchor_local + passed + gained(passed, rate(slave));
}

uint64_t dc_system_time(const struct slave *slave)
{
    return (uint64_t)dc_local_time(slave) + get_u64(slave->memory + REG_DC_OFFSET);
}

uint64_t dc_when(const struct slave *slave, uint64_t system_time)
{
    int64_t ahead = (int64_t)(system_time - dc_system_time(slave));

    if (ahead <= 0)
        return slave->frame_ns;
    /* Far ahead half the way will do. */
    if (ahead > FAR_NS)
        return slave->frame_ns + (uint64_t)ahead / 2;
    ahead -= gained(ahead, rate(slave));
    return slave->frame_ns + (uint64_t)(ahead > SLACK_NS ? ahead - SLACK_NS : 1);
}

void dc_refresh(struct slave *slave, uint16_t address, size_t length)
{
    const struct dc *dc = &slave->dc;

    (void)length;
    if (address < REG_DC_RECEIVE_TIME) {
        put_u64(slave->memory + REG_DC_SYSTEM_TIME, dc_system_time(slave));
        return;
    }
    /* Sign bit set: own copy behind the received time. */
    put_u32(slave->memory + REG_DC_DIFFERENCE,
            dc->mean < 0 ? 0x80000000u | (uint32_t)-dc->mean : (uint32_t)dc->mean);
}

bool dc_latch_ports(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    int64_t local = dc_local_time(slave);

    (void)data, (void)length;
    if (address != REG_DC_PORT_TIME)
        return false;
    /* A port that does not hear the frame keeps what it had. */
    if (slave->port[0].hears)
        put_u32(slave->memory + REG_DC_PORT_TIME, (uint32_t)local);
    if (slave->port[1].hears)
        put_u32(slave->memory + REG_DC_PORT_TIME + 4, (uint32_t)(local + slave->port1_ns));
    put_u64(slave->memory + REG_DC_RECEIVE_TIME, (uint64_t)local);
    return true;
}

static void set_trim(struct slave *slave, int64_t local, int64_t trim)
{
    struct dc *dc = &slave->dc;

    dc->anchor_local = local;
    dc->anchor_ns = slave->frame_ns;
    dc->trim_ppb = trim;
    sync_schedule(slave);
}

void dc_rebase(struct slave *slave)
{
    set_trim(slave, dc_local_time(slave), slave->dc.trim_ppb);
}

/* How far off a frame is stamped: the same at the same moment, so that runs repeat. */
static int64_t jitter(const struct slave *slave)
{
    int64_t most = slave->faults.jitter_ns;

    if (!most)
        return 0;
    return (int64_t)(spread(slave->frame_ns ^ slave->faults.jitter_seed) %
                     (2 * (uint64_t)most + 1)) -
           most;
}

static int64_t clamp(int64_t value, int64_t limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

/* Drift compensation: the received time is the reference clock's when the frame passed it. A
 * difference is worked off in SETTLE intervals like the last one. */
void dc_follow(struct slave *slave, uint32_t received)
{
    struct dc *dc = &slave->dc;
    int64_t local = dc_local_time(slave);
    uint32_t delay = get_u32(slave->memory + REG_DC_DELAY);
    uint32_t system = (uint32_t)(local + jitter(slave)) + get_u32(slave->memory + REG_DC_OFFSET);
    int32_t difference = (int32_t)(system - delay - received);
    uint64_t passed = slave->frame_ns - dc->compared_ns;
    int64_t pull;

    dc->mean += (difference - dc->mean) >> (slave->memory[REG_DC_FILTER] & 0x0f);
    dc->compared_ns = slave->frame_ns;
    if (!passed)
        return;
    if (passed > FAR_NS)
        passed = FAR_NS;
    if (passed != dc->interval_ns) {
        dc->interval_ns = passed;
        dc->pull = ((int64_t)NS_PER_S << PULL_SHIFT) / (int64_t)(passed * SETTLE);
    }
    if (difference > LOCK_IN_NS || difference < -LOCK_IN_NS) {
        set_trim(slave, local, difference > 0 ? -TRIM_PPB : TRIM_PPB);
        return;
    }
    pull = -(difference * dc->pull) >> PULL_SHIFT;
    dc->integral_ppb = clamp(dc->integral_ppb + pull / SETTLE, TRIM_PPB);
    set_trim(slave, local, clamp(dc->integral_ppb + pull, TRIM_PPB));
}

bool dc_write_time(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    uint8_t now[8];
    size_t offset = (size_t)(address - REG_DC_SYSTEM_TIME);

    if (offset >= 4)
        return true;
    put_u64(now, dc_system_time(slave));
    memcpy(now + offset, data, length);
    dc_follow(slave, get_u32(now));
    return true;
}

bool dc_write_offset(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    memcpy(slave->memory + address, data, length);
    sync_schedule(slave);
    return true;
}

/* The trim as the hardware counts it: one unit is 1 / (5 (start + 2)^2) of the clock. */
void dc_refresh_speed(struct slave *slave, uint16_t address, size_t length)
{
    int64_t start = get_u16(slave->memory + REG_DC_SPEED_START) + 2;

    (void)address, (void)length;
    put_u16(slave->memory + REG_DC_SPEED_DIFF,
            (uint16_t)(slave->dc.trim_ppb * 5 * start * start / NS_PER_S));
}

bool dc_write_speed(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    memcpy(slave->memory + address, data, length);
    slave->dc.mean = 0;
    slave->dc.integral_ppb = 0;
    set_trim(slave, dc_local_time(slave), 0);
    return true;
}
