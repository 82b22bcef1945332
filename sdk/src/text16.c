/* SPDX-License-Identifier: MIT */
#include "tgm/text.h"

#include "number.h"
#include "unicode.h"

void tgm_text16_init(struct tgm_text16 *t, tgm_wchar *buffer, size_t capacity)
{
    t->buffer = buffer;
    t->capacity = buffer != NULL ? capacity : 0;
    t->length = 0;
    t->truncated = 0;
    if (t->capacity > 0)
        buffer[0] = 0;
}

/* All of it or nothing. */
static int append(struct tgm_text16 *t, const tgm_wchar *units, size_t count)
{
    if (t->truncated || t->capacity == 0 || count > t->capacity - 1 - t->length) {
        t->truncated = 1;
        return 0;
    }
    for (size_t i = 0; i < count; i++)
        t->buffer[t->length++] = units[i];
    t->buffer[t->length] = 0;
    return 1;
}

int tgm_text16_character(struct tgm_text16 *t, uint32_t code_point)
{
    tgm_wchar units[2];

    if (!unicode_is_character(code_point))
        code_point = UNICODE_REPLACEMENT;
    if (code_point < 0x10000u) {
        units[0] = (tgm_wchar)code_point;
        return append(t, units, 1);
    }
    units[0] = (tgm_wchar)(0xD800u + ((code_point - 0x10000u) >> 10));
    units[1] = (tgm_wchar)(0xDC00u + (code_point & 0x3FFu));
    return append(t, units, 2);
}

int tgm_text16_utf16_max(struct tgm_text16 *t, const tgm_wchar *string, size_t max)
{
    struct unicode_source16 source = { string, string != NULL ? max : 0 };
    for (uint32_t c; !t->truncated && (c = unicode_next16(&source)) != 0;)
        tgm_text16_character(t, c);
    return !t->truncated;
}

int tgm_text16_utf16(struct tgm_text16 *t, const tgm_wchar *string)
{
    return tgm_text16_utf16_max(t, string, SIZE_MAX);
}

int tgm_text16_utf8_max(struct tgm_text16 *t, const char *string, size_t max)
{
    struct unicode_source8 source = { string, string != NULL ? max : 0 };
    for (uint32_t c; !t->truncated && (c = unicode_next8(&source)) != 0;)
        tgm_text16_character(t, c);
    return !t->truncated;
}

int tgm_text16_utf8(struct tgm_text16 *t, const char *string)
{
    return tgm_text16_utf8_max(t, string, SIZE_MAX);
}

static int append_number(struct tgm_text16 *t, const char *digits, unsigned count)
{
    tgm_wchar units[NUMBER_SIZE];
    for (unsigned i = 0; i < count; i++)
        units[i] = (tgm_wchar)digits[i];
    return append(t, units, count);
}

int tgm_text16_signed(struct tgm_text16 *t, int64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append_number(t, digits, tgm_number_signed(digits, value, width, pad));
}

int tgm_text16_unsigned(struct tgm_text16 *t, uint64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append_number(t, digits, tgm_number_unsigned(digits, value, width, pad));
}

int tgm_text16_hex(struct tgm_text16 *t, uint64_t value, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append_number(t, digits, tgm_number_hex(digits, value, width, pad));
}

int tgm_text16_fixed(struct tgm_text16 *t, double value, unsigned decimals, unsigned width, char pad)
{
    char digits[NUMBER_SIZE];
    return append_number(t, digits, tgm_number_fixed(digits, value, decimals, width, pad));
}

int tgm_text16_column(struct tgm_text16 *t, size_t column)
{
    while (!t->truncated && t->length < column)
        tgm_text16_character(t, ' ');
    return !t->truncated;
}
