/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * plan.h - the way of a process data frame through a segment, worked out once.
 *
 * A master sends the same few frames every cycle: one logical datagram, and behind it perhaps the
 * FRMW that carries the reference clock's time round. For such a frame the plan lists which slave
 * it concerns, with which sync manager and where in the data; the frame then needs no search and no
 * arithmetic of addresses. Everything else, and everything unusual (a slave switched off, an open
 * cable, event requests on the way), goes the general way in segment.c, with the same result to the
 * last byte: tests/test_plan.c compares.
 *
 * Plans are void as soon as anything changes that they were made from: `changes` counts
 * (slave_changed() and the segment's own switches).
 */
#ifndef HARNESS_BUS_PLAN_H
#define HARNESS_BUS_PLAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PLAN_FRAMES 64   /* different frames remembered */
#define PLAN_STOPS  1024 /* slaves in all of them */

/* What tells frames apart. */
struct plan_shape {
    uint32_t address; /* logical */
    uint16_t length;  /* of the logical datagram's data */
    uint16_t station; /* of the reference clock */
    uint8_t command;  /* LRD, LWR or LRW */
    bool clock;       /* an FRMW of the system time follows */
};

struct slave;
struct syncman;

/* One sync manager of process data, whole. */
struct plan_move {
    struct syncman *sm;
    uint8_t *status; /* its status register */
    uint8_t *area;   /* its memory */
    uint16_t length;
    uint16_t at; /* in the data */
};

/* One slave on the way. */
struct plan_stop {
    struct slave *slave;
    uint8_t actions; /* PLAN_* of plan.c */
    struct plan_move read, write;
};

struct plan {
    struct plan_shape shape;
    uint16_t first, count; /* of the stops */
};

struct plans {
    bool off;         /* everything goes the general way */
    uint64_t served;  /* frames that went by a plan */
    uint32_t changes; /* of anything that plans depend on */
    uint32_t made_at; /* value of `changes` the plans below belong to */
    bool refused;     /* the segment is in no state for plans */
    bool marks;       /* some slave marks the source address */
    uint16_t count, last, stops;
    struct plan plan[PLAN_FRAMES];
    struct plan_stop stop[PLAN_STOPS];
};

struct segment;

/* Takes the frame round a line of which every slave answers. True: done; false: nothing has
 * happened, and the frame is one for the general way. */
bool plan_transfer(struct segment *segment, uint8_t *frame, size_t length, uint64_t now_ns);

#endif
