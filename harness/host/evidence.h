/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * evidence.h - what one experiment saw.
 *
 * A plain block of fixed size that the worker process fills as it goes and the parent reads when
 * the worker is gone, however it went. To the parent it is untrusted: counts are clamped and texts
 * terminated by evidence_clean() before anybody looks. Rules judge from it and from nothing else.
 */
#ifndef HARNESS_HOST_EVIDENCE_H
#define HARNESS_HOST_EVIDENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"
#include "host/audit.h"
#include "host/coverage.h"
#include "host/digest.h"
#include "host/product.h"
#include "host/realtime.h"
#include "host/scenario_value.h"
#include "host/sketch.h"
#include "machine/machine.h"

#define EVIDENCE_INCIDENTS  16
#define EVIDENCE_MESSAGES   32
#define EVIDENCE_TEXT       240
#define EVIDENCE_AXES       4
#define EVIDENCE_FAULTS     128
#define EVIDENCE_FAILURES   32
#define EVIDENCE_VALUES     8
#define EVIDENCE_LINES      64
#define EVIDENCE_EEPROM     2752
#define EVIDENCE_INTERRUPTS 64
#define EVIDENCE_RACES      16

/* Where in the run something was. Cycle counts from 0; before the first cycle it is
 * EVIDENCE_NO_CYCLE. */
#define EVIDENCE_NO_CYCLE UINT64_MAX

struct evidence_calls {
    uint64_t count;     /* calls that returned */
    int32_t last_value; /* low 32 bits of the latest result */
    bool disabled;      /* not called any more after a fault or hang */
};

/* A call that did not return as it should. The pointers inside outcome.fault are not used here. */
struct evidence_incident {
    enum entry entry;
    uint64_t cycle;
    enum machine_outcome_kind kind;
    struct machine_fault fault;
    char service[MACHINE_REGION_NAME]; /* host service running for the module, "" when none */
};

struct evidence_message {
    enum entry entry;
    uint64_t cycle;
    int32_t severity;
    bool of_host;             /* of TG Motion itself; entry is then of no meaning */
    uint32_t source;          /* enum console_source, or what the module gave as id */
    char text[EVIDENCE_TEXT]; /* UTF-8, without trailing line ends */
};

/* A call that was interrupted. */
struct evidence_interrupt {
    enum entry entry; /* whose call */
    unsigned by;      /* functions that were called meanwhile: bit n is enum entry n */
    uint64_t cycle;
    uint64_t pc;           /* module address of the instruction before which it was */
    uint64_t instructions; /* of the call before it; 0 on the real clock */
};

/* What an interrupt that was tried out led to. */
enum evidence_race_kind {
    RACE_NEITHER, /* a word has a value that it has in neither uninterrupted order */
    RACE_MIXED,   /* of what one function leaves, one word is of the one order, one of the other */
    RACE_FAILED   /* a function did not return that returns in both orders */
};

/* A word of memory, eight bytes at a multiple of eight. */
struct evidence_word {
    int32_t memory;         /* of the catalogue, by index; -1: the module's own data */
    uint32_t bit;           /* first of the 32 that are wrong: 0 or 32 */
    uint64_t offset;        /* in that memory; of the module's own: its address */
    uint64_t first, second; /* values after: the interrupted function first, the other first */
    uint64_t found;         /* and when it was interrupted */
};

/* The first of its kind; what is the same of another cycle or instruction is counted. */
struct evidence_race {
    enum evidence_race_kind kind;
    enum entry entry, by;
    uint64_t cycle, count;
    uint64_t pc, instructions;     /* before which instruction, as of an interrupt */
    struct evidence_word words[2]; /* RACE_MIXED: of the order entry-by, of by-entry; else one */
    bool has_by_pc;
    uint64_t by_pc; /* where the interrupting function touches what both use */
    bool by_writes;
    struct evidence_word shared; /* what it touches there */
    enum entry failed;           /* RACE_FAILED: who */
    enum machine_outcome_kind outcome;
    struct machine_fault fault;
};

/* Something that went wrong on the bus because the experiment wanted it. */
struct evidence_fault {
    int64_t time_ns; /* simulated; below 0: before the first cycle */
    char text[BUS_FAULT_TEXT];
};

/* An axis that was to move, and could not: its drive reported a fault, or was not in OP, or did not
 * answer, after it had been in OP. (unable.c) */
struct evidence_unable {
    uint64_t cycles; /* in which it was so */
    uint64_t driven; /* of them, UNABLE_GRACE_NS after it began and later: its set-point moved on */
    uint64_t cycle;  /* the first of these; and what was so then */
    uint32_t al_state;
    bool fault;
    double distance; /* inc: from the axis to its set-point */
};

/* How far a scenario got. */
enum evidence_play {
    PLAY_NONE,     /* there was none */
    PLAY_RUNNING,  /* not at its end when the experiment was */
    PLAY_DONE,     /* to its end */
    PLAY_GIVEN_UP, /* what it waited for did not come: the rest was not played */
};

