/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/text16.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Longest number: 1e308 with all digits, and the largest precision that is honoured. */
#define NUMBER_MAX    700
#define PRECISION_MAX 340

struct sink {
    uint16_t *out;
    size_t capacity, used;
    bool cut;
};

struct conversion {
    bool left, plus, space, alternate, zero, has_precision;
    int width, precision;
    enum { SIZE_DEFAULT, SIZE_HH, SIZE_H, SIZE_L, SIZE_64, SIZE_POINTER } size;
    uint16_t letter;
};

static void put(struct sink *sink, uint16_t unit)
{
    if (sink->used + 1 < sink->capacity)
        sink->out[sink->used++] = unit;
    else
        sink->cut = true;
}

static void pad(struct sink *sink, int count, uint16_t with)
{
    for (; count > 0 && !sink->cut; count--)
        put(sink, with);
}

static int number(const uint16_t **format)
{
    int value = 0;
    for (; **format >= '0' && **format <= '9'; (*format)++)
        if (value < 100000)
            value = value * 10 + (**format - '0');
    return value;
}

static void parse_flags(const uint16_t **format, struct conversion *c)
{
    for (;; (*format)++)
        switch (**format) {
        case '-':
            c->left = true;
            break;
        case '+':
            c->plus = true;
            break;
        case ' ':
            c->space = true;
            break;
        case '#':
            c->alternate = true;
            break;
        case '0':
            c->zero = true;
            break;
        default:
            return;
        }
}

static void parse_size(const uint16_t **format, struct conversion *c)
{
    const uint16_t *f = *format;
    if (f[0] == 'h')
        c->size = f[1] == 'h' ? SIZE_HH : SIZE_H, f += f[1] == 'h' ? 2 : 1;
    else if (f[0] == 'l')
        c->size = f[1] == 'l' ? SIZE_64 : SIZE_L, f += f[1] == 'l' ? 2 : 1;
    else if (f[0] == 'I' && f[1] == '6' && f[2] == '4')
        c->size = SIZE_64, f += 3;
    else if (f[0] == 'I' && f[1] == '3' && f[2] == '2')
        f += 3;
    else if (f[0] == 'I' || f[0] == 'z' || f[0] == 't')
        c->size = SIZE_POINTER, f++;
    else if (f[0] == 'j')
        c->size = SIZE_64, f++;
    else if (f[0] == 'w')
        c->size = SIZE_L, f++;
    *format = f;
}

/* The conversion with a narrow format of its own: numbers are the C library's business. */
static void emit_number(struct sink *sink, const struct conversion *c, const char *size,
                        uint64_t whole, double real, bool is_real)
{
    char format[32], text[NUMBER_MAX];
    int at = snprintf(format, sizeof format, "%%%s%s%s", c->plus ? "+" : "", c->space ? " " : "",
                      c->alternate ? "#" : "");
    if (c->has_precision)
        at += snprintf(format + at, sizeof format - (size_t)at, ".%d",
                       c->precision < PRECISION_MAX ? c->precision : PRECISION_MAX);
    snprintf(format + at, sizeof format - (size_t)at, "%s%c", size, (char)c->letter);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    int length = is_real ? snprintf(text, sizeof text, format, real)
                         : snprintf(text, sizeof text, format, whole);
#pragma GCC diagnostic pop
    if (length < 0 || (size_t)length >= sizeof text)
        length = (int)strlen(text);

    const int gap = c->width - length;
    const bool zeros = c->zero && !c->left && (is_real ? isfinite(real) : !c->has_precision);
    const int sign = text[0] == '-' || text[0] == '+' || text[0] == ' ';
    const int prefix =
        sign + (text[sign] == '0' && (text[sign + 1] == 'x' || text[sign + 1] == 'X') ? 2 : 0);
    if (!c->left && !zeros)
        pad(sink, gap, ' ');
    for (int i = 0; i < (zeros ? prefix : 0); i++)
        put(sink, (uint16_t)text[i]);
    if (zeros)
        pad(sink, gap, '0');
    for (int i = zeros ? prefix : 0; i < length; i++)
        put(sink, (uint16_t)(unsigned char)text[i]);
    if (c->left)
        pad(sink, gap, ' ');
}

