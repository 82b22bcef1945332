/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive_cruise.h"
#include "bus/bytes.h"
#include "bus/registers.h"

#include <stddef.h>
#include <string.h>

#define OBJECT(member) offsetof(struct drive, o.member)

/* The default mapping, as pdo_resolve() sorts it. */
static const struct pdo_image default_outputs = {
    .bits = 64,
    .count = 3,
    .fours = 1,
    .twos = 2,
    .copy = { { 4, OBJECT(target_position), 4 },
              { 0, OBJECT(controlword), 2 },
              { 2, OBJECT(mode), 1 } },
};
static const struct pdo_image default_inputs = {
    .bits = 160,
    .count = 6,
    .fours = 4,
    .twos = 5,
    .copy = { { 4, OBJECT(position_actual), 4 },
              { 8, OBJECT(velocity_actual), 4 },
              { 12, OBJECT(following_error), 4 },
              { 16, OBJECT(digital_inputs), 4 },
              { 0, OBJECT(statusword), 2 },
              { 2, OBJECT(mode_display), 1 } },
};

static bool same(const struct pdo_image *a, const struct pdo_image *b)
{
    if (a->bits != b->bits || a->count != b->count)
        return false;
    for (unsigned i = 0; i < a->count; i++) {
        if (a->copy[i].image != b->copy[i].image || a->copy[i].object != b->copy[i].object ||
            a->copy[i].bytes != b->copy[i].bytes)
            return false;
    }
    return true;
}

bool drive_cruise_fits(const struct pdo_image *outputs, const struct pdo_image *inputs)
{
    return same(outputs, &default_outputs) && same(inputs, &default_inputs);
}

static inline bool cruises(const struct drive *drive)
{
    return drive->machine.state == CIA402_OPERATION_ENABLED && drive->o.mode_display == DRIVE_CSP;
}

static inline bool limiting(const struct drive *drive)
{
    return drive->axis.limited ||
           (drive->axis.switches & (AXIS_SWITCH_NEGATIVE | AXIS_SWITCH_POSITIVE)) ||
           drive->demand >= drive->high || drive->demand <= drive->low;
}

static inline unsigned statusword(const struct drive *drive, int64_t actual)
{
    double error = drive->demand - drive->axis.position, window = drive_window(drive);
    int64_t away = drive->target - actual, near = drive->o.position_window;
    unsigned word = cia402_status(&drive->machine) | SW_MODE_12;

    if (drive->al_state == AL_OP)
        word |= SW_REMOTE;
    if (away <= near && away >= -near)
        word |= SW_TARGET_REACHED;
    if (drive->positioned && (error > window || error < -window))
        word |= SW_MODE_13;
    if (limiting(drive))
        word |= SW_INTERNAL_LIMIT;
    return word;
}

bool drive_cruise_inputs(struct drive *drive, uint8_t *data)
{
    int64_t actual, behind;

    if (!cruises(drive))
        return false;
    actual = drive_actual(drive);
    behind = drive->positioned ? drive_increments(drive, drive->demand) - actual : 0;
    put_u16(data, statusword(drive, actual));
    data[2] = (uint8_t)drive->o.mode_display;
    put_u32(data + 4, (uint32_t)(uint64_t)(actual - drive->zero));
    put_u32(data + 8, (uint32_t)drive_rounded(drive->axis.velocity * drive->increments));
    put_u32(data + 12, (uint32_t)(uint64_t)behind);
    put_u32(data + 16, drive->axis.switches | drive->user_inputs);
    drive->stale = true;
    return true;
}

bool drive_cruise_outputs(struct drive *drive, const uint8_t *data, uint64_t now_ns)
{
    unsigned controlword = get_u16(data);

    /* Enabled stays enabled with these bits, whatever the option codes are; mode 0 asks for none.
     */
    if (!cruises(drive) || drive->machine.leaving || drive->limit_stop ||
        (data[2] != DRIVE_CSP && data[2] != 0) || (controlword & (CW_FAULT_RESET | 0x0f)) != 0x0f)
        return false;
    drive->machine.reset_seen = false;
    drive->o.controlword = (uint16_t)controlword;
    drive->o.mode = (int8_t)data[2];
    drive->o.target_position = (int32_t)get_u32(data + 4);
    drive->stale = true;
    drive_cyclic_position.command(drive, now_ns);
    return true;
}
