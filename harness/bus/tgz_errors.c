/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Errors of the TGZ: bits, codes, history, and what stops an axis on the emergency ramp. */
#include "bus/tgz.h"

enum { ANY = 0x01, CURRENT = 0x02, VOLTAGE = 0x04, HEAT = 0x08, BUS = 0x10 };

/* By bit number. Bits 24 and 28..31 are reserved and share code 0x1000. */
static const struct {
    uint16_t code;
    uint8_t in_register; /* of 0x1001, beside "any" */
} errors[] = {
    [0] = { 0x3130, 0 },        /* mains phase */
    [1] = { 0x3100, 0 },        /* mains supply */
    [2] = { 0x8a00, 0 },        /* internal */
    [3] = { 0x3110, VOLTAGE },  /* over-voltage */
    [4] = { 0x3120, VOLTAGE },  /* under-voltage */
    [5] = { 0x5430, 0 },        /* STO */
    [6] = { 0x7110, 0 },        /* holding brake */
    [7] = { 0x7111, 0 },        /* brake switch */
    [8] = { 0x2300, CURRENT },  /* current measurement */
    [9] = { 0x4310, HEAT },     /* motor thermostat */
    [10] = { 0x4110, 0 },       /* ambient temperature */
    [11] = { 0x4210, HEAT },    /* heat sink */
    [12] = { 0x7303, BUS },     /* feedback */
    [13] = { 0x7122, 0 },       /* commutation */
    [14] = { 0x8400, 0 },       /* over speed */
    [15] = { 0x8612, 0 },       /* following error */
    [16] = { 0x8611, 0 },       /* trajectory */
    [17] = { 0x8100, BUS },     /* host communication */
    [18] = { 0x8600, 0 },       /* drive ramp */
    [19] = { 0x2200, CURRENT }, /* current regulation */
    [20] = { 0xf001, 0 },       /* emergency stop */
    [21] = { 0x5110, CURRENT }, /* IGBT driver supply */
    [22] = { 0x7113, 0 },       /* brake resistor */
    [23] = { 0x5112, 0 },       /* 24 V brake supply */
    [24] = { 0x1000, 0 },       /* reserved */
    [25] = { 0x8310, 0 },       /* I2t */
    [26] = { 0x4311, 0 },       /* motor temperature */
    [27] = { 0x6320, 0 },       /* motor parameter */
};

enum { ERRORS = sizeof errors / sizeof *errors };

int tgz_error_bit(uint16_t code)
{
    for (int bit = 0; bit < ERRORS; bit++) {
        if (errors[bit].code == code)
            return bit;
    }
    return -1;
}

static uint32_t bit_of(uint16_t code)
{
    int bit = tgz_error_bit(code);

    return code && bit >= 0 ? 1u << bit : 0;
}

uint8_t tgz_error_register(const struct drive_device *device)
{
    const struct tgz_device *tgz = (const struct tgz_device *)device;
    unsigned value = 0;

    for (unsigned i = 0; i < device->kind->axes; i++) {
        uint32_t bits = tgz->reg[i].errors | bit_of(device->axis[i].o.error_code);

        for (unsigned bit = 0; bit < ERRORS; bit++) {
            if (bits >> bit & 1)
                value |= ANY | errors[bit].in_register;
        }
        if (bits && i)
            value |= DRIVE_REGISTER_SECOND_AXIS;
    }
    return (uint8_t)value;
}

uint32_t tgz_history_entry(unsigned axis, uint16_t code)
{
    int bit = tgz_error_bit(code);

    return code | (uint32_t)axis << 16 | (uint32_t)(bit < 0 ? 0 : bit) << 24;
}

static bool stop_input(const struct tgz_device *tgz, unsigned axis)
{
    return tgz->inputs & tgz->reg[axis].input_mask;
}

/* The stop works where the drive makes or follows a path; elsewhere there is nothing to ramp. */
static void emergency_stop(struct tgz_device *tgz, unsigned axis)
{
    uint32_t mode = tgz->reg[axis].d_mode;

    if (mode == TGZ_MODE_POSITION || mode == TGZ_MODE_GENERATOR_SPEED ||
        mode == TGZ_MODE_GENERATOR_POSITION)
        drive_fault(&tgz->drive.axis[axis], TGZ_CODE_EMERGENCY);
}

void tgz_watch(struct tgz_device *tgz)
{
    for (unsigned i = 0; i < tgz->drive.kind->axes; i++) {
        struct drive *axis = &tgz->drive.axis[i];

        if (stop_input(tgz, i) && cia402_powered(&axis->machine))
            emergency_stop(tgz, i);
    }
    drive_device_report(&tgz->drive);
    for (unsigned i = 0; i < tgz->drive.kind->axes; i++) {
        uint16_t code = tgz->drive.axis[i].o.error_code;

        tgz->reg[i].errors = code ? tgz->reg[i].errors | bit_of(code) : 0;
    }
}

void tgz_guard_start(struct tgz_device *tgz, unsigned axis)
{
    struct tgz_axis *reg = &tgz->reg[axis];
    uint64_t now = tgz->drive.axis[axis].next_ns;

    reg->guard_due_ns = reg->guard_ms ? now + reg->guard_ms * UINT64_C(1000000) : 0;
}

static struct tgz_axis *next_guard(struct tgz_device *tgz, uint64_t now_ns)
{
    struct tgz_axis *next = NULL;

    for (unsigned i = 0; i < tgz->drive.kind->axes; i++) {
        struct tgz_axis *reg = &tgz->reg[i];

        if (reg->guard_due_ns && reg->guard_due_ns <= now_ns &&
            (!next || reg->guard_due_ns < next->guard_due_ns))
            next = reg;
    }
    return next;
}

void tgz_pass(struct tgz_device *tgz, uint64_t now_ns)
{
    struct tgz_axis *guard;

    while ((guard = next_guard(tgz, now_ns))) {
        drive_device_step(tgz, guard->guard_due_ns);
        guard->guard_due_ns = 0;
        emergency_stop(tgz, (unsigned)(guard - tgz->reg));
    }
    drive_device_step(tgz, now_ns);
    tgz_watch(tgz);
}
