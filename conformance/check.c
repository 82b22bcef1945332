/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/archive.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

double check_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static int choose_rules(struct check *check, const struct check_options *options,
                        char why[CHECK_WHY])
{
    size_t all = 0;
    bool without_scenario = false;
    char idle[RULE_PATTERN];
    while (rule_at(all) != NULL)
        all++;
    check->rules = calloc(all, sizeof *check->rules);
    check->chosen = calloc(all, sizeof *check->chosen);
    check->findings = calloc(all, sizeof *check->findings);
    check->runs = calloc(EXPERIMENT_COUNT, sizeof *check->runs);
    if (check->rules == NULL || check->chosen == NULL || check->findings == NULL ||
        check->runs == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    for (size_t i = 0; i < all; i++)
        if (rule_selected(options->rules, rule_at(i)->id)) {
            without_scenario =
                rule_at(i)->experiments == ON_SCENARIOS && options->scenario_count == 0;
            if (!without_scenario)
                check->chosen[check->report.rule_count++] = rule_at(i);
        }
    if (rule_pattern_idle(options->rules, idle))
        snprintf(why, CHECK_WHY, "no rule matches '%s'; `tgm rules` lists them", idle);
    else if (check->report.rule_count > 0)
        return 0;
    else if (without_scenario)
        snprintf(why, CHECK_WHY, "the rule that matches '%s' needs --scenario FILE",
                 options->rules);
    else
        snprintf(why, CHECK_WHY, "'%s' leaves no rule to judge by", options->rules);
    return -EINVAL;
}

/* Why nothing of this file can be called, "" when it can. */
static void note_unrunnable(struct check *check, const struct profile *profile)
{
    const struct image *image = check->image;
    if (image->defect[0] != '\0' || !profile_loads(profile, image)) {
        snprintf(check->cannot_run, sizeof check->cannot_run,
                 "the file is not a module that this profile loads (rule file-format)");
        return;
    }
    if (image->format == IMAGE_FORMAT_FLAT)
        return; /* what it has is known when GetProcAddress has been called */
    for (const char *const *name = profile->exports; *name != NULL; name++) {
        const struct image_symbol *symbol = image_export(image, *name);
        if (symbol != NULL && symbol->executable)
            continue;
        snprintf(check->cannot_run, sizeof check->cannot_run,
                 "the module was not run: %s is not %s (rule %s)", *name,
                 symbol == NULL ? "exported" : "code",
                 symbol == NULL ? "export-names" : "export-code");
        return;
    }
}

static void fill_report(struct check *check, const struct check_options *options)
{
    const struct product *product = product_find(options->profile->product);
    struct report *report = &check->report;
    char *title = check->title;
    snprintf(title, sizeof check->title, "%s, ids %u/%u", product->title, product->compatibility_id,
             product->memory_id);
    report->tool = options->tool;
    report->path = options->shown != NULL ? options->shown : options->path;
    report->size = check->image->size;
    report->sha256 = check->image->sha256;
    report->format = check->image->format_name;
    report->target = check->image->target_name;
    report->profile = options->profile->name;
    report->profile_title = title;
    rule_book_hash(check->rule_book);
    report->rule_book = check->rule_book;
    report->seed = options->seed;
    report->selection = options->rules;
    report->strict = options->strict;
    report->instrumented = options->instrumented;
    report->config = options->around_path;
    report->cycles = options->cycles;
    report->rules = check->rules;
    report->groups = check->groups;
    report->group_count = GROUP_COUNT;
    for (int i = 0; i < GROUP_COUNT; i++)
        check->groups[i].name = rule_group_name((enum rule_group)i);
}

/* "250 / 500 / 1000 us, 10 s of machine time each": what the cycle group did. */
static void note_cycles(struct check *check, const struct check_options *options)
{
    char *note = check->groups[GROUP_CYCLE].note;
    const size_t size = sizeof check->groups[GROUP_CYCLE].note;
    size_t at = 0;
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        if (check->runs[i].ran && experiment_in(ON_CYCLES, i))
            at += (size_t)snprintf(note + at, size - at, "%s%u", at > 0 ? " / " : "",
                                   check->runs[i].plan.experiment.host.cycle_us);
    if (at == 0)
        return;
    if (options->cycles != 0)
        snprintf(note + at, size - at, " us, %" PRIu64 " cycles each", options->cycles);
    else
        snprintf(note + at, size - at, " us, %d s of machine time each", CHECK_SECONDS);
}

static void note_scenarios(struct check *check, const struct check_options *options)
{
    struct group_report *group = &check->groups[GROUP_MACHINE];
    uint64_t checks = 0;
    if (check->scenarios == NULL)
        return;
    for (size_t i = 0; i < options->scenario_count; i++)
        checks += check->scenarios[i].result.evidence.checked;
    snprintf(group->note, sizeof group->note, "%zu scenario%s, %" PRIu64 " checks",
             options->scenario_count, options->scenario_count == 1 ? "" : "s", checks);
}

static void note_today(struct check *check, const struct check_options *options)
{
    const time_t now = time(NULL);
    struct tm day;
    if (options->today != NULL)
        snprintf(check->today, sizeof check->today, "%.10s", options->today);
    else if (gmtime_r(&now, &day) != NULL)
        strftime(check->today, sizeof check->today, "%Y-%m-%d", &day);
}

/* Up to where experiments are run; *wanted: which. */
static int prepare(struct check *check, const struct check_options *options, uint64_t *wanted,
                   char why[CHECK_WHY])
{
    const double begin = check_seconds();
    struct planned plan[EXPERIMENT_COUNT];
    int r = choose_rules(check, options, why);
    if (r == 0)
        r = image_open(&check->image, options->path, why);
    if (r != 0)
        return r;
    note_today(check, options);
    fill_report(check, options);
    plan_experiments(options, plan);
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        check->runs[i].plan = plan[i];
    note_unrunnable(check, options->profile);
    *wanted = 0;
    for (size_t i = 0; i < check->report.rule_count; i++)
        *wanted |= check->chosen[i]->experiments;
    check->groups[GROUP_FILE].seconds = check_seconds() - begin;
    return 0;
}

/* From there on. */
static int conclude(struct check *check, const struct check_options *options, char why[CHECK_WHY])
{
    const double begin = check_seconds();
    note_cycles(check, options);
    note_scenarios(check, options);
    const int r = check_judge(check, options);
    if (r != 0)
        snprintf(why, CHECK_WHY, "no memory");
    check->groups[GROUP_FILE].seconds += check_seconds() - begin;
    return r;
}

static int run_and_judge(struct check *check, const struct check_options *options,
                         char why[CHECK_WHY])
{
    uint64_t wanted;
    int r = prepare(check, options, &wanted, why);
    /* Rather now than when everything has been run. */
    if (r == 0 && options->evidence != NULL)
        r = archive_prepare(options->evidence, why);
    if (r == 0)
        r = check_run_experiments(check, options, wanted, why);
    if (r == 0 && (wanted & ON_SCENARIOS) != 0)
        r = check_run_scenarios(check, options, why);
    if (r == 0)
        r = conclude(check, options, why);
    if (r == 0 && options->evidence != NULL)
        r = archive_save(check, options, options->evidence, check->hash, why);
    if (r == 0 && options->evidence != NULL)
        check->report.evidence = check->hash;
    return r;
}

int check_run(struct check **out, const struct check_options *options, char why[CHECK_WHY])
{
    struct check *check = calloc(1, sizeof *check);
    if (check == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    const int r = run_and_judge(check, options, why);
    if (r != 0) {
        check_free(check);
        return r;
    }
    *out = check;
    return 0;
}

static int judge_archive(struct check *check, const char *folder,
                         const struct check_changes *changes, char why[CHECK_WHY])
{
    uint64_t wanted;
    int r = archive_open(&check->archive, folder, why);
    if (r != 0)
        return r;
    check->sparing = changes->sparing;
    struct check_options options = *archive_options(check->archive);
    if (changes->rules != NULL)
        options.rules = changes->rules;
    options.strict = options.strict || changes->strict;
    if (changes->waivers != NULL) {
        options.waivers = changes->waivers;
        options.today = NULL;
    }
    r = prepare(check, &options, &wanted, why);
    if (r == 0)
        r = archive_fill(check->archive, check, changes->sparing ? wanted : UINT64_MAX, why);
    if (r != 0)
        return r;
    if (check->cannot_run[0] == '\0')
        snprintf(check->cannot_run, sizeof check->cannot_run,
                 "the saved evidence does not have what this rule needs");
    r = conclude(check, &options, why);
    snprintf(check->hash, sizeof check->hash, "%s", archive_hash(check->archive));
    check->report.evidence = check->hash;
    return r;
}

int check_again(struct check **out, const char *folder, const struct check_changes *changes,
                char why[CHECK_WHY])
{
    struct check *check = calloc(1, sizeof *check);
    if (check == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    const int r = judge_archive(check, folder, changes, why);
    if (r != 0) {
        check_free(check);
        return r;
    }
    *out = check;
    return 0;
}

const struct report *check_report(const struct check *check)
{
    return &check->report;
}

unsigned check_lacks(const struct check *check)
{
    unsigned lacks = 0;
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        if (check->runs[i].ran)
            lacks |= check->runs[i].result.worker.lacks;
    return lacks;
}

void check_free(struct check *check)
{
    if (check == NULL)
        return;
    if (check->image != NULL)
        image_close(check->image);
    chronicle_free(&check->chronicle);
    free(check->rules);
    free(check->chosen);
    free(check->findings);
    free(check->runs);
    free(check->scenarios);
    archive_close(check->archive);
    free(check);
}
