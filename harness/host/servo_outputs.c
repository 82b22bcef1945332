/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SERVO.DigitalOut of CiA 402 drives that do not have their outputs among the process data: object
 * 0x60FE:1 is written over CoE when the register changes (M16). A drive that was below PREOP has
 * forgotten them.
 */
#include "host/host_parts.h"

#define LEAST_STATE 2 /* PREOP: mailboxes work */

static bool is_due(const struct host *host, size_t number)
{
    const struct axis *axis = &host->axes[number];
    return axis->slave != NO_SLAVE && wire_tells_outputs(&axis->wire) &&
           axis->reg->EtherCATState >= LEAST_STATE &&
           axis->reg->DigitalOut != host->told_outputs.values[number];
}

static void start(struct host *host, size_t number)
{
    const struct axis *axis = &host->axes[number];
    struct told_outputs *told = &host->told_outputs;
    const uint32_t value = axis->reg->DigitalOut;
    told->job = (struct bus_job){ .kind = BUS_SDO_WRITE,
                                  .slave = axis->slave,
                                  .index = (uint16_t)(0x60FE + 0x800 * axis->wire.axis),
                                  .subindex = 1,
                                  .size = sizeof value };
    for (unsigned i = 0; i < sizeof value; i++)
        told->job.data[i] = (uint8_t)(value >> 8 * i);
    told->values[number] = value;
    told->asked = true;
    bus_job_start(host->bus, &told->job);
}

static void send(struct host *host)
{
    struct told_outputs *told = &host->told_outputs;
    for (size_t i = 0; i < host->axis_count; i++)
        if (host->axes[i].slave != NO_SLAVE && host->axes[i].reg->EtherCATState < LEAST_STATE)
            told->values[i] = 0;
    if (told->asked && !told->job.done)
        return;
    told->asked = false;
    for (size_t i = 0; i < host->axis_count && !told->asked; i++)
        if (is_due(host, i))
            start(host, i);
}

const struct host_part host_servo_outputs = { .name = "servo outputs", .send = send };
