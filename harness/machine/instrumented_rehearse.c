/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * instrumented_rehearse.c - what would come next in an interrupted call, tried out for its hook.
 *
 * The processor's state lies in the call's level; what is added here is the stack. So the call can
 * be gone on with as often as wanted, to its end or by one instruction, whose accesses then are
 * what the hooks saw of it, whatever processor it is.
 */
#include "machine/instrumented.h"

#define BELOW_STACK 256 /* red zone of x86-64, and what one instruction pushes */

/* What of a level's stack is in use. */
static uint8_t *used_stack(const struct emulator *emulator, const struct emulator_level *level,
                           size_t *size)
{
    const uint64_t low = (uint64_t)level->stack;
    uint64_t sp = level->interrupted_sp - BELOW_STACK;

    if (sp - low >= emulator->machine->stack_size) /* the module has its stack elsewhere */
        sp = low;
    *size = emulator->machine->stack_size - (sp - low);
    return (uint8_t *)sp;
}

/* The state of the interrupted call, and its stack, put aside. */
static uint8_t *begin(struct emulator *emulator, struct emulator_level *level, size_t *size)
{
    uint8_t *stack = used_stack(emulator, level, size);

    memcpy(emulator->rehearsed, stack, *size);
    emulator_take_up(emulator, level);
    return stack;
}

void emulator_rehearse(struct machine *machine, struct machine_outcome *outcome)
{
    struct emulator *emulator = machine->emulator;
    struct emulator_level *level = emulator_level_at(emulator, emulator->depth - 1);
    const uint64_t lowest = level->lowest;
    size_t size;
    uint8_t *stack = begin(emulator, level, &size);

    emulator_set_stop(emulator, MACHINE_NEVER);
    memset(outcome, 0, sizeof *outcome);
    machine->rehearsing = true;
    emulator_run_on(emulator, level->interrupted_back, outcome);
    machine->rehearsing = false;
    level->lowest = lowest;
    memcpy(stack, emulator->rehearsed, size);
}

/* An access of the instruction that is tried out. What it is about to write is kept. */
void emulator_probe(struct emulator *emulator, uint64_t address, unsigned size, bool write)
{
    struct emulator_probe *probe = emulator->probe;
    struct code_operand *operand;

    if (write && probe->kept_count < EMULATOR_KEPT) {
        struct emulator_kept *kept = &probe->kept[probe->kept_count++];

        *kept = (struct emulator_kept){ .address = address, .size = size };
        memcpy(kept->bytes, (const void *)address, size);
    }
    for (unsigned i = 0; i < probe->count; i++) {
        operand = &probe->operands[i];
        if (address == operand->address + operand->size) { /* a wider one, in pieces */
            if (operand->write == write) {
                operand->size += size;
                return;
            }
        } else if (address - operand->address < operand->size) {
            operand->read |= !write;
            operand->write |= write;
            return;
        }
    }
    if (probe->count == CODE_OPERANDS)
        return;
    probe->operands[probe->count++] =
        (struct code_operand){ .address = address, .size = size, .read = !write, .write = write };
}

unsigned emulator_next_operands(struct machine *machine,
                                struct code_operand operands[CODE_OPERANDS])
{
    struct emulator *emulator = machine->emulator;
    struct emulator_level *level = emulator_level_at(emulator, emulator->depth - 1);
    struct emulator_probe probe = { .operands = operands };
    const uint64_t lowest = level->lowest;
    size_t size;
    uint8_t *stack = begin(emulator, level, &size);

    emulator_set_stop(emulator, emulator->executed + 1);
    emulator->probe = &probe;
    emulator->stop = EMULATOR_RUNNING;
    uc_emu_start(emulator->uc, level->interrupted_back, emulator->trap, 0, 0);
    emulator->probe = NULL;
    while (probe.kept_count > 0) {
        const struct emulator_kept *kept = &probe.kept[--probe.kept_count];

        memcpy((void *)kept->address, kept->bytes, kept->size);
    }
    level->lowest = lowest;
    memcpy(stack, emulator->rehearsed, size);
    return probe.count;
}
