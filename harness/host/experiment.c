/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/experiment.h"

#include "bus/pcap.h"
#include "host/realtime.h"
#include "host/schedule.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Rows and frames travel in blocks, so that a cycle costs no system call. */
#define BLOCK_BYTES 32768

#define EMPTY_LOOP_NS UINT64_C(1000000000)

_Static_assert(PCAP_BUFFER <= BLOCK_BYTES, "what a capture hands over fits a block");

enum block_kind { BLOCK_ROWS = 1, BLOCK_FRAMES };

struct block_head {
    uint32_t kind, size;
};

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
    struct host_config host; /* the experiment's, with the worker's own capture */
    int pipe_fd;
    struct pcap capture;
    struct block block;
};

static void write_all(int fd, const void *data, size_t size)
{
    const char *at = data;
    while (size > 0) {
        const ssize_t written = write(fd, at, size);
        if (written < 0 && errno != EINTR)
            return; /* the parent is gone: nobody to tell */
        if (written > 0) {
            at += written;
            size -= (size_t)written;
        }
    }
}

static void block_write(int fd, enum block_kind kind, const void *data, size_t size)
{
    const struct block_head head = { kind, (uint32_t)size };
    if (size == 0)
        return;
    write_all(fd, &head, sizeof head);
    write_all(fd, data, size);
}

static int send_frames(void *argument, const void *data, size_t size)
{
    const struct job *job = argument;
    block_write(job->pipe_fd, BLOCK_FRAMES, data, size);
    return 0;
}

