/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>

#include "report/json_text.h"
#include "report/report.h"

static json_t *count(uint64_t value)
{
    return json_integer((json_int_t)value);
}

static json_t *finding_json(const struct finding *finding)
{
    json_t *object = json_object();
    json_object_set_new(object, "what", json_text(finding->what));
    json_object_set_new(object, "count", count(finding->count));
    if (finding->place[0] != '\0')
        json_object_set_new(object, "place", json_text(finding->place));
    if (finding->has_address)
        json_object_set_new(object, "address", json_hex(finding->address));
    if (finding->file[0] != '\0') {
        json_object_set_new(object, "file", json_text(finding->file));
        json_object_set_new(object, "line", json_integer(finding->line));
    }
    if (finding->function != NULL)
        json_object_set_new(object, "function", json_text(finding->function));
    if (finding->has_cycle)
        json_object_set_new(object, "cycle", count(finding->cycle));
    if (finding->again[0] != '\0')
        json_object_set_new(object, "again", json_text(finding->again));
    if (finding->debug[0] != '\0')
        json_object_set_new(object, "debug", json_text(finding->debug));
    return object;
}

static json_t *rule_json(const struct rule_report *rule)
{
    json_t *object = json_object();
    json_t *findings = json_array();
    json_object_set_new(object, "id", json_text(rule->id));
    json_object_set_new(object, "group", json_text(rule->group));
    json_object_set_new(object, "severity", json_text(severity_name(rule->severity)));
    json_object_set_new(object, "outcome", json_text(outcome_name(rule->outcome)));
    json_object_set_new(object, "clause", json_text(rule->clause));
    json_object_set_new(object, "title", json_text(rule->title));
    if (rule->outcome == RULE_NOT_JUDGED)
        json_object_set_new(object, "reason", json_text(rule->reason));
    if (rule->waiver != NULL)
        json_object_set_new(object, "waived", json_true());
    for (size_t i = 0; i < rule->finding_count; i++)
        json_array_append_new(findings, finding_json(&rule->findings[i]));
    json_object_set_new(object, "findings", findings);
    if (rule->dropped > 0)
        json_object_set_new(object, "findings_dropped", count(rule->dropped));
    return object;
}

static json_t *budget_json(const struct budget_report *budget)
{
    json_t *object = json_object();
    json_object_set_new(object, "name", json_text(budget->name));
    json_object_set_new(object, "unit", json_text(budget->unit));
    if (budget->reason[0] != '\0') {
        json_object_set_new(object, "reason", json_text(budget->reason));
        return object;
    }
    json_object_set_new(object, "worst", json_real(budget->worst));
    if (budget->allowed > 0)
        json_object_set_new(object, "allowed", json_real(budget->allowed));
    if (budget->has_cycle)
        json_object_set_new(object, "cycle", count(budget->cycle));
    if (budget->cycle_us != 0)
        json_object_set_new(object, "cycle_us", count(budget->cycle_us));
    if (budget->instructions != 0)
        json_object_set_new(object, "instructions", count(budget->instructions));
    return object;
}

static json_t *coverage_json(const struct coverage_report *coverage)
{
    json_t *object = json_object();
    json_object_set_new(object, "name", json_text(coverage->name));
    json_object_set_new(object, "executed", count(coverage->executed));
    json_object_set_new(object, "total", count(coverage->total));
    if (coverage->missed[0] != '\0')
        json_object_set_new(object, "missed", json_text(coverage->missed));
    return object;
}

static json_t *event_json(const struct timeline_event *event)
{
    json_t *object = json_object();
    json_object_set_new(object, "kind", json_text(timeline_name(event->kind)));
    json_object_set_new(object, "seconds", json_real(event->seconds));
    if (event->has_cycle)
        json_object_set_new(object, "cycle", count(event->cycle));
    json_object_set_new(object, "source", json_text(event->source));
    json_object_set_new(object, "text", json_text(event->text));
    json_object_set_new(object, "count", count(event->count));
    return object;
}

