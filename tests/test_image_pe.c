/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_pe.c - PE modules: one that has everything, and what mingw and lld make.
 */
#include "image_open.h"
#include "image_support_pe.h"

static struct image *open_tiny_pe(struct tiny_pe *t)
{
    struct image *image = open_bytes(t->bytes, TINY_PE_SIZE);
    if (image->defect[0] != '\0')
        fail_msg("%s", image->defect);
    return image;
}

/* ---- the built-in module ---- */

static void has_its_headers_and_segments(bool wide)
{
    static const struct image_segment expected[] = {
        { 0, 0x200, 0x200, 0, IMAGE_READ },
        { 0x1000, 0x100, 0x100, PE_TEXT_AT, IMAGE_READ | IMAGE_EXEC },
        { 0x2000, 0x400, 0x400, PE_RDATA_AT, IMAGE_READ },
        { 0x3000, 0x300, 0x200, PE_DATA_AT, IMAGE_READ | IMAGE_WRITE },
        { 0x4000, PE_RELOCS_SIZE, PE_RELOCS_SIZE, PE_RELOCS_AT, IMAGE_READ },
    };
    static struct tiny_pe t;
    tiny_pe_init(&t, wide);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->format, IMAGE_FORMAT_PE);
    assert_string_equal(image->format_name, "PE");
    assert_int_equal(image->target, wide ? IMAGE_TARGET_X86_64 : IMAGE_TARGET_I386);
    assert_string_equal(image->target_name, wide ? "x86-64" : "i386");
    assert_int_equal(image->segment_count, 5);
    for (size_t i = 0; i < 5; i++) {
        const struct image_segment *s = &image->segments[i];
        assert_int_equal(s->vaddr, expected[i].vaddr);
        assert_int_equal(s->mem_size, expected[i].mem_size);
        assert_int_equal(s->file_size, expected[i].file_size);
        assert_int_equal(s->file_offset, expected[i].file_offset);
        assert_int_equal(s->perm, expected[i].perm);
    }
    assert_int_equal(image->span_begin, 0);
    assert_int_equal(image->span_end, 0x5000);
    assert_int_equal(image->align, 4096);
    assert_int_equal(image->base, TINY_PE_BASE);
    assert_false(image->fixed);
    assert_true(image->has_entry_point);
    assert_int_equal(image->entry_point, 0x1050);
    assert_true(image->exec_stack_stated);
    assert_false(image->exec_stack);
    assert_false(image->has_debug_lines);
    image_close(image);
}

static void has_its_symbols(bool wide)
{
    const struct {
        const char *name, *forwarder;
        uint64_t vaddr;
        uint32_t ordinal;
        enum image_symbol_kind kind;
        bool exported, executable, by_ordinal;
    } expected[] = {
        { "away", "OTHER.Name", 0, 7, IMAGE_SYMBOL_OTHER, true, false, false },
        { "Program_Ini", NULL, 0x1000, 5, IMAGE_SYMBOL_NONE, true, true, false },
        { "Program_01", NULL, 0x1010, 6, IMAGE_SYMBOL_FUNC, true, true, false },
        { "#8", NULL, 0x1020, 8, IMAGE_SYMBOL_NONE, true, true, true },
        { "local", NULL, 0x1030, 0, IMAGE_SYMBOL_FUNC, false, true, false },
        { wide ? "variable" : "variabl", NULL, 0x3060, 0, IMAGE_SYMBOL_NONE, false, false, false },
    };
    static struct tiny_pe t;
    tiny_pe_init(&t, wide);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->symbol_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *s = &image->symbols[i];
        assert_string_equal(s->name, expected[i].name);
        assert_int_equal(s->vaddr, expected[i].vaddr);
        assert_int_equal(s->ordinal, expected[i].ordinal);
        assert_int_equal(s->kind, expected[i].kind);
        assert_int_equal(s->exported, expected[i].exported);
        assert_int_equal(s->executable, expected[i].executable);
        assert_int_equal(s->by_ordinal, expected[i].by_ordinal);
        if (expected[i].forwarder == NULL)
            assert_null(s->forwarder);
        else
            assert_string_equal(s->forwarder, expected[i].forwarder);
    }
    assert_ptr_equal(image_export(image, "Program_01"), &image->symbols[2]);
    image_close(image);
}

