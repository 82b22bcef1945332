/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_evidence.c - evidence as bytes and as a folder; waivers; which rules are judged. */
#include <errno.h>
#include <jansson.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "conformance/check.h"
#include "host/evidence_file.h"

#define GOOD   FIXTURE_DIR "/returns/good.tgm"
#define BAD    FIXTURE_DIR "/returns/bad.tgm"
#define FOLDER TEST_EVIDENCE_DIR

static struct check_options options_for(const char *path)
{
    return (struct check_options){ .path = path,
                                   .tool = "test",
                                   .profile = profile_find("pc4"),
                                   .seed = UINT64_C(0xfedcba9876543210),
                                   .cycles = 60,
                                   .rules = "returns,ini-*,no-fault" };
}

static struct check *checked(const struct check_options *options)
{
    struct check *check;
    char why[CHECK_WHY];
    if (check_run(&check, options, why) != 0)
        fail_msg("%s", why);
    return check;
}

/* The report as JSON, without times. */
static char *printed(const struct check *check)
{
    const struct report *report = check_report(check);
    char *text;
    size_t size;
    for (size_t i = 0; i < report->group_count; i++)
        report->groups[i].seconds = 0;
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    assert_int_equal(report_json(report, stream), 0);
    report_text(report, stream, false);
    fclose(stream);
    return text;
}

static const struct check_changes nothing;

static void remove_folder(void)
{
    assert_int_equal(system("rm -rf " FOLDER), 0);
}

static void a_saved_check_gives_the_same_report(void **state)
{
    const char *const modules[] = { GOOD, BAD, BAD };
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct check_options options = options_for(modules[i]);
        char why[CHECK_WHY] = "";
        struct check *again;
        options.evidence = FOLDER;
        options.strict = i == 1;
        options.instrumented = i == 2;
        struct check *check = checked(&options);
        assert_int_equal(check_report(check)->verdict, i == 0 ? VERDICT_PASS : VERDICT_FAIL);
        if (check_again(&again, FOLDER, &nothing, why) != 0)
            fail_msg("%s", why);
        char *one = printed(check), *other = printed(again);
        assert_string_equal(one, other);
        free(one);
        free(other);
        /* ini-body is judged on a traced run, always. */
        assert_int_equal(check_report(again)->runs_emulated,
                         i == 2 ? check_report(again)->runs_all : 1);
        check_free(check);
        check_free(again);
    }
}

static void the_manifest_says_on_which_machine_each_run_was(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct check_options options = options_for(GOOD);
        json_t *run;
        size_t k;
        options.evidence = FOLDER;
        options.rules = "returns";
        options.instrumented = i == 1;
        check_free(checked(&options));
        json_t *manifest = json_load_file(FOLDER "/manifest.json", 0, NULL);
        json_t *runs = json_object_get(manifest, "experiments");
        assert_int_equal(json_is_true(json_object_get(manifest, "instrumented")), i == 1);
        assert_in_range(json_array_size(runs), 4, EXPERIMENT_COUNT);
        json_array_foreach(runs, k, run) assert_string_equal(
            json_string_value(json_object_get(run, "machine")), i == 1 ? "instrumented" : "native");
        json_decref(manifest);
    }
}

static char *whole(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *bytes = malloc(1 << 20);
    assert_non_null(bytes);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    return bytes;
}

static void put_whole(const char *path, const char *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static void only_evidence_is_replaced_by_evidence(void **state)
{
    struct check_options options = options_for(GOOD);
    struct check *check;
    char why[CHECK_WHY] = "";
    (void)state;
    options.evidence = FOLDER;
    check_free(checked(&options));
    options.rules = "returns";
    check_free(checked(&options));
    assert_int_not_equal(access(FOLDER "/null-data.evidence", F_OK), 0);
    assert_int_equal(access(FOLDER "/cycle-500.evidence", F_OK), 0);
    put_whole(FOLDER "/manifest.json", "{}", 2); /* as a browser's extension has one */
    assert_int_equal(check_run(&check, &options, why), -ENOTEMPTY);
    assert_non_null(strstr(why, "is not empty, and no evidence of tgm"));
    size_t size;
    char *bytes = whole(FOLDER "/manifest.json", &size);
    assert_int_equal(size, 2);
    free(bytes);
    remove_folder();
}

static void refused(const char *reason)
{
    struct check *check;
    char why[CHECK_WHY] = "";
    if (check_again(&check, FOLDER, &nothing, why) == 0)
        fail_msg("evidence was taken that should be refused: %s", reason);
    if (strstr(why, reason) == NULL)
        fail_msg("'%s' does not say '%s'", why, reason);
}

static void tampered_short_and_foreign_evidence_is_refused(void **state)
{
    static const char *const names[] = { "module", "cycle-500.evidence", "start.evidence" };
    struct check_options options = options_for(GOOD);
    (void)state;
    options.evidence = FOLDER;
    check_free(checked(&options));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[512];
        size_t size;
        snprintf(path, sizeof path, FOLDER "/%s", names[i]);
        char *bytes = whole(path, &size);
        bytes[size - 1] ^= 1;
        put_whole(path, bytes, size);
        refused("is not what was written: its SHA-256 is");
        bytes[size - 1] ^= 1;
        put_whole(path, bytes, size - 1);
        refused("is not what was written");
        assert_int_equal(unlink(path), 0);
        refused("No such file");
        put_whole(path, bytes, size);
        free(bytes);
    }
    put_whole(FOLDER "/manifest.json", "{}", 2);
    refused("is no evidence of the form tgm-evidence/1");
    put_whole(FOLDER "/manifest.json", "{", 1);
    refused("is no JSON");
    remove_folder();
}

