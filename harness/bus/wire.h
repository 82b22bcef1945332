/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * wire.h - a segment as a master's network ports meet it: with the faults of a script and with a
 * capture of what went over the cable. The same wire serves SOEM in this process and any master
 * behind a network interface.
 */
#ifndef HARNESS_BUS_WIRE_H
#define HARNESS_BUS_WIRE_H

#include "bus/segment.h"

struct faults;
struct pcap;

/* A frame that reaches the master. */
struct wire_frame {
    enum segment_port port;
    uint64_t back_ns;
    size_t length;
    uint8_t bytes[SEGMENT_FRAME_MAX];
};

struct wire {
    struct segment *segment;
    struct faults *faults; /* NULL: nothing goes wrong */
    struct pcap *capture;  /* NULL: no capture */
    bool has_extra;
    struct wire_frame extra;
};

/* As segment_transfer(), with time passing for the script first. No allocation. */
bool wire_transfer(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                   uint64_t now_ns, uint64_t *back_ns);

/* What else comes back because of the last wire_transfer(), behind the frame it returned: call
 * until NULL. Valid until the next wire_transfer(), which forgets what was not asked for. */
const struct wire_frame *wire_extra(struct wire *wire);

#endif
