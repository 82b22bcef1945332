/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <jansson.h>
#include <setjmp.h>
#include <sodium.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "conformance/certificate.h"

#define HASH(c) c c c c c c c c
#define PROGRAM HASH("0badc0de")

static struct secret_key key, other;
static char folder[] = "/tmp/tgm-certificate-XXXXXX";

static const char *in_folder(const char *name)
{
    static char paths[4][128];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int set_up(void **state)
{
    struct public_key made;
    char why[KEYS_WHY];
    (void)state;
    if (mkdtemp(folder) == NULL || keys_make(in_folder("a.key"), in_folder("a.pub"), &made, why) ||
        keys_make(in_folder("b.key"), in_folder("b.pub"), &made, why) ||
        keys_read_secret(&key, in_folder("a.key"), why) ||
        keys_read_secret(&other, in_folder("b.key"), why))
        return -1;
    return 0;
}

static int tear_down(void **state)
{
    static const char *const names[] = { "a.key", "a.pub", "b.key", "b.pub" };
    (void)state;
    for (size_t i = 0; i < 4; i++)
        unlink(in_folder(names[i]));
    return rmdir(folder);
}

static struct rule_report rules[] = {
    { .id = "no-imports", .severity = SEVERITY_MUST, .outcome = RULE_PASSED },
    { .id = "export-names", .severity = SEVERITY_MUST, .outcome = RULE_PASSED },
};

static struct report passing(void)
{
    return (struct report){ .tool = "tgm 0.1.0",
                            .path = "/plant/gantry.tgm",
                            .sha256 = HASH("0123abcd"),
                            .profile = "pc4",
                            .rule_book = HASH("77aa77aa"),
                            .evidence = HASH("e0e0e0e0"),
                            .rules = rules,
                            .rule_count = 2,
                            .verdict = VERDICT_PASS };
}

static char *certificate_of(const struct report *report)
{
    static struct certificate certificate;
    char why[CERTIFICATE_WHY];
    assert_true(certificate_fill(&certificate, report, "cert-1", PROGRAM, why));
    char *text = certificate_sign(&certificate, &key);
    assert_non_null(text);
    return text;
}

static int open_it(const char *text, size_t size, const struct public_key *by,
                   char why[CERTIFICATE_WHY])
{
    static struct certificate certificate;
    return certificate_open(&certificate, text, size, by, why);
}

/* --- keys ------------------------------------------------------------------------------------- */

static void a_key_read_back_is_the_key_that_was_made(void **state)
{
    struct public_key made, read;
    struct secret_key secret;
    struct stat s;
    char why[KEYS_WHY];
    (void)state;
    assert_int_equal(keys_make(in_folder("c.key"), in_folder("c.pub"), &made, why), 0);
    assert_int_equal(keys_read_public(&read, in_folder("c.pub"), why), 0);
    assert_int_equal(keys_read_secret(&secret, in_folder("c.key"), why), 0);
    assert_memory_equal(made.bytes, read.bytes, sizeof made.bytes);
    assert_memory_equal(made.bytes, secret.public_half.bytes, sizeof made.bytes);
    assert_string_equal(made.id, read.id);
    assert_int_equal(stat(in_folder("c.key"), &s), 0);
    assert_int_equal(s.st_mode & 0777, 0600);
    unlink(in_folder("c.key"));
    unlink(in_folder("c.pub"));
}

static void no_key_file_is_ever_overwritten(void **state)
{
    struct public_key made;
    struct stat before, after;
    char why[KEYS_WHY];
    (void)state;
    assert_int_equal(stat(in_folder("a.key"), &before), 0);
    assert_int_equal(keys_make(in_folder("a.key"), in_folder("new.pub"), &made, why), -EEXIST);
    assert_int_equal(access(in_folder("new.pub"), F_OK), -1);
    assert_int_equal(keys_make(in_folder("new.key"), in_folder("a.pub"), &made, why), -EEXIST);
    assert_int_equal(access(in_folder("new.key"), F_OK), -1);
    assert_int_equal(stat(in_folder("a.key"), &after), 0);
    assert_int_equal(before.st_mtim.tv_nsec, after.st_mtim.tv_nsec);
}

static void a_secret_that_others_can_read_is_refused(void **state)
{
    struct secret_key secret;
    char why[KEYS_WHY];
    (void)state;
    assert_int_equal(chmod(in_folder("b.key"), 0640), 0);
    assert_int_equal(keys_read_secret(&secret, in_folder("b.key"), why), -EPERM);
    assert_non_null(strstr(why, "chmod 600"));
    assert_int_equal(chmod(in_folder("b.key"), 0600), 0);
    assert_int_equal(keys_read_secret(&secret, in_folder("b.key"), why), 0);
}

static void halves_of_a_key_are_not_taken_for_each_other(void **state)
{
    struct secret_key secret;
    struct public_key public_half;
    char why[KEYS_WHY];
    (void)state;
    assert_int_equal(keys_read_public(&public_half, in_folder("a.key"), why), -EINVAL);
    assert_non_null(strstr(why, "is a secret key"));
    chmod(in_folder("a.pub"), 0600);
    assert_int_equal(keys_read_secret(&secret, in_folder("a.pub"), why), -EINVAL);
    assert_int_equal(keys_read_public(&public_half, folder, why), -EINVAL);
}

static void a_key_file_has_one_form_to_the_byte(void **state)
{
    char text[256];
    struct public_key public_half;
    FILE *file = fopen(in_folder("a.pub"), "r");
    (void)state;
    assert_non_null(file);
    const size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    assert_true(keys_parse_public(&public_half, text, size));
    for (size_t i = 0; i < size; i++) {
        assert_false(keys_parse_public(&public_half, text, i));
        struct public_key changed;
        text[i] ^= 1;
        if (keys_parse_public(&changed, text, size)) /* another key, never the same one */
            assert_memory_not_equal(changed.bytes, key.public_half.bytes, KEY_PUBLIC);
        text[i] ^= 1;
    }
}

/* --- what is signed --------------------------------------------------------------------------- */

static void a_certificate_says_what_the_report_said(void **state)
{
    static struct certificate read;
    const struct report report = passing();
    char why[CERTIFICATE_WHY], *text = certificate_of(&report);
    (void)state;
    assert_int_equal(certificate_open(&read, text, strlen(text), &key.public_half, why), 0);
    assert_string_equal(read.name, "gantry.tgm");
    assert_string_equal(read.module, report.sha256);
    assert_string_equal(read.tool, "tgm 0.1.0");
    assert_string_equal(read.program, PROGRAM);
    assert_string_equal(read.profile, "cert-1/pc4");
    assert_string_equal(read.rule_book, report.rule_book);
    assert_string_equal(read.evidence, report.evidence);
    assert_int_equal(read.passed.count, 2);
    assert_string_equal(read.passed.ids[1], "export-names");
    assert_int_equal(read.warned.count, 0);
    free(text);
}

static void the_same_report_and_key_give_the_same_bytes(void **state)
{
    const struct report report = passing();
    char *first = certificate_of(&report), *second = certificate_of(&report);
    (void)state;
    assert_string_equal(first, second);
    free(first);
    free(second);
}

static json_t *payload_of(const char *text)
{
    char why[ENVELOPE_WHY];
    size_t size;
    char *payload = envelope_open("application/vnd.in-toto+json", text, strlen(text),
                                  &key.public_half, &size, why);
    assert_non_null(payload);
    json_t *root = json_loadb(payload, size, 0, NULL);
    free(payload);
    assert_non_null(root);
    return root;
}

static void the_statement_is_an_in_toto_test_result(void **state)
{
    struct report report = passing();
    char *text = certificate_of(&report);
    json_t *root = payload_of(text);
    const char *type, *predicate, *result, *name, *hash;
    json_t *passed, *failed;
    (void)state;
    assert_int_equal(json_unpack(root, "{s:s, s:s, s:{s:s, s:o, s:o}, s:[{s:s, s:{s:s}}]}", "_type",
                                 &type, "predicateType", &predicate, "predicate", "result", &result,
                                 "passedTests", &passed, "failedTests", &failed, "subject", "name",
                                 &name, "digest", "sha256", &hash),
                     0);
    assert_string_equal(type, "https://in-toto.io/Statement/v1");
    assert_string_equal(predicate, "https://in-toto.io/attestation/test-result/v0.1");
    assert_string_equal(result, "PASSED");
    assert_string_equal(name, "gantry.tgm");
    assert_string_equal(hash, report.sha256);
    assert_int_equal(json_array_size(passed), 2);
    assert_int_equal(json_array_size(failed), 0);
    json_decref(root);
    free(text);
    rules[1].severity = SEVERITY_SHOULD;
    rules[1].outcome = RULE_FAILED;
    text = certificate_of(&report);
    root = payload_of(text);
    assert_int_equal(json_unpack(root, "{s:{s:s}}", "predicate", "result", &result), 0);
    assert_string_equal(result, "WARNED");
    json_decref(root);
    free(text);
    rules[1].severity = SEVERITY_MUST;
    rules[1].outcome = RULE_PASSED;
}

static void nothing_but_a_whole_pass_is_signed(void **state)
{
    static struct certificate certificate;
    char why[CERTIFICATE_WHY];
    struct report reports[9];
    (void)state;
    for (size_t i = 0; i < 9; i++)
        reports[i] = passing();
    reports[0].verdict = VERDICT_FAIL;
    reports[1].verdict = VERDICT_INCOMPLETE;
    reports[2].waiver_count = 1;
    reports[3].selection = "no-*";
    reports[4].cycles = 100;
    reports[5].evidence = NULL;
    reports[6].rule_book = NULL;
    reports[7].path = "\xFF.tgm";
    reports[8].config = "controller.ini";
    for (size_t i = 0; i < 9; i++)
        assert_false(certificate_fill(&certificate, &reports[i], "cert-1", PROGRAM, why));
}

/* --- tampering -------------------------------------------------------------------------------- */

static void every_changed_byte_is_refused(void **state)
{
    const struct report report = passing();
    char why[CERTIFICATE_WHY], *text = certificate_of(&report);
    const size_t size = strlen(text);
    unsigned refused = 0;
    (void)state;
    for (size_t i = 0; i < size; i++)
        for (unsigned bit = 0; bit < 8; bit++) {
            text[i] = (char)(text[i] ^ 1 << bit);
            why[0] = '\0';
            refused += open_it(text, size, &key.public_half, why) == -EINVAL && why[0] != '\0';
            text[i] = (char)(text[i] ^ 1 << bit);
        }
    assert_int_equal(refused, 8 * size);
    assert_int_equal(open_it(text, size, &key.public_half, why), 0);
    free(text);
}

static void bytes_more_or_less_are_refused(void **state)
{
    const struct report report = passing();
    char why[CERTIFICATE_WHY], *text = certificate_of(&report);
    const size_t size = strlen(text);
    char *longer = malloc(size + 1);
    (void)state;
    for (size_t i = 0; i < size; i++)
        assert_int_equal(open_it(text, i, &key.public_half, why), -EINVAL);
    for (size_t i = 0; i <= size; i++)
        for (const char *extra = " \n\ta,}0"; *extra != '\0'; extra++) {
            memcpy(longer, text, i);
            longer[i] = *extra;
            memcpy(longer + i + 1, text + i, size - i);
            assert_int_equal(open_it(longer, size + 1, &key.public_half, why), -EINVAL);
        }
    free(longer);
    free(text);
}

static void another_key_is_refused_and_named(void **state)
{
    const struct report report = passing();
    char why[CERTIFICATE_WHY], *text = certificate_of(&report);
    (void)state;
    assert_int_equal(open_it(text, strlen(text), &other.public_half, why), -EINVAL);
    assert_string_equal(why, "it names another key as its signer");
    /* who puts the expected name in has still not signed it */
    memcpy(strstr(text, key.public_half.id), other.public_half.id, KEY_ID - 1);
    assert_int_equal(open_it(text, strlen(text), &other.public_half, why), -EINVAL);
    assert_non_null(strstr(why, "the signature does not fit"));
    free(text);
}

static int open_statement(const char *statement, char why[CERTIFICATE_WHY])
{
    char *text = envelope_seal("application/vnd.in-toto+json", statement, strlen(statement), &key);
    const int r = open_it(text, strlen(text), &key.public_half, why);
    free(text);
    return r;
}

/* The key may have signed other things, too. */
static void signed_statements_of_another_kind_are_no_certificates(void **state)
{
    const struct report report = passing();
    char why[CERTIFICATE_WHY], *text = certificate_of(&report), *sealed;
    size_t size;
    (void)state;
    sealed = envelope_seal("application/octet-stream", "{}", 2, &key);
    assert_int_equal(open_it(sealed, strlen(sealed), &key.public_half, why), -EINVAL);
    assert_string_equal(why, "what it signs is of another kind");
    free(sealed);
    char *good = envelope_open("application/vnd.in-toto+json", text, strlen(text), &key.public_half,
                               &size, why);
    assert_int_equal(open_statement(good, why), 0);
    static const struct {
        const char *from, *to; /* of one length */
    } changes[] = { { "PASSED", "FAILED" },
                    { "test-result/v0.1", "test-result/v9.9" },
                    { "Statement/v1", "Statement/v2" },
                    { "\"failedTests\":[]", "\"failedTests\":{}" },
                    { "\"failedTests\"", "\"failedTasts\"" },
                    { "0123abcd", "0123ABCD" } };
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        char *changed = strdup(good), *at = strstr(changed, changes[i].from);
        assert_non_null(at);
        memcpy(at, changes[i].to, strlen(changes[i].to));
        assert_int_equal(open_statement(changed, why), -EINVAL);
        assert_string_equal(why, "it is signed, but it does not state that a module passed");
        free(changed);
    }
    free(good);
    free(text);
}

