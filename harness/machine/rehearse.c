/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * rehearse.c - the rest of an interrupted call, as often as a hook wants to see it.
 *
 * The interrupted context lies in the call's level, and going on with it (interrupt.c) leaves it
 * there: so it can be gone on with again, when the stack that belongs to it is put back.
 */
#define _GNU_SOURCE 1
#include <string.h>

#include "machine/machine_private.h"

#define RED_ZONE 128
#define LONGEST  15 /* bytes of an instruction */

/* What of a level's stack is in use: from its red zone up. */
static uint8_t *used_stack(const struct machine *machine, const struct machine_level *level,
                           size_t *size)
{
    uint64_t low = (uint64_t)level->stack, sp = (uint64_t)level->registers[REG_RSP] - RED_ZONE;

    if (sp - low >= machine->stack_size) /* the module has its stack elsewhere */
        sp = low;
    *size = machine->stack_size - (sp - low);
    return (uint8_t *)sp;
}

void machine_native_rehearse(struct machine *machine, struct machine_outcome *outcome)
{
    struct machine_level *level = machine_level_at(machine, machine->level - 1);
    const struct machine_level kept = *level;
    const struct machine_state outer = machine_state;
    struct machine_left left;
    uint64_t serial;
    size_t size;
    uint8_t *stack = used_stack(machine, level, &size);

    memcpy(machine->rehearsed, stack, size);
    level->hook = NULL;
    level->stepping = level->stepped = level->pending = false;
    machine_level_set(machine, machine->level - 1);
    machine_incident.service_depth = 0;
    machine_incident.hung = false;
    machine->resuming = machine->rehearsing = true;
    left = machine_enter_again();
    machine->rehearsing = false;
    memset(outcome, 0, sizeof *outcome);
    outcome->kind = MACHINE_RETURNED;
    outcome->value = left.value;
    if (left.how != LEFT_CLEAN)
        machine_irregular(machine, left.how, outcome);
    machine_level_set(machine, machine->level + 1);
    *level = kept;
    memcpy(stack, machine->rehearsed, size);
    serial = machine_state.serial;
    machine_state = outer;
    machine_state.serial = serial + 1;
}

unsigned machine_native_next_operands(struct machine *machine,
                                      struct code_operand operands[CODE_OPERANDS])
{
    static const int numbers[16] = { REG_RAX, REG_RCX, REG_RDX, REG_RBX, REG_RSP, REG_RBP,
                                     REG_RSI, REG_RDI, REG_R8,  REG_R9,  REG_R10, REG_R11,
                                     REG_R12, REG_R13, REG_R14, REG_R15 };
    const struct machine_level *level = machine_level_at(machine, machine->level - 1);
    const uint64_t ip = (uint64_t)level->registers[REG_RIP];
    uint64_t registers[16];
    size_t size = LONGEST;

    if (machine->decoder == NULL)
        machine->decoder = code_decoder_open();
    if (machine->decoder == NULL)
        return 0;
    for (int i = 0; i < 16; i++)
        registers[i] = (uint64_t)level->registers[numbers[i]];
    while (size > 1 && !machine_executes(machine, ip, size))
        size--;
    return code_operands(machine->decoder, (const uint8_t *)ip, size, ip, registers, operands);
}
