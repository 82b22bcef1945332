/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_flat.c - images without a header: what is taken for one, and what is not.
 */
#include "image_open.h"

static struct image *open_named(const char *path, const void *bytes, size_t size)
{
    struct image *image;
    char why[IMAGE_WHY];
    assert_int_equal(image_open_memory(&image, path, bytes, size, why), 0);
    assert_null(image_broken_promise(image));
    return image;
}

static void is_defect(const char *path, const void *bytes, size_t size, const char *text)
{
    struct image *image = open_named(path, bytes, size);
    if (strstr(image->defect, text) == NULL || image->defect[0] == '\0')
        fail_msg("defect is \"%s\", expected \"%s\"", image->defect, text);
    image_close(image);
}

static void flat_image_is_one_piece_at_its_address(void **state)
{
    (void)state;
    struct image *image = open_module("flat.tgm.bin");
    assert_int_equal(image->format, IMAGE_FORMAT_FLAT);
    assert_string_equal(image->format_name, "flat");
    assert_int_equal(image->target, IMAGE_TARGET_ARM);
    assert_int_equal(image->segment_count, 1);
    assert_int_equal(image->segments[0].vaddr, 0x07800000);
    assert_int_equal(image->segments[0].mem_size, image->size);
    assert_int_equal(image->segments[0].file_size, image->size);
    assert_int_equal(image->segments[0].file_offset, 0);
    assert_int_equal(image->segments[0].perm, IMAGE_READ | IMAGE_EXEC);
    assert_int_equal(image->span_begin, 0x07800000);
    assert_true(image->fixed);
    assert_int_equal(image->base, 0);
    assert_true(image->has_entry_point);
    assert_int_equal(image->entry_point, 0x07800000);
    assert_int_equal(image->symbol_count + image->import_count + image->reloc_count, 0);
    image_close(image);
}

/* The built module with an export table of the SDK behind it: count, self, first address and name
 * as given. */
static void with_table(uint8_t bytes[8192], size_t *size, uint32_t self_error, uint32_t count,
                       uint32_t address, const char *name)
{
    struct image *image = open_module("flat.tgm.bin");
    size_t at = (image->size + 3) & ~(size_t)3;
    memset(bytes, 0, 8192);
    memcpy(bytes, image->bytes, image->size);
    image_close(image);
    const uint32_t self = 0x07800000 + (uint32_t)at + self_error;
    memcpy(bytes + at, "TGM-EXPORTS-1", 13);
    memcpy(bytes + at + 16, &self, 4);
    memcpy(bytes + at + 20, &count, 4);
    memcpy(bytes + at + 24, &address, 4);
    memcpy(bytes + at + 28, name, strlen(name));
    *size = at + 40;
}

static void the_sdks_export_table_is_read_and_held_against_the_image(void **state)
{
    static uint8_t bytes[8192];
    size_t size;
    (void)state;
    with_table(bytes, &size, 0, 1, 0x07800004, "Program_Ini");
    struct image *image = open_named("x.bin", bytes, size);
    assert_string_equal(image->defect, "");
    const struct image_symbol *symbol = image_export(image, "Program_Ini");
    assert_non_null(symbol);
    assert_int_equal(symbol->vaddr, 0x07800004);
    assert_true(symbol->executable && !symbol->thumb);
    image_close(image);
    with_table(bytes, &size, 4, 1, 0x07800004, "Program_Ini"); /* lies elsewhere: no table */
    image = open_named("x.bin", bytes, size);
    assert_string_equal(image->defect, "");
    assert_int_equal(image->symbol_count, 0);
    image_close(image);
    with_table(bytes, &size, 0, 2, 0x07800004, "Program_Ini");
    is_defect("x.bin", bytes, size, "there is room for fewer");
    with_table(bytes, &size, 0, 0xFFFFFFFF, 0x07800004, "Program_Ini");
    is_defect("x.bin", bytes, size, "there is room for fewer");
    with_table(bytes, &size, 0, 1, 0x07900000, "Program_Ini");
    is_defect("x.bin", bytes, size, "outside the image");
    with_table(bytes, &size, 0, 1, 0x077ffffc, "Program_Ini");
    is_defect("x.bin", bytes, size, "outside the image");
    with_table(bytes, &size, 0, 1, 0x07800004, "");
    is_defect("x.bin", bytes, size, "without a name");
}

static void name_decides_together_with_the_beginning(void **state)
{
    (void)state;
    struct image *image = open_module("flat.tgm.bin");
    is_defect("module.tgm", image->bytes, image->size, "starts with the bytes");
    is_defect(".bin", image->bytes, image->size, "starts with the bytes");
    is_defect("module.BIN", image->bytes, image->size, "starts with the bytes");
    struct image *other = open_named("TGM_PLC.bin", image->bytes, image->size);
    assert_int_equal(other->format, IMAGE_FORMAT_FLAT);
    assert_string_equal(other->defect, "");
    image_close(other);
    image_close(image);
    image = open_module("six_arm.so");
    other = open_named("six.tgm.bin", image->bytes, image->size);
    assert_int_equal(other->format, IMAGE_FORMAT_ELF32);
    image_close(other);
    image_close(image);
}

static void stamped_files_are_refused(void **state)
{
    (void)state;
    struct image *image = open_module("flat.tgm.bin");
    is_defect("a.tgm_controller", image->bytes, image->size,
              "a .tgm_controller file, and the vendor's stamp is not documented");
    is_defect("a.tgz_motion", image->bytes, image->size,
              "a .tgz_motion file, and the vendor's stamp is not documented");
    image_close(image);
}

