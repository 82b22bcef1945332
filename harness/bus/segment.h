/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * segment.h - a line of EtherCAT slaves: a raw Ethernet frame goes in at the first slave, passes
 * all of them in wiring order and comes back, changed in place. Knows nothing of any master.
 */
#ifndef HARNESS_BUS_SEGMENT_H
#define HARNESS_BUS_SEGMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SEGMENT_FRAME_MIN 60 /* Ethernet without FCS */
#define SEGMENT_FRAME_MAX 1514
#define SEGMENT_HOP_NS    700 /* from one processing unit to the next, one way */

struct slave;

struct segment {
    struct slave *slaves; /* wiring order; owned by the caller */
    size_t count;
};

/* Wires the slaves (initialised by slave_init) into a line: link states, delays. */
void segment_init(struct segment *segment, struct slave *slaves, size_t count);

/* Sends one frame (without FCS) into the segment at virtual time now_ns, which never goes back
 * between calls. True: the frame is back, same length, processed. False: nothing comes back; the
 * frame was malformed, longer or shorter than Ethernet allows, or destroyed by a slave.
 * *back_ns (may be NULL): when its last byte reaches the master, by wire time at 100 Mbit/s and
 * the slaves' delays. */
bool segment_transfer(struct segment *segment, uint8_t *frame, size_t length, uint64_t now_ns,
                      uint64_t *back_ns);

#endif
