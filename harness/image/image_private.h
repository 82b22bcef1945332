/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_private.h - what the files of this room share and nobody else sees.
 */
#ifndef HARNESS_IMAGE_PRIVATE_H
#define HARNESS_IMAGE_PRIVATE_H

#include "image/image.h"

/*
 * States why the file can be no module. Only the first statement of an image counts: later ones
 * are mostly consequences. The sentence is made safe to print (the file's own names go into it).
 * Always false, so that a check reads `return image_defect(...)`.
 */
bool image_defect(struct image *image, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/*
 * Makes room for one more item at the end of an array with `count` used items. False when memory
 * ran out; the array is then untouched. The capacity is implied by the count (powers of two from
 * 16), so an array that grows through this function must only grow through this function.
 */
bool image_make_room(void *array_pointer, size_t count, size_t item_size);

/* Where the memory range [vaddr, vaddr + size) stands in the file. False unless one segment takes
 * all of it from the file. size > 0. */
bool image_file_range(const struct image *image, uint64_t vaddr, uint64_t size, uint64_t *offset);

/* The 8 little-endian bytes at a module address, zero where the file has none. */
uint64_t image_word(const struct image *image, uint64_t vaddr);

/* Describes an ELF file: fills the image, or its defect. 0 or negative errno (no memory). */
int elf_read(struct image *image);

/* libelf's handle on the image's bytes, NULL when there is none. End with elf_handle_free(). */
struct Elf;
struct Elf *elf_handle_new(const struct image *image);
void elf_handle_free(struct Elf *handle);

/* State behind image_where(). NULL when memory ran out. */
struct lines;
struct lines *lines_new(void);
void lines_free(struct lines *lines);

/* One step of the line table: code from vaddr on (to the next row) was made from this line. */
struct line_row {
    uint64_t vaddr;
    uint32_t file; /* where the file's name starts in text, plus 1; 0: no line from here on */
    uint32_t line;
    uint32_t order; /* of rows at one address the last one counts */
};

struct line_table {
    struct line_row *rows;
    size_t row_count;
    char *text; /* file names, each ended by a zero byte */
    size_t text_size;
};

/*
 * Reads the debug information of an image. libdw is handed hostile bytes here, so it works in a
 * child process that can only compute: whatever happens to it, the caller merely gets no table.
 * False when there is none. The table is checked (every file names a string in text) and owned by
 * the caller: free() rows and text.
 */
bool lines_extract(const struct image *image, struct line_table *table);

#endif
