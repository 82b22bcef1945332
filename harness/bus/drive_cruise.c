/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive_cruise.h"
#include "bus/axis_step.h"
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

enum { MOST_STEPS = 1000 }; /* at once */

bool drive_cruise_step(struct drive *drive, uint64_t now_ns)
{
    struct axis_line line = { .demand = drive->demand,
                              .velocity = drive->demand_velocity,
                              .end = drive->end,
                              .steps_left = drive->steps_left };
    double window = drive_window(drive), error;
    uint64_t steps;
    uint32_t done;

    if (now_ns < drive->next_ns)
        return true;
    steps = (now_ns - drive->next_ns) / AXIS_STEP_NS + 1;
    if (!cruises(drive) || drive->machine.leaving || drive->outside_steps ||
        drive->o.limit_reaction != DRIVE_LIMIT_SHOWN || steps > MOST_STEPS)
        return false;
    drive_take_torque_limits(drive);
    done = axis_follow_line(&drive->axis, &line, window, (uint32_t)steps);
    drive->demand = line.demand;
    drive->demand_velocity = line.velocity;
    drive->steps_left = line.steps_left;
    drive->positioned = drive->stale = true;
    drive->next_ns += (uint64_t)done * AXIS_STEP_NS;
    error = line.demand - drive->axis.position;
    if (error <= window && error >= -window)
        return true;
    drive_watch_following_error(drive);
    return false;
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

/* put_u32() in one store, where compilers do not see it. */
static inline void store(uint8_t *to, uint32_t value)
{
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
    memcpy(to, &value, sizeof value);
#else
    put_u32(to, value);
#endif
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
    store(data + 4, (uint32_t)(uint64_t)(actual - drive->zero));
    store(data + 8, (uint32_t)drive_rounded(drive->axis.velocity * drive->increments));
    store(data + 12, (uint32_t)(uint64_t)behind);
    store(data + 16, drive->axis.switches | drive->user_inputs);
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
