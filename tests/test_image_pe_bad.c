/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_pe_bad.c - PE files that lie, are cut off or spoilt: always one sentence that names
 * the lie, never a byte read that is not there (open_bytes() copies the bytes without a spare one).
 */
#include "image_lies_pe.h"
#include "image_open.h"

static void is_defect(const void *bytes, size_t size, const char *text)
{
    struct image *image = open_bytes(bytes, size);
    if (strstr(image->defect, text) == NULL || image->defect[0] == '\0')
        fail_msg("defect is \"%s\", expected to contain \"%s\"", image->defect, text);
    image_close(image);
}

static void every_lie_is_named(void **state)
{
    (void)state;
    static struct tiny_pe t;
    unsigned wrong = 0;
    for (size_t i = 0; i < 2 * sizeof pe_lies / sizeof pe_lies[0]; i++) {
        tiny_pe_init(&t, i % 2 == 0);
        pe_lies[i / 2].tell(&t);
        struct image *image = open_bytes(t.bytes, TINY_PE_SIZE);
        if (image->defect[0] == '\0' || strstr(image->defect, pe_lies[i / 2].sentence) == NULL) {
            print_error("%s (%s): defect is \"%s\", expected \"%s\"\n", pe_lies[i / 2].name,
                        i % 2 == 0 ? "PE32+" : "PE32", image->defect, pe_lies[i / 2].sentence);
            wrong++;
        }
        image_close(image);
    }
    assert_int_equal(wrong, 0);
}

static void sentence_is_safe_to_print(void **state)
{
    (void)state;
    static struct tiny_pe t;
    tiny_pe_init(&t, true);
    memcpy(t.bytes + PE_STRINGS_AT + 0x10, "\x1b[2J\n", 5);
    pe_put(&t, PE_ORDINALS_AT, 2, 9);
    is_defect(t.bytes, TINY_PE_SIZE, "exports ?[2J?am_01 as function 9 of 5");
}

/* ---- more than fits ---- */

/* The module with a last section that reaches extra bytes past 0x5000, zero but for what a test
 * puts there. */
static struct tiny_pe *new_longer(bool wide, uint32_t extra)
{
    struct tiny_pe *t = calloc(1, sizeof *t);
    uint8_t *bytes = calloc(1, 0x1a00 + (size_t)extra);
    assert_non_null(t);
    assert_non_null(bytes);
    tiny_pe_init(t, wide);
    memcpy(bytes, t->bytes, PE_SYMBOLS_AT);
    t->bytes = bytes;
    pe_put_directory(t, 4, 0, 0);
    pe_put(t, PE_POINTER_TO_SYMBOLS, 4, 0);
    pe_put_section(t, 3, VIRTUAL_SIZE, 0x1000 + extra);
    pe_put_section(t, 3, RAW_SIZE, 0x1000 + extra);
    pe_put(t, PE_SIZE_OF_IMAGE, 4, 0x5000 + ((extra + 0xfff) & ~0xfffu));
    return t;
}

static void free_longer(struct tiny_pe *t)
{
    free(t->bytes);
    free(t);
}

/* Offset in t->bytes of an address in the last section. */
static size_t longer_at(uint32_t vaddr)
{
    return vaddr - 0x4000 + 0xa00;
}

static void is_longer_defect(const struct tiny_pe *t, uint32_t extra, const char *text)
{
    is_defect(t->bytes, 0x1a00 + (size_t)extra, text);
}

static void long_names_are_defects(void **state)
{
    (void)state;
    enum { EXTRA = 0x1000 };
    for (int wide = 0; wide < 2; wide++) {
        struct tiny_pe *t = new_longer(wide != 0, EXTRA);
        memset(t->bytes + longer_at(0x5000), 'a', 1025);
        pe_put(t, PE_NAMES_AT, 4, 0x5000);
        is_longer_defect(t, EXTRA, "export name 0 at 0x5000 is empty");
        t->bytes[longer_at(0x5000 + 1024)] = 0;
        is_longer_defect(t, EXTRA, "export names are not sorted");
        memset(t->bytes + longer_at(0x5000), 'a', EXTRA);
        pe_put(t, PE_NAMES_AT, 4, 0x5ff0);
        is_longer_defect(t, EXTRA, "has no end in its section");
        free_longer(t);
    }
}

