/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_bad.c - files that lie or are something else: always one sentence that names the lie.
 */
#include "image_lies.h"
#include "image_open.h"

static void is_defect(const void *bytes, size_t size, const char *text)
{
    struct image *image = open_bytes(bytes, size);
    if (strstr(image->defect, text) == NULL)
        fail_msg("defect is \"%s\", expected to contain \"%s\"", image->defect, text);
    image_close(image);
}

/* ---- one lie each ---- */

static void every_lie_is_named(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof elf_lies / sizeof elf_lies[0]; i++) {
        static struct tiny t;
        tiny_init(&t);
        elf_lies[i].tell(&t);
        struct image *image = open_bytes(&t, sizeof t);
        if (image->defect[0] == '\0' || strstr(image->defect, elf_lies[i].sentence) == NULL)
            fail_msg("%s: defect is \"%s\", expected \"%s\"", elf_lies[i].name, image->defect,
                     elf_lies[i].sentence);
        image_close(image);
    }
}

static void sentence_is_safe_to_print(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    memcpy(t.dynstr + t.dynsym[TINY_01].st_name, "\x1b[2J\n\xc3\xa4", 7);
    t.dynsym[TINY_01].st_size = UINT64_MAX;
    is_defect(&t, sizeof t, "dynamic symbol ?[2J???_01: ");
}

/* ---- more than fits ---- */

#define EXTRA (0x4000 + sizeof(struct tiny))

/* The built-in module with a fourth segment, at EXTRA, of extra bytes that start as zero. */
static struct tiny *new_longer(size_t extra)
{
    struct tiny *t = calloc(1, sizeof *t + extra);
    assert_non_null(t);
    tiny_init(t);
    t->ph[TINY_SPARE] = (Elf64_Phdr){ .p_type = PT_LOAD,
                                      .p_flags = PF_R | PF_W,
                                      .p_offset = sizeof *t,
                                      .p_vaddr = EXTRA,
                                      .p_filesz = extra,
                                      .p_memsz = extra,
                                      .p_align = 0x1000 };
    return t;
}

static void long_name_is_a_defect(void **state)
{
    (void)state;
    struct tiny *t = new_longer(1200);
    memset(t + 1, 'a', 1199);
    DYN(DT_STRTAB) = EXTRA;
    DYN(DT_STRSZ) = 1200;
    is_defect(t, sizeof *t + 1200, "longer than 1024");
    free(t);
}

static void huge_count_of_relocations_is_refused_quickly(void **state)
{
    (void)state;
    /* One address, then bitmaps: each 8 bytes of file ask for 63 relocations. */
    enum { SIZE = 8 * 20000 };
    struct tiny *t = new_longer(SIZE);
    uint64_t *relr = (uint64_t *)(t + 1);
    t->ph[TINY_SPARE].p_memsz = 0x8000000;
    memset(relr, 0xff, SIZE);
    relr[0] = EXTRA;
    DYN(DT_RELR) = EXTRA;
    DYN(DT_RELRSZ) = SIZE;
    is_defect(t, sizeof *t + SIZE, "more than 1048576 relocations");
    free(t);
}

static void huge_count_of_initialisers_is_refused(void **state)
{
    (void)state;
    enum { SIZE = 8 * 65537 };
    struct tiny *t = new_longer(SIZE);
    DYN(DT_FINI_ARRAY) = EXTRA;
    DYN(DT_FINI_ARRAYSZ) = SIZE;
    is_defect(t, sizeof *t + SIZE, "more than 65536 initialisers");
    free(t);
}

static void huge_count_of_libraries_is_refused(void **state)
{
    (void)state;
    enum { COUNT = 262144, SIZE = (COUNT + 40) * sizeof(Elf64_Dyn) };
    struct tiny *t = new_longer(SIZE);
    Elf64_Dyn *dyn = (Elf64_Dyn *)(t + 1);
    memcpy(dyn + COUNT, t->dyn, sizeof t->dyn);
    for (size_t i = 0; i < COUNT; i++)
        dyn[i] = (Elf64_Dyn){ DT_NEEDED, { DYN(DT_NEEDED) } };
    t->ph[TINY_DYNAMIC].p_offset = sizeof *t;
    t->ph[TINY_DYNAMIC].p_vaddr = EXTRA;
    t->ph[TINY_DYNAMIC].p_filesz = t->ph[TINY_DYNAMIC].p_memsz = SIZE;
    is_defect(t, sizeof *t + SIZE, "more than 262144 imports");
    free(t);
}