static void has_its_imports(bool wide)
{
    uint64_t word = wide ? 8 : 4;
    const struct {
        enum image_import_kind kind;
        const char *name;
        uint64_t user;
        bool delayed;
    } expected[] = {
        { IMAGE_IMPORT_LIBRARY, "KERNEL32.dll", 0, false },
        { IMAGE_IMPORT_SYMBOL, "KERNEL32.dll!Sleep", 0x3000, false },
        { IMAGE_IMPORT_SYMBOL, "KERNEL32.dll!#12", 0x3000 + word, false },
        { IMAGE_IMPORT_LIBRARY, "LATE.dll", 0, true },
        { IMAGE_IMPORT_SYMBOL, "LATE.dll!later", 0x3020, true },
        { IMAGE_IMPORT_FILTER, "OTHER.Name", 0, false },
    };
    static struct tiny_pe t;
    tiny_pe_init(&t, wide);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->import_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->import_count; i++) {
        assert_int_equal(image->imports[i].kind, expected[i].kind);
        assert_string_equal(image->imports[i].name, expected[i].name);
        assert_int_equal(image->imports[i].has_user, expected[i].user != 0);
        assert_int_equal(image->imports[i].user, expected[i].user);
        assert_int_equal(image->imports[i].delayed, expected[i].delayed);
    }
    image_close(image);
}

static void has_its_relocations(bool wide)
{
    uint64_t word = wide ? 8 : 4;
    const struct {
        uint64_t vaddr;
        int64_t addend;
    } expected[] = {
        { 0x2200, 0x3040 },
        { 0x2200 + word, 0x3048 },
        { 0x2200 + 2 * word, 0x3050 },
        { 0x2200 + 3 * word, 0x2240 },
        { 0x2240, 0x1060 },
        { 0x2240 + word, 0x1070 },
        { 0x3000, -1 },
        { 0x3000 + word, -1 },
        { 0x3020, 0x1040 },
        { 0x3060, 0x3200 },
    };
    static struct tiny_pe t;
    tiny_pe_init(&t, wide);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->reloc_count, sizeof expected / sizeof expected[0]);
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *r = &image->relocs[i];
        bool slot = expected[i].addend == -1;
        assert_int_equal(r->vaddr, expected[i].vaddr);
        assert_int_equal(r->width, word);
        assert_int_equal(r->kind, slot ? IMAGE_RELOC_SYMBOLIC : IMAGE_RELOC_RELATIVE);
        assert_int_equal(r->type, slot ? IMAGE_RELOC_IAT : wide ? 10 : 3);
        if (slot) {
            assert_string_equal(r->symbol, image->imports[i - 5].name);
            continue;
        }
        assert_int_equal(r->addend, expected[i].addend);
        assert_null(r->symbol);
        assert_string_equal(r->type_name,
                            wide ? "IMAGE_REL_BASED_DIR64" : "IMAGE_REL_BASED_HIGHLOW");
    }
    image_close(image);
}

static void has_its_thread_storage(bool wide)
{
    static struct tiny_pe t;
    tiny_pe_init(&t, wide);
    struct image *image = open_tiny_pe(&t);
    assert_true(image->has_tls);
    assert_int_equal(image->tls_size, 8 + 16);
    assert_int_equal(image->initialiser_count, 2);
    for (unsigned i = 0; i < 2; i++) {
        assert_string_equal(image->initialisers[i].what, "TLS callback");
        assert_int_equal(image->initialisers[i].vaddr, 0x1060 + 0x10 * i);
        assert_int_equal(image->initialisers[i].index, i);
    }
    image_close(image);
}

static void pe64_is_read_whole(void **state)
{
    (void)state;
    has_its_headers_and_segments(true);
    has_its_symbols(true);
    has_its_imports(true);
    has_its_relocations(true);
    has_its_thread_storage(true);
}

static void pe32_is_read_whole(void **state)
{
    (void)state;
    has_its_headers_and_segments(false);
    has_its_symbols(false);
    has_its_imports(false);
    has_its_relocations(false);
    has_its_thread_storage(false);
}

/* ---- variations that are no lies ---- */

static void directory_with_only_an_end_mark_is_no_import(void **state)
{
    (void)state;
    static struct tiny_pe t;
    tiny_pe_init(&t, true);
    memset(t.bytes + PE_IMPORTS_AT, 0, 40);
    memset(t.bytes + PE_DELAY_AT, 0, 64);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->import_count, 1);
    assert_int_equal(image->imports[0].kind, IMAGE_IMPORT_FILTER);
    image_close(image);
}

