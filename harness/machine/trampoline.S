/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * trampoline.S - the way into module code and the three ways out of it.
 *
 * The module gets known registers: its argument, sentinels in the callee-saved ones, zero in the
 * rest. On the way back nothing it left is trusted: the host's stack pointer comes from
 * machine_state, what the ABI promises is compared, and put right when it was broken.
 *
 * While `active` is set a fault is the module's. It is cleared by the first instruction after the
 * call, so that a module which returns with the trap flag set or with the host's memory locked away
 * (wrpkru) is still charged.
 */
#include "machine/trampoline.h"

        .text
        .hidden machine_state
        .hidden machine_enter
        .hidden machine_abandon
        .hidden machine_signal_entry
        .hidden machine_resume
        .hidden machine_enter_again
        .hidden machine_step_aside
        .hidden machine_enter_aside
        .hidden machine_returned
        .hidden machine_trampoline_begin
        .hidden machine_trampoline_end

/* The general registers that a function of C keeps. */
        .macro  push_kept
        push    %rbx
        push    %rbp
        push    %r12
        push    %r13
        push    %r14
        push    %r15
        .endm

        .macro  pop_kept
        pop     %r15
        pop     %r14
        pop     %r13
        pop     %r12
        pop     %rbp
        pop     %rbx
        .endm

/* On the way into a call: what the host is to find again. rcx is machine_state from here on. */
        .macro  leave_host
        push_kept
        lea     machine_state(%rip), %rcx
        mov     %rsp, STATE_HOST_RSP(%rcx)
        stmxcsr STATE_HOST_MXCSR(%rcx)
        fnstcw  STATE_HOST_X87(%rcx)
        incq    STATE_SERIAL(%rcx)
        .endm

        .globl  machine_trampoline_begin
machine_trampoline_begin:

/* Before machine_returned, behind which a trap flag is none of the call's any more. */
stepped:
        pushq   STATE_ENTER_FLAGS(%rcx)
        popfq
        jmp     begin

/* The Windows convention: the argument in rcx, 32 bytes above the return address that the function
 * may write to (they are below the stack's top), more callee-saved registers, and the control word
 * that Windows gives a thread. */
begin_windows:
        fldcw   STATE_WINDOWS_X87(%rcx)
        movdqu  STATE_WINDOWS_XMM+0(%rcx), %xmm6
        movdqu  STATE_WINDOWS_XMM+16(%rcx), %xmm7
        movdqu  STATE_WINDOWS_XMM+32(%rcx), %xmm8
        movdqu  STATE_WINDOWS_XMM+48(%rcx), %xmm9
        movdqu  STATE_WINDOWS_XMM+64(%rcx), %xmm10
        movdqu  STATE_WINDOWS_XMM+80(%rcx), %xmm11
        movdqu  STATE_WINDOWS_XMM+96(%rcx), %xmm12
        movdqu  STATE_WINDOWS_XMM+112(%rcx), %xmm13
        movdqu  STATE_WINDOWS_XMM+128(%rcx), %xmm14
        movdqu  STATE_WINDOWS_XMM+144(%rcx), %xmm15
        mov     %rdi, %rdx
        mov     STATE_WINDOWS_SENTINEL+0(%rcx), %rdi
        mov     STATE_WINDOWS_SENTINEL+8(%rcx), %rsi
        mov     %rdx, %rcx
        xor     %edx, %edx
        xor     %r8d, %r8d
        xor     %r9d, %r9d
        xor     %r10d, %r10d
        xor     %r11d, %r11d
        call    *%rax
        jmp     returned_windows

/* struct machine_left machine_enter_aside(uint64_t stack_pointer): back to where
 * machine_step_aside() left a call; comes back as machine_enter() does. */
        .globl  machine_enter_aside
        .type   machine_enter_aside, @function
machine_enter_aside:
        leave_host
        movl    $1, STATE_ACTIVE(%rcx)
        mov     %rdi, %rsp
        ldmxcsr 0(%rsp)
        fldcw   4(%rsp)
        add     $8, %rsp
        pop_kept
        ret
        .size   machine_enter_aside, . - machine_enter_aside

/* struct machine_left machine_enter(void *function, void *argument) */
        .globl  machine_enter
        .type   machine_enter, @function
        .p2align 6
