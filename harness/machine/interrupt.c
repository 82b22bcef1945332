/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * interrupt.c - stops a call between two instructions, lets the host do something, goes on with it.
 *
 * Both ways of stopping end in a signal handler that finds the processor in module code: the trap
 * flag, one trap an instruction, until the wanted one; or the alarm, a timer. The handler keeps the
 * interrupted context (registers and extended state) and makes the kernel return to
 * machine_interlude() on the host's stack, below what waits there for the call. From there on
 * everything is ordinary code: signals are served, calls may be made. To go on, machine_resume()
 * traps, and the handler puts the kept context back.
 *
 * Only instructions of the module are interrupted. An alarm that finds a host service, or the way
 * into the call, turns the trap flag on, so that the first instruction of the module behind it is.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "machine/machine_private.h"

#ifndef sigev_notify_thread_id
#define sigev_notify_thread_id _sigev_un._tid
#endif
#ifndef AT_MINSIGSTKSZ
#define AT_MINSIGSTKSZ 51
#endif

#define LEGACY_STATE   512  /* bytes of extended state without a header of the kernel's */
#define SMALLEST_FRAME 4096 /* of signals, where the kernel does not say */

enum { VECTOR_DEBUG = 1, VECTOR_BREAKPOINT = 3 };

static struct machine_level *running(struct machine *machine)
{
    return machine_level_at(machine, machine->level);
}

int machine_levels_open(struct machine *machine, char why[MACHINE_WHY])
{
    for (unsigned i = 0; i < MACHINE_LEVELS; i++)
        machine->levels[i].after = MACHINE_NEVER;
    if (!machine->config.interruptible)
        return 0;
    machine->extended_room = getauxval(AT_MINSIGSTKSZ);
    if (machine->extended_room < SMALLEST_FRAME)
        machine->extended_room = SMALLEST_FRAME;
    for (unsigned i = 0; i < MACHINE_LEVELS; i++) {
        machine->levels[i].extended = malloc(machine->extended_room);
        if (machine->levels[i].extended == NULL)
            return machine_fail(why, -ENOMEM, "no memory for interrupted calls");
    }
    machine->rehearsed = malloc(machine->stack_size);
    if (machine->rehearsed == NULL)
        return machine_fail(why, -ENOMEM, "no memory for interrupted calls");
    return 0;
}

void machine_levels_close(struct machine *machine)
{
    for (unsigned i = 0; i < MACHINE_LEVELS; i++)
        free(machine->levels[i].extended);
    free(machine->rehearsed);
    code_decoder_close(machine->decoder);
    if (machine->has_alarm && !machine->sealed)
        timer_delete(machine->alarm);
    machine->has_alarm = false;
}

void machine_level_set(struct machine *machine, unsigned level)
{
    machine->level = level;
    machine->stack = machine_level_at(machine, level)->stack;
    machine_state.stack_top = machine_stack_top(machine, machine->stack);
    machine_thread_block_update(machine);
}

void machine_native_interrupt_next(struct machine *machine, uint64_t after, machine_interrupt *hook,
                                   void *argument)
{
    struct machine_level *level = running(machine);

    if (!machine->config.interruptible || machine->level + 1 >= machine->levels_left)
        return;
    level->pending = false;
    level->after = after;
    level->argument = argument;
    atomic_signal_fence(memory_order_seq_cst);
    level->hook = hook; /* from here on an alarm is heard */
}

uint64_t machine_native_instructions(const struct machine *machine)
{
    return machine->levels[machine->order[machine->level]].executed;
}

void machine_level_begin(struct machine *machine)
{
    struct machine_level *level = running(machine);

    level->executed = 0;
    level->inside = false;
    level->stepping = level->stepped = level->hook != NULL && level->after != MACHINE_NEVER;
    machine_state.enter_flags = 0;
    atomic_signal_fence(memory_order_seq_cst);
    if (level->stepping || level->pending) /* an alarm after this sets it itself */
        machine_state.enter_flags = FLAGS_CLEAN | FLAG_TRAP;
}

