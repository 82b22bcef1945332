/* SPDX-License-Identifier: GPL-2.0-or-later */
/* view.h - a slave as somebody sees it who stands in front of it, whatever its master believes. */
#ifndef HARNESS_BUS_VIEW_H
#define HARNESS_BUS_VIEW_H

#include <stddef.h>
#include <stdint.h>

#define VIEW_AXES  2
#define VIEW_BYTES 8

struct slave;

struct view {
    const char *name;
    uint16_t station; /* 0: no master has given it one */
    uint16_t al_state, al_code;
    const char *state; /* "SAFEOP+ERR" */
    const char *code;  /* what al_code means, "" when it is 0 */
    unsigned axes;     /* CiA 402 axes, of which at most VIEW_AXES are shown */
    int32_t position[VIEW_AXES];
    size_t
        input_bytes; /* of the input image, when there is one of at most VIEW_BYTES and no axis */
    uint8_t input[VIEW_BYTES];
    size_t pin_bytes; /* of digital outputs, 0: none */
    uint8_t pins[4];
};

void view_take(const struct slave *slave, struct view *view);

#endif
