/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_relocs.c - the base relocations: every word that has to change when the module does not lie at
 * its ImageBase.
 */
#include "image/pe.h"

#include <stdlib.h>

typedef unsigned long long ull;

enum { BASED_ABSOLUTE = 0, BASED_HIGHLOW = 3, BASED_HIGHADJ = 4, BASED_DIR64 = 10 };

static const struct {
    const char *name;
    unsigned width;
} types[16] = {
    [1] = { "IMAGE_REL_BASED_HIGH", 2 },
    [2] = { "IMAGE_REL_BASED_LOW", 2 },
    [BASED_HIGHLOW] = { "IMAGE_REL_BASED_HIGHLOW", 4 },
    [BASED_HIGHADJ] = { "IMAGE_REL_BASED_HIGHADJ", 2 },
    [BASED_DIR64] = { "IMAGE_REL_BASED_DIR64", 8 },
};

static bool add_reloc(struct pe *pe, uint64_t vaddr, unsigned type)
{
    struct image *image = pe->image;
    unsigned width = types[type].width;
    bool relative = type == (pe->word == 8 ? BASED_DIR64 : BASED_HIGHLOW);
    struct image_reloc reloc = { .vaddr = vaddr,
                                 .kind = relative ? IMAGE_RELOC_RELATIVE : IMAGE_RELOC_OTHER,
                                 .type = type,
                                 .type_name = types[type].name != NULL ? types[type].name : "?",
                                 .width = width };
    if (image_segment_at(image, vaddr, width != 0 ? width : 1) == NULL)
        return image_defect(image, "base relocation (%s) patches 0x%llx, which lies in no section",
                            reloc.type_name, (ull)vaddr);
    if (relative) {
        uint64_t addend = image_word(image, vaddr, pe->word) - image->base;
        reloc.addend = pe->word == 4 ? (int32_t)(uint32_t)addend : (int64_t)addend;
    }
    return pe_add_reloc(pe, &reloc);
}

static bool read_block(struct pe *pe, uint64_t page, const uint8_t *entries, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        unsigned entry = pe_u16(entries + (size_t)2 * i), type = entry >> 12;
        if (type != BASED_ABSOLUTE && !add_reloc(pe, page + (entry & 0xfff), type))
            return false;
        if (type != BASED_HIGHADJ)
            continue;
        if (++i == count)
            return image_defect(pe->image,
                                "base relocation block for page 0x%llx ends in the middle of an "
                                "IMAGE_REL_BASED_HIGHADJ",
                                (ull)page);
    }
    return true;
}

static bool read_blocks(struct pe *pe, const uint8_t *at, uint32_t room)
{
    while (room != 0) {
        uint32_t page = room >= 8 ? pe_u32(at) : 0, size = room >= 8 ? pe_u32(at + 4) : 0;
        if (size < 8 || size > room || size % 4 != 0)
            return image_defect(pe->image,
                                "base relocation block for page 0x%x has 0x%x bytes (SizeOfBlock), "
                                "allowed is a multiple of 4 from 8 to the 0x%x that are left",
                                page, size, room);
        if (page % IMAGE_PAGE != 0)
            return image_defect(pe->image,
                                "base relocation block for 0x%x (VirtualAddress), allowed is a "
                                "multiple of 0x1000",
                                page);
        if (!read_block(pe, page, at + 8, (size - 8) / 2))
            return false;
        at += size;
        room -= size;
    }
    return true;
}

bool pe_read_relocs(struct pe *pe)
{
    const struct pe_directory *directory = &pe->directory[PE_RELOC];
    const uint8_t *at = NULL;
    if (directory->size != 0) {
        at = pe_bytes(pe, directory->vaddr, directory->size);
        if (at == NULL)
            return image_defect(pe->image,
                                "base relocation directory (0x%x, 0x%x bytes) does not lie in the "
                                "file's part of one section",
                                directory->vaddr, directory->size);
        if (pe->relocs_stripped)
            return image_defect(pe->image,
                                "has base relocations and IMAGE_FILE_RELOCS_STRIPPED, which says "
                                "that it has none");
    }
    return (at == NULL || read_blocks(pe, at, directory->size)) && image_sort_relocs(pe->image);
}

/* The first relocation that reaches past vaddr. */
static size_t first_reloc(const struct image *image, uint64_t vaddr)
{
    size_t low = 0, high = image->reloc_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const struct image_reloc *reloc = &image->relocs[middle];
        if (reloc->vaddr + (reloc->width != 0 ? reloc->width : 1) <= vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

bool pe_check_relocs(struct pe *pe)
{
    static const enum pe_directory_index fixed[] = { PE_EXPORT, PE_IMPORT, PE_RELOC,
                                                     PE_DELAY_IMPORT };
    const struct image *image = pe->image;
    for (size_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++) {
        const struct pe_directory *directory = &pe->directory[fixed[i]];
        size_t index = first_reloc(image, directory->vaddr);
        if (directory->size == 0 || index == image->reloc_count)
            continue;
        /* mingw calls its whole .idata section the import directory, the slots included. */
        while (fixed[i] == PE_IMPORT && index < image->reloc_count &&
               image->relocs[index].type == IMAGE_RELOC_IAT)
            index++;
        if (index < image->reloc_count &&
            image->relocs[index].vaddr < (uint64_t)directory->vaddr + directory->size)
            return image_defect(pe->image,
                                "a relocation patches 0x%llx, which is part of the %s: what it "
                                "says depends on where the module lies",
                                (ull)image->relocs[index].vaddr, pe_directory_name(fixed[i]));
    }
    return true;
}

bool pe_pointer(struct pe *pe, const char *what, uint64_t vaddr, uint64_t *target, bool *null)
{
    const struct image *image = pe->image;
    const uint8_t *at = pe_bytes(pe, vaddr, pe->word);
    if (at == NULL)
        return image_defect(pe->image, "%s at 0x%llx does not lie in the file's part of a section",
                            what, (ull)vaddr);
    size_t index = first_reloc(image, vaddr);
    bool patched = index < image->reloc_count && image->relocs[index].vaddr == vaddr &&
                   image->relocs[index].kind == IMAGE_RELOC_RELATIVE;
    uint64_t word = pe_word(pe, at), top = pe->word == 4 ? UINT32_MAX : UINT64_MAX;
    *null = word == 0 && !patched;
    *target = (word - image->base) & top;
    if (!*null && !patched && !image->fixed)
        return image_defect(pe->image,
                            "%s at 0x%llx holds 0x%llx, right at ImageBase only: no relocation "
                            "changes it",
                            what, (ull)vaddr, (ull)word);
    return true;
}
