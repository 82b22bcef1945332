/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/text16.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* Longest number: 1e308 with all digits, and the largest precision that has digits of its own:
 * every double is exact with 1074 behind the point. What is asked for beyond that is 0. */
#define NUMBER_MAX    1500
#define PRECISION_MAX 1074
#define WHOLE_MAX                                                                                  \
    32 /* the same of whole numbers: 22 octal digits; more, and the C library allocates */
#define HEX_DIGITS 13 /* of %a unless said */

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

/* A number in parts: "-0x" "1.5" "e+05", with zeros between the parts. */
struct number_text {
    const char *text;
    int prefix, body, end;      /* lengths: sign and 0x, digits, exponent */
    int zeros_before, zeros_in; /* in front of the digits; between digits and exponent */
};

static void put_zeros(struct sink *sink, int count)
{
    pad(sink, count, '0');
}

static void put_part(struct sink *sink, const char *text, int count)
{
    for (int i = 0; i < count && !sink->cut; i++)
        put(sink, (uint16_t)(unsigned char)text[i]);
}

static void put_number(struct sink *sink, const struct conversion *c, struct number_text n,
                       bool may_fill)
{
    const int64_t length = (int64_t)n.prefix + n.zeros_before + n.body + n.zeros_in + n.end;
    const int gap = c->width > length ? (int)(c->width - length) : 0;
    const bool fill = may_fill && c->zero && !c->left;
    if (!c->left && !fill)
        pad(sink, gap, ' ');
    put_part(sink, n.text, n.prefix);
    if (fill)
        put_zeros(sink, gap);
    put_zeros(sink, n.zeros_before);
    put_part(sink, n.text + n.prefix, n.body);
    put_zeros(sink, n.zeros_in);
    put_part(sink, n.text + n.prefix + n.body, n.end);
    if (c->left)
        pad(sink, gap, ' ');
}

static int prefix_of(const char *text)
{
    const int sign = text[0] == '-' || text[0] == '+' || text[0] == ' ';
    return sign + (text[sign] == '0' && (text[sign + 1] == 'x' || text[sign + 1] == 'X') ? 2 : 0);
}

