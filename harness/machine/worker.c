/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * worker.c - see worker.h.
 *
 * How "gone afterwards" is made sure: the child cannot create processes, leave its process group or
 * outlive its parent (confine.c), so that it is one process; the parent kills the group while the
 * child is still unreaped, when its number cannot have been given to somebody else.
 *
 * How "done" is told from "exited": the parent draws a random word before the fork, and the child
 * writes it into a page shared with the parent after body() returned. A module that makes the
 * process exit does not get there. (One that searches the whole address space for the word could:
 * within one process nothing can be hidden for good. Hence the evidence is untrusted as well.)
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "machine/confine.h"
#include "machine/worker.h"

#define TICK_NS        50000000ull
#define POLL_NS        2000000ull /* between looks at the child where there is no pidfd */
#define DEFAULT_MEMORY (1ull << 30)
#define CPU_MORE       2 /* s of processor time beyond the wall time */
#define BULK_BYTES     65536

/* Page shared between parent and child. The child's word is taken for nothing but this. */
struct last_words {
    uint64_t cookie[2];
    int value; /* of body() */
    unsigned lacks;
    char reason[WORKER_REASON];
};

/* In a child: its page. */
static volatile struct last_words *own_words;

/* What the caller wants done. */
struct job {
    worker_body *body;
    void *argument;
    void *shared;
    const struct worker_limits *limits;
    bool want_pipe;
};

/* The parent's view of one run. */
struct run {
    pid_t child;
    int pid_fd;   /* -1: not to be had */
    int bulk_fd;  /* read end, -1: none or at its end */
    int setup_fd; /* read end: errno of a failed set-up, then end of file */
    uint64_t begin_ns, deadline_ns, next_tick_ns;
    uint64_t cookie[2];
    volatile struct last_words *words;
    worker_progress *progress;
    void *progress_argument;
    const void *shared;
    uint8_t *bulk; /* BULK_BYTES */
};

static uint64_t now_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static void close_fd(int *fd)
{
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
}

void *worker_block(size_t size)
{
    void *block = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);

    return block == MAP_FAILED ? NULL : block;
}

void worker_block_free(void *block, size_t size)
{
    if (block != NULL)
        munmap(block, size);
}

/* The child, from its first instruction to its last. */
static __attribute__((noreturn)) void child_main(const struct run *run, const struct job *job,
                                                 struct confinement *confinement)
{
    int error = confine(confinement), value;

    if (error != 0) {
        if (write(confinement->report_fd, &error, sizeof error) < 0)
            _exit(126);
        _exit(127);
    }
    close(confinement->report_fd);
    own_words = run->words;
    run->words->lacks = confinement->lacks;
    value = job->body(job->argument, job->shared, confinement->keep_fd);
    run->words->value = value;
    run->words->cookie[0] = run->cookie[0];
    run->words->cookie[1] = run->cookie[1];
    _exit(0);
}

/* Waits until the child has confined itself. 0, or the errno of its failure. A child that dies on
 * the way is left to the ordinary course. */
static int await_setup(struct run *run)
{
    int error = 0;
    ssize_t got;

    do
        got = read(run->setup_fd, &error, sizeof error);
    while (got < 0 && errno == EINTR);
    close_fd(&run->setup_fd);
    return got == (ssize_t)sizeof error ? error : 0;
}

/* Passes on what is in the pipe, at most one buffer. False when there is nothing more. */
static bool drain(struct run *run)
{
    ssize_t got;

    if (run->bulk_fd < 0)
        return false;
    got = read(run->bulk_fd, run->bulk, BULK_BYTES);
    if (got < 0)
        return errno == EINTR;
    if (got == 0) {
        close_fd(&run->bulk_fd);
        return false;
    }
    if (run->progress != NULL)
        run->progress(run->progress_argument, run->shared, run->bulk, (size_t)got);
    return true;
}

