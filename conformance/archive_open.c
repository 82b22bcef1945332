/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/archive_parts.h"

#include <errno.h>
#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/evidence_file.h"
#include "host/scenario.h"
#include "image/sha256.h"

struct archive {
    char folder[4096], module[ARCHIVE_PATH];
    char hash[ARCHIVE_HASH];
    json_t *manifest;
    struct check_options options;
    struct waivers waivers;
    struct check_scenario scenarios[ARCHIVE_SCENARIOS];
    char *texts[ARCHIVE_SCENARIOS];
};

static __attribute__((format(printf, 2, 3))) int refuse(char why[CHECK_WHY], const char *format,
                                                        ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, CHECK_WHY, format, arguments);
    va_end(arguments);
    return -EINVAL;
}

/* The same, and it must be what the manifest says. */
static char *read_listed(const struct archive *archive, const char *name, size_t *size,
                         char why[CHECK_WHY])
{
    const json_t *entry = json_object_get(json_object_get(archive->manifest, "files"), name);
    const char *wanted = json_string_value(json_object_get(entry, "sha256"));
    const json_int_t length = json_integer_value(json_object_get(entry, "size"));
    char hash[ARCHIVE_HASH];
    if (wanted == NULL) {
        refuse(why, "'%s/%s' is not in the manifest", archive->folder, name);
        return NULL;
    }
    char *bytes = archive_read(archive->folder, name, size, why);
    if (bytes == NULL)
        return NULL;
    sha256_text(bytes, *size, hash);
    if ((json_int_t)*size == length && strcmp(hash, wanted) == 0)
        return bytes;
    if ((json_int_t)*size != length)
        refuse(why, "'%s/%s' is not what was written: %zu bytes instead of %lld", archive->folder,
               name, *size, (long long)length);
    else
        refuse(why, "'%s/%s' is not what was written: its SHA-256 is %.8s..., not %.8s...",
               archive->folder, name, hash, wanted);
    free(bytes);
    return NULL;
}

/* A member that is text; NULL where it is null or missing. */
static const char *text_of(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

static int read_waivers(struct archive *archive, char why[CHECK_WHY])
{
    const json_t *list = json_object_get(archive->manifest, "waivers");
    char text[WAIVERS_MOST * sizeof(struct waiver)] = "", reason[WAIVERS_WHY];
    size_t at = 0;
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *entry = json_array_get(list, i);
        const char *rule = text_of(entry, "rule"), *until = text_of(entry, "until"),
                   *by = text_of(entry, "by"), *because = text_of(entry, "reason");
        if (rule == NULL || until == NULL || by == NULL || because == NULL)
            return refuse(why, "the manifest's waivers are damaged");
        /* Read like a file of them, so that the same is demanded of them. */
        const int length = snprintf(text + at, sizeof text - at, "%s until %s by %s: %s\n", rule,
                                    until, by, because);
        if (length < 0 || (size_t)length >= sizeof text - at)
            return refuse(why, "the manifest has too many waivers");
        at += (size_t)length;
    }
    if (waivers_read(&archive->waivers, text, at, ARCHIVE_MANIFEST, reason) != 0)
        return refuse(why, "%s", reason);
    archive->options.waivers = archive->waivers.count > 0 ? &archive->waivers : NULL;
    return 0;
}

static int read_options(struct archive *archive, char why[CHECK_WHY])
{
    const json_t *manifest = archive->manifest;
    struct check_options *o = &archive->options;
    const char *profile = text_of(manifest, "profile"), *seed = text_of(manifest, "seed");
    const json_int_t cycles = json_integer_value(json_object_get(manifest, "cycles"));
    char *end = NULL;
    o->tool = text_of(manifest, "tool");
    o->shown = text_of(manifest, "shown");
    if (o->shown == NULL)
        o->shown = text_of(manifest, "module");
    o->path = archive->module;
    o->profile = profile != NULL ? profile_find(profile) : NULL;
    o->rules = text_of(manifest, "rules");
    o->strict = json_is_true(json_object_get(manifest, "strict"));
    o->instrumented = json_is_true(json_object_get(manifest, "instrumented"));
    o->around_path = text_of(manifest, "config");
    o->today = text_of(manifest, "today");
    o->again_path = text_of(manifest, "module");
    if (o->tool == NULL || o->shown == NULL || o->profile == NULL || seed == NULL ||
        o->today == NULL || o->again_path == NULL || cycles < 0)
        return refuse(why, "the manifest is not complete");
    o->seed = strtoull(seed, &end, 16);
    if (*end != '\0' || end == seed)
        return refuse(why, "the manifest's seed is no number");
    o->cycles = (uint64_t)cycles;
    return read_waivers(archive, why);
}

