/* SPDX-License-Identifier: GPL-2.0-or-later */
/* confine.h - what a worker gives up before it runs anything. Only worker.c calls this. */
#ifndef HARNESS_MACHINE_CONFINE_H
#define HARNESS_MACHINE_CONFINE_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

struct confinement {
    pid_t parent;          /* die when it does */
    uint64_t memory_bytes; /* address space above what there is now */
    uint64_t cpu_seconds;  /* of processor time, 0: no end */
    bool real_time;        /* keeps what it takes to run at a priority of its own */
    unsigned lacks;        /* out: enum worker_layer that the kernel would not give */
    int keep_fd;           /* descriptors that stay open, -1 for none; renumbered in place */
    int report_fd;
};

/*
 * In the child, right after fork(): signals to their defaults, own process group, killed with the
 * parent, no core dump, no descriptors but /dev/null on 0-2 and the two kept, resource limits, no
 * capabilities (but those for running in real time, if wanted), namespaces of its own, in which
 * there is no network and nobody to talk to, and a system call filter under which the process
 * cannot create or trace or signal another one, run another program or leave its group. 0, or the
 * errno of what failed.
 */
int confine(struct confinement *confinement);

#endif
