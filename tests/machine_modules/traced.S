/* SPDX-License-Identifier: GPL-2.0-or-later */
/* traced.S - functions of which each instruction and each access to memory is known. Built twice:
 * traced.so, and traced_open.so, whose code can be written. */
        .macro  function name
        .globl  \name
        .type   \name, @function
\name:
        .endm
        .macro  label name
        .globl  \name
\name:
        .endm

        .text
/* rdi: 128 bytes */
function touch
label touch_read_8
        mov     (%rdi), %rax
label touch_write_4
        movl    $0x11223344, 8(%rdi)
        push    %rax                    /* the stack is no shared memory */
        pop     %rax
        lea     own_data(%rip), %rcx
        mov     %rax, (%rcx)            /* nor is its own data */
label touch_add_2
        addw    $1, 16(%rdi)
label touch_write_1
        movb    %al, 21(%rdi)
        movups  (%rdi), %xmm1
label touch_write_16
        movups  %xmm1, 32(%rdi)
label touch_unaligned
        mov     51(%rdi), %edx
        ret

/* Three times one instruction. */
function repeated
        lea     64(%rdi), %rdi
        mov     $3, %ecx
        mov     $-1, %rax
label repeated_at
        rep stosq
        ret

/* A register that cannot be reached, in the last of five instructions. */
function fault_in_the_middle
        mov     (%rdi), %rax
        add     $1, %rax
        mov     %rax, 8(%rdi)
        xor     %ecx, %ecx
label fault_in_the_middle_at
        mov     %rax, 16(%rcx)
        mov     %rax, 24(%rdi)
        ret

function divide_in_the_middle
        nop
        xor     %ecx, %ecx
        mov     $1, %eax
        cltd
label divide_in_the_middle_at
        idiv    %ecx
        ret

function call_null_in_the_middle
        push    %rbx
        xor     %ebx, %ebx
        call    *%rbx
label call_null_back
        pop     %rbx
        ret

/* rdi: 0 or not */
function branch
        test    %rdi, %rdi
        jz      branch_zero
label branch_other
        mov     $2, %eax
        ret
label branch_zero
        mov     $1, %eax
        ret

function vector_extension
        nop
label vector_extension_at
        vaddpd  %ymm1, %ymm2, %ymm0
        ret

function vector_extension_short
label vector_extension_short_at
        vaddss  %xmm1, %xmm2, %xmm0
        ret

function count_bits
label count_bits_at
        popcnt  %rdi, %rax
        ret

function general_extension
        mov     $0xf0, %eax
        mov     $0x3c, %ecx
        andn    %ecx, %eax, %eax
        ret

/* Takes 4 KiB and touches only the far end. */
function deep
        sub     $4096, %rsp
        movb    $1, (%rsp)
        add     $4096, %rsp
        ret

/* rdi: { service, format, seen }; more arguments than there are registers */
function call_service
        push    %rbx
        mov     %rdi, %rbx
        mov     $1, %eax
        cvtsi2sd %eax, %xmm0
        mov     $3, %eax
        cvtsi2sd %eax, %xmm1
        pushq   $9                      /* the second on the stack */
        pushq   $8
        mov     8(%rbx), %rdi
        mov     $2, %esi
        mov     $-4, %rdx
        mov     $5, %ecx
        mov     $6, %r8d
        mov     $7, %r9d
        mov     $2, %eax
        call    *(%rbx)
label call_service_back
        add     $16, %rsp
        pop     %rbx
        ret

/* rdi: a service */
function call_for_ever
        push    %rbx
        mov     %rdi, %rbx
1:      call    *%rbx
        jmp     1b

/* Makes `patched` return 9 instead of 8. */
function patch_code
        call    patched
        lea     patched(%rip), %rcx
label patch_code_at
        movb    $9, 1(%rcx)
        jmp     patched
function patched
        mov     $8, %eax
        ret

        .data
        .p2align 3
own_data:
        .quad   0
        .section .note.GNU-stack, "", @progbits
