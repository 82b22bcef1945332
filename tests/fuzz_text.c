/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * libFuzzer target: any sequence of calls on a UTF-16 and a UTF-8 builder of any small capacity. After each
 * call: ended by 0, within capacity, the bytes around the buffer untouched, valid Unicode, and
 * an extension of what was there before; once truncated, unchanged.
 *
 *     clang -fsanitize=fuzzer,address,undefined -Isdk/include -o fuzz_text tests/fuzz_text.c \
 *         sdk/src/number.c sdk/src/text16.c sdk/src/text8.c -DTGM_HOST
 *
 * Input: byte 0 and 1 the capacities; then calls: one byte which, and its arguments.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <tgm/text.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define MOST   80
#define CANARY 0xA5

static uint8_t store8[MOST + 32];
static uint16_t store16[MOST + 32];
#define TEXT8  ((char *)store8 + 16)
#define TEXT16 (store16 + 16)

static void must(int holds)
{
    if (!holds)
        abort();
}

static void check_canaries(size_t capacity8, size_t capacity16)
{
    for (size_t i = 0; i < MOST + 32; i++) {
        must((i >= 16 && i < 16 + capacity8) || store8[i] == CANARY);
        must((i >= 16 && i < 16 + capacity16) || store16[i] == CANARY * 0x101);
    }
}

/* Written apart from the SDK's own decoder, by the bit patterns. */
static void check_utf8(const char *text, size_t length)
{
    for (size_t i = 0; i < length;) {
        const unsigned c = (uint8_t)text[i];
        const size_t more = c < 0x80 ? 0 : c >> 5 == 6 ? 1 : c >> 4 == 14 ? 2 : c >> 3 == 30 ? 3 : 99;
        must(more < 4 && i + more < length);
        uint32_t value = more == 0 ? c : c & (0x3Fu >> more);
        for (size_t k = 1; k <= more; k++) {
            must((text[i + k] & 0xC0) == 0x80);
            value = value << 6 | ((uint8_t)text[i + k] & 0x3Fu);
        }
        static const uint32_t least[] = { 1, 0x80, 0x800, 0x10000 };
        must(value >= least[more] && value <= 0x10FFFF && (value < 0xD800 || value > 0xDFFF));
        i += more + 1;
    }
}

static void check_utf16(const uint16_t *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        must(text[i] != 0 && (text[i] < 0xDC00 || text[i] > 0xDFFF));
        if (text[i] >= 0xD800 && text[i] <= 0xDBFF) {
            i++;
            must(i < length && text[i] >= 0xDC00 && text[i] <= 0xDFFF);
        }
    }
}

struct input {
    const uint8_t *at;
    size_t left;
};

static uint64_t take(struct input *in, size_t bytes)
{
    uint64_t value = 0;
    for (; bytes > 0; bytes--, in->at += in->left > 0, in->left -= in->left > 0)
        value = value << 8 | (in->left > 0 ? *in->at : 0);
    return value;
}

/* Strings lie in blocks of their exact size, so that the sanitizer sees a read behind the end. */
static void append_string(struct tgm_text8 *t8, struct tgm_text16 *t16, struct input *in, unsigned kind)
{
    const size_t count = take(in, 1) % 40;
    const size_t ended = kind & 1; /* with a final 0, or bounded by max */
    char *bytes = malloc(count + ended + (count + ended == 0));
    uint16_t *units = malloc((count + ended + (count + ended == 0)) * sizeof *units);
    must(bytes != NULL && units != NULL);
    for (size_t i = 0; i < count; i++) {
        bytes[i] = (char)take(in, 1);
        units[i] = (uint16_t)take(in, 2);
    }
    if (ended) {
        bytes[count] = 0;
        units[count] = 0;
    }
    if (kind == 0) {
        tgm_text8_utf8_max(t8, bytes, count);
        tgm_text16_utf8_max(t16, bytes, count);
    } else if (kind == 1) {
        tgm_text8_utf8(t8, bytes);
        tgm_text16_utf8(t16, bytes);
    } else if (kind == 2) {
        tgm_text8_utf16_max(t8, units, count);
        tgm_text16_utf16_max(t16, units, count);
    } else {
        tgm_text8_utf16(t8, units);
        tgm_text16_utf16(t16, units);
    }
    free(bytes);
    free(units);
}

static void one_call(struct tgm_text8 *t8, struct tgm_text16 *t16, struct input *in)
{
    const unsigned which = (unsigned)take(in, 1);
    if (which % 10 < 4) {
        append_string(t8, t16, in, which % 10);
        return;
    }
    const uint64_t value = take(in, 8);
    const unsigned width = (unsigned)take(in, 1), decimals = (unsigned)take(in, 1);
    const char pad = (char)take(in, 1);
    double real;
    memcpy(&real, &value, sizeof real);
    switch (which % 10) {
    case 4:
        tgm_text8_signed(t8, (int64_t)value, width, pad);
        tgm_text16_signed(t16, (int64_t)value, width, pad);
        break;
    case 5:
        tgm_text8_unsigned(t8, value, width, pad);
        tgm_text16_unsigned(t16, value, width, pad);
        break;
    case 6:
        tgm_text8_hex(t8, value, width, pad);
        tgm_text16_hex(t16, value, width, pad);
        break;
    case 7:
        tgm_text8_fixed(t8, real, decimals, width, pad);
        tgm_text16_fixed(t16, real, decimals, width, pad);
        break;
    case 8:
        tgm_text8_character(t8, (uint32_t)value);
        tgm_text16_character(t16, (uint32_t)value);
        break;
    default:
        tgm_text8_column(t8, width);
        tgm_text16_column(t16, width);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct input in = { data, size };
    struct tgm_text8 t8;
    struct tgm_text16 t16;
    char before8[MOST];
    uint16_t before16[MOST];

    memset(store8, CANARY, sizeof store8);
    memset(store16, CANARY, sizeof store16);
    const size_t capacity8 = take(&in, 1) % (MOST + 1), capacity16 = take(&in, 1) % (MOST + 1);
    tgm_text8_init(&t8, TEXT8, capacity8);
    tgm_text16_init(&t16, TEXT16, capacity16);
    check_canaries(capacity8, capacity16);

    while (in.left > 0) {
        const struct tgm_text8 was8 = t8;
        const struct tgm_text16 was16 = t16;
        memcpy(before8, TEXT8, sizeof before8);
        memcpy(before16, TEXT16, sizeof before16);

        one_call(&t8, &t16, &in);

        check_canaries(capacity8, capacity16);
        must(capacity8 == 0 ? t8.length == 0 : t8.length < capacity8 && TEXT8[t8.length] == 0);
        must(capacity16 == 0 ? t16.length == 0 : t16.length < capacity16 && TEXT16[t16.length] == 0);
        must(t8.length >= was8.length && memcmp(TEXT8, before8, was8.length) == 0);
        must(t16.length >= was16.length && memcmp(TEXT16, before16, was16.length * 2) == 0);
        must(!was8.truncated || (t8.truncated && t8.length == was8.length));
        must(!was16.truncated || (t16.truncated && t16.length == was16.length));
        check_utf8(TEXT8, t8.length);
        check_utf16(TEXT16, t16.length);
    }
    return 0;
}
