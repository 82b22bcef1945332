/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/program.h"
#include "conformance/certificate.h"
#include "conformance/check.h"
#include "conformance/rule_book.h"
#include "report/markup.h"

struct call {
    const struct command *command;
    const char *certificate, *module, *key, *evidence;
};

/* What does not hold. Returns EXIT_MODULE. */
static int refuse(const char *format, ...) __attribute__((format(printf, 1, 2)));
static int refuse(const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fputs("NOT VERIFIED: ", stdout);
    markup_plain(stdout, text);
    fputc('\n', stdout);
    return EXIT_MODULE;
}

static int open_certificate(const struct call *call, const struct public_key *key,
                            struct certificate *certificate)
{
    static char text[ENVELOPE_MOST + 1];
    char why[CERTIFICATE_WHY];
    FILE *file = fopen(call->certificate, "rb");
    const size_t size = file != NULL ? fread(text, 1, sizeof text, file) : 0;
    const int error = file == NULL ? errno : ferror(file) ? EIO : 0;
    if (file != NULL)
        fclose(file);
    if (error != 0)
        return complain(call->command, "cannot read '%s': %s", call->certificate, strerror(error));
    if (certificate_open(certificate, text, size, key, why) == 0)
        return EXIT_OK;
    return refuse("%s: %s", call->certificate, why);
}

static int check_module(const struct call *call, const struct certificate *certificate)
{
    char hash[FILE_HASH];
    const int r = file_hash(call->module, hash);
    if (r != 0)
        return complain(call->command, "cannot read '%s': %s", call->module, strerror(-r));
    if (strcmp(hash, certificate->module) == 0)
        return EXIT_OK;
    return refuse("%s is not the module that was certified: its sha256 is %s, the certificate is "
                  "for %s",
                  call->module, hash, certificate->module);
}

/* Every byte of it is what was signed for, and judged again it gives the same verdict. */
static int check_evidence(const struct call *call, const struct certificate *certificate)
{
    char path[4096], hash[FILE_HASH], why[CHECK_WHY];
    struct check *check;
    if (call->evidence == NULL)
        return EXIT_OK;
    if (snprintf(path, sizeof path, "%s/manifest.json", call->evidence) >= (int)sizeof path)
        return complain(call->command, "the name is too long");
    const int r = file_hash(path, hash);
    if (r != 0)
        return complain(call->command, "cannot read '%s': %s", path, strerror(-r));
    if (strcmp(hash, certificate->evidence) != 0)
        return refuse("%s was changed, or is of another check: its sha256 is %s, the certificate "
                      "is for %s",
                      path, hash, certificate->evidence);
    if (check_again(&check, call->evidence, &(struct check_changes){ .rules = NULL }, why) != 0)
        return refuse("%s: %s", call->evidence, why);
    const struct report *report = check_report(check);
    const bool same = strcmp(report->sha256, certificate->module) == 0 &&
                      strcmp(report->evidence, certificate->evidence) == 0;
    const enum verdict verdict = report->verdict;
    check_free(check);
    if (!same)
        return refuse("%s is the evidence of another module", call->evidence);
    if (verdict != VERDICT_PASS)
        return refuse("%s: judged again by this program it gives %s", call->evidence,
                      verdict_name(verdict));
    return EXIT_OK;
}

static void line(const char *label, const char *text)
{
    printf("  %-12s ", label);
    markup_plain(stdout, text);
    fputc('\n', stdout);
}

static void tell(const struct call *call, const struct certificate *certificate,
                 const struct public_key *key)
{
    char text[512], book[RULE_BOOK_HASH];
    line("module", certificate->name);
    line("sha256", certificate->module);
    snprintf(text, sizeof text, "%zu rules passed, %zu warned", certificate->passed.count,
             certificate->warned.count);
    line("result", text);
    for (size_t i = 0; i < certificate->warned.count; i++)
        line(i == 0 ? "warned" : "", certificate->warned.ids[i]);
    snprintf(text, sizeof text, "%s, sha256 %s", certificate->tool, certificate->program);
    line("judged by", text);
    rule_book_hash(book);
    snprintf(text, sizeof text, "%s, rule book %s%s", certificate->profile, certificate->rule_book,
             strcmp(book, certificate->rule_book) == 0 ? "" : " (not that of this program)");
    line("profile", text);
    snprintf(text, sizeof text, "%s%s", certificate->evidence,
             call->evidence != NULL ? ", unchanged; judged again: PASS"
                                    : ", not looked at (--evidence DIR)");
    line("evidence", text);
    line("signed by", key->id);
    printf("VERIFIED: this module passed %s, and nothing was changed since\n",
           certificate->profile);
}

static int verify(const struct call *call)
{
    static struct certificate certificate;
    struct public_key key;
    char why[KEYS_WHY];
    if (keys_read_public(&key, call->key, why) != 0)
        return complain(call->command, "%s", why);
    int status = open_certificate(call, &key, &certificate);
    if (status == EXIT_OK)
        status = check_module(call, &certificate);
    if (status == EXIT_OK)
        status = check_evidence(call, &certificate);
    if (status == EXIT_OK)
        tell(call, &certificate, &key);
    return status;
}

int command_verify(const struct command *command, int argc, char **argv)
{
    struct call call = { .command = command };
    const char *files[2] = { NULL, NULL };
    int words, status;
    const struct option table[] = {
        { "--key", OPTION_TEXT, "FILE", "the public key of who you trust", &call.key, 0, 0 },
        { "--evidence", OPTION_TEXT, "DIR", "look at the evidence, too", &call.evidence, 0, 0 },
        { 0 },
    };
    if (!options_read(command, table, argc, argv, files, 2, &words, &status))
        return status;
    if (words < 2)
        return complain(command, "%s usage: tgm verify %s",
                        words == 0 ? "which certificate?" : "which module?", command->usage);
    if (call.key == NULL)
        return complain(command, "whose --key? usage: tgm verify %s", command->usage);
    call.certificate = files[0];
    call.module = files[1];
    return verify(&call);
}
