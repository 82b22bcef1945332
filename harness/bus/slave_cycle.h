/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * slave_cycle.h - the steps of a slave that every cycle takes, inline: a buffered sync manager
 * written or read as a whole, its watchdog, the device's inputs. Used by the parts of the slave and
 * by plan.c, so that both ways through a slave are the same code.
 */
#ifndef HARNESS_BUS_SLAVE_CYCLE_H
#define HARNESS_BUS_SLAVE_CYCLE_H

#include "bus/slave_parts.h"

#include <string.h>

enum { SYNCMAN_NO_BUFFER = 3 };

/* Shows flags, fill state and latest buffer in the status register of sync manager n. */
static inline void syncman_publish(struct slave *slave, unsigned n, unsigned set, unsigned clear)
{
    const struct syncman *sm = &slave->sm[n];
    uint8_t *status = slave->memory + REG_SM + (size_t)n * SM_SIZE + SM_STATUS;
    unsigned value = *status & ~(unsigned)(SM_STATUS_FULL | SM_STATUS_BUFFER | SM_STATUS_READING |
                                           SM_STATUS_WRITING | clear);

    value |= set;
    if (sm->mailbox && sm->full)
        value |= SM_STATUS_FULL;
    if (sm->buffered)
        value |= (unsigned)sm->latest << 4;
    *status = (uint8_t)value;
}

/* The first of the three buffers that is neither the latest nor the other side's. */
static inline uint8_t syncman_free_buffer(const struct syncman *sm, uint8_t other)
{
    static const uint8_t first[4][4] = {
        { 1, 2, 1, 1 }, { 2, 0, 0, 0 }, { 1, 0, 0, 0 }, { 1, 0, 0, 0 }
    };

    return first[sm->latest][other];
}

static inline void watchdog_trigger(struct slave *slave)
{
    struct watchdog *wd = &slave->watchdog;

    if (!wd->period_ns)
        return;
    if (!wd->running) {
        wd->running = true;
        slave->memory[REG_WD_STATUS] = 1;
    }
    wd->deadline_ns = slave->now_ns + wd->period_ns;
    if (wd->deadline_ns < slave->due_ns)
        slave->due_ns = wd->deadline_ns;
}

/* The master has written the last byte of process data. */
static inline void syncman_written(struct slave *slave, unsigned n)
{
    struct syncman *sm = &slave->sm[n];

    if (sm->buffered) {
        sm->latest = sm->master_at;
        sm->master_at = syncman_free_buffer(sm, sm->device_at);
        syncman_publish(slave, n, SM_STATUS_WRITTEN, SM_STATUS_READ);
    }
    if (sm->watchdog)
        watchdog_trigger(slave);
    if ((int)n == slave->output_sm)
        slave->outputs_fresh = true;
}

/* The whole area of a usable process data sync manager at once. */
static inline bool syncman_read_whole(struct slave *slave, unsigned n, uint8_t *data)
{
    struct syncman *sm = &slave->sm[n];

    if (!sm->buffered) {
        memcpy(data, slave->memory + sm->start, sm->length);
        return true;
    }
    if (sm->latest == SYNCMAN_NO_BUFFER)
        return false;
    sm->master_at = sm->latest;
    sm->open = false;
    memcpy(data, slave->memory + sm->start + (size_t)sm->latest * sm->length, sm->length);
    syncman_publish(slave, n, SM_STATUS_READ, SM_STATUS_WRITTEN);
    return true;
}

/* The device's side of process data: the buffer to read from or to fill; done makes it the latest.
 */
static inline const uint8_t *syncman_device_read(struct slave *slave, unsigned n)
{
    struct syncman *sm = &slave->sm[n];

    if (!sm->buffered)
        return slave->memory + sm->start;
    sm->device_at = sm->latest == SYNCMAN_NO_BUFFER ? 0 : sm->latest;
    return slave->memory + sm->start + (size_t)sm->device_at * sm->length;
}

static inline uint8_t *syncman_device_fill(struct slave *slave, unsigned n)
{
    struct syncman *sm = &slave->sm[n];

    if (!sm->buffered)
        return slave->memory + sm->start;
    sm->device_at = syncman_free_buffer(sm, sm->open ? sm->master_at : SYNCMAN_NO_BUFFER);
    return slave->memory + sm->start + (size_t)sm->device_at * sm->length;
}

static inline void syncman_device_done(struct slave *slave, unsigned n)
{
    struct syncman *sm = &slave->sm[n];

    if (!sm->buffered)
        return;
    sm->latest = sm->device_at;
    syncman_publish(slave, n, SM_STATUS_WRITTEN, SM_STATUS_READ);
}

/* The device wants to know when its clock comes to certain times. */
static inline bool slave_awaits_pulse(const struct slave *slave)
{
    return slave->sync.running && slave->type->sync;
}

/* Time passes for the device. */
static inline void slave_pass(struct slave *slave, uint64_t now_ns)
{
    slave->now_ns = now_ns;
    if (slave->type->step)
        slave->type->step(slave->device, now_ns);
}

static inline void slave_publish_inputs(struct slave *slave)
{
    unsigned n = (unsigned)slave->input_sm;

    if (slave->input_sm < 0 || !slave->sm[n].enabled || !slave->sm[n].usable)
        return;
    /* A processor writes inputs from SAFEOP on; a plain digital port always shows its pins. */
    if (slave->state < AL_SAFEOP && !slave->type->al_emulation)
        return;
    slave->type->inputs(slave->device, syncman_device_fill(slave, n), slave->sm[n].length);
    syncman_device_done(slave, n);
}

#endif
