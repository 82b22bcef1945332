/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_arguments.c - the argument cursor in every convention, and the thunks in front of it. */
#include <errno.h>

#include "machine_fixture.h"

#include "host/text16.h"
#include "machine/machine_private.h"

#define W(literal) ((const uint16_t *)u##literal)

static char text[256];

static const char *formatted(const uint16_t *format, struct arguments *arguments)
{
    uint16_t out[128];
    text16_vformat(out, COUNT(out), format, arguments);
    text16_to_utf8(text, sizeof text, out);
    return text;
}

/* --- lists that the compiler made --- */

/* More of each kind than there are registers for. */
#define MANY_FORMAT                                                                                \
    W("%d %u %hd %hhx %lld %f %s %hs %c %g %e %lld %d %x %.1f %.1f %.1f %.1f %.1f %.1f %.1f %d")
#define MANY                                                                                       \
    -1, 4000000000u, (short)-2, (unsigned char)254, -5000000000ll, 1.5, W("\u20acw"), "bytes",     \
        (int)u'\u0159', 0.25, 1e10, 0x7edcba9876543210ll, -7, 0xabcu, 1.0, 2.0, 3.0, 4.0, 5.0,     \
        6.0, 7.0, 42
#define MANY_TEXT                                                                                  \
    "-1 4000000000 -2 fe -5000000000 1.500000 \u20acw bytes \u0159 0.25 1.000000e+10 "             \
    "9141386507638288912 -7 abc 1.0 2.0 3.0 4.0 5.0 6.0 7.0 42"

static const char *of_sysv(const uint16_t *format, ...)
{
    struct arguments arguments;
    va_list list;
    va_start(list, format);
    arguments_from_list(&arguments, list);
    const char *result = formatted(format, &arguments);
    va_end(list);
    return result;
}

static __attribute__((ms_abi)) const char *of_win64(const uint16_t *format, ...)
{
    struct arguments arguments;
    __builtin_ms_va_list list;
    __builtin_ms_va_start(list, format);
    arguments_from_win64(&arguments, (const void *)list);
    const char *result = formatted(format, &arguments);
    __builtin_ms_va_end(list);
    return result;
}

static void a_list_of_this_processor_is_read_to_its_end(void **state)
{
    (void)state;
    assert_string_equal(of_sysv(MANY_FORMAT, MANY), MANY_TEXT);
    assert_string_equal(of_sysv(W("%ld %lu"), -3000000000l, 5000000000ul),
                        "-3000000000 5000000000");
    assert_string_equal(of_sysv(W("%p"), (void *)0x12345), "0000000000012345");
}

static void a_list_of_windows_is_read_to_its_end(void **state)
{
    (void)state;
    assert_string_equal(of_win64(MANY_FORMAT, MANY), MANY_TEXT);
    /* `long` has 32 bits there: the upper half of its slot means nothing. */
    assert_string_equal(of_win64(W("%ld %lu %d"), 0x12345678fffffffell, 0x12345678ffffffffll, 9),
                        "-2 4294967295 9");
    assert_string_equal(of_win64(W("%p"), (void *)0x12345), "0000000000012345");
}

/* --- memory as a 32-bit compiler leaves it --- */

static uint32_t low(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint32_t)bits;
}

static uint32_t high(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint32_t)(bits >> 32);
}

static void cdecl_takes_four_bytes_and_wide_ones_eight_without_a_gap(void **state)
{
    (void)state;
    const uint32_t stack[] = { (uint32_t)-1, low(1.5),   high(1.5),   (uint32_t)-3,
                               0x9abcdef0,   0x12345678, 0xfffe,      7,
                               0xdeadbee,    low(-2.25), high(-2.25), 5 };
    struct arguments arguments;
    arguments_from_cdecl(&arguments, stack);
    assert_string_equal(formatted(W("%d %g %ld %I64x %hd %zu %p %g %u"), &arguments),
                        "-1 1.5 -3 123456789abcdef0 -2 7 0DEADBEE -2.25 5");
}

