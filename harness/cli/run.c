/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/capture.h"
#include "bus/busfile.h"
#include "cli/cli.h"
#include "cli/eeprom.h"
#include "cli/configuration.h"
#include "cli/clock.h"
#include "cli/machine.h"
#include "cli/path.h"
#include "cli/record.h"
#include "cli/scenario.h"
#include "conformance/check.h"
#include "conformance/profile.h"
#include "conformance/rules.h"
#include "host/can.h"

#define RUN_WHY 1024

/* As the command line has it. */
struct asked {
    const char *profile, *config, *bus, *faults, *can, *path, *preempt, *clock, *prefix;
    bool shm;
    uint64_t duration, cycle_us, seed, path_start_ns;
};

/* One run on its way: what was asked for and what has been shown so far. */
struct run {
    const struct command *command;
    const struct image *image;
    struct asked asked;
    struct configuration configuration;
    struct interp_path path;
    struct scenario *scenario;
    char *faults, *can;
    struct experiment experiment;
    struct record record;
    struct plant plant; /* with --bus */
    struct capture capture;
    const char *pcap_path;
    const char *scenario_path;
    const char *machine; /* --machine */
    struct eeprom_file eeprom;
    FILE *screen; /* standard error when recording or capture go to standard output */
    bool terminal;
    bool in_process;
    uint64_t messages_shown, faults_shown, lines_shown;
    double begin, shown_at;
};

/* Text from the module must not move the cursor or fake a line of ours: evidence_clean() took
 * controls out. */
static void show_message(const struct run *run, const struct evidence_message *message)
{
    if (message->cycle == EVIDENCE_NO_CYCLE)
        fprintf(run->screen, "%s  before the cycles  %-11s  %s\n", run->terminal ? "\r\033[K" : "",
                evidence_speaker(message), message->text);
    else
        fprintf(run->screen, "%s  cycle %-11" PRIu64 "  %-11s  %s\n",
                run->terminal ? "\r\033[K" : "", message->cycle, evidence_speaker(message),
                message->text);
}

static void show_fault(const struct run *run, const struct evidence_fault *fault)
{
    char when[32] = "before the cycles";
    if (fault->time_ns >= 0)
        snprintf(when, sizeof when, "%.6f s", (double)fault->time_ns * 1e-9);
    fprintf(run->screen, "%s  %-17s  %-11s  %s\n", run->terminal ? "\r\033[K" : "", when,
            "bus fault", fault->text);
}

static void show_line(const struct run *run, const struct evidence_line *line)
{
    char text[SCENARIO_TEXT], when[32];
    snprintf(when, sizeof when, "%.6f s", (double)line->time_ns * 1e-9);
    scenario_tell_line(run->experiment.host.scenario, line, text);
    fprintf(run->screen, "%s  %-17s  %-11s  %s\n", run->terminal ? "\r\033[K" : "", when,
            "scenario", text);
}

static int64_t message_time(const struct run *run, const struct evidence_message *message)
{
    if (message->cycle == EVIDENCE_NO_CYCLE)
        return -1;
    return (int64_t)(message->cycle * run->experiment.host.cycle_us * 1000);
}

enum event { EVENT_FAULT, EVENT_LINE, EVENT_MESSAGE, EVENTS };

/* Which kind of event is next, of those that have not been shown yet; EVENTS: none. */
static enum event next_event(const struct run *run, const struct evidence *evidence)
{
    const uint64_t faults = run->faults_shown, lines = run->lines_shown;
    const uint64_t messages = run->messages_shown;
    int64_t at[EVENTS] = { INT64_MAX, INT64_MAX, INT64_MAX }, first = INT64_MAX;
    enum event next = EVENTS;
    if (faults < evidence->fault_count && faults < EVIDENCE_FAULTS)
        at[EVENT_FAULT] = evidence->faults[faults].time_ns;
    if (lines < evidence->line_count && lines < EVIDENCE_LINES)
        at[EVENT_LINE] = (int64_t)evidence->lines[lines].time_ns;
    if (messages < evidence->message_count && messages < EVIDENCE_MESSAGES)
        at[EVENT_MESSAGE] = message_time(run, &evidence->messages[messages]);
    for (int i = 0; i < EVENTS; i++)
        if (at[i] < first) {
            first = at[i];
            next = (enum event)i;
        }
    return next;
}

