/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_seal.c - a sealed machine in its worker: what module code may not do, and what
 * happens to those that do it. Every case runs in a process of its own kind: worker_run(). */
#define _GNU_SOURCE 1
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "machine/worker.h"
#include "machine_fixture.h"

#define MAX_CALLS 96

/* One call of the module in the worker. */
struct sealed_call {
    const char *function;
    uint64_t argument;  /* or, when words is set, the address of */
    uint64_t words[4];  /* what call_library wants: function and three arguments */
    const char *name;   /* of the system call */
    bool parent;        /* argument is the parent's process number, known there only */
    const char *blamed; /* label: expected pc */
    long syscall;       /* expected number */
};

/* Copied into the worker by the fork. */
struct sealed_run {
    const struct image *image;
    const struct sealed_call *calls;
    size_t count;
    pid_t parent;
    int (*afterwards)(struct machine *); /* in the worker, sealed; may be NULL */
};

/* Shared with the worker. */
struct sealed_report {
    char why[MACHINE_WHY];
    size_t called;
    int64_t notes[8];
    struct machine_outcome outcomes[MAX_CALLS];
    char bulk[256]; /* collected by the parent */
    size_t bulk_size;
};

static struct sealed_report *report; /* the block, at the same place in both processes */
static int evidence = -1;            /* in the worker */

static int run_sealed(void *argument, void *shared, int pipe_fd)
{
    const struct machine_config config = { .kind = fixture_kind,
                                           .seed = 21,
                                           .hang_ns = TEST_HANG_NS };
    const struct sealed_run *run = argument;
    struct machine *machine;

    (void)shared;
    evidence = pipe_fd;
    if (machine_load(&machine, run->image, &config, report->why) != 0 ||
        machine_seal(machine, pipe_fd, report->why) != 0)
        return 1;
    for (size_t i = 0; i < run->count; i++) {
        struct sealed_call now = run->calls[i];
        uint64_t first = now.parent ? (uint64_t)run->parent : now.argument;

        if (now.parent)
            now.words[1] = first;
        machine_call(machine, image_export(run->image, now.function)->vaddr,
                     now.words[0] != 0 ? (void *)now.words : (void *)first, &report->outcomes[i]);
        report->called++;
    }
    return run->afterwards != NULL ? run->afterwards(machine) : 0;
}

static void collect(void *argument, const void *shared, const void *data, size_t size)
{
    size_t room = sizeof report->bulk - report->bulk_size;

    (void)argument;
    (void)shared;
    size = size < room ? size : room;
    if (size > 0)
        memcpy(report->bulk + report->bulk_size, data, size);
    report->bulk_size += size;
}

static struct worker_result in_worker(const struct sealed_call *calls, size_t count,
                                      int (*afterwards)(struct machine *))
{
    struct image *image = fixture_image("hostile");
    struct sealed_run run = { image, calls, count, getpid(), afterwards };
    struct worker_limits limits = {
        .wall_ns = 20000000000u,
        .memory_bytes = fixture_kind == MACHINE_NATIVE ? 0 : MACHINE_INSTRUMENTED_MEMORY,
    };
    struct worker_result result = { .end = WORKER_FAILED };

    if (report != NULL)
        worker_block_free(report, sizeof *report);
    report = worker_block(sizeof *report);
    assert_non_null(report);
    if (calls != NULL)
        for (size_t i = 0; i < count; i++)
            assert_non_null(image_export(image, calls[i].function));
    assert_int_equal(worker_run(run_sealed, &run, report, &limits, collect, NULL, true, &result),
                     0);
    assert_string_equal(report->why, "");
    if (result.reason[0] != '\0')
        print_message("  worker says: %s\n", result.reason);
    image_close(image);
    return result;
}

static uint64_t label(const char *name)
{
    struct image *image = fixture_image("hostile");
    const struct image_symbol *symbol = image_export(image, name);
    uint64_t vaddr;

    assert_non_null(symbol);
    vaddr = symbol->vaddr;
    image_close(image);
    return vaddr;
}

