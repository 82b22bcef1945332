/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_relocs.c - every word that a loader would have to patch, from all four kinds of table.
 */
#include "image/elf.h"

typedef unsigned long long ull;

static const struct elf_reloc_type unknown_type = { "?", IMAGE_RELOC_OTHER, 0 };

static const struct elf_reloc_type *type_of(const struct elf_kind *kind, uint32_t type)
{
    bool known = type < kind->reloc_type_count && kind->reloc_types[type].name != NULL;
    return known ? &kind->reloc_types[type] : &unknown_type;
}

/* What the table being read looks like. */
struct reloc_table {
    enum elf_tag where, size;
    enum elf_record record;
};

static bool name_symbol(struct elf *elf, const struct reloc_table *table, uint64_t index,
                        uint32_t symbol, struct image_reloc *reloc)
{
    if (symbol == 0)
        return true;
    if (symbol >= elf->dynsym_count)
        return image_defect(elf->image, "%s: entry %llu names dynamic symbol %u of %u",
                            elf_tag_name(table->where), (ull)index, symbol, elf->dynsym_count);
    const char *name = elf_string(&elf->dynstr, elf->dynsym[symbol].st_name);
    reloc->symbol = name != NULL && name[0] != '\0' ? name : NULL;
    if (elf->import_of[symbol] == 0)
        return true;
    struct image_import *import = &elf->image->imports[elf->import_of[symbol] - 1];
    if (!import->has_user) {
        import->has_user = true;
        import->user = reloc->vaddr;
    }
    return true;
}

static bool add_reloc(struct elf *elf, const struct reloc_table *table, uint64_t index,
                      uint64_t vaddr, uint64_t info, int64_t addend)
{
    struct image *image = elf->image;
    uint32_t type = (uint32_t)ELF64_R_TYPE(info);
    const struct elf_reloc_type *known = type_of(elf->kind, type);
    struct image_reloc reloc = { .vaddr = vaddr,
                                 .addend = addend,
                                 .kind = known->kind,
                                 .type = type,
                                 .type_name = known->name,
                                 .width = known->width };
    if (type == elf->kind->reloc_none)
        return true;
    if (image_segment_at(image, vaddr, known->width != 0 ? known->width : 1) == NULL)
        return image_defect(image, "%s: entry %llu (%s) patches 0x%llx, which lies in no segment",
                            elf_tag_name(table->where), (ull)index, known->name, (ull)vaddr);
    if (image->reloc_count == IMAGE_MAX_RELOCS)
        return image_defect(image, "has more than %u relocations", IMAGE_MAX_RELOCS);
    if (!name_symbol(elf, table, index, (uint32_t)ELF64_R_SYM(info), &reloc))
        return false;
    if (known->kind == IMAGE_RELOC_TLS)
        image->has_tls = true;
    if (!image_make_room(&image->relocs, image->reloc_count, sizeof reloc))
        return elf_out_of_memory(elf);
    image->relocs[image->reloc_count++] = reloc;
    return true;
}

static bool read_rela(struct elf *elf, const struct reloc_table *table, const Elf64_Rela *rela,
                      uint64_t count)
{
    for (uint64_t i = 0; i < count; i++) {
        if (!add_reloc(elf, table, i, rela[i].r_offset, rela[i].r_info, rela[i].r_addend))
            return false;
    }
    return true;
}

/* The addend of REL and RELR stands in the word itself. */
static int64_t word_at(const struct elf *elf, uint64_t vaddr)
{
    uint64_t word = image_word(elf->image, vaddr, elf->kind->word);
    return elf->kind->word == 4 ? (int32_t)(uint32_t)word : (int64_t)word;
}

static bool read_rel(struct elf *elf, const struct reloc_table *table, const Elf64_Rel *rel,
                     uint64_t count)
{
    for (uint64_t i = 0; i < count; i++) {
        if (!add_reloc(elf, table, i, rel[i].r_offset, rel[i].r_info,
                       word_at(elf, rel[i].r_offset)))
            return false;
    }
    return true;
}

static bool add_relr(struct elf *elf, const struct reloc_table *table, uint64_t index,
                     uint64_t vaddr)
{
    return add_reloc(elf, table, index, vaddr, ELF64_R_INFO(0, elf->kind->reloc_relative),
                     word_at(elf, vaddr));
}