static void what_may_be_asked_anew_is_judged_anew(void **state)
{
    static struct waivers waivers;
    struct check_options options = options_for(BAD);
    struct check_changes changes = { .rules = "ini-*" };
    char why[CHECK_WHY];
    struct check *check;
    (void)state;
    options.evidence = FOLDER;
    check_free(checked(&options));
    assert_int_equal(check_again(&check, FOLDER, &changes, why), 0);
    assert_int_equal(check_report(check)->verdict, VERDICT_PASS);
    check_free(check);
    static const char text[] = "returns until 2999-12-31 by me: it is only a test\n";
    assert_int_equal(waivers_read(&waivers, text, sizeof text - 1, "w", why), 0);
    changes = (struct check_changes){ .waivers = &waivers };
    assert_int_equal(check_again(&check, FOLDER, &changes, why), 0);
    assert_int_equal(check_report(check)->verdict, VERDICT_PASS);
    assert_int_equal(check_report(check)->waived, 1);
    check_free(check);
    /* What no run was made for cannot be judged. */
    changes = (struct check_changes){ .rules = "restart" };
    assert_int_equal(check_again(&check, FOLDER, &changes, why), 0);
    assert_int_equal(check_report(check)->verdict, VERDICT_INCOMPLETE);
    check_free(check);
}

/* Marks the bytes that some row holds. */
static void mark(const struct evidence_row *rows, size_t base, unsigned char *covered)
{
    for (; rows->name != NULL; rows++)
        for (size_t i = 0; i < rows->count; i++)
            if (rows->of != NULL)
                mark(rows->of, base + rows->offset + i * rows->size, covered);
            else
                memset(covered + base + rows->offset + i * rows->size, 1, rows->size);
}

static bool is_left_out(size_t at)
{
    const size_t service = offsetof(struct experiment_result, evidence.incidents[0].fault.service);
    const size_t first = offsetof(struct experiment_result, evidence.incidents[0]);
    const size_t race = offsetof(struct experiment_result, evidence.races[0].fault.service);
    const size_t stop = offsetof(struct experiment_result, evidence.stop);
    for (size_t i = 0; i < EVIDENCE_INCIDENTS; i++) {
        const size_t begin = service + i * sizeof(struct evidence_incident);
        if (at >= begin && at < begin + sizeof(void *) && at > first)
            return true;
    }
    for (size_t i = 0; i < EVIDENCE_RACES; i++)
        if (at - race - i * sizeof(struct evidence_race) < sizeof(void *))
            return true;
    return at == stop;
}

static void every_byte_of_evidence_is_in_a_row_but_for_padding(void **state)
{
    static unsigned char covered[sizeof(struct experiment_result)];
    size_t run = 0;
    (void)state;
    mark(evidence_result_rows, 0, covered);
    for (size_t at = 0; at < sizeof covered; at++) {
        run = covered[at] || is_left_out(at) ? 0 : run + 1;
        /* Padding ends where something aligned begins, and is shorter than that. */
        if (run >= 8)
            fail_msg("byte %zu of struct experiment_result is in no row of evidence_rows.c", at);
    }
}

