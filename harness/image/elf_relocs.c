/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_relocs.c - every word that a loader would have to patch, from all four kinds of table.
 */
#include "image/elf.h"

#include <stdlib.h>

typedef unsigned long long ull;

/* psABI x86-64, table 4.9. width: bytes patched; 0: none or unknown. */
static const struct reloc_type {
    const char *name;
    enum image_reloc_kind kind;
    unsigned width;
} types[] = {
#define TYPE(name, kind, width) [R_X86_64_##name] = { "R_X86_64_" #name, IMAGE_RELOC_##kind, width }
    TYPE(NONE, OTHER, 0),        TYPE(64, SYMBOLIC, 8),         TYPE(PC32, SYMBOLIC, 4),
    TYPE(GOT32, OTHER, 4),       TYPE(PLT32, SYMBOLIC, 4),      TYPE(COPY, SYMBOLIC, 0),
    TYPE(GLOB_DAT, SYMBOLIC, 8), TYPE(JUMP_SLOT, SYMBOLIC, 8),  TYPE(RELATIVE, RELATIVE, 8),
    TYPE(GOTPCREL, OTHER, 4),    TYPE(32, SYMBOLIC, 4),         TYPE(32S, SYMBOLIC, 4),
    TYPE(16, SYMBOLIC, 2),       TYPE(PC16, SYMBOLIC, 2),       TYPE(8, SYMBOLIC, 1),
    TYPE(PC8, SYMBOLIC, 1),      TYPE(DTPMOD64, TLS, 8),        TYPE(DTPOFF64, TLS, 8),
    TYPE(TPOFF64, TLS, 8),       TYPE(TLSGD, TLS, 4),           TYPE(TLSLD, TLS, 4),
    TYPE(DTPOFF32, TLS, 4),      TYPE(GOTTPOFF, TLS, 4),        TYPE(TPOFF32, TLS, 4),
    TYPE(PC64, SYMBOLIC, 8),     TYPE(GOTOFF64, OTHER, 8),      TYPE(GOTPC32, OTHER, 4),
    TYPE(GOT64, OTHER, 8),       TYPE(GOTPCREL64, OTHER, 8),    TYPE(GOTPC64, OTHER, 8),
    TYPE(GOTPLT64, OTHER, 8),    TYPE(PLTOFF64, OTHER, 8),      TYPE(SIZE32, SYMBOLIC, 4),
    TYPE(SIZE64, SYMBOLIC, 8),   TYPE(GOTPC32_TLSDESC, TLS, 4), TYPE(TLSDESC_CALL, TLS, 0),
    TYPE(TLSDESC, TLS, 16),      TYPE(IRELATIVE, INDIRECT, 8),  TYPE(RELATIVE64, RELATIVE, 8),
    TYPE(GOTPCRELX, OTHER, 4),   TYPE(REX_GOTPCRELX, OTHER, 4),
#undef TYPE
};
static const struct reloc_type unknown_type = { "?", IMAGE_RELOC_OTHER, 0 };

static const struct reloc_type *type_of(uint32_t type)
{
    bool known = type < sizeof types / sizeof types[0] && types[type].name != NULL;
    return known ? &types[type] : &unknown_type;
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
    const struct reloc_type *known = type_of(type);
    struct image_reloc reloc = { .vaddr = vaddr,
                                 .addend = addend,
                                 .kind = known->kind,
                                 .type = type,
                                 .type_name = known->name };
    if (type == R_X86_64_NONE)
        return true;
    if (image_segment_at(image, vaddr, known->width != 0 ? known->width : 1) == NULL)
        return image_defect(image, "%s: entry %llu (%s) patches 0x%llx, which lies in no segment",
                            elf_tag_name(table->where), (ull)index, known->name, (ull)vaddr);
    if (image->reloc_count == ELF_MAX_RELOCS)
        return image_defect(image, "has more than %u relocations", ELF_MAX_RELOCS);
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
static bool read_rel(struct elf *elf, const struct reloc_table *table, const Elf64_Rel *rel,
                     uint64_t count)
{
    for (uint64_t i = 0; i < count; i++) {
        int64_t addend = (int64_t)image_word(elf->image, rel[i].r_offset);
        if (!add_reloc(elf, table, i, rel[i].r_offset, rel[i].r_info, addend))
            return false;
    }
    return true;
}

static bool add_relr(struct elf *elf, const struct reloc_table *table, uint64_t index,
                     uint64_t vaddr)
{
    return add_reloc(elf, table, index, vaddr, ELF64_R_INFO(0, R_X86_64_RELATIVE),
                     (int64_t)image_word(elf->image, vaddr));
}

/* An even entry is an address; an odd one is a bitmap of the 63 words that follow. */
static bool read_relr(struct elf *elf, const struct reloc_table *table, const Elf64_Xword *relr,
                      uint64_t count)
{
    uint64_t next = 0;
    for (uint64_t i = 0; i < count; i++) {
        if ((relr[i] & 1) == 0) {
            if (!add_relr(elf, table, i, relr[i]))
                return false;
            next = relr[i] + 8;
            continue;
        }
        if (i == 0)
            return image_defect(elf->image,
                                "DT_RELR starts with a bitmap (0x%llx), not with an "
                                "address",
                                (ull)relr[i]);
        for (unsigned bit = 1; bit < 64; bit++) {
            if ((relr[i] >> bit & 1) != 0 && !add_relr(elf, table, i, next + 8 * (bit - 1)))
                return false;
        }
        next += 8 * 63;
    }
    return true;
}

static bool read_table(struct elf *elf, const struct reloc_table *table)
{
    uint64_t size = elf->tag[table->size], record = elf_record_size(table->record);
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

static int compare_relocs(const void *left, const void *right)
{
    const struct image_reloc *a = left, *b = right;
    return (a->vaddr > b->vaddr) - (a->vaddr < b->vaddr);
}

/* Two relocations of one word: the result depends on the order in which a loader goes. */
static bool check_overlap(struct image *image)
{
    const struct image_reloc *relocs = image->relocs;
    for (size_t i = 1; i < image->reloc_count; i++) {
        unsigned width = type_of(relocs[i - 1].type)->width;
        if (relocs[i].vaddr - relocs[i - 1].vaddr < (width != 0 ? width : 1))
            return image_defect(image,
                                "two relocations patch the same bytes (%s at 0x%llx, %s at "
                                "0x%llx)",
                                relocs[i - 1].type_name, (ull)relocs[i - 1].vaddr,
                                relocs[i].type_name, (ull)relocs[i].vaddr);
    }
    return true;
}

bool elf_read_relocs(struct elf *elf)
{
    static const struct reloc_table rela = { ELF_RELA, ELF_RELASZ, ELF_RECORD_RELA };
    static const struct reloc_table rel = { ELF_REL, ELF_RELSZ, ELF_RECORD_REL };
    static const struct reloc_table relr = { ELF_RELR, ELF_RELRSZ, ELF_RECORD_XWORD };
    if (!read_table(elf, &rela) || !read_table(elf, &rel) || !read_table(elf, &relr) ||
        !read_jmprel(elf, &rela, &rel))
        return false;
    struct image *image = elf->image;
    if (image->reloc_count != 0)
        qsort(image->relocs, image->reloc_count, sizeof image->relocs[0], compare_relocs);
    return check_overlap(image);
}
