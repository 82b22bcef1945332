/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_exports.c - the export directory: names, ordinals, and the table of addresses behind both.
 */
#include "image/pe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct exports {
    uint32_t base, function_count, name_count;
    const uint8_t *functions, *names, *ordinals; /* 4, 4 and 2 bytes each */
    uint8_t *named;                              /* per function: it has a name */
};

static const uint8_t *table(struct pe *pe, const char *what, uint32_t vaddr, uint32_t count,
                            uint32_t size)
{
    const uint8_t *at = count == 0 ? pe->image->bytes : pe_bytes(pe, vaddr, (uint64_t)count * size);
    if (at == NULL)
        image_defect(pe->image,
                     "export directory: %s (0x%x, %u entries) does not lie in the file's part of "
                     "one section",
                     what, vaddr, count);
    return at;
}

static bool read_directory(struct pe *pe, struct exports *exports)
{
    struct image *image = pe->image;
    const struct pe_directory *directory = &pe->directory[PE_EXPORT];
    const uint8_t *at = directory->size >= 40 ? pe_bytes(pe, directory->vaddr, 40) : NULL;
    if (at == NULL)
        return image_defect(image,
                            "export directory (0x%x, 0x%x bytes): its 40 bytes do not lie in the "
                            "file's part of one section",
                            directory->vaddr, directory->size);
    exports->base = pe_u32(at + 16);
    exports->function_count = pe_u32(at + 20);
    exports->name_count = pe_u32(at + 24);
    if (exports->function_count > 65536 || exports->base > 65536 - exports->function_count)
        return image_defect(image,
                            "export directory: Base %u, NumberOfFunctions %u; ordinals end at "
                            "65535",
                            exports->base, exports->function_count);
    if (exports->name_count > IMAGE_MAX_SYMBOLS - exports->function_count)
        return image_defect(image, "export directory: NumberOfNames is %u, allowed are up to %u",
                            exports->name_count, IMAGE_MAX_SYMBOLS - exports->function_count);
    exports->functions =
        table(pe, "AddressOfFunctions", pe_u32(at + 28), exports->function_count, 4);
    exports->names = table(pe, "AddressOfNames", pe_u32(at + 32), exports->name_count, 4);
    exports->ordinals = table(pe, "AddressOfNameOrdinals", pe_u32(at + 36), exports->name_count, 2);
    return exports->functions != NULL && exports->names != NULL && exports->ordinals != NULL;
}

/* "OTHER.Name" or "OTHER.#7", where a loader finds it: inside the export directory. */
static const char *forwarder(struct pe *pe, const char *name, uint32_t vaddr)
{
    const struct pe_directory *directory = &pe->directory[PE_EXPORT];
    const char *text = pe_string(pe, vaddr);
    const char *dot = text != NULL ? strrchr(text, '.') : NULL;
    if (dot != NULL && dot != text && dot[1] != '\0' &&
        strlen(text) < directory->size - (vaddr - directory->vaddr))
        return text;
    image_defect(pe->image,
                 "exports %.64s as a forwarder at 0x%x, which is no LIBRARY.Name inside the export "
                 "directory",
                 name, vaddr);
    return NULL;
}

static bool add_forwarded(struct pe *pe, struct image_symbol *symbol, uint32_t vaddr)
{
    symbol->forwarder = forwarder(pe, symbol->name, vaddr);
    symbol->kind = IMAGE_SYMBOL_OTHER;
    return symbol->forwarder != NULL && pe_add_symbol(pe, symbol) &&
           pe_add_import(pe, &(struct image_import){ .kind = IMAGE_IMPORT_FILTER,
                                                     .name = symbol->forwarder });
}

static bool add_export(struct pe *pe, const struct exports *exports, uint32_t index,
                       const char *name, bool by_ordinal)
{
    const struct pe_directory *directory = &pe->directory[PE_EXPORT];
    uint32_t vaddr = pe_u32(exports->functions + (size_t)4 * index);
    struct image_symbol symbol = {
        .name = name, .exported = true, .by_ordinal = by_ordinal, .ordinal = exports->base + index
    };
    if (vaddr - directory->vaddr < directory->size)
        return add_forwarded(pe, &symbol, vaddr);
    const struct image_segment *segment = image_segment_at(pe->image, vaddr, 1);
    if (vaddr == 0 || segment == NULL)
        return image_defect(pe->image, "exports %.64s at 0x%x, which lies in no section", name,
                            vaddr);
    symbol.vaddr = vaddr;
    symbol.executable = (segment->perm & IMAGE_EXEC) != 0;
    return pe_add_symbol(pe, &symbol);
}

static bool looks_like_ordinal(const char *name)
{
    return name[0] == '#' && name[1] != '\0' && strspn(name + 1, "0123456789") == strlen(name + 1);
}

/* Loaders search the names by halves: that needs them in order. */
static bool check_order(struct pe *pe, const char *before, const char *name)
{
    int order = before != NULL ? strcmp(before, name) : -1;
    if (order == 0)
        return image_defect(pe->image, "exports %.64s twice", name);
    if (order > 0)
        return image_defect(pe->image,
                            "export names are not sorted: %.64s comes before %.64s, and who "
                            "searches by halves misses one",
                            before, name);
    return true;
}

static bool read_names(struct pe *pe, struct exports *exports)
{
    const char *before = NULL;
    for (uint32_t i = 0; i < exports->name_count; i++) {
        uint32_t vaddr = pe_u32(exports->names + (size_t)4 * i);
        uint32_t index = pe_u16(exports->ordinals + (size_t)2 * i);
        const char *name = pe_string(pe, vaddr);
        if (name == NULL || looks_like_ordinal(name))
            return image_defect(pe->image,
                                "export name %u at 0x%x is empty, reads as an ordinal, is longer "
                                "than %u or has no end in its section",
                                i, vaddr, IMAGE_MAX_NAME);
        if (index >= exports->function_count)
            return image_defect(pe->image, "exports %.64s as function %u of %u", name, index,
                                exports->function_count);
        if (!check_order(pe, before, name) || !add_export(pe, exports, index, name, false))
            return false;
        exports->named[index] = 1;
        before = name;
    }
    return true;
}

static bool read_unnamed(struct pe *pe, const struct exports *exports)
{
    for (uint32_t i = 0; i < exports->function_count; i++) {
        if (exports->named[i] != 0 || pe_u32(exports->functions + (size_t)4 * i) == 0)
            continue;
        char name[16];
        snprintf(name, sizeof name, "#%u", exports->base + i);
        const char *kept = pe_text(pe, name);
        if (kept == NULL || !add_export(pe, exports, i, kept, true))
            return false;
    }
    return true;
}

bool pe_read_exports(struct pe *pe)
{
    struct exports exports;
    if (pe->directory[PE_EXPORT].size == 0)
        return true;
    if (!read_directory(pe, &exports))
        return false;
    exports.named = calloc((size_t)exports.function_count + 1, 1);
    if (exports.named == NULL)
        return pe_out_of_memory(pe);
    bool go_on = read_names(pe, &exports) && read_unnamed(pe, &exports);
    free(exports.named);
    image_sort_symbols(pe->image);
    return go_on;
}