static int read_scenarios(struct archive *archive, char why[CHECK_WHY])
{
    const struct product *product = product_find(archive->options.profile->product);
    const struct catalogue *catalogue =
        catalogue_find(product->generation, (int)product->memory_id);
    const json_t *list = json_object_get(archive->manifest, "scenarios");
    char name[64], reason[SCENARIO_WHY];
    if (json_array_size(list) > ARCHIVE_SCENARIOS)
        return refuse(why, "the manifest has more than %d scenarios", ARCHIVE_SCENARIOS);
    archive->options.scenarios = archive->scenarios;
    for (size_t i = 0; i < json_array_size(list); i++) {
        struct check_scenario *scenario = &archive->scenarios[i];
        size_t size;
        archive_scenario_name(i, "scenario", name);
        scenario->path = text_of(json_array_get(list, i), "key");
        archive->texts[i] = read_listed(archive, name, &size, why);
        if (archive->texts[i] == NULL)
            return -EINVAL;
        if (scenario->path == NULL)
            return refuse(why, "the manifest's scenarios are damaged");
        struct scenario *read;
        if (scenario_read(&read, archive->texts[i], size, scenario->path, catalogue, reason) != 0)
            return refuse(why, "%s", reason);
        scenario->scenario = read;
        scenario->text = archive->texts[i];
        archive->options.scenario_count++;
    }
    return 0;
}

/* The module lies there and is the one; where it is read from later. */
static int look_at_module(struct archive *archive, char why[CHECK_WHY])
{
    const char *name = archive_module_name(text_of(archive->manifest, "module"));
    size_t size;
    char *bytes = read_listed(archive, name, &size, why);
    if (bytes == NULL)
        return -EINVAL;
    free(bytes);
    snprintf(archive->module, sizeof archive->module, "%s/%s", archive->folder, name);
    return 0;
}

static int read_manifest(struct archive *archive, char why[CHECK_WHY])
{
    size_t size;
    json_error_t error;
    char *text = archive_read(archive->folder, ARCHIVE_MANIFEST, &size, why);
    if (text == NULL)
        return -EINVAL;
    sha256_text(text, size, archive->hash);
    archive->manifest = json_loadb(text, size, JSON_REJECT_DUPLICATES, &error);
    free(text);
    if (archive->manifest == NULL)
        return refuse(why, "'%s/%s' is no JSON: line %d: %s", archive->folder, ARCHIVE_MANIFEST,
                      error.line, error.text);
    const char *form = text_of(archive->manifest, "form");
    if (form == NULL || strcmp(form, ARCHIVE_FORM) != 0)
        return refuse(why, "'%s' is no evidence of the form %s", archive->folder, ARCHIVE_FORM);
    return 0;
}

int archive_open(struct archive **out, const char *folder, char why[CHECK_WHY])
{
    struct archive *archive = calloc(1, sizeof *archive);
    if (archive == NULL)
        return refuse(why, "no memory");
    int r = (size_t)snprintf(archive->folder, sizeof archive->folder, "%s", folder) <
                    sizeof archive->folder
                ? 0
                : refuse(why, "the name of the folder is too long");
    if (r == 0)
        r = read_manifest(archive, why);
    if (r == 0)
        r = look_at_module(archive, why);
    if (r == 0)
        r = read_options(archive, why);
    if (r == 0)
        r = read_scenarios(archive, why);
    if (r != 0) {
        archive_close(archive);
        return r;
    }
    *out = archive;
    return 0;
}

void archive_close(struct archive *archive)
{
    if (archive == NULL)
        return;
    for (size_t i = 0; i < ARCHIVE_SCENARIOS; i++) {
        scenario_close((struct scenario *)(uintptr_t)archive->scenarios[i].scenario);
        free(archive->texts[i]);
    }
    json_decref(archive->manifest);
    free(archive);
}

const struct check_options *archive_options(const struct archive *archive)
{
    return &archive->options;
}

const char *archive_hash(const struct archive *archive)
{
    return archive->hash;
}

