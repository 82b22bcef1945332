/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_worker.c - processes that do what they want, and are gone afterwards. */
#define _GNU_SOURCE 1
#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "machine/worker.h"
#include "machine_fixture.h"

#define BULK_TOTAL (3u << 20)

/* Shared with the workers. */
struct block {
    volatile int64_t notes[16];
    volatile pid_t pid;
};

static struct block *block;
static const struct worker_limits ample = { .wall_ns = 20000000000u };

static int make_block(void **state)
{
    (void)state;
    block = worker_block(sizeof *block);
    return block == NULL ? -1 : 0;
}

/* After every test: no child is left. */
static int drop_block(void **state)
{
    (void)state;
    worker_block_free(block, sizeof *block);
    errno = 0;
    return waitpid(-1, NULL, WNOHANG) == -1 && errno == ECHILD ? 0 : -1;
}

static struct worker_result run(worker_body *body, const struct worker_limits *limits)
{
    struct worker_result result = { .end = WORKER_FAILED, .value = -1 };

    assert_int_equal(worker_run(body, NULL, block, limits, NULL, NULL, false, &result), 0);
    return result;
}

static int return_0(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;

    seen->notes[0] = argument == NULL;
    seen->notes[1] = pipe_fd;
    seen->pid = getpid();
    return 0;
}

static int return_minus_7(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    worker_say("it was\nthe wind");
    return -7;
}

static int exit_0(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    _exit(0);
}

static int exit_5(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    _exit(5);
}

static int die_of_null(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    signal(SIGSEGV, SIG_DFL);
    __asm__ volatile("movb $0, 0");
    return 0;
}

static int spin(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;

    (void)argument, (void)pipe_fd;
    seen->pid = getpid();
    for (int sig = 1; sig < NSIG; sig++)
        signal(sig, SIG_IGN);
    for (;;)
        seen->notes[0]++;
    return 0;
}

static int stop_itself(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    kill(getpid(), SIGSTOP);
    return 0;
}

static void ends_are_told_apart(void **state)
{
    struct worker_result result;

    (void)state;
    result = run(return_0, &ample);
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(result.value, 0);
    assert_true(result.wall_ns > 0);
    assert_string_equal(result.reason, "");
    assert_int_equal(block->notes[0], 1);
    assert_int_equal(block->notes[1], -1);
    assert_int_not_equal(block->pid, getpid());
    result = run(return_minus_7, &ample);
    assert_int_equal(result.end, WORKER_FAILED);
    assert_int_equal(result.value, -7);
    assert_string_equal(result.reason, "it was?the wind");
    result = run(exit_0, &ample);
    assert_int_equal(result.end, WORKER_EXITED);
    assert_int_equal(result.value, 0);
    result = run(exit_5, &ample);
    assert_int_equal(result.end, WORKER_EXITED);
    assert_int_equal(result.value, 5);
    result = run(die_of_null, &ample);
    assert_int_equal(result.end, WORKER_KILLED);
    assert_int_equal(result.value, SIGSEGV);
}

static bool exists(pid_t pid)
{
    char path[64];

    snprintf(path, sizeof path, "/proc/%d", (int)pid);
    return access(path, F_OK) == 0;
}

static void timeout_kills_whatever_it_does(void **state)
{
    static const struct worker_limits brief = { .wall_ns = 100000000 };
    worker_body *const stubborn[] = { spin, stop_itself };

    (void)state;
    for (size_t i = 0; i < COUNT(stubborn); i++) {
        struct worker_result result = run(stubborn[i], &brief);

        assert_int_equal(result.end, WORKER_TIMEOUT);
        assert_true(result.wall_ns >= 100000000);
        assert_true(result.wall_ns < 5000000000);
    }
    assert_true(block->notes[0] > 0);
    assert_false(exists(block->pid));
}

