/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * void fiber_switch(void **leave, void *enter)
 *
 * Saves what the System V calling convention asks a function to keep (registers, the control words
 * of x87 and SSE) on the running stack, its top in *leave, and goes on where `enter` was left.
 */
        .text
        .globl  fiber_switch
        .hidden fiber_switch
        .type   fiber_switch, @function
fiber_switch:
        pushq   %rbp
        pushq   %rbx
        pushq   %r12
        pushq   %r13
        pushq   %r14
        pushq   %r15
        subq    $8, %rsp
        stmxcsr (%rsp)
        fnstcw  4(%rsp)
        movq    %rsp, (%rdi)
        movq    %rsi, %rsp
        ldmxcsr (%rsp)
        fldcw   4(%rsp)
        addq    $8, %rsp
        popq    %r15
        popq    %r14
        popq    %r13
        popq    %r12
        popq    %rbx
        popq    %rbp
        ret
        .size   fiber_switch, . - fiber_switch

/* The first switch to a fiber returns to here: r12 is the function, r13 its argument. */
        .globl  fiber_begin
        .hidden fiber_begin
        .type   fiber_begin, @function
fiber_begin:
        movq    %r13, %rdi
        call    *%r12
        ud2
        .size   fiber_begin, . - fiber_begin

        .section .note.GNU-stack, "", @progbits
