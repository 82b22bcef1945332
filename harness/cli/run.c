/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli/capture.h"
#include "bus/busfile.h"
#include "cli/cli.h"
#include "cli/eeprom.h"
#include "cli/configuration.h"
#include "cli/clock.h"
#include "cli/plot.h"
#include "cli/scope.h"
#include "conformance/profile.h"
#include "conformance/rules.h"
#include "host/can.h"

#define RECORD_MAX 64
#define RUN_WHY    1024

/* One run on its way: what was asked for and what has been shown so far. */
struct run {
    const struct command *command;
    const struct image *image;
    struct experiment experiment;
    struct catalogue_register registers[RECORD_MAX];
    struct recording recording;
    struct output csv;
    const char *csv_path;
    const char *plot_path;
    char plot_csv[32]; /* recorded here when only a picture is wanted, "" otherwise */
    struct host_osc osc;
    struct plant plant; /* with --bus */
    struct capture capture;
    const char *pcap_path;
    struct eeprom_file eeprom;
    FILE *screen; /* standard error when recording or capture go to standard output */
    bool terminal;
    bool in_process;
    uint64_t messages_shown, faults_shown;
    double begin, shown_at;
    int csv_error;
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

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

static int64_t message_time(const struct run *run, const struct evidence_message *message)
{
    if (message->cycle == EVIDENCE_NO_CYCLE)
        return -1;
    return (int64_t)(message->cycle * run->experiment.host.cycle_us * 1000);
}

/* Messages and faults that have not been shown yet, in the order of their times. */
static void show_events(struct run *run, const struct evidence *evidence)
{
    for (;;) {
        const bool message = run->messages_shown < evidence->message_count &&
                             run->messages_shown < EVIDENCE_MESSAGES;
        const bool fault =
            run->faults_shown < evidence->fault_count && run->faults_shown < EVIDENCE_FAULTS;
        const struct evidence_message *m = &evidence->messages[message ? run->messages_shown : 0];
        const struct evidence_fault *f = &evidence->faults[fault ? run->faults_shown : 0];
        if (!message && !fault)
            return;
        if (fault && (!message || f->time_ns <= message_time(run, m))) {
            show_fault(run, f);
            run->faults_shown++;
        } else {
            show_message(run, m);
            run->messages_shown++;
        }
    }
}

static void show_status(struct run *run, const struct evidence *evidence)
{
    const double elapsed = seconds() - run->begin;
    const double simulated = (double)evidence->time_ns * 1e-9;
    fprintf(run->screen, "%s  bus %s  cycle %" PRIu64 " of %" PRIu64 "  %.3f s  x%.0f real time",
            run->terminal ? "\r\033[K" : "", evidence->all_op ? "OP" : "starting",
            evidence->cycles_done, run->experiment.cycles, simulated,
            elapsed > 0 ? simulated / elapsed : 0.0);
    for (unsigned i = 0; i < evidence->axis_count; i++)
        fprintf(run->screen, "  SERVO[%u] %.1f inc", i, evidence->axis_position[i]);
    if (!run->terminal)
        fputc('\n', run->screen);
    fflush(run->screen);
}

/* The shortest decimal that reads back as the same number, so that equal runs give equal files. */
static void print_number(FILE *stream, double value)
{
    char text[32];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value || isnan(value))
            break;
    }
    fputs(text, stream);
}

static void write_rows(struct run *run, const double *rows, size_t row_count)
{
    const size_t width = 1 + run->recording.count;
    for (size_t i = 0; i < row_count; i++, rows += width) {
        fprintf(run->csv.stream, "%.6f", rows[0]);
        for (size_t k = 1; k < width; k++) {
            fputc(',', run->csv.stream);
            print_number(run->csv.stream, rows[k]);
        }
        fputc('\n', run->csv.stream);
    }
    if (ferror(run->csv.stream))
        run->csv_error = EXIT_CALL;
}

