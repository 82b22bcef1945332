/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_special.c - instructions that no computation needs: they ask an operating system, command
 * the processor, or answer differently on every machine.
 */
#include "image/code.h"

#include <capstone/capstone.h>
#include <stdio.h>
#include <string.h>

static const struct special {
    unsigned id;
    enum image_special_kind kind;
} x86_specials[] = {
    { X86_INS_SYSCALL, IMAGE_SPECIAL_SYSTEM },     { X86_INS_SYSENTER, IMAGE_SPECIAL_SYSTEM },
    { X86_INS_INT, IMAGE_SPECIAL_SYSTEM },         { X86_INS_INT1, IMAGE_SPECIAL_SYSTEM },
    { X86_INS_INT3, IMAGE_SPECIAL_SYSTEM },        { X86_INS_INTO, IMAGE_SPECIAL_SYSTEM },
    { X86_INS_VMCALL, IMAGE_SPECIAL_SYSTEM },      { X86_INS_VMMCALL, IMAGE_SPECIAL_SYSTEM },
    { X86_INS_VMFUNC, IMAGE_SPECIAL_SYSTEM },      { X86_INS_SYSEXIT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_SYSRET, IMAGE_SPECIAL_PRIVILEGED },  { X86_INS_IN, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_INSB, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_INSW, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_INSD, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_OUT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_OUTSB, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_OUTSW, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_OUTSD, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_HLT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_CLI, IMAGE_SPECIAL_PRIVILEGED },     { X86_INS_STI, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_CLTS, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_CLAC, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_STAC, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_RDMSR, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_WRMSR, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_LGDT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_LIDT, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_LLDT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_LTR, IMAGE_SPECIAL_PRIVILEGED },     { X86_INS_LMSW, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_SGDT, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_SIDT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_SLDT, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_STR, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_SMSW, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_INVD, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_WBINVD, IMAGE_SPECIAL_PRIVILEGED },  { X86_INS_INVLPG, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_INVPCID, IMAGE_SPECIAL_PRIVILEGED }, { X86_INS_XSETBV, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_MONITOR, IMAGE_SPECIAL_PRIVILEGED }, { X86_INS_MWAIT, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_SWAPGS, IMAGE_SPECIAL_PRIVILEGED },  { X86_INS_RSM, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_IRET, IMAGE_SPECIAL_PRIVILEGED },    { X86_INS_IRETD, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_IRETQ, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_LJMP, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_LCALL, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_RETF, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_RETFQ, IMAGE_SPECIAL_PRIVILEGED },   { X86_INS_LDS, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_LES, IMAGE_SPECIAL_PRIVILEGED },     { X86_INS_LFS, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_LGS, IMAGE_SPECIAL_PRIVILEGED },     { X86_INS_LSS, IMAGE_SPECIAL_PRIVILEGED },
    { X86_INS_RDFSBASE, IMAGE_SPECIAL_THREAD },    { X86_INS_RDGSBASE, IMAGE_SPECIAL_THREAD },
    { X86_INS_WRFSBASE, IMAGE_SPECIAL_THREAD },    { X86_INS_WRGSBASE, IMAGE_SPECIAL_THREAD },
    { X86_INS_RDTSC, IMAGE_SPECIAL_MACHINE },      { X86_INS_RDTSCP, IMAGE_SPECIAL_MACHINE },
    { X86_INS_RDPMC, IMAGE_SPECIAL_MACHINE },      { X86_INS_CPUID, IMAGE_SPECIAL_MACHINE },
    { X86_INS_RDRAND, IMAGE_SPECIAL_MACHINE },     { X86_INS_RDSEED, IMAGE_SPECIAL_MACHINE },
    { X86_INS_XGETBV, IMAGE_SPECIAL_MACHINE },     { X86_INS_XBEGIN, IMAGE_SPECIAL_MACHINE },
};

static const struct special arm_specials[] = {
    { ARM_INS_SVC, IMAGE_SPECIAL_SYSTEM },       { ARM_INS_SMC, IMAGE_SPECIAL_SYSTEM },
    { ARM_INS_HVC, IMAGE_SPECIAL_SYSTEM },       { ARM_INS_BKPT, IMAGE_SPECIAL_SYSTEM },
    { ARM_INS_HLT, IMAGE_SPECIAL_SYSTEM },       { ARM_INS_CPS, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_WFI, IMAGE_SPECIAL_PRIVILEGED },   { ARM_INS_WFE, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_ERET, IMAGE_SPECIAL_PRIVILEGED },  { ARM_INS_RFEDA, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_RFEDB, IMAGE_SPECIAL_PRIVILEGED }, { ARM_INS_RFEIA, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_RFEIB, IMAGE_SPECIAL_PRIVILEGED }, { ARM_INS_SRSDA, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_SRSDB, IMAGE_SPECIAL_PRIVILEGED }, { ARM_INS_SRSIA, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_SRSIB, IMAGE_SPECIAL_PRIVILEGED }, { ARM_INS_CDP, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_CDP2, IMAGE_SPECIAL_PRIVILEGED },  { ARM_INS_LDC, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_STC, IMAGE_SPECIAL_PRIVILEGED },   { ARM_INS_MCRR, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_MCRR2, IMAGE_SPECIAL_PRIVILEGED }, { ARM_INS_MCR2, IMAGE_SPECIAL_PRIVILEGED },
    { ARM_INS_MRC2, IMAGE_SPECIAL_PRIVILEGED },  { ARM_INS_MRRC2, IMAGE_SPECIAL_PRIVILEGED },
};

