/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The style sheet of HTML reports, in the program. */
    .section .rodata
    .global report_style
report_style:
    .incbin "harness/report/report.css"
    .byte 0
    .section .note.GNU-stack, "", @progbits