static void huge_count_of_imports_is_refused(void **state)
{
    (void)state;
    enum { COUNT = 262144, EXTRA = 4 * COUNT + 0x200 };
    struct tiny_pe *t = new_longer(false, EXTRA);
    for (uint32_t i = 0; i < COUNT; i++)
        pe_put(t, longer_at(0x5000 + 4 * i), 4, 0x80000001);
    pe_put(t, PE_IMPORTS_AT, 4, 0);
    pe_put(t, PE_IMPORTS_AT + 16, 4, 0x5000);
    is_longer_defect(t, EXTRA, "has more than 262144 imports");
    free_longer(t);
}

/* A library with a long name, whose functions all share one: a kilobyte a word. */
static void names_that_grow_beyond_measure_are_refused(void **state)
{
    (void)state;
    enum { COUNT = 20000, EXTRA = (4 * COUNT + 0x7ff) & ~0x1ff };
    struct tiny_pe *t = new_longer(false, EXTRA);
    for (uint32_t i = 0; i < COUNT; i++)
        pe_put(t, longer_at(0x5000 + 4 * i), 4, 0x80000001);
    uint32_t name = 0x5000 + 4 * COUNT + 4;
    memset(t->bytes + longer_at(name), 'x', 1000);
    pe_put(t, PE_IMPORTS_AT, 4, 0);
    pe_put(t, PE_IMPORTS_AT + 12, 4, name);
    pe_put(t, PE_IMPORTS_AT + 16, 4, 0x5000);
    is_longer_defect(t, EXTRA, "names of imports and exports take more than 16 MiB");
    free_longer(t);
}

static void huge_count_of_relocations_is_refused(void **state)
{
    (void)state;
    enum { COUNT = 1048580, EXTRA = ((8 + 2 * COUNT) + 0x1ff) & ~0x1ff };
    struct tiny_pe *t = new_longer(false, EXTRA);
    pe_put(t, longer_at(0x5000), 4, 0x3000);
    pe_put(t, longer_at(0x5004), 4, EXTRA);
    for (uint32_t i = 0; i < COUNT; i++)
        pe_put(t, longer_at(0x5008 + 2 * i), 2, 0x3000);
    pe_put_directory(t, 5, 0x5000, EXTRA);
    is_longer_defect(t, EXTRA, "more than 1048576 relocations");
    free_longer(t);
}

static void huge_count_of_callbacks_is_refused(void **state)
{
    (void)state;
    enum { COUNT = 65537, EXTRA = (4 * COUNT + 0x3ff) & ~0x1ff };
    struct tiny_pe *t = new_longer(false, EXTRA);
    for (uint32_t i = 0; i < COUNT; i++)
        pe_put(t, longer_at(0x5000 + 4 * i), 4, TINY_PE_BASE + 0x1000);
    pe_put_word(t, PE_TLS_AT + 12, TINY_PE_BASE + 0x5000);
    pe_put_directory(t, 5, 0, 0);
    pe_put(t, PE_CHARACTERISTICS, 2, 0x2023);
    is_longer_defect(t, EXTRA, "more than 65536 initialisers");
    free_longer(t);
}

/* ---- damage ---- */

static void cut_everywhere(const uint8_t *bytes, size_t size)
{
    for (size_t length = 0; length < size; length++) {
        struct image *image = open_bytes(bytes, length);
        if (image->defect[0] == '\0')
            fail_msg("cut off at %zu of %zu: no defect", length, size);
        image_close(image);
    }
}

static void module_cut_anywhere_is_a_defect(void **state)
{
    (void)state;
    static struct tiny_pe t;
    for (int wide = 0; wide < 2; wide++) {
        tiny_pe_init(&t, wide != 0);
        cut_everywhere(t.bytes, TINY_PE_SIZE);
    }
}

static void real_module_cut_anywhere_is_a_defect(void **state)
{
    (void)state;
    static const char *const names[] = { "six_lld_i686.dll", "pe_lld_x86_64.dll",
                                         "six_mingw_i686_stripped.dll", "pe_ctors_x86_64.dll" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        cut_everywhere(image->bytes, image->size);
        image_close(image);
    }
}

static void look_at_places(const struct image *image)
{
    struct image_place place;
    static const uint64_t addresses[] = { 0, 0x1000, 0x1234, 0x2000, UINT64_MAX };
    for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++)
        image_where(image, addresses[i], &place);
}

