/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * code_step.h - one instruction in memory, as whoever is about to execute it on an emulated CPU has
 * to know it: what an emulator does differently from a processor that runs user code.
 */
#ifndef HARNESS_IMAGE_CODE_STEP_H
#define HARNESS_IMAGE_CODE_STEP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image/image.h"

enum code_step_kind {
    CODE_STEP_PLAIN = 1,   /* also what is no instruction at all: the emulator will say so */
    CODE_STEP_CONDITION,   /* Thumb IT: the `covers` instructions behind it belong to it */
    CODE_STEP_ALIGNED,     /* Arm: register number `covers` has to be a multiple of 4 */
    CODE_STEP_REPEAT,      /* a string instruction with a repeat prefix; `covers`: bytes of its
                              counter */
    CODE_STEP_SYSCALL,     /* asks the operating system */
    CODE_STEP_SYSCALL_OLD, /* int 0x80 */
    CODE_STEP_BREAKPOINT,
    CODE_STEP_PRIVILEGED, /* faults in user code */
    CODE_STEP_FOREIGN,    /* valid on real processors of the target, wrong or unknown on ours */
    CODE_STEP_KINDS
};

struct code_step {
    enum code_step_kind kind;
    unsigned size; /* bytes; of no instruction: 1, Arm 4, Thumb 2 */
    unsigned
        covers;    /* CODE_STEP_CONDITION: 1 to 4; CODE_STEP_REPEAT: 2, 4 or 8; ALIGNED: 0 to 12 */
    bool known;    /* a real processor of the target would execute it */
    bool by_stack; /* x86: its memory operand is found through the stack pointer or frame pointer */
};

struct code_stepper {
    enum image_target target;
    size_t handle, thumb_handle; /* Capstone's */
    void *scratch;               /* its struct cs_insn */
};

/* False when there is no disassembler for the target, or no memory. */
bool code_stepper_open(struct code_stepper *stepper, enum image_target target);
void code_stepper_close(struct code_stepper *stepper);

/* The instruction that begins with these bytes. */
void code_step_read(struct code_stepper *stepper, const uint8_t *bytes, size_t size,
                    uint64_t address, bool thumb, struct code_step *step);

/* The instruction before this one, of `size` bytes there, could be a call: its length, 0 when not.
 * For Arm the return address has lost its Thumb bit. */
unsigned code_call_before(struct code_stepper *stepper, const uint8_t *end, size_t size,
                          uint64_t address, bool thumb);

#endif
