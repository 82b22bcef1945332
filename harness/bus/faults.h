/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * faults.h - what goes wrong on a segment, and when: by a script on the virtual clock, or by single
 * commands.
 *
 * A script has one statement a line and comments behind #:
 *
 *     at 250ms unplug after 2
 *     from 1s to 2s lose 1% frames seed 7
 *     every 500ms mailbox 1 silent for 20ms
 *
 * docs/faults.md describes the language; the verbs are the rows of fault_verbs.c. A fault that
 * lasts is undone at its end: whatever else is still wrong with the same slave, cable or input
 * stays wrong. The same script, seed and frames give the same faults, byte for byte.
 */
#ifndef HARNESS_BUS_FAULTS_H
#define HARNESS_BUS_FAULTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"

#define FAULTS_WHY        BUS_WHY
#define FAULTS_TEXT       80
#define FAULTS_STATEMENTS 1000 /* most statements of one script */
#define FAULTS_COMMANDS   64   /* most faults by command that last at the same time */
#define FAULTS_LOG        256  /* events that are remembered */

struct faults;
struct fault_verb;
struct segment;

/* Which frames a fault is about. */
enum fault_pick {
    FAULT_PICK_NEXT,   /* `frame`, or nothing: the next one */
    FAULT_PICK_NUMBER, /* `frame N`: the n-th since the script began, from 1 */
    FAULT_PICK_COUNT,  /* `N frames`: the next N */
    FAULT_PICK_ALL,    /* `frames`: every one while it lasts */
    FAULT_PICK_SHARE,  /* `P% frames`: some, by chance */
};

/* One fault as data: a verb and its arguments. Which of them mean something is the verb's matter.
 * Parsing and applying are apart so that a scenario can be checked before it runs. */
struct fault_action {
    const struct fault_verb *verb;
    unsigned given;    /* bit n: the verb's n-th optional part is there */
    size_t place;      /* slave, from 1; cable: the slave it is behind, 0 the master's port */
    unsigned channel;  /* of inputs, from 0 */
    unsigned axis;     /* from 1 */
    unsigned al_state; /* AL_* of registers.h */
    uint32_t code;     /* AL status, SDO abort or drive fault code */
    uint16_t index;    /* object */
    int16_t subindex;  /* negative: every one */
    int64_t value;     /* of inputs; of clocks in ppb */
    uint64_t time_ns;  /* argument of the verb */
    uint64_t seed;
    bool seeded; /* the statement says so itself */
    enum fault_pick pick;
    uint64_t pick_number;   /* N; of SHARE: in millionths */
    uint64_t lasts_ns;      /* `for`; 0: not given */
    char text[FAULTS_TEXT]; /* as it was written, for people */
};

/* Reads a script and holds it against the segment: a slave that does not exist or cannot have the
 * fault is an error. Faults that are there from the `start` come with the next call. 0, -ENOMEM or
 * -EINVAL with "name:line:column: what; expected ..." in `why`. `seed` is for statements that name
 * none. The text may go away afterwards, the segment may not. An empty script is a script. */
int faults_open(struct faults **out, const char *text, size_t length, const char *name,
                struct segment *segment, uint64_t seed, char why[FAULTS_WHY]);
void faults_close(struct faults *faults);

/* Script time 0 is this bus time, and frames count from here. Nothing but what is marked `start`
 * happens before. Calls after the first change nothing. */
void faults_begin(struct faults *faults, uint64_t zero_ns);
/* Applies what is due up to now_ns, each at its own time. No allocation, here and below. */
void faults_advance(struct faults *faults, uint64_t now_ns);

/* One action without a time, with or without `for`: "unplug after 2", "lose 3 frames". 0, or
 * -EINVAL with "line:column: ..." left out of the reason when there is only one line to speak of.
 */
int fault_parse(struct fault_action *action, const char *text, const struct segment *segment,
                char why[FAULTS_WHY]);
/* The same, to hear only whether it would be one: "PLACE:column: what; expected ...". */
int fault_check(const char *text, const struct segment *segment, const char *place,
                char why[FAULTS_WHY]);
/* Applies it now. 0, or -ENOSPC with a reason when FAULTS_COMMANDS of them still last. */
int faults_apply(struct faults *faults, const struct fault_action *action, uint64_t now_ns,
                 char why[FAULTS_WHY]);
/* Both. */
int faults_command(struct faults *faults, const char *text, uint64_t now_ns, char why[FAULTS_WHY]);

/* What becomes of one frame. */
struct fault_fate {
    bool lose, lose_back;           /* in front of the slaves; behind them */
    bool duplicate, duplicate_back; /* passes the slaves twice; comes back twice */
    bool damage;
    size_t damage_behind;
    uint64_t delay_ns;
};

/* A frame is about to be sent; false: nothing happens to it. Time must have been advanced. */
bool faults_frame(struct faults *faults, uint64_t now_ns, struct fault_fate *fate);

/* What was applied, numbered from 0. False: not yet. Its text is empty when FAULTS_LOG more have
 * come since. */
bool faults_event(const struct faults *faults, uint64_t number, struct bus_fault_event *event);

/* The language, for documents and completion: NULL past the end. */
struct fault_verb_text {
    const char *name, *grammar, *help, *example;
};
bool fault_verb_text(size_t index, struct fault_verb_text *text);

#endif