static void module_asks_the_kernel_in_vain(void **state)
{
    static const struct sealed_call calls[] = {
        { .function = "kill_process", .parent = true, .blamed = "kill_process_at", .syscall = 62 },
        { .function = "exit_group_0", .blamed = "exit_group_0_at", .syscall = 231 },
        { .function = "write_standard_output", .blamed = "write_standard_output_at", .syscall = 1 },
        { .function = "write_evidence",
          .argument = 3,
          .blamed = "write_evidence_at",
          .syscall = 1 },
        { .function = "fork_bomb", .blamed = "fork_bomb_at", .syscall = 57 },
        { .function = "get_process_number", .blamed = "get_process_number_at", .syscall = 39 },
        { .function = "x32_call", .blamed = "x32_call_at", .syscall = 0x40000027 },
        { .function = "return_from_no_signal",
          .blamed = "return_from_no_signal_at",
          .syscall = 15 },
        { .function = "hidden_call", .blamed = "hidden_call_at", .syscall = 39 },
    };
    struct worker_result result = in_worker(calls, COUNT(calls), NULL);

    (void)state;
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(report->called, COUNT(calls));
    for (size_t i = 0; i < COUNT(calls); i++) {
        const struct machine_outcome *outcome = &report->outcomes[i];

        print_message("  %s\n", calls[i].function);
        assert_int_equal(outcome->kind, MACHINE_SYSCALL);
        assert_int_equal(outcome->fault.signal, SIGSYS);
        assert_int_equal(outcome->fault.syscall, calls[i].syscall);
        assert_false(outcome->fault.syscall_i386);
        assert_true(outcome->fault.in_module);
        assert_int_equal(outcome->fault.pc, label(calls[i].blamed));
    }
    assert_int_equal(report->bulk_size, 0);
}

static void old_ways_into_the_kernel_are_closed(void **state)
{
    static const struct sealed_call calls[] = {
        { .function = "int_0x80" },
        { .function = "sysenter_call" },
        { .function = "call_vsyscall" },
        { .function = "end_normally" },
    };
    struct worker_result result = in_worker(calls, COUNT(calls), NULL);
    const struct machine_outcome *outcome = report->outcomes;

    (void)state;
    assert_int_equal(result.end, WORKER_DONE);
    /* A kernel without 32-bit support makes an exception of it, at the same place. */
    assert_true(outcome[0].kind == MACHINE_SYSCALL || outcome[0].kind == MACHINE_FAULT);
    if (outcome[0].kind == MACHINE_SYSCALL) {
        assert_true(outcome[0].fault.syscall_i386);
        assert_int_equal(outcome[0].fault.syscall, 20);
    }
    assert_int_equal(outcome[0].fault.pc, label("int_0x80_at"));
    /* AMD: no such instruction. Intel: arrives as a 32-bit call from nowhere. */
    assert_int_not_equal(outcome[1].kind, MACHINE_RETURNED);
    if (outcome[1].fault.signal == SIGILL)
        assert_int_equal(outcome[1].fault.pc, label("sysenter_call_at"));
    print_message("  int 0x80: outcome %d, sysenter: %d signal %d, vsyscall: %d\n",
                  (int)outcome[0].kind, (int)outcome[1].kind, outcome[1].fault.signal,
                  (int)outcome[2].kind);
    /* time() if the kernel emulates the page, nothing there otherwise. */
    assert_int_not_equal(outcome[2].kind, MACHINE_RETURNED);
    if (outcome[2].kind == MACHINE_SYSCALL)
        assert_int_equal(outcome[2].fault.syscall, SYS_time);
    assert_int_equal(outcome[2].fault.pc, label("call_vsyscall_back"));
    assert_int_equal(outcome[3].kind, MACHINE_RETURNED);
    assert_int_equal(outcome[3].value, 7);
}

#define LIBRARY(function, a, b, c)                                                                 \
    {                                                                                              \
        (uint64_t)(uintptr_t)(function), (uint64_t)(a), (uint64_t)(b), c                           \
    }

