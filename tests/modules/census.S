/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * census.S - x86-64 code in which test_census.c looks for instructions: those that exports lead to by every way
 * there is, and those that nothing leads to. Labels mark what is looked for.
 */
    .intel_syntax noprefix

.macro export name
    .globl \name
    .type \name, @function
\name:
.endm
.macro local_function name
    .type \name, @function
\name:
.endm
.macro end name
    .size \name, . - \name
.endm

    .text

/* Straight, called, jumped to. */
export straight
    nop
at_syscall:
    syscall
at_sysenter:
    sysenter
    ret
end straight

export calls
    call callee
    ret
end calls
local_function callee
at_int:
    int 0x80
    ret
end callee

export branches
    test rdi, rdi
    jne over
at_in:
    in al, dx
over:
    jmp tail
end branches
local_function tail
at_hlt:
    hlt
at_cli:
    cli
    ret
end tail

/* Into the middle of an instruction. */
export hidden
    jmp hidden_in_number + 1
hidden_in_number:
    .byte 0xb8
at_hidden:
    .byte 0x0f, 0x05, 0xc3, 0x00 /* mov eax, 0xc3050f; the number: syscall; ret */
    ret
end hidden

/* The number alone is nothing. */
export number
    mov eax, 0xc3050f
    ret
end number

/* Through a table that is indexed, a pointer in a table, the address of a function. */
export switched
    cmp esi, 2
    ja 1f
    mov esi, esi
    lea rax, [rip + jump_table]
    movsxd rsi, dword ptr [rax + rsi * 4]
    add rax, rsi
    jmp rax
case_0:
    ret
case_1:
at_rdtsc:
    rdtsc
    ret
case_2:
    nop
    ret
1:  ret
end switched

export by_pointer
    mov rax, [rip + pointers]
    call rax
    ret
end by_pointer
export by_any_pointer
    mov rax, [rip + changing]
    call rax
    ret
end by_any_pointer
local_function unknown_pointer
at_rdmsr:
    rdmsr
    ret
end unknown_pointer
local_function pointed_to
at_wrmsr:
    wrmsr
    ret
end pointed_to

/* Where the stack cannot be followed, control can. */
export lost_stack
    mov rsp, rsi
at_out:
    out 0x80, al
    ret
end lost_stack

/* A jump that nobody knows: everything in the function counts. */
export lost_jump
    push rdi
    mov rax, [rsi + rdx * 8]
    jmp rax
    pop rdi
at_cpuid:
    cpuid
    ret
end lost_jump

/* Who does not come back is not followed by code. */
export ends
    call never_returns
    .byte 0x0f, 0x01
end ends
local_function never_returns
    ud2
end never_returns

/* Blocks of threads, control and segment registers. */
export thread
at_canary:
    mov rax, fs:[0x28]
at_teb:
    mov rax, gs:[0x30]
at_limit:
    mov rax, gs:[0x10]
    nop word ptr cs:[rax + rax]
    ret
end thread

export registers
at_cr:
    mov rax, cr4
at_es:
    mov es, eax
    mov eax, es
    ret
end registers

/* What user code may do. */
export harmless
    pause
    mfence
    sfence
    lock inc dword ptr [rdi]
    prefetcht0 [rdi]
    ldmxcsr [rdi]
    fldcw [rdi]
    pushfq
    popfq
    std
    cld
    rep movsb
    ud2
end harmless

/* Nobody comes here. */
local_function dead
at_dead:
    sysenter
    ret
end dead

/* Neither function nor code. */
    .balign 16
at_bytes:
    .byte 0xcd, 0x2e

    .section .rodata
    .balign 4
jump_table:
    .long case_0 - jump_table, case_1 - jump_table, case_2 - jump_table

    .section .data.rel.ro, "aw", @progbits
    .balign 8
pointers:
    .quad pointed_to
    .data
    .balign 8
changing:
    .quad unknown_pointer
    .section .note.GNU-stack, "", @progbits
