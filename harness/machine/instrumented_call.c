/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * instrumented_call.c - one call into the module on the emulated CPU.
 *
 * The emulation is left and entered again for everything that is not the module's: a host service,
 * an interrupt. So whatever those do runs as ordinary host code, a service's bad pointer can be
 * caught, and calls can stand inside one another without the emulator knowing.
 */
#include <setjmp.h>

#include "machine/instrumented.h"

#ifdef ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
#endif

void emulator_set_stop(struct emulator *emulator, uint64_t interrupt_at)
{
    const uint64_t hang = emulator->machine->config.hang_instructions;

    emulator->interrupt_at = interrupt_at;
    emulator->stop_at = interrupt_at < hang ? interrupt_at : hang;
}

/* The stack that calls of this level run on, and how far it reaches for Windows' code that asks. */
void emulator_use_stack(struct emulator *emulator, const struct emulator_level *level)
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

/* The state of a call that others are to be made during; back: where it is gone on with. */
static void put_down(struct emulator *emulator, struct emulator_level *level, uint64_t back)
{
    uc_context_save(emulator->uc, level->interrupted);
    level->interrupted_back = back;
    level->interrupted_pc = emulator->pc;
    level->interrupted_sp = emulator_read(emulator, emulator->cpu->sp);
    level->interrupted_executed = emulator->executed;
}

void emulator_take_up(struct emulator *emulator, const struct emulator_level *level)
{
    uc_context_restore(emulator->uc, level->interrupted);
    emulator_use_stack(emulator, level);
    emulator->executed = level->interrupted_executed;
    emulator->pc = level->interrupted_pc;
    emulator->block_end = 0;
    emulator->pass = false;
}

/* Behind a service, instead of going on there. */
static void step_aside(struct emulator *emulator)
{
    const unsigned number = emulator->machine->order[emulator->depth - 1];
    struct emulator_level *level = &emulator->levels[number];
    struct machine_level *own = &emulator->machine->levels[number];

    own->service = emulator->machine->services[emulator->number].name;
    own->service_return = (void *)(emulator->service_back & ~emulator->odd);
    put_down(emulator, level, emulator->service_back);
    level->interrupt_at = emulator->interrupt_at;
    level->block_next = emulator->block_next;
    level->block_end = emulator->block_end;
    emulator->stop = EMULATOR_ASIDE;
}

/* A service on the host's stack. False when the call does not go on behind it. */
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
    if (machine->aside)
        step_aside(emulator);
    return !machine->aside;
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
    struct emulator_level *level = emulator_level_at(emulator, emulator->depth - 1);
    uint64_t more, vaddr = 0;

    put_down(emulator, level, resume_at(emulator));
    machine_vaddr(machine, (const void *)emulator->pc, &vaddr);
    more = level->hook(level->argument, vaddr, emulator->executed);
    emulator_take_up(emulator, level);
    if (more == MACHINE_ABANDON) {
        emulator->stop = EMULATOR_HANG;
        return false;
    }
    emulator_set_stop(emulator, more == MACHINE_NEVER ? MACHINE_NEVER : emulator->executed + more);
    emulator->pass = more == 0;
    *pc = level->interrupted_back;
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
        emulator->cpu->leave(emulator, emulator_level_at(emulator, emulator->depth - 1)->top,
                             outcome);
        return;
    }
    if (emulator->stop == EMULATOR_ASIDE) {
        outcome->kind = MACHINE_ASIDE;
        return;
    }
    if (emulator->stop == EMULATOR_SERVICE)
        emulator_service_fault(emulator, outcome);
    else
        emulator_fault(emulator, outcome);
    emulator->service = NULL;
}

void emulator_run_on(struct emulator *emulator, uint64_t pc, struct machine_outcome *outcome)
{
    describe(emulator, run(emulator, pc), outcome);
}

/* Of the call at the greatest depth, from an address on. */
static void call_on(struct emulator *emulator, uint64_t pc, struct machine_outcome *outcome)
{
    struct machine *machine = emulator->machine;
    const unsigned number = machine->order[emulator->depth - 1];
    struct emulator_level *level = &emulator->levels[number];

    outcome->abi_broken = 0;
    outcome->value = 0;
    emulator_run_on(emulator, pc, outcome);
    outcome->elapsed_ns = machine->timing ? machine_now_ns() - machine->levels[number].begun_ns : 0;
    outcome->instructions = emulator->executed;
    emulator->depth--;
    if (outcome->kind == MACHINE_ASIDE) {
        outcome->aside = machine_level_aside(machine, emulator->depth);
        return;
    }
    level->lowest &= ~(uint64_t)(emulator->cpu->word - 1);
    level->executed = emulator->executed;
    level->hook = NULL;
    level->after = MACHINE_NEVER;
    outcome->stack_bytes = level->top - level->lowest;
    if (outcome->stack_bytes > emulator->deepest)
        emulator->deepest = outcome->stack_bytes;
}

bool emulator_set_aside(const struct machine *machine)
{
    return machine->emulator->serving && machine->emulator->depth < machine->levels_left;
}

unsigned emulator_depth(const struct machine *machine)
{
    return machine->emulator->depth;
}

void emulator_go_on(struct machine *machine, struct machine_outcome *outcome)
{
    struct emulator *emulator = machine->emulator;
    const struct emulator_level *level = emulator_level_at(emulator, emulator->depth++);

    emulator_take_up(emulator, level);
    emulator->block_next = level->block_next;
    emulator->block_end = level->block_end;
    emulator_set_stop(emulator, level->interrupt_at);
    call_on(emulator, level->interrupted_back, outcome);
}

void emulator_call(struct machine *machine, uint64_t function, void *argument,
                   struct machine_outcome *outcome)
{
    struct emulator *emulator = machine->emulator;
    struct emulator_level *level = emulator_level_at(emulator, emulator->depth);
    const uint64_t thumb = emulator->cpu->arch == UC_ARCH_ARM ? function & 1 : 0;
    const uint64_t start = (uint64_t)machine_address(machine, function - thumb);

    machine->levels[machine->order[emulator->depth++]].begun_ns =
        machine->timing ? machine_now_ns() : 0;
    uc_context_restore(emulator->uc, emulator->fresh);
    emulator_use_stack(emulator, level);
    level->lowest = level->top;
    emulator->executed = 0;
    emulator->block_end = 0;
    emulator->pass = false;
    emulator_set_stop(emulator, level->hook != NULL ? level->after : MACHINE_NEVER);
    emulator->pc = 0;
    emulator->cpu->enter(emulator, start, (uint64_t)argument);
    call_on(emulator, start | thumb, outcome);
}
