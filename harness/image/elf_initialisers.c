/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_initialisers.c - code that a dynamic linker runs before and after everybody else.
 *
 * e_entry is not among it: no loader calls the entry point of a shared object.
 */
#include "image/elf.h"

#include <stdlib.h>
#include <string.h>

typedef unsigned long long ull;

static int compare_to_reloc(const void *key, const void *item)
{
    const uint64_t *vaddr = key;
    const struct image_reloc *reloc = item;
    return (*vaddr > reloc->vaddr) - (*vaddr < reloc->vaddr);
}

/* The function whose address stands at slot once the module is loaded, 0 when it comes from
 * elsewhere. */
static uint64_t function_at(const struct elf *elf, uint64_t slot, bool *patched)
{
    const struct image *image = elf->image;
    const struct image_reloc *reloc = image->reloc_count == 0
                                          ? NULL
                                          : bsearch(&slot, image->relocs, image->reloc_count,
                                                    sizeof image->relocs[0], compare_to_reloc);
    *patched = reloc != NULL;
    if (reloc == NULL)
        return image_word(image, slot, elf->kind->word);
    if (reloc->kind == IMAGE_RELOC_RELATIVE)
        return (uint64_t)reloc->addend & elf->kind->address_max;
    if (reloc->type != elf->kind->reloc_absolute || reloc->symbol == NULL)
        return 0;
    const struct image_symbol *symbol = elf_find_export(elf, reloc->symbol);
    return symbol != NULL ? (symbol->vaddr + (uint64_t)reloc->addend) & elf->kind->address_max : 0;
}

static bool add_initialiser(struct elf *elf, const char *what, uint64_t vaddr, uint64_t index)
{
    struct image *image = elf->image;
    if (image->initialiser_count == IMAGE_MAX_INITIALISERS)
        return image_defect(image, "has more than %u initialisers", IMAGE_MAX_INITIALISERS);
    if (!image_make_room(&image->initialisers, image->initialiser_count,
                         sizeof image->initialisers[0]))
        return elf_out_of_memory(elf);
    image->initialisers[image->initialiser_count++] =
        (struct image_initialiser){ .what = what,
                                    .vaddr = elf->kind->thumb ? vaddr & ~(uint64_t)1 : vaddr,
                                    .index = (unsigned)index };
    return true;
}

static bool read_array(struct elf *elf, enum elf_tag where, enum elf_tag size_tag)
{
    uint64_t size = elf->tag[size_tag], vaddr = elf->tag[where], offset;
    unsigned word = elf->kind->word;
    bool patched;
    if (elf->has_tag[where] != elf->has_tag[size_tag])
        return image_defect(elf->image, "dynamic table has only one of %s and %s",
                            elf_tag_name(where), elf_tag_name(size_tag));
    if (size == 0)
        return true;
    if (size % word != 0)
        return image_defect(elf->image, "%s is %llu, allowed is a multiple of %u",
                            elf_tag_name(size_tag), (ull)size, word);
    if (!image_file_range(elf->image, vaddr, size, &offset))
        return image_defect(elf->image,
                            "%s: 0x%llx bytes at 0x%llx do not lie in the file's part of one "
                            "segment",
                            elf_tag_name(where), (ull)size, (ull)vaddr);
    for (uint64_t i = 0; i < size / word; i++) {
        if (!add_initialiser(elf, elf_tag_name(where), function_at(elf, vaddr + word * i, &patched),
                             i))
            return false;
    }
    return true;
}

static bool read_function(struct elf *elf, enum elf_tag tag)
{
    return !elf->has_tag[tag] || add_initialiser(elf, elf_tag_name(tag), elf->tag[tag], 0);
}

/* Old compilers' lists of constructors, run by DT_INIT: -1, functions, 0. */
static bool read_old_list(struct elf *elf, const Elf64_Shdr *section, const char *what)
{
    uint64_t offset;
    unsigned word = elf->kind->word;
    if (section->sh_size < word ||
        !image_file_range(elf->image, section->sh_addr, section->sh_size, &offset))
        return true;
    for (uint64_t i = 0; i < section->sh_size / word; i++) {
        bool patched;
        uint64_t function = function_at(elf, section->sh_addr + word * i, &patched);
        if (!patched && (function == 0 || function == elf->kind->address_max))
            continue;
        if (!add_initialiser(elf, what, function, i))
            return false;
    }
    return true;
}

static bool read_old_lists(struct elf *elf)
{
    static const char *const lists[] = { ".ctors", ".dtors" };
    Elf64_Shdr header;
    const char *name;
    for (size_t i = 1; elf_section(elf, i, &header, &name); i++) {
        for (size_t k = 0; k < sizeof lists / sizeof lists[0]; k++) {
            if (strcmp(name, lists[k]) == 0 && (header.sh_flags & SHF_ALLOC) != 0 &&
                !read_old_list(elf, &header, lists[k]))
                return false;
        }
    }
    return true;
}

bool elf_read_initialisers(struct elf *elf)
{
    return read_array(elf, ELF_PREINIT_ARRAY, ELF_PREINIT_ARRAYSZ) &&
           read_function(elf, ELF_INIT) && read_array(elf, ELF_INIT_ARRAY, ELF_INIT_ARRAYSZ) &&
           read_array(elf, ELF_FINI_ARRAY, ELF_FINI_ARRAYSZ) && read_function(elf, ELF_FINI) &&
           read_old_lists(elf);
}
