/* SPDX-License-Identifier: GPL-2.0-or-later */
/* operands.c - what memory the instruction at an interrupt is about to touch. */
#define _GNU_SOURCE 1
#include <capstone/capstone.h>

#include "machine/machine_private.h"

#define LONGEST 15 /* bytes of an instruction */

/* Capstone's registers that an address is made of, and the kernel's. The 32-bit ones are the lower
 * halves. */
static const struct {
    x86_reg whole, half;
    int number;
} registers[] = {
    { X86_REG_RAX, X86_REG_EAX, REG_RAX },  { X86_REG_RBX, X86_REG_EBX, REG_RBX },
    { X86_REG_RCX, X86_REG_ECX, REG_RCX },  { X86_REG_RDX, X86_REG_EDX, REG_RDX },
    { X86_REG_RSI, X86_REG_ESI, REG_RSI },  { X86_REG_RDI, X86_REG_EDI, REG_RDI },
    { X86_REG_RBP, X86_REG_EBP, REG_RBP },  { X86_REG_RSP, X86_REG_ESP, REG_RSP },
    { X86_REG_R8, X86_REG_R8D, REG_R8 },    { X86_REG_R9, X86_REG_R9D, REG_R9 },
    { X86_REG_R10, X86_REG_R10D, REG_R10 }, { X86_REG_R11, X86_REG_R11D, REG_R11 },
    { X86_REG_R12, X86_REG_R12D, REG_R12 }, { X86_REG_R13, X86_REG_R13D, REG_R13 },
    { X86_REG_R14, X86_REG_R14D, REG_R14 }, { X86_REG_R15, X86_REG_R15D, REG_R15 },
};

static uint64_t value_of(const struct machine_level *level, x86_reg reg)
{
    for (size_t i = 0; i < sizeof registers / sizeof registers[0]; i++)
        if (registers[i].whole == reg)
            return (uint64_t)level->registers[registers[i].number];
        else if (registers[i].half == reg)
            return (uint32_t)level->registers[registers[i].number];
    return 0;
}

static uint64_t address_of(const struct machine_level *level, const cs_insn *instruction,
                           const x86_op_mem *operand)
{
    uint64_t base = operand->base == X86_REG_RIP ? instruction->address + instruction->size
                                                 : value_of(level, operand->base);

    return base + value_of(level, operand->index) * (uint64_t)operand->scale +
           (uint64_t)operand->disp;
}

static unsigned operands_of(const struct machine_level *level, const cs_insn *instruction,
                            struct machine_operand operands[MACHINE_OPERANDS])
{
    const cs_x86 *x86 = &instruction->detail->x86;
    unsigned count = 0;

    if (instruction->id == X86_INS_LEA || instruction->id == X86_INS_NOP)
        return 0;
    for (unsigned i = 0; i < x86->op_count && count < MACHINE_OPERANDS; i++) {
        const cs_x86_op *operand = &x86->operands[i];

        if (operand->type == X86_OP_MEM)
            operands[count++] =
                (struct machine_operand){ .address = address_of(level, instruction, &operand->mem),
                                          .size = operand->size,
                                          .read = (operand->access & CS_AC_READ) != 0,
                                          .write = (operand->access & CS_AC_WRITE) != 0 };
    }
    return count;
}

static bool decoder_open(struct machine *machine)
{
    csh capstone;

    if (machine->decoder != 0)
        return machine->decoded != NULL;
    if (cs_open(CS_ARCH_X86, CS_MODE_64, &capstone) != CS_ERR_OK)
        return false;
    cs_option(capstone, CS_OPT_DETAIL, CS_OPT_ON);
    machine->decoder = capstone;
    machine->decoded = cs_malloc(capstone);
    return machine->decoded != NULL;
}

void machine_operands_close(struct machine *machine)
{
    csh capstone = machine->decoder;

    if (machine->decoded != NULL)
        cs_free(machine->decoded, 1);
    if (capstone != 0)
        cs_close(&capstone);
    machine->decoder = 0;
    machine->decoded = NULL;
}

unsigned machine_next_operands(struct machine *machine,
                               struct machine_operand operands[MACHINE_OPERANDS])
{
    const struct machine_level *level = &machine->levels[machine->level - 1];
    uint64_t ip = (uint64_t)level->registers[REG_RIP];
    const uint8_t *code = (const uint8_t *)ip;
    size_t length = LONGEST;

    if (!decoder_open(machine))
        return 0;
    while (length > 1 && !machine_executes(machine, ip, length))
        length--;
    if (!cs_disasm_iter(machine->decoder, &code, &length, &ip, machine->decoded))
        return 0;
    return operands_of(level, machine->decoded, operands);
}
