/* SPDX-License-Identifier: GPL-2.0-or-later */
/* abi.S - functions that return, but not as the calling convention demands. */
        .macro  function name
        .globl  \name
        .type   \name, @function
\name:
        .endm

        .text
function keeps_all
        push    %rbx
        push    %rbp
        mov     $1, %ebx
        mov     $2, %ebp
        lea     (%rbx, %rbp), %eax
        pop     %rbp
        pop     %rbx
        ret

        .irp    name, rbx, rbp, r12, r13, r14, r15
function break_\name
        not     %\name
        mov     $7, %eax
        ret
        .endr

/* Two registers exchanged: each holds a value that another one should. */
function swap_registers
        xchg    %rbx, %r15
        mov     $7, %eax
        ret

function break_stack
        pop     %rcx
        sub     $16, %rsp
        mov     $7, %eax
        jmp     *%rcx

function lose_stack
        pop     %rcx
        xor     %esp, %esp
        mov     $7, %eax
        jmp     *%rcx

function break_direction
        mov     $7, %eax
        std
        ret

function break_alignment_check
        pushfq
        orq     $0x40000, (%rsp)
        popfq
        mov     $7, %eax
        ret

function break_mxcsr
        stmxcsr -4(%rsp)
        orl     $0x6000, -4(%rsp)
        ldmxcsr -4(%rsp)
        mov     $7, %eax
        ret

/* Sticky exception flags may change. */
function inexact_mxcsr
        stmxcsr -4(%rsp)
        orl     $0x20, -4(%rsp)
        ldmxcsr -4(%rsp)
        mov     $7, %eax
        ret

/* All x87 exceptions unmasked, and one pending. */
function break_x87_control
        movw    $0x340, -2(%rsp)
        fldcw   -2(%rsp)
        fld1
        fchs
        fsqrt
        mov     $7, %eax
        ret

function change_x87_control
        movw    $0x27f, -2(%rsp)
        fldcw   -2(%rsp)
        mov     $7, %eax
        ret

function leave_x87_value
        fldpi
        mov     $7, %eax
        ret

function leave_mmx
        pcmpeqd %mm3, %mm3
        mov     $7, %eax
        ret

function break_fs
        xor     %eax, %eax
        wrfsbase %rax
        mov     $7, %eax
        ret

/* Everything at once. */
function break_everything
        pop     %rcx
        not     %rbx
        not     %rbp
        not     %r12
        not     %r13
        not     %r14
        not     %r15
        fldpi
        movw    $0x340, -16(%rsp)
        fldcw   -16(%rsp)
        movl    $0xff80, -16(%rsp)
        ldmxcsr -16(%rsp)
        pushq   $0x44602
        popfq
        mov     $7, %eax
        xor     %esp, %esp
        jmp     *%rcx
        .section .note.GNU-stack, "", @progbits
