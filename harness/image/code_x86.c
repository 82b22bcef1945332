/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_x86.c - x86-64 and i386 instructions as code.h wants them.
 */
#include "image/code.h"

#include <capstone/capstone.h>

enum { AX = 0, CX = 1, SP = 4, BP = 5, SI = 6, DI = 7 };

struct reading {
    struct code *code;
    struct code_insn *insn;
    const cs_insn *from;
    const cs_x86 *x86;
    unsigned word;
};

static const struct {
    uint16_t reg;
    int8_t number;
    uint8_t width;
} registers[] = {
    { X86_REG_RAX, 0, 8 },   { X86_REG_RCX, 1, 8 },   { X86_REG_RDX, 2, 8 },
    { X86_REG_RBX, 3, 8 },   { X86_REG_RSP, 4, 8 },   { X86_REG_RBP, 5, 8 },
    { X86_REG_RSI, 6, 8 },   { X86_REG_RDI, 7, 8 },   { X86_REG_R8, 8, 8 },
    { X86_REG_R9, 9, 8 },    { X86_REG_R10, 10, 8 },  { X86_REG_R11, 11, 8 },
    { X86_REG_R12, 12, 8 },  { X86_REG_R13, 13, 8 },  { X86_REG_R14, 14, 8 },
    { X86_REG_R15, 15, 8 },  { X86_REG_EAX, 0, 4 },   { X86_REG_ECX, 1, 4 },
    { X86_REG_EDX, 2, 4 },   { X86_REG_EBX, 3, 4 },   { X86_REG_ESP, 4, 4 },
    { X86_REG_EBP, 5, 4 },   { X86_REG_ESI, 6, 4 },   { X86_REG_EDI, 7, 4 },
    { X86_REG_R8D, 8, 4 },   { X86_REG_R9D, 9, 4 },   { X86_REG_R10D, 10, 4 },
    { X86_REG_R11D, 11, 4 }, { X86_REG_R12D, 12, 4 }, { X86_REG_R13D, 13, 4 },
    { X86_REG_R14D, 14, 4 }, { X86_REG_R15D, 15, 4 }, { X86_REG_AX, 0, 2 },
    { X86_REG_CX, 1, 2 },    { X86_REG_DX, 2, 2 },    { X86_REG_BX, 3, 2 },
    { X86_REG_SP, 4, 2 },    { X86_REG_BP, 5, 2 },    { X86_REG_SI, 6, 2 },
    { X86_REG_DI, 7, 2 },    { X86_REG_R8W, 8, 2 },   { X86_REG_R9W, 9, 2 },
    { X86_REG_R10W, 10, 2 }, { X86_REG_R11W, 11, 2 }, { X86_REG_R12W, 12, 2 },
    { X86_REG_R13W, 13, 2 }, { X86_REG_R14W, 14, 2 }, { X86_REG_R15W, 15, 2 },
    { X86_REG_AL, 0, 1 },    { X86_REG_CL, 1, 1 },    { X86_REG_DL, 2, 1 },
    { X86_REG_BL, 3, 1 },    { X86_REG_AH, 0, 0 },    { X86_REG_CH, 1, 0 },
    { X86_REG_DH, 2, 0 },    { X86_REG_BH, 3, 0 },    { X86_REG_SPL, 4, 1 },
    { X86_REG_BPL, 5, 1 },   { X86_REG_SIL, 6, 1 },   { X86_REG_DIL, 7, 1 },
    { X86_REG_R8B, 8, 1 },   { X86_REG_R9B, 9, 1 },   { X86_REG_R10B, 10, 1 },
    { X86_REG_R11B, 11, 1 }, { X86_REG_R12B, 12, 1 }, { X86_REG_R13B, 13, 1 },
    { X86_REG_R14B, 14, 1 }, { X86_REG_R15B, 15, 1 },
};

