/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * plc.h - PLC control: load, run, stop, pause, reset (docs/decisions.md, R1).
 *
 * Whoever controls the PLC writes MAIN.PLC_Ctrl and MAIN.TGM_TgMotionCmd: Observer, another program
 * on the shared memories, a scenario through host_run() and its like, the module itself. They are
 * read when a cycle begins and no function of the module is under way. The Run sequence:
 *
 *   1    no function is called any more; those that were interrupted or sleep come to
 *        their ends
 *   2-4  TGM_Data, digital outputs of I/O units and drives, and SERVO.Mode become 0; the loop runs
 *        on for PLC_CLEAR_NS, so that the slaves get to know
 *   5    the loop stops: no frames, for at least PLC_LOAD_NS
 *   6-7  the module is loaded; the loop runs again, and the bus is brought back to OP
 *   8    Program_Ini; on 1 the cyclic calls begin
 *
 * Steps take whole cycles. The last but one ends at a multiple of PLC_LOAD_STEP_NS, so that
 * milliseconds and cycles meet as they did at the first start.
 */
#ifndef HARNESS_HOST_PLC_H
#define HARNESS_HOST_PLC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"

#define PLC_CLEAR_NS     UINT64_C(10000000)
#define PLC_LOAD_NS      UINT64_C(200000000) /* longer than the slaves' watchdogs */
#define PLC_LOAD_STEP_NS UINT64_C(10000000)

enum plc_step {
    PLC_STOPPED,
    PLC_ENDING,   /* step 1 waits for functions that are asleep */
    PLC_CLEARING, /* steps 1 to 4 are done */
    PLC_LOADING,  /* the loop stands */
    PLC_RUNNING
};

struct plc {
    enum plc_step step;
    uint64_t until;     /* cycle in which the step ends */
    uint64_t run_cycle; /* the first one with cyclic calls */
    bool leave;         /* TG Motion is to end */
    bool anew;          /* TG Motion is to begin anew */
    bool bus_reset;     /* slaves are being sent to INIT, this one at present: */
    size_t bus_slave;
    struct bus_job job;
    uint16_t name[512]; /* MAIN.PLC_Name of the module that this host was made for */
};

#endif
