/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "bus/busfile.h"
#include "bus/faults.h"
#include "bus/live.h"
#include "bus/rack.h"
#include "bus/view.h"
#include "cli/capture.h"
#include "cli/cli.h"

#define NAMES_MAX 64
#define TABLE_NS  UINT64_C(100000000)  /* between two pictures on a terminal */
#define LINE_NS   UINT64_C(1000000000) /* between two lines on a pipe */

struct bus_show {
    const struct command *command;
    struct rack rack;
    struct faults *faults;
    struct live *live;
    struct capture capture;
    FILE *screen; /* standard error when the capture goes to standard output */
    bool terminal;
    size_t lines; /* of the picture on the terminal */
    struct live_counts counted;
    uint64_t counted_ns;
    double frames_a_second;
    struct view view[BUS_MAX_SLAVES], told[BUS_MAX_SLAVES];
};

static volatile sig_atomic_t stopped;

static void stop(int signal_number)
{
    (void)signal_number;
    stopped = 1;
}

/* --- what is shown ------------------------------------------------------------------------------
 */

static void print_bits(FILE *stream, const uint8_t *bytes, size_t count)
{
    if (count > 2)
        for (size_t i = count; i > 0; i--)
            fprintf(stream, "%02x", bytes[i - 1]);
    else
        for (size_t bit = 8 * count; bit > 0; bit--)
            fputc(bytes[(bit - 1) / 8] >> (bit - 1) % 8 & 1 ? '1' : '0', stream);
}

static void print_values(FILE *stream, const struct view *view)
{
    for (unsigned i = 0; i < view->axes && i < VIEW_AXES; i++)
        fprintf(stream, "  axis %u %" PRId32 " inc", i, view->position[i]);
    if (view->input_bytes > 0) {
        fputs("  in ", stream);
        print_bits(stream, view->input, view->input_bytes);
    }
    if (view->pin_bytes > 0) {
        fputs("  out ", stream);
        print_bits(stream, view->pins, view->pin_bytes);
    }
}

static void print_slave(FILE *stream, size_t position, const struct view *view)
{
    char station[8] = "-";
    if (view->station != 0)
        snprintf(station, sizeof station, "0x%04x", view->station);
    fprintf(stream, "  %3zu  %-32.32s  %-6s  %-10s", position, view->name, station, view->state);
    if (view->al_code != 0)
        fprintf(stream, "  0x%04X %s", view->al_code, view->code);
    else
        print_values(stream, view);
}

/* "2 OP, 1 SAFEOP+ERR" */
static void print_states(struct bus_show *show)
{
    const size_t count = show->rack.segment.count;
    const char *separator = "";
    for (size_t i = 0; i < count; i++) {
        size_t same = 0, before = 0;
        for (size_t k = 0; k < count; k++) {
            if (show->view[k].al_state != show->view[i].al_state)
                continue;
            same++;
            before += k < i;
        }
        if (before > 0)
            continue;
        fprintf(show->screen, "%s%zu %s", separator, same, show->view[i].state);
        separator = ", ";
    }
}

static void print_summary(struct bus_show *show)
{
    const struct live_counts *counts = live_counts(show->live);
    print_states(show);
    fprintf(show->screen, "  %.0f frames/s", show->frames_a_second);
    if (counts->wkc > 0)
        fprintf(show->screen, "  wkc %u", counts->wkc);
    if (counts->dropped > 0)
        fprintf(show->screen, "  %" PRIu64 " lost", counts->dropped);
}

/* Slaves that fit under each other; the picture must not scroll. */
static size_t table_rows(const struct bus_show *show)
{
    struct winsize size;
    const size_t count = show->rack.segment.count;
    if (ioctl(fileno(show->screen), TIOCGWINSZ, &size) != 0 || size.ws_row == 0)
        return count;
    const size_t room = size.ws_row > 3 ? size.ws_row - 3u : 0;
    return count <= room ? count : room;
}

/* Over the picture before it; lines are cut at the edge instead of wrapped. */
static void draw_table(struct bus_show *show)
{
    const size_t rows = table_rows(show), count = show->rack.segment.count;
    if (show->lines > 0)
        fprintf(show->screen, "\033[%zuA", show->lines);
    fprintf(show->screen, "\r\033[J\033[?7l%6.1f s  ", (double)live_now(show->live) * 1e-9);
    print_summary(show);
    fputc('\n', show->screen);
    for (size_t i = 0; i < rows; i++) {
        print_slave(show->screen, i + 1, &show->view[i]);
        fputc('\n', show->screen);
    }
    if (rows < count)
        fprintf(show->screen, "  and %zu more\n", count - rows);
    fputs("\033[?7h", show->screen);
    show->lines = 1 + rows + (rows < count);
}

