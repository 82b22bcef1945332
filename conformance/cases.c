/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What an experiment's evidence is good for, the same for every rule. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

const struct experiment *case_experiment(const struct case_file *file, enum experiment_id id)
{
    return &file->runs[id].plan.experiment;
}

bool case_unsupported(const struct case_file *file, enum experiment_id id,
                      struct findings *findings)
{
    const struct evidence *evidence = &file->runs[id].result.evidence;
    for (unsigned i = 0; i < evidence->incident_count; i++) {
        const struct evidence_incident *incident = &evidence->incidents[i];
        struct finding where = { .count = 0 };
        if (incident->kind != MACHINE_UNSUPPORTED)
            continue;
        incident_place(incident, &where, file);
        finding_not_judged(findings, "the emulated CPU lacks an instruction of %s: %s",
                           entry_name(incident->entry), where.place);
        return true;
    }
    return false;
}

const struct evidence *case_loaded(const struct case_file *file, enum experiment_id id,
                                   struct findings *findings)
{
    const struct case_run *run = &file->runs[id];
    const struct experiment_result *result = &run->result;
    const char *name = run->plan.experiment.name;
    if (run->plan.inapplicable)
        return NULL;
    if (!run->ran) {
        finding_not_judged(findings, "%s", file->cannot_run);
        return NULL;
    }
    if (experiment_was_stopped(result) || result->worker.end == WORKER_TIMEOUT) {
        finding_not_judged(findings, "experiment %s: the worker was stopped before it was done",
                           name);
        return NULL;
    }
    if (result->evidence.trouble[0] != '\0' || result->worker.end == WORKER_FAILED) {
        finding_not_judged(findings, "experiment %s: %s", name,
                           result->evidence.trouble[0] != '\0' ? result->evidence.trouble
                                                               : "the worker failed");
        return NULL;
    }
    return case_unsupported(file, id, findings) ? NULL : &result->evidence;
}

static const char no_functions[] =
    "GetProcAddress handed out no functions: nothing was called (rule export-names)";

bool case_lacks_functions(const struct case_file *file, const struct evidence *evidence)
{
    return file->image->format == IMAGE_FORMAT_FLAT && evidence->lookup.asked &&
           !evidence->lookup.found;
}

const struct evidence *case_evidence(const struct case_file *file, enum experiment_id id,
                                     struct findings *findings)
{
    const struct evidence *evidence = case_loaded(file, id, findings);
    if (evidence == NULL || !case_lacks_functions(file, evidence))
        return evidence;
    finding_not_judged(findings, "%s", no_functions);
    return NULL;
}

/* The experiment was played to its end: every cycle, or until no function could be called any more.
 */
static bool is_complete(const struct experiment *experiment, const struct evidence *evidence)
{
    bool callable = false;
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++)
        callable = callable || !evidence->calls[entry].disabled;
    return evidence->stage == EVIDENCE_FINISHED &&
           (evidence->cycles_done == experiment->cycles || !callable);
}

/* Reasons why the evidence of an experiment says too little about the cycles. */
void case_complete(const struct case_file *file, enum experiment_id id, struct findings *findings)
{
    const struct experiment_result *result = &file->runs[id].result;
    const struct evidence *evidence = &result->evidence;
    const struct experiment *experiment = case_experiment(file, id);
    if (result->worker.end == WORKER_FAILED || evidence->trouble[0] != '\0')
        finding_not_judged(findings, "experiment %s: %s", experiment->name,
                           evidence->trouble[0] != '\0' ? evidence->trouble : "the worker failed");
    else if (result->worker.end == WORKER_TIMEOUT)
        finding_not_judged(findings,
                           "experiment %s: only %" PRIu64 " of %" PRIu64
                           " cycles were done in %.0f s: the module is too slow, or this computer "
                           "too busy; fewer cycles: --cycles N",
                           experiment->name, evidence->cycles_done, experiment->cycles,
                           (double)result->worker.wall_ns * 1e-9);
    else if (experiment_was_stopped(result))
        finding_not_judged(findings, "experiment %s: the worker was stopped from outside (%s)",
                           experiment->name, strsignal(result->worker.value));
    else if (result->worker.end != WORKER_DONE)
        finding_not_judged(findings, "experiment %s: the module ended the process it ran in",
                           experiment->name);
    else if (case_lacks_functions(file, evidence))
        finding_not_judged(findings, "%s", no_functions);
    else if (experiment->cycles > 0 && evidence->cycles_done == 0)
        finding_not_judged(findings,
                           "no cycle was run: Program_Ini did not return 1 (rule ini-returns-one)");
    else if (!is_complete(experiment, evidence))
        finding_not_judged(findings, "experiment %s: its evidence is not complete",
                           experiment->name);
}

void finding_stamp(struct finding *finding, const struct experiment *experiment, enum entry entry,
                   uint64_t cycle)
{
    finding->function = entry_name(entry);
    if (experiment->plain)
        finding->plain_us = experiment->host.cycle_us;
    if (cycle == EVIDENCE_NO_CYCLE)
        return;
    finding->has_cycle = true;
    finding->cycle = cycle;
    snprintf(finding->when, sizeof finding->when, "in cycle %" PRIu64 " at Cycle_Time %u us", cycle,
             experiment->host.cycle_us);
}
