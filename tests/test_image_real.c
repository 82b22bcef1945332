/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_image_real.c - modules as compilers and linkers make them (tests/modules/image_*.c), their
 * debug information, and what can go wrong with a file before it is one.
 */
#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image_open.h"

#define SOURCES "tests/modules"

static const char *const entries[] = { "Program_Ini", "Program_01", "Program_02",
                                       "Program_03",  "Program_04", "Program_05" };

static size_t count_relocs(const struct image *image, enum image_reloc_kind kind)
{
    size_t count = 0;
    for (size_t i = 0; i < image->reloc_count; i++)
        count += image->relocs[i].kind == kind;
    return count;
}

/* ---- real compilers and linkers ---- */

static void has_six_entries(const char *name)
{
    struct image *image = open_module(name);
    size_t exported = 0;
    for (size_t i = 0; i < image->symbol_count; i++)
        exported += image->symbols[i].exported;
    assert_int_equal(exported, 6);
    for (size_t i = 0; i < 6; i++) {
        const struct image_symbol *entry = image_export(image, entries[i]);
        assert_non_null(entry);
        assert_int_equal(entry->kind, IMAGE_SYMBOL_FUNC);
        assert_true(entry->executable);
        assert_true(entry->size > 0);
    }
    image_close(image);
}

static void every_layout_exports_the_six(void **state)
{
    (void)state;
    static const char *const names[] = {
        "six.so",      "six_lld.so",     "six_stripped.so", "six_sysv.so",      "six_both.so",
        "six_relr.so", "six_plain.so",   "six_libc.so",     "six_relr_lld.so",  "six_dwarf4.so",
        "six_gz.so",   "six_nostack.so", "six_filter.so",   "six_execstack.so",
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        has_six_entries(names[i]);
}

/* table[] of image_six.c: five pointers, however the linker writes them down. */
static void every_layout_relocates_the_table(void **state)
{
    (void)state;
    static const char *const names[] = { "six.so", "six_lld.so", "six_sysv.so", "six_relr.so",
                                         "six_relr_lld.so" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        uint64_t table = symbol(image, "table")->vaddr;
        uint64_t zeroed = symbol(image, "zeroed")->vaddr;
        assert_int_equal(image->reloc_count, 5);
        assert_int_equal(image->import_count, 0);
        assert_int_equal(image->initialiser_count, 0);
        assert_false(image->has_tls);
        for (size_t k = 0; k < 5; k++) {
            assert_int_equal(image->relocs[k].vaddr, table + 8 * k);
            assert_int_equal(image->relocs[k].kind, IMAGE_RELOC_RELATIVE);
            assert_int_equal(image->relocs[k].addend,
                             k == 0 ? symbol(image, "counter")->vaddr : zeroed + 4 * (k - 1));
        }
        assert_int_equal(symbol(image, "zeroed")->size, 4000);
        image_close(image);
    }
}

static void stack_statements(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        bool exec, stated;
    } expected[] = { { "six.so", false, true },
                     { "six_execstack.so", true, true },
                     { "six_nostack.so", true, false } };
    for (size_t i = 0; i < 3; i++) {
        struct image *image = open_module(expected[i].name);
        assert_int_equal(image->exec_stack, expected[i].exec);
        assert_int_equal(image->exec_stack_stated, expected[i].stated);
        image_close(image);
    }
}

static void stripped_module_keeps_only_exports(void **state)
{
    (void)state;
    struct image *image = open_module("six_stripped.so");
    assert_int_equal(image->symbol_count, 6);
    assert_false(image->has_debug_lines);
    image_close(image);
}

static void filters_are_imports(void **state)
{
    (void)state;
    struct image *image = open_module("six_filter.so");
    assert_int_equal(image->import_count, 2);
    assert_int_equal(import(image, "front.so")->kind, IMAGE_IMPORT_FILTER);
    assert_int_equal(import(image, "aside.so")->kind, IMAGE_IMPORT_FILTER);
    image_close(image);
}

