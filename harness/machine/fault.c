/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fault.c - processor exceptions, forbidden system calls and watchdog ticks.
 *
 * The handler does not jump out: it writes down what happened, makes the interrupted context the
 * trampoline's exit (machine_abandon) with a fresh processor state, and returns. So the kernel
 * itself restores signal mask and signal stack, nested signals cannot pile up, and a call costs
 * nothing for it. All signals are blocked meanwhile: an exception in the handler ends the process,
 * as does one while no call is active (a defect of the harness, not of the module).
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <linux/audit.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/machine_private.h"
#include "machine/worker.h"

#ifndef SS_AUTODISARM
#define SS_AUTODISARM (1u << 31)
#endif
#ifndef AT_MINSIGSTKSZ
#define AT_MINSIGSTKSZ 51
#endif
#ifndef SYS_SECCOMP
#define SYS_SECCOMP 1
#endif

#define HANDLER_STACK (64u << 10) /* besides the frame that the kernel pushes */

/* x86 exception vectors and page fault error bits. */
enum { VECTOR_BREAKPOINT = 3, VECTOR_PAGE_FAULT = 14 };
enum { PAGE_FAULT_WRITE = 1 << 1, PAGE_FAULT_FETCH = 1 << 4 };

static const int handled[MACHINE_SIGNALS] = { SIGSEGV, SIGBUS, SIGFPE,  SIGILL,
                                              SIGTRAP, SIGSYS, SIGALRM, MACHINE_ALARM };

/* The last bytes before ip are these: the instruction that trapped began there. */
static bool ends_with(const struct machine *machine, uint64_t ip, uint8_t first, uint8_t second)
{
    const uint8_t *code = (const uint8_t *)ip;

    return machine_executes(machine, ip - 2, 2) && code[-2] == first && code[-1] == second;
}

static uint64_t begin_of_syscall(const struct machine *machine, uint64_t ip)
{
    return ends_with(machine, ip, 0x0f, 0x05) || ends_with(machine, ip, 0xcd, 0x80) ? ip - 2 : ip;
}

static uint64_t begin_of_breakpoint(const struct machine *machine, uint64_t ip)
{
    if (ends_with(machine, ip, 0xcd, 0x03))
        return ip - 2;
    return machine_executes(machine, ip - 1, 1) && *(const uint8_t *)(ip - 1) == 0xcc ? ip - 1 : ip;
}

static enum machine_access page_fault_access(uint64_t error)
{
    if (error & PAGE_FAULT_FETCH)
        return MACHINE_ACCESS_EXECUTE;
    return error & PAGE_FAULT_WRITE ? MACHINE_ACCESS_WRITE : MACHINE_ACCESS_READ;
}

static void describe(const struct machine *machine, int sig, const siginfo_t *info,
                     const ucontext_t *context)
{
    const greg_t *registers = context->uc_mcontext.gregs;
    struct machine_fault *fault = &machine_incident.fault;
    uint64_t ip = (uint64_t)registers[REG_RIP];
    uint64_t vector = (uint64_t)registers[REG_TRAPNO];

    memset(fault, 0, sizeof *fault);
    fault->signal = sig;
    machine_incident.kind = MACHINE_FAULT;
    if (sig == SIGSYS) {
        machine_incident.kind = MACHINE_SYSCALL;
        fault->syscall = info->si_syscall;
        fault->syscall_i386 = info->si_arch == AUDIT_ARCH_I386;
        ip = begin_of_syscall(machine, ip);
    } else if (sig == SIGALRM) {
        machine_incident.kind = MACHINE_HANG;
    } else if (sig == SIGTRAP && vector == VECTOR_BREAKPOINT) {
        ip = begin_of_breakpoint(machine, ip);
    } else if ((sig == SIGSEGV || sig == SIGBUS) && vector == VECTOR_PAGE_FAULT) {
        fault->address = (uint64_t)info->si_addr;
        fault->access = page_fault_access((uint64_t)registers[REG_ERR]);
        machine_describe_address(machine, fault);
    }
    machine_attribute(machine, ip, (uint64_t)registers[REG_RSP], fault);
}

/* Nothing of the module's vector and x87 state comes back, nor its protection key rights (which
 * could take the host's memory away): every extended component is marked as in its initial state.
 */
static void reset_extended_state(struct _libc_fpstate *state)
{
    enum { SOFTWARE_BYTES = 464, XSAVE_HEADER = 512 };
    const uint32_t xsave_magic = 0x46505853, default_mxcsr = 0x1f80;
    const uint64_t none = 0;
    uint8_t *bytes = (uint8_t *)state;

    if (state == NULL)
        return;
    if (memcmp(bytes + SOFTWARE_BYTES, &xsave_magic, sizeof xsave_magic) == 0)
        memcpy(bytes + XSAVE_HEADER, &none, sizeof none);
    state->cwd = 0x37f;
    state->swd = 0;
    state->ftw = 0;
    state->mxcsr = default_mxcsr;
}

/* Makes the interrupted context go on in host code. The code and stack segments too: the module may
 * have switched to 32-bit code. */