/* What has not been shown yet, in the order of its times. */
static void show_events(struct run *run, const struct evidence *evidence)
{
    for (;;)
        switch (next_event(run, evidence)) {
        case EVENT_FAULT:
            show_fault(run, &evidence->faults[run->faults_shown++]);
            break;
        case EVENT_LINE:
            show_line(run, &evidence->lines[run->lines_shown++]);
            break;
        case EVENT_MESSAGE:
            show_message(run, &evidence->messages[run->messages_shown++]);
            break;
        default:
            return;
        }
}

static void show_status(struct run *run, const struct evidence *evidence)
{
    const double elapsed = check_seconds() - run->begin;
    const double simulated = (double)evidence->time_ns * 1e-9;
    char all[32] = "";
    if (!run->experiment.until_played) /* otherwise nobody knows how many there will be */
        snprintf(all, sizeof all, " of %" PRIu64, run->experiment.cycles);
    fprintf(run->screen, "%s  bus %s  cycle %" PRIu64 "%s  %.3f s  x%.0f real time",
            run->terminal ? "\r\033[K" : "", evidence->all_op ? "OP" : "starting",
            evidence->cycles_done, all, simulated, elapsed > 0 ? simulated / elapsed : 0.0);
    for (unsigned i = 0; i < evidence->axis_count; i++)
        fprintf(run->screen, "  SERVO[%u] %.1f inc", i, evidence->axis_position[i]);
    if (!run->terminal)
        fputc('\n', run->screen);
    fflush(run->screen);
}

static void progress(void *argument, const struct evidence *evidence, const double *rows,
                     size_t row_count)
{
    struct run *run = argument;
    if (row_count > 0)
        record_rows(&run->record, evidence, rows, row_count);
    const double now = check_seconds();
    if (now - run->shown_at < (run->terminal ? 0.1 : 1.0))
        return;
    run->shown_at = now;
    if (evidence->stage >=
        EVIDENCE_BETWEEN) /* a message that is being written is shown next time */
        show_events(run, evidence);
    show_status(run, evidence);
}

static int tell_incident(const struct run *run, const struct evidence_incident *incident,
                         const char *name)
{
    char text[FINDING_TEXT];
    struct finding finding = { 0 };
    const struct case_file file = { .image = run->image, .name = name };
    incident_describe(incident, text);
    fprintf(run->screen, "  %s", text);
    if (incident->cycle != EVIDENCE_NO_CYCLE)
        fprintf(run->screen, " in cycle %" PRIu64, incident->cycle);
    fputc('\n', run->screen);
    incident_place(incident, &finding, &file);
    if (finding.place[0] != '\0')
        fprintf(run->screen, "    %s\n", finding.place);
    return EXIT_MODULE;
}