static int try_to_multiply(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;
    char *const arguments[] = { "/bin/true", NULL };
    unsigned i = 0;

    (void)argument, (void)pipe_fd;
    seen->notes[i++] = fork() == -1 ? errno : 0;
    seen->notes[i++] = syscall(SYS_fork) == -1 ? errno : 0;
    seen->notes[i++] = syscall(SYS_vfork) == -1 ? errno : 0;
    seen->notes[i++] =
        syscall(SYS_clone, CLONE_VM | CLONE_THREAD | CLONE_SIGHAND, 0, 0, 0, 0) == -1 ? errno : 0;
    seen->notes[i++] = syscall(SYS_clone3, NULL, 0) == -1 ? errno : 0;
    seen->notes[i++] = execv("/bin/true", arguments) == -1 ? errno : 0;
    seen->notes[i++] = setsid() == -1 ? errno : 0;
    seen->notes[i++] = setpgid(0, getppid()) == -1 ? errno : 0;
    seen->notes[i++] = kill(getppid(), 0) == -1 ? errno : 0;
    seen->notes[i++] = syscall(SYS_tgkill, getppid(), getppid(), 0) == -1 ? errno : 0;
    seen->notes[i++] = prctl(PR_SET_PDEATHSIG, 0) == -1 ? errno : 0;
    seen->notes[i++] = syscall(SYS_ptrace, 0, 0, 0, 0) == -1 ? errno : 0;
    return kill(getpid(), 0);
}

/* getpid by its number in the 32-bit table, which another filter table would take for writev. */
static int enter_by_the_old_gate(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;
    long result = 20;

    (void)argument, (void)pipe_fd;
    __asm__ volatile("int $0x80" : "+a"(result)::"memory");
    seen->notes[0] = result;
    return 0;
}

static void worker_has_no_other_way_into_the_kernel(void **state)
{
    struct worker_result result = run(enter_by_the_old_gate, &ample);

    (void)state;
    if (result.end == WORKER_KILLED) {
        assert_int_equal(result.value, SIGSEGV); /* a kernel without 32-bit support */
        return;
    }
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal((int)block->notes[0], -ENOSYS);
}

static void worker_stays_one_process(void **state)
{
    static const int expected[] = { EPERM, EPERM, EPERM, EPERM, ENOSYS, EPERM,
                                    EPERM, EPERM, EPERM, EPERM, EPERM,  EPERM };
    struct worker_result result;

    (void)state;
    result = run(try_to_multiply, &ample);
    assert_int_equal(result.end, WORKER_DONE);
    for (size_t i = 0; i < COUNT(expected); i++)
        assert_int_equal(block->notes[i], expected[i]);
}