static void progress(void *argument, const struct evidence *evidence, const double *rows,
                     size_t row_count)
{
    struct run *run = argument;
    if (row_count > 0)
        write_rows(run, rows, row_count);
    const double now = seconds();
    if (now - run->shown_at < (run->terminal ? 0.1 : 1.0))
        return;
    run->shown_at = now;
    if (evidence->stage >=
        EVIDENCE_BETWEEN) /* a message that is being written is shown next time */
        show_events(run, evidence);
    show_status(run, evidence);
}

static const struct catalogue *catalogue_of(const struct run *run)
{
    const struct product *product = run->experiment.host.product;
    return catalogue_find(product->generation, (int)product->memory_id);
}

/* "SERVO[0].Position,SERVO[0].WritePosition" */
static int read_registers(struct run *run, const char *list)
{
    const struct product *product = run->experiment.host.product;
    const struct catalogue *catalogue = catalogue_of(run);
    char why[CATALOGUE_WHY];
    if (catalogue == NULL)
        return complain(run->command, "--record: no register names for %s", product->title);
    if (list[0] == '\0' || list[strlen(list) - 1] == ',')
        return complain(run->command, "--record needs register names with commas between them");
    while (*list != '\0') {
        char name[128];
        const size_t length = strcspn(list, ",");
        if (run->recording.count == RECORD_MAX)
            return complain(run->command, "--record takes at most %d registers", RECORD_MAX);
        if (length == 0 || length >= sizeof name)
            return complain(run->command,
                            "--record needs register names with commas between them, not '%s'",
                            list);
        memcpy(name, list, length);
        name[length] = '\0';
        if (catalogue_resolve(catalogue, name, &run->registers[run->recording.count], why) != 0)
            return complain(run->command, "--record: %s", why);
        if (!host_has_register(&run->experiment.host, &run->registers[run->recording.count]))
            return complain(run->command, "--record: %s is past the end of %s on %s", name,
                            run->registers[run->recording.count].memory->name, product->title);
        run->recording.count++;
        list += length + (list[length] == ',');
    }
    run->recording.registers = run->registers;
    run->recording.every = 1;
    return 0;
}

static void write_head(struct run *run, const char *list)
{
    fprintf(run->csv.stream, "time_s,%s\n", list);
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
    interrupts_tell(run->screen, evidence, run->image);
    clock_tell(run->screen, &evidence->clock);
    if (evidence->trouble[0] != '\0')
        return complain(run->command, "%s", evidence->trouble);
    if (result->worker.end == WORKER_TIMEOUT || result->worker.end == WORKER_KILLED ||
        result->worker.end == WORKER_EXITED) {
        fprintf(run->screen, "  %s ended or blocked the process it ran in\n",
                entry_name(evidence->entry));
        return EXIT_MODULE;
    }
    if (evidence->incident_count == 0 && evidence->calls[ENTRY_INI].last_value != 1) {
        fprintf(run->screen, "  Program_Ini returned %d: the start is aborted\n",
                (int)evidence->calls[ENTRY_INI].last_value);
        return EXIT_MODULE;
    }
    return status;
}

static int draw_plot(const struct run *run, const char *module)
{
    char title[FINDING_TEXT];
    const struct product *product = run->experiment.host.product;
    snprintf(title, sizeof title, "%s on %s, Cycle_Time %u us", module, product->title,
             run->experiment.host.cycle_us);
    return plot_draw(run->command, run->csv_path, run->plot_path, title, catalogue_of(run));
}

static int play(struct run *run, const char *path)
{
    struct experiment_result result;
    const char *slash = strrchr(path, '/');
    const bool recording = run->recording.count > 0;
    run->begin = run->shown_at = seconds();
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
        r = experiment_run(&run->experiment, run->image, recording ? &run->recording : NULL,
                           progress, run, &result);
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
    if (run->csv.stream != NULL) {
        r = output_close(&run->csv, status != EXIT_CALL); /* a call in vain replaces nothing */
        if (r != 0 || run->csv_error != 0)
            status = complain(run->command, "cannot write '%s': %s", run->csv_path,
                              r != 0 ? strerror(-r) : "write error");
        else if (run->plot_path != NULL && status != EXIT_CALL)
            r = draw_plot(run, slash != NULL ? slash + 1 : path);
        if (run->plot_path != NULL && r != 0)
            status = EXIT_CALL;
    }
    return status;
}