void machine_level_end(struct machine *machine)
{
    struct machine_level *level = running(machine);

    level->hook = NULL;
    level->after = MACHINE_NEVER;
    level->stepping = level->stepped = level->pending = false;
    machine_state.enter_flags = 0;
}

void machine_service_steps(struct machine *machine, bool on)
{
    const struct machine_level *level = running(machine);
    uint64_t flags;

    if (!level->stepping && !level->pending)
        return;
    flags = __builtin_ia32_readeflags_u64();
    __builtin_ia32_writeeflags_u64(on ? flags | FLAG_TRAP : flags & ~(uint64_t)FLAG_TRAP);
}

static void trap_flag(ucontext_t *context, bool on)
{
    greg_t *flags = &context->uc_mcontext.gregs[REG_EFL];

    *flags = on ? *flags | FLAG_TRAP : *flags & ~(greg_t)FLAG_TRAP;
}

/* Bytes of the extended state that the kernel saved; it tells at the end of the legacy part. */
static size_t extended_size(const struct _libc_fpstate *state)
{
    enum { SOFTWARE_BYTES = 464 };
    const uint32_t magic = 0x46505853;
    uint32_t told[2];

    memcpy(told, (const uint8_t *)state + SOFTWARE_BYTES, sizeof told);
    return told[0] == magic ? told[1] : LEGACY_STATE;
}

static __attribute__((noreturn)) void abandon(const struct machine *machine,
                                              const struct machine_level *level)
{
    struct machine_fault *fault = &machine_incident.fault;

    memset(fault, 0, sizeof *fault);
    fault->signal = SIGALRM;
    machine_attribute(machine, (uint64_t)level->registers[REG_RIP],
                      (uint64_t)level->registers[REG_RSP], fault);
    machine_incident.kind = MACHINE_HANG;
    machine_abandon();
}

/* The hook, and everything that it does, between two instructions of the module. */
static __attribute__((noreturn, noinline, used)) void machine_interlude(void)
{
    struct machine *machine = machine_incident.machine;
    struct machine_level *level = running(machine);
    const struct machine_state outer = machine_state;
    uint64_t pc = 0, more, serial;

    machine_vaddr(machine, (const void *)level->registers[REG_RIP], &pc);
    machine_level_set(machine, machine->level + 1);
    more = level->hook(level->argument, pc, level->executed);
    machine_level_set(machine, machine->level - 1);
    serial = machine_state.serial;
    machine_state = outer;
    machine_state.serial = serial + 1; /* to the watchdog it is a new call */
    machine_incident.service_depth = 0;
    machine_incident.hung = false;
    if (more == MACHINE_ABANDON)
        abandon(machine, level);

    level->stepping = more != MACHINE_NEVER;
    level->after = level->stepping ? level->executed + more : MACHINE_NEVER;
    level->stepped |= level->stepping;
    machine->resuming = true;
    machine_resume();
}

/* False when the context cannot be kept: the call goes on without an interrupt. */
static bool stop(struct machine *machine, ucontext_t *context)
{
    struct machine_level *level = running(machine);
    const struct _libc_fpstate *state = context->uc_mcontext.fpregs;

    if (state == NULL || extended_size(state) > machine->extended_room)
        return false;
    trap_flag(context, false);
    memcpy(level->registers, context->uc_mcontext.gregs, sizeof level->registers);
    level->extended_size = extended_size(state);
    memcpy(level->extended, state, level->extended_size);
    level->pending = level->stepping = false;
    level->after = MACHINE_NEVER;
    level->inside = true;
    machine_state.active = 0;
    /* As if called from there: the return address would have taken 8 bytes. */
    machine_redirect(context, (uint64_t)machine_interlude,
                     (((uint64_t)machine_state.host_rsp - 256) & ~(uint64_t)15) - 8);
    return true;
}

