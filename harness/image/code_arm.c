/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_arm.c - Arm instructions, A32 and Thumb, as code.h wants them.
 */
#include "image/code.h"

#include <capstone/capstone.h>

enum { SP = 13, LR = 14, PC = 15 };

struct reading {
    struct code *code;
    struct code_insn *insn;
    const cs_insn *from;
    const cs_arm *arm;
};

/* CODE_NONE for all but the general registers. */
static int number_of(unsigned reg)
{
    if (reg >= ARM_REG_R0 && reg <= ARM_REG_R12)
        return (int)(reg - ARM_REG_R0);
    return reg == ARM_REG_SP ? SP : reg == ARM_REG_LR ? LR : reg == ARM_REG_PC ? PC : CODE_NONE;
}

static int register_of(const cs_arm_op *operand)
{
    return operand->type == ARM_OP_REG ? number_of((unsigned)operand->reg) : CODE_NONE;
}

/* What the program counter reads as. */
static int64_t pc_of(const struct reading *r)
{
    return (int64_t)(r->insn->vaddr + (r->insn->thumb ? 4 : 8));
}

static void add(struct reading *r, struct code_op op)
{
    code_op(r->code, r->insn, op);
}

/* Where a result goes: one in the program counter is a jump. */
static int8_t target(struct reading *r, int reg)
{
    if (reg != PC)
        return (int8_t)reg;
    r->insn->flow = CODE_JUMP_VALUE;
    r->insn->value = CODE_TEMP;
    return CODE_TEMP;
}

static int8_t source(struct reading *r, int reg)
{
    if (reg != PC)
        return (int8_t)reg;
    add(r, (struct code_op){ .kind = CODE_PLACE, .dst = CODE_TEMP, .imm = pc_of(r) });
    return CODE_TEMP;
}

static void kill(struct reading *r, int reg)
{
    if (reg != CODE_NONE)
        add(r, (struct code_op){ .kind = CODE_KILL, .dst = target(r, reg) });
}

static void move(struct reading *r, int reg, int64_t bytes)
{
    add(r,
        (struct code_op){ .kind = CODE_ADD, .dst = (int8_t)reg, .a = (int8_t)reg, .imm = bytes });
}

/* ---- values ---- */

static bool is_sub(unsigned id)
{
    return id == ARM_INS_SUB || id == ARM_INS_SUBW;
}

/* rd, rn, operand or rd, operand. */
static void read_add(struct reading *r)
{
    const cs_arm_op *last = &r->arm->operands[r->arm->op_count - 1];
    const int dst = register_of(&r->arm->operands[0]);
    const int a = r->arm->op_count == 2 ? dst : register_of(&r->arm->operands[1]);
    const int b = register_of(last);
    const bool plain = last->shift.type == ARM_SFT_INVALID;
    struct code_op op = { .kind = CODE_KILL, .b = (int8_t)b };
    if (dst == CODE_NONE)
        return;
    if (last->type == ARM_OP_IMM && a == PC) {
        op.kind = CODE_PLACE;
        op.imm = (pc_of(r) & ~(int64_t)3) + (is_sub(r->from->id) ? -(int64_t)last->imm : last->imm);
    } else if (last->type == ARM_OP_IMM && a != CODE_NONE) {
        op.kind = CODE_ADD;
        op.imm = is_sub(r->from->id) ? -(int64_t)last->imm : last->imm;
    } else if (a != CODE_NONE && b != CODE_NONE && is_sub(r->from->id) && plain && b != PC) {
        op.kind = CODE_DIFF;
    } else if (a != CODE_NONE && b != CODE_NONE && !is_sub(r->from->id) && (a != PC || b != PC) &&
               (plain || (last->shift.type == ARM_SFT_LSL && last->shift.value < 8))) {
        op.kind = CODE_SUM;
        op.shift = plain ? 0 : (uint8_t)last->shift.value;
    }
    if (op.kind != CODE_KILL && op.kind != CODE_PLACE) {
        op.a = source(r, a);
        op.b = b == PC ? source(r, b) : op.b;
    }
    op.dst = target(r, dst);
    add(r, op);
}