static void emit_text(struct sink *sink, const struct conversion *c, const void *text, bool wide)
{
    static const uint16_t null_text[] = { '(', 'n', 'u', 'l', 'l', ')', 0 };
    if (text == NULL)
        text = null_text, wide = true;
    const size_t most = c->has_precision ? (size_t)c->precision : SIZE_MAX;
    size_t length = 0;
    while (length < most && length <= sink->capacity &&
           (wide ? ((const uint16_t *)text)[length] : ((const unsigned char *)text)[length]) != 0)
        length++;
    const int gap = length < (size_t)c->width ? c->width - (int)length : 0;
    if (!c->left)
        pad(sink, gap, c->zero ? '0' : ' ');
    for (size_t i = 0; i < length && !sink->cut; i++)
        put(sink, wide ? ((const uint16_t *)text)[i] : ((const unsigned char *)text)[i]);
    if (c->left)
        pad(sink, gap, ' ');
}

/* va_list by pointer, so that a conversion takes exactly its arguments. */
struct arguments {
    va_list list;
};

static uint64_t take_integer(const struct conversion *c, struct arguments *a, bool is_signed)
{
    switch (c->size) {
    case SIZE_64:
        return va_arg(a->list, unsigned long long);
    case SIZE_L:
        return is_signed ? (uint64_t)va_arg(a->list, long) : va_arg(a->list, unsigned long);
    case SIZE_POINTER:
        return va_arg(a->list, size_t);
    case SIZE_HH:
        return is_signed ? (uint64_t)(int64_t)(signed char)va_arg(a->list, int)
                         : (unsigned char)va_arg(a->list, unsigned);
    case SIZE_H:
        return is_signed ? (uint64_t)(int64_t)(short)va_arg(a->list, int)
                         : (unsigned short)va_arg(a->list, unsigned);
    case SIZE_DEFAULT:
        break;
    }
    return is_signed ? (uint64_t)(int64_t)va_arg(a->list, int) : va_arg(a->list, unsigned);
}

/* False when the letter is none of the language. */
static bool convert(struct sink *sink, struct conversion *c, struct arguments *a)
{
    switch (c->letter) {
    case '%':
        put(sink, '%');
        return true;
    case 'd':
    case 'i':
        emit_number(sink, c, "ll", take_integer(c, a, true), 0, false);
        return true;
    case 'u':
    case 'x':
    case 'X':
    case 'o':
        emit_number(sink, c, "ll", take_integer(c, a, false), 0, false);
        return true;
    case 'p':
        c->letter = 'X', c->has_precision = true, c->precision = (int)(2 * sizeof(void *));
        emit_number(sink, c, "ll", (uint64_t)(uintptr_t)va_arg(a->list, void *), 0, false);
        return true;
    case 'e':
    case 'E':
    case 'f':
    case 'F':
    case 'g':
    case 'G':
    case 'a':
    case 'A':
        emit_number(sink, c, "", 0, va_arg(a->list, double), true);
        return true;
    case 'c':
    case 'C': {
        const bool narrow = c->letter == 'C' ? c->size != SIZE_L : c->size == SIZE_H;
        const int unit = va_arg(a->list, int);
        const uint16_t text[2] = { narrow ? (unsigned char)unit : (uint16_t)unit, 0 };
        c->has_precision = false;
        pad(sink, c->left ? 0 : c->width - 1, ' ');
        put(sink, text[0]);
        pad(sink, c->left ? c->width - 1 : 0, ' ');
        return true;
    }
    case 's':
    case 'S': {
        const bool narrow = c->letter == 'S' ? c->size != SIZE_L : c->size == SIZE_H;
        emit_text(sink, c, va_arg(a->list, const void *), !narrow);
        return true;
    }
    default:
        return false;
    }
}

static bool conversion_step(struct sink *sink, const uint16_t **format, struct arguments *a)
{
    struct conversion c = { 0 };
    parse_flags(format, &c);
    if (**format == '*') {
        c.width = va_arg(a->list, int);
        (*format)++;
        if (c.width < 0)
            c.left = true, c.width = c.width == INT32_MIN ? 0 : -c.width;
    } else {
        c.width = number(format);
    }
    if (**format == '.') {
        (*format)++;
        c.has_precision = true;
        if (**format == '*') {
            c.precision = va_arg(a->list, int);
            (*format)++;
            c.has_precision = c.precision >= 0;
        } else {
            c.precision = number(format);
        }
    }
    parse_size(format, &c);
    c.letter = **format;
    if (c.letter == 0 || !convert(sink, &c, a))
        return false;
    (*format)++;
    return true;
}