static void module_without_directories_has_nothing(void **state)
{
    (void)state;
    static struct tiny_pe t;
    for (int wide = 0; wide < 2; wide++) {
        tiny_pe_init(&t, wide != 0);
        for (unsigned i = 0; i < 16; i++)
            pe_put_directory(&t, i, 0, 0);
        pe_put(&t, PE_POINTER_TO_SYMBOLS, 4, 0);
        pe_put(&t, PE_ENTRY_POINT, 4, 0);
        struct image *image = open_tiny_pe(&t);
        assert_int_equal(image->symbol_count + image->import_count + image->reloc_count +
                             image->initialiser_count,
                         0);
        assert_false(image->has_tls);
        assert_false(image->has_entry_point);
        image_close(image);
    }
}

static void module_without_relocations_is_fixed(void **state)
{
    (void)state;
    static struct tiny_pe t;
    tiny_pe_init(&t, true);
    pe_put_directory(&t, 5, 0, 0);
    pe_put(&t, PE_CHARACTERISTICS, 2, 0x2023);
    struct image *image = open_tiny_pe(&t);
    assert_true(image->fixed);
    assert_int_equal(image->reloc_count, 2); /* the slots */
    assert_int_equal(image->initialiser_count, 2);
    image_close(image);
}

static void import_without_name_table_is_read_from_the_slots(void **state)
{
    (void)state;
    static struct tiny_pe t;
    tiny_pe_init(&t, false);
    pe_put(&t, PE_IMPORTS_AT, 4, 0);
    struct image *image = open_tiny_pe(&t);
    assert_non_null(import(image, "KERNEL32.dll!Sleep"));
    assert_non_null(import(image, "KERNEL32.dll!#12"));
    image_close(image);
}

static void pointer_in_front_of_the_module_has_a_negative_addend(void **state)
{
    (void)state;
    static struct tiny_pe t;
    for (int wide = 0; wide < 2; wide++) {
        tiny_pe_init(&t, wide != 0);
        pe_put_word(&t, PE_POINTER_AT, TINY_PE_BASE - 4);
        struct image *image = open_tiny_pe(&t);
        assert_int_equal(image->relocs[image->reloc_count - 1].addend, -4);
        image_close(image);
    }
}

static void relocations_that_are_not_a_whole_address_are_other(void **state)
{
    (void)state;
    static const struct {
        unsigned type;
        const char *name;
        unsigned width;
    } types[] = { { 1, "IMAGE_REL_BASED_HIGH", 2 },
                  { 2, "IMAGE_REL_BASED_LOW", 2 },
                  { 3, "IMAGE_REL_BASED_HIGHLOW", 4 },
                  { 4, "IMAGE_REL_BASED_HIGHADJ", 2 },
                  { 5, "?", 0 },
                  { 9, "?", 0 },
                  { 11, "?", 0 } };
    static struct tiny_pe t;
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++) {
        tiny_pe_init(&t, true);
        /* The parameter of HIGHADJ, which is no entry, would otherwise patch 0x3fff. */
        pe_put(&t, PE_SECOND_BLOCK_AT + 10, 2, types[i].type << 12 | 0x060);
        pe_put(&t, PE_SECOND_BLOCK_AT + 12, 2, types[i].type == 4 ? 0xafff : 0);
        struct image *image = open_tiny_pe(&t);
        const struct image_reloc *r = &image->relocs[image->reloc_count - 1];
        assert_int_equal(r->vaddr, 0x3060);
        assert_int_equal(r->kind, IMAGE_RELOC_OTHER);
        assert_string_equal(r->type_name, types[i].name);
        assert_int_equal(r->width, types[i].width);
        image_close(image);
    }
    tiny_pe_init(&t, false);
    pe_put(&t, PE_SECOND_BLOCK_AT + 10, 2, 0xa060);
    struct image *image = open_tiny_pe(&t);
    assert_int_equal(image->relocs[image->reloc_count - 1].kind, IMAGE_RELOC_OTHER);
    image_close(image);
}

static void forwarder_may_name_an_ordinal(void **state)
{
    (void)state;
    static struct tiny_pe t;
    tiny_pe_init(&t, true);
    memcpy(t.bytes + PE_STRINGS_AT + 0x30, "a.b.#7", 7);
    struct image *image = open_tiny_pe(&t);
    assert_string_equal(image_export(image, "away")->forwarder, "a.b.#7");
    image_close(image);
}

