/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/selftest.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "conformance/check.h"
#include "conformance/expected.h"

#define JOBS_MOST 64
#define TEXT_MOST ((size_t)256 << 10) /* of a file of a rule's folder */

/* Enough for what every fixture does, short enough for all of them. */
enum { CYCLES = 60, SEED = 1 };

struct pool {
    const struct selftest_options *options;
    struct selftest *test;
    atomic_size_t next;
    atomic_bool over;
};

static bool ends_with(const char *text, const char *end)
{
    const size_t length = strlen(text), size = strlen(end);
    return length >= size && strcmp(text + length - size, end) == 0;
}

static int by_name(const void *a, const void *b)
{
    const struct selftest_fixture *one = a, *other = b;
    return strcmp(one->name, other->name);
}

static int add(struct selftest *test, const struct rule *rule, const char *folder, const char *name)
{
    struct selftest_fixture *more = realloc(test->fixtures, (test->count + 1) * sizeof *more);
    if (more == NULL)
        return -ENOMEM;
    test->fixtures = more;
    struct selftest_fixture *fixture = &test->fixtures[test->count++];
    memset(fixture, 0, sizeof *fixture);
    fixture->rule = rule;
    fixture->bad = strncmp(name, "bad", 3) == 0;
    snprintf(fixture->name, sizeof fixture->name, "%s", name);
    snprintf(fixture->path, sizeof fixture->path, "%s/%s", folder, name);
    return 0;
}

static int find_fixtures(struct selftest *test, const struct rule *rule, const char *folder)
{
    char path[768];
    const size_t first = test->count;
    int r = 0;
    snprintf(path, sizeof path, "%s/%s", folder, rule->id);
    DIR *dir = opendir(path);
    if (dir == NULL)
        return 0; /* it is not proven, then */
    for (struct dirent *entry; r == 0 && (entry = readdir(dir)) != NULL;)
        if (ends_with(entry->d_name, ".tgm") || ends_with(entry->d_name, ".tgm.bin"))
            r = add(test, rule, path, entry->d_name);
    closedir(dir);
    if (test->count > first)
        qsort(test->fixtures + first, test->count - first, sizeof *test->fixtures, by_name);
    return r;
}

/* A small file, to be freed; NULL when there is none. */
static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = file != NULL ? calloc(1, TEXT_MOST + 1) : NULL;
    if (text != NULL)
        text[fread(text, 1, TEXT_MOST, file)] = '\0';
    if (file != NULL)
        fclose(file);
    return text;
}

/* The fixture's own scenario, else the rule's, else none: NULL. */
struct played {
    struct scenario *scenario;
    char path[1024], *text;
};

/* False when it cannot be read. */
static bool read_scenario(const struct pool *pool, const struct selftest_fixture *fixture,
                          struct played *played, char why[SCENARIO_WHY])
{
    const char *const names[] = { fixture->name, "machine." };
    played->scenario = NULL;
    played->text = NULL;
    for (size_t i = 0; i < 2 && played->text == NULL; i++) {
        snprintf(played->path, sizeof played->path, "%s/%s/%.*s.scenario", pool->options->folder,
                 fixture->rule->id, (int)strcspn(names[i], "."), names[i]);
        played->text = read_text(played->path);
    }
    if (played->text == NULL || scenario_read(&played->scenario, played->text, strlen(played->text),
                                              played->path, catalogue_find(4, 0), why) == 0)
        return true;
    free(played->text);
    return false;
}

/* The profile that loads such a file; of what no profile loads, pc4 says so. */
static const struct profile *profile_for(const char *path)
{
    char why[IMAGE_WHY];
    struct image *image;
    if (image_open(&image, path, why) != 0)
        return profile_find("pc4");
    const struct profile *profile = profile_of_image(image);
    image_close(image);
    return profile != NULL ? profile : profile_find("pc4");
}

static void say(struct selftest_fixture *fixture, const char *what, const char *id,
                const char *more)
{
    const size_t at = strlen(fixture->why);
    snprintf(fixture->why + at, sizeof fixture->why - at, "%s%s%s%.160s", at > 0 ? "; " : "", what,
             id, more);
}

/* Where a finding is: "at (Program_04) bad.c:7", as the address depends on the compiler. */
static const char *place_of(const struct finding *finding)
{
    const char *mark = finding->has_address ? strstr(finding->place, "+0x") : NULL;
    return mark != NULL ? mark + 3 + strspn(mark + 3, "0123456789abcdef") : finding->place;
}

/* How it is shown again, as far as it does not depend on where the module lies. */
static void keep_reproduction(FILE *out, const struct finding *f, const char *rule)
{
    const char *again = strstr(f->again, rule), *stop = strstr(f->debug, ",offset'");
    const char *end = stop != NULL ? strstr(stop, " -ex c --args ") : NULL;
    const char *call = strstr(f->debug, " --in-process ");
    fprintf(out, "|%s|", again != NULL ? again + strlen(rule) : "");
    if (end != NULL)
        fprintf(out, "%.*s", (int)(end - stop - 8), stop + 8);
    fprintf(out, "%s\n", call != NULL ? call : "");
}

