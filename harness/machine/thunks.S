/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * thunks.S - the functions that module code is given: one for each service and convention, 16 bytes
 * apart. Each writes down the registers with arguments and goes to machine_served() (serve.c), on
 * the module's stack.
 */
#include "machine/thunks.h"

        .text
        .hidden machine_served
        .hidden machine_thunks_sysv
        .hidden machine_thunks_win64

        .macro  thunks name, behind
        .globl  \name
        .p2align 4
\name:
        .set    number, 0
        .rept   MACHINE_SERVICES
        .p2align 4
        mov     $number, %eax
        jmp     \behind
        .set    number, number + 1
        .endr
        .endm

        thunks  machine_thunks_sysv, sysv
        thunks  machine_thunks_win64, win64

/* struct arguments_sysv on the stack. */
        .p2align 4
sysv:   push    %rbp
        mov     %rsp, %rbp
        sub     $176, %rsp
        and     $-16, %rsp
        mov     %rdi, 0(%rsp)
        mov     %rsi, 8(%rsp)
        mov     %rdx, 16(%rsp)
        mov     %rcx, 24(%rsp)
        mov     %r8, 32(%rsp)
        mov     %r9, 40(%rsp)
        movaps  %xmm0, 48(%rsp)
        movaps  %xmm1, 64(%rsp)
        movaps  %xmm2, 80(%rsp)
        movaps  %xmm3, 96(%rsp)
        movaps  %xmm4, 112(%rsp)
        movaps  %xmm5, 128(%rsp)
        movaps  %xmm6, 144(%rsp)
        movaps  %xmm7, 160(%rsp)
        mov     %eax, %edi
        mov     %rsp, %rsi
        lea     16(%rbp), %rdx
        mov     8(%rbp), %rcx
        call    machine_served
        leave
        ret

/* The caller left room above the return address for the four registers. It keeps rdi, rsi and
 * xmm6 to xmm15, which the host's functions do not. */
        .p2align 4
win64:  push    %rbp
        mov     %rsp, %rbp
        mov     %rcx, 16(%rbp)
        mov     %rdx, 24(%rbp)
        mov     %r8, 32(%rbp)
        mov     %r9, 40(%rbp)
        push    %rdi
        push    %rsi
        sub     $160, %rsp
        and     $-16, %rsp
        movaps  %xmm6, 0(%rsp)
        movaps  %xmm7, 16(%rsp)
        movaps  %xmm8, 32(%rsp)
        movaps  %xmm9, 48(%rsp)
        movaps  %xmm10, 64(%rsp)
        movaps  %xmm11, 80(%rsp)
        movaps  %xmm12, 96(%rsp)
        movaps  %xmm13, 112(%rsp)
        movaps  %xmm14, 128(%rsp)
        movaps  %xmm15, 144(%rsp)
        mov     %eax, %edi
        xor     %esi, %esi
        lea     16(%rbp), %rdx
        mov     8(%rbp), %rcx
        call    machine_served
        movaps  0(%rsp), %xmm6
        movaps  16(%rsp), %xmm7
        movaps  32(%rsp), %xmm8
        movaps  48(%rsp), %xmm9
        movaps  64(%rsp), %xmm10
        movaps  80(%rsp), %xmm11
        movaps  96(%rsp), %xmm12
        movaps  112(%rsp), %xmm13
        movaps  128(%rsp), %xmm14
        movaps  144(%rsp), %xmm15
        mov     -8(%rbp), %rdi
        mov     -16(%rbp), %rsi
        leave
        ret

        .section .note.GNU-stack, "", @progbits