static void evidence_comes_back_as_it_was(void **state)
{
    static struct experiment_result in, out;
    uint8_t *bytes;
    size_t size;
    char why[EVIDENCE_WHY];
    (void)state;
    in.evidence.stage = EVIDENCE_FINISHED;
    in.evidence.cycle = UINT64_MAX;
    in.evidence.calls[ENTRY_05].last_value = -7;
    in.evidence.calls[ENTRY_05].disabled = true;
    in.evidence.incidents[15].fault.region_offset = INT64_MIN;
    strcpy(in.evidence.messages[31].text, "\xc3\xa4");
    in.evidence.digest.states[DIGEST_STATES - 1].where = 3;
    in.evidence.sketch.greatest[SKETCH_CURVES - 1][SKETCH_BUCKETS - 1] = 1.5F;
    in.worker.end = WORKER_KILLED;
    in.worker.value = 11;
    assert_int_equal(evidence_encode(&in, &bytes, &size), 0);
    assert_in_range(size, 100, 4000); /* zeros cost next to nothing */
    assert_int_equal(evidence_decode(&out, bytes, size, why), 0);
    assert_memory_equal(&in.evidence.calls, &out.evidence.calls, sizeof in.evidence.calls);
    assert_true(out.evidence.cycle == UINT64_MAX);
    assert_true(out.evidence.incidents[15].fault.region_offset == INT64_MIN);
    assert_string_equal(out.evidence.messages[31].text, "\xc3\xa4");
    assert_int_equal(out.evidence.digest.states[DIGEST_STATES - 1].where, 3);
    assert_true(out.evidence.sketch.greatest[SKETCH_CURVES - 1][SKETCH_BUCKETS - 1] > 1.4F);
    assert_int_equal(out.worker.end, WORKER_KILLED);
    assert_int_equal(out.worker.value, 11);
    /* Every length but the right one is refused. */
    for (size_t length = 0; length < size; length++)
        assert_int_not_equal(evidence_decode(&out, bytes, length, why), 0);
    bytes[12] ^= 1;
    assert_int_not_equal(evidence_decode(&out, bytes, size, why), 0);
    assert_string_equal(why,
                        "another version of tgm wrote it, in a form that this one does not read");
    free(bytes);
}

/* Any other bits in one are undefined behaviour for whoever looks. */
static void flags_out_of_a_file_are_true_or_false(void **state)
{
    static struct experiment_result in, out;
    const struct evidence *e = &out.evidence;
    const bool *const flags[] = {
        &e->all_op,
        &e->calls[ENTRY_05].disabled,
        &e->unable[1].fault,
        &e->eeprom.saved,
        &e->instrumented,
        &e->incidents[1].fault.in_module,
        &e->lookup.asked,
        &e->lookup.found,
        &e->incidents[1].fault.has_pc,
        &e->clock.used,
        &e->clock.priority,
        &e->incidents[1].fault.syscall_i386,
        &e->clock.pinned,
        &e->clock.locked,
        &e->messages[1].of_host,
        &e->races[1].by_writes,
        &e->races[1].has_by_pc,
        &e->failures[1].values[1].is_double,
        &e->audit.traced,
        &e->audit.accesses[1].write,
        &e->audit.accesses[1].before_op,
        &e->lines[1].value.is_double,
    };
    uint8_t *bytes;
    size_t size;
    char why[EVIDENCE_WHY];
    (void)state;
    memset(&in, 0xFE, sizeof in);
    assert_int_equal(evidence_encode(&in, &bytes, &size), 0);
    assert_int_equal(evidence_decode(&out, bytes, size, why), 0);
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
        assert_int_equal(*(const unsigned char *)flags[i], 1);
    free(bytes);
}

static void waivers_are_refused(const char *text, const char *reason)
{
    static struct waivers waivers;
    char why[WAIVERS_WHY] = "";
    assert_int_not_equal(waivers_read(&waivers, text, strlen(text), "w", why), 0);
    if (strstr(why, reason) == NULL)
        fail_msg("'%s' does not say '%s'", why, reason);
}

static void waivers_need_a_rule_a_day_an_owner_and_a_reason(void **state)
{
    static struct waivers waivers;
    static const char good[] =
        "# ours\n\n  returns until 2028-02-29 by A. Person <a@b.c> :  it  waits \r\n"
        "no-fault until 2027-01-31 by x: y";
    char why[WAIVERS_WHY];
    (void)state;
    assert_int_equal(waivers_read(&waivers, good, sizeof good - 1, "w", why), 0);
    assert_int_equal(waivers.count, 2);
    assert_string_equal(waivers.list[0].rule, "returns");
    assert_string_equal(waivers.list[0].expiry, "2028-02-29");
    assert_string_equal(waivers.list[0].owner, "A. Person <a@b.c>");
    assert_string_equal(waivers.list[0].reason, "it  waits");
    assert_false(waiver_expired(&waivers.list[1], "2027-01-31"));
    assert_true(waiver_expired(&waivers.list[1], "2027-02-01"));
    waivers_are_refused("return until 2027-01-01 by x: y", "w:1: 'return' is no rule");
    waivers_are_refused("\nreturns until 2027-02-29 by x: y", "w:2: 'until' and a day");
    waivers_are_refused("returns until 2027-13-01 by x: y", "a day");
    waivers_are_refused("returns until 2027-1-01 by x: y", "a day");
    waivers_are_refused("returns by x: y", "'until' and a day");
    waivers_are_refused("returns until 2027-01-01 x: y", "'by'");
    waivers_are_refused("returns until 2027-01-01 by : y", "'by'");
    waivers_are_refused("returns until 2027-01-01 by x:  ", "the reason is missing");
    waivers_are_refused("returns until 2027-01-01 by x: y\nreturns until 2027-01-01 by x: z",
                        "w:2: a second waiver");
}