/* Of Program_01 to 03, as archive_save.c writes them: 0 is the product's own, -1 off. */
static bool read_periods(const json_t *periods, struct host_config *host)
{
    bool good = json_array_size(periods) == 3;
    for (unsigned i = 0; i < 3 && good; i++) {
        const json_t *period = json_array_get(periods, i);
        const json_int_t us = json_integer_value(period);
        good = json_is_integer(period) && us >= -1 && us <= INT32_MAX &&
               (us <= 0 || product_allows_period(host->product, i, (uint32_t)us));
        host->program_period_us[i] = us < 0 ? PERIOD_OFF : (uint32_t)us;
    }
    return good;
}

/* What an experiment was made of, where it can differ from its row. */
static int read_conditions(const json_t *entry, struct experiment *experiment, char why[CHECK_WHY])
{
    const char *name = text_of(entry, "name");
    if (name == NULL || !json_is_integer(json_object_get(entry, "cycle_us")))
        return refuse(why, "the manifest's experiments are damaged");
    const json_int_t cycle_us = json_integer_value(json_object_get(entry, "cycle_us")),
                     cycles = json_integer_value(json_object_get(entry, "cycles")),
                     data = json_integer_value(json_object_get(entry, "data_bytes"));
    if (cycle_us < 0 || cycle_us > UINT32_MAX || cycles < 0 || data < 0 || data > DATA_MOST ||
        !product_allows_cycle(experiment->host.product, (uint32_t)cycle_us) ||
        !read_periods(json_object_get(entry, "periods_us"), &experiment->host))
        return refuse(why, "the manifest's experiment %s is none of this product", name);
    experiment->name = name;
    experiment->host.cycle_us = (uint32_t)cycle_us;
    experiment->cycles = (uint64_t)cycles;
    experiment->host.data_bytes = (uint32_t)data;
    return 0;
}

static int read_result(const struct archive *archive, const char *name,
                       struct experiment_result *result, char why[CHECK_WHY])
{
    size_t size;
    char reason[EVIDENCE_WHY];
    char *bytes = read_listed(archive, name, &size, why);
    if (bytes == NULL)
        return -EINVAL;
    const int r = evidence_decode(result, (const uint8_t *)bytes, size, reason);
    free(bytes);
    return r == 0 ? 0 : refuse(why, "'%s/%s': %s", archive->folder, name, reason);
}

static bool is_listed(const json_t *list, const char *name)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *entry = json_string_value(json_array_get(list, i));
        if (entry != NULL && strcmp(entry, name) == 0)
            return true;
    }
    return false;
}

static int fill_run(const struct archive *archive, struct case_run *run, char why[CHECK_WHY])
{
    const json_t *list = json_object_get(archive->manifest, "experiments");
    char name[128];
    run->plan.inapplicable =
        is_listed(json_object_get(archive->manifest, "inapplicable"), run->plan.row.name);
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *entry = json_array_get(list, i);
        const char *key = text_of(entry, "key");
        if (key == NULL || strcmp(key, run->plan.row.name) != 0)
            continue;
        snprintf(name, sizeof name, "%s.evidence", run->plan.row.name);
        int r = read_conditions(entry, &run->plan.experiment, why);
        if (r == 0)
            r = read_result(archive, name, &run->result, why);
        run->ran = r == 0;
        return r;
    }
    return 0;
}

int archive_fill(const struct archive *archive, struct check *check, uint64_t wanted,
                 char why[CHECK_WHY])
{
    const json_t *list = json_object_get(archive->manifest, "scenarios");
    int r = 0;
    for (int id = 0; id < EXPERIMENT_COUNT && r == 0; id++)
        if (experiment_in(wanted, id))
            r = fill_run(archive, &check->runs[id], why);
    check->scenarios = calloc(archive->options.scenario_count + 1, sizeof *check->scenarios);
    if (check->scenarios == NULL)
        return refuse(why, "no memory");
    for (size_t i = 0; i < archive->options.scenario_count && r == 0; i++) {
        struct case_scenario *played = &check->scenarios[i];
        char name[64];
        archive_scenario_name(i, "evidence", name);
        played->scenario = archive->scenarios[i].scenario;
        played->name = archive->scenarios[i].path;
        played->experiment.host.product = product_find(archive->options.profile->product);
        r = read_conditions(json_array_get(list, i), &played->experiment, why);
        if (r == 0)
            r = read_result(archive, name, &played->result, why);
        played->ran = r == 0;
    }
    return r;
}
