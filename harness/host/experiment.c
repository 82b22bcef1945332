/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/experiment.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Rows travel in blocks, so that a cycle costs no system call. */
#define BLOCK_BYTES 32768

struct block {
    const struct recording *recording;
    int fd;
    size_t used; /* doubles */
    double values[BLOCK_BYTES / sizeof(double)];
};

struct job {
    const struct experiment *experiment;
    const struct image *image;
    const struct recording *recording;
    struct block block;
};

static void block_flush(struct block *block)
{
    const char *at = (const char *)block->values;
    size_t left = block->used * sizeof(double);
    while (left > 0) {
        const ssize_t written = write(block->fd, at, left);
        if (written < 0 && errno != EINTR)
            break; /* the parent is gone: nobody to tell */
        if (written > 0) {
            at += written;
            left -= (size_t)written;
        }
    }
    block->used = 0;
}

static void block_sample(void *argument, struct host *host)
{
    struct block *block = argument;
    const struct recording *recording = block->recording;
    if (host_cycles(host) % recording->every != 0)
        return;
    if (block->used + 1 + recording->count > BLOCK_BYTES / sizeof(double))
        block_flush(block);
    block->values[block->used++] = (double)host_time(host) * 1e-9;
    for (size_t i = 0; i < recording->count; i++)
        block->values[block->used++] =
            scalar_get(recording->registers[i].type, host_register(host, &recording->registers[i]));
}

static void run_cycles(const struct experiment *experiment, struct host *host)
{
    bool going = host_start(host);
    for (uint64_t i = 0; i < experiment->cycles && going; i++)
        going = host_cycle(host);
}

static int play(struct job *job, struct evidence *evidence, int pipe_fd, struct machine *machine,
                struct host *host)
{
    int r = machine_seal(machine, pipe_fd, evidence->trouble);
    if (r != 0)
        return r;
    if (job->recording != NULL && pipe_fd >= 0) {
        job->block.recording = job->recording;
        job->block.fd = pipe_fd;
        host_on_sample(host, block_sample, &job->block);
    }
    run_cycles(job->experiment, host);
    block_flush(&job->block);
    evidence->stack_used = machine_stack_used(machine);
    evidence->stage = EVIDENCE_FINISHED;
    return 0;
}

static int prepare(const struct experiment *experiment, const struct image *image, uint64_t hang_ns,
                   struct evidence *evidence, struct machine **machine, struct host **host)
{
    const struct machine_config config = { .seed = experiment->host.seed,
                                           .poison = true,
                                           .hang_ns = hang_ns };
    int r = machine_load(machine, image, &config, evidence->trouble);
    if (r != 0)
        return r;
    evidence->stage = EVIDENCE_LOADED;
    return host_open(host, &experiment->host, *machine, image, evidence, evidence->trouble);
}

/* In the worker process. */
static int body(void *argument, void *shared, int pipe_fd)
{
    struct job *job = argument;
    struct evidence *evidence = shared;
    struct machine *machine = NULL;
    struct host *host = NULL;
    int r = prepare(job->experiment, job->image, 0, evidence, &machine, &host);
    if (r == 0)
        r = play(job, evidence, pipe_fd, machine, host);
    /* No clean-up: module code may have left the heap in any state, and the process ends here. */
    return r == 0 ? 0 : 1;
}

__attribute__((noinline)) void tgm_debug_module_loaded(const char *path, uint64_t offset)
{
    __asm__ volatile("" : : "r"(path), "r"(offset) : "memory");
}

int experiment_run_here(const struct experiment *experiment, const struct image *image,
                        struct evidence *evidence)
{
    const uint64_t never = UINT64_C(86400) * 1000000000;
    struct machine *machine = NULL;
    struct host *host = NULL;
    int r = prepare(experiment, image, never, evidence, &machine, &host);
    if (r == 0) {
        tgm_debug_module_loaded(image->path, (uint64_t)(uintptr_t)machine_address(machine, 0));
        run_cycles(experiment, host);
        evidence->stage = EVIDENCE_FINISHED;
    }
    host_close(host);
    if (machine != NULL)
        machine_unload(machine);
    return r;
}

struct relay {
    experiment_progress *progress;
    void *argument;
    const struct evidence *evidence;
    size_t row_doubles, pending; /* bytes of an incomplete row */
    char row[BLOCK_BYTES * 2 + 65536];
};

static void relay(void *argument, const void *shared, const void *data, size_t size)
{
    struct relay *r = argument;
    struct evidence snapshot;
    memcpy(&snapshot, shared, sizeof snapshot);
    evidence_clean(&snapshot);
    const size_t row = r->row_doubles * sizeof(double);
    const char *from = data;
    while (size > 0 && row > 0) {
        const size_t room = sizeof r->row - r->pending;
        const size_t take = size < room ? size : room;
        memcpy(r->row + r->pending, from, take);
        from += take;
        size -= take;
        r->pending += take;
        const size_t rows = r->pending / row;
        r->progress(r->argument, &snapshot, (const double *)(const void *)r->row, rows);
        memmove(r->row, r->row + rows * row, r->pending - rows * row);
        r->pending -= rows * row;
    }
    if (from == data)
        r->progress(r->argument, &snapshot, NULL, 0);
}

int experiment_run(const struct experiment *experiment, const struct image *image,
                   const struct recording *recording, experiment_progress *progress, void *argument,
                   struct experiment_result *result)
{
    int r = -ENOMEM;
    struct job *job = calloc(1, sizeof *job);
    struct relay *forward = calloc(1, sizeof *forward);
    struct evidence *shared = worker_block(sizeof *shared);
    if (job == NULL || forward == NULL || shared == NULL)
        goto out;
    job->experiment = experiment;
    job->image = image;
    job->recording = recording;
    forward->progress = progress;
    forward->argument = argument;
    forward->row_doubles = recording != NULL ? 1 + recording->count : 0;
    const struct worker_limits limits = {
        .wall_ns = experiment->wall_ns != 0
                       ? experiment->wall_ns
                       : UINT64_C(10000000000) + experiment->cycles * UINT64_C(2000000),
    };
    r = worker_run(body, job, shared, &limits, progress != NULL ? relay : NULL, forward,
                   recording != NULL, &result->worker);
    if (r == 0) {
        memcpy(&result->evidence, shared, sizeof *shared);
        evidence_clean(&result->evidence);
    }
out:
    if (shared != NULL)
        worker_block_free(shared, sizeof *shared);
    free(forward);
    free(job);
    return r;
}
