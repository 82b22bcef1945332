/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image.c - what image.h says about a module that is right, value by value: the built-in one
 * of image_support.h and small variations of it.
 */
#include "image_open.h"

/* ---- the built-in module ---- */

static void tiny_has_its_three_segments(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    struct image *image = open_tiny(&t);
    size_t code = offsetof(struct tiny, code), data = offsetof(struct tiny, dyn);
    size_t end = offsetof(struct tiny, symtab);
    assert_int_equal(image->format, IMAGE_FORMAT_ELF64);
    assert_int_equal(image->target, IMAGE_TARGET_X86_64);
    assert_string_equal(image->format_name, "ELF64");
    assert_string_equal(image->target_name, "x86-64");
    assert_int_equal(image->segment_count, 3);
    const struct image_segment *s = image->segments;
    assert_int_equal(s[0].vaddr, 0);
    assert_int_equal(s[0].mem_size, code);
    assert_int_equal(s[0].perm, IMAGE_READ);
    assert_int_equal(s[1].vaddr, code + 0x1000);
    assert_int_equal(s[1].file_offset, code);
    assert_int_equal(s[1].perm, IMAGE_READ | IMAGE_EXEC);
    assert_int_equal(s[2].vaddr, data + 0x2000);
    assert_int_equal(s[2].file_size, end - data);
    assert_int_equal(s[2].mem_size, end - data + TINY_BSS);
    assert_int_equal(s[2].perm, IMAGE_READ | IMAGE_WRITE);
    assert_int_equal(image->span_begin, 0);
    assert_int_equal(image->span_end, (end + 0x2000 + TINY_BSS + 0xfff) & ~(size_t)0xfff);
    assert_int_equal(image->align, 4096);
    assert_true(image->has_tls);
    assert_int_equal(image->tls_size, 24);
    assert_true(image->exec_stack_stated);
    assert_false(image->exec_stack);
    assert_int_equal(image->relro_begin, TINY_ADDRESS(dyn));
    assert_int_equal(image->relro_end, TINY_ADDRESS(dyn) + sizeof t.dyn);
    assert_false(image->has_debug_lines);
    image_close(image);
}

static void tiny_has_its_symbols_sorted_and_once(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    uint64_t code = TINY_ADDRESS(code);
    const struct {
        const char *name;
        uint64_t vaddr, size;
        enum image_symbol_kind kind;
        bool exported, executable;
    } expected[] = {
        { "slot", 0, 8, IMAGE_SYMBOL_TLS, true, false },
        { "Program_Ini", code, 16, IMAGE_SYMBOL_FUNC, true, true },
        { "Program_01", code + 16, 32, IMAGE_SYMBOL_FUNC, true, true },
        { "pick", code + 48, 8, IMAGE_SYMBOL_IFUNC, true, true },
        { "local", code + 64, 16, IMAGE_SYMBOL_FUNC, false, true },
        { "hidden_one", code + 80, 8, IMAGE_SYMBOL_FUNC, false, true },
        { "label", code + 96, 0, IMAGE_SYMBOL_NONE, false, true },
        { "shared", TINY_ADDRESS(words), 8, IMAGE_SYMBOL_OBJECT, true, false },
    };
    struct image *image = open_tiny(&t);
    assert_int_equal(image->symbol_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->symbol_count; i++) {
        assert_string_equal(image->symbols[i].name, expected[i].name);
        assert_int_equal(image->symbols[i].vaddr, expected[i].vaddr);
        assert_int_equal(image->symbols[i].size, expected[i].size);
        assert_int_equal(image->symbols[i].kind, expected[i].kind);
        assert_int_equal(image->symbols[i].exported, expected[i].exported);
        assert_int_equal(image->symbols[i].executable, expected[i].executable);
    }
    assert_ptr_equal(image_export(image, "pick"), &image->symbols[3]);
    assert_null(image_export(image, "local"));
    assert_null(image_export(image, "program_01"));
    assert_null(image_export(image, "missing"));
    image_close(image);
}

