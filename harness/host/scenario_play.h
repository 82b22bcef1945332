/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * scenario_play.h - a scenario being played: where it is, and what waits to be judged.
 *
 * Bound once, before the worker is sealed; nothing here allocates. Of every cycle it wants three
 * moments: its begin, before inputs are received, when statements that are due act; right behind
 * the receive, to see whether what was set stayed; and right behind Program_04, where the
 * oscilloscope samples, when expectations are judged (docs/decisions.md, H7).
 */
#ifndef HARNESS_HOST_SCENARIO_PLAY_H
#define HARNESS_HOST_SCENARIO_PLAY_H

#include "bus/bus.h"
#include "host/evidence.h"
#include "host/scenario_parts.h"

#define PLAY_NO_SLAVE SIZE_MAX

/* Where `set` and `input` lead. */
struct play_route {
    size_t slave;               /* PLAY_NO_SLAVE: to the memory */
    unsigned channel, channels; /* the first, and how many: bit n of the value is channel + n */
    bool word;                  /* each bit is a channel, otherwise all of the value is one */
};

struct play_state {
    bool active;
    uint64_t due_ns;   /* EVERY: the next time */
    uint64_t until_ns; /* the last moment */
};

struct play_block {
    size_t statement;
    uint64_t left;     /* rounds, with the one that is played */
    uint64_t began_ns; /* cycle in which the round began */
};

/* Where PLC control leads. */
typedef void play_control(void *argument, enum scenario_control what);

struct play {
    const struct scenario *scenario; /* NULL: none is played */
    struct evidence *evidence;
    struct bus *bus; /* NULL: none */
    uint64_t bus_zero, cycle_ns;
    play_control *control; /* NULL: there is none */
    void *control_argument;
    void *at[SCENARIO_REGISTERS];
    struct play_route route[SCENARIO_STATEMENTS];

    size_t next;
    uint64_t origin_ns, last_ns;
    struct play_block blocks[SCENARIO_BLOCKS];
    size_t depth;
    struct play_state state[SCENARIO_STATEMENTS];
    size_t active_count;
    /* What was set in this cycle: by which statement (counted from 1), which value. */
    uint32_t set_by[SCENARIO_REGISTERS];
    struct scenario_value set_to[SCENARIO_REGISTERS];
    size_t set_count;
};

/* Everything but evidence, bus, cycle_ns, at and route is set to the begin. */
void play_begin(struct play *play, uint64_t bus_zero);
void play_before(struct play *play, uint64_t cycle, uint64_t now_ns);
void play_received(struct play *play, uint64_t cycle, uint64_t now_ns);
void play_after(struct play *play, uint64_t cycle, uint64_t now_ns);

/* What an expression is worth now. */
struct scenario_value play_value(const struct play *play,
                                 const struct scenario_expression *expression);

#endif