static void an_expired_waiver_fails_the_module(void **state)
{
    static struct waivers waivers;
    static const char text[] = "returns until 2026-01-31 by me: for now\n";
    struct check_options options = options_for(GOOD);
    char why[WAIVERS_WHY];
    (void)state;
    assert_int_equal(waivers_read(&waivers, text, sizeof text - 1, "w", why), 0);
    options.waivers = &waivers;
    options.today = "2026-01-31";
    struct check *check = checked(&options);
    assert_int_equal(check_report(check)->verdict, VERDICT_PASS);
    assert_false(check_report(check)->waivers[0].used);
    check_free(check);
    options.today = "2026-02-01";
    check = checked(&options);
    assert_int_equal(check_report(check)->verdict, VERDICT_FAIL);
    assert_true(check_report(check)->waivers[0].expired);
    check_free(check);
}

static size_t chosen(const char *rules)
{
    struct check_options options = options_for(GOOD);
    options.rules = rules;
    struct check *check = checked(&options);
    const size_t count = check_report(check)->rule_count;
    check_free(check);
    return count;
}

static void rules_are_chosen_by_patterns_and_taken_away_by_others(void **state)
{
    (void)state;
    assert_int_equal(chosen("returns"), 1);
    assert_int_equal(chosen("returns,no-fault"), 2);
    assert_int_equal(chosen("returns,no-fault,!no-*"), 1);
    assert_int_equal(chosen("file-*,!no-*"), 1);
    assert_int_equal(chosen("!*-*"), chosen("*,!*-*"));
    assert_in_range(chosen("!*-*"), 1, chosen(NULL) - 1);
}

static void a_pattern_that_fits_no_rule_is_a_wrong_call(void **state)
{
    static const struct {
        const char *rules, *reason;
    } calls[] = {
        { "no-falt", "no rule matches 'no-falt'" },
        { "returns,no-falt", "no rule matches 'no-falt'" },
        { "returns,!no-falt", "no rule matches 'no-falt'" },
        { "", "no rule matches ''" },
        { "returns,", "no rule matches ''" },
        { "returns,!returns", "'returns,!returns' leaves no rule" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        struct check_options options = options_for(GOOD);
        struct check *check;
        char why[CHECK_WHY] = "";
        options.rules = calls[i].rules;
        assert_int_equal(check_run(&check, &options, why), -EINVAL);
        if (strstr(why, calls[i].reason) == NULL)
            fail_msg("'%s' does not say '%s'", why, calls[i].reason);
    }
}

static void the_number_of_jobs_changes_nothing(void **state)
{
    char *texts[2];
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct check_options options = options_for(FIXTURE_DIR "/no-fault/bad.tgm");
        options.jobs = 1 + 3 * i;
        struct check *check = checked(&options);
        texts[i] = printed(check);
        check_free(check);
    }
    assert_string_equal(texts[0], texts[1]);
    free(texts[0]);
    free(texts[1]);
}

/* What an earlier run may have left. */
static int set_up(void **state)
{
    (void)state;
    remove_folder();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_saved_check_gives_the_same_report),
        cmocka_unit_test(the_manifest_says_on_which_machine_each_run_was),
        cmocka_unit_test(only_evidence_is_replaced_by_evidence),
        cmocka_unit_test(tampered_short_and_foreign_evidence_is_refused),
        cmocka_unit_test(what_may_be_asked_anew_is_judged_anew),
        cmocka_unit_test(every_byte_of_evidence_is_in_a_row_but_for_padding),
        cmocka_unit_test(evidence_comes_back_as_it_was),
        cmocka_unit_test(flags_out_of_a_file_are_true_or_false),
        cmocka_unit_test(waivers_need_a_rule_a_day_an_owner_and_a_reason),
        cmocka_unit_test(an_expired_waiver_fails_the_module),
        cmocka_unit_test(rules_are_chosen_by_patterns_and_taken_away_by_others),
        cmocka_unit_test(a_pattern_that_fits_no_rule_is_a_wrong_call),
        cmocka_unit_test(the_number_of_jobs_changes_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