static void spoil(uint8_t *bytes, size_t size, size_t begin, size_t end)
{
    static const uint8_t masks[] = { 0x01, 0x02, 0x08, 0x10, 0x7f, 0x80, 0xff };
    for (size_t i = begin; i < end; i++) {
        for (size_t k = 0; k < sizeof masks + 2; k++) {
            uint8_t old = bytes[i];
            bytes[i] = k < sizeof masks ? old ^ masks[k] : k == sizeof masks ? 0 : 0xff;
            struct image *image = open_bytes(bytes, size);
            if (!image->has_debug_lines)
                look_at_places(image);
            image_close(image);
            bytes[i] = old;
        }
    }
}

static void any_byte_of_a_module_may_be_wrong(void **state)
{
    (void)state;
    static struct tiny_pe t;
    for (int wide = 0; wide < 2; wide++) {
        tiny_pe_init(&t, wide != 0);
        spoil(t.bytes, TINY_PE_SIZE, 0, TINY_PE_SIZE);
    }
}

static void any_byte_of_a_real_module_may_be_wrong(void **state)
{
    (void)state;
    static const char *const names[] = { "pe_lld_i686.dll", "pe_delay_x86_64.dll",
                                         "six_mingw_x86_64_stripped.dll" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        spoil(image->bytes, image->size, 0, image->size);
        image_close(image);
    }
    /* With COFF symbols and debug sections: the headers, then the symbols. */
    struct image *image = open_module("pe_mingw_i686.dll");
    uint32_t symbols;
    memcpy(&symbols, image->bytes + 0x80 + 12, 4);
    assert_in_range(symbols, 0x400, image->size);
    spoil(image->bytes, image->size, 0, 0x400);
    spoil(image->bytes, image->size, symbols, image->size);
    image_close(image);
}

static uint64_t random_state;

static uint64_t next_random(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

static void many_wrong_bytes_at_once(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 40000; seed++) {
        static struct tiny_pe t;
        tiny_pe_init(&t, seed % 2 == 0);
        random_state = seed * 0x9e3779b97f4a7c15u;
        for (unsigned n = 1 + (unsigned)(next_random() % 8); n > 0; n--) {
            /* Mostly past the headers, so that the lie is not found at once. */
            size_t from = next_random() % 8 == 0 ? 0 : PE_RDATA_AT;
            t.bytes[from + next_random() % (TINY_PE_SIZE - from)] = (uint8_t)next_random();
        }
        struct image *image = open_bytes(t.bytes, TINY_PE_SIZE);
        look_at_places(image);
        image_close(image);
    }
}

static void debug_information_may_be_wrong(void **state)
{
    (void)state;
    random_state = 4711;
    struct image *image = open_module("six_mingw_i686.dll");
    uint64_t vaddr = image_export(image, "Program_04")->vaddr;
    for (size_t i = 0x2000; i < image->size; i += 131) {
        struct image_place place;
        uint8_t old = image->bytes[i];
        image->bytes[i] = (uint8_t)next_random();
        struct image *wrong = open_bytes(image->bytes, image->size);
        image_where(wrong, vaddr + 1, &place);
        if (place.file != NULL)
            assert_true(strlen(place.file) < 4096);
        image_close(wrong);
        image->bytes[i] = old;
    }
    image_close(image);
}

/* ---- other kinds of file ---- */

static void what_toolchains_make_besides_modules_is_named(void **state)
{
    (void)state;
    static const char *const names[] = { "pe_exe_x86_64.exe", "pe_exe_i686.exe" };
    for (size_t i = 0; i < 2; i++) {
        struct image *image = open_any_module(names[i]);
        assert_non_null(strstr(image->defect, "a program, not a module"));
        assert_int_equal(image->format, IMAGE_FORMAT_PE);
        image_close(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_lie_is_named),
        cmocka_unit_test(sentence_is_safe_to_print),
        cmocka_unit_test(long_names_are_defects),
        cmocka_unit_test(huge_count_of_imports_is_refused),
        cmocka_unit_test(names_that_grow_beyond_measure_are_refused),
        cmocka_unit_test(huge_count_of_relocations_is_refused),
        cmocka_unit_test(huge_count_of_callbacks_is_refused),
        cmocka_unit_test(module_cut_anywhere_is_a_defect),
        cmocka_unit_test(real_module_cut_anywhere_is_a_defect),
        cmocka_unit_test(any_byte_of_a_module_may_be_wrong),
        cmocka_unit_test(any_byte_of_a_real_module_may_be_wrong),
        cmocka_unit_test(many_wrong_bytes_at_once),
        cmocka_unit_test(debug_information_may_be_wrong),
        cmocka_unit_test(what_toolchains_make_besides_modules_is_named),
    };
    return cmocka_run_group_tests_name("image_pe_bad", tests, NULL, NULL);
}