static enum image_special_kind listed(const struct special *specials, size_t count, unsigned id)
{
    for (size_t i = 0; i < count; i++)
        if (specials[i].id == id)
            return specials[i].kind;
    return IMAGE_SPECIAL_NONE;
}

#define LISTED(specials, id) listed(specials, sizeof(specials) / sizeof(specials)[0], id)

static bool is_segment(unsigned reg)
{
    return reg == X86_REG_CS || reg == X86_REG_DS || reg == X86_REG_ES || reg == X86_REG_FS ||
           reg == X86_REG_GS || reg == X86_REG_SS;
}

static bool is_control(unsigned reg)
{
    return (reg >= X86_REG_CR0 && reg <= X86_REG_CR15) ||
           (reg >= X86_REG_DR0 && reg <= X86_REG_DR15);
}

/* What a stack probe of Microsoft's compiler asks of Windows: how far the stack reaches down. */
static bool is_stack_limit(const struct code *code, const x86_op_mem *mem)
{
    return code->image->format == IMAGE_FORMAT_PE && code->machine.word == 8 &&
           mem->segment == X86_REG_GS && mem->base == X86_REG_INVALID &&
           mem->index == X86_REG_INVALID && mem->disp == 0x10;
}

static enum image_special_kind x86_operand(const struct code *code, const cs_insn *insn,
                                           unsigned index)
{
    const cs_x86_op *operand = &insn->detail->x86.operands[index];
    const bool written = index == 0 && (insn->id == X86_INS_MOV || insn->id == X86_INS_POP);
    if (operand->type == X86_OP_REG && is_control((unsigned)operand->reg))
        return IMAGE_SPECIAL_PRIVILEGED;
    if (operand->type == X86_OP_REG && written && is_segment((unsigned)operand->reg))
        return IMAGE_SPECIAL_PRIVILEGED;
    if (operand->type == X86_OP_MEM && insn->id != X86_INS_NOP && insn->id != X86_INS_LEA &&
        (operand->mem.segment == X86_REG_FS || operand->mem.segment == X86_REG_GS) &&
        !is_stack_limit(code, &operand->mem))
        return IMAGE_SPECIAL_THREAD;
    return IMAGE_SPECIAL_NONE;
}

static enum image_special_kind x86_special(const struct code *code, const cs_insn *insn)
{
    enum image_special_kind kind = LISTED(x86_specials, insn->id);
    for (unsigned i = 0; kind == IMAGE_SPECIAL_NONE && i < insn->detail->x86.op_count; i++)
        kind = x86_operand(code, insn, i);
    return kind;
}

/*
 * Registers of coprocessor 15 that user code may have to do with, by opc1, CRn, CRm, opc2: the
 * barriers that were instructions of it once, and what an operating system shows.
 */
static const struct register_15 {
    uint8_t opc1, crn, crm, opc2;
    enum image_special_kind kind;
} registers_15[] = {
    { 0, 7, 5, 4, IMAGE_SPECIAL_NONE },     /* instruction barrier */
    { 0, 7, 10, 4, IMAGE_SPECIAL_NONE },    /* data synchronisation barrier */
    { 0, 7, 10, 5, IMAGE_SPECIAL_NONE },    /* data memory barrier */
    { 0, 9, 13, 0, IMAGE_SPECIAL_MACHINE }, /* cycle counter */
    { 0, 13, 0, 2, IMAGE_SPECIAL_THREAD },  /* user thread register */
    { 0, 13, 0, 3, IMAGE_SPECIAL_THREAD },  /* thread block of the operating system */
};

static unsigned coprocessor_number(const cs_arm_op *operand)
{
    return (unsigned)operand->imm;
}