static void read_mov(struct reading *r)
{
    const cs_arm_op *from = &r->arm->operands[1];
    const int dst = register_of(&r->arm->operands[0]), src = register_of(from);
    if (dst == PC && src == LR) {
        r->insn->flow = CODE_RETURN;
    } else if (dst != CODE_NONE && from->type == ARM_OP_IMM) {
        const uint32_t number = (uint32_t)from->imm;
        add(r, (struct code_op){ .kind = CODE_NUMBER,
                                 .dst = target(r, dst),
                                 .imm = r->from->id == ARM_INS_MVN ? ~number : number });
    } else if (dst != CODE_NONE && src != CODE_NONE && r->from->id == ARM_INS_MOV &&
               from->shift.type == ARM_SFT_INVALID) {
        const int8_t a = source(r, src);
        add(r, (struct code_op){ .kind = CODE_ADD, .dst = target(r, dst), .a = a });
    } else {
        kill(r, dst);
    }
}

static void read_movt(struct reading *r)
{
    const int dst = register_of(&r->arm->operands[0]);
    if (dst != CODE_NONE && dst != PC)
        add(r, (struct code_op){ .kind = CODE_HIGH,
                                 .dst = (int8_t)dst,
                                 .imm = (uint32_t)r->arm->operands[1].imm & 0xffff });
}

/* and, bic with an immediate; bfc from bit 0. */
static void read_mask(struct reading *r)
{
    const cs_arm_op *last = &r->arm->operands[r->arm->op_count - 1];
    const int dst = register_of(&r->arm->operands[0]);
    const bool bfc = r->from->id == ARM_INS_BFC;
    const int a = bfc || r->arm->op_count == 2 ? dst : register_of(&r->arm->operands[1]);
    struct code_op op = { .kind = CODE_MASK, .dst = (int8_t)dst, .a = (int8_t)a };
    if (dst == CODE_NONE || dst == PC || a == CODE_NONE || a == PC || last->type != ARM_OP_IMM ||
        (bfc && (r->arm->operands[1].imm != 0 || last->imm < 1 || last->imm > 31))) {
        kill(r, dst);
        return;
    }
    if (bfc)
        op.imm = -((int64_t)1 << last->imm);
    else
        op.imm = r->from->id == ARM_INS_BIC ? ~(int64_t)last->imm : last->imm;
    add(r, op);
}

static void read_low(struct reading *r, uint8_t width)
{
    const int dst = register_of(&r->arm->operands[0]), src = register_of(&r->arm->operands[1]);
    if (dst == CODE_NONE || dst == PC || src == CODE_NONE || src == PC ||
        r->arm->operands[1].shift.type != ARM_SFT_INVALID)
        kill(r, dst);
    else
        add(r, (struct code_op){
                   .kind = CODE_LOW, .dst = (int8_t)dst, .a = (int8_t)src, .width = width });
}

/* ---- memory ---- */

static const struct transfer {
    unsigned id;
    uint8_t width, registers;
    bool is_store, is_signed;
} transfers[] = {
    { ARM_INS_LDR, 4, 1, false, false },  { ARM_INS_LDRB, 1, 1, false, false },
    { ARM_INS_LDRH, 2, 1, false, false }, { ARM_INS_LDRSB, 1, 1, false, true },
    { ARM_INS_LDRSH, 2, 1, false, true }, { ARM_INS_LDRD, 4, 2, false, false },
    { ARM_INS_STR, 4, 1, true, false },   { ARM_INS_STRB, 1, 1, true, false },
    { ARM_INS_STRH, 2, 1, true, false },  { ARM_INS_STRD, 4, 2, true, false },
};

static const struct transfer *transfer_of(unsigned id)
{
    for (size_t i = 0; i < sizeof transfers / sizeof transfers[0]; i++) {
        if (transfers[i].id == id)
            return &transfers[i];
    }
    return NULL;
}

