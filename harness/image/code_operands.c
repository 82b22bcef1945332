/* SPDX-License-Identifier: GPL-2.0-or-later */
/* code_operands.c - see code_operands.h. */
#include <stdlib.h>

#include <capstone/capstone.h>

#include "image/code_operands.h"

struct code_decoder {
    csh capstone;
    cs_insn *instruction;
};

/* In the processor's numbering: all of a register, and its lower half. */
static const x86_reg numbers[16][2] = {
    { X86_REG_RAX, X86_REG_EAX },  { X86_REG_RCX, X86_REG_ECX },  { X86_REG_RDX, X86_REG_EDX },
    { X86_REG_RBX, X86_REG_EBX },  { X86_REG_RSP, X86_REG_ESP },  { X86_REG_RBP, X86_REG_EBP },
    { X86_REG_RSI, X86_REG_ESI },  { X86_REG_RDI, X86_REG_EDI },  { X86_REG_R8, X86_REG_R8D },
    { X86_REG_R9, X86_REG_R9D },   { X86_REG_R10, X86_REG_R10D }, { X86_REG_R11, X86_REG_R11D },
    { X86_REG_R12, X86_REG_R12D }, { X86_REG_R13, X86_REG_R13D }, { X86_REG_R14, X86_REG_R14D },
    { X86_REG_R15, X86_REG_R15D },
};

struct code_decoder *code_decoder_open(void)
{
    struct code_decoder *decoder = calloc(1, sizeof *decoder);

    if (decoder == NULL || cs_open(CS_ARCH_X86, CS_MODE_64, &decoder->capstone) != CS_ERR_OK) {
        free(decoder);
        return NULL;
    }
    cs_option(decoder->capstone, CS_OPT_DETAIL, CS_OPT_ON);
    decoder->instruction = cs_malloc(decoder->capstone);
    if (decoder->instruction != NULL)
        return decoder;
    code_decoder_close(decoder);
    return NULL;
}

void code_decoder_close(struct code_decoder *decoder)
{
    if (decoder == NULL)
        return;
    if (decoder->instruction != NULL)
        cs_free(decoder->instruction, 1);
    cs_close(&decoder->capstone);
    free(decoder);
}

static uint64_t value_of(const uint64_t registers[16], x86_reg reg)
{
    for (int i = 0; i < 16; i++)
        if (numbers[i][0] == reg)
            return registers[i];
        else if (numbers[i][1] == reg)
            return (uint32_t)registers[i];
    return 0;
}

static uint64_t address_of(const uint64_t registers[16], const cs_insn *instruction,
                           const x86_op_mem *operand)
{
    uint64_t base = operand->base == X86_REG_RIP ? instruction->address + instruction->size
                                                 : value_of(registers, operand->base);

    return base + value_of(registers, operand->index) * (uint64_t)operand->scale +
           (uint64_t)operand->disp;
}

unsigned code_operands(struct code_decoder *decoder, const uint8_t *code, size_t size, uint64_t at,
                       const uint64_t registers[16], struct code_operand operands[CODE_OPERANDS])
{
    const cs_insn *instruction = decoder->instruction;
    unsigned count = 0;

    if (!cs_disasm_iter(decoder->capstone, &code, &size, &at, decoder->instruction))
        return 0;
    if (instruction->id == X86_INS_LEA || instruction->id == X86_INS_NOP)
        return 0;
    for (unsigned i = 0; i < instruction->detail->x86.op_count && count < CODE_OPERANDS; i++) {
        const cs_x86_op *operand = &instruction->detail->x86.operands[i];

        if (operand->type == X86_OP_MEM)
            operands[count++] =
                (struct code_operand){ .address = address_of(registers, instruction, &operand->mem),
                                       .size = operand->size,
                                       .read = (operand->access & CS_AC_READ) != 0,
                                       .write = (operand->access & CS_AC_WRITE) != 0 };
    }
    return count;
}
