/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Rules about what a module does when something goes wrong on the bus (conformance/faults/). What
 * it does without any disturbance, too, is other rules' matter.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_cycle.h"

#define LATE_MS 100 /* at the end of a run: what is called at all is called in it */

/* The script in words: what experiments.def calls faults-lost-frame. */
static const char *script_of(const struct cycle_run *run)
{
    const char *name = run->experiment->name, *dash = strchr(name, '-');
    return dash != NULL ? dash + 1 : name;
}

static const struct evidence *calm(const struct cycle_run *run)
{
    static const struct evidence nothing;
    const struct case_run *of = &run->file->runs[EXPERIMENT_CYCLE_500];
    return of->ran ? &of->result.evidence : &nothing;
}

/* Nothing can be said of disturbances then. */
static bool fails_anyway(const struct cycle_run *run)
{
    if (calm(run)->incident_count == 0)
        return false;
    finding_not_judged(run->findings, "the module fails without any disturbance, too");
    return true;
}

/* --- it returns ------------------------------------------------------------------------------- */

static void judge_returns(const struct cycle_run *run)
{
    char text[FINDING_TEXT];
    if (fails_anyway(run))
        return;
    for (unsigned i = 0; i < run->evidence->incident_count; i++) {
        const struct evidence_incident *incident = &run->evidence->incidents[i];
        incident_describe(incident, text);
        struct finding *finding = finding_add(run->findings, "%s: %s", script_of(run), text);
        finding_stamp(finding, run->experiment, incident->entry, incident->cycle);
        incident_place(incident, finding, run->file);
    }
    /* Neither was it stopped, nor did the harness fail: there is evidence. */
    if (run->file->runs[run->id].result.worker.end != WORKER_DONE)
        finding_stamp(finding_add(run->findings, "%s: %s ended the process it ran in",
                                  script_of(run), entry_name(run->evidence->entry)),
                      run->experiment, run->evidence->entry, run->evidence->cycle);
    if (run->evidence->stage == EVIDENCE_FINISHED && run->evidence->incident_count == 0 &&
        run->evidence->fault_count == 0)
        finding_not_judged(run->findings, "experiment %s: nothing went wrong in it",
                           run->experiment->name);
}

void check_disturbed_returns(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_DISTURBED, judge_returns, findings);
}

/* --- numbers ---------------------------------------------------------------------------------- */

static void judge_finite(const struct cycle_run *run)
{
    const struct audit_motion *motion = &run->evidence->audit.motion[AUDIT_NO_NUMBER];
    if (motion->count == 0 || calm(run)->audit.motion[AUDIT_NO_NUMBER].count > 0)
        return;
    struct finding *finding = finding_add(
        run->findings, "%s: the set-point of SERVO[%u] is no number", script_of(run), motion->axis);
    finding_stamp(finding, run->experiment, ENTRY_04, motion->cycle);
    finding->function = NULL;
    finding->count = motion->count;
}

void check_disturbed_finite(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_DISTURBED, judge_finite, findings);
}

/* --- set-points of an axis that cannot follow --------------------------------------------------
 */

static void judge_set_points(const struct cycle_run *run)
{
    for (unsigned axis = 0; axis < EVIDENCE_AXES; axis++) {
        const struct evidence_unable *unable = &run->evidence->unable[axis];
        char why[40];
        if (unable->driven == 0)
            continue;
        snprintf(why, sizeof why,
                 unable->fault ? "reports a fault" : "is in EtherCATState %" PRIu32,
                 unable->al_state);
        struct finding *finding =
            finding_add(run->findings, "%s: the set-point of SERVO[%u] moves on while its drive %s",
                        script_of(run), axis, why);
        finding_stamp(finding, run->experiment, ENTRY_04, unable->cycle);
        finding->function = NULL;
        finding->count = unable->driven;
        snprintf(finding->place, sizeof finding->place, "%.0f inc from the axis",
                 fabs(unable->distance));
    }
}

void check_disturbed_set_points(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_DISTURBED, judge_set_points, findings);
}

static void judge_restart(const struct cycle_run *run)
{
    const struct audit_motion *motion = &run->evidence->audit.motion[AUDIT_JUMP];
    if (motion->count == 0 || calm(run)->audit.motion[AUDIT_JUMP].count > 0)
        return;
    struct finding *finding =
        finding_add(run->findings,
                    "%s: SERVO[%u] is enabled again with its set-point away from where it stands",
                    script_of(run), motion->axis);
    finding_stamp(finding, run->experiment, ENTRY_04, motion->cycle);
    finding->function = NULL;
    finding->count = motion->count;
    snprintf(finding->place, sizeof finding->place, "%.0f inc; at most %.0f", fabs(motion->value),
             motion->limit);
}

void check_disturbed_restart(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_DISTURBED, judge_restart, findings);
}

/* --- afterwards ------------------------------------------------------------------------------- */

static void judge_recovery(const struct cycle_run *run)
{
    const struct evidence *evidence = run->evidence;
    const uint64_t late = LATE_MS * UINT64_C(1000) / run->experiment->host.cycle_us;
    /* A function that failed is another rule's. */
    if (evidence->incident_count > 0 || evidence->stage != EVIDENCE_FINISHED ||
        evidence->calls[ENTRY_04].count == 0)
        return;
    if (evidence->called_cycle[ENTRY_04] + late < evidence->cycles_done)
        finding_stamp(finding_add(run->findings,
                                  "%s: Program_04 is not called any more: the PLC has stopped or "
                                  "paused itself",
                                  script_of(run)),
                      run->experiment, ENTRY_04, evidence->called_cycle[ENTRY_04]);
    else if (!evidence->all_op && calm(run)->all_op)
        finding_add(run->findings, "%s: the bus is not in OP again", script_of(run));
}

void check_disturbed_recovers(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_DISTURBED, judge_recovery, findings);
}
