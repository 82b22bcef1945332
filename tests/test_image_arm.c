/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_arm.c - ELF32 modules for Arm as gcc, clang, bfd and lld make them, whole and spoilt.
 */
#include "image_open.h"

static const char *const entries[] = { "Program_Ini", "Program_01", "Program_02",
                                       "Program_03",  "Program_04", "Program_05" };

static const char *const six[] = { "six_arm.so", "six_arm_lld.so", "six_arm_relr.so",
                                   "six_thumb.so" };

static void every_linker_exports_the_six(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof six / sizeof six[0]; i++) {
        struct image *image = open_module(six[i]);
        size_t exported = 0;
        assert_int_equal(image->format, IMAGE_FORMAT_ELF32);
        assert_string_equal(image->format_name, "ELF32");
        assert_int_equal(image->target, IMAGE_TARGET_ARM);
        assert_string_equal(image->target_name, "Arm");
        for (size_t k = 0; k < image->symbol_count; k++)
            exported += image->symbols[k].exported;
        assert_int_equal(exported, 6);
        for (size_t k = 0; k < 6; k++) {
            const struct image_symbol *entry = image_export(image, entries[k]);
            assert_int_equal(entry->kind, IMAGE_SYMBOL_FUNC);
            assert_true(entry->executable);
            assert_true(entry->size > 0);
            assert_int_equal(entry->vaddr % 2, 0);
            assert_int_equal(entry->thumb, strcmp(six[i], "six_thumb.so") == 0);
        }
        assert_int_equal(image->import_count, 0);
        assert_int_equal(image->initialiser_count, 0);
        assert_false(image->has_tls || image->exec_stack || image->has_entry_point || image->fixed);
        assert_int_equal(image->base, 0);
        image_close(image);
    }
}

/* table[] of image_six.c: five pointers, in DT_REL or DT_RELR, whose addends stand in the words. */
static void every_linker_relocates_the_table(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof six / sizeof six[0]; i++) {
        struct image *image = open_module(six[i]);
        uint64_t table = symbol(image, "table")->vaddr, zeroed = symbol(image, "zeroed")->vaddr;
        unsigned found = 0;
        for (size_t k = 0; k < image->reloc_count; k++) {
            const struct image_reloc *r = &image->relocs[k];
            assert_int_equal(r->kind, IMAGE_RELOC_RELATIVE);
            assert_string_equal(r->type_name, "R_ARM_RELATIVE");
            assert_int_equal(r->type, 23);
            assert_int_equal(r->width, 4);
            if (r->vaddr < table || r->vaddr >= table + 20)
                continue;
            assert_int_equal(r->vaddr, table + 4 * found);
            assert_int_equal(r->addend, found == 0 ? symbol(image, "counter")->vaddr
                                                   : zeroed + 4 * (found - 1));
            found++;
        }
        assert_int_equal(found, 5);
        image_close(image);
    }
}

static void mapping_symbols_are_no_names(void **state)
{
    (void)state;
    struct image *image = open_module("six_arm.so");
    for (size_t i = 0; i < image->symbol_count; i++)
        assert_true(image->symbols[i].name[0] != '$');
    assert_true(symbol(image, "local_function")->size > 0);
    image_close(image);
}

static void start_module_has_everything_a_loader_would_do(void **state)
{
    (void)state;
    struct image *image = open_module("start_arm.so");
    size_t counts[IMAGE_RELOC_OTHER + 1] = { 0 };
    for (size_t i = 0; i < image->reloc_count; i++)
        counts[image->relocs[i].kind]++;
    assert_true(counts[IMAGE_RELOC_TLS] > 0);
    assert_true(counts[IMAGE_RELOC_SYMBOLIC] > 0);
    assert_true(image->has_tls);
    assert_int_equal(image->tls_size, 8);
    assert_int_equal(image_export(image, "exported_per_thread")->kind, IMAGE_SYMBOL_TLS);
    assert_int_equal(image_export(image, "picked")->kind, IMAGE_SYMBOL_IFUNC);
    assert_int_equal(import(image, "somewhere_else")->kind, IMAGE_IMPORT_SYMBOL);
    assert_int_equal(import(image, "perhaps")->kind, IMAGE_IMPORT_WEAK);
    assert_int_equal(initialiser(image, "DT_INIT_ARRAY", 0)->vaddr,
                     symbol(image, "constructor")->vaddr);
    assert_int_equal(initialiser(image, "DT_FINI_ARRAY", 0)->vaddr,
                     symbol(image, "destructor")->vaddr);
    image_close(image);
}

static void lines_are_found(void **state)
{
    (void)state;
    if (under_valgrind())
        skip();
    for (size_t i = 0; i < sizeof six / sizeof six[0]; i++) {
        struct image *image = open_module(six[i]);
        struct image_place place;
        assert_true(image->has_debug_lines);
        image_where(image, symbol(image, "local_function")->vaddr, &place);
        assert_string_equal(place.function, "local_function");
        assert_string_equal(place.file, "tests/modules/image_six.c");
        assert_int_equal(place.line, 12);
        image_close(image);
    }
}

/* ---- lies that only this class can tell ---- */

