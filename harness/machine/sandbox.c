/* SPDX-License-Identifier: GPL-2.0-or-later */
/* sandbox.c - see sandbox.h. */
#define _GNU_SOURCE 1
#include <asm/prctl.h>
#include <errno.h>
#include <linux/futex.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/filter.h"
#include "machine/machine_private.h"
#include "machine/sandbox.h"
#include "machine/worker.h"

#define ALL         UINT64_MAX
#define INT         UINT32_MAX /* arguments of type int: the upper half is nobody's */
#define DENY(error) (SECCOMP_RET_ERRNO | (error))

/* Conditions of a row. */
#define ANY                                                                                        \
    0,                                                                                             \
    {                                                                                              \
        {                                                                                          \
            0, false, 0, 0                                                                         \
        }                                                                                          \
    }
#define IF(c)                                                                                      \
    1,                                                                                             \
    {                                                                                              \
        c                                                                                          \
    }
#define IF2(c, d)                                                                                  \
    2,                                                                                             \
    {                                                                                              \
        c, d                                                                                       \
    }
#define IF3(c, d, e)                                                                               \
    3,                                                                                             \
    {                                                                                              \
        c, d, e                                                                                    \
    }
#define IS(argument, mask, value)                                                                  \
    {                                                                                              \
        argument, false, mask, value                                                               \
    }

#ifdef ADDRESS_SANITIZER
/* Its allocator maps into address space that it reserved. */
#define MAP_WITHOUT 0
#else
#define MAP_WITHOUT (MAP_FIXED | MAP_FIXED_NOREPLACE)
#endif

#define MAP_SCARCE (MAP_HUGETLB | MAP_LOCKED | MAP_GROWSDOWN)

enum { ALLOW = SECCOMP_RET_ALLOW };

/* Fixed part: nothing here can reach beyond the process. */
static const struct filter_rule fixed_rules[] = {
    /* ends */
    { SYS_exit, ALLOW, ANY },
    { SYS_exit_group, ALLOW, ANY },
    /* signal handling: returning from handlers. Not their actions, and not the mask, which could
     * keep the watchdog out; abort() asks for it but can do without. */
    { SYS_rt_sigreturn, ALLOW, ANY },
    { SYS_rt_sigprocmask, DENY(EPERM), ANY },
    { SYS_restart_syscall, ALLOW, ANY },
    { SYS_sigaltstack, ALLOW, IF(IS(0, ALL, 0)) }, /* asking where it is */
    /* clocks that the vDSO does not serve, sleeping */
    { SYS_clock_gettime, ALLOW, ANY },
    { SYS_clock_getres, ALLOW, ANY },
    { SYS_clock_nanosleep, ALLOW, ANY },
    { SYS_nanosleep, ALLOW, ANY },
    { SYS_sched_yield, ALLOW, ANY },
    /* among the process's own threads, of which there is one */
    { SYS_futex, ALLOW, IF(IS(1, INT, FUTEX_WAKE | FUTEX_PRIVATE_FLAG)) },
    { SYS_futex, ALLOW, IF(IS(1, INT, FUTEX_WAIT | FUTEX_PRIVATE_FLAG)) },
    /* memory of the allocator: anonymous, never executable, never on top of something, nothing that
     * the computer has little of */
    { SYS_brk, ALLOW, ANY },
    { SYS_mmap, ALLOW,
      IF2(IS(2, PROT_EXEC, 0), IS(3, MAP_ANONYMOUS | MAP_WITHOUT | MAP_SCARCE, MAP_ANONYMOUS)) },
    { SYS_munmap, ALLOW, ANY },
#ifdef ADDRESS_SANITIZER
    { SYS_madvise, ALLOW, ANY },
#else
    { SYS_madvise, ALLOW, IF(IS(2, INT, MADV_DONTNEED)) },
    { SYS_madvise, ALLOW, IF(IS(2, INT, MADV_FREE)) },
#endif
    { SYS_mremap, DENY(ENOMEM), ANY }, /* realloc() copies then */
    { SYS_getrandom, DENY(ENOSYS), ANY },
    { SYS_getpid, ALLOW, ANY },
    { SYS_gettid, ALLOW, ANY },
    { SYS_sysinfo, ALLOW, ANY }, /* qsort() asks how much memory there is */
#ifdef ADDRESS_SANITIZER
    { SYS_mprotect, ALLOW, IF(IS(2, PROT_EXEC, 0)) },
#endif
};

