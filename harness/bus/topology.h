/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * topology.h - which way frames take through a segment: cables, ports, loops. segment.c alone
 * includes this; it asks for routes and hands frames to the slaves on them.
 *
 * Cable c leads from slave c - 1 (its port 1) to slave c (its port 0); cable 0 comes from the
 * master's port A, cable `count` goes to its port B. A controller processes what comes in at port 0
 * and passes on what comes in at port 1, unless its port 0 is closed: then that, too, goes through
 * its processing unit on the way round.
 */
#ifndef HARNESS_BUS_TOPOLOGY_H
#define HARNESS_BUS_TOPOLOGY_H

#include "bus/segment.h"

/* Links and loops as they are now, routes from them. */
void topology_update(struct segment *segment, uint64_t now_ns);

/* The frame that is about to go in at `port` is damaged where segment_damage_next() said, if it
 * comes by there: counts it at all slaves behind, and returns how many of the route's slaves
 * processed it before. The route's whole length when it does not come by. *damaged says which. */
size_t topology_damage(struct segment *segment, enum segment_port port, bool *damaged);

/* A valid frame ended at a port that keeps its loop closed until one comes: it opens. */
void topology_knock(struct segment *segment, const struct route *route);

#endif
