/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * segment.h - a line of EtherCAT slaves: a raw Ethernet frame goes in at one end, passes the slaves
 * in wiring order and comes back, changed in place. Knows nothing of any master.
 *
 * A master has one port (A, at the first slave) or, with redundancy, a second one (B, behind the
 * last). Every cable can be pulled and plugged, every slave switched off and on.
 */
#ifndef HARNESS_BUS_SEGMENT_H
#define HARNESS_BUS_SEGMENT_H

#include "bus/plan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SEGMENT_FRAME_MIN 60 /* Ethernet without FCS */
#define SEGMENT_FRAME_MAX 1514
#define SEGMENT_HOP_NS    700 /* from one processing unit to the next, one way */
#define SEGMENT_SLAVES    200 /* most slaves of one segment */

enum segment_port { SEGMENT_PORT_A, SEGMENT_PORT_B };

struct slave;

struct segment {
    struct slave *slaves; /* wiring order; owned by the caller */
    size_t count;
    bool ring;                    /* the last slave's cable leads to the master's port B */
    bool cut[SEGMENT_SLAVES + 1]; /* cable behind slave i (from 1); 0: the master's port A */
    struct plans plans;
};

/* Wires the slaves (initialised by slave_init) into a line: link states, delays. The segment must
 * stay where it is. */
void segment_init(struct segment *segment, struct slave *slaves, size_t count);

/* Every slave is switched on and reached from port A. */
bool segment_is_whole(const struct segment *segment);
/* Connects or disconnects the master's port B. */
void segment_close_ring(struct segment *segment, bool ring, uint64_t now_ns);
/* Pulls or plugs the cable behind slave `behind`: 0 the master's port A, count the cable to port B.
 */
void segment_cable(struct segment *segment, size_t behind, bool plugged, uint64_t now_ns);
/* Switches slave `slave` (from 0) off or on; on is a power-on reset. */
void segment_power(struct segment *segment, size_t slave, bool on, uint64_t now_ns);

/* Sends one frame (without FCS) into the segment at *port and virtual time now_ns, which never goes
 * back between calls. True: the frame is back, same length, processed, at *port (in a ring a frame
 * comes back at the other one). False: nothing comes back; the frame was malformed, longer or
 * shorter than Ethernet allows, or destroyed by a slave. *back_ns (may be NULL): when its last byte
 * reaches the master, by wire time at 100 Mbit/s and the slaves' delays. */
bool segment_transfer(struct segment *segment, enum segment_port *port, uint8_t *frame,
                      size_t length, uint64_t now_ns, uint64_t *back_ns);

#endif
