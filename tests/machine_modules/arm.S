/* SPDX-License-Identifier: GPL-2.0-or-later */
/* arm.S - functions for 32-bit Arm, good and bad ones: a shared object, or, with FLAT, the flat
 * image of a controller, whose first function returns the table of the others. */
        .syntax unified
        .arch   armv7-a
        .fpu    vfpv3
        .arm
        .macro  function name
        .globl  \name
        .type   \name, %function
\name:
        .endm
        .macro  thumb_function name
        .thumb
        .thumb_func
        .globl  \name
        .type   \name, %function
\name:
        .endm
        .macro  label name
        .globl  \name
        .type   \name, %object
\name:
        .endm

        .text
        .p2align 2
#ifdef FLAT
function GetProcAddress
        adr     r0, table
        bx      lr
table:  .word   returns_value, loop_1000, count_up, unfilled, loop_thumb, call_service, null_read
#endif

function returns_value
        mvn     r0, r0
        mvn     r1, #0
        bx      lr

/* 3 + 2 * 1000 instructions */
function loop_1000
        movw    r1, #1000
1:      subs    r1, r1, #1
        bne     1b
        mov     r0, #7
        bx      lr

        .irp    number, 4, 5, 6, 7, 8, 9, 10, 11
function break_r\number
        mvn     r\number, r\number
        bx      lr
        .endr

        .irp    number, 8, 15
function break_d\number
        vmov    r0, r1, d\number
        mvn     r1, r1
        vmov    d\number, r0, r1
        bx      lr
        .endr

function break_stack
        sub     sp, sp, #16
        bx      lr

/* Rounds towards zero; then sticky flags alone, which are nobody's. */
function break_rounding
        mov     r0, #0xc00000
        vmsr    fpscr, r0
        bx      lr
function sticky_flags
        mov     r0, #0x1f
        vmsr    fpscr, r0
        bx      lr

/* { double a, b, quotient, root } */
function divides
        vldr    d0, [r0]
        vldr    d1, [r0, #8]
        vdiv.f64 d2, d0, d1
        vstr    d2, [r0, #16]
        vsqrt.f64 d3, d2
        vstr    d3, [r0, #24]
        bx      lr

function null_read
        mov     r0, #0
label null_read_at
        ldr     r1, [r0, #16]
        bx      lr

/* Words may lie anywhere, pairs of them not. */
function unaligned_word
        ldr     r0, [r0, #1]
        bx      lr
function unaligned_pair
        add     r0, r0, #2
label unaligned_pair_at
        ldrd    r2, r3, [r0]
        bx      lr

/* What a condition leaves out is not done: 16 conditions of which two hold, bases that are odd. */
function skipped_instructions
        add     r1, r0, #2
        cmp     r0, r0                  /* Z, C; not N, not V */
        ldrdne  r2, r3, [r1]
        vldrne  d16, [r1]
        ldmcc   r1, {r2, r3}
        strdmi  r2, r3, [r1]
        ldmvs   r1, {r2, r3}
        ldrdhi  r2, r3, [r1]
        ldrdlt  r2, r3, [r1]
        vldrgt  d16, [r1]
        svcne   #0
        cmn     r0, #0                  /* not Z: r0 is an address; not V, not C */
        ldrdeq  r2, r3, [r1]
        ldrdcs  r2, r3, [r1]
        ldrdvs  r2, r3, [r1]
        svceq   #0
        mvn     r2, #0
        cmp     r2, #0                  /* N, C */
        ldrdpl  r2, r3, [r1]
        ldrdge  r2, r3, [r1]
        ldrdgt  r2, r3, [r1]
        cmp     r0, r0
        ldrdls  r2, r3, [r0]
        ldrdle  r2, r3, [r0]
        mov     r0, #7
        bx      lr

function kept_condition
        add     r1, r0, #2
        cmp     r0, r0
label kept_condition_at
        ldrdeq  r2, r3, [r1]
        bx      lr

function undefined_instruction
label undefined_instruction_at
        udf     #0
/* The Cortex-A9 does not divide. */
function divide_instruction
label divide_instruction_at
        .inst   0xe710f110              /* sdiv r0, r0, r1 */
        bx      lr

function breakpoint
label breakpoint_at
        bkpt    #0
        bx      lr

function make_system_call
        mov     r7, #20
label make_system_call_at
        svc     #0
        bx      lr

function privileged
label privileged_at
        mcr     p15, 0, r0, c1, c0, 0
        bx      lr

function recurse
label recurse_at
        push    {r4, lr}
        bl      recurse
        pop     {r4, pc}

function call_null
        push    {r4, lr}
        mov     r0, #0
        blx     r0
label call_null_back
        pop     {r4, pc}

function wild_jump
        movw    r0, #0
        movt    r0, #0x9000
        mov     lr, #0
        bx      r0

function loop_for_ever
label loop_for_ever_at
        b       loop_for_ever

/* { service }: (int 2, a gap, int64 -4, double 1.5, int 5) */
function call_service
        push    {r4, lr}
        sub     sp, sp, #16
        ldr     r4, [r0]
        mov     r0, #5
        str     r0, [sp, #8]
        mov     r0, #0
        str     r0, [sp]
        movw    r0, #0
        movt    r0, #0x3ff8
        str     r0, [sp, #4]
        mov     r0, #2
        mvn     r2, #3
        mvn     r3, #0
        blx     r4
label call_service_back
        add     sp, sp, #16
        pop     {r4, pc}

/* { words }: by condition; every instruction counts */
function conditions
        ldr     r1, [r0]
        cmp     r1, #0
        moveq   r0, #1
        movne   r0, #2
        addne   r0, r0, #10
        bx      lr

function count_up
        ldr     r1, 1f
#ifdef FLAT
        ldr     r0, [r1]
        add     r2, r0, #1
        str     r2, [r1]
#else
2:      add     r1, pc, r1
        ldr     r0, [r1]
        add     r2, r0, #1
        str     r2, [r1]
#endif
        bx      lr
#ifdef FLAT
1:      .word   counter
#else
1:      .word   counter - 2b - 8
#endif

/* What lies behind the image. */
function unfilled
        ldr     r1, 1f
        ldr     r0, [r1]
        bx      lr
#ifdef FLAT
1:      .word   0x07c00000
#else
1:      .word   0
#endif

/* 5 + 5 * 100 instructions: an IT block of three. */
        .p2align 2
thumb_function loop_thumb
        movs    r1, #100
        movs    r0, #0
1:      adds    r0, #1
        subs    r1, #1
        itt     ne
        addne   r0, #1
        bne     1b
        nop
        bx      lr

thumb_function thumb_null_read
        movs    r0, #0
label thumb_null_read_at
        ldr     r1, [r0, #4]
        bx      lr

thumb_function thumb_call_service
        push    {r4, lr}
        ldr     r1, [r0]
        movs    r0, #9
        blx     r1
label thumb_call_service_back
        pop     {r4, pc}

thumb_function thumb_call_null
        push    {r4, lr}
        movs    r0, #0
        blx     r0
label thumb_call_null_back
        pop     {r4, pc}

        .data
        .p2align 2
label counter
        .word   5
#ifndef FLAT
label pointer
        .word   counter
#endif
        .section .note.GNU-stack, "", %progbits