static int look_at_itself(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;
    struct __user_cap_header_struct header = { _LINUX_CAPABILITY_VERSION_3, 0 };
    struct __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3];
    struct rlimit limit;
    struct stat null, out;
    sigset_t mask;
    char *memory;

    (void)argument;
    seen->notes[0] = pipe_fd;
    for (int fd = 0; fd < 1024; fd++)
        seen->notes[1] += fcntl(fd, F_GETFD) != -1;
    stat("/dev/null", &null);
    for (int fd = 0; fd < 3; fd++)
        seen->notes[2] += fstat(fd, &out) == 0 && out.st_rdev == null.st_rdev;
    getrlimit(RLIMIT_CORE, &limit);
    seen->notes[3] = (int64_t)limit.rlim_max;
    getrlimit(RLIMIT_NOFILE, &limit);
    seen->notes[4] = (int64_t)limit.rlim_max;
    memory = mmap(NULL, 100u << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    seen->notes[5] = memory == MAP_FAILED ? errno : 0;
    memory = mmap(NULL, 10u << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    seen->notes[6] = memory == MAP_FAILED ? errno : 0;
    seen->notes[7] = getpgrp() == getpid();
    sigprocmask(SIG_BLOCK, NULL, &mask);
    seen->notes[8] = sigismember(&mask, SIGUSR1);
    seen->notes[9] = signal(SIGUSR1, SIG_DFL) == SIG_DFL;
    seen->notes[10] = prctl(PR_GET_DUMPABLE);
    seen->notes[11] = syscall(SYS_capget, &header, data) == 0 ? (int64_t)data[0].effective : -1;
    return 0;
}

static void worker_gives_up_what_it_inherits(void **state)
{
    static const struct worker_limits small = { .wall_ns = 20000000000u,
                                                .memory_bytes = 50u << 20 };
    struct worker_result result;
    sigset_t blocked, before, after;
    int stray[20];

    (void)state;
    sigemptyset(&blocked);
    sigaddset(&blocked, SIGUSR1);
    sigprocmask(SIG_BLOCK, &blocked, &before);
    signal(SIGUSR1, SIG_IGN);
    for (size_t i = 0; i < COUNT(stray); i++)
        stray[i] = open("/dev/zero", O_RDONLY);
    assert_int_equal(worker_run(look_at_itself, NULL, block, &small, NULL, NULL, true, &result), 0);
    for (size_t i = 0; i < COUNT(stray); i++)
        close(stray[i]);
    signal(SIGUSR1, SIG_DFL);
    sigprocmask(SIG_SETMASK, &before, &after);
    assert_int_equal(sigismember(&after, SIGUSR1), 1);
    assert_int_equal(sigismember(&after, SIGTERM), 0);
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(block->notes[0], 3);
    assert_int_equal(block->notes[1], 4);
    assert_int_equal(block->notes[2], 3);
    assert_int_equal(block->notes[3], 0);
    assert_int_equal(block->notes[4], 16);
    assert_int_equal(block->notes[5], ENOMEM);
    assert_int_equal(block->notes[6], 0);
    assert_int_equal(block->notes[7], 1);
    assert_int_equal(block->notes[8], 0);
    assert_int_equal(block->notes[9], 1);
    assert_int_equal(block->notes[10], 0);
    assert_int_equal(block->notes[11] & ~(int64_t)(1u << CAP_SYS_NICE | 1u << CAP_IPC_LOCK), 0);
}

/* Numbered words, in pieces of odd sizes. */
static int look_around(void *argument, void *shared, int pipe_fd)
{
    struct block *seen = shared;
    char network[64] = "";
    struct rlimit limit;

    (void)argument, (void)pipe_fd;
    seen->notes[0] = getuid();
    if (readlink("/proc/self/ns/net", network, sizeof network - 1) < 0)
        return 1;
    seen->notes[1] = strtol(strchr(network, '[') + 1, NULL, 10);
    getrlimit(RLIMIT_CPU, &limit);
    seen->notes[2] = (int64_t)limit.rlim_max;
    seen->notes[3] = socket(AF_INET, SOCK_STREAM, 0) == -1 ? errno : 0;
    return 0;
}

/* Each layer is there, or the parent hears that it is not. */
static void worker_is_nobody_and_has_no_network_where_the_kernel_allows_it(void **state)
{
    char network[64] = "";
    struct worker_result result = run(look_around, &ample);

    (void)state;
    assert_int_equal(result.end, WORKER_DONE);
    assert_true(readlink("/proc/self/ns/net", network, sizeof network - 1) > 0);
    if ((result.lacks & WORKER_USER_NAMESPACE) == 0)
        assert_int_equal(block->notes[0], 65534);
    if ((result.lacks & WORKER_NETWORK_NAMESPACE) == 0)
        assert_int_not_equal(block->notes[1], strtol(strchr(network, '[') + 1, NULL, 10));
    assert_int_equal(block->notes[2], 22);
    assert_int_equal(block->notes[3], EPERM);
    for (unsigned i = 0; i < WORKER_LAYERS; i++)
        if (result.lacks >> i & 1)
            print_message("  the kernel does not give %s\n", worker_layer_name(i));
    assert_null(worker_layer_name(WORKER_LAYERS));
}

static void worker_that_runs_in_real_time_keeps_its_user(void **state)
{
    const struct worker_limits limits = { .wall_ns = 20000000000u, .real_time = true };
    struct worker_result result = run(look_around, &limits);

    (void)state;
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(block->notes[0], getuid());
    assert_int_equal(block->notes[3], EPERM);
}

static int send_bulk(void *argument, void *shared, int pipe_fd)
{
    static uint32_t words[BULK_TOTAL / 4];
    size_t done = 0;

    (void)argument, (void)shared;
    for (uint32_t i = 0; i < BULK_TOTAL / 4; i++)
        words[i] = i * 2654435761u;
    while (done < BULK_TOTAL) {
        size_t piece = 1 + done % 70001;
        ssize_t sent;

        piece = piece < BULK_TOTAL - done ? piece : BULK_TOTAL - done;
        sent = write(pipe_fd, (const char *)words + done, piece);
        if (sent < 0)
            return errno;
        done += (size_t)sent;
    }
    return 0;
}

struct received {
    uint8_t *bytes;
    size_t size, ticks;
};

static void receive(void *argument, const void *shared, const void *data, size_t size)
{
    struct received *received = argument;

    (void)shared;
    if (size == 0)
        received->ticks++;
    else if (received->size + size <= BULK_TOTAL)
        memcpy(received->bytes + received->size, data, size);
    received->size += size;
}

static void bulk_data_arrives_whole_and_in_order(void **state)
{
    struct received received = { malloc(BULK_TOTAL), 0, 0 };
    struct worker_result result;
    uint32_t word;

    (void)state;
    assert_non_null(received.bytes);
    assert_int_equal(worker_run(send_bulk, NULL, block, &ample, receive, &received, true, &result),
                     0);
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(received.size, BULK_TOTAL);
    for (uint32_t i = 0; i < BULK_TOTAL / 4; i++) {
        memcpy(&word, received.bytes + (size_t)i * 4, 4);
        if (word != i * 2654435761u)
            fail_msg("word %u is wrong", i);
    }
    free(received.bytes);
    /* Nobody listens: it does not block either. */
    assert_int_equal(worker_run(send_bulk, NULL, block, &ample, NULL, NULL, true, &result), 0);
    assert_int_equal(result.end, WORKER_DONE);
}

/* More at once than the parent reads at once, and gone. */
static int send_burst(void *argument, void *shared, int pipe_fd)
{
    static char burst[512 << 10];

    (void)argument;
    if (fcntl(pipe_fd, F_SETPIPE_SZ, sizeof burst) < 0)
        ((struct block *)shared)->notes[0] = errno;
    return write(pipe_fd, burst, sizeof burst) == sizeof burst ? 0 : 1;
}

static void last_burst_of_a_worker_is_kept(void **state)
{
    static uint8_t bytes[BULK_TOTAL];

    (void)state;
    for (int i = 0; i < 30; i++) {
        struct received received = { bytes, 0, 0 };
        struct worker_result result;

        assert_int_equal(
            worker_run(send_burst, NULL, block, &ample, receive, &received, true, &result), 0);
        assert_int_equal(result.end, WORKER_DONE);
        assert_int_equal(received.size, 512 << 10);
    }
}

static int send_and_hang(void *argument, void *shared, int pipe_fd)
{
    if (write(pipe_fd, "last words", 10) != 10)
        return 1;
    return spin(argument, shared, pipe_fd);
}

static int flood(void *argument, void *shared, int pipe_fd)
{
    static char zeros[65536];

    (void)argument, (void)shared;
    while (write(pipe_fd, zeros, sizeof zeros) > 0)
        ;
    return 1;
}

static void what_was_sent_before_a_timeout_is_kept(void **state)
{
    static const struct worker_limits brief = { .wall_ns = 300000000 };
    struct received received = { malloc(BULK_TOTAL), 0, 0 };
    struct worker_result result;

    (void)state;
    assert_non_null(received.bytes);
    assert_int_equal(
        worker_run(send_and_hang, NULL, block, &brief, receive, &received, true, &result), 0);
    assert_int_equal(result.end, WORKER_TIMEOUT);
    assert_int_equal(received.size, 10);
    assert_memory_equal(received.bytes, "last words", 10);
    assert_in_range(received.ticks, 2, 8);
    assert_int_equal(worker_run(flood, NULL, block, &brief, receive, &received, true, &result), 0);
    assert_int_equal(result.end, WORKER_TIMEOUT);
    free(received.bytes);
}

/* The harness itself is killed: its worker must not survive it. */
static void worker_dies_with_its_parent(void **state)
{
    pid_t harness = fork();

    (void)state;
    if (harness == 0) {
        struct worker_result result;

        worker_run(spin, NULL, block, &ample, NULL, NULL, false, &result);
        _exit(0);
    }
    assert_true(harness > 0);
    for (int i = 0; i < 5000 && block->notes[0] == 0; i++)
        usleep(1000);
    assert_true(block->pid > 0);
    assert_true(exists(block->pid));
    kill(harness, SIGKILL);
    waitpid(harness, NULL, 0);
    usleep(10000);
    int64_t counted = block->notes[0];
    usleep(50000);
    assert_int_equal(block->notes[0], counted);
}

static volatile sig_atomic_t interruptions;

static void interrupt(int sig)
{
    (void)sig;
    interruptions++;
}

static int sleep_a_little(void *argument, void *shared, int pipe_fd)
{
    (void)argument, (void)shared, (void)pipe_fd;
    usleep(100000);
    return 0;
}

static void signals_in_the_parent_disturb_nothing(void **state)
{
    const struct itimerval every = { { 0, 500 }, { 0, 500 } }, never = { { 0, 0 }, { 0, 0 } };
    struct sigaction action = { .sa_handler = interrupt }, before;
    struct worker_result result;

    (void)state;
    sigaction(SIGALRM, &action, &before);
    setitimer(ITIMER_REAL, &every, NULL);
    result = run(sleep_a_little, &ample);
    setitimer(ITIMER_REAL, &never, NULL);
    sigaction(SIGALRM, &before, NULL);
    assert_int_equal(result.end, WORKER_DONE);
    assert_true(interruptions > 20);
}

static void *run_in_thread(void *argument)
{
    struct worker_result *result = argument;

    worker_run(result->value == 1 ? return_minus_7 : sleep_a_little, NULL, block, &ample, NULL,
               NULL, true, result);
    return NULL;
}

static void two_workers_at_a_time(void **state)
{
    struct worker_result results[2] = { { .value = 0 }, { .value = 1 } };
    pthread_t threads[2];

    (void)state;
    for (int i = 0; i < 2; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, run_in_thread, &results[i]), 0);
    for (int i = 0; i < 2; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(results[0].end, WORKER_DONE);
    assert_int_equal(results[1].end, WORKER_FAILED);
    assert_int_equal(results[1].value, -7);
}

static int open_fds(void)
{
    int count = 0;

    for (int fd = 0; fd < 1024; fd++)
        count += fcntl(fd, F_GETFD) != -1;
    return count;
}

static void many_runs_leave_nothing_open(void **state)
{
    struct worker_result result;
    int before = open_fds();

    (void)state;
    for (int i = 0; i < 50; i++) {
        assert_int_equal(worker_run(i % 2 ? return_0 : exit_5, NULL, block, &ample, NULL, NULL,
                                    i % 3 == 0, &result),
                         0);
        assert_int_equal(result.end, i % 2 ? WORKER_DONE : WORKER_EXITED);
    }
    assert_int_equal(open_fds(), before);
}

/* Set-up fails: no descriptors to be had. */
static void failure_to_start_is_an_error(void **state)
{
    struct rlimit before, few;
    struct worker_result result = { .value = 123 };

    (void)state;
    getrlimit(RLIMIT_NOFILE, &before);
    few = before;
    few.rlim_cur = 4;
    setrlimit(RLIMIT_NOFILE, &few);
    int error = worker_run(return_0, NULL, block, &ample, NULL, NULL, true, &result);
    few.rlim_cur = 20; /* enough for the parent, not for arranging them in the child */
    setrlimit(RLIMIT_NOFILE, &few);
    int late_error = worker_run(return_0, NULL, block, &ample, NULL, NULL, true, &result);
    setrlimit(RLIMIT_NOFILE, &before);
    assert_int_equal(error, -EMFILE);
    assert_true(late_error < 0);
    assert_int_equal(result.value, 123);
    assert_int_equal(run(return_0, &ample).end, WORKER_DONE);
}

#define WORKER(test) cmocka_unit_test_setup_teardown(test, make_block, drop_block)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WORKER(ends_are_told_apart),
        WORKER(timeout_kills_whatever_it_does),
        WORKER(worker_has_no_other_way_into_the_kernel),
        WORKER(worker_stays_one_process),
        WORKER(worker_gives_up_what_it_inherits),
        WORKER(worker_is_nobody_and_has_no_network_where_the_kernel_allows_it),
        WORKER(worker_that_runs_in_real_time_keeps_its_user),
        WORKER(bulk_data_arrives_whole_and_in_order),
        WORKER(last_burst_of_a_worker_is_kept),
        WORKER(what_was_sent_before_a_timeout_is_kept),
        WORKER(worker_dies_with_its_parent),
        WORKER(signals_in_the_parent_disturb_nothing),
        WORKER(two_workers_at_a_time),
        WORKER(many_runs_leave_nothing_open),
        WORKER(failure_to_start_is_an_error),
    };

    return cmocka_run_group_tests_name("worker", tests, NULL, NULL);
}
