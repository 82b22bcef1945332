/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/certificate.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PAYLOAD   "application/vnd.in-toto+json"
#define STATEMENT "https://in-toto.io/Statement/v1"
#define PREDICATE "https://in-toto.io/attestation/test-result/v0.1"

/* The fields of `configuration`, in their order; each with the hash of what is named. */
enum { PART_TOOL, PART_PROFILE, PART_EVIDENCE, PART_COUNT };

static bool refuse(char why[CERTIFICATE_WHY], const char *what)
{
    snprintf(why, CERTIFICATE_WHY, "%s", what);
    return false;
}

/* --- from a report ---------------------------------------------------------------------------- */

static bool add_rule(struct certificate_rules *rules, const char *id)
{
    if (rules->count == CERTIFICATE_RULES || strlen(id) >= sizeof *rules->ids)
        return false;
    strcpy(rules->ids[rules->count++], id);
    return true;
}

static bool is_text(const char *name)
{
    json_t *string = json_string(name);
    json_decref(string);
    return string != NULL;
}

static bool fill_rules(struct certificate *certificate, const struct report *report)
{
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        if (!add_rule(rule->outcome == RULE_PASSED ? &certificate->passed : &certificate->warned,
                      rule->id))
            return false;
    }
    return true;
}

bool certificate_fill(struct certificate *certificate, const struct report *report,
                      const char *suite, const char *program, char why[CERTIFICATE_WHY])
{
    char profile[2 * CERTIFICATE_TEXT];
    memset(certificate, 0, sizeof *certificate);
    if (report->verdict != VERDICT_PASS)
        return refuse(why, report->verdict == VERDICT_FAIL
                               ? "the module does not conform; nothing was signed"
                               : "not everything could be judged; nothing was signed");
    if (report->waiver_count > 0 || report->selection != NULL || report->config != NULL ||
        report->cycles != 0)
        return refuse(why, "only the whole profile, without waivers, is signed for");
    if (report->rule_book == NULL || report->evidence == NULL)
        return refuse(why, "the evidence was not saved; nothing was signed");
    snprintf(profile, sizeof profile, "%s/%s", suite, report->profile);
    if (!is_text(report_file_name(report)))
        return refuse(why, "the module's name is no UTF-8 text; rename the file");
    const struct {
        char *to;
        size_t size;
        const char *from;
    } texts[] = {
        { certificate->name, sizeof certificate->name, report_file_name(report) },
        { certificate->module, sizeof certificate->module, report->sha256 },
        { certificate->tool, sizeof certificate->tool, report->tool },
        { certificate->program, sizeof certificate->program, program },
        { certificate->profile, sizeof certificate->profile, profile },
        { certificate->rule_book, sizeof certificate->rule_book, report->rule_book },
        { certificate->evidence, sizeof certificate->evidence, report->evidence },
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if ((size_t)snprintf(texts[i].to, texts[i].size, "%s", texts[i].from) >= texts[i].size)
            return refuse(why, "a name is too long for a certificate; nothing was signed");
    return fill_rules(certificate, report) ||
           refuse(why, "there are too many rules for a certificate; nothing was signed");
}

/* --- the statement ---------------------------------------------------------------------------- */

static json_t *list_json(const struct certificate_rules *rules)
{
    json_t *list = json_array();
    for (size_t i = 0; i < rules->count; i++)
        json_array_append_new(list, json_string(rules->ids[i]));
    return list;
}

static json_t *part_json(const char *name, const char *sha256, const char *key, const char *value)
{
    return json_pack("{s:s, s:{s:s}, s:{s:s}}", "name", name, "digest", "sha256", sha256,
                     "annotations", key, value);
}

/* The one text of a statement; to be freed. */
static char *statement(const struct certificate *c)
{
    json_t *root = json_pack(
        "{s:s, s:[{s:s, s:{s:s}}], s:s, s:{s:s, s:[o, o, o], s:o, s:o, s:[]}}", "_type", STATEMENT,
        "subject", "name", c->name, "digest", "sha256", c->module, "predicateType", PREDICATE,
        "predicate", "result", c->warned.count > 0 ? "WARNED" : "PASSED", "configuration",
        part_json("tgm", c->program, "version", c->tool),
        part_json("rule-book", c->rule_book, "profile", c->profile),
        part_json("evidence", c->evidence, "of", "manifest.json"), "passedTests",
        list_json(&c->passed), "warnedTests", list_json(&c->warned), "failedTests");
    char *text = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(root);
    return text;
}

char *certificate_sign(const struct certificate *certificate, const struct secret_key *key)
{
    char *text = statement(certificate);
    char *sealed = text != NULL ? envelope_seal(PAYLOAD, text, strlen(text), key) : NULL;
    free(text);
    return sealed;
}

/* --- back ------------------------------------------------------------------------------------- */

static bool read_text(const json_t *object, const char *key, char *out, size_t size)
{
    const char *text = json_string_value(json_object_get(object, key));
    if (text == NULL || text[0] == '\0' || strlen(text) >= size)
        return false;
    strcpy(out, text);
    return true;
}

static bool read_hash(const json_t *object, char out[CERTIFICATE_HASH])
{
    return read_text(json_object_get(object, "digest"), "sha256", out, CERTIFICATE_HASH) &&
           strlen(out) == CERTIFICATE_HASH - 1 &&
           strspn(out, "0123456789abcdef") == CERTIFICATE_HASH - 1;
}

static bool read_rules(const json_t *list, struct certificate_rules *rules)
{
    size_t i;
    json_t *id;
    json_array_foreach(list, i, id) if (!json_is_string(id) ||
                                        !add_rule(rules, json_string_value(id))) return false;
    return json_is_array(list);
}

static bool read_statement(struct certificate *c, const json_t *root)
{
    const json_t *predicate = json_object_get(root, "predicate");
    const json_t *parts = json_object_get(predicate, "configuration");
    const json_t *subject = json_array_get(json_object_get(root, "subject"), 0);
    const json_t *part[PART_COUNT];
    for (size_t i = 0; i < PART_COUNT; i++)
        part[i] = json_array_get(parts, i);
    return read_text(subject, "name", c->name, sizeof c->name) && read_hash(subject, c->module) &&
           read_hash(part[PART_TOOL], c->program) &&
           read_text(json_object_get(part[PART_TOOL], "annotations"), "version", c->tool,
                     sizeof c->tool) &&
           read_hash(part[PART_PROFILE], c->rule_book) &&
           read_text(json_object_get(part[PART_PROFILE], "annotations"), "profile", c->profile,
                     sizeof c->profile) &&
           read_hash(part[PART_EVIDENCE], c->evidence) &&
           read_rules(json_object_get(predicate, "passedTests"), &c->passed) &&
           read_rules(json_object_get(predicate, "warnedTests"), &c->warned);
}

/* What was read says all there is: written again it is the same text. A statement with other types,
 * a FAILED one, or one with more in it is none of ours, whoever has signed it. */
static bool says_the_same(const struct certificate *certificate, const char *text, size_t size)
{
    char *again = statement(certificate);
    const bool same = again != NULL && strlen(again) == size && memcmp(again, text, size) == 0;
    free(again);
    return same;
}

int certificate_open(struct certificate *certificate, const char *text, size_t size,
                     const struct public_key *key, char why[CERTIFICATE_WHY])
{
    char sealed[ENVELOPE_WHY];
    size_t length = 0;
    memset(certificate, 0, sizeof *certificate);
    char *payload = envelope_open(PAYLOAD, text, size, key, &length, sealed);
    if (payload == NULL) {
        refuse(why, sealed);
        return -EINVAL;
    }
    json_t *root = json_loadb(payload, length, JSON_REJECT_DUPLICATES, NULL);
    const bool good = root != NULL && read_statement(certificate, root) &&
                      says_the_same(certificate, payload, length);
    json_decref(root);
    free(payload);
    if (!good)
        refuse(why, "it is signed, but it does not state that a module passed");
    return good ? 0 : -EINVAL;
}
