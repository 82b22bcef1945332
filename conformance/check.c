/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/check_parts.h"

#include <errno.h>
#include <fnmatch.h>
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
        if (options->rules == NULL || fnmatch(options->rules, rule_at(i)->id, 0) == 0) {
            without_scenario =
                rule_at(i)->experiments == ON_SCENARIOS && options->scenario_count == 0;
            if (!without_scenario)
                check->chosen[check->report.rule_count++] = rule_at(i);
        }
    if (check->report.rule_count == 0) {
        if (without_scenario)
            snprintf(why, CHECK_WHY, "the rule that matches '%s' needs --scenario FILE",
                     options->rules);
        else
            snprintf(why, CHECK_WHY, "no rule matches '%s'; `tgm rules` lists them",
                     options->rules);
        return -EINVAL;
    }
    return 0;
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

int check_run(struct check **out, const struct check_options *options, char why[CHECK_WHY])
{
    const double begin = check_seconds();
    struct check *check = calloc(1, sizeof *check);
    if (check == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    int r = choose_rules(check, options, why);
    if (r == 0)
        r = image_open(&check->image, options->path, why);
    if (r != 0)
        goto out;
    fill_report(check, options);
    struct planned plan[EXPERIMENT_COUNT];
    plan_experiments(options, plan);
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        check->runs[i].plan = plan[i];
    note_unrunnable(check, options->profile);
    uint64_t wanted = 0;
    for (size_t i = 0; i < check->report.rule_count; i++)
        wanted |= check->chosen[i]->experiments;
    check->groups[GROUP_FILE].seconds = check_seconds() - begin;
    r = check_run_experiments(check, options, wanted, why);
    if (r == 0 && (wanted & ON_SCENARIOS) != 0)
        r = check_run_scenarios(check, options, why);
    if (r != 0)
        goto out;
    note_cycles(check, options);
    const double judging = check_seconds();
    r = check_judge(check, options);
    if (r != 0)
        snprintf(why, CHECK_WHY, "no memory");
    check->groups[GROUP_FILE].seconds += check_seconds() - judging;
out:
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
    free(check);
}
