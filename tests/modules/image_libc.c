/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_libc.c - a module that leans on the C library, as a newcomer writes it.
 */
#include <stdio.h>

long Program_01(void *data);

long Program_01(void *data)
{
    printf("%p\n", data);
    return 0;
}