/* Nothing is said while nothing happens. */
static void print_line(struct bus_show *show)
{
    bool changed = false;
    for (size_t i = 0; i < show->rack.segment.count; i++)
        changed = changed || show->view[i].al_state != show->told[i].al_state ||
                  show->view[i].al_code != show->told[i].al_code;
    if (!changed && show->frames_a_second <= 0)
        return;
    fprintf(show->screen, "  %.0f s  ", (double)live_now(show->live) * 1e-9);
    print_summary(show);
    for (size_t i = 0; i < show->rack.segment.count; i++)
        if (show->view[i].al_code != 0 && show->view[i].al_code != show->told[i].al_code)
            fprintf(show->screen, "; slave %zu (%s): 0x%04X %s", i + 1, show->view[i].name,
                    show->view[i].al_code, show->view[i].code);
    fputc('\n', show->screen);
    memcpy(show->told, show->view, sizeof show->told);
}

static void update(struct bus_show *show)
{
    const struct live_counts *counts = live_counts(show->live);
    const uint64_t now_ns = live_now(show->live);
    const uint64_t passed_ns = now_ns - show->counted_ns;
    if (passed_ns >= LINE_NS / 2) {
        show->frames_a_second =
            (double)(counts->received - show->counted.received) * 1e9 / (double)passed_ns;
        show->counted = *counts;
        show->counted_ns = now_ns;
    }
    for (size_t i = 0; i < show->rack.segment.count; i++)
        view_take(&show->rack.slaves[i], &show->view[i]);
    if (show->terminal)
        draw_table(show);
    else
        print_line(show);
    fflush(show->screen);
    /* Whoever reads the capture from a pipe sees it now; an error is told at the end. */
    if (capture_pcap(&show->capture) != NULL)
        pcap_flush(&show->capture.pcap);
}

/* --- from the words to the end ------------------------------------------------------------------
 */

static int serve(struct bus_show *show, uint64_t for_ns)
{
    const uint64_t period_ns = show->terminal ? TABLE_NS : LINE_NS;
    char why[LIVE_WHY];
    uint64_t next_ns = period_ns;
    int status = EXIT_OK;
    while (!stopped && live_now(show->live) < for_ns && status == EXIT_OK) {
        /* Short turns, so that a signal between two of them is heard soon. */
        uint64_t until_ns = live_now(show->live) + TABLE_NS;
        if (until_ns > next_ns)
            until_ns = next_ns;
        if (until_ns > for_ns)
            until_ns = for_ns;
        if (live_run(show->live, until_ns, why) != 0)
            status = complain(show->command, "%s", why);
        if (live_now(show->live) < next_ns)
            continue;
        update(show);
        next_ns = live_now(show->live) + period_ns;
    }
    const struct live_counts *counts = live_counts(show->live);
    fprintf(show->screen, "bus  %" PRIu64 " frames, %" PRIu64 " answered, %.1f s\n",
            counts->received, counts->answered, (double)live_now(show->live) * 1e-9);
    return status;
}

static uint64_t wall_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* Script time 0 is the moment the slaves begin to answer. */
static int open_faults(struct bus_show *show, const char *path, uint64_t seed)
{
    char why[FAULTS_WHY];
    char *text = read_text(show->command, "fault script", path);
    if (text == NULL)
        return EXIT_CALL;
    const int r =
        faults_open(&show->faults, text, strlen(text), path, &show->rack.segment, seed, why);
    free(text);
    if (r != 0)
        return complain(show->command, "%s", why);
    faults_begin(show->faults, 0);
    return 0;
}

static int open_and_serve(struct bus_show *show, struct live_config *config, const char *pcap,
                          uint64_t for_ns)
{
    const struct sigaction action = { .sa_handler = stop };
    char why[LIVE_WHY];
    struct wire wire = { .segment = &show->rack.segment, .faults = show->faults };
    config->wire = &wire;
    if (live_open(&show->live, config, why) != 0)
        return complain(show->command, "%s", why);
    int r = pcap != NULL ? capture_open(&show->capture, pcap, wall_ns()) : 0;
    if (r != 0)
        return complain(show->command, "cannot write '%s': %s", pcap, strerror(-r));
    wire.capture = capture_pcap(&show->capture);
    show->screen = show->capture.output.stream == stdout ? stderr : stdout;
    show->terminal = isatty(fileno(show->screen)) != 0;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    const size_t count = show->rack.segment.count;
    fprintf(show->screen, "bus  %zu slave%s on %s, waiting for a master\n", count,
            count == 1 ? "" : "s", config->interface);
    fflush(show->screen);
    int status = serve(show, for_ns);
    r = capture_close(&show->capture);
    if (r != 0)
        status = complain(show->command, "cannot write '%s': %s", pcap, strerror(-r));
    return status;
}

