/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * trace.h - what an instrumented machine sees a module do, access by access.
 *
 * The callback runs on the host's stack in the middle of an instruction of the module: it may read
 * memory and write down what it wants, call nothing of the machine, and allocate nothing. Order is
 * the order of execution, and the same on every run.
 *
 * Seen are reads and writes by the module's own instructions that were allowed: one that is not is
 * the fault of the call. What a host service reads or writes
 * for it is not: the service knows that itself.
 */
#ifndef HARNESS_MACHINE_TRACE_H
#define HARNESS_MACHINE_TRACE_H

#include <stdbool.h>
#include <stdint.h>

/* trace_access.region of a write to the module's own code: to a byte that has been executed. (Where
 * code cannot be written, such a write is the fault of the call and not seen here.) */
#define TRACE_CODE UINT32_MAX

struct trace_access {
    uint64_t pc;          /* module address of the instruction */
    uint64_t instruction; /* how many this call had executed before it */
    uint64_t address;     /* as the module sees it */
    int64_t offset;       /* from the beginning of the region; of code: module address */
    uint32_t region;      /* in the order of machine_map() and machine_map_shared(), from 0 */
    unsigned size;        /* bytes, 1 to 8; wider accesses come in pieces, lowest address first */
    bool write;
    uint64_t value; /* what was read, or is about to be written: the low `size` bytes, rest zero */
};

typedef void trace_callback(void *argument, const struct trace_access *access);

/* Lives as long as the machine. */
struct machine_trace {
    trace_callback *access; /* of memory that machine_map() made, its slack included (offset
                               negative or past its size), and writes to own code */
    void *argument;
};

#endif
