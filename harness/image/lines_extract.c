/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * lines_extract.c - the line table of a module, through libdw, in a process of its own.
 *
 * Debug information is the largest and most intricate part of a module file and nothing needs it
 * to run. Checking it before libdw sees it would mean writing libdw again; so the child that reads
 * it has no system call but those that get memory and end it, and limits on memory and time.
 */
#include "image/image_private.h"

#include <dwarf.h>
#include <elfutils/libdw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define MAX_ROWS (1u << 20)
#define MAX_TEXT (4u << 20)
#define MAX_PATH 4096u

/* Written by the child, untrusted. */
struct block {
    uint32_t complete;
    uint32_t row_count;
    uint32_t text_size;
    struct line_row rows[MAX_ROWS];
    char text[MAX_TEXT];
};

/* ---- in the child ---- */

/* The name as it was given to the compiler: libdw puts the compiler's directory in front. */
static const char *recorded_name(const char *path, const char *directory)
{
    size_t length = directory != NULL ? strlen(directory) : 0;
    if (length != 0 && strncmp(path, directory, length) == 0 && path[length] == '/')
        path += length + 1;
    while (strncmp(path, "./", 2) == 0)
        path += 2;
    return path;
}

/* Place of the name in the block plus 1, 0 when there is no room. */
static uint32_t add_name(struct block *block, Dwarf_Files *files, size_t index)
{
    const char *const *directories = NULL;
    size_t directory_count = 0;
    const char *path = dwarf_filesrc(files, index, NULL, NULL);
    if (path == NULL)
        return 0;
    if (dwarf_getsrcdirs(files, &directories, &directory_count) != 0 || directory_count == 0)
        directories = NULL;
    path = recorded_name(path, directories != NULL ? directories[0] : NULL);
    size_t length = strnlen(path, MAX_PATH) + 1;
    if (length > MAX_PATH || length > MAX_TEXT - block->text_size)
        return 0;
    uint32_t place = block->text_size + 1;
    memcpy(block->text + block->text_size, path, length);
    block->text_size += (uint32_t)length;
    return place;
}

/* names: per file of this table its place in the block, UINT32_MAX while unknown. */
static void add_row(const struct image *image, struct block *block, Dwarf_Line *line,
                    uint32_t *names, size_t name_count)
{
    Dwarf_Addr vaddr;
    Dwarf_Files *files;
    size_t index;
    int number = 0;
    bool end = false;
    if (block->row_count == MAX_ROWS || dwarf_lineaddr(line, &vaddr) != 0)
        return;
    /* Debug information of a PE file counts on its preferred address. */
    vaddr -= image->base;
    if (dwarf_lineno(line, &number) != 0 || number < 0)
        number = 0;
    /* Lines of functions that the linker threw away start at 0. The end of a function may be the
     * end of its segment. */
    const struct image_segment *segment = image_segment_at(image, vaddr, 1);
    if (dwarf_lineendsequence(line, &end) != 0 || end)
        segment = vaddr != 0 ? image_segment_at(image, vaddr - 1, 1) : NULL;
    if (segment == NULL || (segment->perm & IMAGE_EXEC) == 0)
        return;
    uint32_t name = 0;
    if (!end && dwarf_line_file(line, &files, &index) == 0 && index < name_count) {
        if (names[index] == UINT32_MAX)
            names[index] = add_name(block, files, index);
        name = names[index];
    }
    block->rows[block->row_count] = (struct line_row){
        .vaddr = vaddr, .file = name, .line = (uint32_t)number, .order = block->row_count
    };
    block->row_count++;
}

static void add_table(const struct image *image, struct block *block, Dwarf_Lines *lines,
                      size_t line_count, size_t file_count)
{
    uint32_t *names = malloc((file_count + 1) * sizeof names[0]);
    if (names == NULL)
        return;
    memset(names, 0xff, (file_count + 1) * sizeof names[0]);
    for (size_t i = 0; i < line_count; i++)
        add_row(image, block, dwarf_onesrcline(lines, i), names, file_count);
    free(names);
}

struct declarations {
    const struct image *image;
    struct block *block;
    Dwarf_Files *files;
    uint32_t *names;
    size_t name_count;
};

/* A function begins, for a person, on the line that declares it, not on that of its first
 * instruction. Added before the lines of the instructions, this row is the first of its address. */
