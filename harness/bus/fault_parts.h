/* SPDX-License-Identifier: GPL-2.0-or-later */
/* fault_parts.h - what the parts of the fault script owe each other; nobody else includes this. */
#ifndef HARNESS_BUS_FAULT_PARTS_H
#define HARNESS_BUS_FAULT_PARTS_H

#include "bus/faults.h"
#include "bus/segment.h"
#include "bus/slave.h"

#define FAULT_NEVER    UINT64_MAX
#define FAULT_CYCLE_NS 100000000 /* how long `power cycle` takes unless it says so */

/* What is wrong while a fault lasts. Faults of one kind at one place are undone together with the
 * last of them. */
enum fault_kind {
    FAULT_MOMENT, /* over at once */
    FAULT_FRAMES,
    FAULT_CABLE,
    FAULT_POWER,
    FAULT_MUTE,
    FAULT_INPUT,
    FAULT_SLAVE, /* something in struct slave_faults */
};

enum fault_phase { FAULT_IDLE, FAULT_WAITING, FAULT_ACTIVE, FAULT_OVER };

/* When a statement happens; times are those of the script. */
struct fault_schedule {
    bool from_start;   /* there since the bus was switched on */
    uint64_t at_ns;    /* (first) begin */
    uint64_t to_ns;    /* undone then, and not begun from then on; FAULT_NEVER */
    uint64_t every_ns; /* 0: once */
    uint64_t frame;    /* instead of a time: in front of that frame; 0: none */
};

struct fault_statement {
    struct fault_schedule when;
    struct fault_action action;

    enum fault_phase phase;
    uint64_t next_ns;   /* bus time of the next begin or end */
    uint64_t resume_ns; /* of the next begin of `every` */
    uint64_t random;
    uint64_t left;       /* frames still to be hit */
    uint64_t seen, hits; /* frames while it lasts */
    int64_t base;        /* what the input is held at, or goes up and down around */
    int64_t before;      /* what it showed */
};

/* One row of the language. `grammar` are the words behind the name: lower case as it stands, upper
 * case an argument (fault_script.c), brackets an optional part. Several rows may share a name. */
struct fault_verb {
    const char *name, *grammar, *help, *example;
    enum fault_kind kind;
    uint64_t lasts_ns; /* unless said otherwise; 0: for good */
    unsigned most;     /* how many a slave can have at once; 0: any number */
    /* Can this slave have the fault? NULL, or what could. */
    const char *(*refuse)(const struct fault_action *, const struct slave *);
    void (*begin)(struct faults *, struct fault_statement *, uint64_t now_ns);
    void (*end)(struct faults *, struct fault_statement *, uint64_t now_ns);
    /* FAULT_SLAVE: adds to what is wrong with the slave while the fault lasts. */
    void (*effect)(const struct fault_action *, struct slave_faults *);
    /* FAULT_FRAMES: what becomes of a frame that it hits. */
    void (*strike)(const struct fault_action *, struct fault_fate *);
    /* Inputs that change with every frame. */
    void (*shake)(struct faults *, struct fault_statement *, uint64_t now_ns);
};

struct faults {
    struct segment *segment;
    struct fault_statement *statements; /* of the script, then room for commands */
    size_t script_count, count, room;
    uint64_t seed, commands;
    bool begun;
    uint64_t zero_ns, frames; /* since the script began */
    uint64_t due_ns;          /* earliest next_ns */
    bool watching, shaking;   /* a statement wants to see every frame */
    bool changed;             /* the three above may be out of date */
    uint64_t logged;
    struct bus_fault_event log[FAULTS_LOG];
};

/* fault_verbs.c */
const struct fault_verb *fault_verb(size_t index); /* NULL past the end */

/* fault_script.c: reads a script into rows (enough of them, or NULL); *count: how many there are.
 */
int fault_script_read(const char *text, size_t length, const char *name,
                      const struct segment *segment, struct fault_statement *rows, size_t *count,
                      char why[FAULTS_WHY]);

/* faults.c, for the verbs */
void faults_note(struct faults *faults, uint64_t now_ns, const char *text, const char *remark);
/* The slave that a statement is about, with time passed up to now_ns. */
struct slave *faults_slave(struct faults *faults, const struct fault_statement *statement,
                           uint64_t now_ns);
/* The last statement of that kind that is active at the place of this one, or NULL. */
struct fault_statement *faults_still(struct faults *faults,
                                     const struct fault_statement *statement);
/* Ends what is active of a kind; place as in the action. */
void faults_finish(struct faults *faults, enum fault_kind kind, size_t place, uint64_t now_ns);
/* Ends everything; place 0: everywhere, otherwise what is wrong with that slave. */
void faults_mend(struct faults *faults, size_t place, uint64_t now_ns);

#endif
