/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_initialisers.c - the TLS directory: how much thread-local storage, and the functions that a
 * loader calls with every thread. And mingw's lists of constructors, which its run-time library
 * walks from the entry point; Microsoft's (.CRT$XC) have no name that a linked module would keep.
 */
#include "image/pe.h"

#include <string.h>

typedef unsigned long long ull;

static bool add_initialiser(struct pe *pe, const char *what, uint64_t vaddr, unsigned index)
{
    struct image *image = pe->image;
    if (image->initialiser_count == IMAGE_MAX_INITIALISERS)
        return image_defect(image, "has more than %u initialisers", IMAGE_MAX_INITIALISERS);
    if (!image_make_room(&image->initialisers, image->initialiser_count,
                         sizeof image->initialisers[0]))
        return pe_out_of_memory(pe);
    image->initialisers[image->initialiser_count++] =
        (struct image_initialiser){ .what = what, .vaddr = vaddr, .index = index };
    return true;
}

static bool read_callbacks(struct pe *pe, uint64_t array)
{
    for (unsigned i = 0;; i++) {
        uint64_t target;
        bool null;
        if (!pe_pointer(pe, "TLS callback", array + (uint64_t)i * pe->word, &target, &null))
            return false;
        if (null)
            return true;
        if (image_segment_at(pe->image, target, 1) == NULL)
            return image_defect(pe->image, "TLS callback %u at 0x%llx lies in no section", i,
                                (ull)target);
        if (!add_initialiser(pe, "TLS callback", target, i))
            return false;
    }
}

/* The template for each thread's block: [start, end), then zeroes. */
static bool read_template(struct pe *pe, uint64_t vaddr, uint32_t zeroes)
{
    uint64_t start, end;
    bool no_start, no_end;
    if (!pe_pointer(pe, "TLS StartAddressOfRawData", vaddr, &start, &no_start) ||
        !pe_pointer(pe, "TLS EndAddressOfRawData", vaddr + pe->word, &end, &no_end))
        return false;
    uint64_t size = no_start || no_end ? 0 : end - start;
    if (no_start != no_end || (size != 0 && image_segment_at(pe->image, start, size) == NULL))
        return image_defect(pe->image,
                            "TLS directory: the template from 0x%llx to 0x%llx lies in no section",
                            (ull)start, (ull)end);
    if (size + zeroes > IMAGE_MAX_SPAN)
        return image_defect(pe->image, "TLS directory: SizeOfZeroFill is 0x%x, allowed are 256 MiB",
                            zeroes);
    pe->image->has_tls = true;
    pe->image->tls_size = size + zeroes;
    return true;
}

bool pe_read_tls(struct pe *pe)
{
    const struct pe_directory *directory = &pe->directory[PE_TLS];
    uint64_t vaddr = directory->vaddr, target;
    uint32_t size = 4 * pe->word + 8;
    bool null;
    if (directory->size == 0)
        return true;
    const uint8_t *at = directory->size >= size ? pe_bytes(pe, vaddr, size) : NULL;
    if (at == NULL)
        return image_defect(pe->image,
                            "TLS directory (0x%x, 0x%x bytes): its %u bytes do not lie in the "
                            "file's part of one section",
                            directory->vaddr, directory->size, size);
    if (!read_template(pe, vaddr, pe_u32(at + 4 * pe->word)) ||
        !pe_pointer(pe, "TLS AddressOfIndex", vaddr + 2 * pe->word, &target, &null))
        return false;
    if (null || image_segment_at(pe->image, target, 4) == NULL)
        return image_defect(pe->image, "TLS AddressOfIndex lies in no section");
    if (!pe_pointer(pe, "TLS AddressOfCallBacks", vaddr + 3 * pe->word, &target, &null))
        return false;
    return null || read_callbacks(pe, target);
}

/* -1, functions, 0. Found by a symbol's name, so a list that makes no sense is left out. */
static bool read_list(struct pe *pe, const char *what, uint64_t vaddr)
{
    uint64_t offset, ones = pe->word == 4 ? UINT32_MAX : UINT64_MAX;
    for (unsigned i = 0; pe->image->initialiser_count < IMAGE_MAX_INITIALISERS; i++) {
        uint64_t word = image_word(pe->image, vaddr, pe->word);
        if (!image_file_range(pe->image, vaddr, pe->word, &offset) || word == 0)
            return true;
        uint64_t target = (word - pe->image->base) & ones;
        if (word != ones && image_segment_at(pe->image, target, 1) != NULL &&
            !add_initialiser(pe, what, target, i))
            return false;
        vaddr += pe->word;
    }
    return true;
}

bool pe_read_lists(struct pe *pe)
{
    static const struct {
        const char *symbol, *what;
    } lists[] = { { "__CTOR_LIST__", ".ctors" }, { "__DTOR_LIST__", ".dtors" } };
    const struct image *image = pe->image;
    for (size_t k = 0; k < sizeof lists / sizeof lists[0]; k++) {
        size_t i = 0;
        while (i < image->symbol_count && strcmp(image->symbols[i].name, lists[k].symbol) != 0)
            i++;
        if (i < image->symbol_count && !read_list(pe, lists[k].what, image->symbols[i].vaddr))
            return false;
    }
    return true;
}
