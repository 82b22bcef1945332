/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_ctors.c - a Windows module with a constructor and a destructor, which mingw puts into lists
 * that nothing but its run-time library walks.
 */
static volatile long started;

static void __attribute__((constructor)) constructor(void)
{
    started = 1;
}

static void __attribute__((destructor)) destructor(void)
{
    started = 0;
}

__declspec(dllexport) long Program_01(void *data);

long Program_01(void *data)
{
    return data != 0 ? started : 0;
}
