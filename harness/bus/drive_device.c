/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive_cruise.h"
#include "bus/drive_device.h"

#include <errno.h>
#include <stddef.h>
#include <string.h>

unsigned drive_object_axis(uint16_t index)
{
    return index >= 0x2000 ? (index & 0x0fffu) / 0x800u : 0;
}

uint16_t drive_object_base(uint16_t index)
{
    return (uint16_t)(index - 0x800u * drive_object_axis(index));
}

static void wake(struct drive_device *device)
{
    drive_rest_end(&device->rest, &device->axis[0]);
}

/* --- mapping and identity --- */

static void load_map(struct pdo_map *map, const struct sii_pdo *pdo)
{
    map->count = pdo->entry_count;
    for (unsigned i = 0; i < pdo->entry_count; i++)
        map->entry[i] = (uint32_t)pdo->entries[i].index << 16 |
                        (uint32_t)pdo->entries[i].subindex << 8 | pdo->entries[i].bits;
}

static void load_maps(struct pdo_map *maps, struct pdo_assign *assign, const struct sii_pdo *pdos,
                      unsigned count)
{
    *assign = (struct pdo_assign){ 0 };
    for (unsigned i = 0; i < count; i++) {
        load_map(&maps[i], &pdos[i]);
        if (pdos[i].sm != 0xff)
            assign->pdo[assign->count++] = pdos[i].index;
    }
}

/* What the dictionary says for itself before anybody has written to it. */
static void load_defaults(struct drive_device *device)
{
    const struct sii_info *sii = device->kind->sii;

    load_maps(device->rx, &device->assign[PDO_RX], sii->rx, sii->rx_count);
    load_maps(device->tx, &device->assign[PDO_TX], sii->tx, sii->tx_count);
    device->identity[0] = device->setup.identity.vendor;
    device->identity[1] = device->setup.identity.product;
    device->identity[2] = device->setup.identity.revision;
    device->identity[3] = device->setup.serial;
}

static void set_up_axis(struct drive_device *device, unsigned axis)
{
    /* Axes of one device stand at different places. */
    uint64_t seed = device->setup.seed + axis * 0x5bd1e995u;

    drive_init(&device->axis[axis], device->kind->model[axis], seed);
}

/* Objects of an axis that is not there show a fault for good. */
static void bury(struct drive_device *device)
{
    for (unsigned i = device->kind->axes; i < DRIVE_AXES && device->kind->model[i]; i++) {
        device->axis[i].machine.state = CIA402_FAULT;
        device->axis[i].stale = true;
        drive_publish(&device->axis[i]);
    }
}

void drive_device_init(void *device, const struct device_setup *setup)
{
    struct drive_device *d = device;

    d->setup = *setup;
    d->kind = setup->type->model;
    load_defaults(d);
    for (unsigned i = 0; i < DRIVE_AXES && d->kind->model[i]; i++)
        set_up_axis(d, i);
    bury(d);
}

void drive_device_power_on(void *device, uint64_t now_ns)
{
    struct drive_device *d = device;

    wake(d);
    load_defaults(d);
    memset(d->reported, 0, sizeof d->reported);
    for (unsigned i = 0; i < d->kind->axes; i++)
        drive_power_on(&d->axis[i], now_ns);
    bury(d);
}

/* --- errors --- */

static const struct {
    uint16_t first, last;
    uint8_t bits;
} register_rows[] = {
    { 0x2000, 0x2fff, 0x03 }, /* current */
    { 0x3000, 0x3fff, 0x05 }, /* voltage */
    { 0x4000, 0x4fff, 0x09 }, /* temperature */
    { 0x7500, 0x75ff, 0x11 }, /* communication */
    { 0x8100, 0x81ff, 0x11 }, /* communication */
    { 0x0001, 0xffff, 0x21 }, /* device profile */
};

static unsigned register_bits(uint16_t code)
{
    unsigned i = 0;

    while (code < register_rows[i].first || code > register_rows[i].last)
        i++;
    return register_rows[i].bits;
}

uint8_t drive_error_register(const struct drive_device *device)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < device->kind->axes; i++) {
        uint16_t code = device->axis[i].o.error_code;

        if (code)
            bits |= register_bits(code) | (i ? (unsigned)DRIVE_REGISTER_SECOND_AXIS : 0u);
    }
    return (uint8_t)bits;
}

uint32_t drive_history_entry(unsigned axis, uint16_t code)
{
    return (uint32_t)axis << 16 | code;
}

void drive_device_remember(struct drive_device *device, uint32_t entry)
{
    unsigned depth = device->kind->history;

    memmove(device->history + 1, device->history, (depth - 1) * sizeof *device->history);
    device->history[0] = entry;
    if (device->history_count < depth)
        device->history_count++;
}