enum evidence_failure_kind {
    FAILURE_EXPECTATION, /* what the statement expects or waits for was not so */
    FAILURE_NO_FIT,      /* the register cannot hold values[0] */
    FAILURE_OVERWRITTEN, /* TG Motion writes the register itself: values[0] did not stay */
    FAILURE_REFUSED      /* the bus took neither the input's values[0] nor the fault */
};

/* A statement of a scenario that failed, the first time it did. */
struct evidence_failure {
    uint32_t statement;
    enum evidence_failure_kind kind;
    uint64_t cycle, time_ns;
    uint64_t count; /* times it failed in this way */
    uint32_t value_count;
    struct scenario_value values[EVIDENCE_VALUES]; /* of the registers it reads, in order */
};

/* A `log` of a scenario. */
struct evidence_line {
    uint32_t statement;
    uint64_t time_ns;
    struct scenario_value value; /* of its expression */
};

/* What is stored in the EEPROM: from the file at first, then what was saved. */
struct evidence_eeprom {
    bool saved;    /* something was, in this run */
    uint32_t size; /* bytes; 0: never saved */
    uint8_t data[EVIDENCE_EEPROM];
};

/* What GetProcAddress of a flat image returned when it was loaded last. */
struct evidence_lookup {
    bool asked;
    bool found;     /* the table lies in the module's memory; without: functions mean nothing */
    uint32_t table; /* its address */
    uint32_t functions[ENTRY_COUNT]; /* as many as the product asks for; bit 0: Thumb code */
};

enum evidence_stage {
    EVIDENCE_NOTHING, /* the worker did not get as far as loading */
    EVIDENCE_LOADED,
    EVIDENCE_CALLING, /* inside a call: see entry, cycle */
    EVIDENCE_BETWEEN, /* between calls */
    EVIDENCE_FINISHED /* everything the experiment asked for was done */
};

struct evidence {
    enum evidence_stage stage;
    enum entry entry; /* of the latest call */
    uint64_t cycle;   /* of the latest call */
    uint64_t cycles_done;
    uint64_t time_ns; /* simulated */

    /* For the status line of `tgm run`; the bus as the host last saw it. */
    unsigned servo_count; /* register groups with an axis; of the first ones: */
    unsigned axis_count;
    double axis_position[EVIDENCE_AXES]; /* inc */
    bool all_op;
    struct evidence_calls calls[ENTRY_COUNT];
    uint64_t called_cycle[ENTRY_COUNT]; /* of the latest call of each */
    struct evidence_unable unable[EVIDENCE_AXES];

    unsigned incident_count; /* stored; all that happened are stored, a function is disabled by its
                                first */
    struct evidence_incident incidents[EVIDENCE_INCIDENTS];

    uint64_t message_count; /* all; the first EVIDENCE_MESSAGES are stored */
    struct evidence_message messages[EVIDENCE_MESSAGES];

    uint64_t fault_count; /* all; the first EVIDENCE_FAULTS are stored */
    struct evidence_fault faults[EVIDENCE_FAULTS];

    enum evidence_play play;
    uint64_t checked; /* expectations that were judged, each time they were */
    uint64_t failed;  /* of them, and of what the scenario could not do */
    unsigned failure_count;
    struct evidence_failure failures[EVIDENCE_FAILURES]; /* the first */
    uint64_t line_count;                                 /* all; the first are stored */
    struct evidence_line lines[EVIDENCE_LINES];

    struct evidence_eeprom eeprom;
    uint64_t interrupt_count; /* all; the first EVIDENCE_INTERRUPTS are stored */
    struct evidence_interrupt interrupts[EVIDENCE_INTERRUPTS];

    /* PREEMPT_TRIED: calls that were, interrupts of them; how many went wrong, of those the first.
     */
    uint64_t tried_calls, tried_points, race_total;
    unsigned race_count;
    struct evidence_race races[EVIDENCE_RACES];

    unsigned loads;    /* of the module, besides the first */
    bool instrumented; /* the emulated CPU ran it */
    struct evidence_lookup lookup;
    struct evidence_clock clock;

    uint64_t op_cycle;   /* first cycle with every slave in OP, EVIDENCE_NO_CYCLE when never */
    uint64_t wkc_errors; /* exchanges with a working counter below the expected one, once in OP */
    size_t stack_used;   /* bytes */
    unsigned slaves;
    struct digest digest;
    struct coverage coverage; /* on the instrumented machine */
    struct sketch sketch; /* of the first axes; no row without a bus */

    struct audit_record audit; /* audit.h */

    volatile bool stop; /* the parent wants the run to end */

    char trouble[MACHINE_WHY]; /* the harness itself could not go on: why; "" when all is well */
};

/* Who a message is from: "Program_04", "EtherCAT master" ... */
const char *evidence_speaker(const struct evidence_message *message);

/* Makes a block that a worker wrote safe to read. */
void evidence_clean(struct evidence *evidence);

#endif
