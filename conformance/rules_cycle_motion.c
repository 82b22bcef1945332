/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about set-points as they leave for the bus (host/watch.c). */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

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

static void judge_early(const struct cycle_run *run)
{
    const struct audit_motion *motion = motion_of(run, AUDIT_EARLY);
    if (motion == NULL)
        return;
    stamp(run, motion,
          finding_add(run->findings,
                      "SERVO[%u].Mode is %.0f while its drive has not been in OP: it is to move "
                      "before the bus is ready",
                      motion->axis, motion->value));
}

void check_waits_for_bus(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_early, findings);
}