/* What its own rule says: the same on every machine. */
static void keep_findings(struct selftest_fixture *fixture, const struct rule_report *rule)
{
    size_t size;
    FILE *out = open_memstream(&fixture->findings, &size);
    char again[128]; /* before this the call names the module */
    snprintf(again, sizeof again, " --rule %s", rule->id);
    if (out == NULL)
        return;
    for (size_t i = 0; i < rule->finding_count; i++) {
        const struct finding *f = &rule->findings[i];
        fprintf(out, "%s|%s|%s%s|%s|%llu", f->what, f->when, f->has_address ? "at" : "",
                place_of(f), f->function != NULL ? f->function : "", (unsigned long long)f->count);
        keep_reproduction(out, f, again);
    }
    if (rule->dropped > 0)
        fprintf(out, "and %zu more\n", rule->dropped);
    fclose(out);
}

/* What the rules say that did not judge it, "REASON|RULE" and a line each. */
static void keep_reasons(struct selftest_fixture *fixture, const struct report *report)
{
    size_t size;
    FILE *out = open_memstream(&fixture->reasons, &size);
    for (size_t i = 0; out != NULL && i < report->rule_count; i++)
        if (report->rules[i].outcome == RULE_NOT_JUDGED)
            fprintf(out, "%s|%s\n", report->rules[i].reason, report->rules[i].id);
    if (out != NULL)
        fclose(out);
}

/* Of a good one nothing is expected but that nothing is said. */
static void compare(const struct pool *pool, struct selftest_fixture *fixture,
                    const struct report *report)
{
    char path[1024], why[EXPECTED_WHY];
    struct expected expected;
    snprintf(path, sizeof path, "%s/%s/expected", pool->options->folder, fixture->rule->id);
    char *text = read_text(path);
    if (text == NULL ||
        !expected_find((struct expected){ text, strlen(text) }, fixture->name, &expected)) {
        say(fixture, "nothing is expected of it in ", "expected", "");
        free(text);
        return;
    }
    if (fixture->findings != NULL && !expected_findings(expected, fixture->findings, why))
        say(fixture, "", why, "");
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        const char *reason = rule->outcome == RULE_NOT_JUDGED ? rule->reason : "";
        if (!expected_reason(expected, rule->id, reason, why))
            say(fixture, "", why, "");
    }
    free(text);
}

static void judge(const struct pool *pool, struct selftest_fixture *fixture,
                  const struct report *report)
{
    bool judged = false; /* by its own rule */
    keep_reasons(fixture, report);
    for (size_t i = 0; i < report->rule_count; i++) {
        const struct rule_report *rule = &report->rules[i];
        const bool own = strcmp(rule->id, fixture->rule->id) == 0;
        const char *first = rule->finding_count > 0 ? rule->findings[0].what : "";
        judged = judged || own;
        if (own)
            keep_findings(fixture, rule);
        if (fixture->bad && own && rule->outcome != RULE_FAILED)
            say(fixture, "did not trip ", rule->id, "");
        if (rule->outcome == RULE_FAILED && !(fixture->bad && own)) {
            say(fixture, "tripped ", rule->id, ": ");
            say(fixture, "", "", first);
        }
        if (!fixture->bad && rule->outcome == RULE_NOT_JUDGED)
            say(fixture, "not judged by ", rule->id, "");
    }
    const bool must = fixture->rule->severity == SEVERITY_MUST;
    if (fixture->bad && judged && (report->verdict == VERDICT_FAIL) != must)
        say(fixture, "verdict ", verdict_name(report->verdict), "");
    if (!fixture->bad && report->verdict != VERDICT_PASS)
        say(fixture, "verdict ", verdict_name(report->verdict), "");
    if (fixture->bad)
        compare(pool, fixture, report);
}

/* FOLDER/RULE/NAME, made if need be. */
static const char *evidence_folder(const char *folder, const struct selftest_fixture *fixture,
                                   bool make, char path[2048])
{
    const int length = snprintf(path, 1024, "%s/%s", folder, fixture->rule->id);
    if (make) {
        mkdir(folder, 0777);
        mkdir(path, 0777); /* what went wrong is told where the evidence is written */
    }
    snprintf(path + length, 1024, "/%s", fixture->name);
    return path;
}

