/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "image/code_step.h"

#include <capstone/capstone.h>
#include <string.h>

struct listed {
    unsigned id;
    enum code_step_kind kind;
};

/* Raise a general protection fault in user code, but not on an emulator without an operating system
 * around it. */
static const struct listed x86_kinds[] = {
    { X86_INS_SYSCALL, CODE_STEP_SYSCALL },    { X86_INS_SYSENTER, CODE_STEP_SYSCALL },
    { X86_INS_INT3, CODE_STEP_BREAKPOINT },    { X86_INS_HLT, CODE_STEP_PRIVILEGED },
    { X86_INS_IN, CODE_STEP_PRIVILEGED },      { X86_INS_OUT, CODE_STEP_PRIVILEGED },
    { X86_INS_INSB, CODE_STEP_PRIVILEGED },    { X86_INS_INSW, CODE_STEP_PRIVILEGED },
    { X86_INS_INSD, CODE_STEP_PRIVILEGED },    { X86_INS_OUTSB, CODE_STEP_PRIVILEGED },
    { X86_INS_OUTSW, CODE_STEP_PRIVILEGED },   { X86_INS_OUTSD, CODE_STEP_PRIVILEGED },
    { X86_INS_CLI, CODE_STEP_PRIVILEGED },     { X86_INS_STI, CODE_STEP_PRIVILEGED },
    { X86_INS_CLTS, CODE_STEP_PRIVILEGED },    { X86_INS_RDMSR, CODE_STEP_PRIVILEGED },
    { X86_INS_WRMSR, CODE_STEP_PRIVILEGED },   { X86_INS_LGDT, CODE_STEP_PRIVILEGED },
    { X86_INS_LIDT, CODE_STEP_PRIVILEGED },    { X86_INS_LLDT, CODE_STEP_PRIVILEGED },
    { X86_INS_LTR, CODE_STEP_PRIVILEGED },     { X86_INS_LMSW, CODE_STEP_PRIVILEGED },
    { X86_INS_INVD, CODE_STEP_PRIVILEGED },    { X86_INS_WBINVD, CODE_STEP_PRIVILEGED },
    { X86_INS_INVLPG, CODE_STEP_PRIVILEGED },  { X86_INS_INVPCID, CODE_STEP_PRIVILEGED },
    { X86_INS_XSETBV, CODE_STEP_PRIVILEGED },  { X86_INS_SWAPGS, CODE_STEP_PRIVILEGED },
    { X86_INS_SYSEXIT, CODE_STEP_PRIVILEGED }, { X86_INS_SYSRET, CODE_STEP_PRIVILEGED },
    { X86_INS_RDPMC, CODE_STEP_PRIVILEGED },   { X86_INS_RDRAND, CODE_STEP_FOREIGN },
    { X86_INS_RDSEED, CODE_STEP_FOREIGN },     { X86_INS_XBEGIN, CODE_STEP_FOREIGN },
    { X86_INS_XSAVE, CODE_STEP_FOREIGN },      { X86_INS_XRSTOR, CODE_STEP_FOREIGN },
    { X86_INS_WRFSBASE, CODE_STEP_PLAIN },     { X86_INS_RDFSBASE, CODE_STEP_PLAIN },
};

/* Use the stack segment without naming the register. */
static const unsigned x86_stack_users[] = {
    X86_INS_PUSH,  X86_INS_PUSHF, X86_INS_PUSHFD, X86_INS_PUSHFQ, X86_INS_POP,   X86_INS_POPF,
    X86_INS_POPFD, X86_INS_POPFQ, X86_INS_CALL,   X86_INS_RET,    X86_INS_LEAVE, X86_INS_ENTER,
};