static void coff_symbols_that_lie_are_left_out(void **state)
{
    (void)state;
    static struct tiny_pe t;
    static const struct {
        size_t at;
        unsigned width;
        uint64_t value;
    } lies[] = {
        { PE_SYMBOLS_AT + 12, 2, 5 },
        { PE_SYMBOLS_AT + 12, 2, 0 },
        { PE_SYMBOLS_AT + 12, 2, 0xffff },
        { PE_SYMBOLS_AT + 8, 4, 0x100 },
        { PE_SYMBOLS_AT + 8, 4, UINT32_MAX },
        { PE_SYMBOLS_AT + 16, 1, 103 },
        { PE_SYMBOLS_AT, 4, 0 },
        { PE_SYMBOLS_AT + 17, 1, 0 },
    };
    for (size_t i = 0; i < sizeof lies / sizeof lies[0]; i++) {
        tiny_pe_init(&t, true);
        pe_put(&t, lies[i].at, lies[i].width, lies[i].value);
        struct image *image = open_tiny_pe(&t);
        bool last = i + 1 == sizeof lies / sizeof lies[0];
        assert_int_equal(image->symbol_count, last ? 6 : 5);
        image_close(image);
    }
}

/* ---- real compilers and linkers ---- */

static const char *const entries[] = { "Program_01", "Program_02", "Program_03",
                                       "Program_04", "Program_05", "Program_Ini" };

static void every_linker_exports_the_six(void **state)
{
    (void)state;
    static const char *const names[] = {
        "six_mingw_x86_64.dll",        "six_mingw_i686.dll", "six_mingw_x86_64_stripped.dll",
        "six_mingw_i686_stripped.dll", "six_lld_x86_64.dll", "six_lld_i686.dll",
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        size_t exported = 0;
        for (size_t k = 0; k < image->symbol_count; k++)
            exported += image->symbols[k].exported;
        assert_int_equal(exported, 6);
        for (unsigned k = 0; k < 6; k++) {
            const struct image_symbol *entry = image_export(image, entries[k]);
            assert_non_null(entry);
            assert_true(entry->executable);
            assert_int_equal(entry->ordinal, k + 1);
        }
        assert_int_equal(image->import_count, 0);
        assert_int_equal(image->initialiser_count, 0);
        assert_false(image->has_tls || image->has_entry_point || image->exec_stack || image->fixed);
        image_close(image);
    }
}

/* table[] of image_six.c: five pointers into the module's data. */
static void table_is_relocated(void **state)
{
    (void)state;
    static const char *const names[] = { "six_mingw_x86_64.dll", "six_mingw_i686.dll" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        uint64_t table = symbol(image, "table")->vaddr, zeroed = symbol(image, "zeroed")->vaddr;
        unsigned word = image->target == IMAGE_TARGET_X86_64 ? 8 : 4, found = 0;
        for (size_t k = 0; k < image->reloc_count; k++) {
            const struct image_reloc *r = &image->relocs[k];
            assert_int_equal(r->kind, IMAGE_RELOC_RELATIVE);
            assert_int_equal(r->width, word);
            if (r->vaddr < table || r->vaddr >= table + 5 * word)
                continue;
            assert_int_equal(r->vaddr, table + found * word);
            assert_int_equal(r->addend, found == 0 ? symbol(image, "counter")->vaddr
                                                   : zeroed + 4 * (found - 1));
            found++;
        }
        assert_int_equal(found, 5);
        image_close(image);
    }
}

static void full_module_shows_what_it_wants(void **state)
{
    (void)state;
    static const char *const names[] = { "pe_mingw_x86_64.dll", "pe_mingw_i686.dll",
                                         "pe_lld_x86_64.dll",   "pe_lld_i686.dll",
                                         "pe_delay_x86_64.dll", "pe_delay_i686.dll" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        bool delayed = i >= 4;
        assert_int_equal(import(image, "OTHER.dll")->delayed, delayed);
        assert_int_equal(import(image, "OTHER.dll!by_name")->delayed, delayed);
        assert_int_equal(import(image, "OTHER.dll!#7")->kind, IMAGE_IMPORT_SYMBOL);
        assert_int_equal(image->has_entry_point, !delayed);
        assert_true(image->has_tls);
        assert_int_equal(image->tls_size, 24 + 16);
        assert_non_null(initialiser(image, "TLS callback", 1));
        /* lld decorates forwarders of i386. */
        assert_non_null(strstr(image_export(image, "Program_03")->forwarder, "OTHER.by_name"));
        assert_int_equal(image_export(image, "Program_03")->kind, IMAGE_SYMBOL_OTHER);
        assert_true(image_export(image, "#9")->by_ordinal);
        assert_int_equal(image_export(image, "#9")->ordinal, 9);
        assert_int_equal(image_export(image, "alias")->vaddr,
                         image_export(image, "Program_01")->vaddr);
        image_close(image);
    }
}