static void tiny_has_its_imports_with_the_first_user(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    const struct {
        enum image_import_kind kind;
        const char *name;
        bool has_user;
        uint64_t user;
    } expected[] = {
        { IMAGE_IMPORT_LIBRARY, "libm.so", false, 0 },
        { IMAGE_IMPORT_FILTER, "front.so", false, 0 },
        { IMAGE_IMPORT_FILTER, "aside.so", false, 0 },
        { IMAGE_IMPORT_SYMBOL, "missing", true, TINY_ADDRESS(words[72]) },
        { IMAGE_IMPORT_WEAK, "maybe", true, TINY_ADDRESS(words[71]) },
        { IMAGE_IMPORT_WEAK, "null_weak", false, 0 },
        { IMAGE_IMPORT_SYMBOL, "null_strong", false, 0 },
    };
    struct image *image = open_tiny(&t);
    assert_int_equal(image->import_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->import_count; i++) {
        assert_int_equal(image->imports[i].kind, expected[i].kind);
        assert_string_equal(image->imports[i].name, expected[i].name);
        assert_int_equal(image->imports[i].has_user, expected[i].has_user);
        assert_int_equal(image->imports[i].user, expected[i].user);
    }
    image_close(image);
}

static void tiny_has_its_relocations_by_address(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    uint64_t code = TINY_ADDRESS(code);
    const struct {
        uint64_t vaddr;
        int64_t addend;
        enum image_reloc_kind kind;
        uint32_t type;
        const char *type_name, *symbol;
    } expected[] = {
        { TINY_ADDRESS(init_array[0]), (int64_t)code + 64, IMAGE_RELOC_RELATIVE, 8,
          "R_X86_64_RELATIVE", NULL },
        { TINY_ADDRESS(words[0]), 0x10, IMAGE_RELOC_RELATIVE, 8, "R_X86_64_RELATIVE", NULL },
        { TINY_ADDRESS(words[1]), 0x11, IMAGE_RELOC_RELATIVE, 8, "R_X86_64_RELATIVE", NULL },
        { TINY_ADDRESS(words[63]), -1, IMAGE_RELOC_RELATIVE, 8, "R_X86_64_RELATIVE", NULL },
        { TINY_ADDRESS(words[70]), (int64_t)code + 16, IMAGE_RELOC_RELATIVE, 8, "R_X86_64_RELATIVE",
          NULL },
        { TINY_ADDRESS(words[71]), 5, IMAGE_RELOC_SYMBOLIC, 1, "R_X86_64_64", "maybe" },
        { TINY_ADDRESS(words[72]), 0, IMAGE_RELOC_SYMBOLIC, 6, "R_X86_64_GLOB_DAT", "missing" },
        { TINY_ADDRESS(words[73]), (int64_t)code + 48, IMAGE_RELOC_INDIRECT, 37,
          "R_X86_64_IRELATIVE", NULL },
        { TINY_ADDRESS(words[74]), 0, IMAGE_RELOC_TLS, 16, "R_X86_64_DTPMOD64", "slot" },
        { TINY_ADDRESS(words[75]), 0, IMAGE_RELOC_SYMBOLIC, 7, "R_X86_64_JUMP_SLOT", "missing" },
        { TINY_ADDRESS(words[76]), 0, IMAGE_RELOC_SYMBOLIC, 7, "R_X86_64_JUMP_SLOT", "Program_01" },
    };
    struct image *image = open_tiny(&t);
    assert_int_equal(image->reloc_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->reloc_count; i++) {
        assert_int_equal(image->relocs[i].vaddr, expected[i].vaddr);
        assert_int_equal(image->relocs[i].addend, expected[i].addend);
        assert_int_equal(image->relocs[i].kind, expected[i].kind);
        assert_int_equal(image->relocs[i].type, expected[i].type);
        assert_int_equal(image->relocs[i].width, 8);
        assert_string_equal(image->relocs[i].type_name, expected[i].type_name);
        if (expected[i].symbol == NULL)
            assert_null(image->relocs[i].symbol);
        else
            assert_string_equal(image->relocs[i].symbol, expected[i].symbol);
    }
    image_close(image);
}

static void tiny_has_its_initialisers_in_the_order_they_run(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    uint64_t code = TINY_ADDRESS(code);
    const struct image_initialiser expected[] = {
        { "DT_PREINIT_ARRAY", 0, 0 },      { "DT_INIT", code, 0 },
        { "DT_INIT_ARRAY", code + 64, 0 }, { "DT_INIT_ARRAY", code + 80, 1 },
        { "DT_FINI_ARRAY", code + 64, 0 }, { "DT_FINI", code + 16, 0 },
        { ".ctors", code + 96, 1 },
    };
    struct image *image = open_tiny(&t);
    assert_int_equal(image->initialiser_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->initialiser_count; i++) {
        assert_string_equal(image->initialisers[i].what, expected[i].what);
        assert_int_equal(image->initialisers[i].vaddr, expected[i].vaddr);
        assert_int_equal(image->initialisers[i].index, expected[i].index);
    }
    image_close(image);
}