static const struct listed arm_kinds[] = {
    { ARM_INS_SVC, CODE_STEP_SYSCALL },
    { ARM_INS_BKPT, CODE_STEP_BREAKPOINT },
    { ARM_INS_IT, CODE_STEP_CONDITION },
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static bool open_one(size_t *handle, cs_arch arch, cs_mode mode)
{
    csh opened;

    if (cs_open(arch, mode, &opened) != CS_ERR_OK)
        return false;
    *handle = opened;
    return cs_option(opened, CS_OPT_DETAIL, CS_OPT_ON) == CS_ERR_OK;
}

void code_stepper_close(struct code_stepper *stepper)
{
    csh handles[] = { stepper->handle, stepper->thumb_handle };

    if (stepper->scratch != NULL)
        cs_free(stepper->scratch, 1);
    for (size_t i = 0; i < COUNT(handles); i++)
        if (handles[i] != 0)
            cs_close(&handles[i]);
    *stepper = (struct code_stepper){ .target = stepper->target };
}

static bool decode(struct code_stepper *stepper, const uint8_t *bytes, size_t size,
                   uint64_t address, bool thumb)
{
    return cs_disasm_iter(thumb ? stepper->thumb_handle : stepper->handle, &bytes, &size, &address,
                          stepper->scratch);
}

/* Capstone sorts a table at its first instruction, and asks how much memory there is for that:
 * later there may be nobody to ask. */
static void warm_up(struct code_stepper *stepper)
{
    static const uint8_t any[] = { 0x50, 0x90, 0x90, 0x90 };

    decode(stepper, any, sizeof any, 0, false);
    if (stepper->thumb_handle != 0)
        decode(stepper, any, sizeof any, 0, true);
}

bool code_stepper_open(struct code_stepper *stepper, enum image_target target)
{
    bool opened = false;

    *stepper = (struct code_stepper){ .target = target };
    if (target == IMAGE_TARGET_ARM)
        opened = open_one(&stepper->handle, CS_ARCH_ARM, CS_MODE_ARM) &&
                 open_one(&stepper->thumb_handle, CS_ARCH_ARM, CS_MODE_THUMB);
    else if (target == IMAGE_TARGET_X86_64)
        opened = open_one(&stepper->handle, CS_ARCH_X86, CS_MODE_64);
    else if (target == IMAGE_TARGET_I386)
        opened = open_one(&stepper->handle, CS_ARCH_X86, CS_MODE_32);
    if (opened)
        stepper->scratch = cs_malloc(stepper->handle);
    if (stepper->scratch != NULL) {
        warm_up(stepper);
        return true;
    }
    code_stepper_close(stepper);
    return false;
}

static bool is_among(const unsigned *list, size_t count, unsigned id)
{
    for (size_t i = 0; i < count; i++)
        if (list[i] == id)
            return true;
    return false;
}

static enum code_step_kind listed(const struct listed *list, size_t count, unsigned id)
{
    for (size_t i = 0; i < count; i++)
        if (list[i].id == id)
            return list[i].kind;
    return CODE_STEP_PLAIN;
}

/*
 * An encoding with a VEX or EVEX prefix. Ours knows the prefix for the general registers' own
 * extensions (BMI) only; with vector instructions it would compute something else, silently.
 */
static bool is_vector_extension(const struct code_stepper *stepper, const cs_insn *insn)
{
    static const uint8_t prefixes[] = {
        0x66, 0x67, 0xf2, 0xf3, 0x2e, 0x36, 0x3e, 0x26, 0x64, 0x65
    };
    const bool wide = stepper->target == IMAGE_TARGET_X86_64;
    size_t at = 0;

    while (at + 2 < insn->size && memchr(prefixes, insn->bytes[at], sizeof prefixes) != NULL)
        at++;
    if (insn->bytes[at] != 0xc4 && insn->bytes[at] != 0xc5 && insn->bytes[at] != 0x62)
        return false;
    if (!wide && insn->bytes[at + 1] < 0xc0) /* les, lds, bound */
        return false;
    for (unsigned i = 0; i < insn->detail->groups_count; i++)
        if (insn->detail->groups[i] == X86_GRP_BMI || insn->detail->groups[i] == X86_GRP_BMI2)
            return false;
    return true;
}

static bool is_repeated(const cs_insn *insn)
{
    const cs_x86 *x86 = &insn->detail->x86;
    const uint8_t opcode = x86->opcode[0];

    return (x86->prefix[0] == X86_PREFIX_REP || x86->prefix[0] == X86_PREFIX_REPNE) &&
           ((opcode >= 0xa4 && opcode <= 0xa7) || (opcode >= 0xaa && opcode <= 0xaf));
}

static enum code_step_kind x86_kind(const struct code_stepper *stepper, const cs_insn *insn)
{
    const cs_x86 *x86 = &insn->detail->x86;

    if (is_vector_extension(stepper, insn))
        return CODE_STEP_FOREIGN;
    if (is_repeated(insn))
        return CODE_STEP_REPEAT;
    if (insn->id == X86_INS_INT && x86->op_count == 1)
        return x86->operands[0].imm == 0x80   ? CODE_STEP_SYSCALL_OLD
               : x86->operands[0].imm == 0x03 ? CODE_STEP_BREAKPOINT
                                              : CODE_STEP_PRIVILEGED;
    for (unsigned i = 0; i < x86->op_count; i++) {
        const cs_x86_op *operand = &x86->operands[i];

        if (operand->type == X86_OP_REG &&
            ((operand->reg >= X86_REG_CR0 && operand->reg <= X86_REG_CR15) ||
             (operand->reg >= X86_REG_DR0 && operand->reg <= X86_REG_DR15)))
            return CODE_STEP_PRIVILEGED;
    }
    return listed(x86_kinds, COUNT(x86_kinds), insn->id);
}

static bool x86_by_stack(const cs_insn *insn)
{
    const cs_x86 *x86 = &insn->detail->x86;

    for (unsigned i = 0; i < x86->op_count; i++) {
        const unsigned base = x86->operands[i].mem.base;

        if (x86->operands[i].type == X86_OP_MEM)
            return base == X86_REG_RSP || base == X86_REG_RBP || base == X86_REG_ESP ||
                   base == X86_REG_EBP;
    }
    return is_among(x86_stack_users, COUNT(x86_stack_users), insn->id);
}

/* Loads and stores for which the address has to be that of a word (Arm Architecture Reference
 * Manual, unaligned access): by a list of registers, and others. */
static const unsigned arm_lists[] = {
    ARM_INS_LDM,   ARM_INS_LDMDA, ARM_INS_LDMDB,  ARM_INS_LDMIB,  ARM_INS_STM,    ARM_INS_STMDA,
    ARM_INS_STMDB, ARM_INS_STMIB, ARM_INS_VLDMIA, ARM_INS_VLDMDB, ARM_INS_VSTMIA, ARM_INS_VSTMDB,
};
static const unsigned arm_words[] = { ARM_INS_LDRD, ARM_INS_STRD,  ARM_INS_VLDR,
                                      ARM_INS_VSTR, ARM_INS_LDREX, ARM_INS_STREX };

/* The register that such an address begins with, when it can be an odd one: not sp, not pc. */
static bool arm_base(const cs_insn *insn, unsigned *number)
{
    const bool by_list = is_among(arm_lists, COUNT(arm_lists), insn->id);
    const cs_arm *arm = &insn->detail->arm;

    if (!by_list && !is_among(arm_words, COUNT(arm_words), insn->id))
        return false;
    for (unsigned i = 0; i < arm->op_count; i++) {
        const cs_arm_op *operand = &arm->operands[i];
        const unsigned reg = by_list ? (unsigned)operand->reg : (unsigned)operand->mem.base;

        if (by_list ? i > 0 : operand->type != ARM_OP_MEM)
            continue;
        *number = reg - ARM_REG_R0;
        return reg >= ARM_REG_R0 && reg <= ARM_REG_R12;
    }
    return false;
}

/* The lowest set bit of the mask ends the block. */
static unsigned it_covers(const cs_insn *insn)
{
    const unsigned mask = insn->bytes[0] & 15u;

    return mask & 1u ? 4 : mask & 2u ? 3 : mask & 4u ? 2 : 1;
}

void code_step_read(struct code_stepper *stepper, const uint8_t *bytes, size_t size,
                    uint64_t address, bool thumb, struct code_step *step)
{
    const bool arm = stepper->target == IMAGE_TARGET_ARM;
    const cs_insn *insn = stepper->scratch;

    *step = (struct code_step){ .kind = CODE_STEP_PLAIN, .size = !arm ? 1 : thumb ? 2 : 4 };
    if (!decode(stepper, bytes, size, address, thumb))
        return;
    step->size = insn->size;
    if (arm) {
        step->kind = listed(arm_kinds, COUNT(arm_kinds), insn->id);
        step->known = insn->id != ARM_INS_UDF && insn->id != ARM_INS_TRAP;
        step->covers = step->kind == CODE_STEP_CONDITION ? it_covers(insn) : 0;
        if (step->kind == CODE_STEP_PLAIN && arm_base(insn, &step->covers))
            step->kind = CODE_STEP_ALIGNED;
        return;
    }
    step->kind = x86_kind(stepper, insn);
    step->known = insn->id != X86_INS_UD0 && insn->id != X86_INS_UD2 && insn->id != X86_INS_UD2B;
    step->covers = step->kind == CODE_STEP_REPEAT ? insn->detail->x86.addr_size : 0;
    step->by_stack = x86_by_stack(insn);
}

static bool is_call(const struct code_stepper *stepper, const cs_insn *insn)
{
    return stepper->target == IMAGE_TARGET_ARM ? insn->id == ARM_INS_BL || insn->id == ARM_INS_BLX
                                               : insn->id == X86_INS_CALL;
}

unsigned code_call_before(struct code_stepper *stepper, const uint8_t *end, size_t size,
                          uint64_t address, bool thumb)
{
    const bool arm = stepper->target == IMAGE_TARGET_ARM;
    const unsigned step = !arm ? 1 : thumb ? 2 : 4, longest = arm ? 4 : 7;

    for (unsigned length = !arm ? 2 : step; length <= longest && length <= size; length += step) {
        const cs_insn *insn = stepper->scratch;

        if (decode(stepper, end - length, length, address - length, thumb) &&
            insn->size == length && is_call(stepper, insn))
            return length;
    }
    return 0;
}
