/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * chronicle.h - evidence as parts of a report: what happened in each run and when, and the curves
 * of its axes. Of saved evidence it is the same as of a run of now: nothing else is looked at.
 */
#ifndef CONFORMANCE_CHRONICLE_H
#define CONFORMANCE_CHRONICLE_H

#include "conformance/rules.h"

struct chronicle {
    struct timeline_report
        *timelines; /* runs with cycles, and others in which something happened */
    size_t timeline_count;
    struct plot_report *plots; /* of the usual run at the default Cycle_Time, and of scenarios */
    size_t plot_count;
    struct coverage_report *coverage;
    size_t coverage_count;
    const char *coverage_reason; /* why there is none; NULL: there is */
};

/* 0 or -ENOMEM, with nothing to free then. */
int chronicle_make(struct chronicle *chronicle, const struct case_file *file);
void chronicle_free(struct chronicle *chronicle);

/* Its parts. */
int chronicle_coverage(struct chronicle *chronicle, const struct case_file *file);
int chronicle_timeline(struct timeline_report *timeline, const struct experiment *experiment,
                       const struct experiment_result *result, const struct scenario *scenario);
int chronicle_plot(struct plot_report *plot, const char *name, const struct experiment *experiment,
                   const struct sketch *sketch);
void chronicle_plot_free(struct plot_report *plot);

#endif