/* True when the child has ended. It stays unreaped: its number stays its own. */
static bool ended(const struct run *run)
{
    siginfo_t info;

    info.si_pid = 0;
    while (waitid(P_PID, (id_t)run->child, &info, WEXITED | WNOHANG | WNOWAIT) != 0)
        if (errno != EINTR)
            return true;
    return info.si_pid == run->child;
}

static void tick(struct run *run, uint64_t now)
{
    if (now < run->next_tick_ns)
        return;
    if (run->progress != NULL)
        run->progress(run->progress_argument, run->shared, NULL, 0);
    run->next_tick_ns = now + TICK_NS;
}

/* Sleeps until something happens, a tick is due or the time is up. */
static void sleep_until_event(const struct run *run, uint64_t now)
{
    struct pollfd fds[2] = { { .fd = run->bulk_fd, .events = POLLIN },
                             { .fd = run->pid_fd, .events = POLLIN } };
    uint64_t until = run->next_tick_ns < run->deadline_ns ? run->next_tick_ns : run->deadline_ns;
    struct timespec wait;

    if (run->pid_fd < 0 && until > now + POLL_NS)
        until = now + POLL_NS;
    until = until > now ? until - now : 0;
    wait.tv_sec = (time_t)(until / 1000000000u);
    wait.tv_nsec = (long)(until % 1000000000u);
    ppoll(fds, 2, &wait, NULL); /* whatever it says, the loop looks for itself */
}

/* True when the time was up before the child ended. */
static bool attend(struct run *run)
{
    for (;;) {
        bool over = ended(run);
        bool more = drain(run);
        uint64_t now = now_ns();

        if (over) {
            while (more)
                more = drain(run);
            return false;
        }
        if (now >= run->deadline_ns)
            return true;
        tick(run, now);
        if (!more)
            sleep_until_event(run, now);
    }
}

/* Kills and reaps; the status of the child. */
static int finish(const struct run *run)
{
    int status = 0;

    kill(-run->child, SIGKILL);
    kill(run->child, SIGKILL);
    while (waitpid(run->child, &status, 0) < 0 && errno == EINTR)
        ;
    return status;
}

void worker_say(const char *reason)
{
    size_t i = 0;

    if (own_words == NULL)
        return;
    for (; i < WORKER_REASON - 1 && reason[i] != '\0'; i++)
        own_words->reason[i] = reason[i];
    own_words->reason[i] = '\0';
}

void worker_lacks(enum worker_layer layer)
{
    if (own_words != NULL)
        own_words->lacks |= layer;
}

const char *worker_layer_name(unsigned index)
{
    static const char *const names[WORKER_LAYERS] = { "a user namespace", "a network namespace",
                                                      "an IPC namespace", "Landlock" };

    return index < WORKER_LAYERS ? names[index] : NULL;
}

/* Whatever is in the page, a line comes out. */
static void take_reason(const struct run *run, struct worker_result *result)
{
    size_t i = 0;
    char c;

    while (i < WORKER_REASON - 1 && (c = run->words->reason[i]) != '\0')
        result->reason[i++] = (char)(c >= ' ' && c <= '~' ? c : '?');
    result->reason[i] = '\0';
}

static void judge(const struct run *run, bool timed_out, int status, struct worker_result *result)
{
    result->wall_ns = now_ns() - run->begin_ns;
    result->value = 0;
    result->lacks = run->words->lacks & ((1u << WORKER_LAYERS) - 1);
    take_reason(run, result);
    if (timed_out) {
        result->end = WORKER_TIMEOUT;
    } else if (WIFSIGNALED(status)) {
        result->end = WORKER_KILLED;
        result->value = WTERMSIG(status);
    } else if (run->words->cookie[0] != run->cookie[0] || run->words->cookie[1] != run->cookie[1]) {
        result->end = WORKER_EXITED;
        result->value = WEXITSTATUS(status);
    } else {
        result->value = run->words->value;
        result->end = result->value == 0 ? WORKER_DONE : WORKER_FAILED;
    }
}

