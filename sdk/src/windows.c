/* SPDX-License-Identifier: MIT */
/*
 * What Microsoft's compilers, and clang for their targets, take from their C library on their own;
 * with it a module links with /NODEFAULTLIB. Not needed by mingw (TARGET=pe64).
 */
#ifdef _MSC_VER

/* Its presence says that floating-point numbers are used. */
extern int _fltused;
int _fltused = 0x9875;

#if defined(__clang__) && defined(_M_X64)
/*
 * Called in front of a frame of more than a page, whose size is in rax: touches the stack's pages
 * from the lowest one that is there (gs:0x10) on downwards, in order, and changes no register.
 * Microsoft's own compiler, which has no inline assembly, calls it not with /Gs1000000.
 */
void __chkstk(void);
__attribute__((naked)) void __chkstk(void)
{
    __asm__("push %rcx\n\t"
            "push %rax\n\t"
            "lea 24(%rsp), %rcx\n\t"
            "sub %rax, %rcx\n\t"
            "mov $0, %eax\n\t"
            "cmovb %rax, %rcx\n\t"
            "mov %gs:16, %rax\n\t"
            "cmp %rax, %rcx\n\t"
            "jae 2f\n\t"
            "and $-4096, %rcx\n"
            "1:\n\t"
            "sub $4096, %rax\n\t"
            "movb $0, (%rax)\n\t"
            "cmp %rax, %rcx\n\t"
            "jne 1b\n"
            "2:\n\t"
            "pop %rax\n\t"
            "pop %rcx\n\t"
            "ret");
}
#endif

#else
typedef int tgm_windows_c_is_empty;
#endif