/* What happened, and whether it was the module's fault. */
static int conclude(struct run *run, const struct experiment_result *result, const char *name)
{
    const struct evidence *evidence = &result->evidence;
    int status = EXIT_OK;
    show_events(run, evidence);
    if (evidence->fault_count > EVIDENCE_FAULTS)
        fprintf(run->screen, "  and %" PRIu64 " bus faults more\n",
                evidence->fault_count - EVIDENCE_FAULTS);
    if (evidence->message_count > EVIDENCE_MESSAGES)
        fprintf(run->screen, "  and %" PRIu64 " messages more\n",
                evidence->message_count - EVIDENCE_MESSAGES);
    show_status(run, evidence);
    if (run->terminal)
        fputc('\n', run->screen);
    for (unsigned i = 0; i < evidence->incident_count; i++)
        status = tell_incident(run, &evidence->incidents[i], name);
    if (evidence->instrumented)
        fprintf(run->screen, "  %s %s, run on the emulated CPU\n", run->image->format_name,
                run->image->target_name);
    interrupts_tell(run->screen, evidence, run->image);
    clock_tell(run->screen, &evidence->clock);
    if (evidence->trouble[0] != '\0')
        return complain(run->command, "%s", evidence->trouble);
    if (run->experiment.host.scenario != NULL) {
        const int played = scenario_conclude(run->screen, run->experiment.host.scenario,
                                             run->scenario_path, evidence);
        status = status == EXIT_OK ? played : status;
    }
    if (result->worker.end == WORKER_TIMEOUT || result->worker.end == WORKER_KILLED ||
        result->worker.end == WORKER_EXITED) {
        fprintf(run->screen, "  %s ended or blocked the process it ran in%s%s\n",
                entry_name(evidence->entry), result->worker.reason[0] != '\0' ? ": " : "",
                result->worker.reason);
        return EXIT_MODULE;
    }
    if (evidence->incident_count == 0 && evidence->calls[ENTRY_INI].last_value != 1) {
        fprintf(run->screen, "  Program_Ini returned %d: the start is aborted\n",
                (int)evidence->calls[ENTRY_INI].last_value);
        return EXIT_MODULE;
    }
    return status;
}

static int play(struct run *run, const char *path)
{
    struct experiment_result result;
    const char *slash = strrchr(path, '/');
    run->begin = run->shown_at = check_seconds();
    int r;
    if (run->in_process) {
        memset(&result, 0, sizeof result);
        experiment_run_here(&run->experiment, run->image, &result.evidence);
    } else {
        struct shm shm = { .count = 0 };
        char why[SHM_WHY];
        if (run->experiment.host.shm != NULL && shm_make(&shm, &run->experiment.host, why) != 0)
            return complain(run->command, "%s", why);
        stop_catch(&run->experiment, &shm);
        r = experiment_run(&run->experiment, run->image, record_recording(&run->record), progress,
                           run, &result);
        shm_remove(&shm);
        stop_restore();
        if (r != 0)
            return complain(run->command, "no worker process: %s", strerror(-r));
    }
    int status = conclude(run, &result, slash != NULL ? slash + 1 : path);
    if (eeprom_write(run->command, &run->eeprom, &result.evidence) != 0)
        status = EXIT_CALL;
    r = capture_close(&run->capture);
    if (r != 0 && r != -EBADMSG) /* that one is the worker's, and told */
        status = complain(run->command, "cannot write '%s': %s", run->pcap_path, strerror(-r));
    return record_finish(&run->record, &result.evidence, status, slash != NULL ? slash + 1 : path,
                         run->screen);
}

static int open_module(struct run *run, const struct profile *profile, const char *path,
                       struct image **image)
{
    char why[RUN_WHY], wanted[PROFILE_WANTED];
    if (image_open(image, path, why) != 0)
        return complain(run->command, "%s", why);
    run->image = *image;
    if ((*image)->defect[0] != '\0')
        fprintf(stderr, "tgm run: %s: %s\n", path, (*image)->defect);
    else if (!profile_loads(profile, *image))
        fprintf(stderr, "tgm run: %s: %s %s; %s is needed\n", path, (*image)->format_name,
                (*image)->target_name, profile_wanted(profile, wanted));
    else
        return 0;
    return EXIT_MODULE;
}

/* Stays until the end of the run: devices, library and stimuli are in it. */
static int read_bus(struct run *run, const char *path)
{
    static struct busfile *file;
    char why[LIBRARY_WHY];
    if (path == NULL)
        return 0;
    if (busfile_read(&file, path, why) != 0)
        return complain(run->command, "%s", why);
    run->plant = (struct plant){ .devices = file->devices,
                                 .device_count = file->device_count,
                                 .library = file->library,
                                 .redundant = file->redundant,
                                 .as_found = true };
    run->experiment.host.plant = &run->plant;
    return 0;
}

