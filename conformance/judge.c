/* SPDX-License-Identifier: GPL-2.0-or-later */
/* From evidence to findings, outcomes and the verdict. */
#include "conformance/check_parts.h"

#include <string.h>

static void judge_rule(struct check *check, const struct check_options *options,
                       const struct case_file *file, size_t index)
{
    const struct rule *rule = check->chosen[index];
    struct findings *findings = &check->findings[index];
    struct rule_report *out = &check->rules[index];
    rule->check(file, findings);
    *out = (struct rule_report){
        .id = rule->id,
        .group = rule_group_name(rule->group),
        .clause = rule->clause,
        .title = rule->title,
        .advice = rule->advice,
        .severity = rule->severity,
        .outcome = findings->count > 0           ? RULE_FAILED
                   : findings->reason[0] != '\0' ? RULE_NOT_JUDGED
                                                 : RULE_PASSED,
        .findings = findings->list,
        .finding_count = findings->count,
        .dropped = findings->dropped,
    };
    memcpy(out->reason, findings->reason, sizeof out->reason);
    for (size_t i = 0; i < findings->count; i++)
        check_add_reproduction(options, check->image, rule, &findings->list[i]);
}

/* The parts of the report that no rule makes. */
static int tell(struct check *check, const struct case_file *file)
{
    struct report *report = &check->report;
    const int r = chronicle_make(&check->chronicle, file);
    report->timelines = check->chronicle.timelines;
    report->timeline_count = check->chronicle.timeline_count;
    report->plots = check->chronicle.plots;
    report->plot_count = check->chronicle.plot_count;
    report->coverage = check->chronicle.coverage;
    report->coverage_count = check->chronicle.coverage_count;
    report->coverage_reason = check->chronicle.coverage_reason;
    return r;
}

/* Those for rules that were not asked for are of no concern. */
static void list_waivers(struct check *check, const struct check_options *options)
{
    struct report *report = &check->report;
    report->waivers = check->waivers;
    for (size_t i = 0; options->waivers != NULL && i < options->waivers->count; i++) {
        const struct waiver *w = &options->waivers->list[i];
        bool asked = false;
        for (size_t k = 0; k < report->rule_count; k++)
            asked = asked || strcmp(check->chosen[k]->id, w->rule) == 0;
        if (asked)
            check->waivers[report->waiver_count++] =
                (struct waiver_report){ .rule = w->rule,
                                        .reason = w->reason,
                                        .owner = w->owner,
                                        .expiry = w->expiry,
                                        .expired = waiver_expired(w, check->today) };
    }
}

static void count_run(struct report *report, const struct experiment_result *result)
{
    report->runs_all++;
    report->runs_emulated += result->evidence.instrumented;
}

static void count_runs(struct check *check, const struct check_options *options)
{
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        if (check->runs[i].ran)
            count_run(&check->report, &check->runs[i].result);
    for (size_t i = 0; check->scenarios != NULL && i < options->scenario_count; i++)
        if (check->scenarios[i].ran)
            count_run(&check->report, &check->scenarios[i].result);
}

static void waive(struct check *check, struct rule_report *rule)
{
    for (size_t i = 0; rule->outcome == RULE_FAILED && i < check->report.waiver_count; i++) {
        struct waiver_report *waiver = &check->waivers[i];
        if (strcmp(waiver->rule, rule->id) != 0)
            continue;
        waiver->used = true;
        if (!waiver->expired)
            rule->waiver = waiver;
    }
}

static void count(struct report *report, const struct rule_report *rule)
{
    report->passed += rule->outcome == RULE_PASSED;
    const bool note = rule->severity == SEVERITY_NOTE;
    report->failed += rule->outcome == RULE_FAILED && !note;
    report->noted += rule->outcome == RULE_FAILED && note;
    report->not_judged += rule->outcome == RULE_NOT_JUDGED && !note;
    report->waived += rule->waiver != NULL;
    if (report_fails(report, rule))
        report->verdict = VERDICT_FAIL;
    if (rule->outcome == RULE_NOT_JUDGED && report_decides(report, rule) &&
        report->verdict != VERDICT_FAIL)
        report->verdict = VERDICT_INCOMPLETE;
}

int check_judge(struct check *check, const struct check_options *options)
{
    struct report *report = &check->report;
    const char *shown = options->shown != NULL ? options->shown : options->path;
    const char *slash = strrchr(shown, '/');
    const struct case_file file = {
        .image = check->image,
        .profile = options->profile,
        .name = slash != NULL ? slash + 1 : shown,
        .runs = check->runs,
        .scenarios = check->scenarios,
        .scenario_count = options->scenario_count,
        .cannot_run = check->cannot_run,
    };
    report->budgets = check->budgets;
    report->budget_count = budgets_report(&file, check->budgets);
    list_waivers(check, options);
    count_runs(check, options);
    for (size_t i = 0; i < report->rule_count; i++) {
        judge_rule(check, options, &file, i);
        waive(check, &check->rules[i]);
        count(report, &check->rules[i]);
    }
    for (size_t i = 0; i < report->waiver_count; i++)
        if (report->waivers[i].expired)
            report->verdict = VERDICT_FAIL;
    return check->sparing ? 0 : tell(check, &file);
}
