/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/drive_rest.h"

static bool stands_unpowered(const struct drive *drive)
{
    return drive_coasts(drive) && drive->axis.velocity == 0.0;
}

void drive_rest_begin(struct drive_rest *rest, const struct drive *drive, const uint8_t *outputs)
{
    if (!rest->allowed || !stands_unpowered(drive))
        return;
    /* A whole cycle has left everything as it was, but for the time. Padding is compared as well:
     * if it differs, the rest is missed and nothing is wrong. */
    rest->before.next_ns = drive->next_ns;
    rest->on = memcmp(&rest->before, drive, sizeof *drive) == 0 &&
               memcmp(rest->outputs, outputs, DRIVE_REST_OUT) == 0;
    rest->shown = false;
    rest->now_ns = 0;
    memcpy(&rest->before, drive, sizeof *drive);
    memcpy(rest->outputs, outputs, DRIVE_REST_OUT);
}

void drive_rest_end(struct drive_rest *rest, struct drive *drive)
{
    if (!rest->on)
        return;
    rest->on = false;
    drive_step(drive, rest->now_ns);
}

void drive_rest_note_inputs(struct drive_rest *rest, const uint8_t *inputs)
{
    if (!rest->on)
        return;
    memcpy(rest->inputs, inputs, DRIVE_REST_IN);
    rest->shown = true;
}
