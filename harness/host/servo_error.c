/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SERVO.Error: when a drive goes into fault, its error code is fetched over CoE (M13). A TGZ has it
 * in its history, 0x1003: the newest that is of the axis.
 */
#include "host/drive_error.h"
#include "host/host_parts.h"

static struct axis_error *error_of(struct host *host, const struct axis *axis)
{
    return &host->errors[axis - host->axes];
}

enum { HISTORY = 0x1003, HISTORY_MOST = 64 };

static void ask_for(struct host *host, const struct axis *axis, struct axis_error *error,
                    uint16_t index, uint8_t subindex)
{
    error->job = (struct bus_job){
        .kind = BUS_SDO_READ,
        .slave = axis->slave,
        .index = index,
        .subindex = subindex,
        .size = index == HISTORY ? sizeof(uint32_t) : sizeof(uint16_t),
    };
    error->asked = true;
    bus_job_start(host->bus, &error->job);
}

static void ask(struct host *host, const struct axis *axis, struct axis_error *error)
{
    if (wire_tgz_axes(host->config.plant, axis->slave) > 0)
        ask_for(host, axis, error, HISTORY, 1);
    else
        ask_for(host, axis, error, (uint16_t)(0x603F + 0x800 * axis->wire.axis), 0);
}

/* Bit 16 of an entry of the history is the axis. True when there is an older one to be looked at.
 */
static bool is_of_other_axis(const struct axis *axis, const struct bus_job *job)
{
    return job->index == HISTORY && (job->data[2] & 1) != axis->wire.axis &&
           job->subindex < HISTORY_MOST;
}

/* Until the drive has answered the fault is "other". */
void servo_faulty(struct host *host, struct axis *axis)
{
    struct axis_error *error = error_of(host, axis);
    if (!error->faulty) {
        error->faulty = true;
        error->bit = DRIVE_ERROR_OTHER;
        error->stale = error->asked; /* an answer on its way is that of the fault before */
        if (!error->asked)
            ask(host, axis, error);
    }
    if (error->asked && error->job.done) {
        error->asked = false;
        if (error->stale) {
            error->stale = false;
            ask(host, axis, error);
        } else if (error->job.result == 0 && is_of_other_axis(axis, &error->job)) {
            ask_for(host, axis, error, HISTORY, (uint8_t)(error->job.subindex + 1));
        } else if (error->job.result == 0) {
            const uint16_t code = (uint16_t)(error->job.data[0] | error->job.data[1] << 8);
            error->bit = drive_error_bit(code);
            console_log(host, TGM_LOG_ETHERCAT_STATUS, CONSOLE_SERVO, CONSOLE_ERROR,
                        "servo %u: fault, 0x%04X is 0x%04X", (unsigned)axis->reg->Number,
                        error->job.index, code);
        }
    }
    axis->reg->Error = error->bit;
}

void servo_faultless(struct host *host, struct axis *axis)
{
    struct axis_error *error = error_of(host, axis);
    error->faulty = false;
    if (error->asked && error->job.done)
        error->asked = false;
    axis->reg->Error = 0;
}
