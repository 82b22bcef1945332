/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * rules.h - the rule book as data, and what a judgement is given.
 *
 * A judgement is a pure function from image and evidence to findings: no I/O, no globals, no early
 * exit. It fails its rule by adding a finding and declares it not judged by giving a reason;
 * severity, clause and advice come from rules.def.
 */
#ifndef CONFORMANCE_RULES_H
#define CONFORMANCE_RULES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "conformance/plan.h"
#include "conformance/profile.h"
#include "image/image.h"
#include "report/report.h"

/* What rules need evidence of: sets of experiments. */
#define NO_EXPERIMENT UINT64_C(0)
#define ON_START      EXPERIMENT_SET(START)
#define ON_NULL_DATA  EXPERIMENT_SET(NULL_DATA)
#define ON_SIZES                                                                                   \
    (EXPERIMENT_SET(SIZE_ZERO) | EXPERIMENT_SET(SIZE_OTHER) | EXPERIMENT_SET(SIZE_LESS) |          \
     EXPERIMENT_SET(SIZE_MORE))
#define ON_NULL_FUNCTIONS                                                                          \
    (EXPERIMENT_SET(NO_STRING) | EXPERIMENT_SET(NO_LONG) | EXPERIMENT_SET(NO_SWPRINTF) |           \
     EXPERIMENT_SET(NO_SLEEP))
#define ON_WRONG_ID (EXPERIMENT_SET(OLDER_ID) | EXPERIMENT_SET(NEWER_ID))
#define ON_CYCLES                                                                                  \
    (EXPERIMENT_SET(CYCLE_250) | EXPERIMENT_SET(CYCLE_500) | EXPERIMENT_SET(CYCLE_1000))
#define ON_EVERY_START (ON_START | ON_NULL_DATA | ON_SIZES | ON_NULL_FUNCTIONS | ON_WRONG_ID)
/* The same run under conditions that must not change what a module does. */
#define ON_POISON                                                                                  \
    (EXPERIMENT_SET(CYCLE_500) | EXPERIMENT_SET(REPEATED) | EXPERIMENT_SET(POISON_INVERTED) |      \
     EXPERIMENT_SET(POISON_ZERO))
#define ON_REPEATS    (EXPERIMENT_SET(CYCLE_500) | EXPERIMENT_SET(REPEATED) | EXPERIMENT_SET(PLACES))
#define ON_DATA_SIZES (EXPERIMENT_SET(DATA_LESS) | EXPERIMENT_SET(DATA_MORE))
#define ON_COUNTERS                                                                                \
    (EXPERIMENT_SET(COUNTERS) | EXPERIMENT_SET(COUNTERS_ZERO) | EXPERIMENT_SET(COUNTERS_FAR))
#define ON_RESTART  EXPERIMENT_SET(RESTART)
#define ON_INI_BODY EXPERIMENT_SET(TRACED_500)
#define ON_TRACED                                                                                  \
    (EXPERIMENT_SET(TRACED_250) | EXPERIMENT_SET(TRACED_500) | EXPERIMENT_SET(TRACED_1000))
#define ON_GOOD_RUNS (ON_START | ON_CYCLES)
/* The calm run is what a disturbed one is held against. */
#define ON_DISTURBED                                                                               \
    (EXPERIMENT_SET(LOST_FRAME) | EXPERIMENT_SET(LOST_FRAMES) | EXPERIMENT_SET(LATE_FRAMES) |      \
     EXPERIMENT_SET(SHORT_COUNTER) | EXPERIMENT_SET(CABLE) | EXPERIMENT_SET(SLAVE_RESET) |         \
     EXPERIMENT_SET(AL_ERROR) | EXPERIMENT_SET(WATCHDOG) | EXPERIMENT_SET(DRIVE_FAULT) |           \
     EXPERIMENT_SET(STUCK_INPUT) | EXPERIMENT_SET(CLOCK_DRIFT) | EXPERIMENT_SET(DRIVE_POWER) |     \
     EXPERIMENT_SET(TERMINAL_POWER) | EXPERIMENT_SET(MAILBOX))
#define ON_CALM      EXPERIMENT_SET(CYCLE_500)
#define ON_PREEMPTED EXPERIMENT_SET(PREEMPTED)
#define ON_SCENARIOS (UINT64_C(1) << 63) /* none of experiments.def: those that the user brings */

static inline bool experiment_in(uint64_t set, int id)
{
    return (set >> id & 1) != 0;
}

enum rule_group {
    GROUP_FILE,
    GROUP_START,
    GROUP_CYCLE,
    GROUP_DISTURBED,
    GROUP_PREEMPTED,
    GROUP_MACHINE,
    GROUP_COUNT
};

/* An experiment of experiments.def and what became of it. */
struct case_run {
    struct planned plan;
    bool ran;
    struct experiment_result result; /* valid when it ran */
};

