/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <uchar.h>

#include <cmocka.h>

#include "host/text16.h"

static uint16_t out[64];
static char text[256];

/* Formats and hands back what came out as UTF-8. */
#define FORMATTED(...) formatted(text16_format(out, 64, __VA_ARGS__))
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
        cmocka_unit_test(utf8_is_cut_between_characters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
