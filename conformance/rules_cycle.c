/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about what every call does, in Program_Ini and in the cycles at each Cycle_Time. */
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

enum incident_class { CLASS_HANG, CLASS_FAULT, CLASS_SYSCALL, CLASS_WRITE, CLASS_CODE };

/* The address lies in the module's code. */
static bool is_code(const struct image *image, const struct machine_fault *fault)
{
    if (strcmp(fault->region, "module") != 0 || fault->region_offset < 0)
        return false;
    const uint64_t vaddr = image->span_begin + (uint64_t)fault->region_offset;
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        if ((segment->perm & IMAGE_EXEC) && vaddr >= segment->vaddr &&
            vaddr - segment->vaddr < segment->mem_size)
            return true;
    }
    return false;
}

/* Each incident belongs to exactly one rule. */
static enum incident_class class_of(const struct image *image,
                                    const struct evidence_incident *incident)
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
    if (write && is_code(image, &incident->fault))
        return CLASS_CODE;
    return write ? CLASS_WRITE : CLASS_FAULT;
}

static void report_incident(const struct case_file *file, enum experiment_id id,
                            const struct evidence_incident *incident, struct findings *findings)
{
    char text[FINDING_TEXT];
    incident_describe(incident, text);
    struct finding *finding = finding_add(findings, "%s", text);
    finding_stamp(finding, case_experiment(file, id), incident->entry, incident->cycle);
    incident_place(incident, finding, file);
}

/* The worker ended in a way that no handler in it could catch: what it had been doing is in the
 * evidence. */
static void report_end(const struct case_file *file, enum experiment_id id,
                       enum incident_class class, struct findings *findings)
{
    const struct experiment_result *result = &file->runs[id].result;
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
        finding_stamp(finding, case_experiment(file, id), evidence->entry, evidence->cycle);
}

static void judge_run(const struct case_file *file, enum experiment_id id,
                      enum incident_class class, struct findings *findings)
{
    const struct evidence *evidence = &file->runs[id].result.evidence;
    const bool called = !case_lacks_functions(file, evidence); /* else rule export-names tells */
    for (unsigned i = 0; i < evidence->incident_count && called; i++)
        if (class_of(file->image, &evidence->incidents[i]) == class)
            report_incident(file, id, &evidence->incidents[i], findings);
    report_end(file, id, class, findings);
    case_complete(file, id, findings);
}

static void judge(const struct case_file *file, enum incident_class class,
                  struct findings *findings)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        if (!experiment_in(ON_GOOD_RUNS, id) || file->runs[id].plan.inapplicable)
            continue;
        if (!file->runs[id].ran)
            finding_not_judged(findings, "%s", file->cannot_run);
        else if (!case_unsupported(file, (enum experiment_id)id, findings))
            judge_run(file, (enum experiment_id)id, class, findings);
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

/* Where code can be written without a fault, in images without protection, it is seen only when
 * every access is. */
static void report_code_writes(const struct case_file *file, enum experiment_id id,
                               struct findings *findings)
{
    const struct audit_record *record = &file->runs[id].result.evidence.audit;
    for (uint32_t i = 0; i < record->access_count; i++) {
        const struct audit_access *row = &record->accesses[i];
        if (row->memory != AUDIT_CODE || !row->write)
            continue;
        struct finding *finding = finding_add(findings, "%s wrote to the module's own code",
                                              entry_name((enum entry)row->entry));
        finding_stamp(finding, case_experiment(file, id), (enum entry)row->entry, row->first_cycle);
        finding_place(finding, file, row->pc);
    }
}

void check_no_code_write(const struct case_file *file, struct findings *findings)
{
    judge(file, CLASS_CODE, findings);
    for (int id = 0; id < EXPERIMENT_COUNT && findings->count == 0; id++)
        report_code_writes(file, (enum experiment_id)id, findings);
}