static int read_can(struct run *run, const char *path)
{
    static struct can can;
    char why[CAN_WHY];
    if (path == NULL)
        return 0;
    if ((run->can = read_text(run->command, "CAN script", path)) == NULL)
        return EXIT_CALL;
    if (can_open(&can, run->can, path, 1, why) != 0)
        return complain(run->command, "%s", why);
    run->experiment.host.can = run->can;
    run->experiment.host.can_name = path;
    return 0;
}

static int refuse_self(const struct run *run, const char *option, const char *file,
                       const char *module)
{
    return file != NULL && same_file(file, module)
               ? complain(run->command, "%s '%s' is the module itself", option, file)
               : 0;
}

static int open_files(struct run *run, const char *module)
{
    int status = refuse_self(run, "--csv", run->record.csv_path, module);
    if (status == 0)
        status = refuse_self(run, "--pcap", run->pcap_path, module);
    if (status == 0)
        status = refuse_self(run, "--plot", run->record.plot_path, module);
    if (status == 0)
        status = refuse_self(run, "--eeprom", run->eeprom.path, module);
    if (status != 0)
        return status;
    if (record_open(&run->record) != 0)
        return EXIT_CALL;
    const int r = run->pcap_path != NULL ? capture_open(&run->capture, run->pcap_path, 0) : 0;
    return r == 0 ? 0
                  : complain(run->command, "cannot write '%s': %s", run->pcap_path, strerror(-r));
}

static int start(struct run *run, const struct profile *profile, const char *path)
{
    struct image *image = NULL;
    int status = open_module(run, profile, path, &image);
    if (status == 0)
        status = machine_check(run->command, run->machine, image, &run->experiment);
    if (status == 0)
        status = open_files(run, path);
    const bool taken = run->record.csv.stream == stdout || run->capture.output.stream == stdout;
    run->screen = taken ? stderr : stdout;
    run->terminal = isatty(fileno(run->screen)) != 0;
    run->experiment.host.capture = capture_pcap(&run->capture);
    if (status == 0)
        status = play(run, path);
    record_close(&run->record);
    capture_close(&run->capture);
    if (image != NULL)
        image_close(image);
    return status;
}

static bool is_stdout(const char *path)
{
    return path != NULL && strcmp(path, "-") == 0;
}

/* As long as asked for, or as the scenario. */
static void plan_length(struct run *run, uint64_t duration)
{
    const uint32_t cycle_us = run->experiment.host.cycle_us;
    const uint64_t cycle_ns = cycle_us * UINT64_C(1000);
    if (duration == 0 && run->experiment.host.scenario != NULL) {
        run->experiment.until_played = true;
        run->experiment.cycles = scenario_cycles(run->experiment.host.scenario, cycle_us);
        return;
    }
    duration = duration != 0 ? duration : UINT64_C(2000000000);
    run->experiment.cycles = (duration + cycle_ns - 1) / cycle_ns;
}

/* What the product allows. */
static int choose_product(struct run *run, const struct product *product)
{
    struct asked *asked = &run->asked;
    struct host_config *host = &run->experiment.host;
    char allowed[128];
    int status;
    host->plant = &plant_default;
    if (asked->config != NULL && (status = configuration_open(&run->configuration, run->command,
                                                              asked->config, product, host)) != 0)
        return status;
    if (asked->cycle_us == 0)
        asked->cycle_us = host->cycle_us != 0 ? host->cycle_us : product->default_cycle_us;
    if (asked->cycle_us > UINT32_MAX || !product_allows_cycle(product, (uint32_t)asked->cycle_us)) {
        product_cycles_text(product, allowed, sizeof allowed);
        return complain(run->command, "--cycle must be %s, not %" PRIu64, allowed, asked->cycle_us);
    }
    host->product = product;
    host->cycle_us = (uint32_t)asked->cycle_us;
    host->seed = asked->seed;
    return 0;
}

