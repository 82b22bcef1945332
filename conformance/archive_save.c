/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/archive_parts.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/evidence_file.h"
#include "image/sha256.h"

struct saver {
    const char *folder;
    char *why;
    json_t *files; /* name -> size and hash */
};

static int failed(const struct saver *saver, const char *name, int error)
{
    snprintf(saver->why, CHECK_WHY, "cannot write '%s/%s': %s", saver->folder, name,
             strerror(-error));
    return error;
}

/* JSON is UTF-8. */
static int no_text(const struct saver *saver, const char *name)
{
    snprintf(saver->why, CHECK_WHY, "evidence cannot have the name '%s': it is not UTF-8", name);
    return -EINVAL;
}

static int in_folder(const struct saver *saver, const char *name, char path[ARCHIVE_PATH])
{
    return (size_t)snprintf(path, ARCHIVE_PATH, "%s/%s", saver->folder, name) < ARCHIVE_PATH
               ? 0
               : failed(saver, name, -ENAMETOOLONG);
}

static int write_file(const struct saver *saver, const char *name, const void *bytes, size_t size)
{
    char path[ARCHIVE_PATH];
    const int r = in_folder(saver, name, path);
    if (r != 0)
        return r;
    FILE *file = fopen(path, "wb");
    if (file == NULL)
        return failed(saver, name, -errno);
    const size_t written = fwrite(bytes, 1, size, file);
    const int closed = fclose(file);
    return written == size && closed == 0 ? 0 : failed(saver, name, -EIO);
}

/* Writes it and notes it in the manifest. */
static int add_file(const struct saver *saver, const char *name, const void *bytes, size_t size)
{
    char hash[ARCHIVE_HASH];
    const int r = write_file(saver, name, bytes, size);
    sha256_text(bytes, size, hash);
    if (r == 0)
        json_object_set_new(saver->files, name,
                            json_pack("{s:I, s:s}", "size", (json_int_t)size, "sha256", hash));
    return r;
}

static int add_result(const struct saver *saver, const char *name,
                      const struct experiment_result *result)
{
    uint8_t *bytes;
    size_t size;
    int r = evidence_encode(result, &bytes, &size);
    if (r != 0)
        return failed(saver, name, r);
    r = add_file(saver, name, bytes, size);
    free(bytes);
    return r;
}

/* What rules ask of the experiment itself. */
static json_t *conditions(const char *key, const struct experiment *experiment,
                          const struct evidence *evidence)
{
    const struct host_config *host = &experiment->host;
    return json_pack("{s:s, s:s, s:s, s:i, s:I, s:i, s:[i,i,i]}", "key", key, "name",
                     experiment->name, "machine",
                     evidence->instrumented ? "instrumented" : "native", "cycle_us",
                     (int)host->cycle_us, "cycles", (json_int_t)experiment->cycles, "data_bytes",
                     (int)host->data_bytes, "periods_us", (int)host->program_period_us[0],
                     (int)host->program_period_us[1], (int)host->program_period_us[2]);
}

static int save_experiments(const struct saver *saver, const struct check *check, json_t *manifest)
{
    json_t *ran = json_array(), *inapplicable = json_array();
    int r = 0;
    for (int id = 0; id < EXPERIMENT_COUNT && r == 0; id++) {
        const struct case_run *run = &check->runs[id];
        char name[128];
        if (run->plan.inapplicable)
            json_array_append_new(inapplicable, json_string(run->plan.row.name));
        if (!run->ran)
            continue;
        snprintf(name, sizeof name, "%s.evidence", run->plan.row.name);
        r = add_result(saver, name, &run->result);
        if (json_array_append_new(ran, conditions(run->plan.row.name, &run->plan.experiment,
                                                  &run->result.evidence)) != 0)
            r = no_text(saver, run->plan.row.name);
    }
    json_object_set_new(manifest, "experiments", ran);
    json_object_set_new(manifest, "inapplicable", inapplicable);
    return r;
}

static int save_scenarios(const struct saver *saver, const struct check *check,
                          const struct check_options *options, json_t *manifest)
{
    json_t *list = json_array();
    int r = 0;
    for (size_t i = 0; check->scenarios != NULL && i < options->scenario_count && r == 0; i++) {
        const struct case_scenario *played = &check->scenarios[i];
        const char *text = options->scenarios[i].text;
        char name[64];
        if (!played->ran || text == NULL)
            continue;
        archive_scenario_name(i, "scenario", name);
        r = add_file(saver, name, text, strlen(text));
        archive_scenario_name(i, "evidence", name);
        if (r == 0)
            r = add_result(saver, name, &played->result);
        if (r == 0 && json_array_append_new(list, conditions(played->name, &played->experiment,
                                                             &played->result.evidence)) != 0)
            r = no_text(saver, played->name);
    }
    json_object_set_new(manifest, "scenarios", list);
    return r;
}

static json_t *optional(const char *text)
{
    json_t *value = text != NULL ? json_string(text) : NULL;
    return value != NULL ? value : json_null();
}

static json_t *waivers_of(const struct waivers *waivers)
{
    json_t *list = json_array();
    for (size_t i = 0; waivers != NULL && i < waivers->count; i++) {
        const struct waiver *w = &waivers->list[i];
        json_array_append_new(list, json_pack("{s:s, s:s, s:s, s:s}", "rule", w->rule, "until",
                                              w->expiry, "by", w->owner, "reason", w->reason));
    }
    return list;
}

