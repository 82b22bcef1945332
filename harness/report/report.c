/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/report.h"

#include <string.h>

static const char *const severity_names[] = { "must", "should", "note" };
static const char *const outcome_names[] = { "pass", "fail", "not judged" };
static const char *const verdict_names[] = { "PASS", "FAIL", "INCOMPLETE" };
static const char *const timeline_names[TIMELINE_KINDS] = { "state", "fault", "message",
                                                            "expectation", "incident" };

const char *severity_name(enum severity severity)
{
    return severity_names[severity];
}

const char *outcome_name(enum rule_outcome outcome)
{
    return outcome_names[outcome];
}

const char *verdict_name(enum verdict verdict)
{
    return verdict_names[verdict];
}

const char *timeline_name(enum timeline_kind kind)
{
    return timeline_names[kind];
}

const char *report_file_name(const struct report *report)
{
    const char *slash = strrchr(report->path, '/');
    return slash != NULL && slash[1] != '\0' ? slash + 1 : report->path;
}

bool report_decides(const struct report *report, const struct rule_report *rule)
{
    return rule->severity == SEVERITY_MUST || (rule->severity == SEVERITY_SHOULD && report->strict);
}

bool report_fails(const struct report *report, const struct rule_report *rule)
{
    return rule->outcome == RULE_FAILED && rule->waiver == NULL && report_decides(report, rule);
}

void report_tally(const struct report *report, const char *group, struct report_tally *tally)
{
    memset(tally, 0, sizeof *tally);
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        if (group != NULL && strcmp(rule->group, group) != 0)
            continue;
        tally->all++;
        tally->passed += rule->outcome == RULE_PASSED;
        tally->not_judged += rule->outcome == RULE_NOT_JUDGED;
        tally->waived += rule->outcome == RULE_FAILED && rule->waiver != NULL;
        tally->failed += report_fails(report, rule);
        tally->warned +=
            rule->outcome == RULE_FAILED && rule->waiver == NULL && !report_decides(report, rule);
    }
}

double budget_share(const struct budget_report *budget)
{
    return budget->allowed > 0 ? budget->worst / budget->allowed : 0;
}
