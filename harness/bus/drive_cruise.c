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

/* Sub-steps up to now_ns that the short way may take; 0: none are due or it may not. */
static inline uint32_t steps_due(const struct drive *drive, uint64_t now_ns)
{
    uint64_t steps;

    if (now_ns < drive->next_ns || !cruises(drive) || drive->machine.leaving ||
        drive->outside_steps || drive->o.limit_reaction != DRIVE_LIMIT_SHOWN)
        return 0;
    steps = (now_ns - drive->next_ns) / AXIS_STEP_NS + 1;
    return steps > MOST_STEPS ? 0 : (uint32_t)steps;
}

static inline struct axis_line line_of(const struct drive *drive)
{
    return (struct axis_line){ .demand = drive->demand,
                               .velocity = drive->demand_velocity,
                               .end = drive->end,
                               .steps_left = drive->steps_left };
}

static inline void take_line(struct drive *drive, const struct axis_line *line, uint32_t done)
{
    drive->demand = line->demand;
    drive->demand_velocity = line->velocity;
    drive->steps_left = line->steps_left;
    drive->positioned = drive->stale = true;
    drive->next_ns += (uint64_t)done * AXIS_STEP_NS;
}

static inline bool within(double error, double window)
{
    return error <= window && error >= -window;
}

/* One axis of four. */
struct lane {
    struct axis *axis;
    struct axis_line line;
    double window;
};

/* False: it has left the window of the following error. */
static inline bool lane_step(struct lane *lane)
{
    axis_line_step(&lane->line);
    axis_follow_loop(lane->axis, lane->line.demand, lane->line.velocity);
    return within(lane->line.demand - lane->axis->position, lane->window);
}

/* A step is one chain of dependent operations, most of which a processor spends waiting; side by
 * side the four chains wait together. All end where one leaves its window. */
static uint32_t lanes_run(struct lane lane[4], uint32_t steps)
{
    uint32_t done = 0;
    bool inside;

    do {
        inside = lane_step(&lane[0]);
        inside &= lane_step(&lane[1]);
        inside &= lane_step(&lane[2]);
        inside &= lane_step(&lane[3]);
    } while (++done < steps && inside);
    return done;
}

void drive_cruise_step_four(struct drive *const drive[4], const uint64_t now_ns[4])
{
    uint32_t steps = steps_due(drive[0], now_ns[0]), done;
    struct lane lane[4];

    for (unsigned i = 0; i < 4; i++) {
        if (!steps || steps_due(drive[i], now_ns[i]) != steps || drive[i]->axis.model->ideal)
            return;
        drive_take_torque_limits(drive[i]);
        lane[i] = (struct lane){ &drive[i]->axis, line_of(drive[i]), drive_window(drive[i]) };
    }
    done = lanes_run(lane, steps);
    for (unsigned i = 0; i < 4; i++) {
        axis_read_switches(lane[i].axis);
        take_line(drive[i], &lane[i].line, done);
        if (!within(lane[i].line.demand - lane[i].axis->position, lane[i].window))
            drive_watch_following_error(drive[i]);
    }
}

bool drive_cruise_step(struct drive *drive, uint64_t now_ns)
{
    struct axis_line line;
    double window, error;
    uint32_t steps, done;

    if (now_ns < drive->next_ns)
        return true;
    steps = steps_due(drive, now_ns);
    if (!steps)
        return false;
    drive_take_torque_limits(drive);
    line = line_of(drive);
    window = drive_window(drive);
    done = axis_follow_line(&drive->axis, &line, window, steps);
    take_line(drive, &line, done);
    error = line.demand - drive->axis.position;
    if (within(error, window))
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
    /* Whole words, or who reads them next waits. The byte of padding stays. */
    store(data, statusword(drive, actual) | (uint32_t)(uint8_t)drive->o.mode_display << 16 |
                    (uint32_t)data[3] << 24);
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
