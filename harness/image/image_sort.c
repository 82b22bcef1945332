/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_sort.c - the order that image.h promises for symbols and relocations.
 */
#include "image/image_private.h"

#include <stdlib.h>
#include <string.h>

typedef unsigned long long ull;

static int compare_symbols(const void *left, const void *right)
{
    const struct image_symbol *a = left, *b = right;
    if (a->vaddr != b->vaddr)
        return a->vaddr < b->vaddr ? -1 : 1;
    int order = a->name == b->name ? 0 : strcmp(a->name, b->name);
    if (order != 0)
        return order;
    if (a->exported != b->exported)
        return a->exported ? -1 : 1;
    if (a->size != b->size)
        return a->size > b->size ? -1 : 1;
    return (a->kind > b->kind) - (a->kind < b->kind);
}

void image_sort_symbols(struct image *image)
{
    struct image_symbol *symbols = image->symbols;
    size_t kept = 0;
    if (image->symbol_count == 0)
        return;
    qsort(symbols, image->symbol_count, sizeof symbols[0], compare_symbols);
    for (size_t i = 1; i < image->symbol_count; i++) {
        if (symbols[i].vaddr != symbols[kept].vaddr ||
            strcmp(symbols[i].name, symbols[kept].name) != 0)
            symbols[++kept] = symbols[i];
    }
    image->symbol_count = kept + 1;
}

static int compare_relocs(const void *left, const void *right)
{
    const struct image_reloc *a = left, *b = right;
    return (a->vaddr > b->vaddr) - (a->vaddr < b->vaddr);
}

/* Two relocations of one word: the result depends on the order in which a loader goes. */
bool image_sort_relocs(struct image *image)
{
    struct image_reloc *relocs = image->relocs;
    if (image->reloc_count != 0)
        qsort(relocs, image->reloc_count, sizeof relocs[0], compare_relocs);
    for (size_t i = 1; i < image->reloc_count; i++) {
        unsigned width = relocs[i - 1].width;
        if (relocs[i].vaddr - relocs[i - 1].vaddr < (width != 0 ? width : 1))
            return image_defect(image,
                                "two relocations patch the same bytes (%s at 0x%llx, %s at "
                                "0x%llx)",
                                relocs[i - 1].type_name, (ull)relocs[i - 1].vaddr,
                                relocs[i].type_name, (ull)relocs[i].vaddr);
    }
    return true;
}
