/* SPDX-License-Identifier: GPL-2.0-or-later */
/* windows.S - a PE module: functions called by the Windows convention, good and bad ones. */
        .macro  function name
        .globl  \name
        .def    \name; .scl 2; .type 32; .endef
\name:
        .endm

        .macro  label name
        .globl  \name
\name:
        .endm

        .text
function returns_value
        mov     %rcx, %rax
        not     %rax
        ret

/* rax, rcx ... r15, the argument's 32 bytes of home space written, xmm6-xmm15, control words */
function store_registers
        movq    $1, 8(%rsp)
        movq    $2, 16(%rsp)
        movq    $3, 24(%rsp)
        movq    $4, 32(%rsp)
        mov     %rax, 0(%rcx)
        mov     %rdx, 8(%rcx)
        mov     %r8, 16(%rcx)
        mov     %r9, 24(%rcx)
        mov     %r10, 32(%rcx)
        mov     %r11, 40(%rcx)
        mov     %rdi, 48(%rcx)
        mov     %rsi, 56(%rcx)
        mov     %rbx, 64(%rcx)
        mov     %rbp, 72(%rcx)
        mov     %r12, 80(%rcx)
        mov     %r13, 88(%rcx)
        mov     %r14, 96(%rcx)
        mov     %r15, 104(%rcx)
        mov     %rsp, 112(%rcx)
        stmxcsr 120(%rcx)
        fnstcw  128(%rcx)
        movups  %xmm0, 144(%rcx)
        movups  %xmm5, 160(%rcx)
        .irp    number, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15
        movups  %xmm\number, (176+16*(\number-6))(%rcx)
        .endr
        mov     $7, %eax
        ret

function keeps_all
        push    %rdi
        push    %rsi
        sub     $24, %rsp
        movups  %xmm6, (%rsp)
        mov     $1, %edi
        mov     $2, %esi
        pxor    %xmm6, %xmm6
        pxor    %xmm5, %xmm5
        lea     (%rdi, %rsi), %eax
        movups  (%rsp), %xmm6
        add     $24, %rsp
        pop     %rsi
        pop     %rdi
        ret

        .irp    name, rdi, rsi, rbx, rbp, r12, r13, r14, r15
function break_\name
        not     %\name
        mov     $7, %eax
        ret
        .endr

/* The lower half, the upper half. */
        .irp    number, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15
function break_xmm\number
        pcmpeqb %xmm0, %xmm0
        psrldq  $8, %xmm0
        pxor    %xmm0, %xmm\number
        mov     $7, %eax
        ret
function break_high_xmm\number
        pcmpeqb %xmm0, %xmm0
        pslldq  $8, %xmm0
        pxor    %xmm0, %xmm\number
        mov     $7, %eax
        ret
        .endr

function swap_vectors
        movaps  %xmm6, %xmm0
        movaps  %xmm15, %xmm6
        movaps  %xmm0, %xmm15
        mov     $7, %eax
        ret

function break_stack
        pop     %rcx
        sub     $16, %rsp
        mov     $7, %eax
        jmp     *%rcx

function break_direction
        mov     $7, %eax
        std
        ret

function break_mxcsr
        stmxcsr -4(%rsp)
        orl     $0x6000, -4(%rsp)
        ldmxcsr -4(%rsp)
        mov     $7, %eax
        ret

/* As Linux has it, which is wrong here. */
function linux_x87_control
        movw    $0x37f, -2(%rsp)
        fldcw   -2(%rsp)
        mov     $7, %eax
        ret

/* A division by zero that waits for the next instruction. */
function unmask_x87
        fld1
        fldz
        fdivrp
        fstp    %st(0)
        movw    $0x27b, -2(%rsp)
        fldcw   -2(%rsp)
        mov     $7, %eax
        ret

function leave_x87_value
        fldpi
        mov     $7, %eax
        ret

function break_gs
        mov     $0x1000, %eax
        wrgsbase %rax
        mov     $7, %eax
        ret

function null_gs
        xor     %eax, %eax
        mov     %eax, %gs
        mov     $7, %eax
        ret

function break_much
        not     %rdi
        not     %rsi
        not     %rbx
        pxor    %xmm9, %xmm9
        std
        mov     $7, %eax
        ret

/* gs:8, gs:0x10, gs:0x30, the stack pointer */
function read_thread_block
        mov     %gs:0x08, %rax
        mov     %rax, 0(%rcx)
        mov     %gs:0x10, %rax
        mov     %rax, 8(%rcx)
        mov     %gs:0x30, %rax
        mov     %rax, 16(%rcx)
        mov     %rsp, 24(%rcx)
        mov     0x30(%rax), %rax
        ret

function write_thread_block
        xor     %eax, %eax
label write_thread_block_at
        mov     %eax, %gs:0x10
        ret

function libraries
        mov     %gs:0x60, %rax
label libraries_at
        mov     0x18(%rax), %rax
        ret

function write_null
        xor     %eax, %eax
label write_null_at
        movl    $1, (%rax)
        ret

function write_code
        lea     write_code(%rip), %rax
label write_code_at
        movb    $1, (%rax)
        ret

function write_constant
        lea     constant(%rip), %rax
label write_constant_at
        movb    $1, (%rax)
        ret

function run_data
        sub     $40, %rsp
        lea     plain(%rip), %rax
        call    *%rax
label run_data_after
        add     $40, %rsp
        ret

function make_system_call
        mov     $39, %eax
label make_system_call_at
        syscall
        ret

function loop_for_ever
label loop_for_ever_at
        jmp     loop_for_ever

/* (*argument)(argument, 2, 3, 4, 5, 6.0, 7), by the Windows convention */
function call_back
        push    %rbx
        sub     $64, %rsp
        mov     %rcx, %rbx
        mov     $2, %edx
        mov     $3, %r8d
        mov     $4, %r9d
        movq    $5, 32(%rsp)
        mov     $0x4018000000000000, %rax
        mov     %rax, 40(%rsp)
        movq    $7, 48(%rsp)
        pcmpeqb %xmm6, %xmm6
        call    *(%rbx)
label call_back_after
        pcmpeqb %xmm0, %xmm0
        pcmpeqb %xmm0, %xmm6
        pmovmskb %xmm6, %ecx
        cmp     $0xffff, %ecx
        je      1f
        mov     $-1, %rax
1:      add     $64, %rsp
        pop     %rbx
        ret

function read_plain
        mov     pointer(%rip), %rax
        mov     (%rax), %eax
        ret

function write_plain
        mov     pointer(%rip), %rax
        movl    $5, (%rax)
        mov     $5, %eax
        ret

function read_zeroed
        mov     zeroed(%rip), %rax
        ret

function loop_1000
        mov     $1000, %ecx
1:      dec     %ecx
        jnz     1b
        mov     $7, %eax
        ret

        .section .rdata, "dr"
        .globl  constant
constant:
        .quad   0x1234
        .globl  table
table:  .quad   returns_value, plain, constant

        .data
        .globl  plain
plain:  .long   0x11223344, 0
pointer:
        .quad   plain

        .bss
        .globl  zeroed
zeroed: .skip   4000