machine_enter:
        leave_host
        mov     %rdi, %rax
        mov     %rsi, %rdi
        mov     STATE_SENTINEL+0(%rcx), %rbx
        mov     STATE_SENTINEL+8(%rcx), %rbp
        mov     STATE_SENTINEL+16(%rcx), %r12
        mov     STATE_SENTINEL+24(%rcx), %r13
        mov     STATE_SENTINEL+32(%rcx), %r14
        mov     STATE_SENTINEL+40(%rcx), %r15
        pxor    %xmm0, %xmm0
        pxor    %xmm1, %xmm1
        pxor    %xmm2, %xmm2
        pxor    %xmm3, %xmm3
        pxor    %xmm4, %xmm4
        pxor    %xmm5, %xmm5
        pxor    %xmm6, %xmm6
        pxor    %xmm7, %xmm7
        pxor    %xmm8, %xmm8
        pxor    %xmm9, %xmm9
        pxor    %xmm10, %xmm10
        pxor    %xmm11, %xmm11
        pxor    %xmm12, %xmm12
        pxor    %xmm13, %xmm13
        pxor    %xmm14, %xmm14
        pxor    %xmm15, %xmm15
        movl    $1, STATE_ACTIVE(%rcx)
        mov     STATE_STACK_TOP(%rcx), %rsp
        cmpq    $0, STATE_ENTER_FLAGS(%rcx)
        jne     stepped
begin:  cmpq    $0, STATE_THREAD_BLOCK(%rcx)
        jne     begin_windows
        xor     %ecx, %ecx
        xor     %edx, %edx
        xor     %esi, %esi
        xor     %r8d, %r8d
        xor     %r9d, %r9d
        xor     %r10d, %r10d
        xor     %r11d, %r11d
        call    *%rax

        .globl  machine_returned
machine_returned:
        lea     machine_state(%rip), %rcx
        movl    $0, STATE_ACTIVE(%rcx)
compare:
        mov     %rsp, %rdx
        mov     STATE_HOST_RSP(%rcx), %rsp

        /* Everything that is wrong ends up as a set bit of rsi. */
        xor     STATE_SENTINEL+0(%rcx), %rbx
        xor     STATE_SENTINEL+8(%rcx), %rbp
        xor     STATE_SENTINEL+16(%rcx), %r12
        xor     STATE_SENTINEL+24(%rcx), %r13
        xor     STATE_SENTINEL+32(%rcx), %r14
        xor     STATE_SENTINEL+40(%rcx), %r15
        xor     STATE_STACK_TOP(%rcx), %rdx
        pushfq
        pop     %rdi
        and     $FLAGS_CHECKED, %edi
        stmxcsr STATE_MODULE_MXCSR(%rcx)
        mov     STATE_MODULE_MXCSR(%rcx), %r8d
        xor     STATE_HOST_MXCSR(%rcx), %r8d
        and     $MXCSR_CONTROL, %r8d
        fnstcw  STATE_MODULE_X87(%rcx)
        movzwl  STATE_MODULE_X87(%rcx), %r9d
        xor     STATE_HOST_X87(%rcx), %r9w
        xor     %r10d, %r10d
        cmpl    $0, STATE_HAS_FSGSBASE(%rcx)
        je      1f
        rdfsbase %r10
        xor     STATE_HOST_FS(%rcx), %r10
1:      mov     %rbx, %rsi
        or      %rbp, %rsi
        or      %r12, %rsi
        or      %r13, %rsi
        or      %r14, %rsi
        or      %r15, %rsi
        or      %rdx, %rsi
        or      %rdi, %rsi
        or      %r8, %rsi
        or      %r9, %rsi
        or      %r10, %rsi
        or      STATE_WINDOWS_SEEN(%rcx), %rsi
        mov     %rax, %r11
        xor     %eax, %eax
        test    %rsi, %rsi
        jnz     broken
        fxam                            /* only now: may raise what a changed control word unmasks */
        fnstsw  %ax
        and     $FXAM_MASK, %eax
        xor     $FXAM_EMPTY, %eax
        jnz     broken
        mov     %r11, %rax
        xor     %edx, %edx              /* LEFT_CLEAN */
back:   pop_kept
        ret

broken: mov     %rbx, STATE_SEEN+0(%rcx)
        mov     %rbp, STATE_SEEN+8(%rcx)
        mov     %r12, STATE_SEEN+16(%rcx)
        mov     %r13, STATE_SEEN+24(%rcx)
        mov     %r14, STATE_SEEN+32(%rcx)
        mov     %r15, STATE_SEEN+40(%rcx)
        mov     %rdx, STATE_SEEN_STACK(%rcx)
        mov     %rdi, STATE_SEEN_FLAGS(%rcx)
        mov     %r8, STATE_SEEN_MXCSR(%rcx)
        mov     %r9, STATE_SEEN_X87(%rcx)
        mov     %r10, STATE_SEEN_FS(%rcx)
        mov     %rax, STATE_SEEN_X87TAG(%rcx)
        mov     %r11, %rax
        mov     $LEFT_BROKEN, %edx

repair: pushq   $FLAGS_CLEAN
        popfq
        fninit
        fldcw   STATE_HOST_X87(%rcx)
        ldmxcsr STATE_HOST_MXCSR(%rcx)
        cmpl    $0, STATE_HAS_FSGSBASE(%rcx)
        je      back
        mov     STATE_HOST_FS(%rcx), %r8
        wrfsbase %r8
        jmp     back
        .size   machine_enter, . - machine_enter

/* What the Windows convention promises besides; then the rest. A control word that is not what it
 * was may have unmasked what fldcw would raise: it is put right by repair. */
