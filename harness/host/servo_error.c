/* SPDX-License-Identifier: GPL-2.0-or-later */
/* SERVO.Error: when a drive goes into fault, its error code is fetched over CoE (M13). */
#include "host/drive_error.h"
#include "host/host_parts.h"

static struct axis_error *error_of(struct host *host, const struct axis *axis)
{
    return &host->errors[axis - host->axes];
}

static void ask(struct host *host, const struct axis *axis, struct axis_error *error)
{
    error->job = (struct bus_job){
        .kind = BUS_SDO_READ,
        .slave = axis->slave,
        .index = (uint16_t)(0x603F + 0x800 * (axis->reg->Axis - 1)),
        .size = sizeof(uint16_t),
    };
    error->asked = true;
    bus_job_start(host->bus, &error->job);
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
        } else if (error->job.result == 0) {
            const uint16_t code = (uint16_t)(error->job.data[0] | error->job.data[1] << 8);
            error->bit = drive_error_bit(code);
            console_log(host, TGM_LOG_ETHERCAT_STATUS, CONSOLE_SERVO, CONSOLE_ERROR,
                        "servo %u: fault, 0x603F is 0x%04X", (unsigned)axis->reg->Number, code);
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