/* A scenario and its experiment. */
struct case_scenario {
    const struct scenario *scenario;
    const char *name; /* of its file, as given */
    struct experiment experiment;
    struct experiment_result result;
    bool ran;
};

/* Everything a judgement may look at. */
struct case_file {
    const struct image *image;
    const struct profile *profile;
    const char *name;            /* file name of the module, without folders */
    const struct case_run *runs; /* by enum experiment_id */
    const struct case_scenario *scenarios;
    size_t scenario_count;
    const char *cannot_run; /* why no experiment could run; "" when they could */
};

/* Where a judgement puts what it found. Owned by the caller; FINDINGS_KEPT findings. */
struct findings {
    struct finding list[FINDINGS_KEPT];
    size_t count, dropped;
    char reason[FINDING_TEXT]; /* not judged, because; "" when judged */
    struct finding scratch;    /* takes the details of what is only counted */
};

typedef void rule_check(const struct case_file *, struct findings *);

struct rule {
    const char *id, *clause, *title, *advice;
    enum rule_group group;
    enum severity severity;
    uint64_t experiments; /* set of enum experiment_id, ON_SCENARIOS */
    rule_check *check;
};

/* By index, NULL past the end; by id, NULL when there is none. */
const struct rule *rule_at(size_t index);
const struct rule *rule_find(const char *id);
const char *rule_group_name(enum rule_group group);
/* docs/rules.md, and in it what is said of the rule, with code that breaks it and code that keeps
 * it: from its heading up to the next one. "" when that is older than the rule. */
extern const char rulebook_text[];
const char *rule_section(const struct rule *rule, size_t *length);
/*
 * Shell patterns with commas between them, one with '!' in front takes away: whether some pattern
 * fits (or all only take away), and none of those that do. NULL: every rule is.
 */
bool rule_selected(const char *patterns, const char *id);
/* Some pattern, to be had in idle, fits no rule at all: a slip of the pen, which would leave out or
 * let in what nobody meant to. */
#define RULE_PATTERN 128
bool rule_pattern_idle(const char *patterns, char idle[RULE_PATTERN]);
/* Some pattern, to be had in lone, asks for nothing but what is judged by scenarios. */
bool rule_pattern_needs_scenario(const char *patterns, char lone[RULE_PATTERN]);

/*
 * findings.c. The text is cut at FINDING_TEXT; control characters in it (names in a hostile file)
 * become
 * '?'. What was said before is counted, not repeated. Returns the finding for more detail, a
 * scratch one when it was counted or the list is full (dropped).
 */
struct finding *finding_add(struct findings *findings, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* The first reason stays. */
void finding_not_judged(struct findings *findings, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* "gantry.tgm+0x1a4 (Program_04) gantry.c:88" for an address of the module. */
void finding_place(struct finding *finding, const struct case_file *file, uint64_t vaddr);

/*
 * cases.c. The evidence of an experiment that got as far as it should have, whatever the module did
 * in it. NULL when there is none: the rule is then not judged, with the reason, or, where the
 * experiment is not for this product, simply has one case less.
 */
const struct evidence *case_evidence(const struct case_file *file, enum experiment_id id,
                                     struct findings *findings);
/* A flat image has handed out no functions: nothing of it was called but GetProcAddress. */
bool case_lacks_functions(const struct case_file *file, const struct evidence *evidence);
/* The evidence of a run that need not have come further than that. */
const struct evidence *case_loaded(const struct case_file *file, enum experiment_id id,
                                   struct findings *findings);
/* An emulated CPU lacks an instruction that the module executed in the run, which says nothing of
 * the module: not judged, with the place. */
bool case_unsupported(const struct case_file *file, enum experiment_id id,
                      struct findings *findings);
/* Of the cycles, too: not judged when the run ended before its last cycle. */
void case_complete(const struct case_file *file, enum experiment_id id, struct findings *findings);
const struct experiment *case_experiment(const struct case_file *file, enum experiment_id id);
/* Function, cycle and Cycle_Time of a finding. */
void finding_stamp(struct finding *finding, const struct experiment *experiment, enum entry entry,
                   uint64_t cycle);

/* incidents.c: calls that did not return as they should, as text and as findings. */
void incident_describe(const struct evidence_incident *incident, char text[FINDING_TEXT]);
/* The worker was ended by a signal that no module can have sent: a user, a limit, lack of memory.
 */
bool experiment_was_stopped(const struct experiment_result *result);
/* The access lay below the module's stack: a large local array, or recursion without end. */
bool incident_is_stack_overflow(const struct machine_fault *fault);
/* Where in the module it happened, or, when it happened outside, where the module had called from.
 */
void incident_place(const struct evidence_incident *incident, struct finding *finding,
                    const struct case_file *file);

#define RULE(symbol, ...) rule_check check_##symbol;
#include "conformance/rules.def"
#undef RULE

#endif
