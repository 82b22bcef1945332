/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/channel.h"

#include <errno.h>
#include <string.h>

enum { SDO_STATUS = 1, SDO_LENGTH, SDO_INDEX, SDO_SUBINDEX, SDO_DATA };
enum { REGISTER_LENGTH = 1, REGISTER_INDEX, REGISTER_DATA };

enum { READY = 0, WRITE = 1, READ = 2, REGISTER_ERROR = 3, REGISTER_BUSY = 4 };
enum { STATUS_OK = 0, STATUS_BUSY = 1, STATUS_ERROR = -1 };

static unsigned data_at(const struct channel *channel)
{
    return channel->kind == CHANNEL_SDO ? SDO_DATA : REGISTER_DATA;
}

/* What is shorter than asked for is filled up with 0; a number of up to four bytes is one word. */
static void put_data(struct channel *channel, const void *data, size_t size)
{
    unsigned char *to = (unsigned char *)(uintptr_t)(channel->words + data_at(channel));
    const size_t room = channel->most == 4 ? 4 : channel->wanted;
    memcpy(to, data, size < room ? size : room);
    if (size < room)
        memset(to + size, 0, room - size);
}

static void get_data(const struct channel *channel, void *data, size_t size)
{
    memcpy(data, (const unsigned char *)(uintptr_t)(channel->words + data_at(channel)), size);
}

static enum channel_event fail(struct channel *channel, uint32_t code)
{
    volatile uint32_t *words = channel->words;
    channel->active = false;
    channel->job.abort = code;
    if (channel->failures != NULL && *channel->failures < INT32_MAX)
        ++*channel->failures;
    if (channel->kind == CHANNEL_SDO) {
        words[SDO_DATA] = code;
        words[SDO_STATUS] = (uint32_t)STATUS_ERROR;
        words[0] = READY;
    } else {
        words[REGISTER_DATA] = 0;
        words[0] = REGISTER_ERROR;
    }
    return CHANNEL_FAILED;
}

static enum channel_event succeed(struct channel *channel)
{
    volatile uint32_t *words = channel->words;
    const struct bus_job *job = &channel->job;
    channel->active = false;
    if (job->kind == BUS_SDO_READ || job->kind == BUS_REGISTER_READ)
        put_data(channel, job->data, job->size);
    if (channel->kind == CHANNEL_SDO)
        words[SDO_STATUS] = STATUS_OK;
    words[0] = READY;
    return CHANNEL_DONE;
}

static uint32_t code_of(const struct bus_job *job)
{
    switch (job->result) {
    case -EPROTO:
        return job->abort;
    case -ENOSPC:
        return CHANNEL_TOO_LONG;
    case -EOPNOTSUPP:
        return CHANNEL_NO_MAILBOX;
    case -EBADMSG:
        return CHANNEL_GENERAL;
    default:
        return CHANNEL_TIMEOUT;
    }
}

static bool nobody_there(const struct channel *channel, struct bus *bus)
{
    return bus == NULL || channel->slave >= bus_slave_count(bus) ||
           bus_slave(bus, channel->slave)->lost;
}

static bool length_fits(const struct channel *channel, uint32_t length)
{
    if (channel->most == 4)
        return length == 1 || length == 2 || length == 4;
    return length >= 1 && length <= channel->most;
}

static enum channel_event send(struct channel *channel, struct bus *bus)
{
    if (nobody_there(channel, bus))
        return fail(channel, CHANNEL_TIMEOUT);
    channel->wanted = channel->job.size;
    get_data(channel, channel->job.data, channel->job.size);
    channel->active = true;
    bus_job_start(bus, &channel->job);
    return CHANNEL_NOTHING;
}

static enum channel_event take_sdo(struct channel *channel, struct bus *bus, uint32_t control)
{
    volatile uint32_t *words = channel->words;
    const uint32_t length = words[SDO_LENGTH], index = words[SDO_INDEX],
                   subindex = words[SDO_SUBINDEX];
    words[SDO_STATUS] = STATUS_BUSY;
    if (control != READ && control != WRITE)
        return fail(channel, CHANNEL_BAD_COMMAND);
    if (index > 0xFFFF)
        return fail(channel, CHANNEL_NO_OBJECT);
    if (subindex > 0xFF)
        return fail(channel, CHANNEL_NO_SUBINDEX);
    if (!length_fits(channel, length))
        return fail(channel, CHANNEL_BAD_LENGTH);
    channel->job = (struct bus_job){
        .kind = control == READ ? BUS_SDO_READ : BUS_SDO_WRITE,
        .slave = channel->slave,
        .index = (uint16_t)index,
        .subindex = (uint8_t)subindex,
        /* Complete access begins at subindex 0 or 1. */
        .complete = subindex <= 1 && (channel->complete || length > 4),
        .size = length,
    };
    return send(channel, bus);
}

static enum channel_event take_register(struct channel *channel, struct bus *bus, uint32_t control)
{
    volatile uint32_t *words = channel->words;
    if (control != READ && control != WRITE)
        return CHANNEL_NOTHING; /* 3 and 4 are the host's */
    words[0] = REGISTER_BUSY;
    if (!length_fits(channel, words[REGISTER_LENGTH])) {
        if (channel->most != 4)
            return fail(channel, CHANNEL_BAD_LENGTH);
        words[REGISTER_LENGTH] = 4;
    }
    const uint32_t length = words[REGISTER_LENGTH], index = words[REGISTER_INDEX];
    if (!length_fits(channel, length) || index > 0x10000u - length)
        return fail(channel, CHANNEL_NO_OBJECT);
    channel->job = (struct bus_job){
        .kind = control == READ ? BUS_REGISTER_READ : BUS_REGISTER_WRITE,
        .slave = channel->slave,
        .index = (uint16_t)index,
        .size = length,
    };
    return send(channel, bus);
}

bool channel_asked(const struct channel *channel)
{
    const uint32_t control = channel->words[0];
    if (channel->active)
        return false;
    return channel->kind == CHANNEL_SDO ? control != READY : control == READ || control == WRITE;
}

enum channel_event channel_refuse(struct channel *channel)
{
    return fail(channel, CHANNEL_TIMEOUT);
}

enum channel_event channel_step(struct channel *channel, struct bus *bus)
{
    if (channel->active) {
        if (!channel->job.done)
            return CHANNEL_NOTHING;
        return channel->job.result == 0 ? succeed(channel) : fail(channel, code_of(&channel->job));
    }
    const uint32_t control = channel->words[0];
    if (control == READY)
        return CHANNEL_NOTHING;
    return channel->kind == CHANNEL_SDO ? take_sdo(channel, bus, control)
                                        : take_register(channel, bus, control);
}