static void aapcs_has_four_registers_and_keeps_wide_ones_even(void **state)
{
    (void)state;
    /* f(format, %d, %g, ...): the real would begin at r2, which is even. */
    const uint32_t registers[4] = { 0, 11, low(1.5), high(1.5) };
    _Alignas(8) const uint32_t stack[] = { 12,         0, low(-2.25), high(-2.25),  13,
                                           0xcccccccc, 1, 2,          (uint32_t)-14 };
    struct arguments arguments;
    arguments_from_aapcs(&arguments, registers, stack);
    arguments_pointer(&arguments);
    assert_string_equal(formatted(W("%d %g %d %g %d %I64x %ld"), &arguments),
                        "11 1.5 12 -2.25 13 200000001 -14");
}

static void aapcs_leaves_a_register_out_rather_than_split_a_wide_one(void **state)
{
    (void)state;
    /* f(severity, format, %d, %g, %d): r3 stays empty, and is not used by what comes later. */
    const uint32_t registers[4] = { 1, 0, 21, 0xcccccccc };
    _Alignas(8) const uint32_t stack[] = { low(1.5), high(1.5), 22 };
    struct arguments arguments;
    arguments_from_aapcs(&arguments, registers, stack);
    assert_int_equal(arguments_u32(&arguments), 1);
    arguments_pointer(&arguments);
    assert_string_equal(formatted(W("%d %g %d"), &arguments), "21 1.5 22");

    /* f(severity, format, %g): r2 and r3. */
    const uint32_t others[4] = { 1, 0, low(2.5), high(2.5) };
    arguments_from_aapcs(&arguments, others, stack);
    arguments_u32(&arguments);
    arguments_pointer(&arguments);
    assert_true(arguments_f64(&arguments) == 2.5);
    assert_true(arguments_f64(&arguments) == 1.5);
    assert_int_equal(arguments_u32(&arguments), 22);
}

static void what_a_pointer_and_a_long_take(void **state)
{
    static const struct {
        enum arguments_convention convention;
        size_t pointer, of_long;
    } rows[] = { { ARGUMENTS_SYSV, 8, 8 },
                 { ARGUMENTS_WIN64, 8, 4 },
                 { ARGUMENTS_CDECL, 4, 4 },
                 { ARGUMENTS_AAPCS, 4, 4 } };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        assert_int_equal(arguments_pointer_bytes(rows[i].convention), rows[i].pointer);
        assert_int_equal(arguments_long_bytes(rows[i].convention), rows[i].of_long);
    }
}

static void the_convention_follows_from_format_and_processor(void **state)
{
    static const struct {
        enum image_format format;
        enum image_target target;
        enum arguments_convention convention;
    } rows[] = { { IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, ARGUMENTS_SYSV },
                 { IMAGE_FORMAT_PE, IMAGE_TARGET_X86_64, ARGUMENTS_WIN64 },
                 { IMAGE_FORMAT_PE, IMAGE_TARGET_I386, ARGUMENTS_CDECL },
                 { IMAGE_FORMAT_ELF32, IMAGE_TARGET_ARM, ARGUMENTS_AAPCS },
                 { IMAGE_FORMAT_FLAT, IMAGE_TARGET_ARM, ARGUMENTS_AAPCS } };
    (void)state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct image image = { .format = rows[i].format, .target = rows[i].target };
        assert_int_equal(arguments_convention_of(&image), rows[i].convention);
    }
}

static void behind_the_last_of_given_values_comes_zero(void **state)
{
    static const uint64_t values[] = { 5, UINT64_MAX };
    struct arguments arguments;
    (void)state;
    arguments_from_values(&arguments, values, COUNT(values));
    assert_string_equal(formatted(W("%d %lld %d %s %g"), &arguments), "5 -1 0 (null) 0");
}

/* --- thunks --- */

static int64_t format_service(void *context, struct arguments *arguments)
{
    uint16_t out[128];
    const uint16_t *format = arguments_pointer(arguments);
    text16_vformat(out, COUNT(out), format, arguments);
    text16_to_utf8(context, sizeof text, out);
    __asm__ volatile("pxor %%xmm6, %%xmm6; pxor %%xmm15, %%xmm15" ::: "xmm6", "xmm15");
    return -0x123456789abcdef;
}

static void *serve(struct fixture *fixture, enum arguments_convention convention)
{
    const struct machine_config config = { .seed = 1 };
    char why[MACHINE_WHY];
    void *function;
    fixture_open(fixture, "faults", &config);
    fixture->machine->convention = convention;
    memset(text, 0, sizeof text);
    for (int i = 0; i < 3; i++) /* not the first row */
        if (machine_service(fixture->machine, "format", format_service, text, &function, why) != 0)
            fail_msg("%s", why);
    return function;
}

