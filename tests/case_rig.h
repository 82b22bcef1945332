/* SPDX-License-Identifier: GPL-2.0-or-later */
/* case_rig.h - evidence that is made up for the rules: runs with which nothing is wrong, to be
 * spoiled. */
#ifndef TESTS_CASE_RIG_H
#define TESTS_CASE_RIG_H

#include <stdlib.h>

#include "conformance/rules.h"

enum { CYCLES = 100 };

/* Started, and played to its end. */
static inline void complete(struct experiment *experiment, struct experiment_result *result)
{
    struct evidence *evidence = &result->evidence;
    experiment->name = "made up";
    experiment->cycles = CYCLES;
    experiment->host.product = product_find("pc4");
    experiment->host.cycle_us = 500;
    result->worker.end = WORKER_DONE;
    evidence->stage = EVIDENCE_FINISHED;
    evidence->cycles_done = CYCLES;
    evidence->calls[ENTRY_INI].count = 1;
    evidence->calls[ENTRY_INI].last_value = 1;
}

/* Of every experiment one; to be freed. NULL: no memory. */
static inline struct case_run *complete_runs(void)
{
    struct case_run *runs = calloc(EXPERIMENT_COUNT, sizeof *runs);
    for (int id = 0; runs != NULL && id < EXPERIMENT_COUNT; id++) {
        runs[id].ran = true;
        complete(&runs[id].plan.experiment, &runs[id].result);
    }
    return runs;
}

#endif
