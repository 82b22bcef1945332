/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * lines.c - an address as a person wants to read it: function + offset, file:line.
 */
#include "image/image_private.h"

#include <limits.h>
#include <stdlib.h>

struct lines {
    bool tried;
    struct line_table table; /* rows sorted by address */
};

struct lines *lines_new(void)
{
    return calloc(1, sizeof(struct lines));
}

void lines_free(struct lines *lines)
{
    if (lines == NULL)
        return;
    free(lines->table.rows);
    free(lines->table.text);
    free(lines);
}

static int compare_rows(const void *left, const void *right)
{
    const struct line_row *a = left, *b = right;
    if (a->vaddr != b->vaddr)
        return a->vaddr < b->vaddr ? -1 : 1;
    /* Where one function ends another may begin: the beginning counts. */
    if ((a->file == 0) != (b->file == 0))
        return a->file == 0 ? -1 : 1;
    return (a->order > b->order) - (a->order < b->order);
}

static void load(const struct image *image, struct lines *lines)
{
    if (lines->tried)
        return;
    lines->tried = true;
    if (image->has_debug_lines && lines_extract(image, &lines->table))
        qsort(lines->table.rows, lines->table.row_count, sizeof lines->table.rows[0], compare_rows);
}

/*
 * Of several rows for one address the last one is what the instruction belongs to; the first one is
 * where a function begins, and who asks for the function wants that.
 */
static void find_line(const struct line_table *table, uint64_t vaddr, bool want_first,
                      struct image_place *place)
{
    size_t low = 0, high = table->row_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (table->rows[middle].vaddr <= vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0)
        return;
    const struct line_row *row = &table->rows[low - 1];
    while (want_first && row > table->rows && row[-1].vaddr == vaddr && row[-1].file != 0)
        row--;
    if (row->file == 0)
        return;
    place->file = table->text + row->file - 1;
    place->line = row->line <= INT_MAX ? (int)row->line : 0;
}

/* True when a names the code at an address better than b; both begin at or below it. */
static bool names_better(const struct image_symbol *a, const struct image_symbol *b)
{
    if (a->vaddr != b->vaddr)
        return a->vaddr > b->vaddr;
    if (a->exported != b->exported)
        return a->exported;
    return a->kind == IMAGE_SYMBOL_FUNC && b->kind != IMAGE_SYMBOL_FUNC;
}

/*
 * A function that says how long it is and holds the address beats a mere label inside it (hand
 * written assembly). A label without a length reaches to the next symbol of any kind, so it never
 * claims what lies behind a function that ended.
 */
static const struct image_symbol *function_of(const struct image *image, uint64_t vaddr)
{
    const struct image_symbol *holder = NULL, *nearest = NULL;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->vaddr > vaddr)
            break;
        if (!symbol->executable)
            continue;
        if (symbol->size != 0 && vaddr - symbol->vaddr < symbol->size &&
            (holder == NULL || names_better(symbol, holder)))
            holder = symbol;
        if (nearest == NULL || names_better(symbol, nearest))
            nearest = symbol;
    }
    if (holder != NULL)
        return holder;
    if (nearest == NULL || nearest->size != 0)
        return NULL;
    return image_segment_at(image, nearest->vaddr, vaddr - nearest->vaddr + 1) != NULL ? nearest
                                                                                       : NULL;
}

void image_where(const struct image *image, uint64_t vaddr, struct image_place *place)
{
    *place = (struct image_place){ 0 };
    const struct image_segment *segment = image_segment_at(image, vaddr, 1);
    if (segment == NULL || (segment->perm & IMAGE_EXEC) == 0)
        return;
    const struct image_symbol *function = function_of(image, vaddr);
    if (function != NULL) {
        place->function = function->name;
        place->offset = vaddr - function->vaddr;
    }
    struct lines *lines = image->lines;
    load(image, lines);
    find_line(&lines->table, vaddr, function != NULL && place->offset == 0, place);
}