static void start_module_has_everything_a_loader_would_do(void **state)
{
    (void)state;
    static const char *const names[] = { "start.so", "start_lld.so" };
    for (size_t i = 0; i < 2; i++) {
        struct image *image = open_module(names[i]);
        assert_true(image->has_tls);
        assert_int_equal(image->tls_size, 16);
        assert_int_equal(image_export(image, "exported_per_thread")->kind, IMAGE_SYMBOL_TLS);
        assert_int_equal(image_export(image, "picked")->kind, IMAGE_SYMBOL_IFUNC);
        assert_int_equal(import(image, "somewhere_else")->kind, IMAGE_IMPORT_SYMBOL);
        assert_true(import(image, "somewhere_else")->has_user);
        assert_int_equal(import(image, "perhaps")->kind, IMAGE_IMPORT_WEAK);
        assert_true(count_relocs(image, IMAGE_RELOC_TLS) >= 2);
        assert_true(count_relocs(image, IMAGE_RELOC_SYMBOLIC) >= 3);
        assert_int_equal(image->initialiser_count, 2);
        assert_int_equal(initialiser(image, "DT_INIT_ARRAY", 0)->vaddr,
                         symbol(image, "constructor")->vaddr);
        assert_int_equal(initialiser(image, "DT_FINI_ARRAY", 0)->vaddr,
                         symbol(image, "destructor")->vaddr);
        image_close(image);
    }
}

static void weak_symbol_that_the_linker_made_null_is_an_import(void **state)
{
    (void)state;
    struct image *image = open_module("start_lld.so");
    assert_int_equal(import(image, "never")->kind, IMAGE_IMPORT_WEAK);
    assert_false(import(image, "never")->has_user);
    image_close(image);
}

static void old_module_has_its_constructor_list_and_writable_code(void **state)
{
    (void)state;
    struct image *image = open_module("old.so");
    assert_int_equal(image->initialiser_count, 1);
    assert_int_equal(initialiser(image, ".ctors", 1)->vaddr,
                     symbol(image, "old_constructor")->vaddr);
    uint64_t code = image_export(image, "writable_code")->vaddr;
    assert_int_equal(image_segment_at(image, code, 1)->perm, IMAGE_READ | IMAGE_WRITE | IMAGE_EXEC);
    image_close(image);
}

static void module_on_the_c_library_shows_what_it_wants(void **state)
{
    (void)state;
    static const char *const names[] = { "libc.so", "libc_lld.so" };
    for (size_t i = 0; i < 2; i++) {
        struct image *image = open_module(names[i]);
        const struct image_import *printf_import = import(image, "printf");
        assert_int_equal(import(image, "libc.so.6")->kind, IMAGE_IMPORT_LIBRARY);
        assert_int_equal(printf_import->kind, IMAGE_IMPORT_SYMBOL);
        assert_true(printf_import->has_user);
        assert_non_null(image_segment_at(image, printf_import->user, 8));
        assert_int_equal(import(image, "__cxa_finalize")->kind, IMAGE_IMPORT_WEAK);
        assert_non_null(initialiser(image, "DT_INIT", 0));
        assert_non_null(initialiser(image, "DT_FINI_ARRAY", 0));
        image_close(image);
    }
}

/* ---- lines ---- */

/* Line of a source file that has the text, as a compiler counts. */
static int line_of(const char *path, const char *text)
{
    char line[256];
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    for (int number = 1; fgets(line, sizeof line, file) != NULL; number++) {
        if (strstr(line, text) != NULL) {
            fclose(file);
            return number;
        }
    }
    fclose(file);
    fail_msg("no %s in %s", text, path);
    return 0;
}

static void function_has_line(struct image *image, const char *name, const char *mark)
{
    const struct image_symbol *function = symbol(image, name);
    int line = line_of(SOURCES "/image_six.c", mark);
    bool found = false;
    for (uint64_t vaddr = function->vaddr; vaddr < function->vaddr + function->size; vaddr++) {
        struct image_place place;
        image_where(image, vaddr, &place);
        assert_string_equal(place.function, name);
        assert_int_equal(place.offset, vaddr - function->vaddr);
        assert_string_equal(place.file, SOURCES "/image_six.c");
        assert_true(place.line > 0);
        found = found || place.line == line;
    }
    assert_true(found);
}