/* What fits together. */
static int choose_ways(struct run *run)
{
    const struct asked *asked = &run->asked;
    struct experiment *experiment = &run->experiment;
    int status;
    if (is_stdout(run->record.csv_path) && is_stdout(run->pcap_path))
        return complain(run->command, "--csv and --pcap cannot both go to standard output");
    if ((status = record_choose(&run->record, run->command, &experiment->host)) != 0)
        return status;
    if (clock_read(run->command, asked->clock, experiment) != 0 ||
        machine_read(run->command, run->machine, experiment) != 0 ||
        (asked->preempt != NULL && preempt_read(run->command, asked->preempt, experiment) != 0) ||
        (asked->prefix != NULL && shm_prefix_check(run->command, asked->prefix) != 0))
        return EXIT_CALL;
    if (run->in_process && record_recording(&run->record) != NULL)
        return complain(run->command, "--in-process does not record");
    if (run->in_process && (experiment->real_clock || asked->shm || asked->prefix != NULL))
        return complain(run->command, "--in-process has no --clock real and no --shm");
    if (experiment->real_clock && asked->preempt != NULL)
        return complain(run->command,
                        "--preempt is for the virtual clock: the real one interrupts");
    experiment->host.shm = asked->prefix != NULL ? asked->prefix : asked->shm ? "" : NULL;
    experiment->host.resettable = true;
    experiment->name = "run";
    return 0;
}

static int read_faults(struct run *run, const char *path)
{
    if (path == NULL)
        return 0;
    if ((run->faults = read_text(run->command, "fault script", path)) == NULL)
        return EXIT_CALL;
    run->experiment.host.faults = run->faults;
    run->experiment.host.faults_name = path;
    return 0;
}

static int read_path(struct run *run, const char *path)
{
    const int status = path != NULL ? path_open(&run->path, run->command, path) : 0;
    if (path == NULL || status != 0)
        return status;
    run->experiment.host.path = &run->path;
    run->experiment.host.path_start_ns = run->asked.path_start_ns;
    return 0;
}

static int read_scenario(struct run *run, const struct product *product)
{
    if (run->scenario_path == NULL)
        return 0;
    run->scenario = scenario_from_file(run->command, run->scenario_path, product);
    run->experiment.host.scenario = run->scenario;
    return run->scenario != NULL ? 0 : EXIT_CALL;
}

static int read_files(struct run *run, const struct product *product)
{
    const struct asked *asked = &run->asked;
    int status = eeprom_read(run->command, &run->eeprom, &run->experiment.host);
    if (status == 0)
        status = read_can(run, asked->can);
    if (status == 0)
        status = read_faults(run, asked->faults);
    if (status == 0)
        status = read_path(run, asked->path);
    if (status == 0)
        status = read_bus(run, asked->bus);
    return status == 0 ? read_scenario(run, product) : status;
}

static void close_files(struct run *run)
{
    scenario_close(run->scenario);
    free(run->faults);
    free(run->can);
    path_close(&run->path);
    configuration_close(&run->configuration);
}