static int add_declaration(Dwarf_Die *function, void *argument)
{
    struct declarations *d = argument;
    struct block *block = d->block;
    Dwarf_Attribute attribute;
    Dwarf_Addr vaddr;
    Dwarf_Word index;
    int number;
    if (block->row_count == MAX_ROWS || dwarf_lowpc(function, &vaddr) != 0 ||
        dwarf_decl_line(function, &number) != 0 || number <= 0)
        return DWARF_CB_OK;
    vaddr -= d->image->base;
    const struct image_segment *segment = image_segment_at(d->image, vaddr, 1);
    if (segment == NULL || (segment->perm & IMAGE_EXEC) == 0)
        return DWARF_CB_OK;
    if (dwarf_formudata(dwarf_attr_integrate(function, DW_AT_decl_file, &attribute), &index) != 0 ||
        index >= d->name_count)
        return DWARF_CB_OK;
    if (d->names[index] == UINT32_MAX)
        d->names[index] = add_name(block, d->files, index);
    if (d->names[index] == 0)
        return DWARF_CB_OK;
    block->rows[block->row_count] = (struct line_row){
        .vaddr = vaddr, .file = d->names[index], .line = (uint32_t)number, .order = block->row_count
    };
    block->row_count++;
    return DWARF_CB_OK;
}

static void add_declarations(const struct image *image, struct block *block, Dwarf *dwarf)
{
    Dwarf_Off offset = 0, next;
    size_t header;
    Dwarf_Die unit;
    struct declarations d = { .image = image, .block = block };
    while (dwarf_nextcu(dwarf, offset, &next, &header, NULL, NULL, NULL) == 0 && next > offset) {
        if (dwarf_offdie(dwarf, offset + header, &unit) != NULL &&
            dwarf_getsrcfiles(&unit, &d.files, &d.name_count) == 0) {
            d.names = malloc((d.name_count + 1) * sizeof d.names[0]);
            if (d.names == NULL)
                return;
            memset(d.names, 0xff, (d.name_count + 1) * sizeof d.names[0]);
            dwarf_getfuncs(&unit, add_declaration, &d, 0);
            free(d.names);
        }
        offset = next;
    }
}

static void extract(const struct image *image, void *shared)
{
    struct block *block = shared;
    size_t size = image->size;
    void *rewritten = image->format == IMAGE_FORMAT_PE ? pe_debug_as_elf(image, &size) : NULL;
    if (image->format == IMAGE_FORMAT_PE && rewritten == NULL)
        return;
    Elf *elf = elf_handle_new(rewritten != NULL ? rewritten : image->bytes, size);
    Dwarf *dwarf = elf != NULL ? dwarf_begin_elf(elf, DWARF_C_READ, NULL) : NULL;
    Dwarf_Off offset = 0, next;
    Dwarf_Files *files;
    Dwarf_Lines *lines;
    Dwarf_CU *unit = NULL; /* dwarf_next_lines() goes on from it */
    size_t file_count, line_count;
    if (dwarf == NULL)
        return;
    add_declarations(image, block, dwarf);
    while (dwarf_next_lines(dwarf, offset, &next, &unit, &files, &file_count, &lines,
                            &line_count) == 0 &&
           next > offset) {
        add_table(image, block, lines, line_count, file_count);
        offset = next;
    }
    block->complete = 1;
}

/* ---- in the parent ---- */

static bool block_holds(const struct block *block)
{
    if (block->complete != 1 || block->row_count == 0 || block->row_count > MAX_ROWS ||
        block->text_size == 0 || block->text_size > MAX_TEXT ||
        block->text[block->text_size - 1] != '\0')
        return false;
    for (uint32_t i = 0; i < block->row_count; i++) {
        if (block->rows[i].file > block->text_size)
            return false;
    }
    return true;
}

static bool copy_block(const struct block *block, struct line_table *table)
{
    size_t rows_size = block->row_count * sizeof table->rows[0];
    table->rows = malloc(rows_size);
    table->text = malloc(block->text_size);
    if (table->rows == NULL || table->text == NULL) {
        free(table->rows);
        free(table->text);
        *table = (struct line_table){ 0 };
        return false;
    }
    memcpy(table->rows, block->rows, rows_size);
    memcpy(table->text, block->text, block->text_size);
    table->row_count = block->row_count;
    table->text_size = block->text_size;
    return true;
}

bool lines_extract(const struct image *image, struct line_table *table)
{
    struct block *block = mmap(NULL, sizeof *block, PROT_READ | PROT_WRITE,
                               MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    *table = (struct line_table){ 0 };
    if (block == MAP_FAILED)
        return false;
    bool done = image_in_child(extract, image, block) && block_holds(block) && copy_block(block, table);
    munmap(block, sizeof *block);
    return done;
}