static void resume(struct machine *machine, ucontext_t *context)
{
    const struct machine_level *level = running(machine);

    machine->resuming = false;
    memcpy(context->uc_mcontext.gregs, level->registers, sizeof level->registers);
    memcpy(context->uc_mcontext.fpregs, level->extended, level->extended_size);
    trap_flag(context, level->stepping || level->pending);
    machine_state.active = 1;
}

/* On the way out of the call: nothing is to be interrupted any more. */
static bool leaving(uint64_t ip)
{
    return ip >= (uint64_t)machine_returned && ip < (uint64_t)machine_trampoline_end;
}

/* One instruction done. False: the trap flag is the module's own. */
static bool step(struct machine *machine, ucontext_t *context, uint64_t ip)
{
    struct machine_level *level = running(machine);
    bool inside = machine_executes(machine, ip, 1);

    if (!level->stepped && !level->pending)
        return false;
    level->executed += level->inside;
    level->inside = inside;
    if (leaving(ip))
        level->stepping = level->pending = false;
    if (inside && (level->pending || level->executed >= level->after)) {
        if (stop(machine, context))
            return true;
        level->stepping = level->pending = false;
    }
    trap_flag(context, level->stepping || level->pending);
    return true;
}

static void alarm_came(struct machine *machine, ucontext_t *context, uint64_t ip)
{
    struct machine_level *level = running(machine);

    if (level->hook == NULL || leaving(ip))
        return;
    if (!machine_state.active) { /* on the way in, or between an interrupt and the rest */
        level->pending = true;
        machine_state.enter_flags = FLAGS_CLEAN | FLAG_TRAP;
        return;
    }
    if (machine_incident.service_depth == 0 && machine_executes(machine, ip, 1) &&
        stop(machine, context))
        return;
    level->pending = level->stepped = true;
    level->inside = false;
    if (machine_incident.service_depth == 0)
        trap_flag(context, true);
}

bool machine_interrupt_signal(struct machine *machine, int sig, ucontext_t *context)
{
    uint64_t ip = (uint64_t)context->uc_mcontext.gregs[REG_RIP];
    uint64_t vector = (uint64_t)context->uc_mcontext.gregs[REG_TRAPNO];

    if (sig == MACHINE_ALARM) {
        if (machine != NULL && machine->has_alarm)
            alarm_came(machine, context, ip);
        return true;
    }
    if (sig != SIGTRAP || machine == NULL || !machine->config.interruptible)
        return false;
    if (vector == VECTOR_BREAKPOINT && machine->resuming && ip - 1 == (uint64_t)machine_resume) {
        resume(machine, context);
        return true;
    }
    return vector == VECTOR_DEBUG && machine_state.active && step(machine, context, ip);
}

int machine_native_alarm_open(struct machine *machine, char why[MACHINE_WHY])
{
    struct sigevent event;

    memset(&event, 0, sizeof event);
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = MACHINE_ALARM;
    event.sigev_notify_thread_id = (int)syscall(SYS_gettid);
    if (timer_create(CLOCK_MONOTONIC, &event, &machine->alarm) != 0)
        return machine_fail(why, -errno, "no timer for interrupts: %s", strerror(errno));
    machine->has_alarm = true;
    return 0;
}

/* With SIGEV_THREAD_ID, a timer_t is the kernel's number. */
int machine_alarm_number(const struct machine *machine)
{
    return machine->has_alarm ? (int)(uintptr_t)machine->alarm : -1;
}

void machine_native_alarm_at(struct machine *machine, uint64_t monotonic_ns)
{
    struct itimerspec when;

    memset(&when, 0, sizeof when);
    when.it_value.tv_sec = (time_t)(monotonic_ns / 1000000000u);
    when.it_value.tv_nsec = (long)(monotonic_ns % 1000000000u);
    if (machine->has_alarm)
        timer_settime(machine->alarm, TIMER_ABSTIME, &when, NULL);
}
