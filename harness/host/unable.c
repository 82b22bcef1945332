/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What the PLC wants of an axis that cannot follow (decision H21): its drive has been in OP, and
 * now reports a fault, is in another state or does not answer. Written down, nothing else: TG
 * Motion itself sees to it that the axis is not enabled with a set-point from afar.
 */
#include "host/host_parts.h"

#include <math.h>

#define UNABLE_GRACE_NS UINT64_C(100000000) /* before a module must have noticed */

static bool is_unable(const struct host *host, const struct axis *axis)
{
    return axis->slave != NO_SLAVE && host->evidence->op_cycle != EVIDENCE_NO_CYCLE &&
           (axis->reg->EtherCATState != ETHERCAT_STATE_OP || axis->reg->Status == SERVO_FAULT ||
            axis->reg->Status == SERVO_NO_RESPONSE || host->link_broken);
}

/* Where a set-point that the PLC writes itself is to be. */
static bool wanted(const struct host *host, const SERVO *reg, double *at)
{
    const struct servo_modes *modes = host_modes(host);
    *at = (reg->Mode == modes->user ? reg->TransformedPosition : reg->WritePosition) + reg->Offset +
          reg->Correction;
    return (reg->Mode == modes->position || reg->Mode == modes->user) &&
           (reg->Control & SERVO_DISABLE_TORQUE_BIT1) == 0;
}

static void note(const struct host *host, const struct axis *axis, double at,
                 struct evidence_unable *unable)
{
    if (unable->driven++ > 0)
        return;
    unable->cycle = host->cycle;
    unable->al_state = (uint32_t)axis->reg->EtherCATState;
    unable->fault = axis->reg->Status == SERVO_FAULT;
    unable->distance = at - axis->actual;
}

/* A set-point that stands, or that is where the axis is, commands nothing. */
static void look_at(struct host *host, struct axis *axis, struct evidence_unable *unable)
{
    const uint64_t grace = UNABLE_GRACE_NS / (host->config.cycle_us * UINT64_C(1000));
    const double before = axis->unable_at, jump = AUDIT_AXIS_JUMP * axis->reg->Resolution;
    double at;
    if (!is_unable(host, axis) || !plc_calls(host)) {
        axis->unable_cycles = 0;
        return;
    }
    const bool commanded = wanted(host, axis->reg, &at);
    axis->unable_at = at;
    unable->cycles++;
    if (++axis->unable_cycles > grace && commanded && at != before &&
        fabs(at - axis->actual) > jump)
        note(host, axis, at, unable);
}

static void unable_send(struct host *host)
{
    for (size_t i = 0; i < host->axis_count && i < EVIDENCE_AXES; i++)
        look_at(host, &host->axes[i], &host->evidence->unable[i]);
}

const struct host_part host_unable = { .name = "unable", .send = unable_send };
