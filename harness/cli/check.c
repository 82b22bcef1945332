/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/cli.h"
#include "conformance/check.h"

static int status_of(enum verdict verdict)
{
    return verdict == VERDICT_PASS   ? EXIT_OK
           : verdict == VERDICT_FAIL ? EXIT_MODULE
                                     : EXIT_INCOMPLETE;
}

static int run(const struct command *command, const struct check_options *options, const char *json,
               bool no_colour)
{
    char why[CHECK_WHY];
    struct check *check;
    struct output output = { 0 };
    if (json != NULL && same_file(json, options->path))
        return complain(command, "--json '%s' is the module itself", json);
    int r = json != NULL ? output_open(&output, json) : 0;
    if (r != 0)
        return complain(command, "cannot write '%s': %s", json, strerror(-r));
    r = check_run(&check, options, why);
    if (r != 0) {
        output_close(&output, false);
        return complain(command, "%s", why);
    }
    const struct report *report = check_report(check);
    const bool json_on_stdout = output.stream == stdout;
    FILE *stream = json_on_stdout ? stderr : stdout;
    const bool colour = !no_colour && getenv("NO_COLOR") == NULL && isatty(fileno(stream));
    int status = status_of(report->verdict);
    if (json != NULL) {
        r = report_json(report, output.stream);
        const int closed = output_close(&output, r == 0);
        if (r != 0 || closed != 0)
            status =
                complain(command, "cannot write '%s': %s", json, strerror(r != 0 ? -r : -closed));
    }
    report_text(report, stream, colour);
    check_free(check);
    return status;
}

int command_check(const struct command *command, int argc, char **argv)
{
    struct check_options options = { .seed = DEFAULT_SEED, .tool = "tgm " TGM_VERSION_TEXT };
    const char *profile = "pc4", *json = NULL, *module = NULL;
    bool no_colour = false;
    const struct option table[] = {
        { "--profile", OPTION_TEXT, "NAME", "what is demanded: pc4 (default)", &profile, 0, 0 },
        { "--rule", OPTION_TEXT, "PATTERN", "only the rules whose id matches, as in 'ini-*'",
          &options.rules, 0, 0 },
        { "--seed", OPTION_NUMBER, "N", "seed of places, poison and machine (default 0x1d2f)",
          &options.seed, 0, 0 },
        { "--cycles", OPTION_NUMBER, "N",
          "cycles at each Cycle_Time (default: 10 s of machine time)", &options.cycles, 1,
          100000000 },
        { "--json", OPTION_TEXT, "FILE", "also write the verdict as JSON, - for standard output",
          &json, 0, 0 },
        { "--no-color", OPTION_FLAG, NULL, "no colours, not even on a terminal", &no_colour, 0, 0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, &module, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which module? usage: tgm check %s", command->usage);
    options.path = module;
    options.profile = profile_or_complain(command, profile);
    return options.profile == NULL ? EXIT_CALL : run(command, &options, json, no_colour);
}
