/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * CAN as a module sees it (R9): pReciveDataCan1 and, in generation 4, pReciveDataCan2 lead to 2048
 * entries, one for every identifier. Without a script (--can) there is no CAN: both are NULL.
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* RECEIVE_DATA_CAN; the headers of generation 4 do not name it. */
struct entry_can {
    uint8_t data[8];
    uint32_t length;
    uint32_t fresh; /* counts telegrams; the module may set it to 0 */
};

_Static_assert(sizeof(struct entry_can) == CAN_ENTRY_BYTES, "size of RECEIVE_DATA_CAN");

static void offer(struct host *host, unsigned channel, void *memory)
{
    static const size_t members[] = {
        offsetof(PLC_DATA, GENERATION(PReciveDataCan1, pReciveDataCan1)),
#if TGM_GENERATION == 4
        offsetof(PLC_DATA, PReciveDataCan2),
#endif
    };
    for (int entry = 0; entry < ENTRY_COUNT; entry++)
        plc_data_put(host, (enum entry)entry, members[channel], (uintptr_t)memory);
}

static int can_memory_open(struct host *host, char why[HOST_WHY])
{
    static const char *const names[CAN_CHANNELS] = { "CAN_1", "CAN_2" };
    char text[CAN_WHY];
    if (host->config.can == NULL)
        return 0;
    const char *name = host->config.can_name != NULL ? host->config.can_name : "can";
    int r = can_open(&host->can, host->config.can, name, host->config.product->can_buffer, text);
    if (r != 0)
        snprintf(why, HOST_WHY, "%s", text);
    if (r == 0 && host->config.can_kbit != 0)
        host->can.kbit[0] = host->config.can_kbit;
    for (unsigned i = 0; i < GENERATION(CAN_CHANNELS, 1) && r == 0; i++) {
        void *module;
        r = machine_map(host->machine, names[i], CAN_IDS * sizeof(struct entry_can),
                        MACHINE_REGION_READ_WRITE, &host->can_memory[i], &module, why);
        if (r == 0)
            offer(host, i, module);
    }
    host->system->Main.PLC_CAN_BaudRate = host->can.kbit[0];
    return r;
}

static void store(struct host *host, unsigned channel, const struct can_frame *frame)
{
    struct entry_can *entry = host->can_memory[channel];
    if (entry == NULL)
        return;
    entry += frame->id;
    memcpy(entry->data, frame->data, sizeof entry->data);
    entry->length = frame->length;
    entry->fresh = entry->fresh == UINT32_MAX ? 1 : entry->fresh + 1;
    console_log(host, TGM_LOG_CAN, CONSOLE_MAIN, CONSOLE_INFO, "CAN %u: received 0x%03X, %u bytes",
                channel + 1, (unsigned)frame->id, (unsigned)frame->length);
}

static void can_memory_slot(struct host *host)
{
    unsigned channel;
    struct can_frame frame;
    if (host->config.can == NULL)
        return;
    while (can_receive(&host->can, host->now_ns, &channel, &frame))
        store(host, channel, &frame);
    host->system->Main.CAN_Transmit_Buffer_Fullness = can_waiting(&host->can, 0, host->now_ns);
}

/* Number 2 is the second channel, in generation 4; 0 and 1 are the first. */
int32_t can_send(struct host *host, uint32_t number, uint32_t id, uint32_t length,
                 const uint8_t *data, bool remote)
{
    const unsigned channel = number == 2 ? 1 : 0;
    struct can_frame frame = { .id = id, .remote = remote, .length = (uint8_t)length };
    if (host->config.can == NULL || number > GENERATION(2, 1) || length > sizeof frame.data)
        return 0;
    if (!remote)
        memcpy(frame.data, data, length);
    const bool sent = can_transmit(&host->can, channel, &frame, host->now_ns);
    if (channel == 0)
        host->system->Main.CAN_Transmit_Buffer_Fullness = can_waiting(&host->can, 0, host->now_ns);
    console_log(host, TGM_LOG_CAN, CONSOLE_MAIN, sent ? CONSOLE_INFO : CONSOLE_WARNING,
                "CAN %u: %s 0x%03X, %u bytes", channel + 1, sent ? "sent" : "not sent",
                (unsigned)id, (unsigned)length);
    return sent;
}

const struct host_part host_can = { .name = "can",
                                    .open = can_memory_open,
                                    .slot = can_memory_slot };
