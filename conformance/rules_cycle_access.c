/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Rules about what functions read and write, access by access, and about what a call takes: judged
 * on the runs of the instrumented machine (host/audit.h).
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/budgets.h"
#include "conformance/rules_cycle.h"

void cycle_each_traced(const struct case_file *file, cycle_judge *judge, struct findings *findings)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        struct cycle_run run;
        if (!experiment_in(ON_TRACED, id) ||
            !cycle_run_open(&run, file, (enum experiment_id)id, findings))
            continue;
        judge(&run);
        case_complete(file, (enum experiment_id)id, findings);
        if (!run.evidence->audit.traced)
            finding_not_judged(findings, "experiment %s: no instruction was seen",
                               run.experiment->name);
    }
}

/* --- accesses -------------------------------------------------------------------------------- */

/* "I32 7", "F64 0.25": bits as the register's type has them. */
static void value_text(const struct catalogue_line *line, uint64_t bits, char *text, size_t size)
{
    const char *name = scalar_name(line->type);
    if (line->type == I64 || line->type == I32 || line->type == I16 || line->type == I8)
        snprintf(text, size, "%s %.0f", name, scalar_get(line->type, &bits));
    else if (line->type == F32 || line->type == F64)
        snprintf(text, size, "%s %g", name, scalar_get(line->type, &bits));
    else
        snprintf(text, size, "%s %" PRIu64, name, bits);
}

/* Code line and value: "gantry.tgm+0x1a4 (Program_04) gantry.c:88  F64 5". */
static void place_access(const struct cycle_run *run, const struct audit_access *row,
                         struct finding *finding)
{
    struct catalogue_line line;
    char value[64];
    finding_place(finding, run->file, row->pc);
    if (!audit_line(run->catalogue, row->memory, row->offset, &line) ||
        row->size != scalar_size(line.type))
        return;
    value_text(&line, row->first_value, value, sizeof value);
    const size_t at = strlen(finding->place);
    snprintf(finding->place + at, sizeof finding->place - at, "  %s", value);
}

static void judge_read_only(const struct cycle_run *run)
{
    const struct audit_record *record = &run->evidence->audit;
    char name[AUDIT_NAME];
    for (uint32_t i = 0; i < record->access_count; i++) {
        const struct audit_access *row = &record->accesses[i];
        if (!row->write || (row->classes & AUDIT_READ_ONLY) == 0)
            continue;
        audit_name(run->catalogue, row->memory, row->offset, name);
        struct finding *finding = finding_add(run->findings, "%s wrote %s (read-only)",
                                              entry_name((enum entry)row->entry), name);
        finding_stamp(finding, run->experiment, (enum entry)row->entry, row->first_cycle);
        finding->count += row->count - 1;
        place_access(run, row, finding);
    }
}

void check_write_read_only(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_read_only, findings);
}

static void judge_numbers(const struct cycle_run *run)
{
    const struct audit_record *record = &run->evidence->audit;
    char name[AUDIT_NAME];
    for (uint32_t i = 0; i < record->access_count; i++) {
        const struct audit_access *row = &record->accesses[i];
        if (row->odd_count == 0)
            continue;
        audit_name(run->catalogue, row->memory, row->odd_offset, name);
        struct finding *finding = finding_add(run->findings, "%s wrote no number to %s",
                                              entry_name((enum entry)row->entry), name);
        finding_stamp(finding, run->experiment, (enum entry)row->entry, row->odd_cycle);
        finding->count += row->odd_count - 1;
        finding_place(finding, run->file, row->pc);
    }
}

/* What the long runs saw, where nothing is known of the instruction. */
static void judge_set_points(const struct cycle_run *run)
{
    const struct audit_motion *motion = &run->evidence->audit.motion[AUDIT_NO_NUMBER];
    if (motion->count == 0)
        return;
    struct finding *finding =
        finding_add(run->findings, "the set-point of SERVO[%u] is no number", motion->axis);
    finding_stamp(finding, run->experiment, ENTRY_04, motion->cycle);
    finding->function = NULL;
    finding->count += motion->count - 1;
}

