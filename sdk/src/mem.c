/* SPDX-License-Identifier: MIT */
/*
 * The four functions that compilers call on their own, whatever the flags. Compiled with
 * -fno-builtin -fno-tree-loop-distribute-patterns, or the loops below would become calls to themselves.
 */
#include <stddef.h>
#include <stdint.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *at, int value, size_t size);
int memcmp(const void *a, const void *b, size_t size);

typedef uint64_t __attribute__((may_alias, aligned(1))) word;

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    for (; size >= sizeof(word); size -= sizeof(word), t += sizeof(word), f += sizeof(word))
        *(word *)t = *(const word *)f;
    while (size-- > 0)
        *t++ = *f++;
    return to;
}

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    if ((uintptr_t)t - (uintptr_t)f >= size) { /* also true when t lies below f */
        for (; size >= sizeof(word); size -= sizeof(word), t += sizeof(word), f += sizeof(word))
            *(word *)t = *(const word *)f;
        while (size-- > 0)
            *t++ = *f++;
        return to;
    }
    for (t += size, f += size; size >= sizeof(word); size -= sizeof(word))
        *(word *)(t -= sizeof(word)) = *(const word *)(f -= sizeof(word));
    while (size-- > 0)
        *--t = *--f;
    return to;
}

void *memset(void *at, int value, size_t size)
{
    unsigned char *t = at;
    const unsigned char byte = (unsigned char)value;
    const uint64_t all = byte * UINT64_C(0x0101010101010101);
    for (; size >= sizeof(word); size -= sizeof(word), t += sizeof(word))
        *(word *)t = all;
    while (size-- > 0)
        *t++ = byte;
    return at;
}

int memcmp(const void *a, const void *b, size_t size)
{
    const unsigned char *x = a;
    const unsigned char *y = b;
    for (; size > 0 && *x == *y; size--)
        x++, y++;
    return size > 0 ? *x - *y : 0;
}
