/* SPDX-License-Identifier: GPL-2.0-or-later */
/* confine.c - see confine.h. */
#define _GNU_SOURCE 1
#include <errno.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/confine.h"
#include "machine/filter.h"
#include "machine/worker.h"

enum { KEEP_FD = 3, REPORT_FD = 4, FIRST_UNUSED_FD = 5, FD_LIMIT = 16 };

#define DENY (SECCOMP_RET_ERRNO | EPERM)
#define INT  UINT32_MAX

/* Never, whatever the arguments. */
static const int denied[] = {
    SYS_fork,       SYS_vfork,           SYS_clone,
    SYS_execve,     SYS_execveat,        SYS_setsid,
    SYS_setpgid,    SYS_ptrace,          SYS_process_vm_readv,
    SYS_setns,      SYS_unshare,         SYS_process_vm_writev,
    SYS_tkill,      SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo,
    SYS_pidfd_open, SYS_setrlimit,       SYS_pidfd_send_signal,
    SYS_kexec_load, SYS_reboot,          SYS_io_uring_setup,
    SYS_bpf,        SYS_userfaultfd,     SYS_io_uring_enter,
    SYS_socket,     SYS_socketpair,      SYS_perf_event_open,
    SYS_mount,      SYS_umount2,         SYS_pivot_root,
    SYS_chroot,     SYS_keyctl,          SYS_add_key,
    SYS_iopl,       SYS_ioperm,          SYS_open_by_handle_at,
    SYS_kcmp,       SYS_init_module,     SYS_finit_module,
    SYS_acct,       SYS_request_key,     SYS_delete_module,
    SYS_swapon,     SYS_swapoff,         SYS_process_madvise,
};

static void default_signals(void)
{
    struct sigaction action;
    sigset_t none;

    memset(&action, 0, sizeof action);
    action.sa_handler = SIG_DFL;
    for (int sig = 1; sig < NSIG; sig++)
        sigaction(sig, &action, NULL); /* some cannot be set, and need not be */
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

/*
 * Away from the network, from System V IPC, and from everybody's user numbers: in a user namespace
 * without a mapping it is nobody. That one takes away priorities and locked memory, too, and is not
 * for workers that run in real time. Where the kernel forbids them the rest has to do: the
 * filter lets no socket be made either.
 */
static unsigned leave_namespaces(bool real_time)
{
    unsigned lacks = 0;

    if (!real_time && unshare(CLONE_NEWUSER) != 0)
        lacks |= WORKER_USER_NAMESPACE;
    if (unshare(CLONE_NEWNET) != 0)
        lacks |= WORKER_NETWORK_NAMESPACE;
    if (unshare(CLONE_NEWIPC | CLONE_NEWUTS) != 0)
        lacks |= WORKER_IPC_NAMESPACE;
    return lacks;
}

/* A worker of root is to be no more than anybody's, except for running in real time. */
static int drop_capabilities(bool real_time)
{
    const uint32_t allowed = real_time ? 1u << CAP_SYS_NICE | 1u << CAP_IPC_LOCK : 0;
    struct __user_cap_header_struct header = { _LINUX_CAPABILITY_VERSION_3, 0 };
    struct __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3];

    if (syscall(SYS_capget, &header, data) != 0)
        return errno;
    for (int i = 0; i < _LINUX_CAPABILITY_U32S_3; i++) {
        uint32_t keep = i == 0 ? allowed : 0;

        data[i].permitted &= keep;
        data[i].effective &= keep;
        data[i].inheritable = 0;
    }
    return syscall(SYS_capset, &header, data) != 0 ? errno : 0;
}

static int bind_to_parent(pid_t parent)
{
    if (setpgid(0, 0) != 0 && getpgrp() != getpid())
        return errno;
    if (prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0) != 0)
        return errno;
    /* It may have died before the signal was asked for. */
    return getppid() == parent ? 0 : ESRCH;
}

static void close_from(int first)
{
    struct rlimit limit;

    if (syscall(SYS_close_range, first, ~0u, 0) == 0)
        return;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur > 1u << 20)
        limit.rlim_cur = 1u << 20;
    for (int fd = first; fd < (int)limit.rlim_cur; fd++)
        close(fd);
}

/* keep_fd and report_fd to their numbers, null to the standard ones, the rest closed. Goes by way
 * of high numbers, so that no descriptor lands on one that is still needed. */
