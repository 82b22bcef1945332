/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_imports.c - the import directory and the delay import directory: which functions of which
 * libraries the module wants.
 *
 * Linkers leave a directory that holds nothing but its end mark: that is no import.
 */
#include "image/pe.h"

typedef unsigned long long ull;

bool pe_add_import(struct pe *pe, const struct image_import *import)
{
    struct image *image = pe->image;
    if (image->import_count == IMAGE_MAX_IMPORTS)
        return image_defect(image, "has more than %u imports", IMAGE_MAX_IMPORTS);
    if (!image_make_room(&image->imports, image->import_count, sizeof *import))
        return pe_out_of_memory(pe);
    image->imports[image->import_count++] = *import;
    return true;
}

/* One library: its functions stand in names, their addresses go to slots. */
struct library {
    const char *name;
    uint32_t names, slots;
    bool delayed;
};

/* Names the function that a word of the name table asks for. */
static const char *function_name(struct pe *pe, const struct library *library, uint64_t at,
                                 uint64_t word)
{
    uint64_t top = (uint64_t)1 << (8 * pe->word - 1);
    const char *name = NULL, *made;
    if ((word & top) != 0 && (word & ~top) <= UINT16_MAX) {
        made = image_text(pe->image, "%s!#%u", library->name, (unsigned)(word & UINT16_MAX));
    } else {
        if ((word & top) == 0 && word <= INT32_MAX)
            name = pe_string(pe, word + 2);
        if (name == NULL) {
            image_defect(pe->image,
                         "import from %.64s: the word 0x%llx at 0x%llx is neither an ordinal nor "
                         "the address of a name",
                         library->name, (ull)word, (ull)at);
            return NULL;
        }
        made = image_text(pe->image, "%s!%s", library->name, name);
    }
    if (made == NULL && pe->image->defect[0] == '\0')
        pe_out_of_memory(pe);
    return made;
}

static bool add_function(struct pe *pe, const struct library *library, uint64_t at, uint64_t slot,
                         uint64_t word)
{
    const char *name = function_name(pe, library, at, word);
    struct image_reloc reloc = { .vaddr = slot,
                                 .kind = IMAGE_RELOC_SYMBOLIC,
                                 .type = IMAGE_RELOC_IAT,
                                 .type_name = "import address",
                                 .symbol = name,
                                 .width = pe->word };
    if (name == NULL || !pe_add_import(pe, &(struct image_import){ .kind = IMAGE_IMPORT_SYMBOL,
                                                                   .name = name,
                                                                   .has_user = true,
                                                                   .user = slot,
                                                                   .delayed = library->delayed }))
        return false;
    /* No loader fills the slots of a delay import: the module's own code does. */
    return library->delayed || pe_add_reloc(pe, &reloc);
}

/* A loader that does not know the name table reads the slots instead. */
static bool check_slot(struct pe *pe, const struct library *library, uint64_t slot, uint64_t word)
{
    const uint8_t *at = pe_bytes(pe, slot, pe->word);
    if (image_segment_at(pe->image, slot, pe->word) == NULL)
        return image_defect(pe->image, "import from %.64s: the slot at 0x%llx lies in no section",
                            library->name, (ull)slot);
    if (!library->delayed && (at == NULL || pe_word(pe, at) != word))
        return image_defect(pe->image,
                            "import from %.64s: the slot at 0x%llx asks for something else than "
                            "the name table (0x%llx)",
                            library->name, (ull)slot, (ull)word);
    return true;
}

static bool read_functions(struct pe *pe, const struct library *library)
{
    for (uint64_t i = 0;; i++) {
        uint64_t at = library->names + i * pe->word, slot = library->slots + i * pe->word;
        const uint8_t *bytes = pe_bytes(pe, at, pe->word);
        if (bytes == NULL)
            return image_defect(pe->image,
                                "import from %.64s: the name table at 0x%x has no end in the "
                                "file's part of its section",
                                library->name, library->names);
        uint64_t word = pe_word(pe, bytes);
        if ((word != 0 || !library->delayed) && !check_slot(pe, library, slot, word))
            return false;
        if (word == 0)
            return true;
        if (!add_function(pe, library, at, slot, word))
            return false;
    }
}

static bool read_library(struct pe *pe, const char *what, uint32_t index, uint32_t name,
                         struct library *library)
{
    library->name = pe_string(pe, name);
    if (library->name == NULL)
        return image_defect(pe->image,
                            "%s: the name of library %u at 0x%x is empty, longer than %u or has "
                            "no end in its section",
                            what, index, name, IMAGE_MAX_NAME);
    return pe_add_import(pe, &(struct image_import){ .kind = IMAGE_IMPORT_LIBRARY,
                                                     .name = library->name,
                                                     .delayed = library->delayed }) &&
           read_functions(pe, library);
}

/* The index-th descriptor of a directory of them. NULL with a defect when there is none. */
static const uint8_t *descriptor(struct pe *pe, enum pe_directory_index where, uint32_t index,
                                 uint32_t size)
{
    const struct pe_directory *directory = &pe->directory[where];
    uint64_t offset = (uint64_t)index * size;
    const uint8_t *at =
        offset + size <= directory->size ? pe_bytes(pe, directory->vaddr + offset, size) : NULL;
    if (at == NULL)
        image_defect(pe->image,
                     "%s (0x%x, 0x%x bytes) has no end mark inside its size and its section",
                     pe_directory_name(where), directory->vaddr, directory->size);
    return at;
}

static bool is_zero(const uint8_t *at, uint32_t size)
{
    for (uint32_t i = 0; i < size; i++) {
        if (at[i] != 0)
            return false;
    }
    return true;
}

bool pe_read_imports(struct pe *pe)
{
    if (pe->directory[PE_IMPORT].size == 0)
        return true;
    for (uint32_t i = 0;; i++) {
        const uint8_t *at = descriptor(pe, PE_IMPORT, i, 20);
        if (at == NULL)
            return false;
        if (is_zero(at, 20))
            return true;
        uint32_t names = pe_u32(at), stamp = pe_u32(at + 4), name = pe_u32(at + 12);
        uint32_t slots = pe_u32(at + 16);
        if (name == 0 || slots == 0)
            return image_defect(pe->image,
                                "import directory: library %u has Name 0x%x and FirstThunk 0x%x; "
                                "some loaders take that for the end",
                                i, name, slots);
        if (stamp != 0)
            return image_defect(pe->image,
                                "import directory: library %u is bound (TimeDateStamp 0x%x) to "
                                "addresses of another computer",
                                i, stamp);
        struct library library = { .names = names != 0 ? names : slots, .slots = slots };
        if (!read_library(pe, "import directory", i, name, &library))
            return false;
    }
}

bool pe_read_delay_imports(struct pe *pe)
{
    if (pe->directory[PE_DELAY_IMPORT].size == 0)
        return true;
    for (uint32_t i = 0;; i++) {
        const uint8_t *at = descriptor(pe, PE_DELAY_IMPORT, i, 32);
        if (at == NULL)
            return false;
        if (is_zero(at, 32))
            return true;
        if ((pe_u32(at) & 1) == 0)
            return image_defect(pe->image,
                                "delay import directory: library %u has Attributes 0x%x, allowed "
                                "is 1 (addresses count from the image's start)",
                                i, pe_u32(at));
        struct library library = { .names = pe_u32(at + 16),
                                   .slots = pe_u32(at + 12),
                                   .delayed = true };
        if (!read_library(pe, "delay import directory", i, pe_u32(at + 4), &library))
            return false;
    }
}