static void library_code_helps_the_module_no_further(void **state)
{
    const struct sealed_call calls[] = {
        { .words = LIBRARY(kill, 0, SIGKILL, 0), .parent = true, .syscall = SYS_kill },
        { .words = LIBRARY(open, "/etc/passwd", O_RDONLY, 0), .syscall = SYS_openat },
        { .words = LIBRARY(socket, AF_INET, SOCK_STREAM, 0), .syscall = SYS_socket },
        { .words = LIBRARY(execve, "/bin/sh", 0, 0), .syscall = SYS_execve },
        { .words = LIBRARY(mprotect, 0x10000, 4096, PROT_EXEC), .syscall = SYS_mprotect },
        { .words = LIBRARY(vfork, 0, 0, 0), .syscall = SYS_vfork },
        { .words = LIBRARY(read, 3, 0, 0), .syscall = SYS_read },
        { .words = LIBRARY(write, 1, "x", 1), .syscall = SYS_write },
        { .words = LIBRARY(dup, 3, 0, 0), .syscall = SYS_dup },
        { .words = LIBRARY(tgkill, 1, 1, SIGKILL), .syscall = SYS_tgkill },
        { .words = LIBRARY(prctl, PR_SET_PDEATHSIG, 0, 0), .syscall = SYS_prctl },
    };
    struct sealed_call named[COUNT(calls)];
    struct worker_result result;

    (void)state;
    memcpy(named, calls, sizeof calls);
    for (size_t i = 0; i < COUNT(calls); i++)
        named[i].function = "call_library";
    result = in_worker(named, COUNT(calls), NULL);
    assert_int_equal(result.end, WORKER_DONE);
    for (size_t i = 0; i < COUNT(calls); i++) {
        const struct machine_outcome *outcome = &report->outcomes[i];

        print_message("  system call %ld\n", calls[i].syscall);
        assert_int_equal(outcome->kind, MACHINE_SYSCALL);
        assert_int_equal(outcome->fault.syscall, calls[i].syscall);
        assert_false(outcome->fault.in_module);
        assert_null(outcome->fault.service);
        if (calls[i].syscall == SYS_vfork) /* takes its return address off the stack */
            continue;
        assert_true(outcome->fault.has_pc);
        assert_int_equal(outcome->fault.pc, label("call_library_back"));
    }
}

