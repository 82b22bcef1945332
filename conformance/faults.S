/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The fault scripts of the disturbed experiments, as they are, each ended with a NUL. */
    .section .rodata

.macro faults symbol, path
    .global faults_\symbol
faults_\symbol:
    .incbin "conformance/faults/\path"
    .byte 0
.endm

    faults lost_frame, "lost-frame.faults"
    faults lost_frames, "lost-frames.faults"
    faults late_frames, "late-frames.faults"
    faults short_counter, "short-counter.faults"
    faults cable, "cable.faults"
    faults slave_reset, "slave-reset.faults"
    faults al_error, "al-error.faults"
    faults watchdog, "watchdog.faults"
    faults drive_fault, "drive-fault.faults"
    faults stuck_input, "stuck-input.faults"
    faults clock_drift, "clock-drift.faults"
    faults drive_power, "drive-power.faults"
    faults terminal_power, "terminal-power.faults"
    faults mailbox, "mailbox.faults"

    .section .note.GNU-stack, "", %progbits
