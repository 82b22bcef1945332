/* SPDX-License-Identifier: GPL-2.0-or-later */
/* hostile.S - functions that ask the kernel. NAME_at labels the instruction that asks. */
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
/* edi: process number */
function kill_process
        mov     $9, %esi
        mov     $62, %eax
label kill_process_at
        syscall
        ret

function exit_group_0
        xor     %edi, %edi
        mov     $231, %eax
label exit_group_0_at
        syscall
        ret

function write_standard_output
        mov     $1, %edi
        lea     text(%rip), %rsi
        mov     $5, %edx
        mov     $1, %eax
label write_standard_output_at
        syscall
        ret

/* edi: descriptor */
function write_evidence
        lea     text(%rip), %rsi
        mov     $5, %edx
        mov     $1, %eax
label write_evidence_at
        syscall
        ret

function fork_bomb
1:      mov     $57, %eax
label fork_bomb_at
        syscall
        jmp     1b

function get_process_number
        mov     $39, %eax
label get_process_number_at
        syscall
        ret

function x32_call
        mov     $0x40000027, %eax
label x32_call_at
        syscall
        ret

/* Registers of a signal frame of the module's choice. */
function return_from_no_signal
        mov     $15, %eax
label return_from_no_signal_at
        syscall
        ret

/* i386: getpid */
function int_0x80
        mov     $20, %eax
label int_0x80_at
        int     $0x80
        ret

function sysenter_call
        mov     $20, %eax
        mov     %rsp, %rbp
label sysenter_call_at
        sysenter
        ret

/* A system call instruction inside another one. */
function hidden_call
        mov     $39, %eax
        jmp     hidden_call_at
        .byte   0x48, 0xb8
label hidden_call_at
        syscall
        ret
        .byte   0, 0, 0, 0, 0
        ret

/* rdi: { function, argument 1, argument 2, argument 3 } */
function call_library
        push    %rbx
        mov     %rdi, %rbx
        mov     8(%rbx), %rdi
        mov     16(%rbx), %rsi
        mov     24(%rbx), %rdx
        xor     %ecx, %ecx
        xor     %eax, %eax
        call    *(%rbx)
label call_library_back
        pop     %rbx
        ret

/* The time() entry of the legacy vsyscall page. */
function call_vsyscall
        sub     $8, %rsp
        xor     %edi, %edi
        mov     $0xffffffffff600400, %rax
        call    *%rax
label call_vsyscall_back
        add     $8, %rsp
        ret

/* rdi: { address, number of bytes } */
function fill_memory
        mov     8(%rdi), %rcx
        mov     (%rdi), %rdi
        mov     $0xff, %al
        rep stosb
        ret

function where_is_fill_memory
        lea     fill_memory(%rip), %rax
        ret

function hang
        jmp     hang

/* rdi: { mmap, bytes }; how many such blocks it got. */
function eat_memory
        push    %rbx
        push    %r12
        push    %r13
        mov     %rdi, %rbx
        xor     %r12d, %r12d
1:      xor     %edi, %edi
        mov     8(%rbx), %rsi
        mov     $3, %edx                /* PROT_READ | PROT_WRITE */
        mov     $0x22, %ecx             /* MAP_PRIVATE | MAP_ANONYMOUS */
        mov     $-1, %r8
        xor     %r9d, %r9d
        call    *(%rbx)
        cmp     $-1, %rax
        je      2f
        inc     %r12
        cmp     $100000, %r12
        jb      1b
2:      mov     %r12, %rax
        pop     %r13
        pop     %r12
        pop     %rbx
        ret

/* rdi: the C library's way out of signal handlers. A frame of no signal, whose mask has them all. */
function spin_without_signals
        mov     %rdi, %rdx
        sub     $1024, %rsp
        and     $-64, %rsp
        mov     %rsp, %rdi
        xor     %eax, %eax
        mov     $128, %ecx
        rep stosq
        movq    $6, (%rsp)              /* the stack segment is meant */
        lea     -4096(%rsp), %rax
        mov     %rax, 160(%rsp)         /* rsp */
        lea     hang(%rip), %rax
        mov     %rax, 168(%rsp)         /* rip */
        movq    $0x202, 176(%rsp)
        movw    %cs, 184(%rsp)
        movw    %ss, 190(%rsp)
        movq    $-1, 296(%rsp)          /* the mask */
        jmp     *%rdx

/* Difference of two readings of the processor's clock. */
function read_clock
        rdtsc
        mov     %eax, %ecx
        rdtsc
        sub     %ecx, %eax
        ret

function end_normally
        mov     $7, %eax
        ret

        .section .rodata
text:   .ascii  "hello"
        .section .note.GNU-stack, "", @progbits
