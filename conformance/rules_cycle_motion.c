/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about set-points as they leave for the bus (host/watch.c). */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_cycle.h"

/* The first of its kind, NULL when there was none. */
static const struct audit_motion *motion_of(const struct cycle_run *run,
                                            enum audit_motion_kind kind)
{
    const struct audit_motion *motion = &run->evidence->audit.motion[kind];
    return motion->count > 0 ? motion : NULL;
}

static void stamp(const struct cycle_run *run, const struct audit_motion *motion,
                  struct finding *finding)
{
    finding_stamp(finding, run->experiment, ENTRY_04, motion->cycle);
    finding->function = NULL; /* whoever wrote it last */
    finding->count += motion->count - 1;
    if (motion->limit > 0)
        snprintf(finding->place, sizeof finding->place, "%.0f inc; at most %.0f",
                 fabs(motion->value), motion->limit);
}

static void judge_steps(const struct cycle_run *run)
{
    const struct audit_motion *motion = motion_of(run, AUDIT_TOO_FAST);
    if (motion == NULL)
        return;
    stamp(run, motion,
          finding_add(run->findings,
                      "the set-point of SERVO[%u] goes further in one cycle than the axis can",
                      motion->axis));
}

void check_set_point_steps(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_steps, findings);
}

static void judge_jump(const struct cycle_run *run)
{
    const struct audit_motion *motion = motion_of(run, AUDIT_JUMP);
    if (motion == NULL)
        return;
    stamp(run, motion,
          finding_add(run->findings,
                      "SERVO[%u] is enabled with its set-point away from where it stands",
                      motion->axis));
}

void check_no_jump(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_jump, findings);
}

/* Who set it, as far as a run was traced, and others have no accesses: the same happens in each. */
static void place_mode(const struct cycle_run *run, struct finding *finding)
{
    struct catalogue_line line;
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        const struct audit_record *record = &run->file->runs[id].result.evidence.audit;
        for (uint32_t i = 0; i < record->access_count; i++) {
            const struct audit_access *row = &record->accesses[i];
            if (!row->write || !row->before_op || row->first_value == 0 ||
                !audit_line(run->catalogue, row->memory, row->offset, &line) ||
                strcmp(line.name, "SERVO[n].Mode") != 0)
                continue;
            finding_place(finding, run->file, row->pc);
            finding->function = entry_name((enum entry)row->entry);
            return;
        }
    }
}

static void judge_early(const struct cycle_run *run)
{
    const struct audit_motion *motion = motion_of(run, AUDIT_EARLY);
    if (motion == NULL)
        return;
    struct finding *finding =
        finding_add(run->findings, "SERVO[%u].Mode is %.0f before its drive has ever been in OP",
                    motion->axis, motion->value);
    stamp(run, motion, finding);
    place_mode(run, finding);
}

void check_waits_for_bus(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_early, findings);
}
