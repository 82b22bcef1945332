/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <errno.h>
#include <string.h>

static int8_t sm_of_type(const struct sii_info *info, uint8_t type)
{
    for (unsigned n = 0; n < info->sm_count; n++) {
        if (info->sm[n].type == type)
            return (int8_t)n;
    }
    return -1;
}

static void take_identity(struct sii_info *sii, const struct bus_identity *identity)
{
    if (!identity)
        return;
    if (identity->vendor)
        sii->vendor = identity->vendor;
    if (identity->product)
        sii->product = identity->product;
    if (identity->revision)
        sii->revision = identity->revision;
}

static void send_emergency(void *to, uint16_t code, uint8_t error_register, const uint8_t own[5])
{
    mailbox_emergency(to, code, error_register, own);
}

static bool mailbox_fits(const struct sii_mailbox *m)
{
    if (!m->out_size && !m->in_size)
        return true;
    return m->out_size >= MAILBOX_MIN && m->out_size <= MAILBOX_MAX && m->in_size >= MAILBOX_MIN &&
           m->in_size <= MAILBOX_MAX;
}

int slave_init(struct slave *slave, const struct slave_setup *setup)
{
    const struct device_type *type = setup->type;
    struct device_setup device = { .type = type,
                                   .emergency = { send_emergency, slave },
                                   .seed = setup->seed,
                                   .serial = setup->serial,
                                   .stimuli = setup->stimuli,
                                   .stimulus_count = setup->stimulus_count,
                                   .alias = setup->alias };
    struct sii_info sii = *type->sii;

    take_identity(&sii, setup->identity);
    device.identity = (struct bus_identity){ sii.vendor, sii.product, sii.revision };
    memset(slave, 0, sizeof *slave);
    slave->type = type;
    slave->device = setup->device;
    slave->powered = true;
    slave->due_ns = SLAVE_NEVER;
    slave->state = AL_INIT;
    slave->output_sm = sm_of_type(type->sii, SII_SM_OUTPUTS);
    slave->input_sm = sm_of_type(type->sii, SII_SM_INPUTS);
    slave->logical_first = UINT32_MAX;
    if (!mailbox_fits(&type->sii->mailbox))
        return -EINVAL;
    if (!sii_build(&sii, setup->serial, setup->alias, slave->image))
        return -EINVAL;
    registers_reset(slave);
    sii_load(slave, true);
    dc_init(slave, setup->seed);
    if (type->od)
        od_reset(type->od, slave->device);
    if (type->init)
        type->init(slave->device, &device);
    return 0;
}

/* Everything the controller and its processor know is gone. */
static void forget(struct slave *slave)
{
    al_fall(slave, AL_INIT, AL_CODE_NONE);
    slave->sii_busy_until = 0;
    slave->outputs_fresh = false;
    slave_changed(slave);
    registers_reset(slave);
    if (slave->type->od)
        od_reset(slave->type->od, slave->device);
    if (slave->type->power_on)
        slave->type->power_on(slave->device, slave->now_ns);
}

void slave_power_on(struct slave *slave, uint64_t now_ns)
{
    slave_advance(slave, now_ns);
    slave->powered = true;
    forget(slave);
    sii_load(slave, true);
    dc_power_on(slave);
    slave->due_ns = SLAVE_NEVER;
}

void slave_power_off(struct slave *slave, uint64_t now_ns)
{
    slave_advance(slave, now_ns);
    slave->powered = false;
    forget(slave);
    memset(slave->memory + REG_RAM, 0, sizeof slave->memory - REG_RAM);
    slave->due_ns = SLAVE_NEVER;
}

