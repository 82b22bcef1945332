/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_child.c - work on hostile bytes in a process of its own (docs/decisions.md, I3, I13).
 *
 * libdw and Capstone are large, are not ours, and read what the author of a module chose. Whatever
 * happens to them must not happen to the harness: the child has no system call but those that get
 * memory and end it, and limits on memory and time.
 */
#include "image/image_private.h"

#include <errno.h>
#include <seccomp.h>
#include <signal.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define CPU_SECONDS 4u
#define ALL_SECONDS 10u
#define MORE_MEMORY ((rlim_t)512 << 20)

static bool limit(int resource, rlim_t value)
{
    struct rlimit limits = { .rlim_cur = value, .rlim_max = value };
    return setrlimit(resource, &limits) == 0;
}

static bool limit_memory(void)
{
    unsigned long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (file == NULL)
        return false;
    int got = fscanf(file, "%lu", &pages);
    fclose(file);
    rlim_t now = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE);
    return got == 1 && limit(RLIMIT_AS, now + MORE_MEMORY);
}

static bool add_rules(scmp_filter_ctx filter, uint32_t action, const int *calls, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (seccomp_rule_add(filter, action, calls[i], 0) != 0)
            return false;
    }
    return true;
}

/* Nothing that it could break is within reach: no files, no processes, no signals. */
static bool only_compute(void)
{
    /* sigaltstack: AddressSanitizer, when the harness is built with it, looks before _exit(). */
    static const int allowed[] = { SCMP_SYS(brk),      SCMP_SYS(mmap),       SCMP_SYS(munmap),
                                   SCMP_SYS(mremap),   SCMP_SYS(madvise),    SCMP_SYS(futex),
                                   SCMP_SYS(exit),     SCMP_SYS(exit_group), SCMP_SYS(rt_sigreturn),
                                   SCMP_SYS(mprotect), SCMP_SYS(sigaltstack) };
    /* What a process does that has noticed its own end, and must not try for ever. */
    static const int last_words[] = { SCMP_SYS(write), SCMP_SYS(writev), SCMP_SYS(tgkill) };
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    return filter != NULL &&
           add_rules(filter, SCMP_ACT_ALLOW, allowed, sizeof allowed / sizeof allowed[0]) &&
           add_rules(filter, SCMP_ACT_KILL_PROCESS, last_words,
                     sizeof last_words / sizeof last_words[0]) &&
           seccomp_load(filter) == 0;
}

/* A crash in here is expected and is nobody's business: no handler of the harness may see it. */
static void forget_signals(void)
{
    static const int signals[] = { SIGSEGV, SIGBUS,  SIGFPE,  SIGILL, SIGABRT, SIGTRAP,
                                   SIGSYS,  SIGALRM, SIGXCPU, SIGINT, SIGTERM, SIGPIPE };
    sigset_t none;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++)
        signal(signals[i], SIG_DFL);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

static _Noreturn void child(void (*work)(const struct image *, void *), const struct image *image,
                            void *block)
{
    forget_signals();
    alarm(ALL_SECONDS);
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && limit(RLIMIT_CORE, 0) &&
        limit(RLIMIT_CPU, CPU_SECONDS) && limit_memory() && only_compute())
        work(image, block);
    _exit(0);
}

bool image_in_child(void (*work)(const struct image *, void *), const struct image *image,
                    void *block)
{
    pid_t pid = fork();
    if (pid < 0)
        return false;
    if (pid == 0)
        child(work, image, block);
    int status = 0;
    while (waitpid(pid, &status, 0) < 0) {
        /* ECHILD: SIGCHLD is ignored in this process; the child has ended all the same. */
        if (errno != EINTR)
            break;
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}
