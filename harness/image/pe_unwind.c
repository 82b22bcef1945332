/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_unwind.c - how long functions are, from the exception directory of a PE32+ file (.pdata): the
 * only place where such a file says it. Hints only: an entry that does not hold is left out.
 */
#include "image/pe.h"

enum { UNWIND_ENTRY = 12 }; /* BeginAddress, EndAddress, UnwindInfoAddress */

/* The first symbol at or behind an address. */
static size_t first_symbol(const struct image *image, uint64_t vaddr)
{
    size_t low = 0, high = image->symbol_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (image->symbols[middle].vaddr < vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void add_size(struct image *image, uint32_t begin, uint32_t end)
{
    if (end <= begin || image_segment_at(image, begin, end - begin) == NULL)
        return;
    for (size_t i = first_symbol(image, begin);
         i < image->symbol_count && image->symbols[i].vaddr == begin; i++) {
        if (image->symbols[i].executable && image->symbols[i].size == 0)
            image->symbols[i].size = end - begin;
    }
}

void pe_read_unwind(struct pe *pe)
{
    const struct pe_directory *directory = &pe->directory[PE_EXCEPTION];
    if (pe->word != 8 || directory->size < UNWIND_ENTRY)
        return;
    const uint8_t *at = pe_bytes(pe, directory->vaddr, directory->size);
    if (at == NULL)
        return;
    for (uint32_t i = 0; i < directory->size / UNWIND_ENTRY; i++, at += UNWIND_ENTRY)
        add_size(pe->image, pe_u32(at), pe_u32(at + 4));
}
