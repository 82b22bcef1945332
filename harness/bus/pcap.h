/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pcap.h - a capture of what went over a cable: classic pcap with nanoseconds, link type Ethernet,
 * for Wireshark and everything else that reads it.
 *
 * Frames are written in the order of their times, though a frame's way back is known before the
 * next one is sent. No allocation and, until the buffer is full, no call of the sink.
 */
#ifndef HARNESS_BUS_PCAP_H
#define HARNESS_BUS_PCAP_H

#include <stddef.h>
#include <stdint.h>

#define PCAP_FILE_HEADER   24
#define PCAP_RECORD_HEADER 16
#define PCAP_FRAME_MAX     1514
#define PCAP_BUFFER        32768
#define PCAP_AHEAD         32 /* frames that may be known before their time */

/* Takes bytes, whole records at a time. 0 or negative errno. */
typedef int pcap_sink(void *argument, const void *data, size_t size);

enum pcap_kind {
    PCAP_FILE,    /* what a file holds */
    PCAP_RECORDS, /* without the file's header, for pcap_append() at the other end of a pipe */
};

struct pcap {
    pcap_sink *sink;
    void *argument;
    uint64_t epoch_ns; /* added to every time: 0 for simulated time, else wall time of time 0 */
    int error;         /* the first one; nothing is written after it */
    uint64_t frames;
    size_t used;
    unsigned ahead; /* entries of order[] */
    uint8_t order[PCAP_AHEAD];
    struct pcap_ahead {
        uint64_t at_ns;
        size_t length;
        uint8_t frame[PCAP_FRAME_MAX];
    } slot[PCAP_AHEAD];
    uint8_t buffer[PCAP_BUFFER];
};

void pcap_open(struct pcap *pcap, enum pcap_kind kind, pcap_sink *sink, void *argument,
               uint64_t epoch_ns);

/* A frame (without FCS) that goes over the cable now; shorter ones are padded as a network card
 * pads them. now_ns never goes back. */
void pcap_frame(struct pcap *pcap, uint64_t now_ns, const uint8_t *frame, size_t length);
/* One that is to come at at_ns, now or later. When more than PCAP_AHEAD are known, the earliest is
 * written at once. */
void pcap_frame_at(struct pcap *pcap, uint64_t at_ns, const uint8_t *frame, size_t length);

/* Records that another pcap handed to its sink. What is no record is refused, the rest with it:
 * -EBADMSG; or the error of the sink. */
int pcap_append(struct pcap *pcap, const void *data, size_t size);

/* Hands over what is buffered. 0, or the first error there was since pcap_open(). */
int pcap_flush(struct pcap *pcap);
/* The same with the frames whose time has not come. */
int pcap_close(struct pcap *pcap);

#endif