void machine_redirect(ucontext_t *context, uint64_t ip, uint64_t sp)
{
    greg_t *registers = context->uc_mcontext.gregs;
    uint64_t code, stack;

    __asm__("mov %%cs, %0" : "=r"(code));
    __asm__("mov %%ss, %0" : "=r"(stack));
    registers[REG_CSGSFS] = (greg_t)((code & 0xffff) | (stack & 0xffff) << 48);
    registers[REG_RIP] = (greg_t)ip;
    registers[REG_RSP] = (greg_t)sp;
    registers[REG_EFL] = FLAGS_CLEAN;
    reset_extended_state(context->uc_mcontext.fpregs);
}

/* text, then number, in hexadecimal when it is an address; the end of what was written. */
static char *append(char *at, const char *text, uint64_t number, unsigned base)
{
    char digits[24];
    size_t count = 0;

    at = stpcpy(at, text);
    do
        digits[count++] = "0123456789abcdef"[number % base];
    while ((number /= base) != 0);
    while (count > 0)
        *at++ = digits[--count];
    *at = '\0';
    return at;
}

static void say_why(int sig, const siginfo_t *info, uint64_t ip)
{
    char text[WORKER_REASON], *at = text;

    if (sig == SIGSYS)
        at = append(at, "the harness made system call ", (uint64_t)(unsigned)info->si_syscall, 10);
    else
        at = append(at, "the harness was hit by signal ", (uint64_t)sig, 10);
    append(at,
           sig == SIGSYS ? ", which the sandbox forbids, at 0x" : " outside any module call, at 0x",
           ip, 16);
    worker_say(text);
}

/*
 * Ends the process by this signal. A sealed process cannot set the default action, but the kernel
 * does that itself for an exception while its signal is blocked: repeat it here, or let the
 * interrupted instruction repeat it.
 */
void machine_die(int sig, const siginfo_t *info, ucontext_t *context)
{
    sigfillset(&context->uc_sigmask);
    say_why(sig, info, (uint64_t)context->uc_mcontext.gregs[REG_RIP]);
    if (sig == SIGTRAP)
        __asm__ volatile("int3");
    if (sig == SIGSYS)
        syscall(SYS_ptrace, -1, 0, 0, 0);
    if (info->si_code <= 0 || sig == SIGSYS || sig == SIGTRAP)
        __asm__ volatile("movl $0, 0");
}

void machine_on_signal(int sig, siginfo_t *info, void *context)
{
    struct machine *machine = machine_incident.machine;
    ucontext_t *interrupted = context;
    uint64_t ip = (uint64_t)interrupted->uc_mcontext.gregs[REG_RIP];

    if (machine_interrupt_signal(machine, sig, interrupted))
        return;
    if (sig == SIGALRM) {
        if (machine == NULL || info->si_code != SI_TIMER || !machine_watchdog_tick(machine, ip))
            return;
    } else if (machine == NULL || info->si_code <= 0 || !machine_state.active) {
        machine_die(sig, info, interrupted);
        return;
    }
    machine_state.active = 0;
    describe(machine, sig, info, interrupted);
    machine_redirect(interrupted, (uint64_t)machine_abandon, machine_state.host_rsp);
}

static int install_stack(struct machine *machine)
{
    size_t size = HANDLER_STACK + ((getauxval(AT_MINSIGSTKSZ) + PAGE - 1) & ~(PAGE - 1ul));
    struct machine_reservation *around = &machine->signal_stack;
    stack_t alternate = { .ss_flags = (int)SS_AUTODISARM, .ss_size = size };
    uint8_t *base = mmap(NULL, size + 2 * REGION_GUARD, PROT_NONE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);

    if (base == MAP_FAILED)
        return -errno;
    *around = (struct machine_reservation){ base, size + 2 * REGION_GUARD };
    alternate.ss_sp = base + REGION_GUARD;
    if (mprotect(alternate.ss_sp, size, PROT_READ | PROT_WRITE) != 0)
        return -errno;
    /* Auto-disarm: the frame always goes to the top, wherever the module's stack pointer is. */
    return sigaltstack(&alternate, &machine->borrowed.alternate) != 0 ? -errno : 0;
}

int machine_handlers_install(struct machine *machine, char why[MACHINE_WHY])
{
    struct sigaction action;
    int error = install_stack(machine);

    if (error != 0)
        return machine_fail(why, error, "no stack for signal handlers: %s", strerror(-error));
    memset(&action, 0, sizeof action);
    action.sa_sigaction = machine_signal_entry;
    action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_RESTART;
    sigfillset(&action.sa_mask);
    for (unsigned i = 0; i < MACHINE_SIGNALS; i++) {
        sigset_t one;

        sigaction(handled[i], &action, &machine->borrowed.actions[i]);
        sigemptyset(&one);
        sigaddset(&one, handled[i]);
        sigprocmask(SIG_UNBLOCK, &one, NULL);
    }
    machine->borrowed.installed = true;
    return 0;
}

void machine_handlers_remove(struct machine *machine)
{
    if (!machine->borrowed.installed || machine->sealed)
        return;
    for (unsigned i = 0; i < MACHINE_SIGNALS; i++)
        sigaction(handled[i], &machine->borrowed.actions[i], NULL);
    sigaltstack(&machine->borrowed.alternate, NULL);
    machine->borrowed.installed = false;
}
