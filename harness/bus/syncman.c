/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

static unsigned index_of(const struct slave *slave, const struct syncman *sm)
{
    return (unsigned)(sm - slave->sm);
}

static uint8_t *sm_registers(struct slave *slave, const struct syncman *sm)
{
    return slave->memory + REG_SM + (size_t)index_of(slave, sm) * SM_SIZE;
}

static void decode(struct slave *slave, struct syncman *sm)
{
    const uint8_t *r = sm_registers(slave, sm);
    uint8_t control = r[SM_CONTROL];

    sm->start = get_u16(r);
    sm->length = get_u16(r + SM_LENGTH);
    sm->enabled = (r[SM_ACTIVATE] & SM_ACTIVATE_ENABLE) && sm->length;
    sm->mailbox = (control & SM_CONTROL_MODE) == SM_CONTROL_MAILBOX;
    /* A length of one is plain memory: there is nothing to tear. */
    sm->buffered = (control & SM_CONTROL_MODE) == 0 && sm->length > 1;
    sm->master_writes = control & SM_CONTROL_WRITE;
    sm->watchdog = control & SM_CONTROL_WATCHDOG;
    sm->span = (uint16_t)(sm->buffered ? 3 * sm->length : sm->length);
    sm->usable =
        (sm->mailbox || (control & SM_CONTROL_MODE) == 0) &&
        (uint32_t)sm->start + (sm->buffered ? 3u * sm->length : sm->length) <= SLAVE_MEMORY &&
        sm->start >= REG_DIGITAL_OUT && !(r[SM_PDI_CONTROL] & SM_PDI_DEACTIVATE);
    sm->full = false;
    sm->open = false;
    sm->latest = SYNCMAN_NO_BUFFER;
    sm->master_at = 0;
    sm->device_at = 1;
    /* What came in before is no longer where it was. */
    if (sm - slave->sm == slave->output_sm)
        slave->outputs_fresh = false;
    syncman_publish(slave, index_of(slave, sm), 0, 0xff);
}

static void decode_written(struct slave *slave, unsigned n, const uint8_t *before)
{
    struct syncman *sm = &slave->sm[n];
    const uint8_t *r = slave->memory + REG_SM + (size_t)n * SM_SIZE;
    bool same = memcmp(before, r, SM_STATUS) == 0 &&
                ((before[SM_ACTIVATE] ^ r[SM_ACTIVATE]) & SM_ACTIVATE_ENABLE) == 0;

    /* Masters send an unchanged configuration again; that must not empty a running mailbox. */
    if (!same)
        decode(slave, sm);
    slave->sm_end = 0;
    for (unsigned i = 0; i < SLAVE_SMS; i++) {
        if (slave->sm[i].enabled)
            slave->sm_end = (uint8_t)(i + 1);
    }
    if (!same)
        al_check_running(slave);
    if (n == 1 && ((r[SM_ACTIVATE] ^ r[SM_PDI_CONTROL]) & SM_ACTIVATE_REPEAT))
        mailbox_repeat(slave);
}

/* Address, length and control count only together with the enable bit, and masters write all eight
 * bytes at once: taken as disable, set, enable. Status and PDI control belong to the slave. */
bool syncman_write_registers(struct slave *slave, uint16_t address, const uint8_t *data,
                             size_t length)
{
    bool any = false;

    for (unsigned n = 0; n < SLAVE_SMS; n++) {
        uint16_t base = (uint16_t)(REG_SM + n * SM_SIZE);
        uint8_t before[SM_SIZE];
        bool touched = false;

        memcpy(before, slave->memory + base, SM_SIZE);
        for (unsigned i = 0; i < SM_SIZE; i++) {
            unsigned at = base + i;

            if (i == SM_STATUS || i == SM_PDI_CONTROL || at < address || at >= address + length)
                continue;
            slave->memory[at] = data[at - address];
            touched = true;
        }
        if (touched)
            decode_written(slave, n, before);
        any |= touched;
    }
    return any;
}

struct syncman *syncman_at(struct slave *slave, uint32_t address, size_t limit, size_t *span)
{
    *span = limit;
    for (unsigned n = 0; n < slave->sm_end; n++) {
        struct syncman *sm = &slave->sm[n];

        if (!sm->enabled)
            continue;
        if (address >= sm->start && address < (uint32_t)sm->start + sm->span) {
            size_t visible = (size_t)sm->start + sm->length;
            size_t left = (address < visible ? visible : (size_t)sm->start + sm->span) - address;

            *span = left < limit ? left : limit;
            return sm;
        }
        if (address < sm->start && sm->start - address < *span)
            *span = sm->start - address;
    }
    return NULL;
}

/* Opening at the first byte, closing at the last, nothing in between: shared by both directions.
 * Returns where the access lands in memory, NULL when it is refused. */
