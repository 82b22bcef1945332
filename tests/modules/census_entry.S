/* SPDX-License-Identifier: GPL-2.0-or-later */
/* census_entry.S - a DllMain that does what it is told with -DDEED. */
    .intel_syntax noprefix
    .text
    .globl DllMain
DllMain:
    push rbp
    mov rbp, rsp
    mov [rbp + 16], ecx
    DEED
    mov eax, 1
    pop rbp
    ret
1:  ret
    .data
word: .quad 0
