/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_symbols.c - the COFF symbol table, which mingw leaves in a module: names of local functions
 * for people.
 *
 * No loader reads it, so nothing in it makes a module defective: an entry that lies is left out.
 * Only a table outside the file does, because such a file was cut off.
 */
#include "image/pe.h"

#include <stdlib.h>
#include <string.h>

enum { CLASS_EXTERNAL = 2, CLASS_STATIC = 3, CLASS_LABEL = 6, TYPE_FUNCTION = 0x20 };

static uint64_t symbols_offset(const struct image *image, uint64_t *size)
{
    const uint8_t *coff = image->bytes + pe_u32(image->bytes + 0x3c);
    *size = (uint64_t)PE_COFF_SYMBOL * pe_u32(coff + 16);
    return pe_u32(coff + 12);
}

bool pe_check_symbol_table(struct pe *pe)
{
    struct image *image = pe->image;
    uint64_t size, offset = symbols_offset(image, &size);
    uint64_t strings = offset + size;
    if (offset == 0)
        return true;
    if (strings > image->size || image->size - strings < 4 ||
        pe_u32(image->bytes + strings) > image->size - strings)
        return image_defect(image,
                            "COFF symbols (PointerToSymbolTable 0x%llx, 0x%llx bytes) and their "
                            "names lie outside the file of %zu bytes: was it cut off?",
                            (unsigned long long)offset, (unsigned long long)size, image->size);
    return true;
}

const uint8_t *pe_symbol_table(const struct image *image, uint32_t *count,
                               struct pe_strings *strings)
{
    uint64_t size, offset = symbols_offset(image, &size);
    if (offset == 0)
        return NULL;
    *count = (uint32_t)(size / PE_COFF_SYMBOL);
    strings->text = (const char *)image->bytes + offset + size;
    strings->size = pe_u32(image->bytes + offset + size);
    if (strings->size <= 4 || strings->text[strings->size - 1] != '\0')
        strings->size = 0;
    return image->bytes + offset;
}

const char *pe_coff_string(const struct pe_strings *strings, uint32_t offset)
{
    if (offset < 4 || offset >= strings->size)
        return NULL;
    const char *text = strings->text + offset;
    return strnlen(text, IMAGE_MAX_NAME + 1) <= IMAGE_MAX_NAME ? text : NULL;
}

/* Short names stand in the symbol, without a zero byte when they have eight. On i386 the compiler
 * puts a "_" in front, which no source has. *name is NULL when the symbol names nothing. */
static bool read_name(struct pe *pe, const uint8_t *symbol, const struct pe_strings *strings,
                      const char **name)
{
    char shorter[9] = "";
    *name = pe_u32(symbol) == 0 ? pe_coff_string(strings, pe_u32(symbol + 4)) : shorter;
    if (pe_u32(symbol) != 0)
        memcpy(shorter, symbol, 8);
    if (*name != NULL && pe->word == 4 && **name == '_')
        ++*name;
    if (*name == NULL || **name == '\0' || **name == '.') {
        *name = NULL;
        return true;
    }
    if (pe_u32(symbol) != 0)
        *name = image_text(pe->image, "%s", *name);
    if (*name != NULL)
        return true;
    /* More short names than there is room for: the rest goes without. */
    if (pe->image->defect[0] == '\0')
        return pe_out_of_memory(pe);
    pe->image->defect[0] = '\0';
    return true;
}

static int compare_to_symbol(const void *key, const void *item)
{
    const struct image_symbol *a = key, *b = item;
    return a->vaddr != b->vaddr ? (a->vaddr < b->vaddr ? -1 : 1) : strcmp(a->name, b->name);
}

/* exports: so many symbols were there before, sorted. An export does not say what it is; its symbol
 * does. */
static bool add_symbol(struct pe *pe, struct image_symbol *symbol, size_t exports)
{
    struct image_symbol *known = exports == 0 ? NULL
                                              : bsearch(symbol, pe->image->symbols, exports,
                                                        sizeof *symbol, compare_to_symbol);
    if (known == NULL)
        return pe_add_symbol(pe, symbol);
    if (symbol->kind == IMAGE_SYMBOL_FUNC)
        known->kind = IMAGE_SYMBOL_FUNC;
    return true;
}

static bool read_symbol(struct pe *pe, const uint8_t *at, const struct pe_strings *strings,
                        size_t exports)
{
    struct pe_section section;
    unsigned number = pe_u16(at + 12), class = at[16];
    const char *name;
    if ((class != CLASS_EXTERNAL && class != CLASS_STATIC && class != CLASS_LABEL) || number == 0 ||
        !pe_section_at(pe->image, number - 1, &section) || pe_u32(at + 8) >= section.virtual_size)
        return true;
    if (!read_name(pe, at, strings, &name))
        return false;
    uint64_t vaddr = (uint64_t)section.vaddr + pe_u32(at + 8);
    const struct image_segment *segment = image_segment_at(pe->image, vaddr, 1);
    if (name == NULL || segment == NULL)
        return true;
    bool function = pe_u16(at + 14) == TYPE_FUNCTION;
    struct image_symbol symbol = { .name = name,
                                   .vaddr = vaddr,
                                   .kind = function ? IMAGE_SYMBOL_FUNC : IMAGE_SYMBOL_NONE,
                                   .executable = (segment->perm & IMAGE_EXEC) != 0 };
    return add_symbol(pe, &symbol, exports);
}

bool pe_read_symbols(struct pe *pe)
{
    struct pe_strings strings;
    uint32_t count;
    size_t exports = pe->image->symbol_count;
    const uint8_t *symbols = pe_symbol_table(pe->image, &count, &strings);
    if (symbols == NULL || count > IMAGE_MAX_SYMBOLS)
        return true;
    for (uint64_t i = 0; i < count; i++) {
        const uint8_t *at = symbols + i * PE_COFF_SYMBOL;
        if (!read_symbol(pe, at, &strings, exports))
            return false;
        i += at[17]; /* what follows belongs to this symbol */
    }
    image_sort_symbols(pe->image);
    return true;
}