/* The general register that holds it, CODE_NONE for others. Width 0: its second byte. */
static int general(unsigned reg, unsigned *width)
{
    for (size_t i = 0; i < sizeof registers / sizeof registers[0]; i++) {
        if (registers[i].reg == reg) {
            *width = registers[i].width;
            return registers[i].number;
        }
    }
    *width = 0;
    return CODE_NONE;
}

static int register_of(const cs_x86_op *operand, unsigned *width)
{
    *width = 0;
    return operand->type == X86_OP_REG ? general(operand->reg, width) : CODE_NONE;
}

/* Fills in the place of a memory operand; false when it is one that cannot be followed. */
static bool address(const struct reading *r, const cs_x86_op *operand, struct code_op *op)
{
    const x86_op_mem *mem = &operand->mem;
    unsigned width;
    if (mem->segment == X86_REG_FS || mem->segment == X86_REG_GS)
        return false;
    op->imm = mem->disp;
    op->a = op->b = CODE_NONE;
    op->width = operand->size > 64 ? 64 : operand->size;
    if (mem->base == X86_REG_RIP || mem->base == X86_REG_EIP) {
        op->imm += (int64_t)(r->insn->vaddr + r->insn->size);
        return true;
    }
    if (mem->base != X86_REG_INVALID && (op->a = (int8_t)general(mem->base, &width)) == CODE_NONE)
        return false;
    if (mem->index != X86_REG_INVALID && mem->index != X86_REG_RIZ && mem->index != X86_REG_EIZ) {
        op->b = (int8_t)general(mem->index, &width);
        op->shift = mem->scale == 8 ? 3 : mem->scale == 4 ? 2 : mem->scale == 2 ? 1 : 0;
        if (op->b == CODE_NONE)
            return false;
    }
    /* An absolute address counts on the preferred load address. */
    const uint64_t number = r->word == 4 ? (uint32_t)mem->disp : (uint64_t)mem->disp;
    uint64_t vaddr;
    if (code_is_absolute(r->code, number, &vaddr))
        op->imm = (int64_t)vaddr;
    return true;
}

static void add(struct reading *r, struct code_op op)
{
    code_op(r->code, r->insn, op);
}

static void kill(struct reading *r, int reg)
{
    if (reg != CODE_NONE)
        add(r, (struct code_op){ .kind = CODE_KILL, .dst = (int8_t)reg });
}

static void cut(struct reading *r, int reg, unsigned width)
{
    if (width < r->word)
        add(r,
            (struct code_op){
                .kind = CODE_LOW, .dst = (int8_t)reg, .a = (int8_t)reg, .width = (uint8_t)width });
}

static void move_sp(struct reading *r, int64_t bytes)
{
    add(r, (struct code_op){ .kind = CODE_ADD, .dst = SP, .a = SP, .imm = bytes });
}

static void push(struct reading *r, int reg, unsigned bytes)
{
    /* push rsp stores the value before. */
    move_sp(r, -(int64_t)bytes);
    add(r, (struct code_op){ .kind = CODE_STORE,
                             .dst = (int8_t)(reg == SP ? CODE_NONE : reg),
                             .a = SP,
                             .b = CODE_NONE,
                             .width = (uint8_t)bytes });
}

static void pop(struct reading *r, int reg, unsigned bytes)
{
    add(r, (struct code_op){ .kind = CODE_LOAD,
                             .dst = CODE_TEMP,
                             .a = SP,
                             .b = CODE_NONE,
                             .width = (uint8_t)bytes });
    move_sp(r, bytes);
    if (reg != CODE_NONE)
        add(r, (struct code_op){ .kind = CODE_ADD, .dst = (int8_t)reg, .a = CODE_TEMP });
}

static void load(struct reading *r, int dst, const cs_x86_op *operand, bool is_signed)
{
    struct code_op op = { .kind = CODE_LOAD, .dst = (int8_t)dst, .is_signed = is_signed };
    if (address(r, operand, &op))
        add(r, op);
    else
        kill(r, dst);
}

