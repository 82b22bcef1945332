/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SDK's memory functions against the C library's, at every size and offset around the word size. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define memcpy  sdk_memcpy
#define memmove sdk_memmove
#define memset  sdk_memset
#define memcmp  sdk_memcmp
#include "../sdk/src/mem.c"
#undef memcpy
#undef memmove
#undef memset
#undef memcmp

#define SIZE 96
#define MOST 40

static unsigned char ours[SIZE], theirs[SIZE], source[SIZE];

static void fill(unsigned char *at, unsigned from)
{
    for (unsigned i = 0; i < SIZE; i++)
        at[i] = (unsigned char)(from + i * 37u);
}

/* fill() once for all: each test compares whole arrays, so a byte written outside is seen. */
static void prepare(void)
{
    fill(ours, 1);
    fill(theirs, 1);
    fill(source, 99);
}

static void memcpy_copies(void **state)
{
    (void)state;
    for (size_t size = 0; size <= MOST; size++)
        for (size_t to = 0; to < 9; to++)
            for (size_t from = 0; from < 9; from++) {
                prepare();
                assert_ptr_equal(sdk_memcpy(ours + to, source + from, size), ours + to);
                memcpy(theirs + to, source + from, size);
                assert_memory_equal(ours, theirs, SIZE);
            }
}

static void memmove_moves_over_itself_both_ways(void **state)
{
    (void)state;
    for (size_t size = 0; size <= MOST; size++)
        for (size_t to = 0; to < 24; to++)
            for (size_t from = 0; from < 24; from++) {
                prepare();
                assert_ptr_equal(sdk_memmove(ours + to, ours + from, size), ours + to);
                memmove(theirs + to, theirs + from, size);
                assert_memory_equal(ours, theirs, SIZE);
            }
}

static void memset_takes_the_low_byte(void **state)
{
    static const int values[] = { 0, 1, 0x7F, 0x80, 0xFF, -1, 0x1234 };
    (void)state;
    for (size_t v = 0; v < sizeof values / sizeof values[0]; v++)
        for (size_t size = 0; size <= MOST; size++)
            for (size_t to = 0; to < 9; to++) {
                prepare();
                assert_ptr_equal(sdk_memset(ours + to, values[v], size), ours + to);
                memset(theirs + to, values[v], size);
                assert_memory_equal(ours, theirs, SIZE);
            }
}

static void memcmp_orders_by_the_first_difference_unsigned(void **state)
{
    (void)state;
    for (size_t size = 0; size <= MOST; size++)
        for (size_t at = 0; at < size; at++) {
            prepare();
            assert_int_equal(sdk_memcmp(ours, theirs, size), 0);
            ours[at] = 0x80;
            theirs[at] = 0x7F;
            ours[size] = 0; /* behind the end: must not count */
            theirs[size] = 0xFF;
            assert_true(sdk_memcmp(ours, theirs, size) > 0);
            assert_true(sdk_memcmp(theirs, ours, size) < 0);
            assert_int_equal(sdk_memcmp(ours, theirs, at), 0);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memcpy_copies),
        cmocka_unit_test(memmove_moves_over_itself_both_ways),
        cmocka_unit_test(memset_takes_the_low_byte),
        cmocka_unit_test(memcmp_orders_by_the_first_difference_unsigned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
