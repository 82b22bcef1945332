/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Any bytes as the manifest of saved evidence. The other files of the folder are always the same,
 * so that a manifest can list them with their right sizes and hashes; what they hold has a fuzzer
 * of its own. What is opened fills a check, and has what a report is made of.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/archive_parts.h"
#include "fuzz_json.h"
#include "host/evidence_file.h"

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const uint8_t *manifest;
static size_t manifest_size;
static unsigned long long inputs, opened, filled, runs, scenarios;

static const char *const names[EXPERIMENT_COUNT] = {
#define EXPERIMENT(symbol, name, ...) name,
#include "conformance/experiments.def"
#undef EXPERIMENT
};

static void must(bool holds)
{
    if (!holds)
        abort();
}

/* --- what stands in for the folder, for evidence, for the rule book --------------------------- */

/* Every second scenario is none; what evidence is called begins with what it is worth. */
static const char *content_of(const char *name)
{
    if (strncmp(name, "module", strlen("module")) == 0)
        return "module";
    if (strstr(name, ".scenario") != NULL)
        return strchr(name, '2') == NULL ? "expect 1\n" : "expect\n";
    return strncmp(name, "null", 4) == 0 ? "damaged evidence" : "evidence";
}

char *archive_read(const char *folder, const char *name, size_t *size, char why[CHECK_WHY])
{
    const bool is_manifest = strcmp(name, ARCHIVE_MANIFEST) == 0;
    const void *from = is_manifest ? (const void *)manifest : content_of(name);
    *size = is_manifest ? manifest_size : strlen(from);
    must(strcmp(folder, "folder") == 0 && strchr(name, '/') == NULL);
    char *bytes = malloc(*size + 1);
    if (bytes == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return NULL;
    }
    memcpy(bytes, from, *size);
    bytes[*size] = '\0';
    return bytes;
}

int evidence_decode(struct experiment_result *result, const uint8_t *bytes, size_t size,
                    char why[EVIDENCE_WHY])
{
    result->worker.value = 1;
    must(size > 0);
    if (bytes[0] == 'e')
        return 0;
    snprintf(why, EVIDENCE_WHY, "damaged");
    return -EINVAL;
}

const struct rule *rule_find(const char *id)
{
    static const struct rule any = { .id = "any" };
    return id[0] == 'r' ? &any : NULL;
}

/* --- inputs ----------------------------------------------------------------------------------- */

static bool is_line(const char *text, size_t size)
{
    return memchr(text, '\0', size) != NULL;
}

/* The line that shows a finding again has what the manifest says in it. */
static void reproduce(const struct check_options *options)
{
    static const struct rule rules[] = { { .id = "a", .experiments = 1 },
                                         { .id = "b", .experiments = ON_SCENARIOS } };
    static const struct image image = { .target = IMAGE_TARGET_X86_64,
                                        .format = IMAGE_FORMAT_ELF64 };
    for (int i = 0; i < 2; i++) {
        struct finding finding = { .plain_us = 500, .has_cycle = i == 0, .cycle = 7 };
        check_add_reproduction(options, &image, &rules[i], &finding);
        must(is_line(finding.again, sizeof finding.again));
        must(is_line(finding.debug, sizeof finding.debug));
    }
}

static void look_at_options(const struct check_options *o, const char *hash)
{
    must(strlen(hash) == ARCHIVE_HASH - 1);
    must(o->tool != NULL && o->shown != NULL && o->profile != NULL && o->today != NULL);
    must(o->path != NULL && o->again_path != NULL && o->cycles <= INT64_MAX);
    must(o->waivers == NULL || (o->waivers->count > 0 && o->waivers->count <= WAIVERS_MOST));
    for (size_t i = 0; i < o->scenario_count; i++)
        must(o->scenarios[i].scenario != NULL && o->scenarios[i].path != NULL &&
             o->scenarios[i].text != NULL);
    reproduce(o);
}

static void look_at_experiment(const struct experiment *e)
{
    must(e->name != NULL && e->cycles <= INT64_MAX && e->host.data_bytes <= DATA_MOST);
    must(product_allows_cycle(e->host.product, e->host.cycle_us));
}

static void fill(const struct archive *archive)
{
    static struct case_run cases[EXPERIMENT_COUNT];
    static struct check check;
    char why[CHECK_WHY] = "";
    const struct check_options *options = archive_options(archive);
    check.runs = cases;
    check.scenarios = NULL;
    for (int i = 0; i < EXPERIMENT_COUNT; i++) {
        cases[i].ran = false;
        cases[i].plan.row.name = names[i];
        cases[i].plan.experiment.host.product = product_find(options->profile->product);
    }
    const int r = archive_fill(archive, &check, UINT64_MAX, why);
    must((r == 0) == (why[0] == '\0'));
    filled += r == 0;
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        if (cases[i].ran) {
            look_at_experiment(&cases[i].plan.experiment);
            runs++;
        }
    for (size_t i = 0; check.scenarios != NULL && i < options->scenario_count; i++)
        if (check.scenarios[i].ran) {
            look_at_experiment(&check.scenarios[i].experiment);
            must(check.scenarios[i].scenario != NULL && check.scenarios[i].name != NULL);
            scenarios++;
        }
    free(check.scenarios);
}

static void say_what_was_seen(void)
{
    fprintf(stderr,
            "%llu inputs: %llu manifests, %llu with all they list, %llu runs, %llu scenarios\n",
            inputs, opened, filled, runs, scenarios);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    (void)argument_count;
    (void)arguments;
    return atexit(say_what_was_seen);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct archive *archive;
    char why[CHECK_WHY] = "";
    manifest = data;
    manifest_size = size;
    inputs++;
    const int r = archive_open(&archive, "folder", why);
    must((r == 0) == (why[0] == '\0') && is_line(why, sizeof why));
    if (r != 0)
        return 0;
    opened++;
    look_at_options(archive_options(archive), archive_hash(archive));
    fill(archive);
    archive_close(archive);
    return 0;
}
