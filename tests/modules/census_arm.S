/* SPDX-License-Identifier: GPL-2.0-or-later */
/* census_arm.S - the same as census.S for what is different on Arm. Cortex-A9, A32 and Thumb. */
    .syntax unified
    .arch armv7-a
    .arch_extension sec
    .arch_extension virt
    .fpu vfpv3-d16

.macro export name
    .globl \name
    .type \name, %function
\name:
.endm

    .text
    .arm
export straight
at_svc:
    svc #0
at_bkpt:
    bkpt #1
at_smc:
    smc #0
    bx lr

export privileged
at_cpsid:
    cpsid i
at_wfi:
    wfi
at_cache:
    mcr p15, 0, r0, c7, c5, 0
at_control:
    mrc p15, 0, r0, c1, c0, 0
at_msr:
    msr cpsr_c, r0
at_spsr:
    mrs r0, spsr
at_fpexc:
    vmsr fpexc, r0
at_rfe:
    rfeia r0
    bx lr

export thread
at_tpidruro:
    mrc p15, 0, r0, c13, c0, 3
    bx lr

export machine
at_pmccntr:
    mrc p15, 0, r0, c9, c13, 0
at_cntvct:
    mrrc p15, 1, r0, r1, c14
    bx lr

export harmless
    mrs r0, cpsr
    msr apsr_nzcvq, r0
    mcr p15, 0, r0, c7, c10, 5
    mcr p15, 0, r0, c7, c10, 4
    mcr p15, 0, r0, c7, c5, 4
    dmb
    dsb
    isb
    vmrs r0, fpscr
    vmsr fpscr, r0
    ldrex r1, [r0]
    strex r2, r1, [r0]
    clrex
    subs r0, r0, #1
    subne r0, r0, #1
    bx lr

export conditional
    cmp r0, #0
at_conditional:
    svceq #0
    bx lr

    .thumb
    .thumb_func
export in_thumb
at_thumb_svc:
    svc #7
at_thumb_cps:
    cpsie i
at_thumb_msr:
    msr cpsr_c, r0
    mrs r0, apsr
    msr apsr_nzcvq, r0
    bx lr
    .thumb_func
export pops
    push {r4, lr}
    pop {r4, pc}
    .balign 4
    .section .note.GNU-stack, "", %progbits
