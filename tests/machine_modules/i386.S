/* SPDX-License-Identifier: GPL-2.0-or-later */
/* i386.S - a PE module for 32-bit Windows: functions called as cdecl, good and bad ones. */
        .macro  function name
        .globl  _\name
        .def    _\name; .scl 2; .type 32; .endef
_\name:
        .endm
        .macro  label name
        .globl  _\name
_\name:
        .endm

        .text
function returns_value
        mov     4(%esp), %eax
        not     %eax
        mov     $-1, %edx
        ret

/* 3 + 2 * 1000 instructions */
function loop_1000
        mov     $1000, %ecx
1:      dec     %ecx
        jnz     1b
        mov     $7, %eax
        ret

        .irp    name, ebx, ebp, esi, edi
function break_\name
        not     %\name
        ret
        .endr

function break_stack
        pop     %ecx
        sub     $16, %esp
        jmp     *%ecx

function break_direction
        std
        ret

function break_x87_control
        pushl   $0x37f
        fldcw   (%esp)
        pop     %eax
        ret

function leave_x87_value
        fldpi
        ret

/* 1 when the x87 rounds to doubles: 1 + 2^-60 is 1 then. */
function rounds_to_doubles
        pushl   $0x21800000
        flds    (%esp)
        pop     %eax
        fld1
        faddp
        fld1
        fucomip %st(1), %st
        fstp    %st
        sete    %al
        movzbl  %al, %eax
        ret

/* { double a, b, quotient } */
function divides
        mov     4(%esp), %ecx
        fldl    (%ecx)
        fdivl   8(%ecx)
        fstpl   16(%ecx)
        ret

function null_read
        xor     %eax, %eax
label null_read_at
        mov     16(%eax), %ecx
        ret

function divide_by_zero
        xor     %ecx, %ecx
        xor     %edx, %edx
        mov     $1, %eax
label divide_by_zero_at
        div     %ecx
        ret

function undefined_instruction
label undefined_instruction_at
        ud2

function breakpoint
label breakpoint_at
        int3
        ret

function make_system_call
        mov     $20, %eax
label make_system_call_at
        int     $0x80
        ret

function privileged
label privileged_at
        cli
        ret

function recurse
label recurse_at
        call    _recurse
        ret

function call_null
        xor     %eax, %eax
        call    *%eax
label call_null_back
        ret

function wild_jump
        mov     $0x90000000, %eax
        jmp     *%eax

function write_code
label write_code_at
        movb    $1, _write_code
        ret

function loop_for_ever
label loop_for_ever_at
        jmp     _loop_for_ever_at

/* The stack of the thread block, and its place: { base, limit, self, esp } */
function read_thread_block
        mov     4(%esp), %ecx
        mov     %fs:4, %eax
        mov     %eax, (%ecx)
        mov     %fs:8, %eax
        mov     %eax, 4(%ecx)
        mov     %fs:0x18, %eax
        mov     %eax, 8(%ecx)
        mov     %esp, 12(%ecx)
        ret

/* { service }: (int 2, int64 -4, double 1.5, int 5) */
function call_service
        mov     4(%esp), %ecx
        pushl   $5
        pushl   $0x3ff80000
        pushl   $0
        pushl   $-1
        pushl   $-4
        pushl   $2
        call    *(%ecx)
label call_service_back
        add     $24, %esp
        ret

function read_pointer
        mov     _pointer, %eax
        mov     (%eax), %eax
        ret

function count_up
        mov     _counter, %eax
        incl    _counter
        ret

        .data
        .p2align 2
label counter
        .long   5
label pointer
        .long   _counter
