/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Homing on the switches of the machine, with and without index pulse, and on the spot. */
#include "bus/drive.h"

#include <stddef.h>

/* Fast against `edge_direction` until the switch is active, then slowly along it until it is not:
 * home is where it lets go, or at the first index pulse behind. The encoder has one at every whole
 * revolution. */
static const struct method {
    int8_t number;
    uint8_t switch_bit; /* 0: here and now */
    int8_t edge_direction;
    bool index;
} methods[] = {
    { 1, AXIS_SWITCH_NEGATIVE, +1, true },   /* negative limit, leaving it */
    { 2, AXIS_SWITCH_POSITIVE, -1, true },   /* positive limit, leaving it */
    { 3, AXIS_SWITCH_HOME, -1, true },       /* home switch on the positive side, leaving it */
    { 5, AXIS_SWITCH_HOME, +1, true },       /* home switch on the negative side, leaving it */
    { 17, AXIS_SWITCH_NEGATIVE, +1, false }, /* as 1 */
    { 18, AXIS_SWITCH_POSITIVE, -1, false }, /* as 2 */
    { 19, AXIS_SWITCH_HOME, -1, false },     /* as 3 */
    { 21, AXIS_SWITCH_HOME, +1, false },     /* as 5 */
    { 35, 0, 0, false },
    { 37, 0, 0, false },
};

static const struct method *find_method(int number)
{
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        if (methods[i].number == number)
            return &methods[i];
    }
    return NULL;
}

bool drive_homing_supported(int number)
{
    return find_method(number) != NULL;
}

static void hm_start(struct drive *drive)
{
    drive_demand_actual(drive);
    drive->homing = HOMING_IDLE;
}

static void found(struct drive *drive, int64_t place)
{
    /* The place that was found gets the value of the home offset. */
    drive->zero = place - drive->o.home_offset;
    drive_limits(drive);
    drive->homing = HOMING_STOP;
}

static bool searching(const struct drive *drive)
{
    return drive->homing == HOMING_SEEK || drive->homing == HOMING_EDGE ||
           drive->homing == HOMING_INDEX;
}

static void hm_command(struct drive *drive, uint64_t now_ns)
{
    bool start = drive->o.controlword & CW_MODE_4;
    const struct method *method = find_method(drive->o.homing_method);

    (void)now_ns;
    if (!start) {
        if (searching(drive))
            drive->homing = HOMING_IDLE;
        return;
    }
    if (drive->homing != HOMING_IDLE)
        return;
    if (!method)
        drive->homing = HOMING_FAILED;
    else if (!method->switch_bit)
        found(drive, drive_actual(drive));
    else
        drive->homing = HOMING_SEEK;
}

/* Running against the other end of the travel means that the switch is not where it should be. */
static bool at_wrong_limit(const struct drive *drive, uint8_t wanted, double velocity)
{
    uint8_t limit = velocity < 0 ? AXIS_SWITCH_NEGATIVE : AXIS_SWITCH_POSITIVE;

    return velocity != 0.0 && limit != wanted && (drive->axis.switches & limit);
}

static double search_velocity(const struct drive *drive, const struct method *method)
{
    const uint32_t *speed = drive->o.homing_speed;

    if (!method || !searching(drive) || (drive->o.controlword & CW_HALT))
        return 0.0;
    if (drive->homing == HOMING_SEEK)
        return -method->edge_direction * drive_revolutions(drive, speed[0]);
    return method->edge_direction * drive_revolutions(drive, speed[1]);
}

static void edge_found(struct drive *drive, const struct method *method)
{
    if (!method->index) {
        found(drive, drive_actual(drive));
        return;
    }
    drive->index = axis_floor(drive->axis.position);
    drive->homing = HOMING_INDEX;
}

static void look_for_index(struct drive *drive, const struct method *method)
{
    int64_t now = axis_floor(drive->axis.position);

    if (now != drive->index)
        found(drive,
              drive_increments(drive, (double)(method->edge_direction > 0 ? now : drive->index)));
}

static void search(struct drive *drive, const struct method *method, double velocity)
{
    bool level = drive->axis.switches & method->switch_bit;

    if (at_wrong_limit(drive, method->switch_bit, velocity))
        drive->homing = HOMING_FAILED;
    else if (drive->homing == HOMING_SEEK && level)
        drive->homing = HOMING_EDGE;
    else if (drive->homing == HOMING_EDGE && !level)
        edge_found(drive, method);
    else if (drive->homing == HOMING_INDEX)
        look_for_index(drive, method);
}

static void hm_step(struct drive *drive)
{
    const struct method *method = find_method(drive->o.homing_method);
    double velocity = search_velocity(drive, method);

    drive_ramp(drive, velocity, drive_revolutions(drive, drive->o.homing_acceleration));
    if (method && searching(drive))
        search(drive, method, velocity);
    else if (drive->homing == HOMING_STOP && drive->demand_velocity == 0.0)
        drive->homing = HOMING_DONE;
}

static uint16_t hm_status(const struct drive *drive)
{
    bool rest = drive->demand_velocity == 0.0;

    switch (drive->homing) {
    case HOMING_SEEK:
    case HOMING_EDGE:
    case HOMING_INDEX:
        return 0;
    case HOMING_STOP:
        return SW_MODE_12;
    case HOMING_DONE:
        return SW_MODE_12 | SW_TARGET_REACHED;
    case HOMING_FAILED:
        return (uint16_t)(SW_MODE_13 | (rest ? SW_TARGET_REACHED : 0));
    default:
        return (uint16_t)(rest ? SW_TARGET_REACHED : 0);
    }
}

const struct drive_mode drive_homing = { .number = DRIVE_HM,
                                         .start = hm_start,
                                         .command = hm_command,
                                         .step = hm_step,
                                         .status = hm_status };
