/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * report.h - a verdict as data, and the forms it is printed in.
 *
 * A leaf: it knows nothing of modules, rules or experiments, only of what was found. Filled by
 * conformance/check.c.
 */
#ifndef HARNESS_REPORT_REPORT_H
#define HARNESS_REPORT_REPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum severity { SEVERITY_MUST, SEVERITY_SHOULD, SEVERITY_NOTE };
enum rule_outcome { RULE_PASSED, RULE_FAILED, RULE_NOT_JUDGED };
enum verdict { VERDICT_PASS, VERDICT_FAIL, VERDICT_INCOMPLETE };

#define FINDING_TEXT  512
#define FINDINGS_KEPT 16 /* of one rule; more are counted, not kept */

/* One fault, however often it happened. */
struct finding {
    char what[FINDING_TEXT];  /* what was seen, one sentence without full stop */
    char when[64];            /* "in cycle 200 at Cycle_Time 500 us", "" when it has no time */
    char place[FINDING_TEXT]; /* "gantry.tgm+0x1a4 (Program_04) gantry.c:88", "" when it has none */
    char
        again[FINDING_TEXT]; /* command line that shows it again, "" when the file alone shows it */
    const char *function;    /* entry function, NULL when it is not about one */
    bool has_cycle;
    uint64_t cycle;
    uint64_t count; /* times seen, at least 1 */
};

struct rule_report {
    const char *id, *group, *clause, *title, *advice;
    enum severity severity;
    enum rule_outcome outcome;
    char reason[FINDING_TEXT]; /* why it could not be judged */
    struct finding *findings;
    size_t finding_count;
    size_t dropped; /* findings beyond FINDINGS_KEPT */
};

struct group_report {
    const char *name; /* "file", "start", "cycle" */
    double seconds;   /* wall time spent on it */
    char note[128];   /* "250 / 500 / 1000 us, 20 000 cycles each" */
};

struct report {
    const char *tool; /* "tgm 0.1.0" */
    const char *path;
    uint64_t size; /* bytes of the module */
    const char *sha256, *format, *target;
    const char *profile, *profile_title;
    uint64_t seed;
    const char *selection; /* pattern of the rules that were asked for, NULL: all */
    uint64_t cycles; /* of each run, as asked for; 0: as the suite has them */
    struct rule_report *rules;
    size_t rule_count;
    struct group_report *groups;
    size_t group_count;
    unsigned passed, failed, not_judged;
    enum verdict verdict;
};

const char *severity_name(enum severity severity);
const char *outcome_name(enum rule_outcome outcome);
const char *verdict_name(enum verdict verdict);

/* For people. colour: escape sequences are used. The last line is "RESULT: ...". */
void report_text(const struct report *report, FILE *stream, bool colour);

/* Schema tgm-check/1 (docs/json.md). 0 or negative errno when the stream cannot be written. */
int report_json(const struct report *report, FILE *stream);

#endif