static void store(struct reading *r, int reg, const cs_x86_op *operand)
{
    struct code_op op = { .kind = CODE_STORE, .dst = (int8_t)reg };
    if (address(r, operand, &op))
        add(r, op);
}

/* ---- instructions that matter ---- */

static void read_mov(struct reading *r)
{
    const cs_x86_op *to = &r->x86->operands[0], *from = &r->x86->operands[1];
    unsigned width, from_width;
    const int dst = register_of(to, &width), src = register_of(from, &from_width);
    if (to->type == X86_OP_MEM) {
        store(r, src != CODE_NONE && from_width == r->word ? src : CODE_NONE, to);
    } else if (dst == CODE_NONE) {
        return; /* to a segment or control register */
    } else if (width < 4) {
        if (from->type == X86_OP_MEM)
            load(r, CODE_TEMP, from, false);
        kill(r, dst);
    } else if (from->type == X86_OP_MEM) {
        load(r, dst, from, false);
    } else if (from->type == X86_OP_IMM) {
        const int64_t number = width == 4 ? (int64_t)(uint32_t)from->imm : from->imm;
        add(r, (struct code_op){ .kind = CODE_NUMBER, .dst = (int8_t)dst, .imm = number });
    } else if (src != CODE_NONE) {
        add(r, (struct code_op){ .kind = CODE_ADD, .dst = (int8_t)dst, .a = (int8_t)src });
        cut(r, dst, width);
    } else {
        kill(r, dst);
    }
}

/* movzx, movsx, movsxd. */
static void read_extend(struct reading *r, bool is_signed)
{
    const cs_x86_op *from = &r->x86->operands[1];
    unsigned width, from_width;
    const int dst = register_of(&r->x86->operands[0], &width);
    const int src = register_of(from, &from_width);
    if (dst == CODE_NONE)
        return;
    if (from->type == X86_OP_MEM)
        load(r, dst, from, is_signed);
    else if (src != CODE_NONE && from_width != 0)
        add(r, (struct code_op){ .kind = CODE_LOW,
                                 .dst = (int8_t)dst,
                                 .a = (int8_t)src,
                                 .width = (uint8_t)from_width });
    else
        kill(r, dst);
}

static void read_lea(struct reading *r)
{
    unsigned width;
    const int dst = register_of(&r->x86->operands[0], &width);
    struct code_op op = { .kind = CODE_SUM, .dst = (int8_t)dst };
    if (dst == CODE_NONE)
        return;
    if (r->x86->operands[1].type != X86_OP_MEM || !address(r, &r->x86->operands[1], &op)) {
        kill(r, dst);
        return;
    }
    if (op.a == CODE_NONE && op.b == CODE_NONE)
        op.kind = CODE_PLACE;
    else if (op.b == CODE_NONE)
        op.kind = CODE_ADD;
    add(r, op);
    cut(r, dst, width);
}

/* add, sub, and, with a register first. */
static void read_arithmetic(struct reading *r)
{
    const cs_x86_op *to = &r->x86->operands[0], *from = &r->x86->operands[1];
    unsigned width, from_width;
    const int dst = register_of(to, &width), src = register_of(from, &from_width);
    const unsigned id = r->from->id;
    struct code_op op = { .dst = (int8_t)dst, .a = (int8_t)dst, .b = (int8_t)src };
    if (to->type == X86_OP_MEM)
        store(r, CODE_NONE, to);
    if (from->type == X86_OP_MEM)
        load(r, CODE_TEMP, from, false);
    add(r, (struct code_op){ .kind = CODE_FLAGS });
    if (dst == CODE_NONE)
        return;
    if (from->type == X86_OP_IMM && width >= 4) {
        const int64_t imm = width == 4 ? (int32_t)from->imm : from->imm;
        op.kind = id == X86_INS_AND ? CODE_MASK : CODE_ADD;
        op.imm = id == X86_INS_SUB ? (int64_t) - (uint64_t)imm : imm;
    } else if (src != CODE_NONE && width >= 4 && id != X86_INS_AND) {
        op.kind = id == X86_INS_SUB ? CODE_DIFF : CODE_SUM;
    } else {
        op.kind = CODE_KILL;
    }
    add(r, op);
    if (op.kind != CODE_KILL)
        cut(r, dst, width);
}