static void block_flush(struct block *block)
{
    block_write(block->fd, BLOCK_ROWS, block->values, block->used * sizeof(double));
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

/* What the oscilloscope has in its memory, as rows of a recording. */
static void block_oscilloscope(struct block *block, struct host *host)
{
    for (size_t i = 0; i < host_osc_samples(host); i++) {
        if (block->used + 1 + block->recording->count > sizeof block->values / sizeof(double))
            block_flush(block);
        host_osc_row(host, i, block->values + block->used);
        block->used += 1 + block->recording->count;
    }
}

/* The empty loop that a run on the real clock is shown beside. */
static void measure_empty_loop(const struct experiment *experiment, struct realtime *real)
{
    const struct host_config *config = &experiment->host;
    const struct schedule *schedule = schedule_find(config->product->schedule, config->cycle_us);
    const uint64_t quarter = experiment->cycles * config->cycle_us * UINT64_C(250);
    realtime_empty_loop(real,
                        schedule->slot_count > 1 ? schedule->slots[1].at_us : schedule->cycle_us,
                        quarter < EMPTY_LOOP_NS ? quarter : EMPTY_LOOP_NS);
}

static void run_cycles(const struct experiment *experiment, struct host *host,
                       const struct evidence *evidence)
{
    const uint64_t cycle_ns = experiment->host.cycle_us * UINT64_C(1000);
    const uint64_t reload = experiment->reload_ns / cycle_ns;
    bool going = host_start(host), loaded = experiment->reload_ns == 0;
    for (uint64_t done = 0; done < experiment->cycles && going && !evidence->stop;) {
        const uint64_t before = host_cycles(host);
        if (!loaded && done >= reload) {
            host_run(host);
            loaded = true;
        }
        going = host_cycle(host) && !(experiment->until_played && host_played(host));
        /* A reset of TG Motion begins to count anew; interrupts may take several cycles. */
        done += host_cycles(host) > before ? host_cycles(host) - before : 1;
    }
}

static void note_coverage(const struct machine *machine, struct coverage *coverage)
{
    uint64_t begin, end;
    const uint8_t *bits = machine_coverage(machine, &begin, &end);
    if (bits != NULL)
        coverage_take(coverage, bits, begin, end);
}

static int play(struct job *job, struct evidence *evidence, int pipe_fd, struct machine *machine,
                struct host *host)
{
    int r = machine_seal(machine, pipe_fd, evidence->trouble);
    if (r != 0)
        return r;
    const struct recording *recording = pipe_fd >= 0 ? job->recording : NULL;
    job->block.recording = recording;
    job->block.fd = pipe_fd;
    if (recording != NULL && recording->osc == NULL)
        host_on_sample(host, block_sample, &job->block);
    if (recording != NULL && recording->osc != NULL &&
        host_osc_arm(host, recording->osc, evidence->trouble) != 0)
        return -EINVAL;
    if (job->host.real != NULL)
        measure_empty_loop(job->experiment, job->host.real);
    run_cycles(job->experiment, host, evidence);
    if (recording != NULL && recording->osc != NULL)
        block_oscilloscope(&job->block, host);
    block_flush(&job->block);
    evidence->stack_used = machine_stack_used(machine);
    note_coverage(machine, &evidence->coverage);
    evidence->stage = EVIDENCE_FINISHED;
    return 0;
}

/* What an instrumented machine sees goes into the tables of the evidence. A process has one
 * machine. */
static int trace_open(const struct experiment *experiment, struct host_config *around,
                      struct evidence *evidence, struct machine_config *config)
{
    static struct audit audit;
    static struct machine_trace trace;
    const struct product *product = around->product;
    if (!experiment->traced)
        return 0;
    int r = audit_open(&audit, catalogue_find(product->generation, (int)product->memory_id),
                       &evidence->audit);
    if (r != 0) {
        snprintf(evidence->trouble, sizeof evidence->trouble, "no memory for what is traced");
        return r;
    }
    trace = (struct machine_trace){ .access = audit_access, .argument = &audit };
    config->trace = &trace;
    around->audit = &audit;
    return 0;
}

static bool is_instrumented(const struct experiment *experiment, const struct image *image)
{
    char why[MACHINE_WHY];
    return experiment->instrumented || experiment->traced ||
           machine_fits(image, MACHINE_NATIVE, why) != 0;
}

static int prepare(const struct experiment *experiment, struct host_config *around,
                   const struct image *image, uint64_t hang_ns, struct evidence *evidence,
                   struct machine **machine, struct host **host)
{
    evidence->instrumented = is_instrumented(experiment, image);
    struct machine_config config = {
        .seed = around->seed,
        .kind = evidence->instrumented ? MACHINE_INSTRUMENTED : MACHINE_NATIVE,
        .places = experiment->places,
        .poison =
            experiment->poison != MACHINE_POISON_NONE ? experiment->poison : MACHINE_POISON_SEEDED,
        .hang_ns = hang_ns,
        .interruptible = experiment->real_clock || around->preempt.mode != PREEMPT_NONE,
        .asides = true,
    };
    int r = trace_open(experiment, around, evidence, &config);
    if (r == 0)
        r = machine_load(machine, image, &config, evidence->trouble);
    if (r != 0)
        return r;
    evidence->stage = EVIDENCE_LOADED;
    if (around->preempt.mode == PREEMPT_TRIED && around->preempt.at == 0)
        around->preempt.at = experiment->cycles;
    if (experiment->real_clock)
        r = realtime_open(&around->real, *machine, around->cycle_us, &evidence->clock,
                          evidence->trouble);
    if (r == 0)
        r = host_open(host, around, *machine, image, evidence, evidence->trouble);
    if (r == 0 && experiment->real_clock)
        realtime_prepare(around->real);
    return r;
}

/* In the worker process. */
static int body(void *argument, void *shared, int pipe_fd)
{
    struct job *job = argument;
    struct evidence *evidence = shared;
    struct machine *machine = NULL;
    struct host *host = NULL;
    job->pipe_fd = pipe_fd;
    job->host = job->experiment->host;
    if (job->host.capture != NULL) {
        job->host.capture = &job->capture;
        pcap_open(&job->capture, PCAP_RECORDS, send_frames, job, 0);
    }
    int r = prepare(job->experiment, &job->host, job->image, 0, evidence, &machine, &host);
    if (r == 0)
        r = play(job, evidence, pipe_fd, machine, host);
    if (job->host.capture != NULL)
        pcap_close(&job->capture);
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
    struct host_config around = experiment->host;
    int r = prepare(experiment, &around, image, never, evidence, &machine, &host);
    if (r == 0) {
        tgm_debug_module_loaded(image->path, (uint64_t)(uintptr_t)machine_address(machine, 0));
        run_cycles(experiment, host, evidence);
        evidence->stage = EVIDENCE_FINISHED;
    }
    host_close(host);
    realtime_close(around.real);
    if (machine != NULL)
        machine_unload(machine);
    return r;
}

/* What comes out of the pipe, put together again. The worker is not trusted: a block that is none
 * ends it. */
struct relay {
    experiment_progress *progress;
    void *argument;
    struct pcap *capture;
    const volatile sig_atomic_t *stop;
    struct evidence *shared;
    size_t row_doubles;
    bool damaged;
    size_t head_used, used;
    struct block_head head;
    double block[BLOCK_BYTES / sizeof(double)];
};

static size_t take(void *to, size_t *used, size_t wanted, const char *from, size_t size)
{
    const size_t missing = wanted - *used;
    const size_t count = size < missing ? size : missing;
    memcpy((char *)to + *used, from, count);
    *used += count;
    return count;
}

static bool head_is_sound(const struct relay *r)
{
    const size_t row = r->row_doubles * sizeof(double);
    switch (r->head.kind) {
    case BLOCK_ROWS:
        return row > 0 && r->head.size > 0 && r->head.size <= BLOCK_BYTES &&
               r->head.size % row == 0;
    case BLOCK_FRAMES:
        return r->capture != NULL && r->head.size > 0 && r->head.size <= BLOCK_BYTES;
    default:
        return false;
    }
}

static void block_arrived(struct relay *r, const struct evidence *snapshot)
{
    if (r->head.kind == BLOCK_FRAMES)
        r->damaged = pcap_append(r->capture, r->block, r->head.size) == -EBADMSG;
    else if (r->progress != NULL)
        r->progress(r->argument, snapshot, r->block,
                    r->head.size / (r->row_doubles * sizeof(double)));
    r->head_used = r->used = 0;
}

static void relay_data(struct relay *r, const struct evidence *snapshot, const char *from,
                       size_t size)
{
    while (size > 0 && !r->damaged) {
        size_t count;
        if (r->head_used < sizeof r->head) {
            count = take(&r->head, &r->head_used, sizeof r->head, from, size);
            r->damaged = r->head_used == sizeof r->head && !head_is_sound(r);
        } else {
            count = take(r->block, &r->used, r->head.size, from, size);
            if (r->used == r->head.size)
                block_arrived(r, snapshot);
        }
        from += count;
        size -= count;
    }
}

static void relay(void *argument, const void *shared, const void *data, size_t size)
{
    struct relay *r = argument;
    if (r->stop != NULL && *r->stop)
        r->shared->stop = true;
    struct evidence snapshot;
    memcpy(&snapshot, shared, sizeof snapshot);
    evidence_clean(&snapshot);
    relay_data(r, &snapshot, data, size);
    if (size == 0 && r->progress != NULL)
        r->progress(r->argument, &snapshot, NULL, 0);
}

static void note_damage(const struct relay *r, struct evidence *evidence)
{
    if (r->damaged && evidence->trouble[0] == '\0')
        snprintf(evidence->trouble, sizeof evidence->trouble,
                 "the worker's recording is damaged: it wrote what it should not");
}

/* Only what does not come to an end by itself takes so long, on a busy computer as well: an
 * emulated CPU is some thirty times slower, and trying out interrupts takes a second for each of
 * machine time. */
static uint64_t wall_limit(const struct experiment *experiment, bool instrumented)
{
    const uint64_t cycle_us =
        experiment->host.cycle_us > 1000 ? experiment->host.cycle_us : UINT64_C(1000);
    const uint64_t begin = UINT64_C(10000000000), cycles = experiment->cycles * cycle_us * 2000;
    return instrumented                                     ? 12 * (begin + cycles)
           : experiment->host.preempt.mode == PREEMPT_TRIED ? begin + 12 * cycles
                                                            : begin + cycles;
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
    forward->capture = experiment->host.capture;
    forward->stop = experiment->stop;
    forward->shared = shared;
    forward->row_doubles = recording != NULL ? 1 + recording->count : 0;
    const bool bulk = recording != NULL || forward->capture != NULL;
    const struct worker_limits limits = {
        .wall_ns = experiment->wall_ns != 0
                       ? experiment->wall_ns
                       : wall_limit(experiment, is_instrumented(experiment, image)),
        .real_time = experiment->real_clock,
        .memory_bytes = is_instrumented(experiment, image) ? MACHINE_INSTRUMENTED_MEMORY : 0,
    };
    r = worker_run(body, job, shared, &limits, progress != NULL || bulk ? relay : NULL, forward,
                   bulk, &result->worker);
    if (r == 0) {
        memcpy(&result->evidence, shared, sizeof *shared);
        evidence_clean(&result->evidence);
        note_damage(forward, &result->evidence);
    }
out:
    if (shared != NULL)
        worker_block_free(shared, sizeof *shared);
    free(forward);
    free(job);
    return r;
}
