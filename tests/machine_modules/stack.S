/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stack.S - functions whose deepest byte of stack is known by counting, return address included.
 * Where a figure follows a name, that is the function's; each writes its deepest word, so that what
 * runs can be measured. With -DBACK a function whose address is taken calls through a pointer, too.
 */
        .macro  function name
        .globl  \name
        .type   \name, @function
\name:
        .endm

        .text
function straight               /* 56 */
        pushq   %rbx
        subq    $40, %rsp
        movq    $0, (%rsp)
        addq    $40, %rsp
        popq    %rbx
        ret
        .size   straight, . - straight

function leaf                   /* 32: below the stack pointer, in the red zone */
        movq    $0, -24(%rsp)
        ret

function byte_below             /* 8 + 24: whole words */
        movb    $1, -17(%rsp)
        ret

function segment                /* 8 + 16: two words, though fs has two bytes */
        pushq   %fs
        pushq   %gs
        addq    $16, %rsp
        ret

function half_word              /* 8 + 2, in whole words */
        pushw   %di
        popw    %di
        ret

function nested                 /* 8 + 8 + 56 */
        subq    $8, %rsp
        call    straight
        addq    $8, %rsp
        ret

function deeper_way             /* 8 + 120, the other way 8 + 16 + 56 */
        testq   %rdi, %rdi
        jne     1f
        subq    $16, %rsp
        call    straight
        addq    $16, %rsp
        ret
1:      subq    $120, %rsp
        movq    $0, (%rsp)
        addq    $120, %rsp
        ret

function framed                 /* 8 + 8 + up to 24 of alignment + 64 */
        pushq   %rbp
        movq    %rsp, %rbp
        andq    $-32, %rsp
        subq    $64, %rsp
        movq    $0, (%rsp)
        leave
        ret

function entered                /* 8 + 8 + 32 */
        enter   $32, $0
        movq    $0, (%rsp)
        leave
        ret

function tail                   /* 56: nothing of its own is left below straight */
        subq    $8, %rsp
        addq    $8, %rsp
        jmp     straight

function tail_loop              /* 8 + 8: it goes round, it does not call itself */
        pushq   %rax
        popq    %rax
        decl    %edi
        jns     tail_loop
        ret

function balanced_loop          /* 8 + 24 */
1:      pushq   %rax
        pushq   %rax
        pushq   $0
        addq    $24, %rsp
        decl    %edi
        jns     1b
        ret

function probed                 /* 8 + 8192 */
        movl    $8192, %eax
        call    probe
        subq    %rax, %rsp
        movq    $0, (%rsp)
        addq    $8192, %rsp
        ret

probe:  ret

function table                  /* 8 + 48, the deepest of four */
        cmpl    $3, %esi
        ja      table_9
        leaq    targets(%rip), %rdx
        movl    %esi, %eax
        movslq  (%rdx, %rax, 4), %rax
        addq    %rdx, %rax
        jmp     *%rax
table_0:
        ret
table_1:
        pushq   $0
        popq    %rax
        ret
table_2:
        subq    $48, %rsp
        movq    $0, (%rsp)
        addq    $48, %rsp
table_9:
        ret

function service                /* 8 + 8 + 8: through what is given as argument, stubbed by a ret */
        pushq   %rbx
        call    *8(%rdi)
        popq    %rbx
        ret

function get_place              /* 8 + 8: a call that only asks for the address */
        call    1f
1:      popq    %rax
        ret

function far_jump               /* 8 + 16; the place it jumps to is no function that a pointer could reach */
        subq    $16, %rsp
        leaq    far_place(%rip), %rax
        jmp     *%rax
far_place:
        movq    $0, (%rsp)
        addq    $16, %rsp
        ret

function stops                  /* 8 + 8: what follows the call is no code */
        call    stop
        .byte   0x06, 0x06
stop:   ud2

function falls_into_next        /* 8 + 8; three bytes, though the next function follows at once */
        pushq   %rax
        popq    %rax
        nop
function next                   /* 8 + 8 */
        pushq   %rax
        popq    %rax
        ret

function recursive
        subq    $24, %rsp
recursive_call:
        call    recursive
        addq    $24, %rsp
        ret

function mutual
        pushq   %rax
        call    other
        popq    %rax
        ret
other:  pushq   %rax
other_call:
        call    mutual
        popq    %rax
        ret

function calls_recursive
        call    recursive
        ret

function loop_push
1:      pushq   %rax
        decl    %edi
        jns     1b
        leave
        ret

function alloca
        pushq   %rbp
        movq    %rsp, %rbp
alloca_sub:
        subq    %rsi, %rsp
        leave
        ret

function underflow
        popq    %rax
        popq    %rax
        ret

function no_code
        .byte   0x06

function unknown_jump
        pushq   %rax
unknown_jump_jmp:
        jmp     *%rsi

function pointer                /* 8 + 8 + (8 + 32), callback */
        pushq   %rax
        movq    pointer_to(%rip), %rax
pointer_call:
        call    *%rax
        popq    %rax
        ret

callback:
        subq    $32, %rsp
        movq    $0, (%rsp)
        addq    $32, %rsp
        ret

#ifdef BACK
function back
        leaq    back(%rip), %rax
        pushq   %rax
        movq    pointer_to(%rip), %rax
back_call:
        call    *%rax
        popq    %rax
        ret
#endif

        .section .rodata
        .balign 4
targets:
        .long   table_0 - targets, table_1 - targets, table_2 - targets, table_9 - targets

        .data
        .balign 8
pointer_to:
        .quad   callback

        .section .note.GNU-stack, "", @progbits