static void is_defect(const char *name, size_t at, unsigned width, uint32_t value, const char *text)
{
    struct image *image = open_module(name);
    memcpy(image->bytes + at, &value, width);
    struct image *wrong = open_bytes(image->bytes, image->size);
    if (strstr(wrong->defect, text) == NULL)
        fail_msg("defect is \"%s\", expected \"%s\"", wrong->defect, text);
    image_close(wrong);
    image_close(image);
}

/* Where the first PT_LOAD stands. */
static size_t first_load(const char *name)
{
    struct image *image = open_module(name);
    size_t at = sizeof(Elf32_Ehdr);
    Elf32_Phdr ph;
    for (memcpy(&ph, image->bytes + at, sizeof ph); ph.p_type != PT_LOAD;
         memcpy(&ph, image->bytes + at, sizeof ph))
        at += sizeof ph;
    image_close(image);
    return at;
}

static void headers_that_lie_are_named(void **state)
{
    (void)state;
    static const struct {
        size_t at;
        unsigned width;
        uint32_t value;
        const char *sentence;
    } lies[] = {
        { EI_CLASS, 1, ELFCLASS64, "a 64-bit little-endian ELF file for Arm" },
        { EI_DATA, 1, ELFDATA2MSB, "a 32-bit big-endian ELF file" },
        { offsetof(Elf32_Ehdr, e_machine), 2, EM_386, "a 32-bit little-endian ELF file for i386" },
        { offsetof(Elf32_Ehdr, e_machine), 2, EM_X86_64, "ELF file for x86-64 (e_machine 62)" },
        { offsetof(Elf32_Ehdr, e_type), 2, ET_EXEC, "an executable, not a module" },
        { offsetof(Elf32_Ehdr, e_flags), 4, 0x04000000,
          "Arm EABI version (e_flags 0x4000000) is 4" },
        { offsetof(Elf32_Ehdr, e_flags), 4, 0x05800000, "big-endian Arm data" },
        { offsetof(Elf32_Ehdr, e_ehsize), 2, 64, "(e_ehsize) is 64, allowed is 52" },
        { offsetof(Elf32_Ehdr, e_phentsize), 2, 56, "(e_phentsize) is 56, allowed is 32" },
        { offsetof(Elf32_Ehdr, e_shentsize), 2, 64, "(e_shentsize) is 64, allowed is 40" },
        { offsetof(Elf32_Ehdr, e_phoff), 4, UINT32_MAX, "program header table (e_phoff" },
        { offsetof(Elf32_Ehdr, e_shoff), 4, UINT32_MAX, "section header table (e_shoff" },
    };
    for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++)
        is_defect("six_arm.so", lies[i].at, lies[i].width, lies[i].value, lies[i].sentence);
    size_t load = first_load("six_arm.so");
    is_defect("six_arm.so", load + offsetof(Elf32_Phdr, p_memsz), 4, UINT32_MAX,
              "runs past the end of the address space");
    is_defect("six_arm.so", load + offsetof(Elf32_Phdr, p_vaddr), 4, 0xfffff000,
              "runs past the end of the address space");
}

/* ---- damage ---- */

static void module_cut_anywhere_is_a_defect(void **state)
{
    (void)state;
    struct image *image = open_module("six_arm_relr.so");
    for (size_t length = 0; length < image->size; length++) {
        struct image *cut = open_bytes(image->bytes, length);
        assert_true(cut->defect[0] != '\0');
        image_close(cut);
    }
    image_close(image);
}

static void spoil(struct image *image, size_t begin, size_t end)
{
    static const uint8_t masks[] = { 0x01, 0x02, 0x08, 0x10, 0x7f, 0x80, 0xff };
    for (size_t i = begin; i < end; i++) {
        for (size_t k = 0; k < sizeof masks + 2; k++) {
            uint8_t old = image->bytes[i];
            image->bytes[i] = k < sizeof masks ? old ^ masks[k] : k == sizeof masks ? 0 : 0xff;
            image_close(open_bytes(image->bytes, image->size));
            image->bytes[i] = old;
        }
    }
}

static void any_byte_that_a_loader_reads_may_be_wrong(void **state)
{
    (void)state;
    static const char *const names[] = { "six_thumb.so", "six_arm_relr.so", "start_arm.so" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        Elf32_Ehdr eh;
        memcpy(&eh, image->bytes, sizeof eh);
        for (size_t k = 0; k < image->segment_count; k++)
            spoil(image, image->segments[k].file_offset,
                  image->segments[k].file_offset + image->segments[k].file_size);
        spoil(image, eh.e_shoff, image->size);
        image_close(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_linker_exports_the_six),
        cmocka_unit_test(every_linker_relocates_the_table),
        cmocka_unit_test(mapping_symbols_are_no_names),
        cmocka_unit_test(start_module_has_everything_a_loader_would_do),
        cmocka_unit_test(lines_are_found),
        cmocka_unit_test(headers_that_lie_are_named),
        cmocka_unit_test(module_cut_anywhere_is_a_defect),
        cmocka_unit_test(any_byte_that_a_loader_reads_may_be_wrong),
    };
    return cmocka_run_group_tests_name("image_arm", tests, NULL, NULL);
}
