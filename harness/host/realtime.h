/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * realtime.h - the schedule against the wall clock (CLOCK_MONOTONIC).
 *
 * One thread, on one processor, with real-time priority where the system permits it. What the
 * documents call priorities of tasks are levels of interruption in it: a timer interrupts
 * Program_01 to Program_03 when the next slot is due, as it does on a controller (decision R18).
 *
 * Nothing that was late is left out of the figures (R6): a slot that cannot begin in time begins
 * late, and the ones behind it follow at once until the schedule has caught up. A schedule that is
 * REALTIME_GIVE_UP_NS behind is moved by whole cycles, which are counted as dropped.
 */
#ifndef HARNESS_HOST_REALTIME_H
#define HARNESS_HOST_REALTIME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define REALTIME_WHY        160
#define REALTIME_GIVE_UP_NS UINT64_C(100000000)
/* Bins of a microsecond each below 1024 us, then sixteen to each power of two, up to a minute. */
#define LATENCY_FINE 1024
#define LATENCY_BINS (LATENCY_FINE + 16 * 16)

/* How late things began. */
struct latency {
    uint64_t count, max_ns;
    uint32_t bins[LATENCY_BINS];
};

/* What a run on the real clock tells (part of the evidence). */
struct evidence_clock {
    bool used;
    bool priority, pinned, locked; /* what the system permitted */
    char notice[REALTIME_WHY];     /* what it did not; "" */
    struct latency empty;          /* of an empty loop of the same period, before the run */
    struct latency slots;          /* of the slots of the run */
    uint64_t cycles;
    uint64_t overruns; /* cycles that were not over when the next one was due */
    uint64_t missed;   /* of them, so far over that the next began a whole cycle late or more */
    uint64_t dropped;  /* cycles that the schedule was moved by */
};

struct machine;
struct realtime;

/* Before the process is sealed: 0, or negative errno with a reason. */
int realtime_open(struct realtime **out, struct machine *machine, uint32_t cycle_us,
                  struct evidence_clock *clock, char why[REALTIME_WHY]);
void realtime_close(struct realtime *real);
/* When everything is in memory, and still before the seal: processor, memory and priority, as far
 * as the system permits them. */
void realtime_prepare(struct realtime *real);

/* Waits slot by slot as the run will, and does nothing else. */
void realtime_empty_loop(struct realtime *real, uint32_t slot_us, uint64_t duration_ns);

/* It is schedule_ns now. */
void realtime_start(struct realtime *real, uint64_t schedule_ns);
/* Waits for that moment of the schedule; how late it is, ns. */
uint64_t realtime_wait(struct realtime *real, uint64_t schedule_ns);
/* The same, not counted. */
void realtime_pause(struct realtime *real, uint64_t schedule_ns);
bool realtime_due(const struct realtime *real, uint64_t schedule_ns);
/* A cycle begins, and is over. */
void realtime_cycle(struct realtime *real, uint64_t schedule_ns);
void realtime_cycle_end(struct realtime *real, uint64_t schedule_ns);
/* Interrupts the machine's call when that moment has come. */
void realtime_alarm(const struct realtime *real, struct machine *machine, uint64_t schedule_ns);
/* CLOCK_MONOTONIC, ns */
uint64_t realtime_now(const struct realtime *real);
/* For so long; nothing else happens meanwhile. */
void realtime_sleep(struct realtime *real, uint64_t ns);

/* Where a bin ends, us. */
uint64_t latency_bin_end(size_t bin);
/* The latency that this part (0 to 1) of them did not exceed, ns. */
uint64_t latency_quantile(const struct latency *latency, double part);

#define MEASURED_INTERPOLATORS 3

/* How long things took in the latest cycle, ns: for the registers (measure.c). */
struct measured {
    uint64_t latency_ns; /* of the latest slot */
    uint64_t began_ns;   /* the latest cycle, and the part of TG Motion's own that is measured */
    uint64_t begin_ns;
    uint64_t period_ns;     /* from cycle to cycle */
    uint64_t servo_ns;      /* TG Motion's own work in the cycle, bus included */
    uint64_t servo_last_ns; /* in the one before */
    uint64_t bus_ns;        /* the port: sending and taking what has come back */
    uint64_t interpolator_ns[MEASURED_INTERPOLATORS]; /* the longest step */
};

static inline void measure_longest(uint64_t *longest, uint64_t ns)
{
    if (ns > *longest)
        *longest = ns;
}

void measure_begin(struct measured *measured, bool cycle_begins);
void measure_end(struct measured *measured);

#endif
