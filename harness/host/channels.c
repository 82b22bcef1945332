/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The channels of all servos, I/O units and general devices, looked at once a cycle (M12). */
#include "host/host_parts.h"

static struct channel *add(struct host *host, enum channel_kind kind, volatile uint32_t *words,
                           unsigned most, size_t slave)
{
    struct channel *channel = &host->channels[host->channel_count++];
    *channel = (struct channel){ .kind = kind, .words = words, .most = most, .slave = slave };
    return channel;
}

static int channels_open(struct host *host, char why[HOST_WHY])
{
    (void)why;
    for (size_t i = 0; i < host->axis_count; i++) {
        const struct axis *axis = &host->axes[i];
        add(host, CHANNEL_SDO, &axis->reg->Sdo.Control, 4, axis->slave);
        add(host, CHANNEL_REGISTER, &axis->reg->ecatRegister.Control, 4, axis->slave);
    }
    for (size_t i = 0; i < host->terminal_count; i++) {
        const struct terminal *terminal = &host->terminals[i];
        add(host, CHANNEL_SDO, &terminal->reg->Sdo.Control, 4, terminal->slave)->failures =
            &terminal->reg->sdoResponseTries;
        add(host, CHANNEL_REGISTER, &terminal->reg->ecatRegister.Control, 4, terminal->slave);
    }
    return 0;
}

void channel_log(struct host *host, const struct channel *channel, enum channel_event event)
{
    const struct bus_job *job = &channel->job;
    if (event == CHANNEL_NOTHING || channel->kind != CHANNEL_SDO)
        return;
    const char *what = job->kind == BUS_SDO_READ ? "read" : "write";
    if (event == CHANNEL_DONE)
        console_log(host, TGM_LOG_ETHERCAT_SDO, CONSOLE_SLAVES, CONSOLE_INFO,
                    "slave %zu: SDO %s 0x%04X:%02X, %zu bytes", channel->slave + 1, what,
                    job->index, job->subindex, job->size);
    else
        console_log(host, TGM_LOG_ETHERCAT_SDO, CONSOLE_SLAVES, CONSOLE_WARNING,
                    "slave %zu: SDO %s 0x%04X:%02X failed: 0x%08X", channel->slave + 1, what,
                    job->index, job->subindex, job->abort);
}

static void channels_receive(struct host *host)
{
    for (size_t i = 0; i < host->channel_count; i++)
        channel_log(host, &host->channels[i], channel_step(&host->channels[i], host->bus));
}

const struct host_part host_channels = { .name = "channels",
                                         .open = channels_open,
                                         .receive = channels_receive };