#define ASKS(name_)                                                                                \
    {                                                                                              \
        .function = "call_library", .words = LIBRARY(syscall, SYS_##name_, 0, 0),                  \
        .syscall = SYS_##name_, .name = #name_                                                     \
    }

/* Whatever reaches beyond the process, or makes it more than it is. */
static void every_call_that_reaches_out_is_refused_and_named(void **state)
{
    static const struct sealed_call calls[] = {
        ASKS(fork),
        ASKS(clone),
        ASKS(clone3),
        ASKS(execveat),
        ASKS(ptrace),
        ASKS(process_vm_readv),
        ASKS(kill),
        ASKS(tkill),
        ASKS(process_vm_writev),
        ASKS(tgkill),
        ASKS(pidfd_open),
        ASKS(pidfd_send_signal),
        ASKS(pidfd_getfd),
        ASKS(setsid),
        ASKS(rt_sigqueueinfo),
        ASKS(setpgid),
        ASKS(unshare),
        ASKS(setns),
        ASKS(setuid),
        ASKS(setresuid),
        ASKS(capset),
        ASKS(prctl),
        ASKS(seccomp),
        ASKS(personality),
        ASKS(open),
        ASKS(openat),
        ASKS(openat2),
        ASKS(creat),
        ASKS(unlink),
        ASKS(rename),
        ASKS(mkdir),
        ASKS(truncate),
        ASKS(ftruncate),
        ASKS(mount),
        ASKS(umount2),
        ASKS(pivot_root),
        ASKS(chroot),
        ASKS(chdir),
        ASKS(open_by_handle_at),
        ASKS(read),
        ASKS(pread64),
        ASKS(pwrite64),
        ASKS(sendfile),
        ASKS(splice),
        ASKS(copy_file_range),
        ASKS(dup),
        ASKS(dup2),
        ASKS(fcntl),
        ASKS(ioctl),
        ASKS(close),
        ASKS(memfd_create),
        ASKS(socket),
        ASKS(socketpair),
        ASKS(sendmsg),
        ASKS(connect),
        ASKS(bind),
        ASKS(sendto),
        ASKS(shmget),
        ASKS(shmat),
        ASKS(msgget),
        ASKS(mq_open),
        ASKS(semget),
        ASKS(io_uring_setup),
        ASKS(io_setup),
        ASKS(bpf),
        ASKS(userfaultfd),
        ASKS(keyctl),
        ASKS(perf_event_open),
        ASKS(setpriority),
        ASKS(setrlimit),
        ASKS(prlimit64),
        ASKS(sched_setscheduler),
        ASKS(rt_sigaction),
        ASKS(timer_delete),
        ASKS(sched_setaffinity),
        ASKS(timer_create),
        ASKS(setitimer),
        ASKS(alarm),
        ASKS(msync),
        ASKS(pkey_mprotect),
        ASKS(remap_file_pages),
        ASKS(mlock),
        ASKS(mlockall),
        ASKS(modify_ldt),
        ASKS(reboot),
        ASKS(init_module),
        ASKS(kexec_load),
    };
    struct worker_result result = in_worker(calls, COUNT(calls), NULL);
    char name[MACHINE_CALL_NAME];

    (void)state;
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(report->called, COUNT(calls));
    for (size_t i = 0; i < COUNT(calls); i++) {
        const struct machine_outcome *outcome = &report->outcomes[i];

        if (outcome->kind != MACHINE_SYSCALL || outcome->fault.syscall != calls[i].syscall)
            fail_msg("%s: outcome %d, system call %ld", calls[i].name, (int)outcome->kind,
                     outcome->fault.syscall);
        machine_system_call_name(&outcome->fault, name);
        assert_string_equal(name, calls[i].name);
        assert_int_equal(outcome->fault.pc, label("call_library_back"));
    }
    machine_system_call_name(&(struct machine_fault){ .syscall = 20, .syscall_i386 = true }, name);
    assert_string_equal(name, "getpid");
    machine_system_call_name(&(struct machine_fault){ .syscall = 292, .syscall_arm = true }, name);
    assert_string_equal(name, "recvfrom");
    machine_system_call_name(&(struct machine_fault){ .syscall = 100000 }, name);
    assert_string_equal(name, "unknown");
}

/* Allowed to the host's allocator, in its own way only. */
static void memory_is_to_be_had_for_the_process_alone(void **state)
{
    const struct sealed_call calls[] = {
        { .function = "call_library", .words = LIBRARY(syscall, SYS_madvise, 0, 0) },
        { .function = "call_library", .words = LIBRARY(syscall, SYS_futex, 0, 6) },
        { .function = "eat_memory", .words = { (uint64_t)(uintptr_t)mmap, 16u << 20 } },
        { .function = "end_normally" },
    };

    (void)state;
    assert_int_equal(in_worker(calls, COUNT(calls), NULL).end, WORKER_DONE);
    if (!UNDER_ADDRESS_SANITIZER)
        assert_int_equal(report->outcomes[0].kind, MACHINE_SYSCALL);
    assert_int_equal(report->outcomes[1].kind, MACHINE_SYSCALL);
    assert_int_equal(report->outcomes[2].kind, MACHINE_RETURNED);
    assert_in_range(report->outcomes[2].value, 1, 64); /* of the 1 GiB that it may have */
    assert_int_equal(report->outcomes[3].value, 7);
}

/* Where the kernel returns from handlers. */
static uint64_t restorer(void)
{
    struct {
        void *handler;
        uint64_t flags;
        void *restorer;
        uint64_t mask;
    } action = { .restorer = NULL };
    struct sigaction mine, before;

    memset(&mine, 0, sizeof mine);
    mine.sa_handler = SIG_DFL;
    sigaction(SIGUSR2, &mine, &before); /* the C library adds its restorer */
    syscall(SYS_rt_sigaction, SIGUSR2, NULL, &action, sizeof action.mask);
    return (uint64_t)(uintptr_t)action.restorer;
}

/* No watchdog can reach it: the parent can. */
static void module_that_keeps_every_signal_out_ends_with_its_time(void **state)
{
    const struct sealed_call call = { .function = "spin_without_signals", .argument = restorer() };
    struct image *image = fixture_image("hostile");
    struct sealed_run run = { image, &call, 1, getpid(), NULL };
    const struct worker_limits limits = { .wall_ns = 1000000000u };
    struct worker_result result;

    (void)state;
    assert_true(call.argument != 0);
    assert_int_equal(worker_run(run_sealed, &run, report, &limits, collect, NULL, true, &result),
                     0);
    assert_int_equal(result.end, WORKER_TIMEOUT);
    image_close(image);
}

static void module_that_unmaps_the_hosts_memory_kills_only_its_worker(void **state)
{
    struct sealed_call call = { .function = "call_library" };
    struct worker_result result;

    (void)state;
    call.words[0] = (uint64_t)(uintptr_t)munmap;
    call.words[1] = (uint64_t)(uintptr_t)report & ~UINT64_C(4095);
    call.words[2] = sizeof *report;
    /* The block moves when it is made anew: to the same place, as nothing else was mapped. */
    result = in_worker(&call, 1, NULL);
    if ((uint64_t)(uintptr_t)report == call.words[1]) {
        assert_int_equal(result.end, WORKER_KILLED);
        assert_true(result.value == SIGSEGV || result.value == SIGBUS);
    }
}

/* Nothing is asked of the kernel: rules about the file look for it (sandbox.h). */
static void clocks_that_need_no_system_call_are_not_seen(void **state)
{
    static struct timespec now;
    const struct sealed_call calls[] = {
        { .function = "read_clock" },
        { .function = "call_library", .words = LIBRARY(clock_gettime, CLOCK_MONOTONIC, &now, 0) },
    };

    (void)state;
    assert_int_equal(in_worker(calls, COUNT(calls), NULL).end, WORKER_DONE);
    assert_int_equal(report->outcomes[0].kind, MACHINE_RETURNED);
    assert_int_equal(report->outcomes[1].kind, MACHINE_RETURNED);
    assert_int_equal(report->outcomes[1].value, 0);
}

static int use_memory(struct machine *machine)
{
    char *block = malloc(100), *large;

    (void)machine;
    for (size_t size = 100; size < 40u << 20; size *= 3) {
        large = realloc(block, size);
        if (large == NULL)
            return 2;
        memset(large, 1, size);
        block = large;
    }
    free(block);
    return 0;
}

static int write_evidence(struct machine *machine)
{
    (void)machine;
    return write(evidence, "seen", 4) == 4 ? 0 : 2;
}

static int refuse_more(struct machine *machine)
{
    void *host, *module;
    char why[MACHINE_WHY];

    report->notes[0] = machine_map(machine, "late", 16, MACHINE_REGION_READ, &host, &module, why);
    report->notes[1] = machine_seal(machine, -1, why);
    machine_unload(machine);
    return 0;
}

static void host_can_go_on_when_sealed(void **state)
{
    static const struct sealed_call call = { .function = "end_normally" };

    (void)state;
    assert_int_equal(in_worker(&call, 1, use_memory).end, WORKER_DONE);
    assert_int_equal(in_worker(&call, 1, write_evidence).end, WORKER_DONE);
    assert_int_equal(report->bulk_size, 4);
    assert_memory_equal(report->bulk, "seen", 4);
    assert_int_equal(in_worker(&call, 1, refuse_more).end, WORKER_DONE);
    assert_int_equal(report->notes[0], -EPERM);
    assert_int_equal(report->notes[1], -EALREADY);
}

/* Defects of the harness: nothing is active that could be charged. */
static int harness_opens(struct machine *machine)
{
    (void)machine;
    return open("/dev/null", O_RDONLY);
}

static int harness_reads_null(struct machine *machine)
{
    (void)machine;
    __asm__ volatile("movb $0, 0");
    return 0;
}

static int harness_traps(struct machine *machine)
{
    (void)machine;
    __asm__ volatile("int3");
    return 0;
}

static int harness_divides(struct machine *machine)
{
    (void)machine;
    __asm__ volatile("xor %%ecx, %%ecx\n\txor %%edx, %%edx\n\tdiv %%ecx" ::: "rax", "rcx", "rdx");
    return 0;
}

static int harness_aborts(struct machine *machine)
{
    (void)machine;
    abort();
}

static const struct {
    int (*defect)(struct machine *);
    int signal;
} defects[] = {
    { harness_opens, SIGSYS },   { harness_reads_null, SIGSEGV }, { harness_traps, SIGTRAP },
    { harness_divides, SIGFPE }, { harness_aborts, SIGABRT },
};

static void harness_defects_end_the_worker_by_their_own_signal(void **state)
{
    (void)state;
    for (size_t i = 0; i < COUNT(defects); i++) {
        struct worker_result result = in_worker(NULL, 0, defects[i].defect);

        assert_int_equal(result.end, WORKER_KILLED);
        assert_int_equal(result.value, defects[i].signal);
        assert_int_equal(result.reason[0] != '\0', defects[i].signal != SIGABRT);
    }
}

static void module_that_ends_the_process_is_not_done(void **state)
{
    const struct sealed_call exits = { .function = "call_library",
                                       .words = LIBRARY(_exit, 0, 0, 0) };
    const struct sealed_call aborts = { .function = "call_library",
                                        .words = LIBRARY(abort, 0, 0, 0) };
    struct worker_result result;

    (void)state;
    result = in_worker(&exits, 1, NULL);
    assert_int_equal(result.end, WORKER_EXITED);
    assert_int_equal(result.value, 0);
    assert_int_equal(report->called, 0);
    result = in_worker(&aborts, 1, NULL);
    assert_int_equal(result.end, WORKER_KILLED);
    assert_int_equal(result.value, SIGABRT);
}

/* Overwrites the frames of the host that the call has to go back through. */
static int destroy_stack(struct machine *machine)
{
    uint64_t fill[2] = { (uint64_t)__builtin_frame_address(0) - 2048, 4096 };
    struct machine_outcome outcome;

    machine_call(machine, (uint64_t)report->notes[0], fill, &outcome);
    return 0;
}

static int destroy(struct machine *machine)
{
    report->notes[0] = report->outcomes[0].value - (int64_t)machine_address(machine, 0);
    return destroy_stack(machine);
}

static void module_that_destroys_the_host_kills_only_its_worker(void **state)
{
    static const struct sealed_call call = { .function = "where_is_fill_memory" };
    struct worker_result result = in_worker(&call, 1, destroy);

    (void)state;
    assert_int_equal(result.end, WORKER_KILLED);
    assert_true(result.value == SIGSEGV || result.value == SIGBUS || result.value == SIGABRT ||
                result.value == SIGSYS);
}

static sigset_t every_signal;

/* Not even one that tries to keep the watchdog out. */
static void hang_is_found_when_sealed(void **state)
{
    const struct sealed_call calls[] = {
        { .function = "end_normally" },
        { .function = "hang" },
        { .function = "end_normally" },
        { .function = fixture_kind == MACHINE_NATIVE ? "call_library" : "end_normally",
          .words = LIBRARY(sigprocmask, SIG_BLOCK, &every_signal, 0) },
        { .function = "hang" },
        { .function = "end_normally" },
    };

    (void)state;
    sigfillset(&every_signal);
    assert_int_equal(in_worker(calls, COUNT(calls), NULL).end, WORKER_DONE);
    assert_int_equal(report->outcomes[4].kind, MACHINE_HANG);
    assert_int_equal(report->outcomes[5].kind, MACHINE_RETURNED);
    assert_int_equal(report->outcomes[1].kind, MACHINE_HANG);
    assert_int_equal(report->outcomes[1].fault.pc, label("hang"));
    assert_int_equal(report->outcomes[2].value, 7);
}

int main(void)
{
    const struct CMUnitTest both[] = {
        cmocka_unit_test(module_asks_the_kernel_in_vain),
        cmocka_unit_test(old_ways_into_the_kernel_are_closed),
        cmocka_unit_test(host_can_go_on_when_sealed),
        cmocka_unit_test(harness_defects_end_the_worker_by_their_own_signal),
        cmocka_unit_test(hang_is_found_when_sealed),
    };
    const struct CMUnitTest native[] = {
        cmocka_unit_test(library_code_helps_the_module_no_further),
        cmocka_unit_test(every_call_that_reaches_out_is_refused_and_named),
        cmocka_unit_test(memory_is_to_be_had_for_the_process_alone),
        cmocka_unit_test(module_that_keeps_every_signal_out_ends_with_its_time),
        cmocka_unit_test(module_that_unmaps_the_hosts_memory_kills_only_its_worker),
        cmocka_unit_test(clocks_that_need_no_system_call_are_not_seen),
        cmocka_unit_test(module_that_ends_the_process_is_not_done),
        cmocka_unit_test(module_that_destroys_the_host_kills_only_its_worker),
    };
    int failed = cmocka_run_group_tests_name("sealed, native", both, NULL, NULL) +
                 cmocka_run_group_tests_name("sealed, with the host in reach", native, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("sealed, instrumented", both, NULL, NULL);
}
