/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * instrumented_call.c - one call into the module on the emulated CPU.
 *
 * The emulation is left and entered again for everything that is not the module's: a host service,
 * an interrupt. So whatever those do runs as ordinary host code, a service's bad pointer can be
 * caught, and calls can stand inside one another without the emulator knowing.
 */
#include <setjmp.h>
#include <time.h>

#include "machine/instrumented.h"

#ifdef ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

static uint64_t now_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static void set_stop(struct emulator *emulator, uint64_t interrupt_at)
{
    const uint64_t hang = emulator->machine->config.hang_instructions;

    emulator->interrupt_at = interrupt_at;
    emulator->stop_at = interrupt_at < hang ? interrupt_at : hang;
}

/* The stack that calls of this level run on, and how far it reaches for Windows' code that asks. */
static void use_stack(struct emulator *emulator, const struct emulator_level *level)
{
    struct machine *machine = emulator->machine;
    const uint64_t limit = (uint64_t)level->stack, base = limit + machine->stack_size;
    const unsigned word = emulator->cpu->word;

    machine->stack = level->stack;
    if (emulator->thread_host == NULL || machine->convention == ARGUMENTS_SYSV)
        return;
    memcpy(emulator->thread_host + word, &base, word);
    memcpy(emulator->thread_host + 2 * (size_t)word, &limit, word);
}

/* A service on the host's stack. False when it did not come back. */
static bool serve(struct emulator *emulator, uint64_t *pc)
{
    struct machine *machine = emulator->machine;
    struct arguments arguments;
    int64_t value = 0;

    emulator->service = machine->services[emulator->number].name;
    emulator->service_back = 0;
    emulator->serving = true;
    if (sigsetjmp(emulator->escape, 0) != 0) {
        emulator->serving = false;
        return false;
    }
    /* Where its stack pointer leads is the module's own affair, too. */
    emulator->service_back = emulator->cpu->arguments(emulator, &arguments);
    value =
        machine_service_call(machine, emulator->number, &arguments, (void *)emulator->service_back);
    emulator->serving = false;
    emulator->service = NULL;
    emulator->cpu->answer(emulator, value, emulator->service_back);
    *pc = emulator->service_back;
    return true;
}

static uint64_t resume_at(struct emulator *emulator)
{
    enum { THUMB_STATE = 1 << 5 };

    if (emulator->cpu->arch != UC_ARCH_ARM)
        return emulator->pc;
    return emulator->pc | (emulator_read(emulator, UC_ARM_REG_CPSR) & THUMB_STATE ? 1 : 0);
}

/* The hook, and everything that it does, between two instructions. False: the call is over. */
static bool interlude(struct emulator *emulator, uint64_t *pc)
{
    struct machine *machine = emulator->machine;
    struct emulator_level *level = &emulator->levels[emulator->depth - 1];
    const uint64_t executed = emulator->executed, at = emulator->pc, back = resume_at(emulator);
    uint64_t more, vaddr = 0;

    uc_context_save(emulator->uc, level->interrupted);
    machine_vaddr(machine, (const void *)at, &vaddr);
    more = level->hook(level->argument, vaddr, executed);
    uc_context_restore(emulator->uc, level->interrupted);
    use_stack(emulator, level);
    emulator->executed = executed;
    emulator->pc = at;
    emulator->block_end = 0;
    if (more == MACHINE_ABANDON) {
        emulator->stop = EMULATOR_HANG;
        return false;
    }
    set_stop(emulator, more == MACHINE_NEVER ? MACHINE_NEVER : executed + more);
    emulator->pass = more == 0;
    *pc = back;
    return true;
}

/* Until the call returns (true) or is over in another way. */
static bool run(struct emulator *emulator, uint64_t pc)
{
    for (;;) {
        uc_err error;

        emulator->stop = EMULATOR_RUNNING;
        error = uc_emu_start(emulator->uc, pc, emulator->trap, 0, 0);
        if (emulator->stop == EMULATOR_RUNNING) {
            emulator->stop = EMULATOR_BROKEN;
            emulator->number = (uint32_t)error;
            if (error == UC_ERR_OK && emulator_read(emulator, emulator->cpu->pc) == emulator->trap)
                emulator->stop = EMULATOR_RETURNED;
        }
        if (emulator->stop == EMULATOR_RETURNED)
            return true;
        if (emulator->stop == EMULATOR_SERVICE
                ? !serve(emulator, &pc)
                : emulator->stop != EMULATOR_INTERRUPT || !interlude(emulator, &pc))
            return false;
    }
}

static void describe(struct emulator *emulator, bool returned, struct machine_outcome *outcome)
{
    if (returned) {
        outcome->kind = MACHINE_RETURNED;
        emulator->cpu->leave(emulator, emulator->levels[emulator->depth - 1].top, outcome);
        return;
    }
    if (emulator->stop == EMULATOR_SERVICE)
        emulator_service_fault(emulator, outcome);
    else
        emulator_fault(emulator, outcome);
    emulator->service = NULL;
}

void emulator_call(struct machine *machine, uint64_t function, void *argument,
                   struct machine_outcome *outcome)
{
    struct emulator *emulator = machine->emulator;
    struct emulator_level *level = &emulator->levels[emulator->depth++];
    const uint64_t begin = machine->timing ? now_ns() : 0;
    const uint64_t thumb = emulator->cpu->arch == UC_ARCH_ARM ? function & 1 : 0;
    const uint64_t start = (uint64_t)machine_address(machine, function - thumb);
    bool returned;

    uc_context_restore(emulator->uc, emulator->fresh);
    use_stack(emulator, level);
    level->lowest = level->top;
    emulator->executed = 0;
    emulator->block_end = 0;
    emulator->pass = false;
    set_stop(emulator, level->hook != NULL ? level->after : MACHINE_NEVER);
    emulator->pc = 0;
    emulator->cpu->enter(emulator, start, (uint64_t)argument);
    returned = run(emulator, start | thumb);

    outcome->elapsed_ns = machine->timing ? now_ns() - begin : 0;
    outcome->abi_broken = 0;
    outcome->value = 0;
    describe(emulator, returned, outcome);
    level->lowest &= ~(uint64_t)(emulator->cpu->word - 1);
    level->executed = emulator->executed;
    level->hook = NULL;
    level->after = MACHINE_NEVER;
    outcome->instructions = emulator->executed;
    outcome->stack_bytes = level->top - level->lowest;
    if (outcome->stack_bytes > emulator->deepest)
        emulator->deepest = outcome->stack_bytes;
    emulator->depth--;
}
