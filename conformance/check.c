/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/check.h"

#include <errno.h>
#include <fnmatch.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct check {
    struct image *image;
    struct report report;
    struct rule_report *rules;
    const struct rule **chosen; /* by index of report.rules */
    struct findings *findings;  /* by index of report.rules */
    struct group_report groups[GROUP_COUNT];
    struct experiment experiments[EXPERIMENT_COUNT];
    struct experiment_result results[EXPERIMENT_COUNT];
    bool ran[EXPERIMENT_COUNT];
    bool inapplicable[EXPERIMENT_COUNT];
    struct case_scenario *scenarios;
    char title[96];
    char cannot_run[FINDING_TEXT];
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Under a configuration there is one Cycle_Time, and one of the cycle experiments has it. */
static void one_cycle_only(struct check *check, int i)
{
    check->inapplicable[i] = i != EXPERIMENT_CYCLE_500;
    check->experiments[i].name = "cycle";
}

static void plan_experiments(struct check *check, const struct check_options *options)
{
    enum { ANY, ONLY_4 };
    const struct product *product = product_find(options->profile->product);
    const struct {
        const char *name;
        struct mutation mutation;
        uint32_t cycle_us;
        int generations;
    } rows[EXPERIMENT_COUNT] = {
#define EXPERIMENT(symbol, name, kind, value, cycle_us, generations)                               \
    { name, { kind, value }, cycle_us, generations },
#include "conformance/experiments.def"
#undef EXPERIMENT
    };
    for (int i = 0; i < EXPERIMENT_COUNT; i++) {
        struct experiment *e = &check->experiments[i];
        const uint32_t cycle_us = rows[i].cycle_us;
        check->inapplicable[i] = rows[i].generations == ONLY_4 && product->generation != 4;
        e->name = rows[i].name;
        e->host = (struct host_config){ .plant = &plant_default };
        if (options->around != NULL)
            e->host = *options->around;
        e->host.product = product;
        if (options->around == NULL)
            e->host.cycle_us = cycle_us != 0 ? cycle_us : product->default_cycle_us;
        else if (cycle_us != 0)
            one_cycle_only(check, i);
        e->host.seed = options->seed;
        /* What a bus file announces is known when the bus is there. */
        e->host.without_bus = cycle_us == 0 && !e->host.plant->as_found;
        e->host.mutation = rows[i].mutation;
        if (cycle_us != 0)
            e->cycles = options->cycles != 0 ? options->cycles
                                             : CHECK_SECONDS * UINT64_C(1000000) / e->host.cycle_us;
    }
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
    if (check->rules == NULL || check->chosen == NULL || check->findings == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    for (size_t i = 0; i < all; i++)
        if (options->rules == NULL || fnmatch(options->rules, rule_at(i)->id, 0) == 0) {
            without_scenario = rule_at(i)->experiments == ON_SCENARIOS &&
                               options->scenario_count == 0;
            if (!without_scenario)
                check->chosen[check->report.rule_count++] = rule_at(i);
        }
    if (check->report.rule_count == 0) {
        if (without_scenario)
            snprintf(why, CHECK_WHY, "the rule that matches '%s' needs --scenario FILE",
                     options->rules);
        else
            snprintf(why, CHECK_WHY, "no rule matches '%s'; `tgm rules` lists them", options->rules);
        return -EINVAL;
    }
    return 0;
}

/* Why nothing of this file can be called, "" when it can. */
static void note_unrunnable(struct check *check, const struct profile *profile)
{
    const struct image *image = check->image;
    if (image->defect[0] != '\0' || image->format != profile->format ||
        image->target != profile->target) {
        snprintf(check->cannot_run, sizeof check->cannot_run,
                 "the file is not a module that this profile loads (rule file-format)");
        return;
    }
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

static int run_experiments(struct check *check, const struct check_options *options,
                           unsigned wanted, char why[CHECK_WHY])
{
    if (check->cannot_run[0] != '\0')
        return 0;
    for (int i = 0; i < EXPERIMENT_COUNT; i++) {
        if ((wanted & (1u << i)) == 0 || check->inapplicable[i])
            continue;
        const double begin = seconds();
        struct host_config *around = &check->experiments[i].host;
        if (options->capture != NULL && !around->without_bus)
            around->capture =
                options->capture(options->capture_argument, check->experiments[i].name);
        int r = experiment_run(&check->experiments[i], check->image, NULL, NULL, NULL,
                               &check->results[i]);
        if (r != 0) {
            snprintf(why, CHECK_WHY, "experiment %s: no worker process: %s",
                     check->experiments[i].name, strerror(-r));
            return r;
        }
        check->ran[i] = true;
        check->groups[check->experiments[i].cycles > 0 ? GROUP_CYCLE : GROUP_START].seconds +=
            seconds() - begin;
    }
    return 0;
}

/* A run that could not begin because of the scenario is a wrong call. */
static int run_scenario(struct check *check, const struct check_options *options, size_t index,
                        char why[CHECK_WHY])
{
    struct case_scenario *played = &check->scenarios[index];
    const struct product *product = product_find(options->profile->product);
    char name[40];
    snprintf(name, sizeof name, "scenario-%zu", index + 1);
    played->scenario = options->scenarios[index].scenario;
    played->name = options->scenarios[index].path;
    struct host_config around = { .plant = &plant_default, .cycle_us = product->default_cycle_us };
    if (options->around != NULL)
        around = *options->around;
    around.product = product;
    around.seed = options->seed;
    around.scenario = played->scenario;
    if (options->capture != NULL)
        around.capture = options->capture(options->capture_argument, name);
    played->experiment =
        (struct experiment){ .name = "scenario",
                             .host = around,
                             .cycles = scenario_cycles(played->scenario, around.cycle_us),
                             .until_played = true };
    int r = experiment_run(&played->experiment, check->image, NULL, NULL, NULL, &played->result);
    if (r != 0) {
        snprintf(why, CHECK_WHY, "%s: no worker process: %s", played->name, strerror(-r));
        return r;
    }
    played->ran = true;
    if (played->result.evidence.play == PLAY_NONE && played->result.evidence.trouble[0] != '\0') {
        snprintf(why, CHECK_WHY, "%s", played->result.evidence.trouble);
        return -EINVAL;
    }
    return 0;
}

static int run_scenarios(struct check *check, const struct check_options *options,
                         char why[CHECK_WHY])
{
    const double begin = seconds();
    uint64_t checks = 0;
    check->scenarios = calloc(options->scenario_count, sizeof *check->scenarios);
    if (check->scenarios == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    for (size_t i = 0; i < options->scenario_count && check->cannot_run[0] == '\0'; i++) {
        int r = run_scenario(check, options, i, why);
        if (r != 0)
            return r;
        checks += check->scenarios[i].result.evidence.checked;
    }
    struct group_report *group = &check->groups[GROUP_MACHINE];
    group->seconds = seconds() - begin;
    snprintf(group->note, sizeof group->note, "%zu scenario%s, %" PRIu64 " checks",
             options->scenario_count, options->scenario_count == 1 ? "" : "s", checks);
    return 0;
}

/* A file name as a shell takes it. */
static void shell_word(const char *text, char *out, size_t size)
{
    static const char harmless[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+=:,@%";
    if (text[0] != '\0' && text[strspn(text, harmless)] == '\0') {
        snprintf(out, size, "%s", text);
        return;
    }
    size_t at = 0;
    out[at++] = '\'';
    for (; *text != '\0' && at + 6 < size; text++)
        if (*text == '\'')
            at += (size_t)snprintf(out + at, size - at, "'\\''");
        else
            out[at++] = *text;
    out[at++] = '\'';
    out[at] = '\0';
}

/* All of them, or no line: half of it would be another call. */
static void add_scenarios(const struct check_options *options, struct finding *finding, size_t at)
{
    char path[FINDING_TEXT];
    for (size_t i = 0; i < options->scenario_count; i++) {
        const char *given = options->scenarios[i].path;
        shell_word(given, path, sizeof path);
        if (strlen(given) * 4 + 8 > sizeof path ||
            at + strlen(path) + 12 >= sizeof finding->again) {
            finding->again[0] = '\0';
            return;
        }
        at += (size_t)snprintf(finding->again + at, sizeof finding->again - at, " --scenario %s",
                               path);
    }
}

static void add_reproduction(const struct check_options *options, const struct rule *rule,
                             struct finding *finding)
{
    char path[FINDING_TEXT / 2];
    if (rule->experiments == NO_EXPERIMENT)
        return;
    char dashed[FINDING_TEXT / 2];
    if (strlen(options->path) * 4 + 8 > sizeof path)
        return; /* a path that does not fit would name another file */
    snprintf(dashed, sizeof dashed, "%s%s", options->path[0] == '-' ? "./" : "", options->path);
    shell_word(dashed, path, sizeof path);
    int at = snprintf(finding->again, sizeof finding->again,
                      "tgm check %s --rule %s --seed 0x%" PRIx64, path, rule->id, options->seed);
    if (strcmp(options->profile->name, "pc4") != 0 && at < FINDING_TEXT)
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --profile %s",
                       options->profile->name);
    if (options->around_path != NULL && at < FINDING_TEXT) {
        if (strlen(options->around_path) * 4 + 8 > sizeof path) {
            finding->again[0] = '\0';
            return;
        }
        shell_word(options->around_path, path, sizeof path);
        at += snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --config %s", path);
    }
    if (rule->experiments == ON_SCENARIOS) {
        add_scenarios(options, finding, (size_t)at);
        return;
    }
    if (finding->has_cycle && at < FINDING_TEXT)
        snprintf(finding->again + at, (size_t)(FINDING_TEXT - at), " --cycles %" PRIu64,
                 finding->cycle + 1);
}

static void judge_rule(struct check *check, const struct check_options *options,
                       const struct case_file *file, size_t index)
{
    const struct rule *rule = check->chosen[index];
    struct findings *findings = &check->findings[index];
    struct rule_report *out = &check->rules[index];
    rule->check(file, findings);
    *out = (struct rule_report){
        .id = rule->id,
        .group = rule_group_name(rule->group),
        .clause = rule->clause,
        .title = rule->title,
        .advice = rule->advice,
        .severity = rule->severity,
        .outcome = findings->count > 0           ? RULE_FAILED
                   : findings->reason[0] != '\0' ? RULE_NOT_JUDGED
                                                 : RULE_PASSED,
        .findings = findings->list,
        .finding_count = findings->count,
        .dropped = findings->dropped,
    };
    memcpy(out->reason, findings->reason, sizeof out->reason);
    for (size_t i = 0; i < findings->count; i++)
        add_reproduction(options, rule, &findings->list[i]);
}

static void judge(struct check *check, const struct check_options *options)
{
    struct report *report = &check->report;
    const char *shown = options->shown != NULL ? options->shown : options->path;
    const char *slash = strrchr(shown, '/');
    const struct case_file file = {
        .image = check->image,
        .profile = options->profile,
        .name = slash != NULL ? slash + 1 : shown,
        .experiments = check->experiments,
        .results = check->results,
        .ran = check->ran,
        .inapplicable = check->inapplicable,
        .scenarios = check->scenarios,
        .scenario_count = options->scenario_count,
        .cannot_run = check->cannot_run,
    };
    for (size_t i = 0; i < report->rule_count; i++) {
        judge_rule(check, options, &file, i);
        const enum rule_outcome outcome = check->rules[i].outcome;
        const bool counts = check->rules[i].severity == SEVERITY_MUST;
        report->passed += outcome == RULE_PASSED;
        report->failed += outcome == RULE_FAILED;
        report->not_judged += outcome == RULE_NOT_JUDGED;
        if (outcome == RULE_FAILED && counts)
            report->verdict = VERDICT_FAIL;
        if (outcome == RULE_NOT_JUDGED && counts && report->verdict != VERDICT_FAIL)
            report->verdict = VERDICT_INCOMPLETE;
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
        if (check->ran[i] && check->experiments[i].cycles > 0)
            at += (size_t)snprintf(note + at, size - at, "%s%u", at > 0 ? " / " : "",
                                   check->experiments[i].host.cycle_us);
    if (at == 0)
        return;
    if (options->cycles != 0)
        snprintf(note + at, size - at, " us, %" PRIu64 " cycles each", options->cycles);
    else
        snprintf(note + at, size - at, " us, %d s of machine time each", CHECK_SECONDS);
}

int check_run(struct check **out, const struct check_options *options, char why[CHECK_WHY])
{
    const double begin = seconds();
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
    plan_experiments(check, options);
    note_unrunnable(check, options->profile);
    unsigned wanted = 0;
    for (size_t i = 0; i < check->report.rule_count; i++)
        wanted |= check->chosen[i]->experiments;
    check->groups[GROUP_FILE].seconds = seconds() - begin;
    r = run_experiments(check, options, wanted, why);
    if (r == 0 && (wanted & ON_SCENARIOS) != 0)
        r = run_scenarios(check, options, why);
    if (r != 0)
        goto out;
    note_cycles(check, options);
    const double judging = seconds();
    judge(check, options);
    check->groups[GROUP_FILE].seconds += seconds() - judging;
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
    free(check->rules);
    free(check->chosen);
    free(check->findings);
    free(check->scenarios);
    free(check);
}
