/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * drive_rest.h - an axis without power that stands, on which a cycle with the same outputs changes
 * nothing: it need not be lived through. Time is noted and lived through by drive_rest_end(), which
 * everything calls that might change the axis or look at more of it than its process image.
 */
#ifndef HARNESS_BUS_DRIVE_REST_H
#define HARNESS_BUS_DRIVE_REST_H

#include "bus/drive.h"

#include <string.h>

enum { DRIVE_REST_OUT = 8, DRIVE_REST_IN = 20, DRIVE_REST_PADDING = 3 };

struct drive_rest {
    bool allowed; /* one axis, the default mapping, nothing about it but drive_device.c */
    bool on;
    bool shown;      /* `inputs` are those of the rest */
    uint64_t now_ns; /* the rest has lasted until then */
    uint8_t outputs[DRIVE_REST_OUT];
    uint8_t inputs[DRIVE_REST_IN];
    struct drive before; /* behind the outputs of the cycle before */
};

/* Behind outputs that went the general way: whether they begin a rest. */
void drive_rest_begin(struct drive_rest *rest, const struct drive *drive, const uint8_t *outputs);
void drive_rest_end(struct drive_rest *rest, struct drive *drive);
/* The inputs that the general way has just given. */
void drive_rest_note_inputs(struct drive_rest *rest, const uint8_t *inputs);

/* The three steps of a cycle; false: the general way has to take them. */
static inline bool drive_rest_step(struct drive_rest *rest, uint64_t now_ns)
{
    if (!rest->on)
        return false;
    rest->now_ns = now_ns;
    return true;
}

static inline bool drive_rest_inputs(const struct drive_rest *rest, uint8_t *data)
{
    uint8_t padding = data[DRIVE_REST_PADDING];

    if (!rest->on || !rest->shown)
        return false;
    memcpy(data, rest->inputs, DRIVE_REST_IN);
    data[DRIVE_REST_PADDING] = padding;
    return true;
}

static inline bool drive_rest_outputs(const struct drive_rest *rest, const uint8_t *data)
{
    return rest->on && memcmp(data, rest->outputs, DRIVE_REST_OUT) == 0;
}

#endif
