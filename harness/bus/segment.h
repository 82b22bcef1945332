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

#define SEGMENT_NO_CABLE SIZE_MAX

enum segment_port { SEGMENT_PORT_A, SEGMENT_PORT_B };

struct slave;

/* The way of a frame that goes in at one of the master's ports, as cables and loops are now. */
struct route {
    size_t first, end; /* slaves that process it: first .. end - 1; others pass it on */
    bool returns;      /* it comes back, at `exit` */
    enum segment_port exit;
    bool turned;          /* it reaches `first` from behind and turns round at its dead port 0 */
    uint32_t trip_ns;     /* from port to port */
    struct slave *knocks; /* it ends at this slave's closed port; NULL: it does not */
    unsigned knock_port;
};

struct segment {
    struct slave *slaves; /* wiring order; owned by the caller */
    size_t count;
    bool ring;                    /* the last slave's cable leads to the master's port B */
    bool cut[SEGMENT_SLAVES + 1]; /* cable behind slave i (from 1); 0: the master's port A */
    struct route route[2];        /* by port; they hold until routes_until_ns */
    uint64_t routes_until_ns;
    size_t damage; /* cable on which the next frame is damaged, or SEGMENT_NO_CABLE */
    struct plans plans;
};

/* Wires the slaves (initialised by slave_init, at most SEGMENT_SLAVES: more are left out) into a
 * line: link states, delays. The segment must stay where it is. */
void segment_init(struct segment *segment, struct slave *slaves, size_t count);

/* Connects or disconnects the master's port B. */
void segment_close_ring(struct segment *segment, bool ring, uint64_t now_ns);
/* Pulls or plugs the cable behind slave `behind` (from 1): 0 the master's port A, count the cable
 * to port B. The neighbours count a lost link, show it in DL status and close their loops: frames
 * turn round there. */
void segment_cable(struct segment *segment, size_t behind, bool plugged, uint64_t now_ns);
/* Switches slave `slave` (from 0) off or on; on is a power-on reset. Off, its neighbours lose their
 * links to it. */
void segment_power(struct segment *segment, size_t slave, bool on, uint64_t now_ns);
/* The next frame that comes along the cable behind slave `behind` (as above) is damaged there: the
 * slaves in front have processed it, the next one counts a receive error (0x0300), all after it a
 * forwarded one (0x0308), none of them processes it, and it does not come back. */
void segment_damage_next(struct segment *segment, size_t behind);

/* Sends one frame (without FCS) into the segment at *port and virtual time now_ns, which never goes
 * back between calls. True: the frame is back, same length, at *port. In an intact ring it comes
 * back at the other one: from A processed by all, from B by none. With the ring broken at one place
 * each port has its frame back, processed by the slaves on its side of the break, in wiring order;
 * those of port B come with the circulating bit set, for they turned round at a dead port 0. False:
 * nothing comes back; the frame was malformed, longer or shorter than Ethernet allows, or destroyed
 * by a slave. *back_ns (may be NULL): when its last byte reaches the master, by wire time at 100
 * Mbit/s and the slaves' delays. */
bool segment_transfer(struct segment *segment, enum segment_port *port, uint8_t *frame,
                      size_t length, uint64_t now_ns, uint64_t *back_ns);

#endif
