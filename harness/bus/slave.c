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

int slave_init(struct slave *slave, const struct slave_setup *setup)
{
    const struct device_type *type = setup->type;
    struct device_setup device = { .type = type,
                                   .seed = setup->seed,
                                   .serial = setup->serial,
                                   .stimuli = setup->stimuli,
                                   .stimulus_count = setup->stimulus_count };
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
    if (type->sii->mailbox.out_size > MAILBOX_MAX || type->sii->mailbox.in_size > MAILBOX_MAX)
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

void slave_power_on(struct slave *slave, uint64_t now_ns)
{
    al_fall(slave, AL_INIT, AL_CODE_NONE);
    slave->now_ns = now_ns;
    registers_reset(slave);
    sii_load(slave, true);
    if (slave->type->od)
        od_reset(slave->type->od, slave->device);
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
    slave->due_ns = due;
}

/* Time passes for the device first, so that an event finds it as it is at that very moment. */
static void pass(struct slave *slave, uint64_t now_ns)
{
    slave->now_ns = now_ns;
    if (slave->type->step)
        slave->type->step(slave->device, now_ns);
}

static void run_due(struct slave *slave)
{
    al_run(slave);
    if (slave->mailbox.request && slave->now_ns >= slave->mailbox.due_ns)
        mailbox_run(slave);
    watchdog_run(slave);
    find_due(slave);
}

static void publish_inputs(struct slave *slave)
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

void slave_advance(struct slave *slave, uint64_t now_ns)
{
    if (now_ns < slave->now_ns)
        return;
    while (slave->due_ns <= now_ns) {
        pass(slave, earlier(slave->due_ns > slave->now_ns ? slave->due_ns : slave->now_ns, now_ns));
        run_due(slave);
    }
    pass(slave, now_ns);
    publish_inputs(slave);
}

void slave_settle(struct slave *slave)
{
    unsigned n = (unsigned)slave->output_sm;

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

/* One access is cut at the borders of the register file, of sync managers and of the memory. */
bool slave_read(struct slave *slave, uint16_t address, uint8_t *data, size_t length)
{
    uint32_t at = address, end = (uint32_t)(address + length);
    bool any = false;

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
    if (slave_write(slave, address, data, length))
        done |= 2;
    memcpy(data, old, length);
    return done;
}