/* Everything that was asked for. */
static json_t *describe(const struct check *check, const struct check_options *options)
{
    char seed[24];
    const struct report *report = &check->report;
    json_t *manifest = json_object();
    snprintf(seed, sizeof seed, "0x%" PRIx64, options->seed);
    json_object_set_new(manifest, "form", json_string(ARCHIVE_FORM));
    json_object_set_new(manifest, "tool", json_string(options->tool));
    json_object_set_new(manifest, "module", optional(options->path));
    json_object_set_new(manifest, "shown", optional(options->shown));
    json_object_set_new(manifest, "sha256", json_string(report->sha256));
    json_object_set_new(manifest, "profile", json_string(options->profile->name));
    json_object_set_new(manifest, "seed", json_string(seed));
    json_object_set_new(manifest, "cycles", json_integer((json_int_t)options->cycles));
    json_object_set_new(manifest, "rules", optional(options->rules));
    json_object_set_new(manifest, "strict", json_boolean(options->strict));
    json_object_set_new(manifest, "instrumented", json_boolean(options->instrumented));
    json_object_set_new(manifest, "config", optional(options->around_path));
    json_object_set_new(manifest, "today", json_string(check->today));
    json_object_set_new(manifest, "waivers", waivers_of(options->waivers));
    json_object_set_new(manifest, "verdict", json_string(verdict_name(report->verdict)));
    return manifest;
}

/* Whether the manifest there is one of ours. */
static bool is_archive(const struct saver *saver)
{
    char path[ARCHIVE_PATH];
    if (in_folder(saver, ARCHIVE_MANIFEST, path) != 0)
        return false;
    json_t *manifest = json_load_file(path, JSON_REJECT_DUPLICATES, NULL);
    const char *form = json_string_value(json_object_get(manifest, "form"));
    const bool ours = form != NULL && strcmp(form, ARCHIVE_FORM) == 0;
    json_decref(manifest);
    return ours;
}

/* 1: nothing is in it, 0: something is, or negative errno. */
static int is_empty(const char *folder)
{
    DIR *stream = opendir(folder);
    int entries = 0;
    if (stream == NULL)
        return -errno;
    while (readdir(stream) != NULL)
        entries++;
    closedir(stream);
    return entries <= 2; /* itself and the one above */
}

int archive_prepare(const char *folder, char why[CHECK_WHY])
{
    const struct saver saver = { .folder = folder, .why = why };
    if (mkdir(folder, 0777) == 0)
        return 0;
    const int empty = errno == EEXIST ? is_empty(folder) : -errno;
    const int error = empty < 0                           ? empty
                      : access(folder, W_OK | X_OK) != 0  ? -errno
                      : empty == 0 && !is_archive(&saver) ? -ENOTEMPTY
                                                          : 0;
    if (error == -ENOTEMPTY)
        snprintf(why, CHECK_WHY,
                 "'%s' is not empty, and no evidence of tgm; name another folder for it", folder);
    else if (error != 0)
        snprintf(why, CHECK_WHY, "cannot make the folder '%s': %s", folder, strerror(-error));
    return error;
}

/* What an older archive had and this one may not have: whoever looks into the folder should find
 * nothing that is not in the manifest. The manifest goes first, what is left is no archive. */
static void remove_older(const struct saver *saver, const struct check *check)
{
    char name[128], path[ARCHIVE_PATH];
    static const char *const endings[] = { "scenario", "evidence" };
    if (in_folder(saver, ARCHIVE_MANIFEST, path) != 0 || unlink(path) != 0)
        return;
    for (size_t i = 0; i < ARCHIVE_MODULES; i++)
        if (in_folder(saver, archive_modules[i], path) == 0)
            unlink(path);
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        snprintf(name, sizeof name, "%s.evidence", check->runs[id].plan.row.name);
        if (in_folder(saver, name, path) == 0)
            unlink(path);
    }
    for (size_t i = 0; i < 2 * ARCHIVE_SCENARIOS; i++) {
        archive_scenario_name(i / 2, endings[i % 2], name);
        if (in_folder(saver, name, path) == 0)
            unlink(path);
    }
}

int archive_save(const struct check *check, const struct check_options *options, const char *folder,
                 char hash[ARCHIVE_HASH], char why[CHECK_WHY])
{
    struct saver saver = { .folder = folder, .why = why, .files = json_object() };
    json_t *manifest = describe(check, options);
    char *text = NULL;
    int r = json_is_string(json_object_get(manifest, "module")) ? archive_prepare(folder, why)
                                                                : no_text(&saver, options->path);
    if (r == 0)
        remove_older(&saver, check);
    if (r == 0)
        r = add_file(&saver, archive_module_name(options->path), check->image->bytes,
                     check->image->size);
    if (r == 0)
        r = save_experiments(&saver, check, manifest);
    if (r == 0)
        r = save_scenarios(&saver, check, options, manifest);
    json_object_set(manifest, "files", saver.files);
    if (r == 0 && (text = json_dumps(manifest, JSON_INDENT(2))) == NULL) {
        snprintf(why, CHECK_WHY, "the manifest cannot be written: a name in it is no text");
        r = -EINVAL;
    }
    if (r == 0) {
        sha256_text(text, strlen(text), hash);
        r = write_file(&saver, ARCHIVE_MANIFEST, text, strlen(text));
    }
    free(text);
    json_decref(saver.files);
    json_decref(manifest);
    return r;
}
