/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_operands.h - what memory one instruction of an x86-64 module touches by its operands, given
 * the registers before it. For who runs the code (machine/); what it pushes or pops is not told.
 */
#ifndef HARNESS_IMAGE_CODE_OPERANDS_H
#define HARNESS_IMAGE_CODE_OPERANDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CODE_OPERANDS 2

struct code_operand {
    uint64_t address;
    size_t size;
    bool read, write;
};

struct code_decoder;

/* NULL: no memory. */
struct code_decoder *code_decoder_open(void);
void code_decoder_close(struct code_decoder *decoder);

/* registers: rax, rcx, rdx, rbx, rsp, rbp, rsi, rdi, r8 to r15, as the processor numbers them. How
 * many operands; none when the bytes are no instruction. */
unsigned code_operands(struct code_decoder *decoder, const uint8_t *code, size_t size, uint64_t at,
                       const uint64_t registers[16], struct code_operand operands[CODE_OPERANDS]);

#endif
