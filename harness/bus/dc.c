/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    CRYSTAL_PPB = 20000,  /* slaves differ by up to this, either way */
    TRIM_PPB = 200000,    /* what the control loop may do to the clock */
    LOCK_IN_NS = 1000000, /* beyond this the loop only pulls at its limit */
    PULL_SHIFT = 12,      /* binary digits of the pull behind the point */
    SETTLE = 16,          /* comparisons in which a difference is worked off */
};

void dc_init(struct slave *slave, uint64_t seed)
{
    struct dc *dc = &slave->dc;

    memset(dc, 0, sizeof *dc);
    /* Every slave was switched on at another moment. Kept well below 2^31 ns: SOEM compares port
     * times as signed 32-bit numbers. */
    dc->anchor_local = (int64_t)(seed % 500000000u);
    dc->drift_ppb = (int64_t)((seed >> 32) % (2 * CRYSTAL_PPB + 1)) - CRYSTAL_PPB;
}

int64_t dc_local_time(const struct slave *slave)
{
    const struct dc *dc = &slave->dc;
    int64_t passed = (int64_t)(slave->frame_ns - dc->anchor_ns);

    return dc->anchor_local + passed + passed * (dc->drift_ppb + dc->trim_ppb) / 1000000000;
}

static int64_t system_time(const struct slave *slave)
{
    return dc_local_time(slave) + (int64_t)get_u64(slave->memory + REG_DC_OFFSET);
}

void dc_refresh(struct slave *slave, uint16_t address, size_t length)
{
    const struct dc *dc = &slave->dc;

    (void)length;
    if (address < REG_DC_RECEIVE_TIME) {
        put_u64(slave->memory + REG_DC_SYSTEM_TIME, (uint64_t)system_time(slave));
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
    put_u32(slave->memory + REG_DC_PORT_TIME, (uint32_t)local);
    if (slave->return_ns)
        put_u32(slave->memory + REG_DC_PORT_TIME + 4, (uint32_t)(local + slave->return_ns));
    put_u64(slave->memory + REG_DC_RECEIVE_TIME, (uint64_t)local);
    return true;
}

static void set_trim(struct slave *slave, int64_t local, int64_t trim)
{
    struct dc *dc = &slave->dc;

    dc->anchor_local = local;
    dc->anchor_ns = slave->frame_ns;
    dc->trim_ppb = trim;
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
    uint32_t system = (uint32_t)local + get_u32(slave->memory + REG_DC_OFFSET);
    int32_t difference = (int32_t)(system - delay - received);
    uint64_t passed = slave->frame_ns - dc->compared_ns;
    int64_t pull;

    dc->mean += (difference - dc->mean) >> (slave->memory[REG_DC_FILTER] & 0x0f);
    dc->compared_ns = slave->frame_ns;
    if (!passed)
        return;
    if (passed != dc->interval_ns) {
        dc->interval_ns = passed;
        dc->pull = ((int64_t)1000000000 << PULL_SHIFT) / (int64_t)(passed * SETTLE);
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
    put_u64(now, (uint64_t)system_time(slave));
    memcpy(now + offset, data, length);
    dc_follow(slave, get_u32(now));
    return true;
}

bool dc_write_speed(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    memcpy(slave->memory + address, data, length);
    slave->dc.mean = 0;
    slave->dc.integral_ppb = 0;
    set_trim(slave, dc_local_time(slave), 0);
    return true;
}
