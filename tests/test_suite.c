/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_suite.c - a certificate's suite is what it was when it was frozen. With --write it prints it
 * as it is now. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <sodium.h>

#include "conformance/rule_book.h"
#include "conformance/suite.h"

static char *written(const struct suite *suite)
{
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    suite_write(suite, out);
    assert_int_equal(fclose(out), 0);
    return text;
}

static void the_latest_suite_is_what_its_file_says(void **state)
{
    const struct suite *suite = suite_latest();
    char path[256], *now = written(suite), line[1024];
    size_t number = 0;
    const char *at = now;
    (void)state;
    snprintf(path, sizeof path, "conformance/suites/%s.txt", suite->name);
    FILE *file = fopen(path, "r");
    if (file == NULL)
        fail_msg("%s is missing: build/test/test_suite --write >%s", path, path);
    for (; fgets(line, sizeof line, file) != NULL; at += strlen(line), number++)
        if (strncmp(at, line, strlen(line)) != 0)
            break;
    if (!feof(file) || *at != '\0')
        fail_msg("%s:%zu is no longer so: certificates name this suite. If any was issued, add "
                 "another in suite.c; if not, build/test/test_suite --write >%s",
                 path, number + 1, path);
    fclose(file);
    free(now);
}

static void a_suite_leaves_nothing_out_and_lets_nothing_pass(void **state)
{
    static const struct waivers waivers;
    static const struct host_config around;
    static const struct check_scenario scenario;
    struct check_options options = { .rules = "returns",
                                     .cycles = 1,
                                     .strict = true,
                                     .waivers = &waivers,
                                     .around = &around,
                                     .around_path = "x.ini",
                                     .scenarios = &scenario,
                                     .scenario_count = 1 };
    (void)state;
    suite_apply(suite_latest(), &options);
    assert_int_equal(options.seed, suite_latest()->seed);
    assert_true(options.instrumented);
    assert_false(options.strict);
    assert_int_equal(options.cycles, 0);
    assert_null(options.rules);
    assert_null(options.waivers);
    assert_null(options.around);
    assert_null(options.around_path);
    assert_null(options.scenarios);
    assert_int_equal(options.scenario_count, 0);
}

/* Whoever has a certificate can find out what its rule book says. */
static void the_rule_book_has_the_hash_of_its_text(void **state)
{
    char *text = written(suite_latest()), hash[RULE_BOOK_HASH], expected[RULE_BOOK_HASH];
    const char *book = strchr(text, '\n') + 1;
    unsigned char digest[crypto_hash_sha256_BYTES];
    (void)state;
    crypto_hash_sha256(digest, (const unsigned char *)book, strlen(book));
    sodium_bin2hex(expected, sizeof expected, digest, sizeof digest);
    rule_book_hash(hash);
    assert_string_equal(hash, expected);
    free(text);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_latest_suite_is_what_its_file_says),
        cmocka_unit_test(a_suite_leaves_nothing_out_and_lets_nothing_pass),
        cmocka_unit_test(the_rule_book_has_the_hash_of_its_text),
    };
    if (argc == 2 && strcmp(argv[1], "--write") == 0) {
        suite_write(suite_latest(), stdout);
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
