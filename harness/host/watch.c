/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What TG Motion itself can see of a module without looking into it: the registers it leaves, the
 * processor as it gives it back, the services it uses. Written down for the judge (audit.h).
 */
#include "host/host_parts.h"

#include <math.h>

/* Where the set-point is wanted by whoever has it in this mode (servo.c). */
static double wanted(const struct host *host, const SERVO *reg)
{
    const double base =
        reg->Mode == host_modes(host)->user ? reg->TransformedPosition : reg->WritePosition;
    return base + reg->Offset + reg->Correction;
}

static void note(const struct host *host, size_t axis, enum audit_motion_kind kind, double value,
                 double limit)
{
    audit_motion(&host->evidence->audit, kind, host->cycle, axis, value, limit);
}

/* A servo that is no motor goes anywhere. */
static void watch_step(const struct host *host, size_t index, const struct axis *axis, double next)
{
    const double rev = axis->reg->Resolution;
    const double step = AUDIT_AXIS_SPEED * rev * host_cycle_seconds(host);
    const double coasting = fabs(axis->reg->Speed) * 2 * host_cycle_seconds(host);
    const double jump = coasting > AUDIT_AXIS_JUMP * rev ? coasting : AUDIT_AXIS_JUMP * rev;
    if (axis->slave == NO_SLAVE || !servo_runs(host, axis))
        return;
    if (!axis->tracking && fabs(next - axis->sent) > step)
        note(host, index, AUDIT_TOO_FAST, next - axis->sent, step);
    if (axis->tracking && fabs(next - axis->actual) > jump)
        note(host, index, AUDIT_JUMP, next - axis->actual, jump);
}

static void watch_axis(const struct host *host, size_t index)
{
    const struct axis *axis = &host->axes[index];
    const SERVO *reg = axis->reg;
    const double next = wanted(host, reg);
    if (!isfinite(next))
        note(host, index, AUDIT_NO_NUMBER, next, 0);
    else
        watch_step(host, index, axis, next);
    if (host->evidence->op_cycle == EVIDENCE_NO_CYCLE && reg->EtherCATState != ETHERCAT_STATE_OP &&
        reg->Mode != host_modes(host)->off && (reg->Control & SERVO_DISABLE_TORQUE_BIT1) == 0)
        note(host, index, AUDIT_EARLY, reg->Mode, 0);
}

/* What is in the registers now leaves for the bus right after this. */
static void watch_send(struct host *host)
{
    for (size_t i = 0; i < host->axis_count && plc_calls(host); i++)
        watch_axis(host, i);
}

void watch_begin(const struct host *host, enum entry entry)
{
    const struct evidence *evidence = host->evidence;
    if (host->config.audit != NULL)
        audit_begin(host->config.audit, entry, evidence->cycle,
                    evidence->op_cycle != EVIDENCE_NO_CYCLE);
}

void watch_end(const struct host *host, enum entry entry, const struct machine_outcome *outcome)
{
    struct audit_function *function = &host->evidence->audit.functions[entry];
    if (host->config.audit != NULL && outcome->kind == MACHINE_ASIDE)
        audit_pause(host->config.audit);
    else if (host->config.audit != NULL)
        audit_end(host->config.audit, outcome->kind == MACHINE_RETURNED, outcome->instructions,
                  outcome->stack_bytes);
    if (outcome->kind != MACHINE_RETURNED || outcome->abi_broken == 0)
        return;
    if (function->abi_broken == 0)
        function->abi_cycle = host->evidence->cycle;
    function->abi_broken |= outcome->abi_broken;
}

void watch_sleep(const struct host *host)
{
    struct evidence *evidence = host->evidence;
    struct audit_function *function = &evidence->audit.functions[evidence->entry];
    if (function->sleeps++ > 0)
        return;
    function->sleep_cycle = evidence->cycle;
    if (!machine_service_caller(host->machine, &function->sleep_pc))
        function->sleep_pc = 0;
}

const struct host_part host_watch = { .name = "watch", .send = watch_send };
