/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <uchar.h>

#include <cmocka.h>

#include "host/text16.h"

static uint16_t out[128];
static char text[256];

/* Formats and hands back what came out as UTF-8. */
#define FORMATTED(...) formatted(text16_format(out, 128, __VA_ARGS__))
#define W(literal)     ((const uint16_t *)u##literal)

static int last_result;

static const char *formatted(int result)
{
    last_result = result;
    text16_to_utf8(text, sizeof text, out);
    return text;
}

static void integers_are_formatted_as_windows_does(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("%d|%i|%u"), -5, 7, 3000000000u), "-5|7|3000000000");
    assert_string_equal(FORMATTED(W("%x|%X|%#x|%o"), 255, 255, 255, 8), "ff|FF|0xff|10");
    assert_string_equal(FORMATTED(W("[%5d][%-5d][%05d][%+d]"), 42, 42, -42, 42),
                        "[   42][42   ][-0042][+42]");
    assert_string_equal(FORMATTED(W("%I64d %lld %I64x"), INT64_MIN, INT64_C(-1), UINT64_C(1) << 40),
                        "-9223372036854775808 -1 10000000000");
    assert_string_equal(FORMATTED(W("%hd %hhu"), 65536 + 7, 256 + 9), "7 9");
    assert_string_equal(FORMATTED(W("%#06x"), 255), "0x00ff");
    assert_string_equal(FORMATTED(W("%06.3d"), 5), "   005");
}

static void width_and_precision_may_be_arguments(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("[%*d][%-*d][%.*f]"), 4, 7, 4, 7, 2, 3.14159),
                        "[   7][7   ][3.14]");
    assert_string_equal(FORMATTED(W("[%*d]"), -4, 7), "[7   ]");
}

static void reals_are_formatted(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("%f %.3e %g"), 1.5, 12345.678, 0.0001),
                        "1.500000 1.235e+04 0.0001");
    assert_string_equal(FORMATTED(W("[%08.2f]"), -3.14159), "[-0003.14]");
    assert_string_equal(FORMATTED(W("[%08f]"), __builtin_inf()), "[     inf]");
}

static void strings_are_wide_unless_h_or_capital_s(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("%s|%ls|%hs|%S"), W("wide"), W("too"), "narrow", "also"),
                        "wide|too|narrow|also");
    assert_string_equal(FORMATTED(W("[%5s][%-5s][%.2s]"), W("ab"), W("ab"), W("abc")),
                        "[   ab][ab   ][ab]");
    assert_string_equal(FORMATTED(W("%s"), (void *)0), "(null)");
    assert_string_equal(FORMATTED(W("%c%c%%"), 'A', 0x20AC), "A\xE2\x82\xAC%");
}

static void text_never_passes_the_buffer(void **state)
{
    (void)state;
    for (size_t capacity = 0; capacity < 12; capacity++) {
        uint16_t small[16];
        memset(small, 0xEE, sizeof small);
        const int result = text16_format(small, capacity, W("%s-%d"), W("abcdef"), 123);
        if (capacity < 11)
            assert_int_equal(result, -1);
        else
            assert_int_equal(result, 10);
        if (capacity > 0) {
            size_t length = 0;
            while (small[length] != 0)
                length++;
            assert_true(length < capacity);
        }
        for (size_t i = capacity; i < 16; i++)
            assert_int_equal(small[i], 0xEEEE);
    }
}

static void huge_width_and_precision_end_with_the_buffer(void **state)
{
    (void)state;
    FORMATTED(W("%2000000000d"), 1);
    assert_int_equal(last_result, -1);
    FORMATTED(W("%.99999f"), 1e300);
    assert_int_equal(last_result, -1);
    FORMATTED(W("%.*d"), INT32_MAX, 1);
    assert_int_equal(last_result, -1);
    FORMATTED(W("%*d"), INT32_MIN, 1);
    assert_string_equal(text, "1");
}

static void an_unknown_conversion_stops_and_says_so(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("a%n"), (void *)0), "a");
    assert_int_equal(last_result, -1);
    assert_string_equal(FORMATTED(W("b%")), "b");
    assert_int_equal(last_result, -1);
    assert_string_equal(FORMATTED(W("c%5.2")), "c");
    assert_int_equal(last_result, -1);
}

static void sizes_take_as_many_bits_as_they_say(void **state)
{
    (void)state;
    assert_string_equal(
        FORMATTED(W("%I32d %I64u %Id %zu"), -1, UINT64_MAX, (intptr_t)-2, (size_t)3),
        "-1 18446744073709551615 -2 3");
    assert_string_equal(FORMATTED(W("%ld %lu %jd %td"), -1L, 2ul, INT64_C(-3), (ptrdiff_t)4),
                        "-1 2 -3 4");
    assert_string_equal(FORMATTED(W("%hhd %hu %hx"), 0x1FF, 0x1FFFF, 0x12345), "-1 65535 2345");
    assert_string_equal(FORMATTED(W("%p"), (void *)(uintptr_t)0xABC), "0000000000000ABC");
}