static void chain_to_the_end_of_the_segment_is_a_defect(void **state)
{
    (void)state;
    struct tiny *t = new_longer(256);
    memcpy(t + 1, t->gnu_header, offsetof(struct tiny, chain) - offsetof(struct tiny, gnu_header));
    DYN(DT_GNU_HASH) = EXTRA;
    is_defect(t, sizeof *t + 256, "DT_GNU_HASH: the chain of symbol 3 has no end");
    free(t);
}

/* ---- other kinds of file ---- */

static void other_files_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *bytes;
        size_t size;
        const char *sentence;
    } files[] = {
        { "", 0, "the file is empty" },
        { "#!/bin/sh\necho\n", 15, "this is text, not a module" },
        { "gr\xc3\xbc\xc3\x9f dich\n", 12, "this is text, not a module" },
        { "\xff\xfeh\0i\0", 6, "this is text, not a module" },
        { "\x7f"
          "E",
          2, "too short: 2 bytes, the ELF header alone takes 64" },
        { "\x7f"
          "ELF\2\1\1",
          7, "too short: 7 bytes" },
        { "\x01\x02\x03", 3, "starts with the bytes 01 02 03; a module starts with 7f 45 4c 46" },
        { "MZ", 2, "holds no PE header" },
        { "!<arch>\nabc", 11, "a static library" },
        { "PK\x03\x04"
          "abcd",
          8, "a ZIP archive" },
        { "\x1f\x8b\x08\0", 4, "gzip-compressed" },
        { "BC\xc0\xde\1\2", 6, "LLVM bitcode" },
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        is_defect(files[i].bytes, files[i].size, files[i].sentence);
}

static void pe_header_outside_the_file_is_no_pe(void **state)
{
    (void)state;
    static const uint32_t offsets[] = { 0, 0x3f, 0x69, 0x80, UINT32_MAX };
    uint8_t file[0x80] = "MZ";
    for (size_t i = 0; i < sizeof offsets / sizeof offsets[0]; i++) {
        memcpy(file + 0x3c, &offsets[i], 4);
        is_defect(file, sizeof file, "holds no PE header");
    }
    memcpy(file + 0x3c, &(uint32_t){ 0x68 }, 4);
    memcpy(file + 0x68, "PE\0\0\x4c\x01", 6);
    is_defect(file, sizeof file, "lack IMAGE_FILE_EXECUTABLE_IMAGE");
}

static void what_toolchains_make_besides_modules_is_named(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum image_format format;
        enum image_target target;
        const char *sentence;
    } files[] = {
        { "six.o", IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, "an object file, not a module" },
        { "six_exec", IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, "an executable, not a module" },
        { "six_pie", IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, "a position-independent executable" },
        { "six_i386.so", IMAGE_FORMAT_ELF32, IMAGE_TARGET_I386, "a 32-bit little-endian ELF" },
    };
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        struct image *image = open_any_module(files[i].name);
        assert_non_null(strstr(image->defect, files[i].sentence));
        assert_int_equal(image->format, files[i].format);
        assert_int_equal(image->target, files[i].target);
        image_close(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_lie_is_named),
        cmocka_unit_test(sentence_is_safe_to_print),
        cmocka_unit_test(long_name_is_a_defect),
        cmocka_unit_test(other_files_are_named),
        cmocka_unit_test(pe_header_outside_the_file_is_no_pe),
        cmocka_unit_test(what_toolchains_make_besides_modules_is_named),
        cmocka_unit_test(huge_count_of_relocations_is_refused_quickly),
        cmocka_unit_test(huge_count_of_initialisers_is_refused),
        cmocka_unit_test(huge_count_of_libraries_is_refused),
        cmocka_unit_test(chain_to_the_end_of_the_segment_is_a_defect),
    };
    return cmocka_run_group_tests_name("image_bad", tests, NULL, NULL);
}