static int arrange_fds(struct confinement *confinement)
{
    int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    int high_null = fcntl(null, F_DUPFD, 2 * FD_LIMIT);
    int high_report = fcntl(confinement->report_fd, F_DUPFD, 2 * FD_LIMIT);
    int high_keep =
        confinement->keep_fd < 0 ? -1 : fcntl(confinement->keep_fd, F_DUPFD, 2 * FD_LIMIT);

    if (high_null < 0 || high_report < 0 || (confinement->keep_fd >= 0 && high_keep < 0))
        return errno;
    if (dup2(high_null, 0) < 0 || dup2(high_null, 1) < 0 || dup2(high_null, 2) < 0)
        return errno;
    if (dup2(high_report, REPORT_FD) < 0 || (high_keep >= 0 && dup2(high_keep, KEEP_FD) < 0))
        return errno;
    if (high_keep < 0)
        close(KEEP_FD);
    close_from(FIRST_UNUSED_FD);
    confinement->report_fd = REPORT_FD;
    confinement->keep_fd = high_keep < 0 ? -1 : KEEP_FD;
    return 0;
}

/* Bytes of address space in use. */
static uint64_t address_space(void)
{
    unsigned long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");

    if (file != NULL) {
        if (fscanf(file, "%llu", &pages) != 1)
            pages = 0;
        fclose(file);
    }
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

static int limit_to(int resource, uint64_t value)
{
    struct rlimit limit;

    if (getrlimit((unsigned)resource, &limit) != 0)
        return errno;
    if (value < limit.rlim_max)
        limit.rlim_max = value;
    limit.rlim_cur = limit.rlim_max;
    return setrlimit((unsigned)resource, &limit) != 0 ? errno : 0;
}

static int set_limits(uint64_t in_use, uint64_t memory_bytes, uint64_t cpu_seconds)
{
    const struct {
        int resource;
        uint64_t value;
    } limits[] = {
        { RLIMIT_CORE, 0 },
        { RLIMIT_AS, in_use < UINT64_MAX - memory_bytes ? in_use + memory_bytes : UINT64_MAX },
        { RLIMIT_NOFILE, FD_LIMIT },
        { RLIMIT_NPROC, 0 }, /* the filter sees to it, too */
        { RLIMIT_MEMLOCK, memory_bytes },
        { RLIMIT_MSGQUEUE, 0 },
        /* Should the parent be kept from killing it. */
        { RLIMIT_CPU, cpu_seconds != 0 ? cpu_seconds : RLIM_INFINITY },
    };
    int error = 0;

    for (size_t i = 0; i < sizeof limits / sizeof limits[0] && error == 0; i++)
        error = limit_to(limits[i].resource, limits[i].value);
    /* Dumps that go to a program (core_pattern with a pipe) do not heed RLIMIT_CORE. */
    if (error == 0 && prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0)
        error = errno;
    return error;
}

static int filter_calls(void)
{
    uint32_t self = (uint32_t)getpid();
    const struct filter_rule partly[] = {
        { SYS_clone3, SECCOMP_RET_ERRNO | ENOSYS, 0, { { 0, false, 0, 0 } } },
        { SYS_prlimit64, DENY, 1, { { 2, true, UINT64_MAX, 0 } } }, /* reading them is fine */
        { SYS_kill, DENY, 1, { { 0, true, INT, self } } },
        { SYS_tgkill, DENY, 1, { { 0, true, INT, self } } },
        { SYS_prctl, DENY, 1, { { 0, false, INT, PR_SET_PDEATHSIG } } },
        { SYS_prctl, DENY, 1, { { 0, false, INT, PR_SET_DUMPABLE } } },
    };
    struct filter filter;

    filter_begin(&filter, SECCOMP_RET_ERRNO | ENOSYS);
    for (size_t i = 0; i < sizeof denied / sizeof denied[0]; i++)
        filter_rule(&filter, &(struct filter_rule){ .number = denied[i], .action = DENY });
    for (size_t i = 0; i < sizeof partly / sizeof partly[0]; i++)
        filter_rule(&filter, &partly[i]);
    filter_end(&filter, SECCOMP_RET_ALLOW);
    return -filter_install(&filter);
}

int confine(struct confinement *confinement)
{
    uint64_t in_use;
    int error;

    default_signals();
    in_use = address_space();
    error = arrange_fds(confinement);
    if (error == 0)
        error = set_limits(in_use, confinement->memory_bytes, confinement->cpu_seconds);
    if (error == 0)
        confinement->lacks = leave_namespaces(confinement->real_time);
    if (error == 0)
        error = drop_capabilities(confinement->real_time);
    if (error == 0)
        error = bind_to_parent(confinement->parent);
    return error != 0 ? error : filter_calls();
}
