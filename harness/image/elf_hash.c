/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_hash.c - how many dynamic symbols there are. Nothing in an ELF file says it: it follows from
 * the hash table, and without one from the place where the next table begins.
 */
#include "image/elf.h"

typedef unsigned long long ull;

static bool limit(struct elf *elf, uint64_t count)
{
    if (count > IMAGE_MAX_SYMBOLS)
        return image_defect(elf->image, "has %llu dynamic symbols, allowed are up to %u",
                            (ull)count, IMAGE_MAX_SYMBOLS);
    return true;
}

/* Words at vaddr of the table that tag names. NULL with a defect unless the file has them. */
static const void *words(struct elf *elf, enum elf_tag tag, uint64_t vaddr, enum elf_record type,
                         uint64_t count)
{
    uint64_t offset, size = elf_record_size(elf, type);
    if (count <= elf->image->size / size &&
        image_file_range(elf->image, vaddr, count * size, &offset))
        return elf_records(elf, type, offset, count);
    image_defect(elf->image,
                 "%s 0x%llx: %llu words at 0x%llx do not lie in the file's part of its segment",
                 elf_tag_name(tag), (ull)elf->tag[tag], (ull)count, (ull)vaddr);
    return NULL;
}

static bool count_from_hash(struct elf *elf, uint64_t *count)
{
    uint64_t vaddr = elf->tag[ELF_HASH];
    const Elf64_Word *header = words(elf, ELF_HASH, vaddr, ELF_RECORD_WORD, 2);
    if (header == NULL)
        return false;
    uint64_t buckets = header[0], chains = header[1];
    if (!limit(elf, chains))
        return false;
    header = words(elf, ELF_HASH, vaddr, ELF_RECORD_WORD, 2 + buckets + chains);
    if (header == NULL)
        return false;
    if (buckets == 0)
        return image_defect(elf->image, "DT_HASH: 0 buckets, allowed is at least one");
    const Elf64_Word *links = header + 2;
    for (uint64_t i = 0; i < buckets + chains; i++) {
        if (links[i] >= chains && links[i] != 0)
            return image_defect(elf->image, "DT_HASH: word %llu names symbol %u of %llu",
                                (ull)i + 2, links[i], (ull)chains);
    }
    elf->hash = links;
    elf->hash_buckets = (uint32_t)buckets;
    *count = chains;
    return true;
}

static bool read_gnu_header(struct elf *elf, uint64_t *end)
{
    uint64_t vaddr = elf->tag[ELF_GNU_HASH];
    const Elf64_Word *header = words(elf, ELF_GNU_HASH, vaddr, ELF_RECORD_WORD, 4);
    if (header == NULL)
        return false;
    uint32_t filter = header[2];
    if (header[0] == 0 || filter == 0 || (filter & (filter - 1)) != 0 || header[3] >= 32)
        return image_defect(elf->image,
                            "DT_GNU_HASH: %u buckets, %u filter words, shift %u; allowed is at "
                            "least one bucket, a power of two of filter words, a shift below 32",
                            header[0], filter, header[3]);
    elf->gnu_bucket_count = header[0];
    elf->gnu_first = header[1];
    elf->gnu_filter_size = filter;
    elf->gnu_shift = header[3];
    elf->gnu_filter = words(elf, ELF_GNU_HASH, vaddr + 16, ELF_RECORD_ADDRESS, filter);
    if (elf->gnu_filter == NULL)
        return false;
    vaddr += 16 + elf->kind->word * (uint64_t)filter;
    *end = vaddr + 4 * (uint64_t)elf->gnu_bucket_count;
    elf->gnu_buckets = words(elf, ELF_GNU_HASH, vaddr, ELF_RECORD_WORD, elf->gnu_bucket_count);
    return elf->gnu_buckets != NULL;
}

static bool highest_bucket(struct elf *elf, uint32_t *highest)
{
    *highest = 0;
    for (uint32_t i = 0; i < elf->gnu_bucket_count; i++) {
        uint32_t symbol = elf->gnu_buckets[i];
        if (symbol != 0 && symbol < elf->gnu_first)
            return image_defect(elf->image,
                                "DT_GNU_HASH: bucket %u names symbol %u, the first one in the "
                                "table is %u",
                                i, symbol, elf->gnu_first);
        if (symbol > *highest)
            *highest = symbol;
    }
    return true;
}