static uint8_t *master_window(struct slave *slave, struct syncman *sm, uint32_t address,
                              size_t length)
{
    uint32_t offset = address - sm->start;

    if (!sm->usable || offset + length > sm->length)
        return NULL;
    if (!sm->mailbox && !sm->buffered)
        return slave->memory + address;
    if (offset == 0)
        sm->open = true;
    else if (!sm->open)
        return NULL;
    if (offset + length == sm->length)
        sm->open = false;
    else
        sm_registers(slave, sm)[SM_STATUS] |=
            sm->master_writes ? SM_STATUS_WRITING : SM_STATUS_READING;
    return slave->memory + address + (sm->buffered ? (size_t)sm->master_at * sm->length : 0);
}

bool syncman_master_read(struct slave *slave, struct syncman *sm, uint32_t address, uint8_t *data,
                         size_t length)
{
    bool last = address + length == (uint32_t)sm->start + sm->length;
    const uint8_t *from;

    if (sm->mailbox || sm->buffered) {
        if (sm->master_writes || (sm->mailbox && !sm->full))
            return false;
        if (sm->buffered && sm->latest == SYNCMAN_NO_BUFFER)
            return false;
        if (sm->buffered && address == sm->start)
            sm->master_at = sm->latest;
    }
    from = master_window(slave, sm, address, length);
    if (!from)
        return false;
    memcpy(data, from, length);
    if (!last)
        return true;
    if (sm->mailbox) {
        sm->full = false;
        syncman_publish(slave, index_of(slave, sm), SM_STATUS_READ, SM_STATUS_WRITTEN);
        mailbox_fetched(slave);
    } else if (sm->buffered) {
        syncman_publish(slave, index_of(slave, sm), SM_STATUS_READ, SM_STATUS_WRITTEN);
    }
    return true;
}

static void master_wrote(struct slave *slave, struct syncman *sm)
{
    if (sm->mailbox) {
        sm->full = true;
        syncman_publish(slave, index_of(slave, sm), SM_STATUS_WRITTEN, SM_STATUS_READ);
        mailbox_request(slave);
        return;
    }
    syncman_written(slave, index_of(slave, sm));
}

bool syncman_master_write(struct slave *slave, struct syncman *sm, uint32_t address,
                          const uint8_t *data, size_t length)
{
    uint8_t *to;

    if (!sm->master_writes || (sm->mailbox && sm->full))
        return false;
    to = master_window(slave, sm, address, length);
    if (!to)
        return false;
    memcpy(to, data, length);
    if (address + length == (uint32_t)sm->start + sm->length)
        master_wrote(slave, sm);
    return true;
}

uint8_t syncman_peek(const struct slave *slave, uint32_t address)
{
    for (unsigned n = 0; n < slave->sm_end; n++) {
        const struct syncman *sm = &slave->sm[n];

        if (sm->enabled && sm->buffered && address >= sm->start &&
            address < (uint32_t)sm->start + sm->length && sm->latest != SYNCMAN_NO_BUFFER)
            return slave->memory[address + (size_t)sm->latest * sm->length];
    }
    return address < SLAVE_MEMORY ? slave->memory[address] : 0;
}

bool syncman_device_take(struct slave *slave, unsigned n, uint8_t *data, size_t room, size_t *size)
{
    struct syncman *sm = &slave->sm[n];

    if (!sm->full || sm->length > room)
        return false;
    memcpy(data, slave->memory + sm->start, sm->length);
    *size = sm->length;
    sm->full = false;
    syncman_publish(slave, index_of(slave, sm), SM_STATUS_READ, SM_STATUS_WRITTEN);
    return true;
}

bool syncman_device_put(struct slave *slave, unsigned n, const uint8_t *data, size_t length)
{
    struct syncman *sm = &slave->sm[n];
    uint8_t *to = slave->memory + sm->start;

    if (!sm->enabled || !sm->usable || sm->full || length > sm->length)
        return false;
    memcpy(to, data, length);
    memset(to + length, 0, sm->length - length);
    sm->full = true;
    sm->open = false;
    syncman_publish(slave, index_of(slave, sm), SM_STATUS_WRITTEN, SM_STATUS_READ);
    return true;
}

void syncman_device_clear(struct slave *slave, unsigned n)
{
    struct syncman *sm = &slave->sm[n];

    sm->full = false;
    sm->open = false;
    syncman_publish(slave, index_of(slave, sm), 0, SM_STATUS_WRITTEN | SM_STATUS_READ);
}

void syncman_repeat_done(struct slave *slave)
{
    uint8_t *r = slave->memory + REG_SM + SM_SIZE;

    r[SM_PDI_CONTROL] =
        (uint8_t)((r[SM_PDI_CONTROL] & ~SM_PDI_REPEAT_ACK) | (r[SM_ACTIVATE] & SM_ACTIVATE_REPEAT));
}
