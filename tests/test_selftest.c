/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_selftest.c - what is expected of fixtures, as text and by the whole way; evidence kept of
 * them. */
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

#include "conformance/expected.h"
#include "conformance/selftest.h"

#define COPY     TEST_SELFTEST_DIR "/fixtures"
#define EVIDENCE TEST_SELFTEST_DIR "/evidence"

/* --- text ------------------------------------------------------------------------------------- */

static const char text[] = "# about it\n"
                           "bad-a.tgm\n"
                           "  one|1\n"
                           "  two *|2\n"
                           "  not judged: so * it is|first second\n"
                           "bad-b.tgm\n"
                           "bad.tgm\n"
                           "  three|3\n";

static struct expected of(const char *module)
{
    struct expected found;
    assert_true(expected_find((struct expected){ text, strlen(text) }, module, &found));
    return found;
}

static void a_star_stands_for_any_text(void **state)
{
    (void)state;
    assert_true(expected_fits("a*c", "abc"));
    assert_true(expected_fits("a*c", "ac"));
    assert_true(expected_fits("a*c*", "abcbcb"));
    assert_true(expected_fits("*a*bc", "aabbcabc"));
    assert_true(expected_fits("", ""));
    assert_true(expected_fits("*", ""));
    assert_false(expected_fits("a*c", "abcd"));
    assert_false(expected_fits("a*c", "bc"));
    assert_false(expected_fits("ab", "a"));
    assert_false(expected_fits("a", "ab"));
    assert_false(expected_fits("", "a"));
    assert_true(expected_fits("SERVO[0]?", "SERVO[0]?"));
    assert_false(expected_fits("SERVO[0]?", "SERVO[0]!"));
}

static void each_finding_must_be_there_in_its_place(void **state)
{
    char why[EXPECTED_WHY] = "";
    (void)state;
    assert_true(expected_findings(of("bad-a.tgm"), "one|1\ntwo apples|2\n", why));
    assert_false(expected_findings(of("bad-a.tgm"), "one|1\n", why));
    assert_string_equal(why, "expected \"two *|2\", found \"\"");
    assert_false(expected_findings(of("bad-a.tgm"), "one|1\ntwo apples|2\nthree|3\n", why));
    assert_string_equal(why, "expected \"\", found \"three|3\"");
    assert_false(expected_findings(of("bad-a.tgm"), "two apples|2\none|1\n", why));
    assert_false(expected_findings(of("bad-a.tgm"), "one|1\ntwo apples|3\n", why));
    assert_true(expected_findings(of("bad-b.tgm"), "", why));
    assert_false(expected_findings(of("bad-b.tgm"), "three|3\n", why));
    assert_true(expected_findings(of("bad.tgm"), "three|3\n", why));
}

static void what_is_not_judged_must_be_not_judged_for_that_reason(void **state)
{
    char why[EXPECTED_WHY] = "";
    (void)state;
    assert_true(expected_reason(of("bad-a.tgm"), "first", "so that it is", why));
    assert_true(expected_reason(of("bad-a.tgm"), "second", "so what it is", why));
    assert_true(expected_reason(of("bad-a.tgm"), "third", "", why));
    assert_true(expected_reason(of("bad-a.tgm"), "seco", "", why));
    assert_false(expected_reason(of("bad-a.tgm"), "first", "", why));
    assert_string_equal(why, "first not judged because \"\", expected \"so * it is\"");
    assert_false(expected_reason(of("bad-a.tgm"), "first", "otherwise", why));
    assert_false(expected_reason(of("bad-a.tgm"), "third", "so that it is", why));
    assert_false(expected_reason(of("bad-b.tgm"), "first", "so that it is", why));
}

static void a_module_that_is_not_named_is_not_found(void **state)
{
    struct expected found;
    (void)state;
    assert_false(expected_find((struct expected){ text, strlen(text) }, "bad-c.tgm", &found));
    assert_false(expected_find((struct expected){ text, strlen(text) }, "bad", &found));
    assert_false(expected_find((struct expected){ "", 0 }, "bad.tgm", &found));
    assert_true(expected_find((struct expected){ "a\n  b\n\n c\n", 10 }, "a", &found));
    assert_true(expected_findings(found, "b\n", (char[EXPECTED_WHY]){ "" }));
}

/* --- the whole way ---------------------------------------------------------------------------- */

static struct selftest tested(struct selftest_options options)
{
    struct selftest test;
    char why[SELFTEST_WHY];
    options.jobs = 1;
    if (options.folder == NULL)
        options.folder = FIXTURE_DIR;
    if (selftest_run(&test, &options, why) != 0)
        fail_msg("%s", why);
    return test;
}