/* mcr, mrc: coprocessor, opc1, Rt, CRn, CRm, opc2. */
static enum image_special_kind arm_coprocessor(const cs_arm *arm)
{
    if (arm->op_count < 6)
        return IMAGE_SPECIAL_PRIVILEGED;
    const unsigned number = coprocessor_number(&arm->operands[0]);
    for (size_t i = 0; number == 15 && i < sizeof registers_15 / sizeof registers_15[0]; i++) {
        const struct register_15 *known = &registers_15[i];
        if (known->opc1 == (unsigned)arm->operands[1].imm &&
            known->crn == coprocessor_number(&arm->operands[3]) &&
            known->crm == coprocessor_number(&arm->operands[4]) &&
            known->opc2 == (unsigned)arm->operands[5].imm)
            return known->kind;
    }
    return IMAGE_SPECIAL_PRIVILEGED;
}

/* mrrc: coprocessor, opc1, Rt, Rt2, CRm. The counters of the generic timer are for everybody. */
static enum image_special_kind arm_counter(const cs_arm *arm)
{
    return arm->op_count == 5 && coprocessor_number(&arm->operands[0]) == 15 &&
                   coprocessor_number(&arm->operands[4]) == 14
               ? IMAGE_SPECIAL_MACHINE
               : IMAGE_SPECIAL_PRIVILEGED;
}

/* Only the flags of the status register are user code's. The bits of the encoding that select its
 * parts: c x s f from bit 16 of an A32 instruction, from bit 8 of a Thumb one; bit 22 or 20 selects
 * the saved register. */
static enum image_special_kind arm_status(const cs_insn *insn, bool thumb)
{
    const uint32_t a32 = (uint32_t)insn->bytes[0] | (uint32_t)insn->bytes[1] << 8 |
                         (uint32_t)insn->bytes[2] << 16 | (uint32_t)insn->bytes[3] << 24;
    const uint32_t word = thumb ? a32 << 16 | a32 >> 16 : a32;
    const bool saved = (word & (thumb ? 1u << 20 : 1u << 22)) != 0;
    const uint32_t parts = word >> (thumb ? 8 : 16) & 15u;
    return saved || (insn->id == ARM_INS_MSR && (parts & 3u) != 0) ? IMAGE_SPECIAL_PRIVILEGED
                                                                   : IMAGE_SPECIAL_NONE;
}

/* FPSCR is user code's, what switches the unit on is not. */
static enum image_special_kind arm_vector_status(const cs_arm *arm)
{
    for (unsigned i = 0; i < arm->op_count; i++)
        if (arm->operands[i].type == ARM_OP_REG &&
            (arm->operands[i].reg == ARM_REG_FPEXC || arm->operands[i].reg == ARM_REG_FPSID))
            return IMAGE_SPECIAL_PRIVILEGED;
    return IMAGE_SPECIAL_NONE;
}

/* `subs pc, lr, #4`, `movs pc, lr`, `ldm sp!, {..., pc}^`: back out of an exception. */
static bool leaves_exception(const cs_insn *insn)
{
    const cs_arm *arm = &insn->detail->arm;
    if (arm->usermode)
        return true;
    return arm->update_flags && arm->op_count > 0 && arm->operands[0].type == ARM_OP_REG &&
           arm->operands[0].reg == ARM_REG_PC &&
           (insn->id == ARM_INS_SUB || insn->id == ARM_INS_MOV);
}

static enum image_special_kind arm_special(const cs_insn *insn, bool thumb)
{
    switch (insn->id) {
    case ARM_INS_MCR:
    case ARM_INS_MRC:
        return arm_coprocessor(&insn->detail->arm);
    case ARM_INS_MRRC:
        return arm_counter(&insn->detail->arm);
    case ARM_INS_VMSR:
    case ARM_INS_VMRS:
        return arm_vector_status(&insn->detail->arm);
    case ARM_INS_MSR:
    case ARM_INS_MRS:
        return arm_status(insn, thumb);
    default:
        return leaves_exception(insn) ? IMAGE_SPECIAL_PRIVILEGED : LISTED(arm_specials, insn->id);
    }
}

enum image_special_kind code_special(const struct code *code, const struct cs_insn *from,
                                     bool thumb)
{
    return code->image->target == IMAGE_TARGET_ARM ? arm_special(from, thumb)
                                                   : x86_special(code, from);
}

void code_text(struct code *code, uint64_t vaddr, bool thumb, char *text, size_t size)
{
    cs_insn *insn;
    uint64_t offset;
    snprintf(text, size, "?");
    if (!image_file_range(code->image, vaddr, 1, &offset))
        return;
    const size_t rest = code->image->size - offset;
    if (cs_disasm(thumb ? code->thumb_handle : code->handle, code->image->bytes + offset,
                  rest < 15 ? rest : 15, vaddr, 1, &insn) == 0)
        return;
    snprintf(text, size, "%s%s%s", insn->mnemonic, insn->op_str[0] != '\0' ? " " : "",
             insn->op_str);
    cs_free(insn, 1);
}
