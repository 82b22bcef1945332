/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * faults.S - functions that go wrong in one known way each. The instruction that does is labelled
 * NAME_at, the one after a call to nowhere NAME_back.
 */
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
function returns_value
        mov     %rdi, %rax
        not     %rax
        ret

function null_read
        xor     %eax, %eax
label null_read_at
        mov     16(%rax), %rcx
        ret

/* rdi: end of a region */
function write_past_end
label write_past_end_at
        movb    $1, 16(%rdi)
        ret

function read_first_past_end
label read_first_past_end_at
        movzbl  (%rdi), %eax
        ret

/* rdi: region */
function write_here
label write_here_at
        movb    $1, (%rdi)
        ret

function read_here
        movzbl  (%rdi), %eax
        ret

function read_before
label read_before_at
        movzbl  -1(%rdi), %eax
        ret

function call_here
        sub     $8, %rsp
        call    *%rdi
label call_here_back
        add     $8, %rsp
        ret

function write_code
        lea     write_code(%rip), %rax
label write_code_at
        movb    $1, (%rax)
        ret

function execute_data
        jmp     some_data

function divide_by_zero
        xor     %ecx, %ecx
        xor     %edx, %edx
        mov     $1, %eax
label divide_by_zero_at
        div     %ecx
        ret

function undefined_instruction
        nop
label undefined_instruction_at
        ud2

function breakpoint
        nop
label breakpoint_at
        int3
        ret

function long_breakpoint
label long_breakpoint_at
        .byte   0xcd, 0x03
        ret

function privileged
label privileged_at
        cli
        ret

function recurse
label recurse_at
        call    recurse
        ret

/* A frame of 8 MiB, touched at its far end first. */
function huge_frame
        sub     $0x800000, %rsp
label huge_frame_at
        movb    $1, (%rsp)
        add     $0x800000, %rsp
        ret

function wild_jump
        movabs  $0x123456789000, %rax
        jmp     *%rax

function wild_jump_below
        call    wild_jump
label wild_jump_below_back
        ret

function call_null
        xor     %eax, %eax
        call    *%rax
label call_null_back
        ret

function call_null_in_table
        call    *null_pointer(%rip)
label call_null_in_table_back
        ret

/* rdi: index register; the longest form, with a scale-index byte and a wide displacement */
function call_null_indexed
        lea     null_pointer(%rip), %r12
        xor     %ecx, %ecx
        call    *0x0(%r12, %rcx, 8)
label call_null_indexed_back
        ret

function non_canonical
        movabs  $0x8000000000000000, %rax
label non_canonical_at
        mov     (%rax), %rax
        ret

function non_canonical_stack
        movabs  $0x8000000000000000, %rsp
label non_canonical_stack_at
        push    %rax
        ret

function null_with_wild_stack
        mov     $0x1000, %esp
        xor     %eax, %eax
label null_with_wild_stack_at
        mov     (%rax), %rax
        ret

function loop_for_ever
label loop_for_ever_at
        jmp     loop_for_ever_at

/* rdi: a function of the host */
function loop_around_host
        push    %rbx
        mov     %rdi, %rbx
1:      call    *%rbx
label loop_around_host_back
        jmp     1b

/* rdi: { function of the host, its argument } */
function call_host
        sub     $8, %rsp
        mov     (%rdi), %rax
        mov     8(%rdi), %rdi
        call    *%rax
label call_host_back
        add     $8, %rsp
        ret

/* Every instruction traps from the second on. */
function trap_flag
        pushfq
        orq     $0x100, (%rsp)
        popfq
        nop
label trap_flag_at
        ret

function trap_flag_at_return
        pushfq
        orq     $0x100, (%rsp)
        popfq
        ret

function misaligned_access
        pushfq
        orq     $0x40000, (%rsp)
        popfq
label misaligned_access_at
        mov     -9(%rsp), %eax
        ret

/* Switches to 32-bit code, at an address that has none. */
function far_return
        push    $0x23
        push    $0x1000
        lretq

/* Faults without a thread pointer. */
function fault_without_fs
        xor     %eax, %eax
        mov     %eax, %fs
        pushfq
        orq     $0x40000, (%rsp)
        popfq
label fault_without_fs_at
        mov     (%rax), %rax
        ret

/* Only where the processor has wrfsbase. */
function fault_with_moved_fs
        mov     $0x1000, %eax
        wrfsbase %rax
        xor     %eax, %eax
label fault_with_moved_fs_at
        mov     (%rax), %rax
        ret

/* rdi: 32 words; the registers as they are on entry */
function store_registers
        mov     %rax, 0(%rdi)
        mov     %rcx, 8(%rdi)
        mov     %rdx, 16(%rdi)
        mov     %rsi, 24(%rdi)
        mov     %r8, 32(%rdi)
        mov     %r9, 40(%rdi)
        mov     %r10, 48(%rdi)
        mov     %r11, 56(%rdi)
        mov     %rbx, 64(%rdi)
        mov     %rbp, 72(%rdi)
        mov     %r12, 80(%rdi)
        mov     %r13, 88(%rdi)
        mov     %r14, 96(%rdi)
        mov     %r15, 104(%rdi)
        mov     %rsp, 112(%rdi)
        movups  %xmm0, 128(%rdi)
        movups  %xmm7, 144(%rdi)
        movups  %xmm15, 160(%rdi)
        stmxcsr 176(%rdi)
        fnstcw  184(%rdi)
        ret

        .data
        .p2align 4
label some_data
        ret
        .p2align 4
null_pointer:
        .quad   0
        .section .note.GNU-stack, "", @progbits