/* The symbols of a bucket stand one after the other; a chain word with bit 0 set ends them. */
static bool end_of_chain(struct elf *elf, uint64_t chains, uint32_t symbol, uint64_t *count)
{
    const struct image_segment *segment = image_segment_at(elf->image, chains, 1);
    uint64_t room = 1, at = symbol - elf->gnu_first;
    if (segment != NULL && chains - segment->vaddr < segment->file_size)
        room = (segment->file_size - (chains - segment->vaddr)) / 4;
    if (room > IMAGE_MAX_SYMBOLS)
        room = IMAGE_MAX_SYMBOLS;
    elf->gnu_chains = words(elf, ELF_GNU_HASH, chains, ELF_RECORD_WORD, room);
    if (elf->gnu_chains == NULL)
        return false;
    while (at < room && (elf->gnu_chains[at] & 1) == 0)
        at++;
    if (at >= room)
        return image_defect(elf->image, "DT_GNU_HASH: the chain of symbol %u has no end", symbol);
    *count = elf->gnu_first + at + 1;
    if (!limit(elf, *count))
        return false;
    elf->gnu_end = (uint32_t)*count;
    return true;
}

/* *count stays 0 when the table holds no symbol: then it does not know how many there are. */
static bool count_from_gnu_hash(struct elf *elf, uint64_t *count)
{
    uint64_t chains = 0;
    uint32_t highest;
    if (!read_gnu_header(elf, &chains) || !highest_bucket(elf, &highest))
        return false;
    return highest == 0 || end_of_chain(elf, chains, highest, count);
}

/* As many as fit in front of the next table and name a string that exists. */
static bool count_from_gap(struct elf *elf, uint64_t *count)
{
    static const enum elf_tag tables[] = { ELF_STRTAB,     ELF_HASH,       ELF_GNU_HASH,
                                           ELF_RELA,       ELF_REL,        ELF_JMPREL,
                                           ELF_RELR,       ELF_INIT,       ELF_FINI,
                                           ELF_INIT_ARRAY, ELF_FINI_ARRAY, ELF_PREINIT_ARRAY,
                                           ELF_VERSYM,     ELF_VERNEED,    ELF_VERDEF };
    uint64_t begin = elf->tag[ELF_SYMTAB];
    const struct image_segment *segment = image_segment_at(elf->image, begin, 1);
    *count = 0;
    if (segment == NULL || begin - segment->vaddr >= segment->file_size)
        return true;
    uint64_t end = segment->vaddr + segment->file_size;
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++) {
        uint64_t vaddr = elf->tag[tables[i]];
        if (elf->has_tag[tables[i]] && vaddr > begin && vaddr < end)
            end = vaddr;
    }
    uint64_t room = (end - begin) / elf_record_size(elf, ELF_RECORD_SYM);
    if (room > IMAGE_MAX_SYMBOLS)
        room = IMAGE_MAX_SYMBOLS;
    if (room == 0)
        return true;
    const Elf64_Sym *symbols = elf_table(elf, ELF_RECORD_SYM, ELF_SYMTAB, room);
    if (symbols == NULL)
        return false;
    while (*count < room && symbols[*count].st_name < elf->dynstr.size)
        ++*count;
    return true;
}

bool elf_count_symbols(struct elf *elf, uint64_t *count)
{
    uint64_t from_hash = 0, from_gnu = 0;
    if (elf->has_tag[ELF_HASH] && !count_from_hash(elf, &from_hash))
        return false;
    if (elf->has_tag[ELF_GNU_HASH] && !count_from_gnu_hash(elf, &from_gnu))
        return false;
    if (elf->has_tag[ELF_HASH] && from_gnu > from_hash)
        return image_defect(elf->image, "DT_GNU_HASH holds %llu symbols, DT_HASH %llu",
                            (ull)from_gnu, (ull)from_hash);
    *count = elf->has_tag[ELF_HASH] ? from_hash : from_gnu;
    return *count != 0 || count_from_gap(elf, count);
}
