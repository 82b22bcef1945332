/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The device files of the built-in terminals, as they are, each ended with a NUL. */
    .section .rodata

.macro device symbol, path
    .global \symbol
\symbol:
    .incbin "\path"
    .byte 0
.endm

    device terminal_dio_8x8, "harness/bus/terminals/dio-8x8.device"
    device terminal_ek1100, "harness/bus/terminals/ek1100.device"
    device terminal_di_8, "harness/bus/terminals/di-8.device"
    device terminal_di_16, "harness/bus/terminals/di-16.device"
    device terminal_do_8, "harness/bus/terminals/do-8.device"
    device terminal_do_16, "harness/bus/terminals/do-16.device"
    device terminal_ai_2, "harness/bus/terminals/ai-2.device"
    device terminal_ao_2, "harness/bus/terminals/ao-2.device"
    device terminal_strain_1, "harness/bus/terminals/strain-1.device"

    .section .note.GNU-stack, "", %progbits