static void a_service_gets_arguments_of_this_processor(void **state)
{
    struct fixture fixture;
    int64_t (*function)(const uint16_t *, ...) = serve(&fixture, ARGUMENTS_SYSV);
    (void)state;
    assert_true(function(MANY_FORMAT, MANY) == -0x123456789abcdef);
    assert_string_equal(text, MANY_TEXT);
    fixture_close(&fixture);
}

static void a_service_gets_arguments_of_windows(void **state)
{
    struct fixture fixture;
    int64_t __attribute__((ms_abi)) (*function)(const uint16_t *, ...) =
        serve(&fixture, ARGUMENTS_WIN64);
    (void)state;
    assert_true(function(MANY_FORMAT, MANY) == -0x123456789abcdef);
    assert_string_equal(text, MANY_TEXT);
    fixture_close(&fixture);
}

/* The host's functions may use them; for a function of Windows they are the caller's. */
static void a_service_keeps_what_windows_calls_the_callers(void **state)
{
    struct fixture fixture;
    void *function = serve(&fixture, ARGUMENTS_WIN64);
    uint64_t rdi = 0x1111, rsi = 0x2222, xmm6 = 0x3333, xmm15 = 0x4444;
    (void)state;
    __asm__ volatile("movq %[a], %%xmm6\n\t"
                     "movq %[b], %%xmm15\n\t"
                     "mov %%rsp, %%rbx\n\t"
                     "sub $256, %%rsp\n\t"
                     "and $-16, %%rsp\n\t"
                     "call *%%rax\n\t"
                     "mov %%rbx, %%rsp\n\t"
                     "movq %%xmm6, %[a]\n\t"
                     "movq %%xmm15, %[b]"
                     : "+D"(rdi), "+S"(rsi), [a] "+r"(xmm6), [b] "+r"(xmm15), "+a"(function)
                     : "c"(W("ok"))
                     : "rbx", "rdx", "r8", "r9", "r10", "r11", "xmm0", "xmm1", "xmm2", "xmm3",
                       "xmm4", "xmm5", "xmm6", "xmm15", "memory", "cc");
    assert_string_equal(text, "ok");
    assert_int_equal(rdi, 0x1111);
    assert_int_equal(rsi, 0x2222);
    assert_int_equal(xmm6, 0x3333);
    assert_int_equal(xmm15, 0x4444);
    fixture_close(&fixture);
}

static void a_machine_takes_so_many_services_and_no_more(void **state)
{
    const struct machine_config config = { .seed = 1 };
    struct fixture fixture;
    char why[MACHINE_WHY];
    void *function, *last = NULL;
    (void)state;
    fixture_open(&fixture, "faults", &config);
    for (int i = 0; i < MACHINE_SERVICES; i++) {
        assert_int_equal(
            machine_service(fixture.machine, "format", format_service, text, &function, why), 0);
        assert_ptr_not_equal(function, last);
        last = function;
    }
    assert_int_equal(
        machine_service(fixture.machine, "one more", format_service, text, &function, why),
        -ENOSPC);
    assert_string_equal(why, "one more: more than 32 services");
    fixture_close(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_list_of_this_processor_is_read_to_its_end),
        cmocka_unit_test(a_list_of_windows_is_read_to_its_end),
        cmocka_unit_test(cdecl_takes_four_bytes_and_wide_ones_eight_without_a_gap),
        cmocka_unit_test(aapcs_has_four_registers_and_keeps_wide_ones_even),
        cmocka_unit_test(aapcs_leaves_a_register_out_rather_than_split_a_wide_one),
        cmocka_unit_test(what_a_pointer_and_a_long_take),
        cmocka_unit_test(the_convention_follows_from_format_and_processor),
        cmocka_unit_test(behind_the_last_of_given_values_comes_zero),
        cmocka_unit_test(a_service_gets_arguments_of_this_processor),
        cmocka_unit_test(a_service_gets_arguments_of_windows),
        cmocka_unit_test(a_service_keeps_what_windows_calls_the_callers),
        cmocka_unit_test(a_machine_takes_so_many_services_and_no_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