int command_run(const struct command *command, int argc, char **argv)
{
    static struct run run = { .asked = { .profile = "pc4",
                                         .clock = "virtual",
                                         .seed = DEFAULT_SEED,
                                         .path_start_ns = UINT64_C(1000000000) } };
    const char *module = NULL;
    const struct option table[] = {
        { "--for", OPTION_DURATION, "TIME",
          "simulated time, as in 500ms (default 2s, or as long as the scenario)",
          &run.asked.duration, 0, 0 },
        { "--cycle", OPTION_NUMBER, "US", "Cycle_Time in microseconds (default 500)",
          &run.asked.cycle_us, 0, 0 },
        { "--record", OPTION_TEXT, "NAMES",
          "registers to record, as in 'SERVO[0].Position,DIO[0].In0'", &run.record.registers, 0,
          0 },
        { "--csv", OPTION_TEXT, "FILE", "where the recording goes, - for standard output",
          &run.record.csv_path, 0, 0 },
        { "--plot", OPTION_TEXT, "FILE",
          "draw it: .png or .svg; without --record: where every servo is and is to be",
          &run.record.plot_path, 0, 0 },
        { "--osc", OPTION_TEXT, "NAMES", "record with TG Motion's oscilloscope instead",
          &run.record.osc, 0, 0 },
        { "--osc-every", OPTION_NUMBER, "N", "cycles from sample to sample (default 1)",
          &run.record.every, 1, UINT32_MAX },
        { "--osc-trigger", OPTION_TEXT, "WHEN", "start at an edge, as in 'DIO[0].In0 rising 0.5'",
          &run.record.trigger, 0, 0 },
        { "--osc-pretrigger", OPTION_NUMBER, "N", "samples from before the trigger (5.02: pc5)",
          &run.record.pretrigger, 1, 0xffffff },
        { "--pcap", OPTION_TEXT, "FILE", "capture of the bus for Wireshark, - for standard output",
          &run.pcap_path, 0, 0 },
        { "--seed", OPTION_NUMBER, "N", "seed of places, poison and machine (default 0x1d2f)",
          &run.asked.seed, 0, 0 },
        { "--bus", OPTION_TEXT, "FILE",
          "what stands on the bus (docs/bus-files.md); default: one drive, one 8/8 terminal",
          &run.asked.bus, 0, 0 },
        { "--faults", OPTION_TEXT, "FILE", "what goes wrong on the bus, and when (docs/faults.md)",
          &run.asked.faults, 0, 0 },
        { "--scenario", OPTION_TEXT, "FILE",
          "plays the machine and says what is expected of the module (docs/scenarios.md)",
          &run.scenario_path, 0, 0 },
        { "--eeprom", OPTION_TEXT, "FILE", "what is stored in the EEPROM; written anew when saved",
          &run.eeprom.path, 0, 0 },
        { "--can", OPTION_TEXT, "FILE", "what stands on the CAN bus (docs/can.md)", &run.asked.can,
          0, 0 },
        { "--path", OPTION_TEXT, "FILE", "a path for interpolator 0 (docs/path-files.md)",
          &run.asked.path, 0, 0 },
        { "--path-start", OPTION_DURATION, "TIME", "when it is started (default 1s)",
          &run.asked.path_start_ns, 0, 0 },
        { "--preempt", OPTION_TEXT, "HOW",
          "interrupt Program_01 to 03 by what is above them: seeded, or at=N for instruction N",
          &run.asked.preempt, 0, 0 },
        { "--reload-at", OPTION_DURATION, "TIME", "run the PLC again (Run sequence) at that time",
          &run.experiment.reload_ns, 0, 0 },
        { "--machine", OPTION_TEXT, "KIND",
          "native, or instrumented: an emulated CPU (default: native where the module can)",
          &run.machine, 0, 0 },
        { "--clock", OPTION_TEXT, "WHICH", "virtual (default), or real: the wall clock",
          &run.asked.clock, 0, 0 },
        { "--shm", OPTION_FLAG, NULL,
          "memories as POSIX shared memory: /TGM_System, /TGM_Servo ... (docs/running.md)",
          &run.asked.shm, 0, 0 },
        { "--shm-prefix", OPTION_TEXT, "TEXT", "the same with TEXT in front of the names",
          &run.asked.prefix, 0, 0 },
        { "--in-process", OPTION_FLAG, NULL,
          "no worker and no sandbox, for a debugger (make debug)", &run.in_process, 0, 0 },
        { "--config", OPTION_TEXT, "FILE",
          "configuration of TG Motion (docs/configuration.md); other options win",
          &run.asked.config, 0, 0 },
        { "--profile", OPTION_TEXT, "NAME", "which TG Motion to be: pc4 (default)",
          &run.asked.profile, 0, 0 },
        { 0 },
    };
    int words, status;
    run.command = command;
    if (!options_read(command, table, argc, argv, &module, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which module? usage: tgm run %s", command->usage);
    const struct profile *profile = profile_or_complain(command, run.asked.profile);
    if (profile == NULL)
        return EXIT_CALL;
    const struct product *product = product_find(profile->product);
    status = choose_product(&run, product);
    if (status == 0)
        status = choose_ways(&run);
    if (status == 0)
        status = read_files(&run, product);
    if (status == 0) {
        plan_length(&run, run.asked.duration);
        status = start(&run, profile, module);
    }
    close_files(&run);
    return status;
}
