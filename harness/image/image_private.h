/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_private.h - what the files of this room share and nobody else sees.
 */
#ifndef HARNESS_IMAGE_PRIVATE_H
#define HARNESS_IMAGE_PRIVATE_H

#include "image/image.h"

/* More than any controller program has, and few enough that no file makes the reader slow. */
#define IMAGE_MAX_SPAN         (256u << 20)
#define IMAGE_MAX_SYMBOLS      (1u << 18)
#define IMAGE_MAX_RELOCS       (1u << 20)
#define IMAGE_MAX_IMPORTS      (1u << 18)
#define IMAGE_MAX_INITIALISERS (1u << 16)
#define IMAGE_MAX_NAME         1024u
#define IMAGE_PAGE             4096u

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

/* The width (up to 8) little-endian bytes at a module address, zero where the file has none. */
uint64_t image_word(const struct image *image, uint64_t vaddr, unsigned width);

/* Sorts the symbols by address, then name; of equal ones the exported one stays. */
void image_sort_symbols(struct image *image);
/* Sorts the relocations; a defect when two patch the same byte. */
bool image_sort_relocs(struct image *image);

/*
 * A copy of some text that lives as long as the image, for a name that does not stand in the file
 * as it is. NULL when memory ran out or, with a defect, when a file asks for more than 16 MiB of
 * it.
 */
const char *image_text(struct image *image, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void image_free_texts(struct image *image);

/*
 * Describe a file of their kind: fill the image, or its defect. 0 or negative errno (no memory).
 * flat_recognise() says by name and beginning whether the file is one of the vendor's kinds that
 * have no magic number; then the image is described.
 */
int elf_read(struct image *image);
int pe_read(struct image *image);
bool flat_recognise(struct image *image, int *error);

/* A file with the PE image's debug sections and nothing else, for libdw: an ELF file in memory that
 * the caller frees. NULL when there are none or memory ran out. */
void *pe_debug_as_elf(const struct image *image, size_t *size);

/* libelf's handle on the image's bytes, NULL when there is none. End with elf_handle_free(). */
struct Elf;
struct Elf *elf_handle_new(const void *bytes, size_t size);
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
 * Runs work(image, block) in a child process that can do nothing but compute; block is shared
 * memory, and untrusted afterwards. False when there can be no such process or it ended badly.
 */
bool image_in_child(void (*work)(const struct image *, void *), const struct image *image,
                    void *block);

/* State behind image_routine(). NULL when memory ran out. */
struct stack_routines;
struct stack_routines *stack_new(void);
void stack_free(struct stack_routines *routines);

/* The work of image_routine() and image_code(), for the child: fills everything but vaddr, and a
 * census that was zero (census.h). */
struct census;
void stack_measure(const struct image *image, struct image_routine *routines, size_t count,
                   struct census *census);

/*
 * Reads the debug information of an image. libdw is handed hostile bytes here, so it works in a
 * child process that can only compute: whatever happens to it, the caller merely gets no table.
 * False when there is none. The table is checked (every file names a string in text) and owned by
 * the caller: free() rows and text.
 */
bool lines_extract(const struct image *image, struct line_table *table);

#endif
