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
#define AGAIN_TEXT    1024
#define FINDINGS_KEPT 16 /* of one rule; more are counted, not kept */

/* One fault, however often it happened. */
struct finding {
    char what[FINDING_TEXT];  /* what was seen, one sentence without full stop */
    char when[64];            /* "in cycle 200 at Cycle_Time 500 us", "" when it has no time */
    char place[FINDING_TEXT]; /* "gantry.tgm+0x1a4 (Program_04) gantry.c:88", "" when it has none */
    char again[AGAIN_TEXT];   /* command line that shows it again, "" when it would be too long */
    char debug[AGAIN_TEXT + FINDING_TEXT]; /* the same run under a debugger, "" when there is none */
    uint32_t plain_us;    /* Cycle_Time of the run it was in, if that was the usual one in all
                             else; 0: not */
    bool stops;           /* a debugger stops there by itself: the module faulted */
    const char *function; /* entry function, NULL when it is not about one */
    bool has_address;
    uint64_t address; /* of the module, where it happened */
    char file[256];   /* source file as the compiler recorded it, "" when it is not known */
    int line;
    bool has_cycle;
    uint64_t cycle;
    uint64_t cycles_needed; /* that a run must have for it to be seen; 0: up to its cycle */
    uint64_t count;         /* times seen, at least 1 */
};

struct rule_report {
    const char *id, *group, *clause, *title, *advice;
    enum severity severity;
    enum rule_outcome outcome;
    char reason[FINDING_TEXT]; /* why it could not be judged */
    struct finding *findings;
    size_t finding_count;
    size_t dropped;                     /* findings beyond FINDINGS_KEPT */
    const struct waiver_report *waiver; /* why its failure does not count; NULL: it does */
};

struct group_report {
    const char *name; /* "file", "start", "cycle" */
    double seconds;   /* wall time spent on it */
    char note[128];   /* "250 / 500 / 1000 us, 20 000 cycles each" */
};

/* What a call took of what it may take, at worst. */
struct budget_report {
    const char *name; /* "Program_04", "stack" */
    const char *unit; /* "us", "bytes" */
    double worst;
    double allowed; /* 0: no limit is stated */
    bool has_cycle;
    uint64_t cycle;            /* of the worst call */
    uint32_t cycle_us;         /* Cycle_Time at which it was; 0: does not matter */
    uint64_t instructions;     /* of the worst call; 0: not counted */
    char reason[FINDING_TEXT]; /* why there is no figure; "" when there is one */
};

/* How much of a function was executed, over all runs. */
struct coverage_report {
    char name[64];            /* "Program_04", or another function of the module */
    uint64_t executed, total; /* bytes of code */
    char missed[256];         /* the first place that was not: "gantry.c:88"; "" when all was */
};

enum timeline_kind {
    TIMELINE_STATE,       /* loaded, every slave in OP, the end */
    TIMELINE_FAULT,       /* the experiment did it to the bus */
    TIMELINE_MESSAGE,     /* of the module or of TG Motion */
    TIMELINE_EXPECTATION, /* of a scenario, that failed */
    TIMELINE_INCIDENT,    /* a call that did not return as it should */
    TIMELINE_KINDS
};

struct timeline_event {
    enum timeline_kind kind;
    double seconds; /* of machine time; before the first cycle it is below 0 or 0 */
    bool has_cycle;
    uint64_t cycle;
    char source[32]; /* "Program_04", "bus" */
    char text[FINDING_TEXT];
    uint64_t count; /* times it happened one after the other, at least 1 */
};

/* What happened in one run, in the order of time. */
struct timeline_report {
    char name[48];   /* of the experiment */
    char about[128]; /* "Cycle_Time 500 us, 20000 cycles" */
    double seconds;  /* machine time of the run */
    struct timeline_event *events;
    size_t event_count;
    uint64_t dropped; /* events beyond those that are kept */
    bool in_full;     /* of interest also where nothing but messages is in it */
};

