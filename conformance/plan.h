/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * plan.h - experiments as rows of data, and what they are for one product and one call.
 *
 * Everything in which an experiment can differ from the usual run is a field of its row; plan.c
 * makes the experiment (host/experiment.h) of it. A new condition is a new field, three lines in
 * plan.c, and the rows that use it.
 */
#ifndef CONFORMANCE_PLAN_H
#define CONFORMANCE_PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include "host/experiment.h"

enum experiment_id {
#define EXPERIMENT(symbol, ...) EXPERIMENT_##symbol,
#include "conformance/experiments.def"
#undef EXPERIMENT
    EXPERIMENT_COUNT
};

/* Sets of experiments: bit n is experiment n. */
#define EXPERIMENT_SET(symbol) (UINT64_C(1) << EXPERIMENT_##symbol)

/* One line of experiments.def. */
struct experiment_row {
    const char *name;
    uint32_t cycle_us;     /* 0: only Program_Ini is called, no bus is made */
    uint32_t milliseconds; /* of machine time; 0: CHECK_SECONDS */
    uint32_t least_ms;     /* as long as that even where fewer cycles were asked for */
    int generation;        /* the only one that it is for; 0: any */
    struct mutation mutation;
    enum machine_poison poison; /* MACHINE_POISON_NONE: the usual one */
    uint64_t places;            /* not 0: module, stack and memories lie elsewhere */
    uint32_t data_bytes;        /* of TGM_Data; 0: as usual */
    uint32_t counters;          /* where ticks and timers begin to count */
    uint32_t restart_ms; /* machine time at which the PLC is run again without loading the file
                            again: globals hold what they held; 0: never */
    bool digest;         /* what it did to the registers is compared with others' */
    bool instrumented;   /* on the instrumented machine */
    bool traced;         /* there, and every access is written down (host/audit.h) */
    struct host_preempt preempt; /* how Program_01 to 03 are interrupted */
    bool usual_bus;              /* not under a configuration: its script is for plant_default */
    const char *faults; /* script of what goes wrong on the bus (docs/faults.md); NULL: nothing */
};

/* faults.S */
extern const char faults_lost_frame[], faults_lost_frames[], faults_late_frames[],
    faults_short_counter[], faults_cable[], faults_slave_reset[], faults_al_error[],
    faults_watchdog[], faults_drive_fault[], faults_stuck_input[], faults_clock_drift[],
    faults_drive_power[], faults_terminal_power[], faults_mailbox[];

/* How long a disturbed experiment is. */
#define DISTURBED_MS 1500

/* What an experiment became for this product and call. */
struct planned {
    struct experiment_row row;
    struct experiment experiment;
    bool inapplicable; /* not for this product, or not under this configuration */
};

struct check_options;

/* All of them, by enum experiment_id. */
void plan_experiments(const struct check_options *options, struct planned plan[EXPERIMENT_COUNT]);

#endif
