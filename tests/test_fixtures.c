/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Every rule proves itself: each of its bad modules trips exactly that rule, its good twin none.
 * The fixtures are found by folder: a rule without both is a failure.
 */
#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conformance/check.h"

/* Enough for every fixture's deed (in cycle 20 at the latest), short enough to run them all. */
#define CYCLES 60

/* A fixture is judged by the profile of its format; pc4 says of everything else that it loads none.
 */
static const struct profile *profile_of(const char *path)
{
    const struct profile *profile = NULL;
    struct image *image;
    char why[IMAGE_WHY];
    if (image_open(&image, path, why) != 0)
        fail_msg("%s", why);
    profile = profile_of_image(image);
    image_close(image);
    return profile != NULL ? profile : profile_find("pc4");
}

static struct check *checked(const char *path, const struct check_scenario *scenario)
{
    struct check *check;
    char why[CHECK_WHY];
    const struct check_options options = {
        .path = path,
        .tool = "test",
        .profile = profile_of(path),
        .seed = 1,
        .cycles = CYCLES,
        .scenarios = scenario,
        .scenario_count = scenario->scenario != NULL,
    };
    if (check_run(&check, &options, why) != 0)
        fail_msg("%s: %s", path, why);
    return check;
}

/* The folder's machine.scenario; a rule without one is judged without. */
static struct check_scenario scenario_of(const char *id, char path[512])
{
    struct scenario *scenario = NULL;
    char why[SCENARIO_WHY], text[4096];
    snprintf(path, 512, "conformance/fixtures/%s/machine.scenario", id);
    FILE *file = fopen(path, "r");
    if (file != NULL) {
        const size_t size = fread(text, 1, sizeof text, file);
        fclose(file);
        if (scenario_read(&scenario, text, size, path, catalogue_find(4, 0), why) != 0)
            fail_msg("%s", why);
    }
    return (struct check_scenario){ .scenario = scenario, .path = path };
}

static void print_findings(const struct report *report)
{
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        for (size_t k = 0; k < rule->finding_count; k++)
            print_message("    %s: %s %s %s\n", rule->id, rule->findings[k].what,
                          rule->findings[k].when, rule->findings[k].place);
        if (rule->outcome == RULE_NOT_JUDGED)
            print_message("    %s: not judged: %s\n", rule->id, rule->reason);
    }
}

static void judge_bad(const char *path, const char *id, const struct check_scenario *scenario)
{
    struct check *check = checked(path, scenario);
    const struct report *report = check_report(check);
    const bool fails = rule_find(id)->severity == SEVERITY_MUST;
    /* Rules that only warn leave a verdict of PASS, or INCOMPLETE where the module cannot be run.
     */
    bool right = (report->verdict == VERDICT_FAIL) == fails;
    for (size_t i = 0; i < report->rule_count; i++)
        right = right &&
                (report->rules[i].outcome == RULE_FAILED) == (strcmp(report->rules[i].id, id) == 0);
    if (!right) {
        print_findings(report);
        fail_msg("%s must trip %s and nothing else", path, id);
    }
    check_free(check);
}

static void judge_good(const char *path, const struct check_scenario *scenario)
{
    struct check *check = checked(path, scenario);
    const struct report *report = check_report(check);
    if (report->verdict != VERDICT_PASS || report->failed + report->not_judged != 0) {
        print_findings(report);
        fail_msg("%s must pass", path);
    }
    check_free(check);
}

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), size = strlen(end);
    return length >= size && strcmp(text + length - size, end) == 0;
}

static void a_bad_fixture_trips_exactly_its_rule_and_the_good_one_none(void **state)
{
    const struct rule *rule = *state;
    char folder[512], path[1024], file[512];
    const struct check_scenario scenario = scenario_of(rule->id, file);
    unsigned bad = 0, good = 0;
    snprintf(folder, sizeof folder, "%s/%s", FIXTURE_DIR, rule->id);
    DIR *dir = opendir(folder);
    if (dir == NULL)
        fail_msg("rule %s has no fixtures", rule->id);
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
        if (!ends_with(entry->d_name, ".tgm") && !ends_with(entry->d_name, ".tgm.bin"))
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (strncmp(entry->d_name, "bad", 3) == 0) {
            judge_bad(path, rule->id, &scenario);
            bad++;
        } else {
            judge_good(path, &scenario);
            good++;
        }
    }
    closedir(dir);
    scenario_close((struct scenario *)(uintptr_t)scenario.scenario);
    assert_true(bad >= 1);
    assert_true(good >= 1);
}

int main(void)
{
    struct CMUnitTest tests[128];
    size_t count = 0;
    memset(tests, 0, sizeof tests);
    for (; rule_at(count) != NULL && count < 128; count++) {
        tests[count].name = rule_at(count)->id;
        tests[count].test_func = a_bad_fixture_trips_exactly_its_rule_and_the_good_one_none;
        tests[count].initial_state = (void *)(uintptr_t)rule_at(count);
    }
    return _cmocka_run_group_tests("fixtures", tests, count, NULL, NULL);
}
