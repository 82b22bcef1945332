/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * check.h - the whole way from a file to a verdict: open, run the experiments that the rules ask
 * for, judge, report.
 */
#ifndef CONFORMANCE_CHECK_H
#define CONFORMANCE_CHECK_H

#include "conformance/rules.h"
#include "conformance/waivers.h"

#define CHECK_WHY 1024

/* Where the frames of an experiment with a bus go; NULL: nowhere. What it returned before is not
 * written to any more. */
typedef struct pcap *check_capture(void *argument, const char *experiment);

/* A scenario and the name of its file. */
struct check_scenario {
    const struct scenario *scenario;
    const char *path;
    const char *text; /* what it was read from; needed where evidence is saved */
};

struct check_options {
    const char *path;
    const char *shown; /* name in reports and file name of places; NULL: path */
    const char *tool;  /* "tgm 0.1.0" */
    const struct profile *profile;
    uint64_t seed;
    bool instrumented; /* every experiment that can on the instrumented machine, not only those that
                        * need it
                        */
    unsigned jobs;     /* experiments that run at the same time; 0: one for each core */
    uint64_t cycles;   /* of each cycle experiment; 0 = CHECK_SECONDS of machine time */
    /* Shell patterns over rule ids, with commas between them; one with '!' in front takes rules
     * away. NULL: all. */
    const char *rules;
    bool strict;                   /* rules that a module should keep count as those it must */
    const struct waivers *waivers; /* NULL: none */
    const char *today;             /* "2026-11-27": for waivers; NULL: today (UTC) */
    const char *evidence; /* folder that all evidence is saved in (archive.h); NULL: none */
    /* A configuration to judge under: its bus, servos, periods, sizes, and one Cycle_Time instead
     * of all. NULL: none. */
    const struct host_config *around;
    const char *around_path;                /* the file that it is from */
    const struct check_scenario *scenarios; /* must outlive the check */
    size_t scenario_count;
    check_capture *capture; /* may be NULL */
    void *capture_argument;
    const char *again_path; /* the module's path in lines that show a finding again; NULL: path */
};

/* Machine time of each cycle experiment unless --cycles says otherwise, in s. */
#define CHECK_SECONDS 10

/* Machine time over which runs are compared with one another, in ms. */
#define CHECK_DIGEST_MS 2000
/* Of each run in which every access is seen. */
#define CHECK_TRACED_MS 2000

struct check; /* owns everything the report points to */

/*
 * 0 and a check whose report is complete, or negative errno with a sentence in why: the file cannot
 * be read, no rule matches, no worker process can be made. A bad module is not an error.
 */
int check_run(struct check **out, const struct check_options *options, char why[CHECK_WHY]);

/* What may be asked anew of saved evidence; NULL, and false: as it was then. */
struct check_changes {
    const char *rules;
    bool strict;
    const struct waivers *waivers; /* judged as of today */
    bool sparing; /* what the rules need is read and told, and nothing else of the report */
};

/* From saved evidence, with nothing run: the same report but for times. 0, or negative errno with a
 * sentence in why. */
int check_again(struct check **out, const char *folder, const struct check_changes *changes,
                char why[CHECK_WHY]);
/* To be called before threads are made that run checks. */
void check_share_arena(void);
const struct report *check_report(const struct check *check);
/* Layers of the sandbox (enum worker_layer) that some experiment had to do without. */
unsigned check_lacks(const struct check *check);
void check_free(struct check *check);

/* Of the wall clock, to tell how long something took. */
double check_seconds(void);

#endif