static void lines_are_found_in_every_form_of_debug_information(void **state)
{
    (void)state;
    if (under_valgrind())
        skip();
    static const char *const names[] = { "six.so", "six_lld.so", "six_dwarf4.so", "six_gz.so" };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct image *image = open_module(names[i]);
        assert_true(image->has_debug_lines);
        function_has_line(image, "hidden_function", "LINE hidden");
        function_has_line(image, "local_function", "LINE local");
        function_has_line(image, "Program_04", "LINE Program_04");
        image_close(image);
    }
}

static void address_past_the_code_has_no_line(void **state)
{
    (void)state;
    struct image *image = open_module("six.so");
    struct image_place place;
    const struct image_symbol *data = symbol(image, "counter");
    image_where(image, data->vaddr, &place);
    assert_null(place.file);
    assert_null(place.function);
    image_close(image);
}

/* ---- files ---- */

static void refused(const char *path, int error, const char *reason)
{
    struct image *image = (struct image *)path; /* anything but NULL */
    char why[IMAGE_WHY];
    assert_int_equal(image_open(&image, path, why), -error);
    assert_null(image);
    assert_non_null(strstr(why, path));
    assert_non_null(strstr(why, reason));
    assert_null(strchr(why, '\n'));
}

static void what_is_no_regular_file_is_refused(void **state)
{
    (void)state;
    char directory[] = "/tmp/test_image_XXXXXX", fifo[64];
    assert_non_null(mkdtemp(directory));
    snprintf(fifo, sizeof fifo, "%s/fifo", directory);
    assert_int_equal(mkfifo(fifo, 0600), 0);
    refused(directory, EISDIR, "is a directory");
    refused(fifo, EINVAL, "FIFO");
    refused("/dev/null", EINVAL, "character device");
    refused("/nonexistent/module.tgm", ENOENT, "No such file");
    refused("/etc/passwd/module.tgm", ENOTDIR, "Not a directory");
    unlink(fifo);
    snprintf(fifo, sizeof fifo, "%s/large", directory);
    FILE *large = fopen(fifo, "w");
    assert_non_null(large);
    assert_int_equal(ftruncate(fileno(large), (off_t)(1u << 30) + 1), 0);
    fclose(large);
    refused(fifo, EFBIG, "is larger than 1 GiB");
    unlink(fifo);
    rmdir(directory);
}

static void file_and_memory_give_the_same_image(void **state)
{
    (void)state;
    struct image *file = open_module("six.so");
    struct image *memory = open_bytes(file->bytes, file->size);
    assert_string_equal(file->sha256, memory->sha256);
    assert_int_equal(file->symbol_count, memory->symbol_count);
    assert_int_equal(file->reloc_count, memory->reloc_count);
    image_close(memory);
    image_close(file);
    image_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_layout_exports_the_six),
        cmocka_unit_test(every_layout_relocates_the_table),
        cmocka_unit_test(stack_statements),
        cmocka_unit_test(stripped_module_keeps_only_exports),
        cmocka_unit_test(filters_are_imports),
        cmocka_unit_test(start_module_has_everything_a_loader_would_do),
        cmocka_unit_test(weak_symbol_that_the_linker_made_null_is_an_import),
        cmocka_unit_test(old_module_has_its_constructor_list_and_writable_code),
        cmocka_unit_test(module_on_the_c_library_shows_what_it_wants),
        cmocka_unit_test(lines_are_found_in_every_form_of_debug_information),
        cmocka_unit_test(address_past_the_code_has_no_line),
        cmocka_unit_test(what_is_no_regular_file_is_refused),
        cmocka_unit_test(file_and_memory_give_the_same_image),
    };
    return cmocka_run_group_tests_name("image_real", tests, NULL, NULL);
}