void check_finite_outputs(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_numbers, findings);
    if (findings->count == 0)
        cycle_each(file, ON_CYCLES, judge_set_points, findings);
}

static void judge_order(const struct cycle_run *run)
{
    char output[AUDIT_NAME], input[AUDIT_NAME];
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++) {
        const struct audit_order *order = &run->evidence->audit.functions[entry].order;
        if (order->count == 0)
            continue;
        audit_name(run->catalogue, order->output_memory, order->output_offset, output);
        audit_name(run->catalogue, order->input_memory, order->input_offset, input);
        struct finding *finding = finding_add(run->findings, "%s wrote %s and read %s after it",
                                              entry_name((enum entry)entry), output, input);
        finding_stamp(finding, run->experiment, (enum entry)entry, order->cycle);
        finding->count += order->count - 1;
        finding_place(finding, run->file, order->input_pc);
    }
}

void check_inputs_first(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_order, findings);
}

/* --- what a call takes -------------------------------------------------------------------------
 */

static void judge_budget(const struct cycle_run *run, enum entry entry)
{
    const struct audit_function *function = &run->evidence->audit.functions[entry];
    const struct product_budget *budget = &run->experiment->host.product->budget;
    const double allowed = budget_allowed_us(run->experiment, entry);
    const double worst = budget_us(run->experiment, function->worst_instructions);
    if (allowed <= 0 || worst <= allowed)
        return;
    struct finding *finding =
        finding_add(run->findings, "%s takes longer than it may", entry_name(entry));
    finding_stamp(finding, run->experiment, entry, function->worst_cycle);
    cycle_place_function(run, entry, finding);
    const size_t at = strlen(finding->place);
    snprintf(finding->place + at, sizeof finding->place - at,
             "  %.1f us of %.1f us (%" PRIu64 " instructions, %u in a us)", worst, allowed,
             function->worst_instructions, budget->instructions_per_us);
}

static void judge_budget_04(const struct cycle_run *run)
{
    judge_budget(run, ENTRY_04);
}

static void judge_budget_05(const struct cycle_run *run)
{
    judge_budget(run, ENTRY_05);
}

static void judge_budget_background(const struct cycle_run *run)
{
    for (int entry = ENTRY_01; entry <= ENTRY_03; entry++)
        judge_budget(run, (enum entry)entry);
}

void check_budget_04(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_budget_04, findings);
}

void check_budget_05(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_budget_05, findings);
}

void check_budget_background(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_budget_background, findings);
}

/* A stack that the file tells is too large has its finding in stack-size. */
static bool is_told(const struct case_file *file, enum entry entry)
{
    const struct image_symbol *symbol = image_export(file->image, entry_name(entry));
    const struct image_routine *routine =
        symbol != NULL ? image_routine(file->image, symbol->vaddr) : NULL;
    return routine != NULL && routine->stack > file->profile->stack_bytes;
}

static void judge_stack(const struct cycle_run *run)
{
    const uint32_t limit = run->file->profile->stack_bytes;
    for (int entry = 0; entry < ENTRY_COUNT; entry++) {
        const uint64_t bytes = run->evidence->audit.functions[entry].stack_bytes;
        if (bytes <= limit || is_told(run->file, (enum entry)entry))
            continue;
        struct finding *finding = finding_add(run->findings, "%s needs more than %u bytes of stack",
                                              entry_name((enum entry)entry), limit);
        finding->function = entry_name((enum entry)entry);
        cycle_place_function(run, (enum entry)entry, finding);
        const size_t at = strlen(finding->place);
        snprintf(finding->place + at, sizeof finding->place - at, "  %" PRIu64 " bytes", bytes);
    }
}

void check_stack_limit(const struct case_file *file, struct findings *findings)
{
    cycle_each_traced(file, judge_stack, findings);
}
