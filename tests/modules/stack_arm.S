/* SPDX-License-Identifier: GPL-2.0-or-later */
/* stack_arm.S - as stack.S of the machine's modules, for Arm: A32 first, then Thumb (t_). */
        .syntax unified
        .arch   armv7-a
        .fpu    vfpv3-d16

        .macro  function name
        .globl  \name
        .type   \name, %function
\name:
        .endm

        .text
        .arm
function straight               /* 8 + 40 */
        push    {r4, lr}
        sub     sp, sp, #40
        add     sp, sp, #40
        pop     {r4, pc}

function nested                 /* 4 + 48 */
        str     lr, [sp, #-4]!
        bl      straight
        ldr     pc, [sp], #4

function vectors                /* 8 + 24 + 8 */
        push    {r4, lr}
        vpush   {d8-d10}
        strd    r2, r3, [sp, #-8]!
        ldrd    r2, r3, [sp], #8
        vpop    {d8-d10}
        pop     {r4, pc}

function multiple               /* 8 + 20 */
        stmdb   sp!, {fp, lr}
        add     fp, sp, #4
        sub     sp, sp, #20
        sub     sp, fp, #4
        ldmia   sp!, {fp, pc}

function apcs                   /* 16 + 32: frame pointer chain, everything loaded back at once */
        mov     ip, sp
        push    {fp, ip, lr, pc}
        sub     fp, ip, #4
        sub     sp, sp, #32
        ldmdb   fp, {fp, sp, pc}

function aligned                /* 8 + up to 12 of alignment + 16 */
        push    {fp, lr}
        mov     fp, sp
        bic     sp, sp, #15
        sub     sp, sp, #16
        mov     sp, fp
        pop     {fp, pc}

function conditional            /* 8 + 100: a return in the middle, and one way that is deeper */
        push    {r4, lr}
        cmp     r1, #0
        popeq   {r4, pc}
        sub     sp, sp, #100
        add     sp, sp, #100
        pop     {r4, pc}

function table                  /* 64, the deepest */
        cmp     r1, #2
        ldrls   pc, [pc, r1, lsl #2]
        b       9f
        .long   0f, 1f, 2f
0:      bx      lr
1:      push    {r4}
        pop     {r4}
        bx      lr
2:      sub     sp, sp, #64
        add     sp, sp, #64
9:      bx      lr

function steps                  /* 32, the deepest of branches in a row */
        cmp     r1, #1
        addls   pc, pc, r1, lsl #2
        b       9f
        b       0f
        b       1f
0:      bx      lr
1:      sub     sp, sp, #32
        add     sp, sp, #32
9:      bx      lr

function service                /* 8 */
        push    {r4, lr}
        ldr     r3, [r0, #8]
        blx     r3
        pop     {r4, pc}

function interwork              /* 8 + (8 + 24), Thumb code from A32 code */
        push    {r4, lr}
        blx     t_straight
        pop     {r4, pc}

function post_index             /* 4: stored first, then down */
        str     r4, [sp], #-4
        add     sp, sp, #4
        bx      lr

function tail                   /* 48 */
        b       straight

function recursive
        push    {r4, lr}
        bl      recursive
        pop     {r4, pc}

function loop_push
1:      push    {r4}
        subs    r1, r1, #1
        bne     1b
        bx      lr

function alloca
        push    {fp, lr}
        mov     fp, sp
        sub     sp, sp, r1
        mov     sp, fp
        pop     {fp, pc}

        .thumb
        .thumb_func
function t_straight             /* 8 + 24 */
        push    {r4, lr}
        sub     sp, #24
        add     sp, #24
        pop     {r4, pc}

        .thumb_func
function t_nested               /* 8 + 8 + 32 */
        push    {r3, lr}
        sub.w   sp, sp, #8
        bl      t_straight
        add.w   sp, sp, #8
        pop     {r3, pc}

        .thumb_func
function t_if_then              /* 8 + 40 */
        push    {r4, lr}
        cmp     r1, #0
        itt     eq
        moveq   r0, #1
        popeq   {r4, pc}
        sub     sp, #40
        add     sp, #40
        pop     {r4, pc}

        .thumb_func
function t_table                /* 8 + 56 */
        push    {r4, lr}
        cmp     r1, #2
        bhi     9f
        tbb     [pc, r1]
5:      .byte   (9f - 5b) / 2, (1f - 5b) / 2, (2f - 5b) / 2, 0
1:      nop
        b       9f
2:      sub     sp, #56
        add     sp, #56
9:      pop     {r4, pc}

        .thumb_func
function t_frame                /* 8 + 16 */
        push    {r7, lr}
        sub     sp, #16
        add     r7, sp, #0
        adds    r7, #16
        mov     sp, r7
        pop     {r7, pc}

        .balign 4
        .thumb_func
function t_to_arm               /* as a linker's veneer goes to A32 code: 48 of straight */
        bx      pc
        nop
        .arm
        ldr     ip, 1f
0:      add     pc, ip, pc
1:      .word   straight - (0b + 8)

        .section .note.GNU-stack, "", %progbits
