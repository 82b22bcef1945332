/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SERVO.Capture: positions at the edges of a drive input, as of the cycle in which the edge was
 * seen (docs/decisions.md, M3).
 */
#include "host/host_parts.h"

enum { ARM_POSITIVE = 1, ARM_NEGATIVE = 2 };

static void axis_capture(struct axis *axis)
{
    struct axis_motion *m = &axis->motion;
    SERVO *reg = axis->reg;
    CAPTURE *capture = &reg->Capture;
    const uint32_t before = m->inputs, now = reg->DigitalIn;
    const bool seen = m->inputs_seen;
    m->inputs = now;
    m->inputs_seen = true;
    if (!seen || capture->Typ_ExtCapture > 31)
        return;
    const uint32_t bit = UINT32_C(1) << capture->Typ_ExtCapture;
    if (((before ^ now) & bit) == 0)
        return;
    if ((now & bit) != 0 && (capture->Control & ARM_POSITIVE) != 0) {
        capture->PPosition = reg->Position;
        capture->PExt_Position = reg->ExtPosition;
        capture->Write_Position = reg->WritePosition;
        capture->Control &= ~(uint32_t)ARM_POSITIVE;
    }
    if ((now & bit) == 0 && (capture->Control & ARM_NEGATIVE) != 0) {
        capture->NPosition = reg->Position;
        capture->NExt_Position = reg->ExtPosition;
        capture->Write_Position = reg->WritePosition;
        capture->Control &= ~(uint32_t)ARM_NEGATIVE;
    }
}

/* Without communication there are no inputs, and no edge when they come back. */
static void receive(struct host *host)
{
    for (size_t i = 0; i < host->axis_count; i++)
        if (host->axes[i].reg->Status > SERVO_NO_RESPONSE)
            axis_capture(&host->axes[i]);
        else
            host->axes[i].motion.inputs_seen = false;
}

const struct host_part host_capture = { .name = "capture", .receive = receive };
