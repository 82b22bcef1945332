/* SPDX-License-Identifier: MIT */
#include "tgm/text.h"

#include "number.h"
#include "unicode.h"

void tgm_text8_init(struct tgm_text8 *t, char *buffer, size_t capacity)
{
    t->buffer = buffer;
    t->capacity = buffer != NULL ? capacity : 0;
    t->length = 0;
    t->truncated = 0;
    if (t->capacity > 0)
        buffer[0] = 0;
}

/* All of it or nothing. */
static int append(struct tgm_text8 *t, const char *bytes, size_t count)
{
    if (t->truncated || t->capacity == 0 || count > t->capacity - 1 - t->length) {
        t->truncated = 1;
        return 0;
    }
    for (size_t i = 0; i < count; i++)
        t->buffer[t->length++] = bytes[i];
    t->buffer[t->length] = 0;
    return 1;
}

int tgm_text8_character(struct tgm_text8 *t, uint32_t code_point)
{
    char bytes[4];

    if (!unicode_is_character(code_point))
        code_point = UNICODE_REPLACEMENT;
    const unsigned more = code_point < 0x80u ? 0 : code_point < 0x800u ? 1 : code_point < 0x10000u ? 2 : 3;
    for (unsigned i = more; i > 0; i--, code_point >>= 6)
        bytes[i] = (char)(0x80u | (code_point & 0x3Fu));
    bytes[0] = (char)(more == 0 ? code_point : (0xF0u << (3 - more) & 0xF0u) | code_point);
    return append(t, bytes, more + 1);
}

int tgm_text8_utf8_max(struct tgm_text8 *t, const char *string, size_t max)
{
    struct unicode_source8 source = { string, string != NULL ? max : 0 };
    for (uint32_t c; !t->truncated && (c = unicode_next8(&source)) != 0;)
        tgm_text8_character(t, c);
    return !t->truncated;
}

int tgm_text8_utf8(struct tgm_text8 *t, const char *string)
{
    return tgm_text8_utf8_max(t, string, SIZE_MAX);
}

int tgm_text8_utf16_max(struct tgm_text8 *t, const tgm_wchar *string, size_t max)
{
    struct unicode_source16 source = { string, string != NULL ? max : 0 };
    for (uint32_t c; !t->truncated && (c = unicode_next16(&source)) != 0;)
        tgm_text8_character(t, c);
    return !t->truncated;
}

int tgm_text8_utf16(struct tgm_text8 *t, const tgm_wchar *string)
{
    return tgm_text8_utf16_max(t, string, SIZE_MAX);
}

int tgm_text8_signed(struct tgm_text8 *t, int64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append(t, digits, tgm_number_signed(digits, value, width, pad));
}

int tgm_text8_unsigned(struct tgm_text8 *t, uint64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append(t, digits, tgm_number_unsigned(digits, value, width, pad));
}

int tgm_text8_hex(struct tgm_text8 *t, uint64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append(t, digits, tgm_number_hex(digits, value, width, pad));
}

int tgm_text8_fixed(struct tgm_text8 *t, double value, unsigned decimals, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append(t, digits, tgm_number_fixed(digits, value, decimals, width, pad));
}

int tgm_text8_column(struct tgm_text8 *t, size_t column)
{
    while (!t->truncated && t->length < column)
        tgm_text8_character(t, ' ');
    return !t->truncated;
}