/* Capstone loses the sign of what an A32 instruction adds to its base afterwards. */
static int64_t post_index(const struct reading *r, const cs_arm_op *operand)
{
    const bool down =
        r->insn->thumb ? (r->from->bytes[3] & 2) == 0 : (r->from->bytes[2] & 0x80) == 0;
    const int64_t size = operand->imm < 0 ? -(int64_t)operand->imm : operand->imm;
    return down ? -size : size;
}

/* The place of a memory operand; false when it cannot be followed. */
static bool address(const struct reading *r, const cs_arm_op *operand, struct code_op *op)
{
    const arm_op_mem *mem = &operand->mem;
    op->a = (int8_t)number_of(mem->base);
    op->b = CODE_NONE;
    op->imm = mem->disp;
    if (op->a == CODE_NONE)
        return false;
    if (op->a == PC) {
        op->a = CODE_NONE;
        op->imm += pc_of(r) & ~(int64_t)3;
    }
    if (mem->index == ARM_REG_INVALID)
        return true;
    op->b = (int8_t)number_of(mem->index);
    op->shift = (uint8_t)operand->shift.value;
    return op->b != CODE_NONE && op->b != PC && mem->scale > 0 && !operand->subtracted &&
           (operand->shift.type == ARM_SFT_INVALID ||
            (operand->shift.type == ARM_SFT_LSL && operand->shift.value < 8));
}

static void literal(struct reading *r, const struct code_op *op)
{
    if (op->a == CODE_NONE && op->b == CODE_NONE)
        add(r, (struct code_op){ .kind = CODE_LITERAL, .imm = op->imm, .width = op->width });
}

static void read_transfer(struct reading *r, const struct transfer *transfer)
{
    const cs_arm *arm = r->arm;
    const unsigned mem = transfer->registers;
    struct code_op op = { .kind = transfer->is_store ? CODE_STORE : CODE_LOAD,
                          .width = transfer->width,
                          .is_signed = transfer->is_signed };
    if (arm->op_count <= mem || arm->operands[mem].type != ARM_OP_MEM)
        return;
    const bool known = address(r, &arm->operands[mem], &op);
    const int base = number_of(arm->operands[mem].mem.base);
    const bool post = arm->op_count > mem + 1;
    const bool post_known = post && arm->operands[mem + 1].type == ARM_OP_IMM;
    if (known)
        literal(r, &op);
    for (unsigned i = 0; i < transfer->registers; i++) {
        const int reg = register_of(&arm->operands[i]);
        struct code_op one = op;
        one.imm += 4 * (int64_t)i;
        one.dst = transfer->is_store ? (int8_t)(reg == PC || transfer->width != 4 ? CODE_NONE : reg)
                                     : target(r, reg);
        if (known)
            add(r, one);
        else if (!transfer->is_store)
            kill(r, reg);
        if (!transfer->is_store && reg == PC && base == SP && (post || arm->writeback))
            r->insn->flow = CODE_RETURN;
    }
    if (base == PC || !(post || arm->writeback))
        return;
    if (post_known)
        move(r, base, post_index(r, &arm->operands[mem + 1]));
    else if (!post && known && op.b == CODE_NONE)
        move(r, base, op.imm);
    else
        kill(r, base);
}

/* One load or store of a multiple one; the base is loaded last. */
static void transfer_multiple(struct reading *r, int base, unsigned first, int64_t begin,
                              bool is_store, bool want_base)
{
    for (unsigned i = first; i < r->arm->op_count; i++) {
        const int reg = register_of(&r->arm->operands[i]);
        struct code_op op = { .kind = is_store ? CODE_STORE : CODE_LOAD,
                              .a = (int8_t)base,
                              .b = CODE_NONE,
                              .width = 4,
                              .imm = begin + 4 * (int64_t)(i - first) };
        if (reg == CODE_NONE || (reg == base) != want_base)
            continue;
        op.dst = is_store ? (int8_t)(reg == PC ? CODE_NONE : reg) : target(r, reg);
        add(r, op);
        if (!is_store && reg == PC)
            r->insn->flow = CODE_RETURN;
    }
}

