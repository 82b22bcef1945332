/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * SARIF 2.1.0, as code viewers and code hosts read it: every rule with its result. A passed rule is
 * of kind "pass", one that was not judged "open", a failed one "fail" with a result a finding.
 */
#include <inttypes.h>
#include <sodium.h>
#include <string.h>

#include "report/json_text.h"
#include "report/markup.h"
#include "report/report.h"

#define URI 2048

static const char *level(const struct report *r, const struct rule_report *rule)
{
    return report_decides(r, rule)             ? "error"
           : rule->severity == SEVERITY_SHOULD ? "warning"
                                               : "note";
}

static json_t *message(const char *text)
{
    json_t *object = json_object();
    json_object_set_new(object, "text", json_text(text));
    return object;
}

static json_t *uri(const char *path)
{
    char encoded[URI], *at = encoded;
    if (path[0] == '/')
        at += snprintf(encoded, sizeof encoded, "file://");
    markup_uri(path, at, sizeof encoded - (size_t)(at - encoded));
    return json_string(encoded);
}

static json_t *rule_json(const struct report *r, const struct rule_report *rule)
{
    json_t *object = json_object(), *configuration = json_object(), *properties = json_object();
    json_object_set_new(object, "id", json_text(rule->id));
    json_object_set_new(object, "shortDescription", message(rule->title));
    json_object_set_new(object, "help", message(rule->advice));
    json_object_set_new(configuration, "level", json_text(level(r, rule)));
    json_object_set_new(object, "defaultConfiguration", configuration);
    json_object_set_new(properties, "group", json_text(rule->group));
    json_object_set_new(properties, "severity", json_text(severity_name(rule->severity)));
    json_object_set_new(properties, "clause", json_text(rule->clause));
    json_object_set_new(object, "properties", properties);
    return object;
}

static json_t *driver(const struct report *r)
{
    json_t *object = json_object(), *rules = json_array();
    const char *space = strchr(r->tool, ' ');
    json_object_set_new(object, "name", json_text("tgm"));
    if (space != NULL)
        json_object_set_new(object, "semanticVersion", json_text(space + 1));
    for (size_t i = 0; i < r->rule_count; i++)
        json_array_append_new(rules, rule_json(r, &r->rules[i]));
    json_object_set_new(object, "rules", rules);
    return object;
}

/* The module itself; its bytes are what was judged. */
static json_t *artifact(const struct report *r)
{
    json_t *object = json_object(), *location = json_object(), *hashes = json_object();
    json_object_set_new(location, "uri", uri(r->path));
    json_object_set_new(object, "location", location);
    json_object_set_new(object, "length", json_integer((json_int_t)r->size));
    json_object_set_new(object, "roles", json_pack("[s]", "analysisTarget"));
    json_object_set_new(hashes, "sha-256", json_text(r->sha256));
    json_object_set_new(object, "hashes", hashes);
    return object;
}

static json_t *module_place(const struct report *r)
{
    json_t *artifact_location = json_object();
    json_object_set_new(artifact_location, "uri", uri(r->path));
    json_object_set_new(artifact_location, "index", json_integer(0));
    return artifact_location;
}

/* The source line where it is known, else the module, with the address in it. */
static json_t *physical(const struct report *r, const struct finding *finding)
{
    json_t *place = json_object(), *artifact_location;
    if (finding->file[0] == '\0') {
        artifact_location = module_place(r);
    } else {
        artifact_location = json_object();
        json_object_set_new(artifact_location, "uri", uri(finding->file));
        if (finding->file[0] != '/')
            json_object_set_new(artifact_location, "uriBaseId", json_text("SRCROOT"));
    }
    json_object_set_new(place, "artifactLocation", artifact_location);
    if (finding->file[0] != '\0' && finding->line > 0)
        json_object_set_new(place, "region", json_pack("{si}", "startLine", finding->line));
    if (finding->has_address && finding->address <= INT64_MAX)
        json_object_set_new(place, "address",
                            json_pack("{sI}", "relativeAddress", (json_int_t)finding->address));
    return place;
}

static json_t *location(const struct report *r, const struct finding *finding)
{
    json_t *object = json_object();
    json_object_set_new(object, "physicalLocation", physical(r, finding));
    if (finding->function != NULL) {
        json_t *logical = json_object();
        json_object_set_new(logical, "fullyQualifiedName", json_text(finding->function));
        json_object_set_new(logical, "kind", json_text("function"));
        json_object_set_new(object, "logicalLocations", json_pack("[o]", logical));
    }
    return object;
}

/* The same fault in the next build has the same print: no cycle, address or line goes in. */
static json_t *fingerprint(const struct rule_report *rule, const struct finding *finding)
{
    unsigned char hash[crypto_hash_sha256_BYTES];
    char hex[2 * sizeof hash + 1];
    crypto_hash_sha256_state state;
    crypto_hash_sha256_init(&state);
    crypto_hash_sha256_update(&state, (const unsigned char *)rule->id, strlen(rule->id) + 1);
    crypto_hash_sha256_update(&state, (const unsigned char *)finding->what,
                              strlen(finding->what) + 1);
    crypto_hash_sha256_final(&state, hash);
    sodium_bin2hex(hex, sizeof hex, hash, sizeof hash);
    return json_pack("{ss}", "tgmFinding/v1", hex);
}

