/* SPDX-License-Identifier: GPL-2.0-or-later */
/* windows_frames.c - frames of more than a page, as compilers for Windows make them. */

/* What Microsoft's compilers call in front of such a frame: rax bytes are about to be taken off the
 * stack, and its pages have to be touched from gs:0x10 on downwards, in order. */
__attribute__((naked, used)) void __chkstk(void)
{
    __asm__("push %rcx\n\t"
            "push %rax\n\t"
            "cmp $4096, %rax\n\t"
            "lea 24(%rsp), %rcx\n\t"
            "sub %rax, %rcx\n\t"
            "cmp %gs:16, %rcx\n\t"
            "jae 2f\n\t"
            "and $-4096, %rcx\n\t"
            "mov %gs:16, %rax\n\t"
            "1: sub $4096, %rax\n\t"
            "movb $0, (%rax)\n\t"
            "cmp %rax, %rcx\n\t"
            "jne 1b\n\t"
            "2: pop %rax\n\t"
            "pop %rcx\n\t"
            "ret");
}

static long long fill(volatile unsigned char *bytes, int count)
{
    for (int i = 0; i < count; i += 1000)
        bytes[i] = (unsigned char)(i / 1000);
    return bytes[(count - 1) / 1000 * 1000];
}

__declspec(dllexport) long long frame_of_100k(void *unused)
{
    volatile unsigned char bytes[100000];

    (void)unused;
    return fill(bytes, sizeof bytes);
}

__declspec(dllexport) long long frame_of_1m(void *unused)
{
    volatile unsigned char bytes[1000000];

    (void)unused;
    return fill(bytes, sizeof bytes);
}