static void array_entry_through_an_exported_symbol_is_followed(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.rela[1].r_info = ELF64_R_INFO(TINY_01, R_X86_64_64);
    t.rela[1].r_addend = 3;
    t.rela[0] =
        (Elf64_Rela){ TINY_ADDRESS(init_array[1]), ELF64_R_INFO(TINY_MAYBE, R_X86_64_64), 0 };
    struct image *image = open_tiny(&t);
    assert_int_equal(initialiser(image, "DT_INIT_ARRAY", 0)->vaddr, TINY_ADDRESS(code[16]) + 3);
    assert_int_equal(initialiser(image, "DT_INIT_ARRAY", 1)->vaddr, 0);
    image_close(image);
}

static void entry_point_of_a_shared_object_is_no_initialiser(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.eh.e_entry = TINY_ADDRESS(code[64]);
    struct image *image = open_tiny(&t);
    assert_int_equal(image->initialiser_count, 7);
    image_close(image);
}

static void symbols_are_counted_whatever_tables_there_are(void **state)
{
    (void)state;
    static const int64_t removals[][2] = { { DT_HASH, DT_HASH },
                                           { DT_GNU_HASH, DT_GNU_HASH },
                                           { DT_HASH, DT_GNU_HASH } };
    for (size_t i = 0; i < 3; i++) {
        static struct tiny t;
        tiny_init(&t);
        tiny_dyn_remove(&t, removals[i][0]);
        if (removals[i][1] != removals[i][0])
            tiny_dyn_remove(&t, removals[i][1]);
        struct image *image = open_tiny(&t);
        assert_int_equal(image->symbol_count, 8);
        assert_int_equal(image->import_count, 7);
        image_close(image);
    }
}

static void gnu_hash_without_symbols_still_shows_the_imports(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    tiny_dyn_remove(&t, DT_HASH);
    t.bucket = 0;
    for (unsigned i = TINY_INI; i <= TINY_SLOT; i++)
        t.dynsym[i].st_other = STV_HIDDEN;
    struct image *image = open_tiny(&t);
    assert_non_null(import(image, "missing"));
    image_close(image);
}

static void rel_takes_its_addend_from_the_word(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    tiny_dyn_add(&t, DT_REL, TINY_ADDRESS(rel));
    tiny_dyn_add(&t, DT_RELSZ, sizeof t.rel);
    tiny_dyn_add(&t, DT_RELENT, sizeof t.rel[0]);
    struct image *image = open_tiny(&t);
    assert_int_equal(image->reloc_count, 12);
    assert_int_equal(image->relocs[11].vaddr, TINY_ADDRESS(words[77]));
    assert_int_equal(image->relocs[11].addend, 0x77);
    image_close(image);
}

static void word_in_bss_has_addend_zero(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    /* The last 4 bytes from the file, the other 4 past its end. */
    t.relr[0] = TINY_ADDRESS(words) + sizeof t.words - 4;
    t.relr[1] = 1;
    memset((char *)&t.words[79] + 4, 0x5a, 4);
    struct image *image = open_tiny(&t);
    assert_int_equal(image->relocs[image->reloc_count - 1].addend, 0x5a5a5a5a);
    image_close(image);
}

static void plt_inside_the_other_table_is_not_read_twice(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    tiny_dyn(&t, DT_JMPREL)->d_un.d_val = TINY_ADDRESS(rela[4]);
    struct image *image = open_tiny(&t);
    assert_int_equal(image->reloc_count, 9);
    image_close(image);
}

static void none_relocations_are_not_there(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.rela[4] = (Elf64_Rela){ UINT64_MAX, R_X86_64_NONE, 0 };
    struct image *image = open_tiny(&t);
    assert_int_equal(image->reloc_count, 10);
    image_close(image);
}

static void unknown_relocation_is_other(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.rela[4].r_info = 200;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->relocs[7].kind, IMAGE_RELOC_OTHER);
    assert_int_equal(image->relocs[7].type, 200);
    assert_string_equal(image->relocs[7].type_name, "?");
    image_close(image);
}

