/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/capture.h"
#include "cli/cli.h"
#include "cli/configuration.h"
#include "cli/reports.h"
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

/* The reports of a check that is done, and its status. */
static int tell(const struct command *command, struct report_files *files, struct check *check,
                FILE *stream, bool no_colour)
{
    const struct report *report = check_report(check);
    const bool colour = !no_colour && getenv("NO_COLOR") == NULL && isatty(fileno(stream));
    int status = status_of(report->verdict);
    if (report_files_write(files, command, report) != 0)
        status = EXIT_CALL;
    report_text(report, stream, colour);
    check_free(check);
    return status;
}

/* The verdict is the same; who judges hostile modules wants to know all the same. */
static void tell_lacks(const struct check *check)
{
    const unsigned lacks = check_lacks(check);
    const char *separator = "";
    if (lacks == 0)
        return;
    fprintf(stderr, "tgm check: note: this kernel does not give the sandbox ");
    for (unsigned i = 0; worker_layer_name(i) != NULL; i++)
        if ((lacks >> i & 1) != 0) {
            fprintf(stderr, "%s%s", separator, worker_layer_name(i));
            separator = ", ";
        }
    fprintf(stderr, "; the system call filter stands without\n");
}

static int run(const struct command *command, const struct check_options *options,
               struct report_files *files, bool no_colour)
{
    char why[CHECK_WHY];
    struct check *check;
    if (report_files_open(files, command, options->path) != 0)
        return EXIT_CALL;
    FILE *stream = report_files_take_stdout(files) ? stderr : stdout;
    struct captures *captures = options->capture_argument;
    const int r = check_run(&check, options, why);
    note_error(captures, capture_close(&captures->current));
    if (r != 0) {
        report_files_drop(files);
        return complain(command, "%s", why);
    }
    tell_lacks(check);
    const int status = tell(command, files, check, stream, no_colour);
    if (captures->error != 0 &&
        captures->error != -EBADMSG) /* that one is the worker's, and told */
        return complain(command, "cannot write '%s': %s", captures->failed,
                        strerror(-captures->error));
    return status;
}

/* What belongs to a run cannot be asked of evidence that is there. */
static bool asks_for_a_run(const struct command *command, int argc, char **argv)
{
    static const char *const names[] = { "--profile", "--seed", "--cycles",   "--jobs",
                                         "--config",  "--pcap", "--scenario", "--evidence" };
    for (int i = 0; i < argc; i++)
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            if (strncmp(argv[i], names[k], strcspn(argv[i], "=")) == 0 &&
                strcspn(argv[i], "=") == strlen(names[k])) {
                complain(command, "%s is settled: --from-evidence runs nothing", names[k]);
                return true;
            }
    return false;
}

static int run_again(const struct command *command, const struct check_options *options,
                     const char *folder, struct report_files *files, bool no_colour)
{
    char why[CHECK_WHY], manifest[4352];
    struct check *check;
    const struct check_changes changes = { .rules = options->rules,
                                           .strict = options->strict,
                                           .waivers = options->waivers };
    snprintf(manifest, sizeof manifest, "%s/manifest.json", folder);
    if (report_files_open(files, command, manifest) != 0)
        return EXIT_CALL;
    FILE *stream = report_files_take_stdout(files) ? stderr : stdout;
    if (check_again(&check, folder, &changes, why) != 0) {
        report_files_drop(files);
        return complain(command, "%s", why);
    }
    return tell(command, files, check, stream, no_colour);
}

static bool read_waivers(const struct command *command, const char *path, struct waivers *waivers)
{
    char why[WAIVERS_WHY];
    char *text = read_text(command, "waivers", path);
    if (text == NULL)
        return false;
    const int r = waivers_read(waivers, text, strlen(text), path, why);
    free(text);
    if (r != 0)
        complain(command, "%s", why);
    return r == 0;
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
        scenarios[i].text = read_text(command, "scenario", files->texts[i]);
        if (scenarios[i].text == NULL)
            return false;
        options->scenario_count++;
    }
    return true;
}

