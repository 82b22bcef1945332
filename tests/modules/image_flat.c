/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_flat.c - a module of TGMcontroller: GetProcAddress first.
 */
const void *const *GetProcAddress(void);

static long counter = 7;

static long Program_01(void *data)
{
    return data != 0 ? ++counter : 0;
}

static const void *const functions[] = { (const void *)Program_01 };

__attribute__((section(".text.GetProcAddress"), used)) const void *const *GetProcAddress(void)
{
    static volatile long started;
    started = 1;
    return functions;
}
