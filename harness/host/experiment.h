/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * experiment.h - one run of one module under stated conditions, as data; its evidence.
 *
 * experiment_run() makes a worker process, in it a machine and a host, plays the experiment and
 * brings the evidence back, whatever the module does. The same experiment on the same file gives
 * the same evidence (wall times excepted: there are none in it).
 *
 * A capture (host_config.capture) is written in this process: the worker's frames come through its
 * pipe, and what is no frame is refused. The caller opens and closes it. Frames that a worker had
 * not sent when it was killed are missing.
 */
#ifndef HARNESS_HOST_EXPERIMENT_H
#define HARNESS_HOST_EXPERIMENT_H

#include <signal.h>

#include "host/host.h"
#include "machine/worker.h"

struct experiment {
    const char *name;        /* "cycle-500": stable, for reports and reproduction */
    struct host_config host; /* product, Cycle_Time, mutation, seed ... */
    uint64_t cycles;         /* 0: only Program_Ini is called */
    bool until_played;       /* no longer than until its scenario is at its end */
    uint64_t
        wall_ns; /* limit on the worker; 0 = 10 s, and 2 ms or two Cycle_Times a cycle; twelve
                    times that on the emulated CPU, and for cycles where interrupts are tried */
    uint64_t reload_ns; /* simulated time at which the PLC is run again (host_run); 0: never */
    enum machine_poison poison; /* MACHINE_POISON_NONE: the usual one, MACHINE_POISON_SEEDED */
    uint64_t places;            /* where things lie: machine_config */
    bool traced;                /* on the instrumented machine; what it sees is in evidence.audit */
    bool instrumented; /* on the emulated CPU; where a module runs natively nowhere, always */
    bool plain;        /* `tgm run` repeats it: nothing about it is out of the ordinary */
    bool real_clock;   /* slots come when they are due by the wall clock (realtime.h) */
    /* Ends the run with the cycle when it becomes true; NULL: nothing does. Needs a progress
     * function. */
    const volatile sig_atomic_t *stop;
};

/* What became of an experiment. */
struct experiment_result {
    struct evidence evidence; /* clean */
    struct worker_result worker;
};

/* Values of registers as they were right after Program_04, once a cycle (every `every` cycles).
 * With `osc` it is TG Motion's own oscilloscope that records, and its memory is read at the end;
 * the registers are then its channels. */
struct recording {
    const struct catalogue_register *registers;
    size_t count;
    unsigned every;
    const struct host_osc *osc;
};

/* Called in the parent: evidence while the worker runs (a snapshot that may be mid-change), and
 * recorded rows as they arrive: row_count rows of 1 + recording.count doubles, the first is the
 * time in seconds. */
typedef void experiment_progress(void *argument, const struct evidence *evidence,
                                 const double *rows, size_t row_count);

/* 0 with *result filled, or negative errno when no worker could be made. recording and progress may
 * be NULL. */
int experiment_run(const struct experiment *experiment, const struct image *image,
                   const struct recording *recording, experiment_progress *progress, void *argument,
                   struct experiment_result *result);

/*
 * The same in this process, for a debugger: no worker, no sandbox, no watchdog; a fault stays with
 * whoever debugs it. Calls tgm_debug_module_loaded() once the module is in place. 0, or negative
 * errno with the reason in evidence->trouble.
 */
int experiment_run_here(const struct experiment *experiment, const struct image *image,
                        struct evidence *evidence);

/* Where a debugger stops to learn where the module is: file, and what to add to its addresses. */
void tgm_debug_module_loaded(const char *path, uint64_t offset);

#endif