static void lists_of_constructors_are_found(void **state)
{
    (void)state;
    static const char *const names[] = { "pe_ctors_x86_64.dll", "pe_ctors_i686.dll" };
    for (size_t i = 0; i < 2; i++) {
        struct image *image = open_module(names[i]);
        assert_int_equal(image->initialiser_count, 2);
        assert_int_equal(initialiser(image, ".ctors", 1)->vaddr,
                         symbol(image, "constructor")->vaddr);
        assert_int_equal(initialiser(image, ".dtors", 1)->vaddr,
                         symbol(image, "destructor")->vaddr);
        image_close(image);
    }
}

/* The record that lld-link /DEBUG writes, made to order. */
static void the_pdb_file_is_named_and_not_looked_for(void **state)
{
    static struct tiny_pe t;
    static const char record[] = "RSDS0123456789abcdef\1\0\0\0module.pdb";
    (void)state;
    for (int lie = 0; lie < 5; lie++) {
        tiny_pe_init(&t, true);
        pe_put_directory(&t, 6, PE_VADDR(PE_CONFIG_AT), 28);
        pe_put_directory(&t, 10, 0, 0);
        pe_put(&t, PE_CONFIG_AT + 12, 4, lie == 1 ? 4 : 2);
        pe_put(&t, PE_CONFIG_AT + 16, 4, lie == 2 ? sizeof record - 1 : sizeof record);
        pe_put(&t, PE_CONFIG_AT + 24, 4, lie == 3 ? UINT32_MAX : PE_CONFIG_AT + 64);
        memcpy(t.bytes + PE_CONFIG_AT + 64, record, sizeof record);
        if (lie == 4)
            memcpy(t.bytes + PE_CONFIG_AT + 64, "NB10", 4);
        struct image *image = open_bytes(t.bytes, TINY_PE_SIZE);
        assert_string_equal(image->defect, "");
        if (lie == 0)
            assert_string_equal(image->debug_file, "module.pdb");
        else
            assert_null(image->debug_file);
        image_close(image);
    }
}

static void lines_of_mingw_modules_are_found(void **state)
{
    (void)state;
    if (under_valgrind())
        skip();
    static const char *const names[] = { "six_mingw_x86_64.dll", "six_mingw_i686.dll" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        struct image_place place;
        assert_true(image->has_debug_lines);
        image_where(image, symbol(image, "local_function")->vaddr, &place);
        assert_string_equal(place.function, "local_function");
        assert_non_null(place.file);
        assert_string_equal(place.file, "tests/modules/image_six.c");
        assert_int_equal(place.line, 12);
        image_where(image, image_export(image, "Program_04")->vaddr + 1, &place);
        assert_string_equal(place.function, "Program_04");
        assert_int_equal(place.offset, 1);
        image_close(image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pe64_is_read_whole),
        cmocka_unit_test(pe32_is_read_whole),
        cmocka_unit_test(directory_with_only_an_end_mark_is_no_import),
        cmocka_unit_test(module_without_directories_has_nothing),
        cmocka_unit_test(module_without_relocations_is_fixed),
        cmocka_unit_test(import_without_name_table_is_read_from_the_slots),
        cmocka_unit_test(pointer_in_front_of_the_module_has_a_negative_addend),
        cmocka_unit_test(relocations_that_are_not_a_whole_address_are_other),
        cmocka_unit_test(forwarder_may_name_an_ordinal),
        cmocka_unit_test(coff_symbols_that_lie_are_left_out),
        cmocka_unit_test(every_linker_exports_the_six),
        cmocka_unit_test(table_is_relocated),
        cmocka_unit_test(full_module_shows_what_it_wants),
        cmocka_unit_test(lists_of_constructors_are_found),
        cmocka_unit_test(the_pdb_file_is_named_and_not_looked_for),
        cmocka_unit_test(lines_of_mingw_modules_are_found),
    };
    return cmocka_run_group_tests_name("image_pe", tests, NULL, NULL);
}