returned_windows:
        lea     machine_state(%rip), %rcx
        movl    $0, STATE_ACTIVE(%rcx)
        xor     STATE_WINDOWS_SENTINEL+0(%rcx), %rdi
        xor     STATE_WINDOWS_SENTINEL+8(%rcx), %rsi
        mov     %rdi, STATE_SEEN_DI(%rcx)
        mov     %rsi, STATE_SEEN_SI(%rcx)
        or      %rsi, %rdi
        .irp    number, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15
        movdqu  STATE_WINDOWS_XMM+16*(\number-6)(%rcx), %xmm0
        pxor    %xmm0, %xmm\number
        .endr
        .irp    number, 7, 8, 9, 10, 11, 12, 13, 14, 15
        por     %xmm\number, %xmm6
        .endr
        movq    %xmm6, %r8
        psrldq  $8, %xmm6
        movq    %xmm6, %r9
        or      %r9, %r8
        mov     %r8, STATE_SEEN_XMM(%rcx)
        or      %r8, %rdi
        xor     %r8d, %r8d
        cmpl    $0, STATE_HAS_FSGSBASE(%rcx)
        je      1f
        rdgsbase %r8
        xor     STATE_THREAD_BLOCK(%rcx), %r8
1:      mov     %r8, STATE_SEEN_GS(%rcx)
        or      %r8, %rdi
        fnstcw  STATE_MODULE_X87(%rcx)
        movzwl  STATE_MODULE_X87(%rcx), %r9d
        xor     STATE_WINDOWS_X87(%rcx), %r9w
        mov     %r9, STATE_SEEN_WINDOWS_X87(%rcx)
        or      %r9, %rdi
        mov     %rdi, STATE_WINDOWS_SEEN(%rcx)
        test    %r9, %r9
        jnz     compare
        fldcw   STATE_HOST_X87(%rcx)
        jmp     compare

/* Leaves the call in progress from wherever the processor is; machine_enter() returns. The signal
 * handler makes the kernel resume here. */
        .globl  machine_abandon
        .type   machine_abandon, @function
machine_abandon:
        lea     machine_state(%rip), %rcx
        movl    $0, STATE_ACTIVE(%rcx)
        mov     STATE_HOST_RSP(%rcx), %rsp
        xor     %eax, %eax
        mov     $LEFT_ABANDONED, %edx
        jmp     repair
        .size   machine_abandon, . - machine_abandon

/* void machine_step_aside(uint64_t *stack_pointer): in a host service, leaves the call in progress
 * for as long as the host likes; machine_enter() returns. What a service may not touch is kept on
 * the call's stack. */
        .globl  machine_step_aside
        .type   machine_step_aside, @function
machine_step_aside:
        push_kept
        sub     $8, %rsp
        stmxcsr 0(%rsp)
        fnstcw  4(%rsp)
        mov     %rsp, (%rdi)
        lea     machine_state(%rip), %rcx
        movl    $0, STATE_ACTIVE(%rcx)
        mov     STATE_HOST_RSP(%rcx), %rsp
        xor     %eax, %eax
        mov     $LEFT_ASIDE, %edx
        jmp     repair
        .size   machine_step_aside, . - machine_step_aside

/* Goes on with the call that was interrupted: the signal handler puts its context back. */
        .globl  machine_resume
        .type   machine_resume, @function
machine_resume:
        int3
        ud2
        .size   machine_resume, . - machine_resume

/* struct machine_left machine_enter_again(void): into the call that is interrupted, instead of at the
 * beginning of a function; comes back as machine_enter() does. */
        .globl  machine_enter_again
        .type   machine_enter_again, @function
machine_enter_again:
        leave_host
        jmp     machine_resume
        .size   machine_enter_again, . - machine_enter_again

/* Signal handler. The module's fs base and alignment-check flag are still in force, and compiled C
 * survives neither (stack protector, errno; unaligned access). The kernel has seen to the rest. */
        .globl  machine_signal_entry
        .type   machine_signal_entry, @function
machine_signal_entry:
        pushfq
        andq    $~FLAG_ALIGNMENT, (%rsp)
        popfq
        lea     machine_state(%rip), %rcx
        cmpl    $0, STATE_HAS_FSGSBASE(%rcx)
        je      1f
        mov     STATE_HOST_FS(%rcx), %rax
        wrfsbase %rax
        jmp     machine_on_signal
1:      push    %rdi
        push    %rsi
        push    %rdx
        mov     STATE_HOST_FS(%rcx), %rsi
        mov     $0x1002, %edi           /* ARCH_SET_FS */
        mov     $158, %eax              /* arch_prctl */
        syscall
        pop     %rdx
        pop     %rsi
        pop     %rdi
        jmp     machine_on_signal
        .size   machine_signal_entry, . - machine_signal_entry

        .globl  machine_trampoline_end
machine_trampoline_end:
        .section .note.GNU-stack, "", @progbits
