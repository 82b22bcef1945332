/* SPDX-License-Identifier: GPL-2.0-or-later */
/* instrumented_fault.c - why a call did not return, in the words of a native machine. */
#include <signal.h>

#include "machine/instrumented.h"

/* The instruction that the emulation ended in did not come to its end. */
static void undo(struct emulator *emulator)
{
    if (emulator->executed > 0)
        emulator->executed--;
}

static bool is_fetch(uc_mem_type type)
{
    return type == UC_MEM_FETCH_UNMAPPED || type == UC_MEM_FETCH_PROT;
}

static void bad_access(struct emulator *emulator, struct machine_fault *fault, uint64_t *ip)
{
    const bool write =
        emulator->access == UC_MEM_WRITE_UNMAPPED || emulator->access == UC_MEM_WRITE_PROT;

    fault->signal = SIGSEGV;
    fault->address = emulator->address;
    fault->access = write ? MACHINE_ACCESS_WRITE : MACHINE_ACCESS_READ;
    if (is_fetch(emulator->access)) {
        fault->access = MACHINE_ACCESS_EXECUTE;
        *ip = emulator_read(emulator, emulator->cpu->pc);
    } else {
        undo(emulator);
    }
    emulator->cpu->access(emulator, fault);
    if (fault->access != MACHINE_ACCESS_NONE)
        machine_describe_address(emulator->machine, fault);
}

static bool is_known(struct emulator *emulator, uint64_t ip)
{
    enum { LONGEST = 15 };
    const struct machine *machine = emulator->machine;
    const uint64_t rest = emulator->base + (machine->span_end - machine->span_begin) - ip;
    struct code_step step;

    if (!machine_executes(machine, ip, 1))
        return false;
    code_step_read(&emulator->stepper, (const uint8_t *)ip, rest < LONGEST ? rest : LONGEST, ip,
                   false, &step);
    return step.known;
}

/* An instruction that was not executed, as its kind or the emulator said. */
static enum machine_outcome_kind bad_instruction(struct emulator *emulator,
                                                 struct machine_fault *fault, uint64_t *ip)
{
    fault->signal = SIGILL;
    switch ((enum code_step_kind)emulator->number) {
    case CODE_STEP_SYSCALL:
    case CODE_STEP_SYSCALL_OLD:
        fault->signal = SIGSYS;
        fault->syscall_i386 = emulator->number == CODE_STEP_SYSCALL_OLD;
        fault->syscall_arm = emulator->cpu->arch == UC_ARCH_ARM;
        fault->syscall = (long)(uint32_t)emulator_read(
            emulator, fault->syscall_arm ? UC_ARM_REG_R7 : UC_X86_REG_EAX);
        return MACHINE_SYSCALL;
    case CODE_STEP_BREAKPOINT:
        fault->signal = SIGTRAP;
        return MACHINE_FAULT;
    case CODE_STEP_PRIVILEGED:
        fault->signal = SIGSEGV;
        return MACHINE_FAULT;
    case CODE_STEP_ALIGNED:
        fault->signal = SIGBUS;
        return MACHINE_FAULT;
    case CODE_STEP_FOREIGN:
        return MACHINE_UNSUPPORTED;
    default:
        break;
    }
    undo(emulator);
    *ip = emulator_read(emulator, emulator->cpu->pc);
    /* The emulated Arm is the one that controllers have; x86 processors differ. */
    return emulator->cpu->arch == UC_ARCH_X86 && is_known(emulator, *ip) ? MACHINE_UNSUPPORTED
                                                                         : MACHINE_FAULT;
}

static enum machine_outcome_kind bad_event(struct emulator *emulator, struct machine_fault *fault,
                                           uint64_t *ip)
{
    enum { DEBUG_VECTOR = 1 };
    bool syscall = false;

    fault->signal = emulator->cpu->signal(emulator, emulator->number, &syscall);
    if (emulator->cpu->arch == UC_ARCH_X86 && emulator->number == DEBUG_VECTOR)
        *ip = emulator_read(emulator, emulator->cpu->pc); /* behind the one it came from */
    else
        undo(emulator);
    if (fault->signal == 0)
        return MACHINE_UNSUPPORTED;
    return syscall ? MACHINE_SYSCALL : MACHINE_FAULT;
}

/* Of a jump out of the code, the caller is what a person wants to see. */
static void attribute(struct emulator *emulator, uint64_t ip, struct machine_fault *fault)
{
    const struct machine *machine = emulator->machine;
    uint64_t back;

    if (emulator->cpu->caller == NULL) {
        machine_attribute(machine, ip, emulator_read(emulator, emulator->cpu->sp), fault);
        return;
    }
    fault->ip = ip;
    fault->in_module = machine_vaddr(machine, (const void *)ip, &fault->pc);
    fault->has_pc = fault->in_module;
    if (machine_executes(machine, ip, 1) || !emulator->cpu->caller(emulator, &back))
        return;
    fault->in_module = false;
    fault->has_pc = machine_vaddr(machine, (const void *)back, &fault->pc);
}

void emulator_fault(struct emulator *emulator, struct machine_outcome *outcome)
{
    struct machine_fault *fault = &outcome->fault;
    uint64_t ip = emulator->pc;

    memset(fault, 0, sizeof *fault);
    outcome->kind = MACHINE_FAULT;
    switch (emulator->stop) {
    case EMULATOR_HANG:
        outcome->kind = MACHINE_HANG;
        fault->signal = SIGALRM;
        break;
    case EMULATOR_MEMORY:
        bad_access(emulator, fault, &ip);
        break;
    case EMULATOR_INSTRUCTION:
        outcome->kind = bad_instruction(emulator, fault, &ip);
        break;
    case EMULATOR_EXCEPTION:
        outcome->kind = bad_event(emulator, fault, &ip);
        break;
    default:
        outcome->kind = MACHINE_UNSUPPORTED;
        fault->signal = SIGILL;
        ip = emulator_read(emulator, emulator->cpu->pc);
        break;
    }
    attribute(emulator, ip, fault);
}

void emulator_service_fault(struct emulator *emulator, struct machine_outcome *outcome)
{
    enum { PAGE_FAULT_WRITE = 1 << 1 };
    struct machine_fault *fault = &outcome->fault;

    memset(fault, 0, sizeof *fault);
    outcome->kind = MACHINE_FAULT;
    fault->signal = emulator->escaped_signal;
    fault->ip = emulator->escaped_ip;
    if (fault->signal != SIGFPE) {
        fault->address = emulator->escaped_address;
        fault->access =
            emulator->escaped_error & PAGE_FAULT_WRITE ? MACHINE_ACCESS_WRITE : MACHINE_ACCESS_READ;
        machine_describe_address(emulator->machine, fault);
    }
    fault->service = emulator->service;
    fault->has_pc = machine_vaddr(
        emulator->machine, (const void *)(emulator->service_back & ~emulator->odd), &fault->pc);
}