int text16_vformat(uint16_t *out, size_t capacity, const uint16_t *format, va_list list)
{
    struct sink sink = { out, capacity, 0, false };
    struct arguments arguments;
    bool good = true;
    va_copy(arguments.list, list);
    while (*format != 0 && good && !sink.cut) {
        if (*format != '%') {
            put(&sink, *format++);
            continue;
        }
        format++;
        good = conversion_step(&sink, &format, &arguments);
    }
    va_end(arguments.list);
    if (capacity > 0)
        out[sink.used] = 0;
    return good && !sink.cut && capacity > 0 ? (int)sink.used : -1;
}

int text16_format(uint16_t *out, size_t capacity, const uint16_t *format, ...)
{
    va_list list;
    va_start(list, format);
    int r = text16_vformat(out, capacity, format, list);
    va_end(list);
    return r;
}

/* What moves the cursor or the direction of a terminal; line ends and tabs are text. */
static bool is_control(uint32_t point)
{
    return (point < 0x20 && point != '\n' && point != '\r' && point != '\t') ||
           (point >= 0x7F && point < 0xA0) || (point >= 0x2028 && point <= 0x202E) ||
           (point >= 0x2066 && point <= 0x2069);
}

size_t text16_to_utf8(char *out, size_t capacity, const uint16_t *text)
{
    size_t used = 0;
    while (*text != 0) {
        uint32_t point = *text++;
        if (point >= 0xD800 && point < 0xDC00 && *text >= 0xDC00 && *text < 0xE000)
            point = 0x10000 + ((point - 0xD800) << 10) + (*text++ - 0xDC00u);
        else if (point >= 0xD800 && point < 0xE000)
            point = 0xFFFD;
        if (is_control(point))
            point = '?';
        char bytes[4];
        size_t count = point < 0x80 ? 1 : point < 0x800 ? 2 : point < 0x10000 ? 3 : 4;
        static const unsigned char lead[] = { 0, 0, 0xC0, 0xE0, 0xF0 };
        for (size_t i = count - 1; i > 0; i--, point >>= 6)
            bytes[i] = (char)(0x80 | (point & 0x3F));
        bytes[0] = (char)(lead[count] | point);
        if (used + count >= capacity)
            break;
        memcpy(out + used, bytes, count);
        used += count;
    }
    if (capacity > 0)
        out[used] = '\0';
    return used;
}

/* Length of the sequence at text, 1 to 4, its code point in *point; 0: it is none. */
static size_t utf8_decode(const unsigned char *text, uint32_t *point)
{
    static const uint32_t least[] = { 0, 0, 0x80, 0x800, 0x10000 };
    const size_t length = text[0] < 0x80             ? 1
                          : (text[0] & 0xE0) == 0xC0 ? 2
                          : (text[0] & 0xF0) == 0xE0 ? 3
                          : (text[0] & 0xF8) == 0xF0 ? 4
                                                     : 0;
    *point = length == 1 ? text[0] : text[0] & (0x7Fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((text[i] & 0xC0) != 0x80)
            return 0;
        *point = *point << 6 | (text[i] & 0x3Fu);
    }
    if (length == 0 || *point < least[length] || *point > 0x10FFFF || (*point & ~0x7FFu) == 0xD800)
        return 0;
    return length;
}

void text16_from_utf8(uint16_t *out, size_t capacity, const char *text)
{
    const unsigned char *at = (const unsigned char *)text;
    size_t used = 0;
    memset(out, 0, capacity * sizeof *out);
    while (*at != '\0') {
        uint32_t point;
        const size_t length = utf8_decode(at, &point);
        if (length == 0)
            point = 0xFFFD;
        if (used + (point > 0xFFFF ? 2 : 1) >= capacity)
            return;
        if (point > 0xFFFF) {
            out[used++] = (uint16_t)(0xD800 + ((point - 0x10000) >> 10));
            point = 0xDC00 + (point & 0x3FF);
        }
        out[used++] = (uint16_t)point;
        at += length > 0 ? length : 1;
    }
}
