/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/clock.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#define TOLD_INTERRUPTS 8
#define BAR             40

int clock_read(const struct command *command, const char *text, struct experiment *experiment)
{
    static const char *const names[] = { "virtual", "real" };
    for (size_t i = 0; i < 2; i++)
        if (strcmp(text, names[i]) == 0) {
            experiment->real_clock = i == 1;
            return 0;
        }
    return complain(command, "--clock must be virtual or real, not '%s'", text);
}

int preempt_read(const struct command *command, const char *text, struct experiment *experiment)
{
    struct host_preempt *preempt = &experiment->host.preempt;
    char *end;
    if (strcmp(text, "seeded") == 0) {
        preempt->mode = PREEMPT_SEEDED;
        return 0;
    }
    if (strncmp(text, "at=", 3) == 0 && isdigit((unsigned char)text[3])) {
        errno = 0;
        preempt->mode = PREEMPT_AT;
        preempt->at = strtoull(text + 3, &end, 0);
        if (errno == 0 && *end == '\0' && preempt->at < UINT32_MAX)
            return 0;
    }
    return complain(command, "--preempt must be seeded, or at=N for instruction N, not '%s'", text);
}

int shm_prefix_check(const struct command *command, const char *prefix)
{
    if (strlen(prefix) > SHM_PREFIX || strchr(prefix, '/') != NULL)
        return complain(command, "--shm-prefix must be at most %d characters without '/', not '%s'",
                        SHM_PREFIX, prefix);
    return 0;
}

/* --- being told to stop ------------------------------------------------------------------------
 */

static volatile sig_atomic_t stopped;
static const struct shm *stop_shm;
static const int stop_signals[] = { SIGINT, SIGTERM, SIGHUP };
static struct sigaction stop_before[3];

/* Asked politely once: the run ends with the cycle and says what there is to say. */
static void on_stop(int sig)
{
    if (!stopped) {
        stopped = 1;
        return;
    }
    shm_unlink_names(stop_shm);
    signal(sig, SIG_DFL);
    raise(sig);
}

void stop_catch(struct experiment *experiment, const struct shm *shm)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_stop;
    stop_shm = shm;
    experiment->stop = &stopped;
    for (size_t i = 0; i < 3; i++)
        sigaction(stop_signals[i], &action, &stop_before[i]);
}

void stop_restore(void)
{
    for (size_t i = 0; i < 3; i++)
        sigaction(stop_signals[i], &stop_before[i], NULL);
}

/* --- the real clock ----------------------------------------------------------------------------
 */

static void tell_latency(FILE *screen, const char *name, const struct latency *l)
{
    fprintf(screen, "  %-16s %10" PRIu64 " %8.0f %8.0f %8.0f %10.1f\n", name, l->count,
            (double)latency_quantile(l, 0.5) * 1e-3, (double)latency_quantile(l, 0.99) * 1e-3,
            (double)latency_quantile(l, 0.999) * 1e-3, (double)l->max_ns * 1e-3);
}

/* How many were late by this much, us; to 0: or more. */
static uint64_t in_bins(const struct latency *l, uint64_t from, uint64_t to)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < LATENCY_BINS; i++)
        if (latency_bin_end(i) > from && (to == 0 || latency_bin_end(i) <= to))
            sum += l->bins[i];
    return sum;
}

static void print_bar(FILE *screen, uint64_t part, uint64_t all)
{
    static const char bar[] = "########################################";
    /* By decades: one in a million is still to be seen. */
    const double decades = all > 0 ? log10((double)all) + 1 : 1;
    const int length = part > 0 ? (int)ceil((log10((double)part) + 1) / decades * BAR / 2) : 0;
    fprintf(screen, " %9" PRIu64 " %-20.*s", part, length, bar);
}

static void tell_histogram(FILE *screen, const struct evidence_clock *clock)
{
    static const unsigned edges[] = { 0, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 0 };
    fprintf(screen, "  late by           empty loop                      slots\n");
    for (size_t i = 0; i + 1 < sizeof edges / sizeof *edges; i++) {
        const uint64_t empty = in_bins(&clock->empty, edges[i], edges[i + 1]);
        const uint64_t slots = in_bins(&clock->slots, edges[i], edges[i + 1]);
        if (empty + slots == 0)
            continue;
        if (edges[i + 1] == 0)
            fprintf(screen, "  %4u us and more", edges[i]);
        else
            fprintf(screen, "  %4u to %4u us ", edges[i], edges[i + 1]);
        print_bar(screen, empty, clock->empty.count);
        print_bar(screen, slots, clock->slots.count);
        fputc('\n', screen);
    }
}

void clock_tell(FILE *screen, const struct evidence_clock *clock)
{
    if (!clock->used)
        return;
    if (clock->notice[0] != '\0')
        fprintf(screen, "  notice: %s\n", clock->notice);
    fprintf(screen,
            "  real clock: %" PRIu64 " cycles, %" PRIu64 " overruns, %" PRIu64 " missed, %" PRIu64
            " dropped\n",
            clock->cycles, clock->overruns, clock->missed, clock->dropped);
    fprintf(screen, "  %-16s %10s %8s %8s %8s %10s\n", "late by, us", "count", "50 %", "99 %",
            "99.9 %", "at most");
    tell_latency(screen, "empty loop", &clock->empty);
    tell_latency(screen, "slots", &clock->slots);
    tell_histogram(screen, clock);
}

/* --- interrupts --------------------------------------------------------------------------------
 */

static void tell_interrupt(FILE *screen, const struct evidence_interrupt *interrupt,
                           const struct image *image)
{
    struct image_place place;
    image_where(image, interrupt->pc, &place);
    fprintf(screen, "  cycle %-8" PRIu64 " %s at +0x%" PRIx64, interrupt->cycle,
            entry_name(interrupt->entry), interrupt->pc);
    if (place.function != NULL)
        fprintf(screen, " (%s+%" PRIu64 ")", place.function, place.offset);
    if (place.file != NULL)
        fprintf(screen, " %s:%d", place.file, place.line);
    if (interrupt->instructions > 0)
        fprintf(screen, ", after %" PRIu64 " instructions", interrupt->instructions);
    const char *separator = " by ";
    for (int entry = ENTRY_COUNT - 1; entry > ENTRY_INI; entry--)
        if (interrupt->by & 1u << entry) {
            fprintf(screen, "%s%s", separator, entry_name((enum entry)entry));
            separator = ", ";
        }
    fputc('\n', screen);
}

void interrupts_tell(FILE *screen, const struct evidence *evidence, const struct image *image)
{
    const uint64_t stored = evidence->interrupt_count < EVIDENCE_INTERRUPTS
                                ? evidence->interrupt_count
                                : EVIDENCE_INTERRUPTS;
    if (stored == 0)
        return;
    fprintf(screen, "  %" PRIu64 " calls were interrupted; the first:\n",
            evidence->interrupt_count);
    for (uint64_t i = 0; i < stored && i < TOLD_INTERRUPTS; i++)
        tell_interrupt(screen, &evidence->interrupts[i], image);
}