static void file_without_sections_is_complete_for_a_loader(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.eh.e_shoff = 0;
    t.eh.e_shnum = 0;
    t.eh.e_shstrndx = 0;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->symbol_count, 5);
    assert_int_equal(image->import_count, 5);
    assert_int_equal(image->reloc_count, 11);
    image_close(image);
}

static void static_symbol_table_that_lies_counts_as_stripped(void **state)
{
    (void)state;
    for (unsigned lie = 0; lie < 7; lie++) {
        static struct tiny t;
        tiny_init(&t);
        Elf64_Shdr *symtab = &t.sh[TINY_SYMTAB], *strtab = &t.sh[TINY_STRTAB];
        switch (lie) {
        case 0:
            symtab->sh_offset = UINT64_MAX - 8;
            break;
        case 1:
            symtab->sh_size = UINT64_MAX;
            break;
        case 2:
            symtab->sh_entsize = 1;
            break;
        case 3:
            symtab->sh_link = 77;
            break;
        case 4:
            strtab->sh_size = 20; /* in the middle of a name */
            break;
        case 5:
            strtab->sh_offset = sizeof t;
            break;
        default:
            strtab->sh_type = SHT_NOBITS;
        }
        struct image *image = open_tiny(&t);
        assert_int_equal(image->symbol_count, 5);
        image_close(image);
    }
}

static void static_symbols_that_lie_are_left_out(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.symtab[1].st_value = 0x100000;
    t.symtab[2].st_size = UINT64_MAX;
    t.symtab[6].st_name = UINT32_MAX;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->symbol_count, 5);
    image_close(image);
}

static void absolute_symbol_is_no_function(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.dynsym[TINY_01].st_shndx = SHN_ABS;
    tiny_dyn_remove(&t, DT_INIT_ARRAY);
    tiny_dyn_remove(&t, DT_INIT_ARRAYSZ);
    struct image *image = open_tiny(&t);
    const struct image_symbol *program = image_export(image, "Program_01");
    assert_int_equal(program->kind, IMAGE_SYMBOL_OTHER);
    assert_false(program->executable);
    image_close(image);
}

static void hidden_dynamic_symbol_is_not_exported(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.dynsym[TINY_01].st_other = STV_HIDDEN;
    struct image *image = open_tiny(&t);
    assert_null(image_export(image, "Program_01"));
    assert_false(symbol(image, "Program_01")->exported);
    image_close(image);
}

static void large_alignment_is_kept(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.ph[TINY_R].p_align = 1u << 20;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->align, 1u << 20);
    image_close(image);
}

static void segment_is_found_by_range(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    struct image *image = open_tiny(&t);
    const struct image_segment *rw = &image->segments[2];
    uint64_t end = rw->vaddr + rw->mem_size;
    assert_ptr_equal(image_segment_at(image, rw->vaddr, rw->mem_size), rw);
    assert_ptr_equal(image_segment_at(image, end - 1, 1), rw);
    assert_null(image_segment_at(image, end - 1, 2));
    assert_null(image_segment_at(image, end, 0));
    assert_null(image_segment_at(image, rw->vaddr - 1, 1));
    assert_null(image_segment_at(image, rw->vaddr, UINT64_MAX));
    assert_null(image_segment_at(image, UINT64_MAX, UINT64_MAX));
    image_close(image);
}

static void place_is_a_function_that_holds_the_address(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.symtab[6].st_value = TINY_ADDRESS(code[84]); /* label inside hidden_one */
    struct image *image = open_tiny(&t);
    const struct {
        uint64_t vaddr;
        const char *function;
        uint64_t offset;
    } expected[] = {
        { TINY_ADDRESS(code[0]), "Program_Ini", 0 },
        { TINY_ADDRESS(code[15]), "Program_Ini", 15 },
        { TINY_ADDRESS(code[16]), "Program_01", 0 },
        { TINY_ADDRESS(code[47]), "Program_01", 31 },
        { TINY_ADDRESS(code[56]), NULL, 0 },
        { TINY_ADDRESS(code[64]), "local", 0 },
        { TINY_ADDRESS(code[86]), "hidden_one", 6 },
        { TINY_ADDRESS(code[90]), "label", 6 },
        { TINY_ADDRESS(words), NULL, 0 },
        { 0, NULL, 0 },
        { UINT64_MAX, NULL, 0 },
    };
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; i++) {
        struct image_place place;
        image_where(image, expected[i].vaddr, &place);
        if (expected[i].function == NULL)
            assert_null(place.function);
        else
            assert_string_equal(place.function, expected[i].function);
        assert_int_equal(place.offset, expected[i].offset);
        assert_null(place.file);
        assert_int_equal(place.line, 0);
    }
    image_close(image);
}