static void read_compare(struct reading *r)
{
    unsigned width;
    const int reg = register_of(&r->x86->operands[0], &width);
    for (unsigned i = 0; i < 2; i++) {
        if (r->x86->operands[i].type == X86_OP_MEM)
            load(r, CODE_TEMP, &r->x86->operands[i], false);
    }
    if (reg != CODE_NONE && width != 0 && r->x86->operands[1].type == X86_OP_IMM)
        add(r, (struct code_op){
                   .kind = CODE_COMPARE, .a = (int8_t)reg, .imm = r->x86->operands[1].imm });
    else
        add(r, (struct code_op){ .kind = CODE_FLAGS });
}

/* Also of a segment register, which Capstone calls two bytes wide. */
static unsigned pushed_bytes(const struct reading *r)
{
    return r->x86->prefix[2] == X86_PREFIX_OPSIZE ? 2 : r->word;
}

static void read_push(struct reading *r)
{
    unsigned width, bytes = pushed_bytes(r);
    const int reg = register_of(&r->x86->operands[0], &width);
    if (r->x86->operands[0].type == X86_OP_MEM)
        load(r, CODE_TEMP, &r->x86->operands[0], false);
    push(r, width == r->word ? reg : CODE_NONE, bytes);
}

static void read_pop(struct reading *r)
{
    unsigned width, bytes = pushed_bytes(r);
    const int reg = register_of(&r->x86->operands[0], &width);
    pop(r, width == r->word ? reg : CODE_NONE, bytes);
    if (width != r->word)
        kill(r, reg);
    if (r->x86->operands[0].type == X86_OP_MEM)
        store(r, CODE_NONE, &r->x86->operands[0]);
}

static void read_enter(struct reading *r)
{
    const int64_t size = r->x86->operands[0].imm & 0xffff, level = r->x86->operands[1].imm & 31;
    push(r, BP, r->word);
    if (level > 0) /* copies frame pointers of enclosing functions; nobody does that any more */
        move_sp(r, -(int64_t)r->word * level);
    add(r,
        (struct code_op){ .kind = CODE_ADD, .dst = BP, .a = SP, .imm = level * (int64_t)r->word });
    move_sp(r, -size);
}

static void read_leave(struct reading *r)
{
    add(r, (struct code_op){ .kind = CODE_ADD, .dst = SP, .a = BP });
    pop(r, BP, r->word);
}

/* ---- all others ---- */

/* What it reads and writes, in memory and in registers, becomes any value. */
static void read_other(struct reading *r)
{
    cs_regs reads, writes;
    uint8_t read_count, write_count;
    unsigned width;
    for (unsigned i = 0; i < r->x86->op_count; i++) {
        const cs_x86_op *operand = &r->x86->operands[i];
        if (operand->type != X86_OP_MEM || r->from->id == X86_INS_NOP)
            continue;
        if ((operand->access & CS_AC_WRITE) != 0)
            store(r, CODE_NONE, operand);
        else
            load(r, CODE_TEMP, operand, false);
    }
    /* Capstone knows what an instruction writes, but for a few new ones: the first operand, too. */
    if (r->x86->op_count > 0 && r->from->id != X86_INS_NOP)
        kill(r, register_of(&r->x86->operands[0], &width));
    if (cs_regs_access(r->code->handle, r->from, reads, &read_count, writes, &write_count) !=
        CS_ERR_OK)
        return;
    for (unsigned i = 0; i < write_count; i++) {
        if (writes[i] == X86_REG_EFLAGS)
            add(r, (struct code_op){ .kind = CODE_FLAGS });
        kill(r, general(writes[i], &width));
    }
}