/* first: operand from which on the list goes; inner: it begins a word further up (IB, DA). */
static void read_multiple(struct reading *r, int base, unsigned first, bool is_store, bool down,
                          bool inner, bool writeback)
{
    const int64_t bytes = 4 * (int64_t)(r->arm->op_count - first);
    const int64_t begin = (down ? -bytes : 0) + (inner ? 4 : 0);
    if (base == CODE_NONE || base == PC)
        return;
    transfer_multiple(r, base, first, begin, is_store, false);
    if (writeback)
        move(r, base, down ? -bytes : bytes);
    else
        transfer_multiple(r, base, first, begin, is_store, true);
}

static bool is_single(const cs_arm_op *operand)
{
    return operand->type == ARM_OP_REG && operand->reg >= ARM_REG_S0 && operand->reg <= ARM_REG_S31;
}

static int64_t vector_bytes(const struct reading *r, unsigned first)
{
    int64_t bytes = 0;
    for (unsigned i = first; i < r->arm->op_count; i++)
        bytes += is_single(&r->arm->operands[i]) ? 4 : 8;
    return bytes;
}

static void read_vector_push(struct reading *r, int64_t bytes)
{
    move(r, SP, -bytes);
    add(r, (struct code_op){ .kind = CODE_STORE,
                             .dst = CODE_NONE,
                             .a = SP,
                             .b = CODE_NONE,
                             .width = (uint8_t)(bytes > 255 ? 255 : bytes) });
}

static bool read_multiples(struct reading *r)
{
    const int base = r->arm->op_count > 0 ? register_of(&r->arm->operands[0]) : CODE_NONE;
    const bool back = r->arm->writeback;
    switch (r->from->id) {
    case ARM_INS_PUSH:
        read_multiple(r, SP, 0, true, true, false, true);
        return true;
    case ARM_INS_POP:
        read_multiple(r, SP, 0, false, false, false, true);
        return true;
    case ARM_INS_STM:
    case ARM_INS_STMDB:
        read_multiple(r, base, 1, true, r->from->id == ARM_INS_STMDB, false, back);
        return true;
    case ARM_INS_STMIB:
    case ARM_INS_STMDA:
        read_multiple(r, base, 1, true, r->from->id == ARM_INS_STMDA, true, back);
        return true;
    case ARM_INS_LDM:
    case ARM_INS_LDMDB:
        read_multiple(r, base, 1, false, r->from->id == ARM_INS_LDMDB, false, back);
        return true;
    case ARM_INS_LDMIB:
    case ARM_INS_LDMDA:
        read_multiple(r, base, 1, false, r->from->id == ARM_INS_LDMDA, true, back);
        return true;
    case ARM_INS_VPUSH:
        read_vector_push(r, vector_bytes(r, 0));
        return true;
    case ARM_INS_VPOP:
        move(r, SP, vector_bytes(r, 0));
        return true;
    case ARM_INS_VSTMDB:
    case ARM_INS_VLDMDB:
    case ARM_INS_VSTMIA:
    case ARM_INS_VLDMIA:
        if (back && base != CODE_NONE)
            move(r, base,
                 r->from->id == ARM_INS_VSTMDB || r->from->id == ARM_INS_VLDMDB
                     ? -vector_bytes(r, 1)
                     : vector_bytes(r, 1));
        return true;
    default:
        return false;
    }
}

/* ---- where control goes ---- */