static int open_module(struct run *run, const struct profile *profile, const char *path,
                       struct image **image)
{
    char why[RUN_WHY];
    if (image_open(image, path, why) != 0)
        return complain(run->command, "%s", why);
    run->image = *image;
    if ((*image)->defect[0] != '\0')
        fprintf(stderr, "tgm run: %s: %s\n", path, (*image)->defect);
    else if ((*image)->format != profile->format || (*image)->target != profile->target)
        fprintf(stderr, "tgm run: %s: %s %s; %s is needed\n", path, (*image)->format_name,
                (*image)->target_name, profile->wanted);
    else
        return 0;
    return EXIT_MODULE;
}

/* Stays until the end of the run: devices, library and stimuli are in it. */
static int read_bus(struct run *run, const char *path)
{
    static struct busfile *file;
    char why[LIBRARY_WHY];
    if (busfile_read(&file, path, why) != 0)
        return complain(run->command, "%s", why);
    run->plant = (struct plant){ .devices = file->devices,
                                 .device_count = file->device_count,
                                 .library = file->library,
                                 .redundant = file->redundant,
                                 .as_found = true };
    return 0;
}

static int read_can(struct run *run, const char *path, char **script)
{
    static struct can can;
    char why[CAN_WHY];
    if (path == NULL)
        return 0;
    if ((*script = read_text(run->command, "CAN script", path)) == NULL)
        return EXIT_CALL;
    if (can_open(&can, *script, path, 1, why) != 0)
        return complain(run->command, "%s", why);
    run->experiment.host.can = *script;
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

/* A picture alone: the recording lies in a file of its own until it is drawn. */
static int make_plot_csv(struct run *run)
{
    snprintf(run->plot_csv, sizeof run->plot_csv, "/tmp/tgm-plot-XXXXXX");
    const int fd = mkstemp(run->plot_csv);
    if (fd < 0) {
        run->plot_csv[0] = '\0';
        return complain(run->command, "cannot make a temporary file: %s", strerror(errno));
    }
    close(fd);
    run->csv_path = run->plot_csv;
    return 0;
}

static int open_files(struct run *run, const char *module, const char *record)
{
    int status = refuse_self(run, "--csv", run->csv_path, module);
    if (status == 0)
        status = refuse_self(run, "--pcap", run->pcap_path, module);
    if (status == 0)
        status = refuse_self(run, "--eeprom", run->eeprom.path, module);
    if (status != 0)
        return status;
    if (run->plot_path != NULL && run->csv_path == NULL && make_plot_csv(run) != 0)
        return EXIT_CALL;
    const char *path = run->csv_path;
    int r = path != NULL ? output_open(&run->csv, path) : 0;
    if (r == 0 && path != NULL)
        write_head(run, record);
    if (r == 0 && run->pcap_path != NULL)
        r = capture_open(&run->capture, path = run->pcap_path, 0);
    return r == 0 ? 0 : complain(run->command, "cannot write '%s': %s", path, strerror(-r));
}

static int start(struct run *run, const struct profile *profile, const char *path,
                 const char *record)
{
    struct image *image = NULL;
    int status = open_module(run, profile, path, &image);
    if (status == 0)
        status = open_files(run, path, record);
    const bool taken = run->csv.stream == stdout || run->capture.output.stream == stdout;
    run->screen = taken ? stderr : stdout;
    run->terminal = isatty(fileno(run->screen)) != 0;
    run->experiment.host.capture = capture_pcap(&run->capture);
    if (status == 0)
        status = play(run, path);
    output_close(&run->csv, false);
    if (run->plot_csv[0] != '\0')
        unlink(run->plot_csv);
    capture_close(&run->capture);
    if (image != NULL)
        image_close(image);
    return status;
}

static bool is_stdout(const char *path)
{
    return path != NULL && strcmp(path, "-") == 0;
}

int command_run(const struct command *command, int argc, char **argv)
{
    static struct run run;
    const char *profile_name = "pc4", *record = NULL, *bus = NULL, *module = NULL, *faults = NULL;
    const char *osc = NULL, *osc_trigger = NULL, *config = NULL;
    static struct configuration configuration;
    uint64_t osc_every = 1, osc_before = 0;
    const char *can = NULL;
    char *script = NULL, *can_script = NULL;
    const char *preempt = NULL, *clock = "virtual", *prefix = NULL;
    bool shm = false;
    uint64_t duration = UINT64_C(2000000000), cycle_us = 0, seed = DEFAULT_SEED;
    const struct option table[] = {
        { "--for", OPTION_DURATION, "TIME", "simulated time, as in 2s or 500ms (default 2s)",
          &duration, 0, 0 },
        { "--cycle", OPTION_NUMBER, "US", "Cycle_Time in microseconds (default 500)", &cycle_us, 0,
          0 },
        { "--record", OPTION_TEXT, "NAMES",
          "registers to record, as in 'SERVO[0].Position,DIO[0].In0'", &record, 0, 0 },
        { "--csv", OPTION_TEXT, "FILE", "where the recording goes, - for standard output",
          &run.csv_path, 0, 0 },
        { "--plot", OPTION_TEXT, "FILE",
          "draw the recording: .png or .svg; without --record: where SERVO[0] goes", &run.plot_path,
          0, 0 },
        { "--osc", OPTION_TEXT, "NAMES", "record with TG Motion's oscilloscope instead", &osc, 0,
          0 },
        { "--osc-every", OPTION_NUMBER, "N", "cycles from sample to sample (default 1)", &osc_every,
          1, UINT32_MAX },
        { "--osc-trigger", OPTION_TEXT, "WHEN", "start at an edge, as in 'DIO[0].In0 rising 0.5'",
          &osc_trigger, 0, 0 },
        { "--osc-pretrigger", OPTION_NUMBER, "N", "samples from before the trigger (pc5)",
          &osc_before, 0, 0xffffff },
        { "--pcap", OPTION_TEXT, "FILE", "capture of the bus for Wireshark, - for standard output",
          &run.pcap_path, 0, 0 },
        { "--seed", OPTION_NUMBER, "N", "seed of places, poison and machine (default 0x1d2f)",
          &seed, 0, 0 },
        { "--bus", OPTION_TEXT, "FILE",
          "what stands on the bus (docs/bus-files.md); default: one drive, one 8/8 terminal", &bus,
          0, 0 },
        { "--faults", OPTION_TEXT, "FILE", "what goes wrong on the bus, and when (docs/faults.md)",
          &faults, 0, 0 },
        { "--eeprom", OPTION_TEXT, "FILE", "what is stored in the EEPROM; written anew when saved",
          &run.eeprom.path, 0, 0 },
        { "--can", OPTION_TEXT, "FILE", "what stands on the CAN bus (docs/can.md)", &can, 0, 0 },
        { "--preempt", OPTION_TEXT, "HOW",
          "interrupt Program_01 to 03 by what is above them: seeded, or at=N for instruction N",
          &preempt, 0, 0 },
        { "--reload-at", OPTION_DURATION, "TIME", "run the PLC again (Run sequence) at that time",
          &run.experiment.reload_ns, 0, 0 },
        { "--clock", OPTION_TEXT, "WHICH", "virtual (default), or real: the wall clock", &clock, 0,
          0 },
        { "--shm", OPTION_FLAG, NULL,
          "memories as POSIX shared memory: /TGM_System, /TGM_Servo ... (docs/running.md)", &shm, 0,
          0 },
        { "--shm-prefix", OPTION_TEXT, "TEXT", "the same with TEXT in front of the names", &prefix,
          0, 0 },
        { "--in-process", OPTION_FLAG, NULL,
          "no worker and no sandbox, for a debugger (make debug)", &run.in_process, 0, 0 },
        { "--config", OPTION_TEXT, "FILE",
          "configuration of TG Motion (docs/configuration.md); other options win", &config, 0, 0 },
        { "--profile", OPTION_TEXT, "NAME", "which TG Motion to be: pc4 (default)", &profile_name,
          0, 0 },
        { 0 },
    };
    int words, status;
    run.command = command;
    if (!options_read(command, table, argc, argv, &module, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which module? usage: tgm run %s", command->usage);
    const struct profile *profile = profile_or_complain(command, profile_name);
    if (profile == NULL)
        return EXIT_CALL;
    const struct product *product = product_find(profile->product);
    struct host_config *host = &run.experiment.host;
    host->plant = &plant_default;
    if (config != NULL &&
        (status = configuration_open(&configuration, command, config, product, host)) != 0)
        return status;
    if (cycle_us == 0)
        cycle_us = host->cycle_us != 0 ? host->cycle_us : product->default_cycle_us;
    if (cycle_us > UINT32_MAX || !product_allows_cycle(product, (uint32_t)cycle_us)) {
        char allowed[128];
        product_cycles_text(product, allowed, sizeof allowed);
        return complain(command, "--cycle must be %s, not %" PRIu64, allowed, cycle_us);
    }
    if (osc != NULL && record != NULL)
        return complain(command, "--osc and --record exclude each other");
    if (osc == NULL && (osc_trigger != NULL || osc_before != 0))
        return complain(command, "--osc-trigger and --osc-pretrigger belong to --osc");
    if (osc != NULL)
        record = osc;
    if (record == NULL && run.plot_path != NULL && run.csv_path == NULL)
        record = "SERVO[0].WritePosition,SERVO[0].Position,SERVO[0].Speed";
    if ((record == NULL) != (run.csv_path == NULL && run.plot_path == NULL))
        return complain(command,
                        "%s and --csv or --plot go together: which registers, and where to",
                        osc != NULL ? "--osc" : "--record");
    if (run.plot_path != NULL && is_stdout(run.csv_path))
        return complain(command, "--plot needs the recording in a file, not on standard output");
    if (run.plot_path != NULL && (status = plot_possible(command, run.plot_path)) != 0)
        return status;
    if (is_stdout(run.csv_path) && is_stdout(run.pcap_path))
        return complain(command, "--csv and --pcap cannot both go to standard output");
    if (run.in_process && record != NULL)
        return complain(command, "--in-process does not record");
    if (clock_read(command, clock, &run.experiment) != 0 ||
        (preempt != NULL && preempt_read(command, preempt, &run.experiment) != 0) ||
        (prefix != NULL && shm_prefix_check(command, prefix) != 0))
        return EXIT_CALL;
    if (run.in_process && (run.experiment.real_clock || shm || prefix != NULL))
        return complain(command, "--in-process has no --clock real and no --shm");
    if (run.experiment.real_clock && preempt != NULL)
        return complain(command, "--preempt is for the virtual clock: the real one interrupts");
    run.experiment.host.shm = prefix != NULL ? prefix : shm ? "" : NULL;
    run.experiment.host.resettable = true;
    run.experiment.host.product = product;
    if (record != NULL && (status = read_registers(&run, record)) != 0)
        return status;
    if (osc != NULL) {
        run.osc = (struct host_osc){ .channels = run.registers,
                                     .count = run.recording.count,
                                     .every = (uint32_t)osc_every,
                                     .pretrigger = (uint32_t)osc_before };
        run.recording.osc = &run.osc;
        if (osc_trigger != NULL &&
            (status = scope_read_trigger(command, catalogue_of(&run), osc_trigger, &run.osc)) != 0)
            return status;
    }
    if ((status = eeprom_read(command, &run.eeprom, &run.experiment.host)) != 0 ||
        (status = read_can(&run, can, &can_script)) != 0)
        return status;
    if (faults != NULL && (script = read_text(command, "fault script", faults)) == NULL)
        return EXIT_CALL;
    if (faults != NULL) {
        host->faults = script;
        host->faults_name = faults;
    }
    run.experiment.name = "run";
    run.experiment.host.cycle_us = (uint32_t)cycle_us;
    run.experiment.host.seed = seed;
    if (bus != NULL && (status = read_bus(&run, bus)) != 0)
        return status;
    if (bus != NULL)
        host->plant = &run.plant;
    run.experiment.cycles = (duration + cycle_us * 1000 - 1) / (cycle_us * 1000);
    status = start(&run, profile, module, record);
    free(script);
    free(can_script);
    configuration_close(&configuration);
    return status;
}