static void note(struct drive_device *d, unsigned axis)
{
    const struct device_emergency *emergency = &d->setup.emergency;
    uint16_t code = d->axis[axis].o.error_code;
    uint8_t own[5] = { (uint8_t)axis };

    d->reported[axis] = code;
    d->error_register = d->kind->error_register(d);
    if (code)
        drive_device_remember(d, d->kind->history_entry(axis, code));
    if (emergency->send)
        emergency->send(emergency->to, code, d->error_register, own);
}

/* The axis whose news are the oldest, so that the order does not depend on how time was cut. */
static const struct drive *oldest_news(const struct drive_device *d)
{
    const struct drive *found = NULL;

    for (unsigned i = 0; i < d->kind->axes; i++) {
        const struct drive *axis = &d->axis[i];

        if (axis->o.error_code != d->reported[i] && (!found || axis->failed_ns < found->failed_ns))
            found = axis;
    }
    return found;
}

void drive_device_report(struct drive_device *device)
{
    const struct drive *axis;

    while ((axis = oldest_news(device)))
        note(device, (unsigned)(axis - device->axis));
}

int drive_device_fault(void *device, unsigned axis, uint16_t code, uint64_t now_ns)
{
    struct drive_device *d = device;

    (void)now_ns;
    if (axis >= d->kind->axes || !code)
        return -EINVAL;
    wake(d);
    drive_fault(&d->axis[axis], code);
    drive_device_report(d);
    return 0;
}

/* --- time and process data --- */

void drive_device_refresh(void *device)
{
    struct drive_device *d = device;

    wake(d);
    for (unsigned i = 0; i < d->kind->axes; i++)
        drive_publish(&d->axis[i]);
    d->error_register = d->kind->error_register(d);
}

/* Some master's mapping wants more than the default one has. */
static bool maps_rest(const struct drive_device *d)
{
    static const size_t rest[] = { offsetof(struct drive_device, axis[0].o.position_demand),
                                   offsetof(struct drive_device, axis[0].o.velocity_demand),
                                   offsetof(struct drive_device, axis[0].o.torque_actual) };
    const struct pdo_image *image = &d->image[PDO_TX];

    for (unsigned i = 0; i < image->count; i++) {
        for (size_t k = 0; k < sizeof rest / sizeof *rest; k++) {
            if (image->copy[i].object % sizeof(struct drive) == rest[k] &&
                image->copy[i].object < sizeof d->axis)
                return true;
        }
    }
    return false;
}

void drive_device_state(void *device, unsigned al_state, uint64_t now_ns)
{
    struct drive_device *d = device;

    (void)now_ns;
    wake(d);
    for (unsigned i = 0; i < d->kind->axes; i++)
        drive_al_state(&d->axis[i], al_state);
    d->maps_rest = maps_rest(d);
    d->cruises = d->kind->axes == 1 && drive_cruise_fits(&d->image[PDO_RX], &d->image[PDO_TX]);
    d->rest.allowed = d->cruises && d->setup.type->step == drive_device_step;
    drive_device_report(d);
}

static inline bool has_news(const struct drive_device *d)
{
    return d->axis[0].o.error_code != d->reported[0] || d->axis[1].o.error_code != d->reported[1];
}

void drive_device_step(void *device, uint64_t now_ns)
{
    struct drive_device *d = device;

    if (drive_rest_step(&d->rest, now_ns))
        return;
    if (d->cruises && drive_cruise_step(&d->axis[0], now_ns))
        return;
    for (unsigned i = 0; i < d->kind->axes; i++)
        drive_step(&d->axis[i], now_ns);
    if (has_news(d))
        drive_device_report(d);
}

void drive_device_step_four(void *const devices[4], const uint64_t now_ns[4])
{
    struct drive *axis[4];

    for (unsigned i = 0; i < 4; i++) {
        struct drive_device *d = devices[i];

        if (!d->cruises)
            return;
        axis[i] = &d->axis[0];
    }
    drive_cruise_step_four(axis, now_ns);
}

void drive_device_outputs(void *device, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct drive_device *d = device;

    (void)length; /* the sync manager has the length of the mapping since SAFEOP */
    if (drive_rest_outputs(&d->rest, data))
        return;
    wake(d);
    if (d->cruises && drive_cruise_outputs(&d->axis[0], data, now_ns)) {
        if (has_news(d))
            drive_device_report(d);
        return;
    }
    pdo_outputs_to_objects(d->kind->od, device, data);
    for (unsigned i = 0; i < d->kind->axes; i++)
        drive_command(&d->axis[i], now_ns);
    drive_device_report(d);
    drive_rest_begin(&d->rest, &d->axis[0], data);
}

void drive_device_inputs(void *device, uint8_t *data, size_t length)
{
    struct drive_device *d = device;

    (void)length;
    if (drive_rest_inputs(&d->rest, data))
        return;
    if (d->cruises && drive_cruise_inputs(&d->axis[0], data))
        return;
    for (unsigned i = 0; i < d->kind->axes; i++) {
        if (d->maps_rest)
            drive_publish(&d->axis[i]);
        else
            drive_publish_cyclic(&d->axis[i]);
    }
    pdo_objects_to_inputs(d->kind->od, device, data);
    drive_rest_note_inputs(&d->rest, data);
}

