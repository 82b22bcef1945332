/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about what every call does, in Program_Ini and in the cycles at each Cycle_Time. */
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

enum incident_class { CLASS_HANG, CLASS_FAULT, CLASS_SYSCALL, CLASS_WRITE };

/* Each incident belongs to exactly one rule. */
static enum incident_class class_of(const struct evidence_incident *incident)
{
    switch (incident->kind) {
    case MACHINE_SYSCALL:
        return CLASS_SYSCALL;
    case MACHINE_HANG:
        return CLASS_HANG;
    default:
        break;
    }
    const bool write = incident->fault.access == MACHINE_ACCESS_WRITE &&
                       !incident_is_stack_overflow(&incident->fault);
    return write ? CLASS_WRITE : CLASS_FAULT;
}

static void stamp(struct finding *finding, const struct experiment *experiment, enum entry entry,
                  uint64_t cycle)
{
    finding->function = entry_name(entry);
    if (cycle == EVIDENCE_NO_CYCLE)
        return;
    finding->has_cycle = true;
    finding->cycle = cycle;
    snprintf(finding->when, sizeof finding->when, "in cycle %" PRIu64 " at Cycle_Time %u us", cycle,
             experiment->host.cycle_us);
}

static void report_incident(const struct case_file *file, enum experiment_id id,
                            const struct evidence_incident *incident, struct findings *findings)
{
    char text[FINDING_TEXT];
    incident_describe(incident, text);
    struct finding *finding = finding_add(findings, "%s", text);
    stamp(finding, &file->experiments[id], incident->entry, incident->cycle);
    incident_place(incident, finding, file);
}

/* The worker ended in a way that no handler in it could catch: what it had been doing is in the
 * evidence. */
static void report_end(const struct case_file *file, enum experiment_id id,
                       enum incident_class class, struct findings *findings)
{
    const struct experiment_result *result = &file->results[id];
    const struct evidence *evidence = &result->evidence;
    const char *name = entry_name(evidence->entry);
    struct finding *finding = NULL;
    if (class != CLASS_FAULT || experiment_was_stopped(result))
        return;
    if (result->worker.end == WORKER_KILLED)
        finding = finding_add(findings, "%s destroyed the process it ran in (signal %d: %s)%s%s",
                              name, result->worker.value, strsignal(result->worker.value),
                              result->worker.reason[0] != '\0' ? ": " : "", result->worker.reason);
    else if (result->worker.end == WORKER_EXITED)
        finding = finding_add(findings, "%s ended the process it ran in (exit status %d)", name,
                              result->worker.value);
    if (finding != NULL)
        stamp(finding, &file->experiments[id], evidence->entry, evidence->cycle);
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
static void judge_completeness(const struct case_file *file, enum experiment_id id,
                               struct findings *findings)
{
    const struct experiment_result *result = &file->results[id];
    const struct evidence *evidence = &result->evidence;
    const struct experiment *experiment = &file->experiments[id];
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
    else if (experiment->cycles > 0 && evidence->cycles_done == 0)
        finding_not_judged(findings,
                           "no cycle was run: Program_Ini did not return 1 (rule ini-returns-one)");
    else if (!is_complete(experiment, evidence))
        finding_not_judged(findings, "experiment %s: its evidence is not complete",
                           experiment->name);
}

static void judge(const struct case_file *file, enum incident_class class,
                  struct findings *findings)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        if ((ON_GOOD_RUNS & (1u << id)) == 0 || file->inapplicable[id])
            continue;
        if (!file->ran[id]) {
            finding_not_judged(findings, "%s", file->cannot_run);
            continue;
        }
        const struct evidence *evidence = &file->results[id].evidence;
        for (unsigned i = 0; i < evidence->incident_count; i++)
            if (class_of(&evidence->incidents[i]) == class)
                report_incident(file, (enum experiment_id)id, &evidence->incidents[i], findings);
        report_end(file, (enum experiment_id)id, class, findings);
        judge_completeness(file, (enum experiment_id)id, findings);
    }
}

void check_returns(const struct case_file *file, struct findings *findings)
{
    judge(file, CLASS_HANG, findings);
}

void check_no_fault(const struct case_file *file, struct findings *findings)
{
    judge(file, CLASS_FAULT, findings);
}

void check_no_system_call(const struct case_file *file, struct findings *findings)
{
    judge(file, CLASS_SYSCALL, findings);
}

void check_no_stray_write(const struct case_file *file, struct findings *findings)
{
    judge(file, CLASS_WRITE, findings);
}