static void what_does_not_begin_like_a_function_is_refused(void **state)
{
    (void)state;
    static const struct {
        uint32_t words[4];
        size_t size;
        const char *sentence;
    } files[] = {
        { { 0xe3a00001, 0xe12fff1e }, 8, NULL },              /* mov r0, #1; bx lr */
        { { 0xe92d4010, 0xe8bd8010 }, 8, NULL },              /* push; pop {r4, pc} */
        { { 0xe52de004, 0xe49df004 }, 8, NULL },              /* str lr; ldr pc, [sp], #4 */
        { { 0xe1a0f00e }, 4, NULL },                          /* mov pc, lr */
        { { 0xea000000, 0, 0xe12fff1e }, 12, NULL },          /* b over a word */
        { { 0xe59f0000, 0xe12fff1e, 0x1234 }, 12, NULL },     /* ldr r0, [pc] */
        { { 0xeb000000, 0xe12fff1e, 0xe12fff1e }, 12, NULL }, /* bl */
        { { 0xe1a00000, 0xfa000000, 0xe12fff1e, 0x47704770 }, 16, NULL }, /* blx */
        { { 0xe1a00000, 0xfb000000, 0xe12fff1e }, 12, "the word 0xfb000000 at 0x4" },
        { { 0xe3a00001 }, 3, "starts with the word 0x00000000" },
        { { 0x03a00001, 0xe12fff1e }, 8, "starts with the word 0x03a00001, which is no Arm" },
        { { 0xf57ff05f, 0xe12fff1e }, 8, "starts with the word 0xf57ff05f" },
        { { 0xe3a00001, 0, 0xe12fff1e }, 12, "the word 0x00000000 at 0x4" },
        { { 0xe3a00001, 0xe7f000f0, 0xe12fff1e }, 12, "the word 0xe7f000f0 at 0x4" },
        { { 0xe3a00001, 0xef000000, 0xe12fff1e }, 12, "the word 0xef000000 at 0x4" },
        { { 0xeaffffff }, 4, "the word 0xeaffffff at 0x0" },             /* b past the end */
        { { 0xeafffffd }, 4, "the word 0xeafffffd at 0x0" },             /* b before the start */
        { { 0xeb7fffff, 0xe12fff1e }, 8, "the word 0xeb7fffff at 0x0" }, /* bl far away */
        { { 0xe51f0010, 0xe12fff1e }, 8, "the word 0xe51f0010 at 0x0" }, /* ldr r0, [pc, #-16] */
        { { 0xe59f0004, 0xe12fff1e }, 8, "the word 0xe59f0004 at 0x0" }, /* ldr past the end */
        { { 0xe3a00001, 0xe3a00001 }, 8, "no return instruction in the first" },
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        if (files[i].sentence != NULL) {
            is_defect("a.tgm.bin", files[i].words, files[i].size, files[i].sentence);
            continue;
        }
        struct image *image = open_named("a.tgm.bin", files[i].words, files[i].size);
        if (image->defect[0] != '\0')
            fail_msg("%zu: %s", i, image->defect);
        image_close(image);
    }
    is_defect("a.bin", "", 0, "the file is empty");
    is_defect("a.bin", "hello, controller\n", 18, "this is text");
    is_defect("a.bin", "PK\x03\x04 and so on", 14, "a ZIP archive");
}

static void size_is_limited_by_the_region(void **state)
{
    (void)state;
    uint32_t *words = calloc(1, IMAGE_FLAT_REGION + 1);
    assert_non_null(words);
    words[0] = 0xe12fff1e;
    struct image *image = open_named("a.tgm.bin", words, IMAGE_FLAT_REGION);
    assert_string_equal(image->defect, "");
    assert_int_equal(image->span_end, IMAGE_FLAT_BASE + IMAGE_FLAT_REGION);
    image_close(image);
    is_defect("a.tgm.bin", words, IMAGE_FLAT_REGION + 1,
              "8388609 bytes, a flat image has room for");
    free(words);
}

static void random_bytes_are_no_flat_image(void **state)
{
    (void)state;
    uint64_t random = 88172645463325252u;
    unsigned taken = 0;
    for (unsigned i = 0; i < 100000; i++) {
        uint64_t bytes[64];
        for (unsigned k = 0; k < 64; k++) {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            bytes[k] = random;
        }
        struct image *image = open_named("noise.bin", bytes, sizeof bytes);
        taken += image->defect[0] == '\0';
        image_close(image);
    }
    /* Nothing in the file could tell more: one in a thousand begins like a function. */
    if (taken > 300)
        fail_msg("%u of 100000 random files were taken for flat images", taken);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sdks_export_table_is_read_and_held_against_the_image),
        cmocka_unit_test(flat_image_is_one_piece_at_its_address),
        cmocka_unit_test(name_decides_together_with_the_beginning),
        cmocka_unit_test(stamped_files_are_refused),
        cmocka_unit_test(what_does_not_begin_like_a_function_is_refused),
        cmocka_unit_test(size_is_limited_by_the_region),
        cmocka_unit_test(random_bytes_are_no_flat_image),
    };
    return cmocka_run_group_tests_name("image_flat", tests, NULL, NULL);
}