uint32_t drive_with_bit(uint32_t word, unsigned bit, bool value)
{
    return (word & ~(1u << bit)) | (uint32_t)value << bit;
}

/* The axis that has the channel, NULL when none has. */
static const struct drive *channel_axis(const struct drive_device *d, unsigned channel)
{
    unsigned bit = channel % DRIVE_INPUTS;

    if (channel / DRIVE_INPUTS >= d->kind->axes || (!(1u << bit & AXIS_SWITCHES) && bit < 16))
        return NULL;
    return &d->axis[channel / DRIVE_INPUTS];
}

int drive_device_set_input(void *device, unsigned channel, int64_t value)
{
    struct drive_device *d = device;
    unsigned bit = channel % DRIVE_INPUTS;
    struct drive *drive;
    struct axis *axis;

    if (!channel_axis(d, channel) || value < 0 || value > 1)
        return -EINVAL;
    wake(d);
    drive = &d->axis[channel / DRIVE_INPUTS];
    axis = &drive->axis;
    drive->stale = true;
    if (bit < 16) {
        axis->held_mask = (uint8_t)(axis->held_mask | 1u << bit);
        axis->held = (uint8_t)drive_with_bit(axis->held, bit, value);
        axis->switches = (uint8_t)drive_with_bit(axis->switches, bit, value);
    } else {
        drive->user_inputs = drive_with_bit(drive->user_inputs, bit, value);
    }
    return 0;
}

int drive_device_get_input(const void *device, unsigned channel, int64_t *value)
{
    const struct drive *drive = channel_axis(device, channel);

    if (!drive)
        return -EINVAL;
    *value = (drive->axis.switches | drive->user_inputs) >> channel % DRIVE_INPUTS & 1;
    return 0;
}

void drive_device_free_input(void *device, unsigned channel)
{
    struct drive_device *d = device;
    unsigned bit = channel % DRIVE_INPUTS;

    if (drive_device_set_input(device, channel, 0) || bit >= 16)
        return;
    d->axis[channel / DRIVE_INPUTS].axis.held_mask &= (uint8_t) ~(1u << bit);
    axis_look(&d->axis[channel / DRIVE_INPUTS].axis);
}

/* --- object dictionary --- */

/* Ranges beyond the type, on every axis. */
static const struct range {
    uint16_t index;
    uint8_t subindex;
    int64_t low, high;
} ranges[] = {
    { 0x1003, 0, 0, 0 },          { 0x2001, 0, 0, DRIVE_LIMIT_QUICK_STOP },
    { 0x605b, 0, 0, 1 },          { 0x605c, 0, 0, 1 },
    { 0x605e, 0, 0, 2 },          { 0x6072, 0, 0, 3000 },
    { 0x6083, 0, 1, UINT32_MAX }, { 0x6084, 0, 1, UINT32_MAX },
    { 0x6085, 0, 1, UINT32_MAX }, { 0x609a, 0, 1, UINT32_MAX },
    { 0x60c2, 1, 1, 255 },        { 0x60c2, 2, -6, -2 },
    { 0x60e0, 0, 0, 3000 },       { 0x60e1, 0, 0, 3000 },
};

static bool quick_stop_option(int64_t value)
{
    return (value >= 0 && value <= 2) || value == 5 || value == 6;
}

uint32_t drive_device_check(void *device, uint16_t index, uint8_t subindex, int64_t value)
{
    struct drive_device *d = device;
    const struct drive *drive = &d->axis[drive_object_axis(index)];
    uint16_t base = drive_object_base(index);

    /* What is about to be written may change what the axis does from here on. */
    wake(d);
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        const struct range *r = &ranges[i];

        if (r->index == base && r->subindex == subindex && (value < r->low || value > r->high))
            return SDO_RANGE;
    }
    if (base == 0x605a && !quick_stop_option(value))
        return SDO_RANGE;
    if (base == 0x6060 && value && !drive_mode_supported(drive, (int)value))
        return SDO_RANGE;
    if (base == 0x6098 && !drive_homing_supported((int)value))
        return SDO_RANGE;
    return SDO_OK;
}

/* A controlword or mode by SDO works like one by PDO; in OP the next process data overrules it. */
void drive_device_written(void *device, uint16_t index, uint8_t subindex)
{
    struct drive_device *d = device;
    unsigned axis = drive_object_axis(index);
    uint16_t base = drive_object_base(index);

    (void)subindex;
    if (axis >= d->kind->axes)
        return;
    if (base == 0x6040 || base == 0x6060)
        drive_command(&d->axis[axis], d->axis[axis].next_ns);
    else if (base == 0x607d || base == 0x6080)
        drive_limits(&d->axis[axis]);
    drive_device_report(d);
}
