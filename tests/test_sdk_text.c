/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SDK's text builders; what the fuzz target (fuzz_text.c) checks for any input is here by example. */
#define TGM_HOST
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <tgm/text.h>

#define SIZE 512

static char text8[SIZE];
static uint16_t text16[SIZE];
static struct tgm_text8 t8;
static struct tgm_text16 t16;

static int begin(void **state)
{
    (void)state;
    tgm_text8_init(&t8, text8, SIZE);
    tgm_text16_init(&t16, text16, SIZE);
    return 0;
}

/* What t16 holds, as UTF-8, by way of the converter, which has tests of its own. */
static const char *wide(void)
{
    static char out[SIZE * 3];
    struct tgm_text8 t;
    tgm_text8_init(&t, out, sizeof out);
    tgm_text8_utf16(&t, text16);
    assert_false(t.truncated);
    return out;
}

/* Calls both builders with the same arguments and compares both with the text expected. */
#define BOTH(expected, function, ...)                                                              \
    do {                                                                                           \
        begin(NULL);                                                                               \
        assert_int_equal(tgm_text8_##function(&t8, __VA_ARGS__), 1);                               \
        assert_int_equal(tgm_text16_##function(&t16, __VA_ARGS__), 1);                             \
        assert_string_equal(text8, expected);                                                      \
        assert_string_equal(wide(), expected);                                                     \
        assert_int_equal(t8.length, strlen(expected));                                             \
    } while (0)

static void integers_of_every_size(void **state)
{
    (void)state;
    BOTH("0", signed, 0, 0, ' ');
    BOTH("-1", signed, -1, 0, ' ');
    BOTH("-9223372036854775808", signed, INT64_MIN, 0, ' ');
    BOTH("9223372036854775807", signed, INT64_MAX, 0, ' ');
    BOTH("-2147483648", signed, INT32_MIN, 0, ' ');
    BOTH("0", unsigned, 0, 0, ' ');
    BOTH("4294967295", unsigned, UINT32_MAX, 0, ' ');
    BOTH("4294967296", unsigned, UINT64_C(4294967296), 0, ' ');
    BOTH("10000000000000000000", unsigned, UINT64_C(10000000000000000000), 0, ' ');
    BOTH("18446744073709551615", unsigned, UINT64_MAX, 0, ' ');
    BOTH("0", hex, 0, 0, ' ');
    BOTH("DEADBEEF", hex, 0xDEADBEEFu, 0, ' ');
    BOTH("FFFFFFFFFFFFFFFF", hex, UINT64_MAX, 0, ' ');
}

static void width_and_pad(void **state)
{
    (void)state;
    BOTH("   42", signed, 42, 5, ' ');
    BOTH("00042", signed, 42, 5, '0');
    BOTH("  -42", signed, -42, 5, ' ');
    BOTH("-0042", signed, -42, 5, '0');
    BOTH("-42", signed, -42, 3, '0');
    BOTH("-42", signed, -42, 2, '0');
    BOTH("   42", signed, 42, 5, '*');
    BOTH("0000BEEF", hex, 0xBEEF, 8, '0');
    BOTH("    BEEF", hex, 0xBEEF, 8, ' ');
    BOTH("000000000000000000000000000000000000000000000007", unsigned, 7, 4000000000u, '0');
    BOTH("  -1.50", fixed, -1.5, 2, 7, ' ');
    BOTH("-001.50", fixed, -1.5, 2, 7, '0');
    BOTH("    nan", fixed, __builtin_nan(""), 2, 7, '0');
    BOTH("   -inf", fixed, -__builtin_inf(), 2, 7, '0');
}

static void fractions_by_example(void **state)
{
    (void)state;
    BOTH("0.00", fixed, 0.0, 2, 0, ' ');
    BOTH("0.00", fixed, -0.0, 2, 0, ' ');
    BOTH("0.00", fixed, -0.004, 2, 0, ' ');
    BOTH("-0.01", fixed, -0.006, 2, 0, ' ');
    BOTH("0.12", fixed, 0.125, 2, 0, ' ');
    BOTH("0.38", fixed, 0.375, 2, 0, ' ');
    BOTH("0", fixed, 0.5, 0, 0, ' ');
    BOTH("2", fixed, 1.5, 0, 0, ' ');
    BOTH("2", fixed, 2.5, 0, 0, ' ');
    BOTH("1000.00", fixed, 999.995, 2, 0, ' ');
    BOTH("10", fixed, 9.5, 0, 0, ' ');
    BOTH("0.29999999999999999", fixed, 0.3, 17, 0, ' ');
    BOTH("0.29999999999999999", fixed, 0.3, 400, 0, ' ');
    BOTH("999999999999999872.000", fixed, 999999999999999872.0, 3, 0, ' ');
    BOTH(">=1e18", fixed, 1e18, 3, 0, ' ');
    BOTH("<=-1e18", fixed, -1e300, 3, 0, ' ');
    BOTH("inf", fixed, __builtin_inf(), 3, 0, ' ');
    BOTH("nan", fixed, -__builtin_nan(""), 3, 0, ' ');
    BOTH("0.00000000000000000", fixed, 0x1p-1074, 17, 0, ' ');
}

static uint64_t random_bits(void)
{
    static uint64_t x = UINT64_C(88172645463325252);
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return x;
}

/* The C library rounds exactly, too; it only writes the sign of what shows as zero. */
static void fractions_as_printf_has_them(void **state)
{
    (void)state;
    for (int i = 0; i < 300000; i++) {
        const uint64_t mantissa = random_bits() & ((UINT64_C(1) << 52) - 1);
        const uint64_t exponent = 1023 - 80 + random_bits() % 140;
        const uint64_t few = random_bits() % 52; /* short fractions have halves, long ones do not */
        const uint64_t bits = mantissa >> few << few | exponent << 52 | (random_bits() & 1) << 63;
        const unsigned decimals = (unsigned)(random_bits() % 18);
        char expected[400];
        double value;
        memcpy(&value, &bits, sizeof value);
        if (value >= 1e18 || value <= -1e18)
            continue;
        snprintf(expected, sizeof expected, "%.*f", (int)decimals, value);
        const int zero = strspn(expected, "-0.") == strlen(expected);
        begin(NULL);
        tgm_text8_fixed(&t8, value, decimals, 0, ' ');
        assert_string_equal(text8, expected + (zero && expected[0] == '-'));
    }
}

static void halves_are_found_exactly(void **state)
{
    (void)state;
    for (unsigned decimals = 0; decimals <= 17; decimals++)
        for (int i = -2000; i <= 2000; i++) { /* odd multiples of 2^-(decimals + 1) are halves */
            char expected[64];
            double value = i;
            for (unsigned d = 0; d <= decimals; d++)
                value /= 2;
            snprintf(expected, sizeof expected, "%.*f", (int)decimals, value);
            const int zero = strspn(expected, "-0.") == strlen(expected);
            begin(NULL);
            tgm_text8_fixed(&t8, value, decimals, 0, ' ');
            assert_string_equal(text8, expected + (zero && expected[0] == '-'));
        }
}

#define R "\xEF\xBF\xBD" /* U+FFFD */

static void invalid_utf8_is_replaced_piece_by_piece(void **state)
{
    static const struct {
        const char *in, *out;
    } table[] = {
        { "", "" },
        { "Stra\xC3\x9F" "e \xE2\x82\xAC \xF0\x9F\x98\x80", "Stra\xC3\x9F" "e \xE2\x82\xAC \xF0\x9F\x98\x80" },
        { "\xF4\x8F\xBF\xBF\xEF\xBF\xBF\xDF\xBF\x7F", "\xF4\x8F\xBF\xBF\xEF\xBF\xBF\xDF\xBF\x7F" },
        { "\x80x", R "x" },                       /* stray continuation */
        { "\xC0\xAF", R R },                      /* overlong */
        { "\xE0\x80\xAF", R R R },                /* overlong */
        { "\xF0\x80\x80\xAF", R R R R },          /* overlong */
        { "\xED\xA0\x80", R R R },                /* surrogate */
        { "\xF4\x90\x80\x80", R R R R },          /* above U+10FFFF */
        { "\xF8\x88\x80\x80\x80", R R R R R },    /* five bytes */
        { "\xFF\xFE", R R },
        { "\xE1\x80\xE2\xF0\x91\x92\xF1\xBF\x41", R R R R "A" }, /* Unicode standard, table 3-11 */
        { "\xE2\x82", R },                        /* ends in the middle */
        { "\xF0\x9F\x98", R },
        { "\xC3", R },
        { "a\xF0\x9F" "b", "a" R "b" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        BOTH(table[i].out, utf8, table[i].in);
        BOTH(table[i].out, utf8_max, table[i].in, strlen(table[i].in));
    }
    BOTH("ab", utf8_max, "abc", 2);
    BOTH(R, utf8_max, "\xE2\x82\xAC", 2);
    BOTH("", utf8_max, "abc", 0);
    BOTH("", utf8, NULL);
    BOTH("", utf8_max, NULL, 7);
}

static void unpaired_surrogates_are_replaced(void **state)
{
    static const uint16_t pair[] = { 'a', 0xD83D, 0xDE00, 'b', 0 };
    static const uint16_t high[] = { 0xD83D, 'b', 0 };
    static const uint16_t low[] = { 'a', 0xDE00, 0 };
    static const uint16_t swapped[] = { 0xDE00, 0xD83D, 0 };
    static const uint16_t twice[] = { 0xD83D, 0xD83D, 0xDE00, 0 };
    static const uint16_t ends[] = { 0xDBFF, 0 };
    static const uint16_t borders[] = { 0xD7FF, 0xE000, 0xD800, 0xDC00, 0xDBFF, 0xDFFF, 0 };
    (void)state;
    BOTH("a\xF0\x9F\x98\x80" "b", utf16, pair);
    BOTH("a" R, utf16_max, pair, 2);
    BOTH("a\xF0\x9F\x98\x80", utf16_max, pair, 3);
    BOTH(R "b", utf16, high);
    BOTH("a" R, utf16, low);
    BOTH(R R, utf16, swapped);
    BOTH(R "\xF0\x9F\x98\x80", utf16, twice);
    BOTH(R, utf16, ends);
    BOTH("\xED\x9F\xBF\xEE\x80\x80\xF0\x90\x80\x80\xF4\x8F\xBF\xBF", utf16, borders);
    BOTH("", utf16, NULL);
}

static void characters_by_number(void **state)
{
    (void)state;
    BOTH("A", character, 'A');
    BOTH("\xC2\x80", character, 0x80);
    BOTH("\xDF\xBF", character, 0x7FF);
    BOTH("\xE0\xA0\x80", character, 0x800);
    BOTH("\xEF\xBF\xBF", character, 0xFFFF);
    BOTH("\xF0\x90\x80\x80", character, 0x10000);
    BOTH("\xF4\x8F\xBF\xBF", character, 0x10FFFF);
    BOTH(R, character, 0x110000);
    BOTH(R, character, 0xD800);
    BOTH(R, character, 0xDFFF);
    BOTH(R, character, 0);
    BOTH(R, character, UINT32_MAX);
}

static void columns_align_what_follows(void **state)
{
    (void)state;
    tgm_text8_utf8(&t8, "speed");
    assert_true(tgm_text8_column(&t8, 8));
    assert_true(tgm_text8_column(&t8, 3));
    tgm_text8_unsigned(&t8, 7, 0, ' ');
    assert_string_equal(text8, "speed   7");
    tgm_text16_utf8(&t16, "speed");
    assert_true(tgm_text16_column(&t16, 8));
    assert_string_equal(wide(), "speed   ");
    assert_false(tgm_text16_column(&t16, SIZE_MAX));
    assert_int_equal(t16.length, SIZE - 1);
}

/* Whatever the capacity: a beginning of the whole text, ended by 0, nothing behind it touched. */
static void every_capacity_is_kept(void **state)
{
    (void)state;
    for (size_t capacity = 0; capacity < 24; capacity++) {
        memset(text8, 0x55, sizeof text8);
        memset(text16, 0x55, sizeof text16);
        tgm_text8_init(&t8, text8, capacity);
        tgm_text16_init(&t16, text16, capacity);
        tgm_text8_utf8(&t8, "\xE2\x82\xAC" "7 \xF0\x9F\x98\x80 ");
        tgm_text16_utf8(&t16, "\xE2\x82\xAC" "7 \xF0\x9F\x98\x80 ");
        tgm_text8_signed(&t8, -1234, 0, ' ');
        tgm_text16_signed(&t16, -1234, 0, ' ');
        for (size_t i = capacity; i < SIZE; i++) {
            assert_int_equal(text8[i], 0x55);
            assert_int_equal(text16[i], 0x5555);
        }
        static const size_t fits8[] = { 0, 0, 0, 0, 3, 4, 5, 5, 5, 5, 9, 10, 10, 10, 10, 10, 15 };
        static const size_t fits16[] = { 0, 0, 1, 2, 3, 3, 5, 6, 6, 6, 6, 6, 11 };
        const size_t length8 = capacity > 15 ? 15 : fits8[capacity];
        const size_t length16 = capacity > 11 ? 11 : fits16[capacity];
        assert_int_equal(t8.length, length8 == 15 && capacity < 16 ? 10 : length8);
        assert_int_equal(t16.length, length16);
        assert_int_equal(t8.truncated, capacity < 16);
        assert_int_equal(t16.truncated, capacity < 12);
        if (capacity > 0) {
            assert_int_equal(text8[t8.length], 0);
            assert_int_equal(text16[t16.length], 0);
        }
    }
}

static void nothing_follows_a_truncation(void **state)
{
    (void)state;
    tgm_text8_init(&t8, text8, 4);
    assert_false(tgm_text8_unsigned(&t8, 12345, 0, ' ')); /* whole or not at all */
    assert_string_equal(text8, "");
    assert_false(tgm_text8_utf8(&t8, "x"));
    assert_false(tgm_text8_character(&t8, 'x'));
    assert_string_equal(text8, "");
    tgm_text16_init(&t16, NULL, 100);
    assert_false(tgm_text16_utf8(&t16, "x"));
    assert_int_equal(t16.capacity, 0);
    assert_int_equal(t16.length, 0);
    tgm_text16_init(&t16, NULL, 100);
    assert_true(tgm_text16_utf8(&t16, ""));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(integers_of_every_size, begin),
        cmocka_unit_test_setup(width_and_pad, begin),
        cmocka_unit_test_setup(fractions_by_example, begin),
        cmocka_unit_test_setup(fractions_as_printf_has_them, begin),
        cmocka_unit_test_setup(halves_are_found_exactly, begin),
        cmocka_unit_test_setup(invalid_utf8_is_replaced_piece_by_piece, begin),
        cmocka_unit_test_setup(unpaired_surrogates_are_replaced, begin),
        cmocka_unit_test_setup(characters_by_number, begin),
        cmocka_unit_test_setup(columns_align_what_follows, begin),
        cmocka_unit_test_setup(every_capacity_is_kept, begin),
        cmocka_unit_test_setup(nothing_follows_a_truncation, begin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
