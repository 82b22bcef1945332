/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * worker.h - one experiment, one process, really gone afterwards.
 *
 * The parent forks; the child drops what it can (own process group, dies with its parent, no core,
 * memory and file limits, standard streams to /dev/null), runs body() and exits. What it learns it
 * writes into a block of shared memory as it goes, so that the parent knows how far it came even
 * when the child is killed. The parent waits, kills on timeout, and reaps. The block is untrusted
 * input to the parent.
 */
#ifndef HARNESS_WORKER_H
#define HARNESS_WORKER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

enum worker_end {
    WORKER_DONE,   /* body returned 0 and the child said so in the way only worker.c knows */
    WORKER_FAILED, /* body returned non-zero: harness trouble, see value */
    WORKER_EXITED, /* the process ended by itself without body() returning: code in value */
    WORKER_KILLED, /* ended by a signal: number in value */
    WORKER_TIMEOUT /* killed by us because the time was up */
};

#define WORKER_REASON 160

/* Layers of the confinement that a kernel or a container may forbid. Without them the system call
 * filter stands alone. */
enum worker_layer {
    WORKER_USER_NAMESPACE = 1 << 0,    /* nobody's user number */
    WORKER_NETWORK_NAMESPACE = 1 << 1, /* no network */
    WORKER_IPC_NAMESPACE = 1 << 2,     /* no System V IPC of others */
    WORKER_LANDLOCK = 1 << 3           /* no file by any way, once sealed */
};
#define WORKER_LAYERS 4

struct worker_result {
    enum worker_end end;
    int value;
    uint64_t wall_ns;
    char reason[WORKER_REASON]; /* what the child said last about itself (worker_say), "" when
                                   nothing: one printable line, but untrusted: for people to read
                                   only */
    unsigned lacks; /* enum worker_layer that were not to be had: as the child says, not trusted */
};

struct worker_limits {
    uint64_t wall_ns;      /* time to live; UINT64_MAX: no end */
    uint64_t memory_bytes; /* RLIMIT_AS above what the process has at fork; 0 = 1 GiB */
    bool real_time;        /* keeps priorities and locked memory, and with them the user number */
};

/*
 * body: runs in the child. shared: the block (parent and child see the same memory). pipe_fd: write
 * end of a pipe to the parent for bulk data, -1 when the caller wants none.
 *
 * From the start the child can make no process or thread, run no program, signal or trace nobody
 * and raise none of its limits: those calls fail with EPERM. Descriptors other than 0, 1, 2
 * (/dev/null) and pipe_fd are closed; about ten more may be opened. Signals have their default
 * actions. Root's child keeps no privilege (real_time: but priorities and locking memory), and is
 * nobody, without a network, where the kernel allows that. Processor time is limited to what
 * wall_ns allows and two seconds more. What body needs from files it reads before machine_seal(),
 * or better, the parent before the fork.
 */
typedef int worker_body(void *argument, void *shared, int pipe_fd);

/* Called in the parent about every 50 ms while the child runs, and whenever bulk data arrived
 * (data, size), size 0 for a mere tick. May be NULL. */
typedef void worker_progress(void *argument, const void *shared, const void *data, size_t size);

/*
 * Runs body in a child. shared must come from worker_block(). Returns 0 with *result filled, or
 * negative errno when no child could be made or it could not give up its rights. No process is left
 * behind in any case, not even one that the child itself managed to create: neither when this
 * returns, nor when the calling thread or process ends before it does.
 *
 * No state is kept in the parent: several threads may run workers at the same time.
 */
int worker_run(worker_body *body, void *argument, void *shared, const struct worker_limits *limits,
               worker_progress *progress, void *progress_argument, bool want_pipe,
               struct worker_result *result);

/* In the child: leaves a word on why it is about to end, for worker_result.reason. The latest
 * counts. Fit for signal handlers; does nothing outside a worker. */
void worker_say(const char *reason);

/* In a child: a layer was not to be had, for worker_result.lacks. */
void worker_lacks(enum worker_layer layer);
/* "a user namespace": what a bit of it is, for people. By index, NULL past the end. */
const char *worker_layer_name(unsigned index);

/* Zeroed memory shared with children made later; NULL when there is none. */
void *worker_block(size_t size);
void worker_block_free(void *block, size_t size);

#endif
