/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

static void publish(struct slave *slave, bool alive)
{
    slave->memory[REG_WD_STATUS] = alive;
}

void watchdog_configure(struct slave *slave)
{
    struct watchdog *wd = &slave->watchdog;
    uint64_t tick_ns = (get_u16(slave->memory + REG_WD_DIVIDER) + 2u) * 40u;

    wd->period_ns = get_u16(slave->memory + REG_WD_SM) * tick_ns;
    wd->running = false;
    wd->deadline_ns = SLAVE_NEVER;
    publish(slave, true);
}

bool watchdog_write_registers(struct slave *slave, uint16_t address, const uint8_t *data,
                              size_t length)
{
    memcpy(slave->memory + address, data, length);
    if (address == REG_WD_PDI)
        return true;
    watchdog_configure(slave);
    return true;
}

bool watchdog_clear_counters(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length)
{
    (void)address, (void)data, (void)length;
    memset(slave->memory + REG_WD_COUNT, 0, 2);
    return true;
}

void watchdog_run(struct slave *slave)
{
    struct watchdog *wd = &slave->watchdog;
    uint8_t *count = slave->memory + REG_WD_COUNT;

    if (!wd->running || slave->now_ns < wd->deadline_ns)
        return;
    wd->running = false;
    wd->deadline_ns = SLAVE_NEVER;
    publish(slave, false);
    if (*count < 0xff)
        ++*count;
    if (slave->state != AL_OP)
        return;
    if (slave->type->watchdog)
        slave->type->watchdog(slave->device, slave->now_ns);
    /* Terminals without a processor drop their outputs and stay in OP. */
    if (!slave->type->al_emulation)
        al_fall(slave, AL_SAFEOP, AL_CODE_WATCHDOG);
}