static int draw_cookie(uint64_t cookie[2])
{
    ssize_t got;

    do
        got = getrandom(cookie, 2 * sizeof *cookie, 0);
    while (got < 0 && errno == EINTR);
    return got == 2 * (ssize_t)sizeof *cookie ? 0 : -EIO;
}

static int open_pipe(int fds[2], bool read_without_waiting)
{
    if (pipe2(fds, O_CLOEXEC) != 0)
        return -errno;
    if (read_without_waiting && fcntl(fds[0], F_SETFL, O_NONBLOCK) != 0)
        return -errno;
    return 0;
}

static uint64_t cpu_seconds(const struct worker_limits *limits)
{
    return limits->wall_ns / 1000000000u > UINT32_MAX ? 0
                                                      : limits->wall_ns / 1000000000u + CPU_MORE;
}

/* Forks. No signal handler of the parent may run in the child: all signals wait until the child has
 * its own dispositions. */
static int make_child(struct run *run, const struct job *job, int bulk_fd, int setup_fd)
{
    uint64_t memory = job->limits->memory_bytes;
    struct confinement confinement = { .parent = getpid(),
                                       .memory_bytes = memory != 0 ? memory : DEFAULT_MEMORY,
                                       .cpu_seconds = cpu_seconds(job->limits),
                                       .real_time = job->limits->real_time,
                                       .keep_fd = bulk_fd,
                                       .report_fd = setup_fd };
    sigset_t all, before;
    int error = 0;

    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    run->begin_ns = now_ns();
    run->child = fork();
    if (run->child == 0)
        child_main(run, job, &confinement);
    if (run->child < 0)
        error = -errno;
    else
        setpgid(run->child, run->child); /* the child does too: whoever comes first */
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

static int start(struct run *run, const struct job *job)
{
    int bulk[2] = { -1, -1 }, setup[2] = { -1, -1 };
    int error = open_pipe(setup, false);

    if (error == 0 && job->want_pipe)
        error = open_pipe(bulk, true);
    if (error == 0)
        error = make_child(run, job, bulk[1], setup[1]);
    close_fd(&setup[1]);
    close_fd(&bulk[1]);
    run->setup_fd = setup[0];
    run->bulk_fd = bulk[0];
    return error;
}

static int prepare(struct run *run)
{
    run->words = worker_block(sizeof *run->words);
    run->bulk = malloc(BULK_BYTES);
    if (run->words == NULL || run->bulk == NULL)
        return -ENOMEM;
    return draw_cookie(run->cookie);
}

int worker_run(worker_body *body, void *argument, void *shared, const struct worker_limits *limits,
               worker_progress *progress, void *progress_argument, bool want_pipe,
               struct worker_result *result)
{
    struct run run = { .child = -1,
                       .pid_fd = -1,
                       .bulk_fd = -1,
                       .setup_fd = -1,
                       .progress = progress,
                       .progress_argument = progress_argument,
                       .shared = shared };
    const struct job job = { body, argument, shared, limits, want_pipe };
    int error = prepare(&run);

    if (error == 0)
        error = start(&run, &job);
    if (error != 0)
        goto out;
    run.pid_fd = (int)syscall(SYS_pidfd_open, run.child, 0);
    run.next_tick_ns = run.begin_ns + TICK_NS;
    run.deadline_ns =
        limits->wall_ns < UINT64_MAX - run.begin_ns ? run.begin_ns + limits->wall_ns : UINT64_MAX;
    error = -await_setup(&run);
    bool timed_out = error == 0 && attend(&run);
    int status = finish(&run);

    if (error == 0) {
        while (timed_out && drain(&run))
            ;
        judge(&run, timed_out, status, result);
    }
out:
    close_fd(&run.pid_fd);
    close_fd(&run.bulk_fd);
    close_fd(&run.setup_fd);
    free(run.bulk);
    worker_block_free((void *)(uintptr_t)run.words, sizeof *run.words);
    return error;
}