static json_t *waiver_json(const struct waiver_report *waiver)
{
    json_t *object = json_object(), *properties = json_object();
    json_object_set_new(object, "kind", json_text("external"));
    json_object_set_new(object, "justification", json_text(waiver->reason));
    json_object_set_new(properties, "owner", json_text(waiver->owner));
    json_object_set_new(properties, "expiry", json_text(waiver->expiry));
    json_object_set_new(object, "properties", properties);
    return object;
}

static json_t *result(const struct rule_report *rule, size_t index, const char *kind,
                      const char *result_level, const char *text)
{
    json_t *object = json_object();
    json_object_set_new(object, "ruleId", json_text(rule->id));
    json_object_set_new(object, "ruleIndex", json_integer((json_int_t)index));
    json_object_set_new(object, "kind", json_text(kind));
    json_object_set_new(object, "level", json_text(result_level));
    json_object_set_new(object, "message", message(text));
    return object;
}

static json_t *finding_json(const struct report *r, size_t index, const struct finding *finding)
{
    const struct rule_report *rule = &r->rules[index];
    char text[FINDING_TEXT + sizeof finding->when + 1];
    snprintf(text, sizeof text, "%s%s%s", finding->what, finding->when[0] != '\0' ? " " : "",
             finding->when);
    json_t *object = result(rule, index, "fail", level(r, rule), text);
    json_t *properties = json_object();
    json_object_set_new(object, "locations", json_pack("[o]", location(r, finding)));
    json_object_set_new(object, "partialFingerprints", fingerprint(rule, finding));
    json_object_set_new(object, "occurrenceCount", json_integer((json_int_t)finding->count));
    if (rule->waiver != NULL)
        json_object_set_new(object, "suppressions", json_pack("[o]", waiver_json(rule->waiver)));
    if (finding->place[0] != '\0')
        json_object_set_new(properties, "place", json_text(finding->place));
    if (finding->again[0] != '\0')
        json_object_set_new(properties, "again", json_text(finding->again));
    json_object_set_new(object, "properties", properties);
    return object;
}

static json_t *about_module(const struct report *r, json_t *object)
{
    json_t *place = json_object(), *physical_location = json_object();
    json_object_set_new(physical_location, "artifactLocation", module_place(r));
    json_object_set_new(place, "physicalLocation", physical_location);
    json_object_set_new(object, "locations", json_pack("[o]", place));
    return object;
}

static void add_results(const struct report *r, size_t index, json_t *results)
{
    const struct rule_report *rule = &r->rules[index];
    switch (rule->outcome) {
    case RULE_PASSED:
        json_array_append_new(results,
                              about_module(r, result(rule, index, "pass", "none", rule->title)));
        return;
    case RULE_NOT_JUDGED:
        json_array_append_new(results,
                              about_module(r, result(rule, index, "open", "none", rule->reason)));
        return;
    case RULE_FAILED:
        for (size_t i = 0; i < rule->finding_count; i++)
            json_array_append_new(results, finding_json(r, index, &rule->findings[i]));
        return;
    }
}

static json_t *run_properties(const struct report *r)
{
    json_t *object = json_object();
    json_object_set_new(object, "verdict", json_text(verdict_name(r->verdict)));
    json_object_set_new(object, "profile", json_text(r->profile));
    json_object_set_new(object, "seed", json_hex(r->seed));
    json_object_set_new(object, "strict", json_boolean(r->strict));
    json_object_set_new(object, "instrumented", json_boolean(r->instrumented));
    if (r->rule_book != NULL)
        json_object_set_new(object, "ruleBook", json_text(r->rule_book));
    if (r->evidence != NULL)
        json_object_set_new(object, "evidence", json_text(r->evidence));
    return object;
}

/* Waivers that are out of date: no result of any rule, and they fail the module. */
static json_t *invocation(const struct report *r)
{
    json_t *object = json_object(), *notes = json_array();
    char text[FINDING_TEXT];
    for (size_t i = 0; i < r->waiver_count; i++) {
        const struct waiver_report *waiver = &r->waivers[i];
        if (!waiver->expired)
            continue;
        snprintf(text, sizeof text, "The waiver for %s is out of date since %s (%s: %s).",
                 waiver->rule, waiver->expiry, waiver->owner, waiver->reason);
        json_t *note = json_object(), *rule = json_object();
        json_object_set_new(rule, "id", json_text(waiver->rule));
        json_object_set_new(note, "level", json_text("error"));
        json_object_set_new(note, "message", message(text));
        json_object_set_new(note, "associatedRule", rule);
        json_array_append_new(notes, note);
    }
    json_object_set_new(object, "executionSuccessful", json_true());
    json_object_set_new(object, "toolConfigurationNotifications", notes);
    return object;
}

int report_sarif(const struct report *r, FILE *stream)
{
    json_t *root = json_object(), *run = json_object(), *results = json_array();
    for (size_t i = 0; i < r->rule_count; i++)
        add_results(r, i, results);
    json_object_set_new(run, "tool", json_pack("{so}", "driver", driver(r)));
    json_object_set_new(run, "invocations", json_pack("[o]", invocation(r)));
    json_object_set_new(run, "artifacts", json_pack("[o]", artifact(r)));
    json_object_set_new(run, "columnKind", json_text("unicodeCodePoints"));
    json_object_set_new(run, "results", results);
    json_object_set_new(run, "properties", run_properties(r));
    json_object_set_new(root, "version", json_text("2.1.0"));
    json_object_set_new(root, "runs", json_pack("[o]", run));
    return json_document(root, stream);
}
