/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Homing on the switches of the machine, without index pulse, and on the spot. */
#include "bus/drive.h"

#include <stddef.h>

enum { CW_START = 1 << 4 };

/* Fast against `edge_direction` until the switch is active, then slowly along it until it is not:
 * home is where it lets go. */
static const struct method {
    int8_t number;
    uint8_t switch_bit; /* 0: here and now */
    int8_t edge_direction;
} methods[] = {
    { 17, AXIS_SWITCH_NEGATIVE, +1 }, /* negative limit, leaving it */
    { 18, AXIS_SWITCH_POSITIVE, -1 }, /* positive limit, leaving it */
    { 21, AXIS_SWITCH_HOME, +1 },     /* home switch on the negative side, leaving it */
    { 35, 0, 0 },
    { 37, 0, 0 },
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

static void found(struct drive *drive)
{
    /* The place of the edge gets the value of the home offset. */
    drive->zero = drive_actual(drive) - drive->o.home_offset;
    drive->homing = HOMING_STOP;
}

static void hm_command(struct drive *drive, uint64_t now_ns)
{
    bool start = drive->o.controlword & CW_START;
    const struct method *method = find_method(drive->o.homing_method);

    (void)now_ns;
    if (!start) {
        if (drive->homing == HOMING_SEEK || drive->homing == HOMING_EDGE)
            drive->homing = HOMING_IDLE;
        return;
    }
    if (drive->homing != HOMING_IDLE)
        return;
    if (!method)
        drive->homing = HOMING_FAILED;
    else if (!method->switch_bit)
        found(drive);
    else
        drive->homing = HOMING_SEEK;
}

/* Running against the other end of the travel means that the switch is not where it should be. */
static bool at_wrong_limit(const struct drive *drive, uint8_t wanted, double velocity)
{
    uint8_t limit = velocity < 0 ? AXIS_SWITCH_NEGATIVE : AXIS_SWITCH_POSITIVE;

    return velocity != 0.0 && limit != wanted && (drive->axis.switches & limit);
}

static void hm_step(struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    const struct method *method = find_method(o->homing_method);
    bool halted = o->controlword & CW_HALT;
    double velocity = 0.0;

    if (method && !halted && drive->homing == HOMING_SEEK)
        velocity = -method->edge_direction * drive_revolutions(o->homing_speed[0]);
    else if (method && !halted && drive->homing == HOMING_EDGE)
        velocity = method->edge_direction * drive_revolutions(o->homing_speed[1]);
    drive_ramp(drive, velocity, drive_revolutions(o->homing_acceleration));
    if (method && (drive->homing == HOMING_SEEK || drive->homing == HOMING_EDGE)) {
        bool level = drive->axis.switches & method->switch_bit;

        if (at_wrong_limit(drive, method->switch_bit, velocity))
            drive->homing = HOMING_FAILED;
        else if (drive->homing == HOMING_SEEK && level)
            drive->homing = HOMING_EDGE;
        else if (drive->homing == HOMING_EDGE && !level)
            found(drive);
    } else if (drive->homing == HOMING_STOP && drive->demand_velocity == 0.0) {
        drive->homing = HOMING_DONE;
    }
}

static uint16_t hm_status(const struct drive *drive)
{
    bool rest = drive->demand_velocity == 0.0;

    switch (drive->homing) {
    case HOMING_SEEK:
    case HOMING_EDGE:
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
