/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fuzz_json.h - the mutator of fuzzers whose inputs are JSON behind a byte that chooses: now and
 * then a change that leaves it JSON. Included once in a program.
 */
#ifndef TESTS_FUZZ_JSON_H
#define TESTS_FUZZ_JSON_H

#include <ctype.h>
#include <stdint.h>
#include <string.h>

/* Letters and digits become others: what was a certificate stays one, or all but. */
static void change_letters(uint8_t *data, size_t size, unsigned int seed)
{
    static const char hex[] = "0123456789abcdef";
    for (unsigned int left = 1 + seed % 3; left > 0; left--) {
        seed = seed * 1103515245u + 12345u;
        uint8_t *at = &data[1 + (seed >> 8) % (size - 1)];
        if (isdigit(*at) || isxdigit(*at))
            *at = (uint8_t)hex[seed >> 4 & 15];
        else if (isalpha(*at))
            *at = (uint8_t)('a' + (seed >> 4) % 26);
    }
}

/* A text of a list, with what divides it from the next, comes twice. */
static size_t double_text(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    const size_t at = 1 + seed % (size - 1);
    uint8_t *begin = memchr(data + at, '"', size - at);
    uint8_t *comma = begin != NULL ? memchr(begin, ',', (size_t)(data + size - begin)) : NULL;
    if (comma == NULL)
        return size;
    const size_t length = (size_t)(comma + 1 - begin);
    if (length > max_size - size)
        return size;
    memmove(begin + length, begin, (size_t)(data + size - begin));
    return size + length;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    seed = seed * 2654435761u >> 4;
    if (size < 2 || seed % 4 != 0)
        return LLVMFuzzerMutate(data, size, max_size);
    if (seed % 16 == 0)
        return double_text(data, size, max_size, seed >> 4);
    change_letters(data, size, seed >> 4);
    return size;
}

#endif