/* A curve as buckets of equal length: least and greatest value of each, NaN where there is none. */
struct plot_curve {
    char name[48], unit[16]; /* "SERVO[0].Position", "inc" */
    double *least, *greatest;
};

struct plot_report {
    char title[96];
    double begin, end; /* s of machine time */
    size_t buckets;
    struct plot_curve *curves;
    size_t curve_count;
};

/* A failure that somebody answers for (--waive). Also those that are out of date or for nothing. */
struct waiver_report {
    const char *rule, *reason, *owner;
    const char *expiry; /* "2027-03-31" */
    bool expired;       /* it fails the module, whether its rule failed or not */
    bool used;          /* its rule failed */
};

struct report {
    const char *tool; /* "tgm 0.1.0" */
    const char *path;
    uint64_t size; /* bytes of the module */
    const char *sha256, *format, *target;
    const char *profile, *profile_title;
    uint64_t seed;
    const char *selection; /* pattern of the rules that were asked for, NULL: all */
    const char *config;    /* file that it was judged under, at its one Cycle_Time; NULL: none */
    uint64_t cycles;       /* of each run, as asked for; 0: as the suite has them */
    struct rule_report *rules;
    size_t rule_count;
    struct group_report *groups;
    size_t group_count;
    /* Rules; one of severity note counts as passed or noted only. */
    unsigned passed, failed, not_judged, noted;
    unsigned waived;        /* of the failed */
    bool strict;            /* failed "should" rules fail the module, too */
    bool instrumented;      /* every run that can be was to be on the instrumented machine */
    unsigned runs_all;      /* that were made */
    unsigned runs_emulated; /* of them, on the instrumented machine: asked for or not */
    enum verdict verdict;
    const char *rule_book; /* sha256 of the rules as they were judged; NULL: not known */
    const char *evidence;  /* sha256 of the manifest of the saved evidence; NULL: not saved */
    const struct budget_report *budgets; /* NULL with a count of 0, as with all that follow */
    size_t budget_count;
    const struct coverage_report *coverage;
    size_t coverage_count;
    const char *coverage_reason; /* why there is no coverage; NULL: see above */
    const struct timeline_report *timelines;
    size_t timeline_count;
    const struct plot_report *plots;
    size_t plot_count;
    const struct waiver_report *waivers;
    size_t waiver_count;
};

const char *severity_name(enum severity severity);
const char *outcome_name(enum rule_outcome outcome);
const char *verdict_name(enum verdict verdict);
const char *timeline_name(enum timeline_kind kind);

/* The module's file name, without folders. */
const char *report_file_name(const struct report *report);

/* The outcome of the rule decides the verdict: it is a "must", or a "should" and strict. */
bool report_decides(const struct report *report, const struct rule_report *rule);
/* It failed, decides, and nobody answers for it. */
bool report_fails(const struct report *report, const struct rule_report *rule);

/* Each rule counts in one of them; failed ones that do not decide are warned or, of
 * severity note, noted. */
struct report_tally {
    unsigned all, passed, failed, warned, noted, waived, not_judged;
};

/* Of a group by name; NULL: of all. */
void report_tally(const struct report *report, const char *group, struct report_tally *tally);

/* worst / allowed, 0 when no limit is stated. */
double budget_share(const struct budget_report *budget);

/* For people. colour: escape sequences are used. The last line is "RESULT: ...". */
void report_text(const struct report *report, FILE *stream, bool colour);

/*
 * For machines, and for people with a browser. Each is written whole; wall times aside (junit), the
 * same report gives the same bytes. 0 or negative errno when the stream cannot be written.
 */
int report_json(const struct report *report, FILE *stream);  /* tgm-check/1 (docs/json.md) */
int report_junit(const struct report *report, FILE *stream); /* docs/reports.md */
int report_sarif(const struct report *report, FILE *stream); /* 2.1.0 */
int report_html(const struct report *report, FILE *stream);  /* one file, nothing beside it */

#endif