static uint64_t earlier(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static void find_due(struct slave *slave)
{
    uint64_t due = SLAVE_NEVER;

    if (slave->al.pending || slave->al.wait_outputs)
        due = earlier(due, slave->al.due_ns);
    if (slave->mailbox.request)
        due = earlier(due, slave->mailbox.due_ns);
    if (slave->watchdog.running)
        due = earlier(due, slave->watchdog.deadline_ns);
    slave->due_ns = earlier(due, slave->sync.due_ns);
}

static void run_due(struct slave *slave)
{
    al_run(slave);
    if (slave->mailbox.request && slave->now_ns >= slave->mailbox.due_ns)
        mailbox_run(slave);
    watchdog_run(slave);
    if (slave->now_ns >= slave->sync.due_ns)
        sync_run(slave);
    find_due(slave);
}

void slave_advance(struct slave *slave, uint64_t now_ns)
{
    slave->behind = false;
    if (now_ns < slave->now_ns)
        return;
    /* Time passes for the device first, so that an event finds it as it is at that very moment. */
    while (slave->due_ns <= now_ns) {
        slave->frame_ns = slave->due_ns > slave->now_ns ? slave->due_ns : slave->now_ns;
        slave_pass(slave, slave->frame_ns);
        run_due(slave);
    }
    slave->frame_ns = now_ns;
    slave_pass(slave, now_ns);
    slave_publish_inputs(slave);
}

void slave_disturb(struct slave *slave, const struct slave_faults *faults)
{
    dc_rebase(slave);
    slave->faults = *faults;
    /* Pulses to come are expected at the new rate. */
    dc_rebase(slave);
}

bool slave_drop(struct slave *slave, unsigned state, uint16_t code)
{
    if (state > slave->state)
        return false;
    al_fall(slave, state, code);
    return true;
}

bool slave_expire(struct slave *slave)
{
    if (!slave->watchdog.running)
        return false;
    slave->watchdog.deadline_ns = slave->now_ns;
    watchdog_run(slave);
    return true;
}

void slave_settle(struct slave *slave)
{
    unsigned n = (unsigned)slave->output_sm;

    slave->unlocked = 0;
    if (!slave->outputs_fresh)
        return;
    slave->outputs_fresh = false;
    slave->al.outputs_seen |= slave->state >= AL_SAFEOP;
    if (slave->al.wait_outputs)
        run_due(slave);
    if (slave->state == AL_OP && slave->type->outputs)
        slave->type->outputs(slave->device, syncman_device_read(slave, n), slave->sm[n].length,
                             slave->now_ns);
}

bool slave_is_addressed(const struct slave *slave, uint16_t station)
{
    const uint8_t *m = slave->memory;

    return station == get_u16(m + REG_STATION_ADDRESS) ||
           ((m[REG_DL_CONTROL + 3] & DL_CONTROL_ALIAS) &&
            station == get_u16(m + REG_STATION_ALIAS));
}

/* The distributed clock runs by itself: its times interest only devices that wait for pulses. */
static bool needs_life(const struct slave *slave, uint16_t address, size_t length)
{
    return address < REG_DC_PORT_TIME || address + length > REG_DC_CUC || slave_awaits_pulse(slave);
}

/* One access is cut at the borders of the register file, of sync managers and of the memory. */
bool slave_read(struct slave *slave, uint16_t address, uint8_t *data, size_t length)
{
    uint32_t at = address, end = (uint32_t)(address + length);
    bool any = false;

    if (needs_life(slave, address, length))
        slave_catch_up(slave);
    while (at < end && at < SLAVE_MEMORY) {
        size_t n = (end < SLAVE_MEMORY ? end : SLAVE_MEMORY) - at;
        uint8_t *to = data + (at - address);
        struct syncman *sm = NULL;

        if (at < REG_DIGITAL_OUT)
            n = n < REG_DIGITAL_OUT - at ? n : REG_DIGITAL_OUT - at;
        else
            sm = syncman_at(slave, at, n, &n);
        if (!sm && at < REG_RAM)
            n = n < REG_RAM - at ? n : REG_RAM - at;
        if (sm) {
            any |= syncman_master_read(slave, sm, at, to, n);
        } else if (at < REG_RAM) {
            any |= registers_read(slave, at, to, n);
        } else {
            memcpy(to, slave->memory + at, n);
            any = true;
        }
        at += (uint32_t)n;
    }
    return any;
}

bool slave_write(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    uint32_t at = address, end = (uint32_t)(address + length);
    bool any = false;

    if (needs_life(slave, address, length))
        slave_catch_up(slave);
    while (at < end && at < SLAVE_MEMORY) {
        size_t n = (end < SLAVE_MEMORY ? end : SLAVE_MEMORY) - at;
        const uint8_t *from = data + (at - address);
        struct syncman *sm = NULL;

        if (at < REG_DIGITAL_OUT)
            n = n < REG_DIGITAL_OUT - at ? n : REG_DIGITAL_OUT - at;
        else
            sm = syncman_at(slave, at, n, &n);
        if (!sm && at < REG_RAM)
            n = n < REG_RAM - at ? n : REG_RAM - at;
        if (slave->protected && at >= REG_DIGITAL_OUT && !registers_writable(slave, at)) {
            at += (uint32_t)n;
            continue;
        }
        if (sm) {
            any |= syncman_master_write(slave, sm, at, from, n);
        } else if (at < REG_RAM) {
            any |= registers_write(slave, at, from, n);
        } else {
            memcpy(slave->memory + at, from, n);
            any = true;
        }
        at += (uint32_t)n;
    }
    return any;
}

unsigned slave_exchange(struct slave *slave, uint16_t address, uint8_t *data, size_t length)
{
    uint8_t old[2048];
    unsigned done = 0;

    if (length > sizeof old)
        return 0;
    memcpy(old, data, length);
    if (slave_read(slave, address, old, length))
        done |= 1;
    /* Reading and writing may be set apart by a fixed distance. */
    if (slave_write(slave, (uint16_t)(address + get_u16(slave->memory + REG_PHYSICAL_OFFSET)), data,
                    length))
        done |= 2;
    memcpy(data, old, length);
    return done;
}
