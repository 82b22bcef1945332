/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/report.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>

/* Paths may hold any bytes, JSON holds UTF-8 only: what is not UTF-8 is written as U+FFFD. */
static json_t *text(const char *value)
{
    json_t *string = json_string(value);
    if (string != NULL)
        return string;
    char clean[4096];
    size_t at = 0;
    for (const unsigned char *c = (const unsigned char *)value; *c != 0 && at + 4 < sizeof clean;
         c++)
        at += (size_t)snprintf(clean + at, sizeof clean - at, "%s",
                               *c < 0x80 ? (char[]){ (char)*c, 0 } : "\xEF\xBF\xBD");
    return json_string(clean);
}

static json_t *seed_text(uint64_t seed)
{
    char buffer[24];
    snprintf(buffer, sizeof buffer, "0x%" PRIx64, seed);
    return json_string(buffer);
}

static json_t *finding_json(const struct finding *finding)
{
    json_t *object = json_object();
    json_object_set_new(object, "what", text(finding->what));
    json_object_set_new(object, "count", json_integer((json_int_t)finding->count));
    if (finding->place[0] != '\0')
        json_object_set_new(object, "place", text(finding->place));
    if (finding->function != NULL)
        json_object_set_new(object, "function", text(finding->function));
    if (finding->has_cycle)
        json_object_set_new(object, "cycle", json_integer((json_int_t)finding->cycle));
    if (finding->again[0] != '\0')
        json_object_set_new(object, "again", text(finding->again));
    return object;
}

static json_t *rule_json(const struct rule_report *rule)
{
    json_t *object = json_object();
    json_t *findings = json_array();
    json_object_set_new(object, "id", text(rule->id));
    json_object_set_new(object, "group", text(rule->group));
    json_object_set_new(object, "severity", text(severity_name(rule->severity)));
    json_object_set_new(object, "outcome", text(outcome_name(rule->outcome)));
    json_object_set_new(object, "clause", text(rule->clause));
    json_object_set_new(object, "title", text(rule->title));
    if (rule->outcome == RULE_NOT_JUDGED)
        json_object_set_new(object, "reason", text(rule->reason));
    for (size_t i = 0; i < rule->finding_count; i++)
        json_array_append_new(findings, finding_json(&rule->findings[i]));
    json_object_set_new(object, "findings", findings);
    if (rule->dropped > 0)
        json_object_set_new(object, "findings_dropped", json_integer((json_int_t)rule->dropped));
    return object;
}

int report_json(const struct report *r, FILE *stream)
{
    json_t *root = json_object(), *module = json_object(), *counts = json_object(),
           *rules = json_array();
    if (root == NULL || module == NULL || counts == NULL || rules == NULL)
        return -ENOMEM;
    json_object_set_new(root, "schema", text("tgm-check/1"));
    json_object_set_new(root, "tool", text(r->tool));
    json_object_set_new(module, "path", text(r->path));
    json_object_set_new(module, "sha256", text(r->sha256));
    json_object_set_new(module, "size", json_integer((json_int_t)r->size));
    json_object_set_new(module, "format", text(r->format));
    json_object_set_new(module, "target", text(r->target));
    json_object_set_new(root, "module", module);
    json_object_set_new(root, "profile", text(r->profile));
    json_object_set_new(root, "seed", seed_text(r->seed));
    json_object_set_new(root, "selection", r->selection != NULL ? text(r->selection) : json_null());
    json_object_set_new(root, "cycles",
                        r->cycles != 0 ? json_integer((json_int_t)r->cycles) : json_null());
    json_object_set_new(root, "verdict", text(verdict_name(r->verdict)));
    json_object_set_new(counts, "passed", json_integer(r->passed));
    json_object_set_new(counts, "failed", json_integer(r->failed));
    json_object_set_new(counts, "not_judged", json_integer(r->not_judged));
    json_object_set_new(root, "counts", counts);
    for (size_t i = 0; i < r->rule_count; i++)
        json_array_append_new(rules, rule_json(&r->rules[i]));
    json_object_set_new(root, "rules", rules);
    int bad = json_dumpf(root, stream, JSON_INDENT(2));
    json_decref(root);
    if (bad != 0 || fputc('\n', stream) == EOF || fflush(stream) != 0)
        return errno != 0 ? -errno : -EIO;
    return 0;
}