/* The envelope's signature is over the bytes that the standard says: made here without envelope.c.
 */
static void the_signature_is_that_of_the_standard(void **state)
{
    const char expected[] = "DSSEv1 29 http://example.com/HelloWorld 11 hello world";
    unsigned char signature[crypto_sign_BYTES];
    char base64[128];
    char *text = envelope_seal("http://example.com/HelloWorld", "hello world", 11, &key);
    (void)state;
    crypto_sign_detached(signature, NULL, (const unsigned char *)expected, strlen(expected),
                         key.bytes);
    sodium_bin2base64(base64, sizeof base64, signature, sizeof signature,
                      sodium_base64_VARIANT_ORIGINAL);
    assert_non_null(strstr(text, base64));
    assert_non_null(strstr(text, "\"payload\":\"aGVsbG8gd29ybGQ=\""));
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_key_read_back_is_the_key_that_was_made),
        cmocka_unit_test(no_key_file_is_ever_overwritten),
        cmocka_unit_test(a_secret_that_others_can_read_is_refused),
        cmocka_unit_test(halves_of_a_key_are_not_taken_for_each_other),
        cmocka_unit_test(a_key_file_has_one_form_to_the_byte),
        cmocka_unit_test(a_certificate_says_what_the_report_said),
        cmocka_unit_test(the_same_report_and_key_give_the_same_bytes),
        cmocka_unit_test(the_statement_is_an_in_toto_test_result),
        cmocka_unit_test(nothing_but_a_whole_pass_is_signed),
        cmocka_unit_test(every_changed_byte_is_refused),
        cmocka_unit_test(bytes_more_or_less_are_refused),
        cmocka_unit_test(another_key_is_refused_and_named),
        cmocka_unit_test(signed_statements_of_another_kind_are_no_certificates),
        cmocka_unit_test(the_signature_is_that_of_the_standard),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