static void close_scenarios(const struct check_options *options)
{
    for (size_t i = 0; i < options->scenario_count; i++) {
        scenario_close((struct scenario *)(uintptr_t)scenarios[i].scenario);
        free((void *)(uintptr_t)scenarios[i].text);
    }
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
    struct report_files reports = { .paths = { NULL } };
    struct option_texts patterns = { .count = 0 };
    static struct waivers waivers;
    static char selection[PATTERNS_MAX];
    char lone[RULE_PATTERN];
    const char *profile = "pc4", *module = NULL, *waive = NULL, *saved = NULL;
    uint64_t jobs = 0;
    bool no_colour = false;
    const struct option table[] = {
        { "--profile", OPTION_TEXT, "NAME",
          "what is demanded: pc4 (default), pc5, pc500, tgmmini, tgmcontroller or tgzmotion",
          &profile, 0, 0 },
        { "--rule", OPTION_TEXTS, "PATTERN",
          "only the rules whose id matches, as in 'ini-*'; '!PATTERN': not those; may be given "
          "again",
          &patterns, 0, 0 },
        { "--strict", OPTION_FLAG, NULL, "what a module should keep counts as what it must",
          &options.strict, 0, 0 },
        { "--waive", OPTION_TEXT, "FILE",
          "failures that somebody answers for, until a day (docs/checking.md)", &waive, 0, 0 },
        { "--evidence", OPTION_TEXT, "DIR",
          "save what was seen, to judge it again without a run (docs/checking.md)",
          &options.evidence, 0, 0 },
        { "--from-evidence", OPTION_TEXT, "DIR",
          "judge what was saved there: no MODULE, and nothing is run", &saved, 0, 0 },
        { "--seed", OPTION_NUMBER, "N", "seed of places, poison and machine (default 0x1d2f)",
          &options.seed, 0, 0 },
        { "--cycles", OPTION_NUMBER, "N",
          "cycles at each Cycle_Time (default: 10 s of machine time)", &options.cycles, 1,
          100000000 },
        { "--jobs", OPTION_NUMBER, "N", "experiments at the same time (default: one for each core)",
          &jobs, 1, 64 },
        { "--json", OPTION_TEXT, "FILE", "also write the verdict as JSON, - for standard output",
          &reports.paths[REPORT_JSON], 0, 0 },
        { "--junit", OPTION_TEXT, "FILE", "also as JUnit XML, for a CI system",
          &reports.paths[REPORT_JUNIT], 0, 0 },
        { "--sarif", OPTION_TEXT, "FILE", "also as SARIF 2.1.0, for code viewers",
          &reports.paths[REPORT_SARIF], 0, 0 },
        { "--html", OPTION_TEXT, "FILE", "also as one HTML page (docs/reports.md)",
          &reports.paths[REPORT_HTML], 0, 0 },
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
    if (!patterns_join(command, &patterns, selection, &options.rules) ||
        (waive != NULL && !read_waivers(command, waive, &waivers)))
        return EXIT_CALL;
    options.waivers = waive != NULL ? &waivers : NULL;
    if (saved != NULL)
        return words != 0 ? complain(command, "--from-evidence has its module with it: no MODULE")
               : asks_for_a_run(command, argc, argv)
                   ? EXIT_CALL
                   : run_again(command, &options, saved, &reports, no_colour);
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
    if (files.count == 0 && rule_pattern_needs_scenario(options.rules, lone))
        return complain(command, "the rule that matches '%s' needs --scenario FILE", lone);
    if (options.around_path != NULL) {
        status = configuration_open(&configuration, command, options.around_path,
                                    product_find(options.profile->product), &around);
        if (status != 0)
            return status;
        options.around = &around;
    }
    status = read_scenarios(command, &options, &files) ? run(command, &options, &reports, no_colour)
                                                       : EXIT_CALL;
    close_scenarios(&options);
    configuration_close(&configuration);
    return status;
}