/* Without width: flags, precision and letter. */
static void narrow_format(char out[32], const struct conversion *c, const char *size, int most)
{
    int at = snprintf(out, 32, "%%%s%s%s", c->plus ? "+" : "", c->space ? " " : "",
                      c->alternate ? "#" : "");
    if (c->has_precision)
        at += snprintf(out + at, 32 - (size_t)at, ".%d", c->precision < most ? c->precision : most);
    snprintf(out + at, 32 - (size_t)at, "%s%c", size, (char)c->letter);
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"

/* The digits are the C library's business. */
static void emit_integer(struct sink *sink, const struct conversion *c, uint64_t value)
{
    char format[32], text[2 * WHOLE_MAX];
    narrow_format(format, c, "ll", WHOLE_MAX);
    const int length = snprintf(text, sizeof text, format, value);
    const int beyond = c->has_precision && c->precision > WHOLE_MAX ? c->precision - WHOLE_MAX : 0;
    const int prefix = prefix_of(text);
    put_number(sink, c, (struct number_text){ text, prefix, length - prefix, 0, beyond, 0 },
               !c->has_precision);
}

/* As the C library of Windows writes them: inf, nan, and -nan(ind) for the number that came out of
 * no calculation. */
static void emit_no_number(struct sink *sink, const struct conversion *c, double value)
{
    char text[16];
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const bool big = c->letter < 'a';
    const char *word = !isnan(value)                                ? "inf"
                       : bits == UINT64_C(0xFFF8000000000000)       ? "nan(ind)"
                       : (bits & UINT64_C(0x0008000000000000)) == 0 ? "nan(snan)"
                                                                    : "nan";
    const char *sign = signbit(value) ? "-" : c->plus ? "+" : c->space ? " " : "";
    const int length = snprintf(text, sizeof text, "%s%s", sign, word);
    for (int i = 0; big && i < length; i++)
        if (text[i] >= 'a' && text[i] <= 'z')
            text[i] = (char)(text[i] - 'a' + 'A');
    put_number(sink, c, (struct number_text){ text, 0, length, 0, 0, 0 }, false);
}

static void emit_real(struct sink *sink, const struct conversion *wanted, double value)
{
    char format[32], text[NUMBER_MAX];
    struct conversion c = *wanted;
    if (!isfinite(value)) {
        emit_no_number(sink, &c, value);
        return;
    }
    if ((c.letter == 'a' || c.letter == 'A') && !c.has_precision)
        c.has_precision = true, c.precision = HEX_DIGITS;
    narrow_format(format, &c, "", PRECISION_MAX);
    const int length = snprintf(text, sizeof text, format, value);
    const int prefix = prefix_of(text);
    const char *exponent = strpbrk(text + prefix, c.letter == 'a' || c.letter == 'A' ? "pP" : "eE");
    const int body = exponent != NULL ? (int)(exponent - text) - prefix : length - prefix;
    const bool short_form = c.letter == 'g' || c.letter == 'G';
    const int beyond =
        c.has_precision && c.precision > PRECISION_MAX && (!short_form || c.alternate)
            ? c.precision - PRECISION_MAX
            : 0;
    put_number(sink, &c,
               (struct number_text){ text, prefix, body, length - prefix - body, 0, beyond }, true);
}
#pragma GCC diagnostic pop

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

static uint64_t signed_size(struct arguments *a)
{
    const uint64_t value = arguments_size(a);
    return arguments_pointer_bytes(a->convention) == 4 ? (uint64_t)(int64_t)(int32_t)value : value;
}

static uint64_t take_integer(const struct conversion *c, struct arguments *a, bool is_signed)
{
    switch (c->size) {
    case SIZE_64:
        return arguments_u64(a);
    case SIZE_L:
        return is_signed ? (uint64_t)arguments_long(a) : arguments_ulong(a);
    case SIZE_POINTER:
        return is_signed ? signed_size(a) : arguments_size(a);
    case SIZE_HH:
        return is_signed ? (uint64_t)(int64_t)(int8_t)arguments_u32(a) : (uint8_t)arguments_u32(a);
    case SIZE_H:
        return is_signed ? (uint64_t)(int64_t)(int16_t)arguments_u32(a)
                         : (uint16_t)arguments_u32(a);
    case SIZE_DEFAULT:
        break;
    }
    return is_signed ? (uint64_t)(int64_t)(int32_t)arguments_u32(a) : arguments_u32(a);
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
        emit_integer(sink, c, take_integer(c, a, true));
        return true;
    case 'u':
    case 'x':
    case 'X':
    case 'o':
        emit_integer(sink, c, take_integer(c, a, false));
        return true;
    case 'p':
        c->letter = 'X', c->has_precision = true,
        c->precision = (int)(2 * arguments_pointer_bytes(a->convention));
        emit_integer(sink, c, arguments_size(a));
        return true;
    case 'e':
    case 'E':
    case 'f':
    case 'F':
    case 'g':
    case 'G':
    case 'a':
    case 'A':
        emit_real(sink, c, arguments_f64(a));
        return true;
    case 'c':
    case 'C': {
        const bool narrow = c->letter == 'C' ? c->size != SIZE_L : c->size == SIZE_H;
        const int unit = (int)arguments_u32(a);
        const uint16_t text[2] = { narrow ? (unsigned char)unit : (uint16_t)unit, 0 };
        pad(sink, c->left ? 0 : c->width - 1, c->zero ? '0' : ' ');
        put(sink, text[0]);
        pad(sink, c->left ? c->width - 1 : 0, ' ');
        return true;
    }
    case 's':
    case 'S': {
        const bool narrow = c->letter == 'S' ? c->size != SIZE_L : c->size == SIZE_H;
        emit_text(sink, c, arguments_pointer(a), !narrow);
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
        c.width = (int)arguments_u32(a);
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
            c.precision = (int)arguments_u32(a);
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

int text16_vformat(uint16_t *out, size_t capacity, const uint16_t *format,
                   struct arguments *arguments)
{
    struct sink sink = { out, capacity, 0, false };
    bool good = true;
    while (*format != 0 && good && !sink.cut) {
        if (*format != '%') {
            put(&sink, *format++);
            continue;
        }
        format++;
        good = conversion_step(&sink, &format, arguments);
    }
    if (capacity > 0)
        out[sink.used] = 0;
    return good && !sink.cut && capacity > 0 ? (int)sink.used : -1;
}

int text16_format(uint16_t *out, size_t capacity, const uint16_t *format, ...)
{
    struct arguments arguments;
    va_list list;
    va_start(list, format);
    arguments_from_list(&arguments, list);
    int r = text16_vformat(out, capacity, format, &arguments);
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
