/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_symbols.c - the dynamic symbol table: what the module offers and what it wants.
 */
#include "image/elf.h"

#include <stdlib.h>
#include <string.h>

typedef unsigned long long ull;

static enum image_symbol_kind symbol_kind(const Elf64_Sym *symbol)
{
    /* An absolute symbol is a number, not a place in the module. */
    if (symbol->st_shndx == SHN_ABS)
        return IMAGE_SYMBOL_OTHER;
    switch (ELF64_ST_TYPE(symbol->st_info)) {
    case STT_NOTYPE:
        return IMAGE_SYMBOL_NONE;
    case STT_FUNC:
        return IMAGE_SYMBOL_FUNC;
    case STT_OBJECT:
        return IMAGE_SYMBOL_OBJECT;
    case STT_GNU_IFUNC:
        return IMAGE_SYMBOL_IFUNC;
    case STT_TLS:
        return IMAGE_SYMBOL_TLS;
    default:
        return IMAGE_SYMBOL_OTHER;
    }
}

static bool is_place(const Elf64_Sym *symbol)
{
    return symbol->st_shndx != SHN_ABS && ELF64_ST_TYPE(symbol->st_info) != STT_TLS;
}

static bool is_code(const Elf64_Sym *symbol)
{
    enum image_symbol_kind kind = symbol_kind(symbol);
    return kind == IMAGE_SYMBOL_FUNC || kind == IMAGE_SYMBOL_IFUNC;
}

uint64_t elf_symbol_vaddr(const struct elf *elf, const Elf64_Sym *symbol)
{
    bool marked = elf->kind->thumb && is_code(symbol);
    return marked ? symbol->st_value & ~(uint64_t)1 : symbol->st_value;
}

const char *elf_symbol_lie(const struct elf *elf, const Elf64_Sym *symbol)
{
    const struct image *image = elf->image;
    uint64_t vaddr = elf_symbol_vaddr(elf, symbol);
    if (!is_place(symbol))
        return NULL;
    if (image_segment_at(image, vaddr, 1) == NULL)
        return is_code(symbol) || symbol->st_size != 0 ? "lies in no segment" : NULL;
    if (image_segment_at(image, vaddr, symbol->st_size) == NULL)
        return "runs past the end of its segment";
    return NULL;
}

bool elf_add_symbol(struct elf *elf, const Elf64_Sym *symbol, const char *name, bool exported)
{
    struct image *image = elf->image;
    uint64_t vaddr = elf_symbol_vaddr(elf, symbol);
    const struct image_segment *segment =
        is_place(symbol) ? image_segment_at(image, vaddr, 1) : NULL;
    if (!image_make_room(&image->symbols, image->symbol_count, sizeof image->symbols[0]))
        return elf_out_of_memory(elf);
    image->symbols[image->symbol_count++] =
        (struct image_symbol){ .name = name,
                               .vaddr = vaddr,
                               .size = symbol->st_size,
                               .kind = symbol_kind(symbol),
                               .exported = exported,
                               .executable = segment != NULL && (segment->perm & IMAGE_EXEC) != 0,
                               .thumb = vaddr != symbol->st_value };
    return true;
}

/* ---- the dynamic symbols ---- */

bool elf_is_exported(const Elf64_Sym *symbol)
{
    unsigned binding = ELF64_ST_BIND(symbol->st_info);
    unsigned visibility = ELF64_ST_VISIBILITY(symbol->st_other);
    return binding != STB_LOCAL && visibility != STV_HIDDEN && visibility != STV_INTERNAL;
}

static bool add_undefined(struct elf *elf, uint32_t index, const char *name)
{
    const Elf64_Sym *symbol = &elf->dynsym[index];
    unsigned binding = ELF64_ST_BIND(symbol->st_info);
    if (binding == STB_LOCAL)
        return true;
    if (!elf_add_import(elf, binding == STB_WEAK ? IMAGE_IMPORT_WEAK : IMAGE_IMPORT_SYMBOL, name))
        return false;
    elf->import_of[index] = (uint32_t)elf->image->import_count;
    return true;
}

static bool read_symbol(struct elf *elf, uint32_t index)
{
    const Elf64_Sym *symbol = &elf->dynsym[index];
    const char *name = elf_string(&elf->dynstr, symbol->st_name);
    if (name == NULL)
        return image_defect(elf->image,
                            "dynamic symbol %u: its name at 0x%x is outside the string table of "
                            "0x%llx bytes or longer than %u",
                            index, symbol->st_name, (ull)elf->dynstr.size, IMAGE_MAX_NAME);
    if (ELF64_ST_TYPE(symbol->st_info) == STT_TLS)
        elf->image->has_tls = true;
    if (symbol->st_shndx == SHN_UNDEF)
        return add_undefined(elf, index, name);
    if (name[0] == '\0')
        return true;
    const char *lie = elf_symbol_lie(elf, symbol);
    if (lie != NULL)
        return image_defect(elf->image, "dynamic symbol %.64s: 0x%llx bytes at 0x%llx: %s", name,
                            (ull)symbol->st_size, (ull)symbol->st_value, lie);
    return elf_add_symbol(elf, symbol, name, elf_is_exported(symbol));
}

static int compare_names(const void *left, const void *right)
{
    const struct image_symbol *const *a = left, *const *b = right;
    return strcmp((*a)->name, (*b)->name);
}

/* A name that is offered twice means whichever the loader happens to find first: what the harness
 * tests need not be what the controller runs. */
static bool index_exports(struct elf *elf)
{
    struct image *image = elf->image;
    if (image->symbol_count == 0)
        return true;
    elf->exports = calloc(image->symbol_count, sizeof(elf->exports[0]));
    if (elf->exports == NULL)
        return elf_out_of_memory(elf);
    for (size_t i = 0; i < image->symbol_count; i++) {
        if (image->symbols[i].exported)
            elf->exports[elf->export_count++] = &image->symbols[i];
    }
    qsort(elf->exports, elf->export_count, sizeof(elf->exports[0]), compare_names);
    for (size_t i = 1; i < elf->export_count; i++) {
        const struct image_symbol *a = elf->exports[i - 1], *b = elf->exports[i];
        if (strcmp(a->name, b->name) == 0)
            return image_defect(image, "exports %.64s twice, at 0x%llx and at 0x%llx", a->name,
                                (ull)a->vaddr, (ull)b->vaddr);
    }
    return true;
}

const struct image_symbol *elf_find_export(const struct elf *elf, const char *name)
{
    struct image_symbol key = { .name = name };
    const struct image_symbol *key_pointer = &key;
    const struct image_symbol **found = elf->export_count == 0
                                            ? NULL
                                            : bsearch(&key_pointer, elf->exports, elf->export_count,
                                                      sizeof(elf->exports[0]), compare_names);
    return found != NULL ? *found : NULL;
}

bool elf_read_dynamic_symbols(struct elf *elf)
{
    uint64_t count;
    if (!elf_count_symbols(elf, &count))
        return false;
    if (count == 0)
        return true;
    elf->dynsym = elf_table(elf, ELF_RECORD_SYM, ELF_SYMTAB, count);
    if (elf->dynsym == NULL)
        return false;
    elf->dynsym_count = (uint32_t)count;
    elf->import_of = calloc(elf->dynsym_count, sizeof(elf->import_of[0]));
    if (elf->import_of == NULL)
        return elf_out_of_memory(elf);
    for (uint32_t i = 1; i < elf->dynsym_count; i++) {
        if (!read_symbol(elf, i))
            return false;
    }
    image_sort_symbols(elf->image);
    return index_exports(elf) && elf_check_lookup(elf);
}