static json_t *timeline_json(const struct timeline_report *timeline)
{
    json_t *object = json_object(), *events = json_array();
    json_object_set_new(object, "name", json_text(timeline->name));
    json_object_set_new(object, "about", json_text(timeline->about));
    json_object_set_new(object, "seconds", json_real(timeline->seconds));
    for (size_t i = 0; i < timeline->event_count; i++)
        json_array_append_new(events, event_json(&timeline->events[i]));
    json_object_set_new(object, "events", events);
    if (timeline->dropped > 0)
        json_object_set_new(object, "events_dropped", count(timeline->dropped));
    return object;
}

static json_t *waiver_json(const struct waiver_report *waiver)
{
    json_t *object = json_object();
    json_object_set_new(object, "rule", json_text(waiver->rule));
    json_object_set_new(object, "reason", json_text(waiver->reason));
    json_object_set_new(object, "owner", json_text(waiver->owner));
    json_object_set_new(object, "expiry", json_text(waiver->expiry));
    json_object_set_new(object, "expired", json_boolean(waiver->expired));
    json_object_set_new(object, "used", json_boolean(waiver->used));
    return object;
}

static json_t *module_json(const struct report *r)
{
    json_t *module = json_object();
    json_object_set_new(module, "path", json_text(r->path));
    json_object_set_new(module, "sha256", json_text(r->sha256));
    json_object_set_new(module, "size", count(r->size));
    json_object_set_new(module, "format", json_text(r->format));
    json_object_set_new(module, "target", json_text(r->target));
    return module;
}

static json_t *counts_json(const struct report *r)
{
    struct report_tally tally;
    json_t *counts = json_object();
    report_tally(r, NULL, &tally);
    json_object_set_new(counts, "passed", json_integer(r->passed));
    json_object_set_new(counts, "failed", json_integer(r->failed));
    json_object_set_new(counts, "not_judged", json_integer(r->not_judged));
    json_object_set_new(counts, "noted", json_integer(r->noted));
    json_object_set_new(counts, "waived", json_integer(tally.waived));
    return counts;
}

/* The parts that are lists: each of the report's arrays by its own function. */
#define LIST(array, number, to_json)                                                               \
    for (size_t i = 0; i < (number); i++)                                                          \
    json_array_append_new(list, to_json(&(array)[i]))

static void add_lists(const struct report *r, json_t *root)
{
    json_t *list;
    json_object_set_new(root, "rules", list = json_array());
    LIST(r->rules, r->rule_count, rule_json);
    json_object_set_new(root, "budgets", list = json_array());
    LIST(r->budgets, r->budget_count, budget_json);
    json_object_set_new(root, "coverage", list = json_array());
    LIST(r->coverage, r->coverage_count, coverage_json);
    if (r->coverage_reason != NULL)
        json_object_set_new(root, "coverage_reason", json_text(r->coverage_reason));
    json_object_set_new(root, "runs", list = json_array());
    LIST(r->timelines, r->timeline_count, timeline_json);
    json_object_set_new(root, "waivers", list = json_array());
    LIST(r->waivers, r->waiver_count, waiver_json);
}

int report_json(const struct report *r, FILE *stream)
{
    json_t *root = json_object();
    if (root == NULL)
        return -ENOMEM;
    json_object_set_new(root, "schema", json_text("tgm-check/1"));
    json_object_set_new(root, "tool", json_text(r->tool));
    json_object_set_new(root, "module", module_json(r));
    json_object_set_new(root, "profile", json_text(r->profile));
    json_object_set_new(root, "seed", json_hex(r->seed));
    json_object_set_new(root, "selection", json_text(r->selection));
    json_object_set_new(root, "config", json_text(r->config));
    json_object_set_new(root, "cycles", r->cycles != 0 ? count(r->cycles) : json_null());
    json_object_set_new(root, "strict", json_boolean(r->strict));
    json_object_set_new(root, "instrumented", json_boolean(r->instrumented));
    json_object_set_new(root, "machines",
                        json_pack("{s:i, s:i}", "native", (int)(r->runs_all - r->runs_emulated),
                                  "instrumented", (int)r->runs_emulated));
    json_object_set_new(root, "rule_book", json_text(r->rule_book));
    json_object_set_new(root, "evidence", json_text(r->evidence));
    json_object_set_new(root, "verdict", json_text(verdict_name(r->verdict)));
    json_object_set_new(root, "counts", counts_json(r));
    add_lists(r, root);
    return json_document(root, stream);
}