static int run(const struct pool *pool, struct selftest_fixture *fixture, const char *rules,
               struct check **check, char why[CHECK_WHY])
{
    const struct selftest_options *options = pool->options;
    char folder[2048];
    struct played played;
    if (options->from_evidence != NULL)
        return check_again(check, evidence_folder(options->from_evidence, fixture, false, folder),
                           &(struct check_changes){ .rules = rules, .sparing = true }, why);
    if (!read_scenario(pool, fixture, &played, why))
        return -EINVAL;
    const struct check_scenario scenario = { .scenario = played.scenario,
                                             .path = played.path,
                                             .text = played.text };
    const struct check_options of_check = {
        .path = fixture->path,
        .tool = "tgm selftest",
        .profile = profile_for(fixture->path),
        .seed = SEED,
        .cycles = CYCLES,
        .jobs = 1,
        .rules = rules,
        .scenarios = &scenario,
        .scenario_count = played.scenario != NULL,
        .evidence = options->evidence != NULL
                        ? evidence_folder(options->evidence, fixture, true, folder)
                        : NULL,
    };
    const int r = check_run(check, &of_check, why);
    scenario_close(played.scenario);
    free(played.text);
    return r;
}

static void try(const struct pool *pool, struct selftest_fixture *fixture)
{
    const char *rules = pool->options->first_only ? fixture->rule->id : pool->options->judges;
    struct check *check;
    char why[CHECK_WHY];
    if (run(pool, fixture, rules, &check, why) == 0) {
        judge(pool, fixture, check_report(check));
        check_free(check);
    } else {
        say(fixture, "could not be judged: ", "", why);
    }
    fixture->right = fixture->why[0] == '\0';
    fixture->tried = true;
}

static void *work(void *argument)
{
    struct pool *pool = argument;
    for (size_t i; !pool->over && (i = atomic_fetch_add(&pool->next, 1)) < pool->test->count;) {
        try(pool, &pool->test->fixtures[i]);
        if (pool->options->first_wrong && !pool->test->fixtures[i].right)
            pool->over = true;
    }
    return NULL;
}

static void try_all(struct pool *pool)
{
    pthread_t threads[JOBS_MOST];
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    unsigned jobs = pool->options->jobs, made = 1;
    check_share_arena();
    if (jobs == 0)
        jobs = cores > 0 ? (unsigned)cores : 1;
    while (made < jobs && made < JOBS_MOST && pthread_create(&threads[made], NULL, work, pool) == 0)
        made++;
    work(pool);
    while (--made > 0)
        pthread_join(threads[made], NULL);
}

int selftest_run(struct selftest *out, const struct selftest_options *options,
                 char why[SELFTEST_WHY])
{
    struct pool pool = { .options = options, .test = out };
    struct selftest_tally tally;
    char idle[RULE_PATTERN];
    *out = (struct selftest){ .count = 0 };
    if (rule_pattern_idle(options->rules, idle)) {
        snprintf(why, SELFTEST_WHY, "no rule matches '%s'; `tgm rules` lists them", idle);
        return -EINVAL;
    }
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        if (!rule_selected(options->rules, rule_at(i)->id))
            continue;
        out->rules++;
        if (find_fixtures(out, rule_at(i), options->folder) != 0) {
            selftest_free(out);
            snprintf(why, SELFTEST_WHY, "no memory");
            return -ENOMEM;
        }
    }
    if (out->rules == 0) {
        snprintf(why, SELFTEST_WHY, "'%s' leaves no rule to prove", options->rules);
        return -EINVAL;
    }
    try_all(&pool);
    for (size_t i = 0; i < out->count; i++) {
        out->tried += out->fixtures[i].tried;
        out->wrong += out->fixtures[i].tried && !out->fixtures[i].right;
    }
    for (size_t i = 0; rule_at(i) != NULL; i++) {
        selftest_tally(out, rule_at(i), &tally);
        out->unproven +=
            rule_selected(options->rules, rule_at(i)->id) && (tally.bad == 0 || tally.good == 0);
    }
    return 0;
}

void selftest_tally(const struct selftest *test, const struct rule *rule,
                    struct selftest_tally *tally)
{
    *tally = (struct selftest_tally){ .bad = 0 };
    for (size_t i = 0; i < test->count; i++) {
        const struct selftest_fixture *fixture = &test->fixtures[i];
        if (fixture->rule != rule)
            continue;
        tally->bad += fixture->bad;
        tally->bad_right += fixture->bad && fixture->right;
        tally->good += !fixture->bad;
        tally->good_right += !fixture->bad && fixture->right;
    }
}

bool selftest_proves(const struct selftest_tally *tally)
{
    return tally->bad > 0 && tally->good > 0 && tally->bad == tally->bad_right &&
           tally->good == tally->good_right;
}

void selftest_free(struct selftest *test)
{
    for (size_t i = 0; i < test->count; i++) {
        free(test->fixtures[i].findings);
        free(test->fixtures[i].reasons);
    }
    free(test->fixtures);
    *test = (struct selftest){ .count = 0 };
}