/* The part that depends on the process. */
static void variable_rules(struct filter *filter, const struct sandbox *sandbox)
{
    const struct filter_rule rules[] = {
        /* abort() */
        { SYS_tgkill, ALLOW,
          IF3(IS(0, INT, (uint32_t)getpid()), IS(1, INT, (uint32_t)syscall(SYS_gettid)),
              IS(2, INT, SIGABRT)) },
        /* the fault handler's repair of a module that moved the thread pointer */
        { SYS_arch_prctl, ALLOW, IF2(IS(0, INT, ARCH_SET_FS), IS(1, ALL, sandbox->thread_base)) },
        { SYS_arch_prctl, ALLOW, IF2(IS(0, INT, ARCH_SET_GS), IS(1, ALL, sandbox->thread_block)) },
    };
    const struct filter_rule evidence[] = {
        { SYS_write, ALLOW, IF(IS(0, INT, (uint32_t)sandbox->evidence_fd)) },
        { SYS_writev, ALLOW, IF(IS(0, INT, (uint32_t)sandbox->evidence_fd)) },
    };

    const struct filter_rule alarm = { SYS_timer_settime, ALLOW,
                                       IF(IS(0, INT, (uint32_t)sandbox->alarm)) };

    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++)
        filter_rule(filter, &rules[i]);
    if (sandbox->alarm >= 0)
        filter_rule(filter, &alarm);
    for (size_t i = 0; i < sizeof evidence / sizeof evidence[0] && sandbox->evidence_fd >= 0; i++)
        filter_rule(filter, &evidence[i]);
}

#ifndef SYS_landlock_create_ruleset
#define SYS_landlock_create_ruleset 444
#define SYS_landlock_restrict_self  446
#endif

/*
 * A second lock on the files, should a system call ever slip through the filter: rules that handle
 * every access the kernel knows of, and allow none.
 */
static void lock_files(void)
{
    static const uint64_t since[] = { 13, 14, 15, 15, 16 }; /* accesses by version */
    const long version = syscall(SYS_landlock_create_ruleset, NULL, 0, 1);
    struct landlock_ruleset_attr rules = { .handled_access_fs = 0 };
    int ruleset;

    if (version >= 1) {
        rules.handled_access_fs = (UINT64_C(1) << since[version < 5 ? version - 1 : 4]) - 1;
        ruleset =
            (int)syscall(SYS_landlock_create_ruleset, &rules, sizeof rules.handled_access_fs, 0);
        if (ruleset >= 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
            syscall(SYS_landlock_restrict_self, ruleset, 0) == 0) {
            close(ruleset);
            return;
        }
        if (ruleset >= 0)
            close(ruleset);
    }
    worker_lacks(WORKER_LANDLOCK);
}

int sandbox_enter(const struct sandbox *sandbox)
{
    struct filter filter;

    if (sandbox->begin >> 32 != sandbox->end >> 32)
        return -EINVAL;
    lock_files();
    filter_begin(&filter, SECCOMP_RET_TRAP);
    filter_range(&filter, sandbox->begin, sandbox->end, SECCOMP_RET_TRAP);
    for (size_t i = 0; i < sizeof fixed_rules / sizeof fixed_rules[0]; i++)
        filter_rule(&filter, &fixed_rules[i]);
    variable_rules(&filter, sandbox);
    filter_end(&filter, SECCOMP_RET_TRAP);
    return filter_install(&filter);
}

int machine_seal(struct machine *machine, int evidence_fd, char why[MACHINE_WHY])
{
    const struct machine_reservation *around = &machine->regions[0].around;
    struct sandbox sandbox = { .begin = (uint64_t)around->base,
                               .end = (uint64_t)around->base + around->size,
                               .thread_base = machine_thread_base(),
                               .thread_block = machine_state.thread_block,
                               .evidence_fd = evidence_fd,
                               .alarm = machine_alarm_number(machine) };
    int error;

    why[0] = '\0';
    if (machine->sealed)
        return machine_fail(why, -EALREADY, "the process is sealed already");
    error = machine->ops->sealing != NULL ? machine->ops->sealing(machine, why) : 0;
    if (error != 0)
        return error;
    error = sandbox_enter(&sandbox);
    if (error != 0)
        return machine_fail(why, error, "the kernel takes no system call filter: %s",
                            strerror(-error));
    machine->sealed = true;
    return 0;
}