static const struct selftest_fixture *fixture_of(const struct selftest *test, const char *name)
{
    for (size_t i = 0; i < test->count; i++)
        if (strcmp(test->fixtures[i].name, name) == 0)
            return &test->fixtures[i];
    fail_msg("no fixture %s", name);
    return NULL;
}

static void copy(const char *from, const char *to, const char *replaced, const char *by)
{
    static char bytes[1 << 20];
    FILE *file = fopen(from, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, sizeof bytes - 1, file);
    bytes[size] = '\0';
    fclose(file);
    file = fopen(to, "wb");
    assert_non_null(file);
    const char *at = replaced != NULL ? strstr(bytes, replaced) : NULL;
    assert_true(replaced == NULL || at != NULL);
    const size_t before = at != NULL ? (size_t)(at - bytes) : size;
    assert_int_equal(fwrite(bytes, 1, before, file), before);
    if (at != NULL)
        fprintf(file, "%s%s", by, at + strlen(replaced));
    assert_int_equal(fclose(file), 0);
}

/* no-tls, as if something else had been expected of it. */
static struct selftest changed(const char *replaced, const char *by)
{
    const char *const names[] = { "bad.tgm", "good.tgm", "expected" };
    char from[512], to[512];
    mkdir(TEST_SELFTEST_DIR, 0777);
    mkdir(COPY, 0777);
    mkdir(COPY "/no-tls", 0777);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(from, sizeof from, FIXTURE_DIR "/no-tls/%s", names[i]);
        snprintf(to, sizeof to, COPY "/no-tls/%s", names[i]);
        copy(from, to, i == 2 ? replaced : NULL, by);
    }
    return tested(
        (struct selftest_options){ .folder = COPY, .rules = "no-tls", .first_only = true });
}

static void a_finding_that_says_something_else_is_wrong(void **state)
{
    (void)state;
    struct selftest test = changed("bad.tgm", "bad.tgm");
    assert_int_equal(test.count, 2);
    assert_int_equal(test.wrong, 0);
    selftest_free(&test);
    test = changed("\nbad.tgm\n  counter", "\nbad.tgm\n  bouncer");
    assert_int_equal(test.wrong, 1);
    assert_non_null(strstr(fixture_of(&test, "bad.tgm")->why, "expected \"bouncer is"));
    selftest_free(&test);
    test = changed("\nbad.tgm\n", "\nworse.tgm\n");
    assert_int_equal(test.wrong, 1);
    assert_non_null(strstr(fixture_of(&test, "bad.tgm")->why, "nothing is expected of it"));
    selftest_free(&test);
}

static void what_modules_did_can_be_judged_again(void **state)
{
    struct selftest_options options = { .rules = "ini-reports-ids,file-format",
                                        .first_only = true,
                                        .evidence = EVIDENCE };
    (void)state;
    mkdir(TEST_SELFTEST_DIR, 0777);
    struct selftest test = tested(options);
    assert_int_equal(test.wrong, 0);
    options.from_evidence = options.evidence;
    options.evidence = NULL;
    struct selftest again = tested(options);
    assert_int_equal(again.wrong, 0);
    assert_int_equal(again.count, test.count);
    for (size_t i = 0; i < test.count; i++) {
        assert_string_equal(again.fixtures[i].findings, test.fixtures[i].findings);
        assert_string_equal(again.fixtures[i].reasons, test.fixtures[i].reasons);
    }
    /* A flat image is told by its name. */
    assert_non_null(strstr(fixture_of(&again, "bad-flat.tgm.bin")->findings, "flat image"));
    selftest_free(&again);
    /* By another rule, for which nothing was run. */
    options.first_only = false;
    options.rules = "ini-reports-ids";
    options.judges = "restart";
    again = tested(options);
    assert_string_equal(fixture_of(&again, "bad.tgm")->reasons,
                        "the saved evidence does not have what this rule needs|restart\n");
    assert_true(again.wrong > 1);
    selftest_free(&again);
    options.first_wrong = true;
    again = tested(options);
    assert_int_equal(again.wrong, 1);
    assert_int_equal(again.tried, 1);
    selftest_free(&again);
    selftest_free(&test);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_star_stands_for_any_text),
        cmocka_unit_test(each_finding_must_be_there_in_its_place),
        cmocka_unit_test(what_is_not_judged_must_be_not_judged_for_that_reason),
        cmocka_unit_test(a_module_that_is_not_named_is_not_found),
        cmocka_unit_test(a_finding_that_says_something_else_is_wrong),
        cmocka_unit_test(what_modules_did_can_be_judged_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
