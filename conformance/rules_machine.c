/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the author of a module expects of it, in scenarios of his own. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

static void report_failures(const struct case_scenario *played, struct findings *findings)
{
    const struct evidence *evidence = &played->result.evidence;
    char text[SCENARIO_TEXT];
    uint64_t told = 0;
    for (unsigned i = 0; i < evidence->failure_count; i++) {
        const struct evidence_failure *failure = &evidence->failures[i];
        scenario_tell(played->scenario, failure, text);
        struct finding *finding = finding_add(findings, "%s", text);
        finding->count = failure->count > 0 ? failure->count : 1;
        finding_stamp(finding, &played->experiment, ENTRY_INI, failure->cycle);
        finding->function = NULL; /* the machine's doing, by whichever function */
        told += failure->count;
    }
    if (evidence->failed > told)
        finding_add(findings, "%s: and %" PRIu64 " failures of other statements", played->name,
                    evidence->failed - told);
}

static void report_incidents(const struct case_file *file, const struct case_scenario *played,
                             struct findings *findings)
{
    const struct evidence *evidence = &played->result.evidence;
    char text[FINDING_TEXT];
    for (unsigned i = 0; i < evidence->incident_count; i++) {
        incident_describe(&evidence->incidents[i], text);
        struct finding *finding = finding_add(findings, "%s: %s", played->name, text);
        finding_stamp(finding, &played->experiment, evidence->incidents[i].entry,
                      evidence->incidents[i].cycle);
        incident_place(&evidence->incidents[i], finding, file);
    }
}

/* A scenario that was not played, or only a part of it, proves nothing. */
static void judge_completeness(const struct case_scenario *played, struct findings *findings)
{
    const struct experiment_result *result = &played->result;
    const struct evidence *evidence = &result->evidence;
    const int32_t ini = evidence->calls[ENTRY_INI].last_value;
    if (result->worker.end == WORKER_FAILED || evidence->trouble[0] != '\0')
        finding_not_judged(findings, "%s: %s", played->name,
                           evidence->trouble[0] != '\0' ? evidence->trouble : "the worker failed");
    else if (result->worker.end == WORKER_TIMEOUT)
        finding_not_judged(findings,
                           "%s: only %" PRIu64 " cycles were done in %.0f s: the module is too "
                           "slow, or this computer too busy",
                           played->name, evidence->cycles_done,
                           (double)result->worker.wall_ns * 1e-9);
    else if (experiment_was_stopped(result))
        finding_not_judged(findings, "%s: the worker was stopped from outside", played->name);
    else if (result->worker.end != WORKER_DONE)
        finding_add(findings, "%s: %s ended the process it ran in", played->name,
                    entry_name(evidence->entry));
    else if (evidence->cycles_done == 0 && evidence->calls[ENTRY_INI].count > 0 && ini != 1)
        finding_add(findings, "%s: not played: Program_Ini returned %d", played->name, (int)ini);
    else if (evidence->play != PLAY_DONE && evidence->failed == 0)
        finding_add(findings, "%s: not played to its end", played->name);
    else if (evidence->play == PLAY_DONE && evidence->checked == 0)
        finding_not_judged(findings, "%s: it expects nothing of the module", played->name);
}

void check_scenario(const struct case_file *file, struct findings *findings)
{
    for (size_t i = 0; i < file->scenario_count; i++) {
        const struct case_scenario *played = &file->scenarios[i];
        if (!played->ran) {
            finding_not_judged(findings, "%s", file->cannot_run);
            continue;
        }
        report_failures(played, findings);
        report_incidents(file, played, findings);
        judge_completeness(played, findings);
    }
}
