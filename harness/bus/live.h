/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * live.h - the segment behind a network interface, in real time: frames that arrive there pass the
 * slaves and go back, for any EtherCAT master at the other end of the cable.
 *
 * The slaves' time is the monotonic clock since live_open(). One thread, no allocation after
 * live_open().
 *
 * A simulated slave must not answer on a plant's network by accident: unless told otherwise only
 * virtual cables are taken (veth pairs, taps) that lead to no bridge.
 */
#ifndef HARNESS_BUS_LIVE_H
#define HARNESS_BUS_LIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "bus/wire.h"

#define LIVE_WHY 512

enum live_timing {
    LIVE_AT_ONCE, /* answers leave as soon as they are there; what a fault delays still is late */
    LIVE_REAL,    /* and not before a real line of slaves could have sent them back */
};

struct live_config {
    const char *interface;
    struct wire *wire; /* outlives the live bus */
    enum live_timing timing;
    bool real_network; /* takes interfaces that may lead to a real network, too */
};

struct live_counts {
    uint64_t received; /* EtherCAT frames */
    uint64_t answered;
    uint64_t dropped; /* too long, malformed, lost on the segment, or refused by the interface */
    unsigned wkc;     /* sum of working counters of the last frame with logical commands */
};

struct live;

/* 0, or negative errno with a sentence in `why`: no such interface (which there are), down, not
 * allowed (rights, or the kind of interface). */
int live_open(struct live **out, const struct live_config *config, char why[LIVE_WHY]);
void live_close(struct live *live);

/* Time of the slaves, in ns. */
uint64_t live_now(const struct live *live);
const struct live_counts *live_counts(const struct live *live);

/* Serves until that time, or until a signal handler has run: 0. The slaves' time has then passed,
 * frames or not. Negative errno with a sentence in `why` when the interface is gone. */
int live_run(struct live *live, uint64_t until_ns, char why[LIVE_WHY]);

#endif
