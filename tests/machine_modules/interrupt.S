/* SPDX-License-Identifier: GPL-2.0-or-later */
/* interrupt.S - functions to be interrupted: each instruction is where the test counts it. */
        .macro  function name
        .globl  \name
        .type   \name, @function
\name:
        .endm

        .text
/* The race: 64 bits written in halves. Argument: where to, and behind it the value. */
function write_halves
        mov     8(%rdi), %rax
        mov     %eax, (%rdi)
        .globl  between_halves
between_halves:
        shr     $32, %rax
        mov     %eax, 4(%rdi)
        mov     $1, %eax
        ret

function read_whole
        mov     (%rdi), %rax
        ret

/* 3 + 2 * 1000 instructions. */
function loop_1000
        mov     $1000, %ecx
1:      dec     %ecx
        jnz     1b
        mov     $7, %eax
        ret

/* Everything that an interrupt could spoil, then checked: 0 when nothing was. */
function keep_everything
        push    %rbx
        push    %rbp
        push    %r15
        mov     $0x1111111111111111, %rbx
        mov     %rbx, -64(%rsp)         /* the red zone */
        lea     (%rbx, %rbx), %rbp
        lea     (%rbp, %rbx), %r15
        lea     (%rbp, %rbp), %r8
        lea     (%r8, %rbx), %r9
        movq    %rbx, %xmm0
        movq    %rbp, %xmm7
        movq    %r15, %xmm15
        fld1
        fldpi
        mov     $0x7fffffff, %ecx
        add     $1, %ecx                /* overflow and sign */
        std
        .globl  keep_here
keep_here:
        nop
        nop
        nop
        jno     bad
        jns     bad
        pushfq
        pop     %rax
        test    $0x400, %eax
        jz      bad
        cld
        mov     $1, %eax
        movq    %xmm0, %rdx
        cmp     %rbx, %rdx
        jne     out
        movq    %xmm7, %rdx
        cmp     %rbp, %rdx
        jne     out
        movq    %xmm15, %rdx
        cmp     %r15, %rdx
        jne     out
        cmp     -64(%rsp), %rbx
        jne     out
        lea     (%r8, %rbx), %rdx
        cmp     %r9, %rdx
        jne     out
        fldpi
        fucomip %st(1), %st
        jne     out
        fstp    %st
        fld1
        fucomip %st(1), %st
        jne     out
        fstp    %st
        xor     %eax, %eax
out:    pop     %r15
        pop     %rbp
        pop     %rbx
        ret
bad:    cld
        mov     $2, %eax
        jmp     out

/* Until somebody writes something there. */
function wait_for_word
        cmpl    $0, (%rdi)
        je      wait_for_word
        mov     (%rdi), %eax
        ret

/* Calls the service that the argument points to, twice. */
function call_service
        push    %rbx
        mov     %rdi, %rbx
        call    *(%rbx)
        .globl  after_service
after_service:
        call    *(%rbx)
        mov     $5, %eax
        pop     %rbx
        ret

function fault_at_once
        ud2

function trap_itself
        pushfq
        orq     $0x100, (%rsp)
        popfq
        nop
        ret

/* Writable data for reloads. */
function count_up
        lea     counter(%rip), %rdx
        mov     (%rdx), %eax
        incl    (%rdx)
        ret

        .data
        .p2align 2
counter:
        .long   5