static void of_two_names_for_one_function_the_exported_one_is_told(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.symtab[1].st_value = TINY_ADDRESS(code[16]); /* "local" beside Program_01 */
    t.symtab[1].st_size = 32;
    struct image *image = open_tiny(&t);
    struct image_place place;
    image_where(image, TINY_ADDRESS(code[20]), &place);
    assert_string_equal(place.function, "Program_01");
    assert_non_null(symbol(image, "local"));
    image_close(image);
}

static void plt_table_without_addends_is_read(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    tiny_dyn(&t, DT_JMPREL)->d_un.d_val = TINY_ADDRESS(rel);
    tiny_dyn(&t, DT_PLTRELSZ)->d_un.d_val = sizeof t.rel;
    tiny_dyn(&t, DT_PLTREL)->d_un.d_val = DT_REL;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->reloc_count, 10);
    assert_int_equal(image->relocs[9].addend, 0x77);
    image_close(image);
}

static void empty_relro_is_none(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.ph[TINY_RELRO].p_vaddr = 0x900000;
    t.ph[TINY_RELRO].p_memsz = 0;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->relro_begin, 0);
    assert_int_equal(image->relro_end, 0);
    image_close(image);
}

static void small_alignment_means_a_page(void **state)
{
    (void)state;
    static struct tiny t;
    tiny_init(&t);
    t.ph[TINY_R].p_align = t.ph[TINY_RX].p_align = t.ph[TINY_RW].p_align = 16;
    struct image *image = open_tiny(&t);
    assert_int_equal(image->align, 4096);
    image_close(image);
}

static void hash_is_of_the_whole_file(void **state)
{
    (void)state;
    struct image *image = open_bytes("abc", 3);
    assert_string_equal(image->sha256,
                        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_memory_equal(image->bytes, "abc", 3);
    assert_string_equal(image->path, "bytes");
    image_close(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiny_has_its_three_segments),
        cmocka_unit_test(tiny_has_its_symbols_sorted_and_once),
        cmocka_unit_test(tiny_has_its_imports_with_the_first_user),
        cmocka_unit_test(tiny_has_its_relocations_by_address),
        cmocka_unit_test(tiny_has_its_initialisers_in_the_order_they_run),
        cmocka_unit_test(array_entry_through_an_exported_symbol_is_followed),
        cmocka_unit_test(entry_point_of_a_shared_object_is_no_initialiser),
        cmocka_unit_test(symbols_are_counted_whatever_tables_there_are),
        cmocka_unit_test(gnu_hash_without_symbols_still_shows_the_imports),
        cmocka_unit_test(rel_takes_its_addend_from_the_word),
        cmocka_unit_test(word_in_bss_has_addend_zero),
        cmocka_unit_test(plt_inside_the_other_table_is_not_read_twice),
        cmocka_unit_test(none_relocations_are_not_there),
        cmocka_unit_test(unknown_relocation_is_other),
        cmocka_unit_test(file_without_sections_is_complete_for_a_loader),
        cmocka_unit_test(static_symbol_table_that_lies_counts_as_stripped),
        cmocka_unit_test(static_symbols_that_lie_are_left_out),
        cmocka_unit_test(absolute_symbol_is_no_function),
        cmocka_unit_test(hidden_dynamic_symbol_is_not_exported),
        cmocka_unit_test(large_alignment_is_kept),
        cmocka_unit_test(segment_is_found_by_range),
        cmocka_unit_test(place_is_a_function_that_holds_the_address),
        cmocka_unit_test(of_two_names_for_one_function_the_exported_one_is_told),
        cmocka_unit_test(plt_table_without_addends_is_read),
        cmocka_unit_test(empty_relro_is_none),
        cmocka_unit_test(small_alignment_means_a_page),
        cmocka_unit_test(hash_is_of_the_whole_file),
    };
    return cmocka_run_group_tests_name("image", tests, NULL, NULL);
}