/* Input 0 of every terminal goes on and off, as in `tgm run` (H3). */
static const struct bus_stimulus button = { .bit = 0,
                                            .period_ns = 400000000,
                                            .phase_ns = 100000000 };

static int read_devices(const struct command *command, const char *const *words, int count,
                        struct bus_device *devices)
{
    const char *names[NAMES_MAX];
    char all[512] = "";
    size_t known = 0, at = 0;
    for (; known < NAMES_MAX && bus_device_type(known, NULL) != NULL && at < sizeof all; known++) {
        names[known] = bus_device_type(known, NULL);
        at += (size_t)snprintf(all + at, sizeof all - at, " %s", names[known]);
    }
    if (count == 0)
        return complain(command, "which devices? usage: tgm bus %s; there are:%s", command->usage,
                        all);
    for (int i = 0; i < count; i++) {
        size_t k = 0;
        while (k < known && strcmp(names[k], words[i]) != 0)
            k++;
        const char *close = k < known ? NULL : nearest(words[i], names, known);
        if (close != NULL)
            return complain(command, "no device type '%s' (did you mean %s?)", words[i], close);
        if (k == known)
            return complain(command, "no device type '%s'; there are:%s", words[i], all);
        devices[i] =
            (struct bus_device){ .type = words[i], .stimuli = &button, .stimulus_count = 1 };
    }
    return 0;
}

static bool is_bus_file(const char *const *words, int count)
{
    const size_t length = count == 1 ? strlen(words[0]) : 0;
    return length > 4 && strcmp(words[0] + length - 4, ".bus") == 0;
}

static int read_timing(const struct command *command, const char *word, enum live_timing *timing)
{
    *timing = strcmp(word, "real") == 0 ? LIVE_REAL : LIVE_AT_ONCE;
    if (*timing == LIVE_REAL || strcmp(word, "instant") == 0)
        return 0;
    return complain(command, "--timing must be instant or real, not '%s'", word);
}

int command_bus(const struct command *command, int argc, char **argv)
{
    static struct bus_show show;
    struct live_config live = { 0 };
    struct bus_device devices[BUS_MAX_SLAVES];
    struct bus_config config = { .devices = devices, .seed = DEFAULT_SEED };
    const char *words[BUS_MAX_SLAVES], *timing = "instant", *pcap = NULL, *faults = NULL;
    uint64_t for_ns = UINT64_MAX;
    const struct option table[] = {
        { "--interface", OPTION_TEXT, "NAME",
          "where the slaves answer: one end of a veth pair, a tap", &live.interface, 0, 0 },
        { "--for", OPTION_DURATION, "TIME", "as in 10s (default: until Ctrl-C)", &for_ns, 0, 0 },
        { "--pcap", OPTION_TEXT, "FILE", "capture for Wireshark, - for standard output", &pcap, 0,
          0 },
        { "--faults", OPTION_TEXT, "FILE", "what goes wrong, and when (docs/faults.md)", &faults, 0,
          0 },
        { "--timing", OPTION_TEXT, "HOW",
          "instant (default), or real: answers take their time on the wire", &timing, 0, 0 },
        { "--seed", OPTION_NUMBER, "N", "seed of the machine (default 0x1d2f)", &config.seed, 0,
          0 },
        { "--on-a-real-network", OPTION_FLAG, NULL,
          "take hardware, too: nothing else may listen there", &live.real_network, 0, 0 },
        { 0 },
    };
    char why[BUS_WHY];
    int count, status;
    show.command = command;
    if (!options_read(command, table, argc, argv, words, BUS_MAX_SLAVES, &count, &status))
        return status;
    struct busfile *file = NULL;
    if (is_bus_file(words, count)) {
        char what[LIBRARY_WHY];
        if (busfile_read(&file, words[0], what) != 0)
            return complain(command, "%s", what);
        config.devices = file->devices;
        config.library = file->library;
        config.device_count = file->device_count;
        if (file->redundant)
            return complain(command, "%s closes a ring: tgm bus has one end only", words[0]);
    } else {
        status = read_devices(command, words, count, devices);
        config.device_count = (size_t)count;
        if (status != 0)
            return status;
    }
    if ((status = read_timing(command, timing, &live.timing)) != 0)
        return status;
    if (live.interface == NULL)
        return complain(command, "which interface? usage: tgm bus %s", command->usage);
    if (rack_open(&show.rack, &config, why) != 0)
        return complain(command, "%s", why);
    status = faults != NULL ? open_faults(&show, faults, config.seed) : 0;
    if (status == 0)
        status = open_and_serve(&show, &live, pcap, for_ns);
    faults_close(show.faults);
    capture_close(&show.capture);
    live_close(show.live);
    rack_close(&show.rack);
    busfile_close(file);
    return status;
}
