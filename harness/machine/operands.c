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

static bool overlap(uint64_t a, size_t a_size, uint64_t b, size_t b_size)
{
    return a < b + b_size && b < a + a_size;
}

static enum machine_access access_of(const struct machine_level *level, const cs_insn *instruction,
                                     uint64_t at, size_t size)
{
    const cs_x86 *x86 = &instruction->detail->x86;
    enum machine_access access = MACHINE_ACCESS_NONE;

    for (unsigned i = 0; i < x86->op_count; i++) {
        const cs_x86_op *operand = &x86->operands[i];

        if (operand->type != X86_OP_MEM || instruction->id == X86_INS_LEA ||
            !overlap(address_of(level, instruction, &operand->mem), operand->size, at, size))
            continue;
        if (operand->access & CS_AC_WRITE)
            return MACHINE_ACCESS_WRITE;
        access = MACHINE_ACCESS_READ;
    }
    return access;
}

enum machine_access machine_next_access(struct machine *machine, const void *at, size_t size)
{
    const struct machine_level *level = &machine->levels[machine->level - 1];
    uint64_t ip = (uint64_t)level->registers[REG_RIP];
    const uint8_t *code = (const uint8_t *)ip;
    size_t length = LONGEST;
    enum machine_access access = MACHINE_ACCESS_NONE;
    cs_insn *instruction;
    csh capstone;

    while (length > 1 && !machine_executes(machine, ip, length))
        length--;
    if (cs_open(CS_ARCH_X86, CS_MODE_64, &capstone) != CS_ERR_OK)
        return access;
    cs_option(capstone, CS_OPT_DETAIL, CS_OPT_ON);
    instruction = cs_malloc(capstone);
    if (instruction != NULL && cs_disasm_iter(capstone, &code, &length, &ip, instruction))
        access = access_of(level, instruction, (uint64_t)at, size);
    if (instruction != NULL)
        cs_free(instruction, 1);
    cs_close(&capstone);
    return access;
}
