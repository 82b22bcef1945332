/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_symtab.c - the full symbol table, when the module was not stripped: names of local functions
 * for people, and undefined symbols that the linker has resolved to null.
 *
 * No loader reads this table, so nothing in it makes a module defective: a table that lies counts
 * as stripped, an entry that lies is left out.
 */
#include "image/elf.h"

#include <stdlib.h>
#include <string.h>

/* A linker writes "name@VERSION" here where the dynamic table has "name". */
static int compare_unversioned(const char *versioned, const char *plain)
{
    size_t length = strcspn(versioned, "@");
    int order = strncmp(versioned, plain, length);
    return order != 0 ? order : plain[length] == '\0' ? 0 : -1;
}

static int compare_to_symbol(const void *key, const void *item)
{
    const struct image_symbol *a = key, *b = item;
    if (a->vaddr != b->vaddr)
        return a->vaddr < b->vaddr ? -1 : 1;
    return compare_unversioned(a->name, b->name);
}

static int compare_to_name(const void *key, const void *item)
{
    const char *const *plain = item;
    return compare_unversioned(key, *plain);
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

struct symtab {
    const Elf64_Sym *symbols;
    uint64_t count;
    struct elf_strings strings;
    size_t dynamic_count;  /* image symbols that were there before, sorted */
    const char **imported; /* names of the symbol imports that were there before, sorted */
    size_t imported_count;
};

static bool find_symtab(struct elf *elf, struct symtab *table)
{
    Elf64_Shdr header, strings;
    const char *name;
    for (size_t i = 1; elf_section(elf, i, &header, &name); i++) {
        if (header.sh_type != SHT_SYMTAB)
            continue;
        size_t size = elf_record_size(elf, ELF_RECORD_SYM);
        table->count = header.sh_size / size;
        if (header.sh_entsize != size || table->count == 0 || table->count > IMAGE_MAX_SYMBOLS ||
            !elf_section_in_file(elf, &header) ||
            !elf_section(elf, header.sh_link, &strings, &name) || strings.sh_type != SHT_STRTAB ||
            !elf_section_in_file(elf, &strings) ||
            !elf_strings_at(elf->image, strings.sh_offset, strings.sh_size, &table->strings))
            return false;
        table->symbols = elf_records(elf, ELF_RECORD_SYM, header.sh_offset, table->count);
        return table->symbols != NULL;
    }
    return false;
}

static bool collect_imported(struct elf *elf, struct symtab *table)
{
    const struct image *image = elf->image;
    table->imported = calloc(image->import_count + 1, sizeof(table->imported[0]));
    if (table->imported == NULL)
        return elf_out_of_memory(elf);
    for (size_t i = 0; i < image->import_count; i++) {
        if (image->imports[i].kind == IMAGE_IMPORT_SYMBOL ||
            image->imports[i].kind == IMAGE_IMPORT_WEAK)
            table->imported[table->imported_count++] = image->imports[i].name;
    }
    qsort(table->imported, table->imported_count, sizeof(table->imported[0]), compare_names);
    return true;
}

/* Whoever calls it calls address 0, and no dynamic symbol tells. lld makes a hidden weak symbol
 * that nobody defines local. */
static bool add_undefined(struct elf *elf, const struct symtab *table, const Elf64_Sym *symbol,
                          const char *name)
{
    bool weak = ELF64_ST_BIND(symbol->st_info) != STB_GLOBAL;
    if (elf->image->import_count == IMAGE_MAX_IMPORTS ||
        bsearch(name, table->imported, table->imported_count, sizeof(table->imported[0]),
                compare_to_name) != NULL)
        return true;
    return elf_add_import(elf, weak ? IMAGE_IMPORT_WEAK : IMAGE_IMPORT_SYMBOL, name);
}

/* Arm: "$a", "$t.1", "$d" say what kind of bytes begins there; they name nothing. */
static bool is_mapping_symbol(const struct elf *elf, const Elf64_Sym *symbol, const char *name)
{
    return elf->kind->machine == EM_ARM && ELF64_ST_TYPE(symbol->st_info) == STT_NOTYPE &&
           name[0] == '$' && name[1] != '\0' && strchr("atd", name[1]) != NULL &&
           (name[2] == '\0' || name[2] == '.');
}

static bool add_defined(struct elf *elf, const struct symtab *table, const Elf64_Sym *symbol,
                        const char *name)
{
    struct image_symbol key = { .name = name, .vaddr = elf_symbol_vaddr(elf, symbol) };
    unsigned type = ELF64_ST_TYPE(symbol->st_info);
    if (type == STT_SECTION || type == STT_FILE || symbol->st_shndx == SHN_ABS ||
        elf_symbol_lie(elf, symbol) != NULL || is_mapping_symbol(elf, symbol, name))
        return true;
    if (table->dynamic_count != 0 && bsearch(&key, elf->image->symbols, table->dynamic_count,
                                             sizeof key, compare_to_symbol) != NULL)
        return true;
    return elf_add_symbol(elf, symbol, name, false);
}

static bool read_symbols(struct elf *elf, const struct symtab *table)
{
    for (uint64_t i = 1; i < table->count; i++) {
        const Elf64_Sym *symbol = &table->symbols[i];
        const char *name = elf_string(&table->strings, symbol->st_name);
        if (name == NULL || name[0] == '\0')
            continue;
        bool go_on = symbol->st_shndx == SHN_UNDEF ? add_undefined(elf, table, symbol, name)
                                                   : add_defined(elf, table, symbol, name);
        if (!go_on)
            return false;
    }
    return true;
}

bool elf_read_symtab(struct elf *elf)
{
    struct symtab table = { .dynamic_count = elf->image->symbol_count };
    if (!find_symtab(elf, &table))
        return true;
    bool go_on = collect_imported(elf, &table) && read_symbols(elf, &table);
    free(table.imported);
    image_sort_symbols(elf->image);
    return go_on;
}
