/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/pcap.h"
#include "bus/bytes.h"
#include "bus/segment.h"

#include <errno.h>
#include <string.h>

enum {
    MAGIC_NS = 0xa1b23c4d,
    VERSION = 4 << 16 | 2, /* 2.4, minor in the upper half */
    SNAP_LENGTH = 65535,
    LINKTYPE_ETHERNET = 1,
};

#define SECOND_NS UINT64_C(1000000000)

_Static_assert(PCAP_FRAME_MAX == SEGMENT_FRAME_MAX, "every frame fits a record");

static uint8_t *room(struct pcap *pcap, size_t size)
{
    if (pcap->used + size > PCAP_BUFFER)
        pcap_flush(pcap);
    pcap->used += size;
    return pcap->buffer + pcap->used - size;
}

static void record(struct pcap *pcap, uint64_t at_ns, const uint8_t *frame, size_t length)
{
    size_t padded = length < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : length;
    uint8_t *at = room(pcap, PCAP_RECORD_HEADER + padded);

    at_ns += pcap->epoch_ns;
    put_u32(at, (uint32_t)(at_ns / SECOND_NS));
    put_u32(at + 4, (uint32_t)(at_ns % SECOND_NS));
    put_u32(at + 8, (uint32_t)padded);
    put_u32(at + 12, (uint32_t)padded);
    memcpy(at + PCAP_RECORD_HEADER, frame, length);
    memset(at + PCAP_RECORD_HEADER + length, 0, padded - length);
    pcap->frames++;
}

/* Writes the earliest frame of those ahead. */
static void release(struct pcap *pcap)
{
    const struct pcap_ahead *slot = &pcap->slot[pcap->order[0]];
    uint8_t freed = pcap->order[0];

    record(pcap, slot->at_ns, slot->frame, slot->length);
    pcap->ahead--;
    memmove(pcap->order, pcap->order + 1, pcap->ahead);
    pcap->order[pcap->ahead] = freed; /* behind those in use: the free ones */
}

void pcap_open(struct pcap *pcap, enum pcap_kind kind, pcap_sink *sink, void *argument,
               uint64_t epoch_ns)
{
    uint8_t *header;

    pcap->sink = sink;
    pcap->argument = argument;
    pcap->epoch_ns = epoch_ns;
    pcap->error = 0;
    pcap->frames = 0;
    pcap->used = 0;
    pcap->ahead = 0;
    for (unsigned i = 0; i < PCAP_AHEAD; i++)
        pcap->order[i] = (uint8_t)i;
    if (kind == PCAP_RECORDS)
        return;
    header = room(pcap, PCAP_FILE_HEADER);
    memset(header, 0, PCAP_FILE_HEADER);
    put_u32(header, MAGIC_NS);
    put_u32(header + 4, VERSION);
    put_u32(header + 16, SNAP_LENGTH);
    put_u32(header + 20, LINKTYPE_ETHERNET);
}

void pcap_frame(struct pcap *pcap, uint64_t now_ns, const uint8_t *frame, size_t length)
{
    while (pcap->ahead && pcap->slot[pcap->order[0]].at_ns <= now_ns)
        release(pcap);
    record(pcap, now_ns, frame, length);
}

void pcap_frame_at(struct pcap *pcap, uint64_t at_ns, const uint8_t *frame, size_t length)
{
    struct pcap_ahead *slot;
    uint8_t taken;
    unsigned place;

    if (pcap->ahead == PCAP_AHEAD)
        release(pcap);
    taken = pcap->order[pcap->ahead];
    slot = &pcap->slot[taken];
    slot->at_ns = at_ns;
    slot->length = length;
    memcpy(slot->frame, frame, length);
    for (place = pcap->ahead++; place > 0; place--) {
        if (pcap->slot[pcap->order[place - 1]].at_ns <= at_ns)
            break;
        pcap->order[place] = pcap->order[place - 1];
    }
    pcap->order[place] = taken;
}

/* Length of the record that starts there, 0 when there is none. */
static size_t record_length(const uint8_t *at, size_t size)
{
    uint32_t length;

    if (size < PCAP_RECORD_HEADER)
        return 0;
    length = get_u32(at + 8);
    if (get_u32(at + 4) >= SECOND_NS || length != get_u32(at + 12) || length < SEGMENT_FRAME_MIN ||
        length > PCAP_FRAME_MAX || size - PCAP_RECORD_HEADER < length)
        return 0;
    return PCAP_RECORD_HEADER + length;
}

int pcap_append(struct pcap *pcap, const void *data, size_t size)
{
    const uint8_t *at = data;

    while (size > 0 && !pcap->error) {
        size_t length = record_length(at, size);

        if (!length) {
            pcap->error = -EBADMSG;
            break;
        }
        memcpy(room(pcap, length), at, length);
        pcap->frames++;
        at += length;
        size -= length;
    }
    return pcap->error;
}

int pcap_flush(struct pcap *pcap)
{
    int error = 0;

    if (pcap->used && (!pcap->error || pcap->error == -EBADMSG))
        error = pcap->sink(pcap->argument, pcap->buffer, pcap->used);
    pcap->used = 0;
    if (error && !pcap->error)
        pcap->error = error;
    return pcap->error;
}

int pcap_close(struct pcap *pcap)
{
    while (pcap->ahead)
        release(pcap);
    return pcap_flush(pcap);
}
