/* SPDX-License-Identifier: GPL-2.0-or-later */
/* stack_i386.S - as stack.S of the machine's modules, for 32-bit Windows. */
        .macro  function name
        .globl  _\name
_\name:
        .endm

        .text
function straight               /* 4 + 4 + 40 */
        pushl   %ebx
        subl    $40, %esp
        movl    $0, (%esp)
        addl    $40, %esp
        popl    %ebx
        ret

function nested                 /* 4 + 12 + 48 */
        subl    $12, %esp
        call    _straight
        addl    $12, %esp
        ret

function realigned              /* 4 + 4 + up to 12 of alignment + 32 */
        pushl   %ebp
        movl    %esp, %ebp
        andl    $-16, %esp
        subl    $32, %esp
        leave
        ret

function dynamic_realign        /* 4 + up to 12 + 4 + 4 + 4 + 20: the stack pointer comes back from memory */
        leal    4(%esp), %ecx
        andl    $-16, %esp
        pushl   -4(%ecx)
        pushl   %ebp
        movl    %esp, %ebp
        pushl   %ecx
        subl    $20, %esp
        movl    -4(%ebp), %ecx
        leave
        leal    -4(%ecx), %esp
        ret

taker:  pushl   %ebx            /* stdcall with two arguments: 4 + 4 */
        popl    %ebx
        ret     $8

function gives                  /* 4 + 8 + 8, in a loop that stays where it is */
        movl    $9, %esi
1:      pushl   $1
        pushl   $2
        call    taker
        decl    %esi
        jne     1b
        ret

function probed                 /* 4 + 8192 */
        movl    $8192, %eax
        call    probe
        subl    %eax, %esp
        addl    $8192, %esp
        ret
probe:  ret

function table                  /* 4 + 64, the deepest */
        movl    8(%esp), %eax
        cmpl    $2, %eax
        ja      table_9
        jmp     *targets(, %eax, 4)
table_0:
        ret
table_1:
        pushl   $0
        popl    %eax
        ret
table_2:
        subl    $64, %esp
        addl    $64, %esp
table_9:
        ret

function service                /* 4 + 4 + 4 */
        pushl   %ebx
        movl    8(%esp), %ebx
        call    *8(%ebx)
        popl    %ebx
        ret

function all_registers          /* 4 + 32 + 4 */
        pushal
        pushfl
        popfl
        popal
        ret

function negative               /* 4 + 16 */
        movl    $-16, %eax
        addl    %eax, %esp
        addl    $16, %esp
        ret

function tail                   /* 48 */
        jmp     _straight

function recursive
        pushl   %eax
        call    _recursive
        popl    %eax
        ret

function loop_push
1:      pushl   %eax
        decl    %edi
        jns     1b
        leave
        ret

function alloca
        pushl   %ebp
        movl    %esp, %ebp
        subl    %edi, %esp
        leave
        ret

function pointer                /* 4 + (4 + 16) */
        call    *pointer_to
        ret
callback:
        subl    $16, %esp
        addl    $16, %esp
        ret

        .section .rdata, "dr"
        .balign 4
targets:
        .long   table_0, table_1, table_2

        .data
        .balign 4
pointer_to:
        .long   callback
