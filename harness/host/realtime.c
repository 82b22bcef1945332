/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE 1
#include "host/realtime.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include "machine/machine.h"

#define PRIORITY 80 /* of SCHED_FIFO: above what people run, below the kernel's own threads */

struct realtime {
    struct evidence_clock *clock;
    uint64_t cycle_ns;
    uint64_t zero_ns; /* CLOCK_MONOTONIC when the schedule was at 0; wraps */
};

static uint64_t monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * UINT64_C(1000000000) + (uint64_t)now.tv_nsec;
}

/* The last processor that the process may use: interrupts and other programs prefer the first. */
static bool pin(void)
{
    cpu_set_t allowed, one;
    CPU_ZERO(&one);
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0)
        return false;
    for (size_t cpu = CPU_SETSIZE; cpu-- > 0;)
        if (CPU_ISSET(cpu, &allowed)) {
            CPU_SET(cpu, &one);
            return sched_setaffinity(0, sizeof one, &one) == 0;
        }
    return false;
}

static bool raise_priority(void)
{
    const struct sched_param parameter = { .sched_priority = PRIORITY };
    return sched_setscheduler(0, SCHED_FIFO, &parameter) == 0;
}

static void tell(struct evidence_clock *clock)
{
    const char *const missing[] = { clock->priority ? "" : " real-time priority",
                                    clock->locked ? "" : " locked memory",
                                    clock->pinned ? "" : " a processor of its own" };
    size_t used = 0;
    for (int i = 0; i < 3; i++)
        if (missing[i][0] != '\0')
            used += (size_t)snprintf(clock->notice + used, sizeof clock->notice - used, "%s%s",
                                     used > 0 ? "," : "no", missing[i]);
    if (used > 0)
        snprintf(clock->notice + used, sizeof clock->notice - used,
                 ": not permitted; the run shares the processor with everything else");
}

int realtime_open(struct realtime **out, struct machine *machine, uint32_t cycle_us,
                  struct evidence_clock *clock, char why[REALTIME_WHY])
{
    char reason[MACHINE_WHY];
    struct realtime *real = calloc(1, sizeof *real);
    int r = real != NULL ? machine_alarm_open(machine, reason) : -ENOMEM;
    if (r != 0) {
        snprintf(why, REALTIME_WHY, "no real clock: %s", strerror(-r));
        free(real);
        return r;
    }
    real->clock = clock;
    real->cycle_ns = cycle_us * UINT64_C(1000);
    clock->used = true;
    machine_timing(machine, true);
    *out = real;
    return 0;
}

void realtime_prepare(struct realtime *real)
{
    struct evidence_clock *clock = real->clock;
    clock->pinned = pin();
    clock->locked = mlockall(MCL_CURRENT) == 0;
    clock->priority = raise_priority();
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0); /* where the priority is an ordinary one */
    tell(clock);
}

void realtime_close(struct realtime *real)
{
    free(real);
}

static size_t bin_of(uint64_t us)
{
    if (us < LATENCY_FINE)
        return (size_t)us;
    const unsigned power = 63 - (unsigned)__builtin_clzll(us);
    const size_t bin = LATENCY_FINE + (power - 10) * 16 + (us >> (power - 4) & 15);
    return bin < LATENCY_BINS ? bin : LATENCY_BINS - 1;
}

uint64_t latency_bin_end(size_t bin)
{
    const size_t coarse = bin - LATENCY_FINE;
    return bin < LATENCY_FINE ? bin + 1 : (17 + coarse % 16) << (coarse / 16 + 6);
}

static void count(struct latency *latency, uint64_t late_ns)
{
    latency->count++;
    latency->bins[bin_of(late_ns / 1000)]++;
    if (late_ns > latency->max_ns)
        latency->max_ns = late_ns;
}

uint64_t latency_quantile(const struct latency *latency, double part)
{
    const double wanted = part * (double)latency->count;
    uint64_t seen = 0;
    for (size_t i = 0; i + 1 < LATENCY_BINS; i++) {
        seen += latency->bins[i];
        if ((double)seen >= wanted)
            return latency_bin_end(i) * UINT64_C(1000);
    }
    return latency->max_ns;
}

static uint64_t sleep_until(uint64_t moment)
{
    const struct timespec until = { .tv_sec = (time_t)(moment / UINT64_C(1000000000)),
                                    .tv_nsec = (long)(moment % UINT64_C(1000000000)) };
    uint64_t now = monotonic();
    while ((int64_t)(moment - now) > 0) {
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
        now = monotonic();
    }
    return now - moment;
}

void realtime_empty_loop(struct realtime *real, uint32_t slot_us, uint64_t duration_ns)
{
    const uint64_t begin = monotonic(), slot = slot_us * UINT64_C(1000);
    for (uint64_t at = slot; at <= duration_ns; at += slot)
        count(&real->clock->empty, sleep_until(begin + at));
}

void realtime_start(struct realtime *real, uint64_t schedule_ns)
{
    real->zero_ns = monotonic() - schedule_ns;
}

uint64_t realtime_wait(struct realtime *real, uint64_t schedule_ns)
{
    const uint64_t late = sleep_until(real->zero_ns + schedule_ns);
    count(&real->clock->slots, late);
    return late;
}

void realtime_pause(struct realtime *real, uint64_t schedule_ns)
{
    sleep_until(real->zero_ns + schedule_ns);
}

void realtime_sleep(struct realtime *real, uint64_t ns)
{
    (void)real;
    sleep_until(monotonic() + ns);
}

bool realtime_due(const struct realtime *real, uint64_t schedule_ns)
{
    return (int64_t)(monotonic() - real->zero_ns - schedule_ns) >= 0;
}

void realtime_cycle(struct realtime *real, uint64_t schedule_ns)
{
    const int64_t late = (int64_t)(monotonic() - real->zero_ns - schedule_ns);
    real->clock->cycles++;
    if (late < (int64_t)real->cycle_ns)
        return;
    real->clock->missed++;
    if (late >= (int64_t)REALTIME_GIVE_UP_NS) {
        const uint64_t cycles = (uint64_t)late / real->cycle_ns;
        real->clock->dropped += cycles;
        real->zero_ns += cycles * real->cycle_ns;
    }
}

void realtime_cycle_end(struct realtime *real, uint64_t schedule_ns)
{
    if ((int64_t)(monotonic() - real->zero_ns - schedule_ns) > 0)
        real->clock->overruns++;
}

void realtime_alarm(const struct realtime *real, struct machine *machine, uint64_t schedule_ns)
{
    machine_alarm_at(machine, real->zero_ns + schedule_ns);
}

uint64_t realtime_now(const struct realtime *real)
{
    (void)real;
    return monotonic();
}

void measure_begin(struct measured *measured, bool cycle_begins)
{
    const uint64_t now = monotonic();
    measured->begin_ns = now;
    if (!cycle_begins)
        return;
    measured->period_ns = measured->began_ns != 0 ? now - measured->began_ns : 0;
    measured->began_ns = now;
    measured->servo_last_ns = measured->servo_ns;
    measured->servo_ns = 0;
}

void measure_end(struct measured *measured)
{
    measured->servo_ns += monotonic() - measured->begin_ns;
}
