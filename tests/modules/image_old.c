/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_old.c - what few compilers still make: .ctors,
 * a segment that is writable and executable.
 */
#define EXPORT __attribute__((visibility("default")))

static void old_constructor(void)
{
}

__attribute__((section(".ctors"), used)) static void (*const list[])(void) = {
    (void (*)(void)) - 1, old_constructor, 0
};

__asm__(".pushsection .both,\"awx\",@progbits\n"
        ".globl writable_code\n"
        ".type writable_code,@function\n"
        "writable_code: ret\n"
        ".size writable_code,.-writable_code\n"
        ".popsection\n");

EXPORT long Program_01(void *data);

long Program_01(void *data)
{
    return data != 0;
}
