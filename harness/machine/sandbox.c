/* SPDX-License-Identifier: GPL-2.0-or-later */
/* sandbox.c - see sandbox.h. */
#define _GNU_SOURCE 1
#include <asm/prctl.h>
#include <errno.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/filter.h"
#include "machine/machine_private.h"
#include "machine/sandbox.h"

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
    { SYS_futex, ALLOW, ANY },
    /* memory of the allocator: anonymous, never executable, never on top of something */
    { SYS_brk, ALLOW, ANY },
    { SYS_mmap, ALLOW,
      IF2(IS(2, PROT_EXEC, 0), IS(3, MAP_ANONYMOUS | MAP_WITHOUT, MAP_ANONYMOUS)) },
    { SYS_munmap, ALLOW, ANY },
    { SYS_madvise, ALLOW, ANY },
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

int sandbox_enter(const struct sandbox *sandbox)
{
    struct filter filter;

    if (sandbox->begin >> 32 != sandbox->end >> 32)
        return -EINVAL;
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
