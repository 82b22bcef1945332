/* SPDX-License-Identifier: GPL-2.0-or-later */
/* docs/rules.md in the program, for `tgm explain`. */
    .section .rodata
    .global rulebook_text
rulebook_text:
    .incbin "docs/rules.md"
    .byte 0
    .section .note.GNU-stack, "", @progbits
