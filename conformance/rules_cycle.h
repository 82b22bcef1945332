/* SPDX-License-Identifier: GPL-2.0-or-later */
/* rules_cycle.h - what the files of the cycle rules share among themselves; nobody else includes
 * it. */
#ifndef CONFORMANCE_RULES_CYCLE_H
#define CONFORMANCE_RULES_CYCLE_H

#include "conformance/rules.h"

/* What a rule makes of one run. */
struct cycle_run {
    const struct case_file *file;
    enum experiment_id id;
    const struct experiment *experiment;
    const struct evidence *evidence;
    const struct catalogue *catalogue; /* of the product */
    struct findings *findings;
};

typedef void cycle_judge(const struct cycle_run *run);

/* False when there is no evidence of that run (case_evidence). */
bool cycle_run_open(struct cycle_run *run, const struct case_file *file, enum experiment_id id,
                    struct findings *findings);

/* Judges each run of the set that can be judged; one that ended early is judged and, unless
 * something was found, makes the rule not judged. */
void cycle_each(const struct case_file *file, uint64_t set, cycle_judge *judge,
                struct findings *findings);
/* The same of runs on the instrumented machine; not judged, with the reason, where it does not run
 * the module. */
void cycle_each_traced(const struct case_file *file, cycle_judge *judge, struct findings *findings);

/* Where a function begins, for a finding that has no better place. */
void cycle_place_function(const struct cycle_run *run, enum entry entry, struct finding *finding);

#endif