static void read_test(struct reading *r)
{
    for (unsigned i = 0; i < r->x86->op_count; i++) {
        if (r->x86->operands[i].type == X86_OP_MEM)
            load(r, CODE_TEMP, &r->x86->operands[i], false);
    }
    add(r, (struct code_op){ .kind = CODE_FLAGS });
}

static void read_xor(struct reading *r)
{
    const cs_x86_op *to = &r->x86->operands[0], *from = &r->x86->operands[1];
    unsigned width;
    const int dst = register_of(to, &width);
    if (dst == CODE_NONE || width < 4 || from->type != X86_OP_REG || from->reg != to->reg) {
        read_other(r);
        return;
    }
    add(r, (struct code_op){ .kind = CODE_NUMBER, .dst = (int8_t)dst });
    add(r, (struct code_op){ .kind = CODE_FLAGS });
}

static void read_step(struct reading *r, int64_t step)
{
    unsigned width;
    const int dst = register_of(&r->x86->operands[0], &width);
    if (dst == CODE_NONE || width < 4) {
        read_other(r);
        return;
    }
    add(r, (struct code_op){ .kind = CODE_ADD, .dst = (int8_t)dst, .a = (int8_t)dst, .imm = step });
    add(r, (struct code_op){ .kind = CODE_FLAGS });
    cut(r, dst, width);
}

/* ---- where control goes ---- */

static const struct {
    unsigned id;
    enum code_condition condition;
} branches[] = {
    { X86_INS_JMP, CODE_ALWAYS },       { X86_INS_JA, CODE_ABOVE },
    { X86_INS_JAE, CODE_ABOVE_EQUAL },  { X86_INS_JB, CODE_BELOW },
    { X86_INS_JBE, CODE_BELOW_EQUAL },  { X86_INS_JE, CODE_SOMETIMES },
    { X86_INS_JNE, CODE_SOMETIMES },    { X86_INS_JG, CODE_SOMETIMES },
    { X86_INS_JGE, CODE_SOMETIMES },    { X86_INS_JL, CODE_SOMETIMES },
    { X86_INS_JLE, CODE_SOMETIMES },    { X86_INS_JO, CODE_SOMETIMES },
    { X86_INS_JNO, CODE_SOMETIMES },    { X86_INS_JP, CODE_SOMETIMES },
    { X86_INS_JNP, CODE_SOMETIMES },    { X86_INS_JS, CODE_SOMETIMES },
    { X86_INS_JNS, CODE_SOMETIMES },    { X86_INS_JCXZ, CODE_SOMETIMES },
    { X86_INS_JECXZ, CODE_SOMETIMES },  { X86_INS_JRCXZ, CODE_SOMETIMES },
    { X86_INS_LOOP, CODE_SOMETIMES },   { X86_INS_LOOPE, CODE_SOMETIMES },
    { X86_INS_LOOPNE, CODE_SOMETIMES },
};

static bool branch_condition(unsigned id, uint8_t *condition)
{
    for (size_t i = 0; i < sizeof branches / sizeof branches[0]; i++) {
        if (branches[i].id == id) {
            *condition = (uint8_t)branches[i].condition;
            return true;
        }
    }
    return false;
}

static void read_target(struct reading *r, enum code_flow direct, enum code_flow through)
{
    const cs_x86_op *operand = &r->x86->operands[0];
    unsigned width;
    r->insn->flow = (uint8_t)through;
    r->insn->value = CODE_TEMP;
    if (operand->type == X86_OP_IMM) {
        r->insn->flow = (uint8_t)direct;
        r->insn->target = r->word == 4 ? (uint32_t)operand->imm : (uint64_t)operand->imm;
    } else if (operand->type == X86_OP_MEM) {
        load(r, CODE_TEMP, operand, false);
    } else {
        r->insn->value = (int8_t)register_of(operand, &width);
    }
    if (r->insn->flow == through && r->insn->value == CODE_NONE)
        r->insn->flow = CODE_STOP;
}

