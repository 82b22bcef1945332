/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * MAIN.SafetyEvent (R12). TG Motion itself raises that the EtherCAT link is lost, and takes it
 * back. The two stops have no source in the harness: whoever writes one into the register - a
 * scenario, an observer, a module - has it carried out until the register is 0 again.
 */
#include "host/host_parts.h"

#include <math.h>

#define SILENT_CYCLES 3   /* without a frame, one after the other, make a lost link */
#define STOP_SECONDS  0.1 /* of a controlled stop of a servo that has no deceleration of its own */

static bool link_broken(const struct host *host)
{
    if (host->silent_cycles >= SILENT_CYCLES)
        return true;
    for (size_t i = 0; i < bus_slave_count(host->bus); i++)
        if (bus_slave(host->bus, i)->lost)
            return true;
    return false;
}

static bool is_stop(uint32_t event)
{
    return event == MAIN_SAFETYEVENT_IMMEDIATE_STOP || event == MAIN_SAFETYEVENT_CONTROLLED_STOP;
}

static void say(struct host *host, bool broken)
{
    console_log(host, TGM_LOG_ETHERCAT, CONSOLE_MASTER, broken ? CONSOLE_ERROR : CONSOLE_INFO,
                broken ? "the link is lost" : "the link is back");
}

static void safety_receive(struct host *host)
{
    MAIN *m = &host->system->Main;
    const bool started = host->evidence->op_cycle != EVIDENCE_NO_CYCLE;
    const bool broken = host->bus != NULL && started && link_broken(host);
    if (broken != host->link_broken)
        say(host, broken);
    host->link_broken = broken;
    if (!is_stop(m->SafetyEvent))
        m->SafetyEvent = broken ? MAIN_SAFETYEVENT_ECAT_BROKEN : MAIN_SAFETYEVENT_NONE;
}

static double deceleration(const struct axis *axis)
{
    const double dec = axis->reg->Pg.Dec;
    return isfinite(dec) && dec > 0 ? dec : fabs(axis->stop_speed) / STOP_SECONDS;
}

/* The set-point of a running servo: `wanted`, unless it is to stop. A stop at once holds where the
 * servo is; a controlled one goes to standstill. */
double safety_set_point(const struct host *host, struct axis *axis, double wanted)
{
    const uint32_t event = host->system->Main.SafetyEvent;
    const double cycle = host_cycle_seconds(host);
    if (!is_stop(event)) {
        axis->stopping = 0;
        return wanted;
    }
    if (axis->stopping != event) {
        axis->stopping = event;
        axis->stop_speed = axis->sent_speed;
        axis->stop_at = event == MAIN_SAFETYEVENT_IMMEDIATE_STOP ? axis->actual : axis->sent;
        axis->stop_deceleration = deceleration(axis);
    }
    if (event == MAIN_SAFETYEVENT_IMMEDIATE_STOP)
        return axis->stop_at;
    const double less = axis->stop_deceleration * cycle;
    axis->stop_speed =
        fabs(axis->stop_speed) <= less ? 0 : axis->stop_speed - copysign(less, axis->stop_speed);
    axis->stop_at += axis->stop_speed * cycle;
    return axis->stop_at;
}

const struct host_part host_safety = { .name = "safety", .receive = safety_receive };
