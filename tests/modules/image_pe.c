/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_pe.c - everything that a Windows loader would have to find, run or set up: functions of
 * another library, thread-local storage with callbacks, an entry point. Which exports it has, and
 * which of them are somebody else's, says image_pe.def.
 */
#include <stddef.h>
#include <stdint.h>

#define EXPORT __attribute__((used))

__declspec(dllimport) long by_name(long);
__declspec(dllimport) long by_number(long);

extern const struct tls_directory {
    uintptr_t start, end, index, callbacks;
    uint32_t zeroes, characteristics;
} _tls_used;

static char block[24];
static unsigned block_index;
static volatile long started;

static void __attribute__((stdcall)) first(void *module, uint32_t reason, void *reserved)
{
    (void)module, (void)reserved;
    started = (long)reason;
}

static void __attribute__((stdcall)) second(void *module, uint32_t reason, void *reserved)
{
    (void)module, (void)reserved;
    started = -(long)reason;
}

static const uintptr_t callbacks[] = { (uintptr_t)first, (uintptr_t)second, 0 };

EXPORT const struct tls_directory _tls_used = { (uintptr_t)block, (uintptr_t)block + sizeof block,
                                                (uintptr_t)&block_index, (uintptr_t)callbacks, 16,
                                                0 };

EXPORT int __attribute__((stdcall)) DllMain(void *module, uint32_t reason, void *reserved)
{
    (void)module, (void)reserved;
    return reason != 0;
}

EXPORT long Program_01(void *data);
EXPORT long Program_02(void *data);
EXPORT long unnamed(void);

long Program_01(void *data)
{
    return by_name(data != 0) + started; /* LINE Program_01 */
}

long Program_02(void *data)
{
    return by_number(data != 0);
}

long unnamed(void)
{
    return block_index;
}

#ifdef DELAYED
/* lld calls it at the first call of a function of a library that is loaded late. */
EXPORT void *__stdcall __delayLoadHelper2(const void *descriptor, void **slot);
void *__stdcall __delayLoadHelper2(const void *descriptor, void **slot)
{
    (void)descriptor;
    return *slot;
}
#endif