static void read_table(struct reading *r)
{
    struct code_op op = { .kind = CODE_LOAD,
                          .dst = CODE_TEMP,
                          .width = r->from->id == ARM_INS_TBB ? 1 : 2 };
    r->insn->flow = CODE_JUMP_VALUE;
    r->insn->value = CODE_TEMP;
    if (r->arm->op_count < 1 || r->arm->operands[0].type != ARM_OP_MEM ||
        !address(r, &r->arm->operands[0], &op)) {
        kill(r, PC);
        return;
    }
    if (op.a == CODE_NONE) /* not aligned here */
        op.imm = pc_of(r);
    add(r, op);
    add(r, (struct code_op){ .kind = CODE_SUM,
                             .dst = CODE_TEMP,
                             .a = CODE_NONE,
                             .b = CODE_TEMP,
                             .shift = 1,
                             .imm = pc_of(r) });
}

static void read_branch(struct reading *r, enum code_flow direct, enum code_flow through)
{
    const cs_arm_op *operand = &r->arm->operands[0];
    const int reg = register_of(operand);
    if (operand->type == ARM_OP_IMM) {
        r->insn->flow = (uint8_t)direct;
        r->insn->target = (uint32_t)operand->imm;
        r->insn->target_thumb = r->insn->thumb != (r->from->id == ARM_INS_BLX);
    } else if (reg == PC) { /* how linkers go from Thumb code to A32 */
        r->insn->flow = (uint8_t)direct;
        r->insn->target = (uint32_t)(pc_of(r) & ~(int64_t)3);
        r->insn->target_thumb = false;
    } else if (reg == LR && through == CODE_JUMP_VALUE) {
        r->insn->flow = CODE_RETURN;
    } else if (reg == CODE_NONE) {
        r->insn->flow = CODE_STOP;
    } else {
        r->insn->flow = (uint8_t)through;
        r->insn->value = source(r, reg);
    }
}

static bool read_flow(struct reading *r)
{
    switch (r->from->id) {
    case ARM_INS_B:
    case ARM_INS_BX:
    case ARM_INS_BXJ:
        read_branch(r, CODE_JUMP, CODE_JUMP_VALUE);
        return true;
    case ARM_INS_BL:
    case ARM_INS_BLX:
        read_branch(r, CODE_CALL, CODE_CALL_VALUE);
        return true;
    case ARM_INS_CBZ:
    case ARM_INS_CBNZ:
        r->insn->flow = CODE_JUMP;
        r->insn->condition = CODE_SOMETIMES;
        r->insn->target = (uint32_t)r->arm->operands[1].imm;
        return true;
    case ARM_INS_TBB:
    case ARM_INS_TBH:
        read_table(r);
        return true;
    case ARM_INS_UDF:
    case ARM_INS_TRAP:
    case ARM_INS_BKPT:
    case ARM_INS_HLT:
    case ARM_INS_RFEDA:
    case ARM_INS_RFEDB:
    case ARM_INS_RFEIA:
    case ARM_INS_RFEIB:
        r->insn->flow = CODE_STOP;
        return true;
    default:
        return false;
    }
}

/* ---- all others ---- */

static bool only_reads(unsigned id)
{
    return id == ARM_INS_TST || id == ARM_INS_TEQ || id == ARM_INS_CMN || id == ARM_INS_CMP ||
           id == ARM_INS_VSTR || id == ARM_INS_PLD || id == ARM_INS_PLDW || id == ARM_INS_MSR ||
           id == ARM_INS_VMSR || id == ARM_INS_STL || id == ARM_INS_STLB || id == ARM_INS_STLH;
}

static void read_memory_operand(struct reading *r, unsigned index)
{
    const cs_arm_op *operand = &r->arm->operands[index];
    struct code_op op = { .kind = r->from->id == ARM_INS_VSTR ? CODE_STORE : CODE_LOAD,
                          .dst = r->from->id == ARM_INS_VSTR ? CODE_NONE : CODE_TEMP,
                          .width = is_single(&r->arm->operands[0]) ? 4 : 8 };
    const int base = number_of(operand->mem.base);
    if (address(r, operand, &op)) {
        literal(r, &op);
        add(r, op);
    }
    if (base != PC && (r->arm->writeback || r->arm->op_count > index + 1))
        kill(r, base);
}

