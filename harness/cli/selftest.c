/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The rule book proves itself on this machine. */
#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"
#include "conformance/selftest.h"

/* Beside the program: where it was built, and where it is installed. */
static bool find_fixtures(char folder[PATH_MAX])
{
    static const char *const places[] = { "/fixtures", "/../share/tgm/fixtures" };
    char program[PATH_MAX], candidate[PATH_MAX + 64];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0)
        return false;
    program[length] = '\0';
    *strrchr(program, '/') = '\0';
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        snprintf(candidate, sizeof candidate, "%s%s", program, places[i]);
        if (access(candidate, R_OK) == 0)
            return realpath(candidate, folder) != NULL;
    }
    return false;
}

static json_t *fixtures_json(const struct selftest *test, const struct rule *rule)
{
    json_t *list = json_array();
    for (size_t i = 0; i < test->count; i++) {
        const struct selftest_fixture *fixture = &test->fixtures[i];
        if (fixture->rule == rule)
            json_array_append_new(
                list, json_pack("{s:s, s:b, s:b, s:s, s:s, s:s}", "name", fixture->name, "bad",
                                fixture->bad, "right", fixture->right, "why", fixture->why,
                                "findings", fixture->findings != NULL ? fixture->findings : "",
                                "not_judged", fixture->reasons != NULL ? fixture->reasons : ""));
    }
    return list;
}

static bool is_right(const struct selftest *test)
{
    return test->wrong == 0 && test->unproven == 0;
}

static void print_json(const struct selftest *test, const char *selected)
{
    json_t *rules = json_array();
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        struct selftest_tally tally;
        if (!rule_selected(selected, rule_at(i)->id))
            continue;
        selftest_tally(test, rule_at(i), &tally);
        json_array_append_new(rules, json_pack("{s:s, s:s, s:b, s:o}", "id", rule_at(i)->id,
                                               "severity", severity_name(rule_at(i)->severity),
                                               "proven", selftest_proves(&tally), "fixtures",
                                               fixtures_json(test, rule_at(i))));
    }
    json_t *object = json_pack("{s:s, s:s, s:b, s:o}", "schema", "tgm-selftest/1", "tool",
                               "tgm " TGM_VERSION_TEXT, "right", is_right(test), "rules", rules);
    json_dumpf(object, stdout, JSON_INDENT(2));
    putchar('\n');
    json_decref(object);
}

/* A line a rule: how many of its fixtures did what they should, of how many. */
static void print_matrix(const struct selftest *test, const char *rules)
{
    printf("  %-26s %-6s %9s %9s\n", "rule", "", "bad", "good");
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        struct selftest_tally t;
        char bad[32], good[32];
        if (!rule_selected(rules, rule_at(i)->id))
            continue;
        selftest_tally(test, rule_at(i), &t);
        snprintf(bad, sizeof bad, "%zu/%zu", t.bad_right, t.bad);
        snprintf(good, sizeof good, "%zu/%zu", t.good_right, t.good);
        printf("  %-26s %-6s %9s %9s%s\n", rule_at(i)->id, severity_name(rule_at(i)->severity), bad,
               good, selftest_proves(&t) ? "" : "   NOT PROVEN");
    }
}

static void print_text(const struct selftest *test, const char *rules)
{
    for (size_t i = 0; i < test->count; i++)
        if (test->fixtures[i].tried && !test->fixtures[i].right)
            printf("WRONG  %s/%s\n       %s\n", test->fixtures[i].rule->id, test->fixtures[i].name,
                   test->fixtures[i].why);
    print_matrix(test, rules);
    printf("\nRESULT: %s (%zu rules, %zu of them not proven; %zu fixtures, %zu wrong)\n",
           is_right(test) ? "PASS" : "FAIL", test->rules, test->unproven, test->count, test->wrong);
}

int command_selftest(const struct command *command, int argc, char **argv)
{
    static char found[PATH_MAX];
    struct selftest_options options = { .folder = NULL };
    struct selftest test;
    char why[SELFTEST_WHY];
    uint64_t jobs = 0;
    bool json = false;
    struct option_texts patterns = { .count = 0 };
    static char selection[PATTERNS_MAX];
    const struct option table[] = {
        { "--rule", OPTION_TEXTS, "PATTERN",
          "only the rules whose id matches, as in 'ini-*'; '!PATTERN': not those; may be given "
          "again",
          &patterns, 0, 0 },
        { "--fixtures", OPTION_TEXT, "DIR", "where the modules are (default: beside the program)",
          &options.folder, 0, 0 },
        { "--jobs", OPTION_NUMBER, "N", "modules at the same time (default: one for each core)",
          &jobs, 1, 64 },
        { "--own", OPTION_FLAG, NULL,
          "judge each module by its own rule alone: quick, but that no other trips is not shown",
          &options.first_only, 0, 0 },
        { "--by", OPTION_TEXT, "PATTERN", "judge every module by these rules alone",
          &options.judges, 0, 0 },
        { "--evidence", OPTION_TEXT, "DIR", "keep what the modules did", &options.evidence, 0, 0 },
        { "--from-evidence", OPTION_TEXT, "DIR", "judge what was kept there; run nothing",
          &options.from_evidence, 0, 0 },
        { "--first", OPTION_FLAG, NULL, "end at the first module that is not judged as it should",
          &options.first_wrong, 0, 0 },
        { "--json", OPTION_FLAG, NULL, "as JSON (docs/json.md)", &json, 0, 0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, NULL, 0, &words, &status))
        return status;
    if (!patterns_join(command, &patterns, selection, &options.rules))
        return EXIT_CALL;
    if (options.folder == NULL && find_fixtures(found))
        options.folder = found;
    if (options.folder == NULL)
        return complain(command, "there are no fixtures beside the program; --fixtures DIR");
    options.jobs = (unsigned)jobs;
    if (selftest_run(&test, &options, why) != 0)
        return complain(command, "%s", why);
    if (json)
        print_json(&test, options.rules);
    else
        print_text(&test, options.rules);
    status = is_right(&test) ? EXIT_OK : EXIT_MODULE;
    selftest_free(&test);
    return status;
}
