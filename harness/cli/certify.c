/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/program.h"
#include "conformance/certificate.h"
#include "conformance/suite.h"

#define PATH_MOST 4096

struct call {
    const struct command *command;
    const char *module, *key, *profile;
    char certificate[PATH_MOST], evidence[PATH_MOST];
};

static int write_certificate(const struct call *call, const char *text)
{
    struct output output;
    int r = output_open(&output, call->certificate);
    if (r == 0) {
        fputs(text, output.stream);
        r = output_close(&output, true);
    }
    if (r != 0)
        return complain(call->command, "cannot write '%s': %s", call->certificate, strerror(-r));
    return EXIT_OK;
}

static int sign(const struct call *call, const struct report *report, const struct secret_key *key)
{
    static struct certificate certificate;
    char why[CERTIFICATE_WHY], program[CERTIFICATE_HASH];
    const int r = program_hash(program);
    if (r != 0)
        return complain(call->command, "cannot read this program's own file: %s", strerror(-r));
    if (!certificate_fill(&certificate, report, suite_latest()->name, program, why)) {
        complain(call->command, "%s", why);
        return report->verdict == VERDICT_FAIL         ? EXIT_MODULE
               : report->verdict == VERDICT_INCOMPLETE ? EXIT_INCOMPLETE
                                                       : EXIT_CALL;
    }
    char *text = certificate_sign(&certificate, key);
    if (text == NULL)
        return complain(call->command, "no memory");
    const int status = write_certificate(call, text);
    free(text);
    if (status == EXIT_OK)
        printf("%s  signed for %s with key %s\n%s  the evidence; who has it can judge again\n",
               call->certificate, certificate.profile, key->public_half.id, call->evidence);
    return status;
}

static int judge_and_sign(const struct call *call, const struct secret_key *key)
{
    char why[CHECK_WHY];
    struct check *check;
    struct check_options options = { .path = call->module,
                                     .tool = "tgm " TGM_VERSION_TEXT,
                                     .profile = profile_or_complain(call->command, call->profile),
                                     .evidence = call->evidence };
    if (options.profile == NULL)
        return EXIT_CALL;
    suite_apply(suite_latest(), &options);
    if (check_run(&check, &options, why) != 0)
        return complain(call->command, "%s", why);
    report_text(check_report(check), stdout, false);
    const int status = sign(call, check_report(check), key);
    check_free(check);
    return status;
}

/* MODULE.tgm.cert beside the module, unless said otherwise. */
static bool beside(char out[PATH_MOST], const char *given, const char *module, const char *ending)
{
    return snprintf(out, PATH_MOST, "%s%s", given != NULL ? given : module,
                    given != NULL ? "" : ending) < PATH_MOST;
}

int command_certify(const struct command *command, int argc, char **argv)
{
    struct call call = { .command = command, .profile = "pc4" };
    const char *to = NULL, *evidence = NULL;
    struct secret_key key;
    char why[KEYS_WHY];
    int words, status;
    const struct option table[] = {
        { "--key", OPTION_TEXT, "FILE",
          "the secret key to sign with (tgm keygen, docs/certificates.md)", &call.key, 0, 0 },
        { "--profile", OPTION_TEXT, "NAME",
          "the product it is for: pc4 (default), pc5, pc500, tgmmini, tgmcontroller or tgzmotion",
          &call.profile, 0, 0 },
        { "-o", OPTION_TEXT, "FILE", "the certificate (default: MODULE.tgm.cert)", &to, 0, 0 },
        { "--evidence", OPTION_TEXT, "DIR",
          "where the evidence is kept (default: MODULE.tgm.evidence)", &evidence, 0, 0 },
        { 0 },
    };
    if (!options_read(command, table, argc, argv, &call.module, 1, &words, &status))
        return status;
    if (words == 0 || call.key == NULL)
        return complain(command, "%s usage: tgm certify %s",
                        words == 0 ? "which module?" : "which --key?", command->usage);
    if (!beside(call.certificate, to, call.module, ".cert") ||
        !beside(call.evidence, evidence, call.module, ".evidence"))
        return complain(command, "the name is too long");
    if (same_file(call.certificate, call.module) || same_file(call.certificate, call.key))
        return complain(command, "-o '%s' is the module or the key itself", call.certificate);
    if (keys_read_secret(&key, call.key, why) != 0)
        return complain(command, "%s", why);
    status = judge_and_sign(&call, &key);
    keys_forget(&key);
    return status;
}
