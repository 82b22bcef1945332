/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_hostile_evidence.c - evidence that says anything at all, in an archive in which every size
 * and hash is right: every rule judges from it, every report is written.
 */
#include <errno.h>
#include <jansson.h>
#include <setjmp.h>
#include <sodium.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "conformance/archive.h"
#include "conformance/plan.h"
#include "host/evidence_file.h"

#define MODULE FIXTURE_DIR "/returns/good.tgm"
#define ROUNDS 2 /* of each kind */
#define FOLDER TEST_EVIDENCE_DIR "-hostile"

static const char *const names[EXPERIMENT_COUNT] = {
#define EXPERIMENT(symbol, name, ...) name,
#include "conformance/experiments.def"
#undef EXPERIMENT
};

static uint64_t state_of_noise;

/* splitmix64: the same noise every time. */
static uint64_t noise(void)
{
    uint64_t z = state_of_noise += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* One word in `rare` is not zero: any bits, few, or all of them. */
static void make_noise(struct experiment_result *result, unsigned rare)
{
    uint64_t *words = (uint64_t *)result;
    memset(result, 0, sizeof *result);
    for (size_t i = 0; i < sizeof *result / sizeof *words; i++) {
        const uint64_t any = noise();
        if (any % rare != 0)
            continue;
        words[i] = any >> 8 & 1 ? noise() : any >> 9 & 1 ? noise() % 1000 : UINT64_MAX;
    }
}

static void put_file(json_t *files, const char *name, const void *bytes, size_t size)
{
    unsigned char digest[crypto_hash_sha256_BYTES];
    char path[512], hash[65];
    snprintf(path, sizeof path, FOLDER "/%s", name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    crypto_hash_sha256(digest, bytes, size);
    sodium_bin2hex(hash, sizeof hash, digest, sizeof digest);
    json_object_set_new(files, name,
                        json_pack("{s:I, s:s}", "size", (json_int_t)size, "sha256", hash));
}

static void put_noise(json_t *files, const char *name, unsigned rare)
{
    static struct experiment_result result;
    uint8_t *bytes;
    size_t size;
    make_noise(&result, rare);
    assert_int_equal(evidence_encode(&result, &bytes, &size), 0);
    put_file(files, name, bytes, size);
    free(bytes);
}

/* Of Program_01 to 03, us; -1: off, 0: the product's. */
static int periods[3];

static json_t *conditions(const char *key, uint32_t cycle_us)
{
    return json_pack("{s:s, s:s, s:i, s:i, s:i, s:[i, i, i]}", "key", key, "name", key, "cycle_us",
                     (int)cycle_us, "cycles", (int)(noise() % 100), "data_bytes",
                     (int)(noise() % 3) * 65536, "periods_us", periods[0], periods[1], periods[2]);
}

static void put_module(json_t *files)
{
    static char bytes[1 << 20];
    FILE *file = fopen(MODULE, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    put_file(files, "module", bytes, size);
}

/* An archive in which nothing but the evidence and its conditions is strange. */
static void make_archive(const char *profile, unsigned rare)
{
    static const uint32_t cycle_times[] = { 250, 500, 1000 };
    static const char scenario[] =
        "every 1ms expect SERVO[0].Position < 5\nlog \"x\" 3\nend at 9ms\n";
    json_t *files = json_object(), *experiments = json_array(), *scenarios = json_array();
    mkdir(FOLDER, 0777);
    put_module(files);
    for (int i = 0; i < EXPERIMENT_COUNT; i++) {
        char name[128];
        snprintf(name, sizeof name, "%s.evidence", names[i]);
        put_noise(files, name, rare);
        json_array_append_new(experiments, conditions(names[i], cycle_times[noise() % 3]));
    }
    put_file(files, "scenario-1.scenario", scenario, sizeof scenario - 1);
    put_noise(files, "scenario-1.evidence", rare);
    json_array_append_new(scenarios, conditions("a.scenario", 500));
    json_t *manifest = json_pack(
        "{s:s, s:s, s:s, s:s, s:s, s:i, s:s, s:o, s:o, s:o}", "form", ARCHIVE_FORM, "tool", "test",
        "module", "a.tgm", "profile", profile, "seed", "0x1", "cycles", 0, "today", "2026-11-27",
        "experiments", experiments, "scenarios", scenarios, "files", files);
    assert_non_null(manifest);
    assert_int_equal(json_dump_file(manifest, FOLDER "/manifest.json", 0), 0);
    json_decref(manifest);
}

static void judge_and_report(void)
{
    static int (*const forms[])(const struct report *, FILE *) = { report_json, report_junit,
                                                                   report_sarif, report_html };
    static const struct check_changes nothing;
    struct check *check;
    char why[CHECK_WHY] = "", *text;
    size_t size;
    if (check_again(&check, FOLDER, &nothing, why) != 0)
        fail_msg("%s", why);
    const struct report *report = check_report(check);
    assert_int_not_equal(report->verdict, VERDICT_PASS);
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    report_text(report, stream, true);
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++)
        assert_int_equal(forms[i](report, stream), 0);
    fclose(stream);
    assert_true(size > 1000);
    free(text);
    check_free(check);
}

static void periods_that_the_product_lacks_are_refused(void **state)
{
    static const struct {
        int periods[3];
        const char *why;
    } rows[] = {
        { { 0, 0, 0 }, "" },
        { { -1, 10000, 200 }, "" },
        { { -2, 0, 0 }, "the manifest's experiment start is none of this product" },
        { { 0, 99, 0 }, "the manifest's experiment start is none of this product" },
        { { 0, 0, 1 }, "the manifest's experiment start is none of this product" },
    };
    static const struct check_changes nothing;
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct check *check;
        char why[CHECK_WHY] = "";
        state_of_noise = i;
        memcpy(periods, rows[i].periods, sizeof periods);
        make_archive("pc4", 4096);
        const int r = check_again(&check, FOLDER, &nothing, why);
        assert_string_equal(why, rows[i].why);
        assert_int_equal(r, rows[i].why[0] != '\0' ? -EINVAL : 0);
        if (r == 0)
            check_free(check);
    }
    memset(periods, 0, sizeof periods);
}

static void every_rule_bears_any_evidence(void **state)
{
    static const unsigned rare[] = { 1, 2, 8, 64, 512, 4096 };
    static const char *const profiles[] = { "pc4", "pc5", "pc500", "tgmcontroller", "tgzmotion" };
    (void)state;
    for (size_t i = 0; i < ROUNDS * sizeof rare / sizeof *rare; i++) {
        state_of_noise = i;
        make_archive(profiles[i % (sizeof profiles / sizeof *profiles)],
                     rare[i % (sizeof rare / sizeof *rare)]);
        judge_and_report();
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_rule_bears_any_evidence),
        cmocka_unit_test(periods_that_the_product_lacks_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
