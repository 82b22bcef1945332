/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_damage.c - files cut off, spoilt and made up: whatever is done to the bytes, an image
 * keeps its promises (open_bytes() looks), and reading it touches no byte that is not there.
 */
#include "image_open.h"

static void look_at_places(const struct image *image)
{
    struct image_place place;
    static const uint64_t addresses[] = { 0, 0x1000, 0x1234, 0x2000, UINT64_MAX };
    for (size_t i = 0; i < sizeof addresses / sizeof addresses[0]; i++)
        image_where(image, addresses[i], &place);
}

static void cut_everywhere(const void *bytes, size_t size)
{
    for (size_t length = 0; length < size; length++) {
        /* A copy of its own, so that a checking allocator sees the first byte too many. */
        struct image *image = open_bytes(bytes, length);
        assert_true(image->defect[0] != '\0');
        image_close(image);
    }
}

static void module_cut_anywhere_is_a_defect(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    cut_everywhere(&t, sizeof t);
}

static void real_module_cut_anywhere_is_a_defect(void **state)
{
    (void)state;
    struct image *image = open_module("six_relr_lld.so");
    cut_everywhere(image->bytes, image->size);
    image_close(image);
}

static void spoil(uint8_t *bytes, size_t size, size_t begin, size_t end)
{
    static const uint8_t masks[] = { 0x01, 0x02, 0x08, 0x10, 0x7f, 0x80, 0xff };
    for (size_t i = begin; i < end; i++) {
        for (size_t k = 0; k < sizeof masks + 2; k++) {
            uint8_t old = bytes[i];
            bytes[i] = k < sizeof masks ? old ^ masks[k] : k == sizeof masks ? 0 : 0xff;
            struct image *image = open_bytes(bytes, size);
            look_at_places(image);
            image_close(image);
            bytes[i] = old;
        }
    }
}

static void any_byte_of_a_module_may_be_wrong(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    spoil((uint8_t *)&t, sizeof t, 0, sizeof t);
}

static void any_header_byte_of_a_real_module_may_be_wrong(void **state)
{
    (void)state;
    struct image *image = open_module("six_stripped.so");
    uint8_t *bytes = malloc(image->size);
    Elf64_Ehdr eh;
    assert_non_null(bytes);
    memcpy(bytes, image->bytes, image->size);
    memcpy(&eh, bytes, sizeof eh);
    /* Headers, program headers, hash, symbols, strings, relocations: the whole first segment. */
    spoil(bytes, image->size, 0, image->segments[0].file_size);
    for (unsigned i = 0; i < eh.e_phnum; i++) {
        Elf64_Phdr ph;
        memcpy(&ph, bytes + eh.e_phoff + i * sizeof ph, sizeof ph);
        if (ph.p_type == PT_DYNAMIC)
            spoil(bytes, image->size, ph.p_offset, ph.p_offset + ph.p_filesz);
    }
    spoil(bytes, image->size, eh.e_shoff, image->size);
    free(bytes);
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

static void random_bytes_are_no_module(void **state)
{
    (void)state;
    static uint8_t bytes[4096];
    for (unsigned seed = 1; seed <= 2000; seed++) {
        random_state = seed * 0x9e3779b97f4a7c15u;
        for (size_t i = 0; i < sizeof bytes; i++)
            bytes[i] = (uint8_t)(next_random() >> 32);
        if (seed % 2 == 0)
            memcpy(bytes,
                   "\x7f"
                   "ELF\2\1\1\0\0\0\0\0\0\0\0\0\3\0\x3e\0\1\0\0\0",
                   24);
        struct image *image = open_bytes(bytes, next_random() % sizeof bytes);
        assert_true(image->defect[0] != '\0');
        image_close(image);
    }
}

static void many_wrong_bytes_at_once(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 20000; seed++) {
        static struct tiny t;
        tiny_init(&t);
        random_state = seed * 0x9e3779b97f4a7c15u;
        for (unsigned n = 1 + (unsigned)(next_random() % 8); n > 0; n--) {
            /* Mostly past the headers, so that the lie is not found at once. */
            size_t from = next_random() % 4 == 0 ? 0 : offsetof(struct tiny, hash);
            size_t at = from + next_random() % (sizeof t - from);
            ((uint8_t *)&t)[at] = (uint8_t)next_random();
        }
        struct image *image = open_bytes(&t, sizeof t);
        look_at_places(image);
        image_close(image);
    }
}

/* Sections of a module by name: where they are in the file. */
static bool find_section(const struct image *image, const char *name, size_t *begin, size_t *end)
{
    Elf64_Ehdr eh;
    Elf64_Shdr names, sh;
    memcpy(&eh, image->bytes, sizeof eh);
    memcpy(&names, image->bytes + eh.e_shoff + eh.e_shstrndx * sizeof sh, sizeof names);
    for (unsigned i = 0; i < eh.e_shnum; i++) {
        memcpy(&sh, image->bytes + eh.e_shoff + i * sizeof sh, sizeof sh);
        if (strcmp((const char *)image->bytes + names.sh_offset + sh.sh_name, name) == 0) {
            *begin = sh.sh_offset;
            *end = sh.sh_offset + sh.sh_size;
            return true;
        }
    }
    return false;
}

static void debug_information_may_be_wrong(void **state)
{
    (void)state;
    static const char *const modules[] = { "six.so", "six_dwarf4.so", "six_gz.so" };
    static const char *const sections[] = { ".debug_line", ".debug_info", ".debug_abbrev" };
    random_state = 4711;
    for (size_t m = 0; m < 3; m++) {
        struct image *image = open_module(modules[m]);
        uint64_t vaddr = image_export(image, "Program_04")->vaddr;
        for (size_t s = 0; s < 3; s++) {
            size_t begin = 0, end = 0;
            assert_true(find_section(image, sections[s], &begin, &end));
            for (size_t i = begin; i < end; i += 11) {
                struct image_place place;
                uint8_t old = image->bytes[i];
                image->bytes[i] = (uint8_t)next_random();
                struct image *wrong = open_bytes(image->bytes, image->size);
                image_where(wrong, vaddr + 1, &place);
                /* The symbol table was left alone. */
                assert_string_equal(place.function, "Program_04");
                if (place.file != NULL)
                    assert_true(strlen(place.file) < 4096);
                image_close(wrong);
                image->bytes[i] = old;
            }
        }
        image_close(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(module_cut_anywhere_is_a_defect),
        cmocka_unit_test(real_module_cut_anywhere_is_a_defect),
        cmocka_unit_test(any_byte_of_a_module_may_be_wrong),
        cmocka_unit_test(any_header_byte_of_a_real_module_may_be_wrong),
        cmocka_unit_test(random_bytes_are_no_module),
        cmocka_unit_test(many_wrong_bytes_at_once),
        cmocka_unit_test(debug_information_may_be_wrong),
    };
    return cmocka_run_group_tests_name("image_damage", tests, NULL, NULL);
}
