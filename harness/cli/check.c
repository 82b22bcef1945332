/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/capture.h"
#include "cli/cli.h"
#include "cli/configuration.h"
#include "cli/scenario.h"
#include "conformance/check.h"

static int status_of(enum verdict verdict)
{
    return verdict == VERDICT_PASS   ? EXIT_OK
           : verdict == VERDICT_FAIL ? EXIT_MODULE
                                     : EXIT_INCOMPLETE;
}

/* --pcap: one file an experiment, one open at a time. */
struct captures {
    const char *folder; /* NULL: none */
    struct capture current;
    char path[4096], failed[4096]; /* the file of now; the first that could not be written */
    int error;
};

static void note_error(struct captures *captures, int error)
{
    if (error == 0 || captures->error != 0)
        return;
    captures->error = error;
    memcpy(captures->failed, captures->path, sizeof captures->failed);
}

static struct pcap *next_capture(void *argument, const char *experiment)
{
    struct captures *captures = argument;
    note_error(captures, capture_close(&captures->current));
    const int length =
        snprintf(captures->path, sizeof captures->path, "%s/%s.pcap", captures->folder, experiment);
    if ((size_t)length >= sizeof captures->path)
        note_error(captures, -ENAMETOOLONG);
    else
        note_error(captures, capture_open(&captures->current, captures->path, 0));
    return capture_pcap(&captures->current);
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
    struct captures *captures = options->capture_argument;
    r = check_run(&check, options, why);
    note_error(captures, capture_close(&captures->current));
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
    if (captures->error != 0 &&
        captures->error != -EBADMSG) /* that one is the worker's, and told */
        status = complain(command, "cannot write '%s': %s", captures->failed,
                          strerror(-captures->error));
    check_free(check);
    return status;
}

static struct check_scenario scenarios[OPTION_TEXTS_MAX];

static bool read_scenarios(const struct command *command, struct check_options *options,
                           const struct option_texts *files)
{
    const struct product *product = product_find(options->profile->product);
    options->scenarios = scenarios;
    for (size_t i = 0; i < files->count; i++) {
        scenarios[i].path = files->texts[i];
        scenarios[i].scenario = scenario_from_file(command, files->texts[i], product);
        if (scenarios[i].scenario == NULL)
            return false;
        options->scenario_count++;
    }
    return true;
}

static void close_scenarios(const struct check_options *options)
{
    for (size_t i = 0; i < options->scenario_count; i++)
        scenario_close((struct scenario *)(uintptr_t)scenarios[i].scenario);
}

int command_check(const struct command *command, int argc, char **argv)
{
    static struct captures captures;
    static struct configuration configuration;
    struct host_config around = { 0 };
    struct check_options options = { .seed = DEFAULT_SEED,
                                     .tool = "tgm " TGM_VERSION_TEXT,
                                     .capture_argument = &captures };
    struct option_texts files = { .count = 0 };
    const char *profile = "pc4", *json = NULL, *module = NULL;
    uint64_t jobs = 0;
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
        { "--jobs", OPTION_NUMBER, "N", "experiments at the same time (default: one for each core)",
          &jobs, 1, 64 },
        { "--json", OPTION_TEXT, "FILE", "also write the verdict as JSON, - for standard output",
          &json, 0, 0 },
        { "--config", OPTION_TEXT, "FILE",
          "judge under this configuration of TG Motion (docs/configuration.md)",
          &options.around_path, 0, 0 },
        { "--pcap", OPTION_TEXT, "DIR", "captures of the bus for Wireshark, one file an experiment",
          &captures.folder, 0, 0 },
        { "--scenario", OPTION_TEXTS, "FILE",
          "what you expect of the module (docs/scenarios.md); may be given again", &files, 0, 0 },
        { "--no-color", OPTION_FLAG, NULL, "no colours, not even on a terminal", &no_colour, 0, 0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, &module, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which module? usage: tgm check %s", command->usage);
    if (captures.folder != NULL) {
        if (mkdir(captures.folder, 0777) != 0 && errno != EEXIST)
            return complain(command, "cannot make the folder '%s': %s", captures.folder,
                            strerror(errno));
        options.capture = next_capture;
    }
    options.path = module;
    options.jobs = (unsigned)jobs;
    options.profile = profile_or_complain(command, profile);
    if (options.profile == NULL)
        return EXIT_CALL;
    if (options.around_path != NULL) {
        status = configuration_open(&configuration, command, options.around_path,
                                    product_find(options.profile->product), &around);
        if (status != 0)
            return status;
        options.around = &around;
    }
    status = read_scenarios(command, &options, &files) ? run(command, &options, json, no_colour)
                                                       : EXIT_CALL;
    close_scenarios(&options);
    configuration_close(&configuration);
    return status;
}