/* What it writes becomes any value. Capstone's lists are not complete: the first operand, too. */
static void read_other(struct reading *r)
{
    cs_regs reads, writes;
    uint8_t read_count, write_count;
    if (r->arm->op_count > 0 && !only_reads(r->from->id))
        kill(r, register_of(&r->arm->operands[0]));
    for (unsigned i = 0; i < r->arm->op_count; i++) {
        if (r->arm->operands[i].type == ARM_OP_MEM)
            read_memory_operand(r, i);
    }
    const size_t handle = r->insn->thumb ? r->code->thumb_handle : r->code->handle;
    if (cs_regs_access(handle, r->from, reads, &read_count, writes, &write_count) == CS_ERR_OK) {
        for (unsigned i = 0; i < write_count; i++) {
            if (number_of(writes[i]) != PC)
                kill(r, number_of(writes[i]));
        }
    }
    if (r->arm->update_flags || only_reads(r->from->id) || r->from->id == ARM_INS_VMRS)
        add(r, (struct code_op){ .kind = CODE_FLAGS });
}

static void read_compare(struct reading *r)
{
    const int reg = register_of(&r->arm->operands[0]);
    if (r->arm->op_count == 2 && reg != CODE_NONE && reg != PC &&
        r->arm->operands[1].type == ARM_OP_IMM)
        add(r, (struct code_op){
                   .kind = CODE_COMPARE, .a = (int8_t)reg, .imm = r->arm->operands[1].imm });
    else
        add(r, (struct code_op){ .kind = CODE_FLAGS });
}

static void read_values(struct reading *r)
{
    const struct transfer *transfer = transfer_of(r->from->id);
    if (transfer != NULL) {
        read_transfer(r, transfer);
        return;
    }
    switch (r->arm->op_count >= 2 ? r->from->id : (unsigned)ARM_INS_INVALID) {
    case ARM_INS_ADD:
    case ARM_INS_ADDW:
    case ARM_INS_SUB:
    case ARM_INS_SUBW:
        read_add(r);
        break;
    case ARM_INS_ADR:
        if (register_of(&r->arm->operands[0]) != CODE_NONE)
            add(r, (struct code_op){ .kind = CODE_PLACE,
                                     .dst = target(r, register_of(&r->arm->operands[0])),
                                     .imm = (pc_of(r) & ~(int64_t)3) + r->arm->operands[1].imm });
        break;
    case ARM_INS_MOV:
    case ARM_INS_MVN:
    case ARM_INS_MOVW:
        read_mov(r);
        break;
    case ARM_INS_MOVT:
        read_movt(r);
        break;
    case ARM_INS_AND:
    case ARM_INS_BIC:
    case ARM_INS_BFC:
        read_mask(r);
        break;
    case ARM_INS_UXTB:
        read_low(r, 1);
        break;
    case ARM_INS_UXTH:
        read_low(r, 2);
        break;
    case ARM_INS_CMP:
        read_compare(r);
        return;
    default:
        read_other(r);
        return;
    }
    if (r->arm->update_flags)
        add(r, (struct code_op){ .kind = CODE_FLAGS });
}

static enum code_condition condition_of(const struct reading *r)
{
    if (r->from->id == ARM_INS_IT)
        return CODE_ALWAYS;
    switch (r->arm->cc) {
    case ARM_CC_INVALID:
    case ARM_CC_AL:
        return CODE_ALWAYS;
    case ARM_CC_HI:
        return CODE_ABOVE;
    case ARM_CC_HS:
        return CODE_ABOVE_EQUAL;
    case ARM_CC_LO:
        return CODE_BELOW;
    case ARM_CC_LS:
        return CODE_BELOW_EQUAL;
    default:
        return CODE_SOMETIMES;
    }
}

void code_arm(struct code *code, struct code_insn *insn, const struct cs_insn *from)
{
    struct reading r = { .code = code, .insn = insn, .from = from, .arm = &from->detail->arm };
    insn->condition = (uint8_t)condition_of(&r);
    if (!read_flow(&r) && !read_multiples(&r))
        read_values(&r);
}
