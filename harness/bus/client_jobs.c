/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What happens beside the process data, on the bus's fiber: jobs in the order in which they came,
 * then the states of the slaves. */
#include "bus/client.h"
#include "bus/fiber.h"

#include <errno.h>
#include <string.h>

/* SOEM tells the reason of a failed SDO only through its error list. */
static int sdo_result(struct bus *bus, int wkc, uint32_t *abort)
{
    ec_errort error;
    int result = wkc > 0 ? 0 : -ETIMEDOUT;

    while (ecx_poperror(&bus->context, &error)) {
        if (wkc > 0)
            continue;
        if (error.Etype == EC_ERR_TYPE_SDO_ERROR) {
            result = -EPROTO;
            *abort = (uint32_t)error.AbortCode;
        } else if (error.Etype == EC_ERR_TYPE_PACKET_ERROR) {
            result = error.ErrorCode == 3 ? -ENOSPC : -EBADMSG;
        } else if (error.Etype == EC_ERR_TYPE_MBX_ERROR) {
            result = -EBADMSG;
        }
    }
    return result;
}

int client_sdo(struct bus *bus, struct bus_job *job)
{
    uint16 slave = (uint16)(job->slave + 1);
    boolean complete = job->complete ? TRUE : FALSE;
    int wkc, size = (int)job->size;

    if (!(bus->slavelist[slave].mbx_proto & ECT_MBXPROT_COE))
        return -EOPNOTSUPP;
    if (job->kind == BUS_SDO_READ) {
        wkc = ecx_SDOread(&bus->context, slave, job->index, job->subindex, complete, &size,
                          job->data, EC_TIMEOUTRXM);
        job->size = wkc > 0 ? (size_t)size : 0;
    } else {
        wkc = ecx_SDOwrite(&bus->context, slave, job->index, job->subindex, complete, size,
                           job->data, EC_TIMEOUTRXM);
    }
    return sdo_result(bus, wkc, &job->abort);
}

static int access_register(struct bus *bus, struct bus_job *job)
{
    uint16 station = bus->slavelist[job->slave + 1].configadr;
    uint16 size = (uint16)job->size;
    int wkc;

    if (job->kind == BUS_REGISTER_READ)
        wkc = ecx_FPRD(&bus->port, station, job->index, size, job->data, EC_TIMEOUTRET3);
    else
        wkc = ecx_FPWR(&bus->port, station, job->index, size, job->data, EC_TIMEOUTRET3);
    return wkc > 0 ? 0 : -ETIMEDOUT;
}

static void carry_out(struct bus *bus, struct bus_job *job)
{
    job->abort = 0;
    if (job->slave >= bus->slave_count || job->size > sizeof job->data)
        job->result = -EINVAL;
    else if (job->kind == BUS_SDO_READ || job->kind == BUS_SDO_WRITE)
        job->result = client_sdo(bus, job);
    else
        job->result = access_register(bus, job);
}

static bool next_job(struct bus *bus)
{
    struct bus_job *job = bus->job_first;

    if (!job)
        return false;
    carry_out(bus, job);
    bus->job_first = job->next;
    if (!bus->job_first)
        bus->job_last = NULL;
    job->done = true;
    return true;
}

void client_jobs(void *argument)
{
    struct bus *bus = argument;

    for (;;) {
        if (client_watch(bus) || next_job(bus))
            continue;
        bus->clock.wake_ns = BUS_CLOCK_NEVER;
        fiber_yield(bus->clock.fiber);
    }
}

/* Every wait of the fiber ends at its own time, not when somebody looks: frames go out in the order
 * of their times. */
void client_run_jobs(struct bus *bus, uint64_t now_ns)
{
    while (bus->clock.wake_ns <= now_ns) {
        bus_clock_reach(&bus->clock, bus->clock.wake_ns);
        fiber_resume(bus->clock.fiber);
    }
}

void bus_job_start(struct bus *bus, struct bus_job *job)
{
    job->done = false;
    job->next = NULL;
    if (bus->job_last)
        bus->job_last->next = job;
    else
        bus->job_first = job;
    bus->job_last = job;
    if (bus->clock.wake_ns == BUS_CLOCK_NEVER)
        bus->clock.wake_ns = bus->clock.now_ns;
}

static int wait_for(struct bus *bus, struct bus_job *job)
{
    struct bus_clock *previous = bus_clock_enter(&bus->clock);

    bus_job_start(bus, job);
    while (!job->done)
        client_run_jobs(bus, bus->clock.wake_ns);
    bus_clock_enter(previous);
    return job->result;
}

static int sdo_check(const struct bus *bus, size_t slave, uint32_t *abort)
{
    if (abort)
        *abort = 0;
    if (slave >= bus->slave_count)
        return -EINVAL;
    return bus->slavelist[slave + 1].mbx_proto & ECT_MBXPROT_COE ? 0 : -EOPNOTSUPP;
}

int bus_sdo_read(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, void *data,
                 size_t *size, uint32_t *abort)
{
    struct bus_job job = { .kind = BUS_SDO_READ,
                           .slave = slave,
                           .index = index,
                           .subindex = subindex,
                           .size = *size < BUS_JOB_DATA ? *size : BUS_JOB_DATA };
    int error = sdo_check(bus, slave, abort);

    if (error)
        return error;
    error = wait_for(bus, &job);
    if (abort)
        *abort = job.abort;
    if (!error) {
        memcpy(data, job.data, job.size);
        *size = job.size;
    }
    return error;
}

int bus_sdo_write(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, const void *data,
                  size_t size, uint32_t *abort)
{
    struct bus_job job = {
        .kind = BUS_SDO_WRITE, .slave = slave, .index = index, .subindex = subindex, .size = size
    };
    int error = size > BUS_JOB_DATA ? -EINVAL : sdo_check(bus, slave, abort);

    if (error)
        return error;
    memcpy(job.data, data, size);
    error = wait_for(bus, &job);
    if (abort)
        *abort = job.abort;
    return error;
}