static bool read_flow(struct reading *r)
{
    struct code_insn *insn = r->insn;
    if (branch_condition(r->from->id, &insn->condition)) {
        read_target(r, CODE_JUMP, CODE_JUMP_VALUE);
        if (r->from->id == X86_INS_LOOP || r->from->id == X86_INS_LOOPE ||
            r->from->id == X86_INS_LOOPNE)
            kill(r, CX);
        return true;
    }
    switch (r->from->id) {
    case X86_INS_CALL:
        read_target(r, CODE_CALL, CODE_CALL_VALUE);
        return true;
    case X86_INS_RET:
        insn->flow = CODE_RETURN;
        insn->pops = r->x86->op_count > 0 ? (uint16_t)r->x86->operands[0].imm : 0;
        return true;
    case X86_INS_HLT:
    case X86_INS_UD2:
    case X86_INS_INT3:
    case X86_INS_IRET:
    case X86_INS_IRETD:
    case X86_INS_IRETQ:
    case X86_INS_RETF:
    case X86_INS_RETFQ:
    case X86_INS_LJMP:
    case X86_INS_LCALL:
        insn->flow = CODE_STOP;
        return true;
    default:
        return false;
    }
}

static bool read_stack(struct reading *r)
{
    switch (r->from->id) {
    case X86_INS_PUSH:
        read_push(r);
        return true;
    case X86_INS_POP:
        read_pop(r);
        return true;
    case X86_INS_PUSHF:
        push(r, CODE_NONE, 2);
        return true;
    case X86_INS_PUSHFD:
    case X86_INS_PUSHFQ:
        push(r, CODE_NONE, r->word);
        return true;
    case X86_INS_POPF:
    case X86_INS_POPFD:
    case X86_INS_POPFQ:
        pop(r, CODE_NONE, r->from->id == X86_INS_POPF ? 2 : r->word);
        add(r, (struct code_op){ .kind = CODE_FLAGS });
        return true;
    case X86_INS_PUSHAL:
    case X86_INS_PUSHAW:
        move_sp(r, r->from->id == X86_INS_PUSHAL ? -32 : -16);
        return true;
    case X86_INS_POPAL:
    case X86_INS_POPAW:
        for (int reg = 0; reg < 8; reg++)
            kill(r, reg != SP ? reg : CODE_NONE);
        move_sp(r, r->from->id == X86_INS_POPAL ? 32 : 16);
        return true;
    case X86_INS_ENTER:
        read_enter(r);
        return true;
    case X86_INS_LEAVE:
        read_leave(r);
        return true;
    default:
        return false;
    }
}

static void read_values(struct reading *r)
{
    switch (r->from->id) {
    case X86_INS_MOV:
    case X86_INS_MOVABS:
        read_mov(r);
        break;
    case X86_INS_MOVZX:
        read_extend(r, false);
        break;
    case X86_INS_MOVSX:
    case X86_INS_MOVSXD:
        read_extend(r, true);
        break;
    case X86_INS_CDQE:
    case X86_INS_CWDE:
        break; /* an index stays one */
    case X86_INS_LEA:
        read_lea(r);
        break;
    case X86_INS_ADD:
    case X86_INS_SUB:
    case X86_INS_AND:
        read_arithmetic(r);
        break;
    case X86_INS_INC:
        read_step(r, 1);
        break;
    case X86_INS_DEC:
        read_step(r, -1);
        break;
    case X86_INS_XOR:
        read_xor(r);
        break;
    case X86_INS_CMP:
        read_compare(r);
        break;
    case X86_INS_TEST:
        read_test(r);
        break;
    default:
        read_other(r);
        break;
    }
}

void code_x86(struct code *code, struct code_insn *insn, const struct cs_insn *from)
{
    struct reading r = { .code = code,
                         .insn = insn,
                         .from = from,
                         .x86 = &from->detail->x86,
                         .word = code->machine.word };
    if (!read_flow(&r) && !read_stack(&r))
        read_values(&r);
}
