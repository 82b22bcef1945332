/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code.h - machine code as far as the stack depends on it, the same for every processor.
 *
 * An instruction is a list of small operations on registers and memory, and then where control
 * goes. What does not matter for the stack pointer, for values that it is restored from and for
 * addresses that are jumped to is one operation: "any value". Only code*.c includes Capstone.
 *
 * Everything here works on hostile bytes; see image_child.c for where it runs.
 */
#ifndef HARNESS_IMAGE_CODE_H
#define HARNESS_IMAGE_CODE_H

#include "image/code_map.h"
#include "image/image_private.h"

/* The numbers of the processor's own encoding: x86 rsp is 4, Arm sp is 13. TEMP holds the target of
 * a jump or call through memory. */
enum { CODE_TEMP = 16, CODE_REGISTERS = 17, CODE_NONE = -1 };

enum code_op_kind {
    CODE_KILL,    /* dst: any value */
    CODE_NUMBER,  /* dst = imm */
    CODE_PLACE,   /* dst = imm, an address of the module */
    CODE_HIGH,    /* dst = its low 16 bits, imm above them */
    CODE_ADD,     /* dst = a + imm */
    CODE_SUM,     /* dst = a + (b << shift) + imm; a may be CODE_NONE: imm is an address then */
    CODE_DIFF,    /* dst = a - b */
    CODE_MASK,    /* dst = a & imm */
    CODE_LOW,     /* dst = the low width bytes of a, zeros above */
    CODE_LOAD,    /* dst = width bytes at a + (b << shift) + imm */
    CODE_STORE,   /* width bytes there = dst; CODE_NONE: any value */
    CODE_LITERAL, /* width bytes at the address imm, among the code, are read */
    CODE_COMPARE, /* flags = a against imm */
    CODE_FLAGS    /* flags: any value */
};

/* In a memory operand without a (CODE_NONE), imm is an address of the module. */
struct code_op {
    uint8_t kind, shift, width;
    bool is_signed; /* CODE_LOAD: the sign is spread */
    int8_t dst, a, b;
    int64_t imm;
};

enum code_flow {
    CODE_NEXT,
    CODE_JUMP,       /* to target */
    CODE_JUMP_VALUE, /* to where a register points */
    CODE_CALL,
    CODE_CALL_VALUE,
    CODE_RETURN,
    CODE_STOP /* raises an exception, or waits for ever */
};

/* When the instruction is executed, of what a compare tells (unsigned). */
enum code_condition {
    CODE_ALWAYS,
    CODE_SOMETIMES,
    CODE_ABOVE,
    CODE_ABOVE_EQUAL,
    CODE_BELOW,
    CODE_BELOW_EQUAL
};

struct code_insn {
    uint64_t vaddr;
    uint64_t target;
    uint32_t first_op;
    uint16_t op_count;
    uint16_t pops; /* CODE_RETURN: bytes that it takes off beyond the return address */
    uint8_t size, flow, condition;
    int8_t value;    /* register of CODE_JUMP_VALUE, CODE_CALL_VALUE */
    uint8_t special; /* enum image_special_kind */
    bool thumb, target_thumb;
};

/* What differs by processor and by calling convention. */
struct code_machine {
    int stack_register;
    unsigned word;       /* bytes of an address */
    unsigned call_bytes; /* a call pushes so much: word on x86, 0 on Arm */
    uint32_t destroyed;  /* registers that a call may change, one bit each */
    int first_arguments[4];
    int link_register; /* holds the return address at the beginning, CODE_NONE: it is pushed */
};

struct code {
    const struct image *image;
    struct code_machine machine;
    size_t handle, thumb_handle; /* Capstone's */
    void *scratch;               /* Capstone's struct cs_insn */
    struct code_map known;       /* address and Thumb bit -> index of the instruction */
    struct code_insn *insns;
    uint32_t insn_count, insn_room;
    struct code_op *ops;
    uint32_t op_count, op_room;
    bool exhausted; /* memory, or the limit of instructions */
};

/* False when there is no disassembler for the image's processor, or no memory. */
bool code_open(struct code *code, const struct image *image);
void code_close(struct code *code);

/* The instruction there; NULL when there is none: no code, no valid encoding, exhausted. Valid
 * until the next call. */
const struct code_insn *code_at(struct code *code, uint64_t vaddr, bool thumb);

/* An address as it stands in the code or data of a module that is loaded where it was linked for.
 */
bool code_is_absolute(const struct code *code, uint64_t number, uint64_t *vaddr);
/* Lies in the file's part of an executable segment. */
bool code_is_code(const struct code *code, uint64_t vaddr);
/* The instruction there in the processor's own words, "?" when there is none. */
void code_text(struct code *code, uint64_t vaddr, bool thumb, char *text, size_t size);

/* ---- for code_x86.c and code_arm.c ---- */

/* Adds to the instruction that is being read. */
void code_op(struct code *code, struct code_insn *insn, struct code_op op);
struct cs_insn;
void code_x86(struct code *code, struct code_insn *insn, const struct cs_insn *from);
void code_arm(struct code *code, struct code_insn *insn, const struct cs_insn *from);
/* code_special.c */
enum image_special_kind code_special(const struct code *code, const struct cs_insn *from,
                                     bool thumb);

#endif