static void every_size_of_text_has_its_kind(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("%ws|%lS|%hS"), W("w"), W("lS"), "hS"), "w|lS|hS");
    assert_string_equal(FORMATTED(W("%lc%wc%lC|%hc%C"), 0x20AC, 0x20AC, 0x20AC, 0x141, 0x142),
                        "\xE2\x82\xAC\xE2\x82\xAC\xE2\x82\xAC|AB");
    assert_string_equal(FORMATTED(W("%hs"), "\xFC"), "\xC3\xBC");
    assert_string_equal(FORMATTED(W("[%5c][%-5c][%05d][%05s][%-05s]"), 'a', 'b', 7, W("x"), W("y")),
                        "[    a][b    ][00007][0000x][y    ]");
}

static void flags_are_those_of_the_language(void **state)
{
    (void)state;
    assert_string_equal(
        FORMATTED(W("[% d][%+ d][%-+5d][% 05d][%#o][%#X][%#x]"), 5, 5, 5, 5, 8, 255, 0),
        "[ 5][+5][+5   ][ 0005][010][0XFF][0]");
    assert_string_equal(FORMATTED(W("[%.0d][%5.0u][%.3x][%+.2d]"), 0, 0, 10, 1),
                        "[][     ][00a][+01]");
    assert_string_equal(FORMATTED(W("[%#.0f][%#g][%g][%G]"), 1.0, 1.0, 1e-10, 1e20),
                        "[1.][1.00000][1e-10][1E+20]");
    assert_string_equal(
        FORMATTED(W("[%a][%.1A][%012.1e][%-10.1f][%+.0e]"), 1.5, -1.5, -2.5, 2.5, 1.0),
        "[0x1.8000000000000p+0][-0X1.8P+0][-00002.5e+00][2.5       ][+1e+00]");
    assert_string_equal(FORMATTED(W("[%020a]"), 1.0), "[0x1.0000000000000p+0]");
}

static double from_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void what_is_no_number_has_its_names(void **state)
{
    (void)state;
    assert_string_equal(FORMATTED(W("%f %+F %e %G"), __builtin_inf(), __builtin_inf(),
                                  -__builtin_inf(), -__builtin_inf()),
                        "inf +INF -inf -INF");
    assert_string_equal(FORMATTED(W("%f %f %F"), from_bits(0x7FF8000000000000),
                                  from_bits(0xFFF8000000000000), from_bits(0x7FF8000000000001)),
                        "nan -nan(ind) NAN");
    assert_string_equal(FORMATTED(W("[%6.1f]"), from_bits(0xFFF8000000000001)), "[  -nan]");
}

static void all_digits_that_are_asked_for_come(void **state)
{
    static uint16_t wide[4096];
    static char narrow[4096], expected[4096];
    (void)state;
    assert_int_equal(text16_format(wide, 4096, W("%.3000f"), 0.1), 3002);
    text16_to_utf8(narrow, sizeof narrow, wide);
    snprintf(expected, sizeof expected, "%.3000f", 0.1);
    assert_string_equal(narrow, expected);
    assert_int_equal(text16_format(wide, 4096, W("%.2000e"), 5e-324), 2007);
    text16_to_utf8(narrow, sizeof narrow, wide);
    snprintf(expected, sizeof expected, "%.2000e", 5e-324);
    assert_string_equal(narrow, expected);
    assert_int_equal(text16_format(wide, 4096, W("%#.1500x|%.1500g"), 255, 0.5), 1502 + 1 + 3);
    text16_to_utf8(narrow, sizeof narrow, wide);
    snprintf(expected, sizeof expected, "%#.1500x|%.1500g", 255u, 0.5);
    assert_string_equal(narrow, expected);
}

static void utf8_is_cut_between_characters(void **state)
{
    (void)state;
    char small[6];
    assert_int_equal(text16_to_utf8(small, sizeof small, W("a\u20AC\u20AC")), 4);
    assert_string_equal(small, "a\xE2\x82\xAC");
    assert_int_equal(text16_to_utf8(text, sizeof text, W("\U0001F600")), 4);
    assert_string_equal(text, "\xF0\x9F\x98\x80");
    const uint16_t lone[] = { 0xD800, 'x', 0xDC00, 0 };
    text16_to_utf8(text, sizeof text, lone);
    assert_string_equal(text, "\xEF\xBF\xBDx\xEF\xBF\xBD");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_are_formatted_as_windows_does),
        cmocka_unit_test(width_and_precision_may_be_arguments),
        cmocka_unit_test(reals_are_formatted),
        cmocka_unit_test(strings_are_wide_unless_h_or_capital_s),
        cmocka_unit_test(text_never_passes_the_buffer),
        cmocka_unit_test(huge_width_and_precision_end_with_the_buffer),
        cmocka_unit_test(an_unknown_conversion_stops_and_says_so),
        cmocka_unit_test(sizes_take_as_many_bits_as_they_say),
        cmocka_unit_test(every_size_of_text_has_its_kind),
        cmocka_unit_test(flags_are_those_of_the_language),
        cmocka_unit_test(what_is_no_number_has_its_names),
        cmocka_unit_test(all_digits_that_are_asked_for_come),
        cmocka_unit_test(utf8_is_cut_between_characters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