/* An even entry is an address; an odd one is a bitmap of the 63 (31) words that follow. */
static bool read_relr(struct elf *elf, const struct reloc_table *table, const uint64_t *relr,
                      uint64_t count)
{
    unsigned word = elf->kind->word, bits = 8 * word;
    uint64_t next = 0;
    for (uint64_t i = 0; i < count; i++) {
        if ((relr[i] & 1) == 0) {
            if (!add_relr(elf, table, i, relr[i]))
                return false;
            next = relr[i] + word;
            continue;
        }
        if (i == 0)
            return image_defect(elf->image,
                                "DT_RELR starts with a bitmap (0x%llx), not with an "
                                "address",
                                (ull)relr[i]);
        for (unsigned bit = 1; bit < bits; bit++) {
            if ((relr[i] >> bit & 1) != 0 && !add_relr(elf, table, i, next + word * (bit - 1)))
                return false;
        }
        next += word * (bits - 1);
    }
    return true;
}

static bool read_table(struct elf *elf, const struct reloc_table *table)
{
    uint64_t size = elf->tag[table->size], record = elf_record_size(elf, table->record);
    if (elf->has_tag[table->where] != elf->has_tag[table->size])
        return image_defect(elf->image, "dynamic table has %s without %s",
                            elf_tag_name(elf->has_tag[table->where] ? table->where : table->size),
                            elf_tag_name(elf->has_tag[table->where] ? table->size : table->where));
    if (size == 0)
        return true;
    if (size % record != 0)
        return image_defect(elf->image, "%s is %llu, allowed is a multiple of %llu",
                            elf_tag_name(table->size), (ull)size, (ull)record);
    const void *found = elf_table(elf, table->record, table->where, size / record);
    if (found == NULL)
        return false;
    switch (table->record) {
    case ELF_RECORD_RELA:
        return read_rela(elf, table, found, size / record);
    case ELF_RECORD_REL:
        return read_rel(elf, table, found, size / record);
    default:
        return read_relr(elf, table, found, size / record);
    }
}

/* Some linkers let DT_RELASZ include the table that DT_JMPREL names. */
static bool inside(const struct elf *elf, const struct reloc_table *inner,
                   const struct reloc_table *outer)
{
    uint64_t begin = elf->tag[inner->where], size = elf->tag[inner->size];
    uint64_t outer_begin = elf->tag[outer->where], outer_size = elf->tag[outer->size];
    return inner->record == outer->record && begin >= outer_begin &&
           begin - outer_begin <= outer_size && size <= outer_size - (begin - outer_begin);
}

static bool read_jmprel(struct elf *elf, const struct reloc_table *rela,
                        const struct reloc_table *rel)
{
    struct reloc_table jmprel = { ELF_JMPREL, ELF_PLTRELSZ, ELF_RECORD_RELA };
    if (!elf->has_tag[ELF_JMPREL] && !elf->has_tag[ELF_PLTRELSZ])
        return true;
    if (elf->tag[ELF_PLTREL] == DT_REL)
        jmprel.record = ELF_RECORD_REL;
    else if (elf->tag[ELF_PLTREL] != DT_RELA)
        return image_defect(elf->image,
                            "DT_PLTREL is %llu, allowed are 7 (DT_RELA) and 17 "
                            "(DT_REL)",
                            (ull)elf->tag[ELF_PLTREL]);
    if (inside(elf, &jmprel, rela) || inside(elf, &jmprel, rel))
        return true;
    return read_table(elf, &jmprel);
}

bool elf_read_relocs(struct elf *elf)
{
    static const struct reloc_table rela = { ELF_RELA, ELF_RELASZ, ELF_RECORD_RELA };
    static const struct reloc_table rel = { ELF_REL, ELF_RELSZ, ELF_RECORD_REL };
    static const struct reloc_table relr = { ELF_RELR, ELF_RELRSZ, ELF_RECORD_ADDRESS };
    if (!read_table(elf, &rela) || !read_table(elf, &rel) || !read_table(elf, &relr) ||
        !read_jmprel(elf, &rela, &rel))
        return false;
    return image_sort_relocs(elf->image);
}
