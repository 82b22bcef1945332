/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_lookup.c - do the hash tables find what the symbol table offers?
 *
 * Some loaders walk the symbol table, others ask a hash table. A file that was edited after linking
 * may answer them differently, and a chain that runs in a circle never answers at all. Everything
 * here takes time proportional to the tables, however they are knotted.
 */
#include "image/elf.h"

#include <stdlib.h>

static uint32_t hash_of(const char *name)
{
    uint32_t hash = 0;
    for (; *name != '\0'; name++) {
        hash = (hash << 4) + (unsigned char)*name;
        hash ^= hash >> 24 & 0xf0;
        hash &= 0x0fffffff;
    }
    return hash;
}

static uint32_t gnu_hash_of(const char *name)
{
    uint32_t hash = 5381;
    for (; *name != '\0'; name++)
        hash = 33 * hash + (unsigned char)*name;
    return hash;
}

/* A symbol that a lookup has to find. Its name was checked when it was read. */
static const char *wanted(const struct elf *elf, uint32_t index)
{
    const Elf64_Sym *symbol = &elf->dynsym[index];
    if (symbol->st_shndx == SHN_UNDEF || !elf_is_exported(symbol))
        return NULL;
    const char *name = elf_string(&elf->dynstr, symbol->st_name);
    return name != NULL && name[0] != '\0' ? name : NULL;
}

static bool not_found(struct elf *elf, const char *table, const char *name)
{
    return image_defect(elf->image,
                        "exports %.64s, but %s does not find it: was the file changed after "
                        "linking?",
                        name, table);
}

/* bucket_of[i]: the bucket whose chain holds symbol i, plus 1. */
static bool walk_chains(struct elf *elf, uint32_t *bucket_of)
{
    const Elf64_Word *links = elf->hash + elf->hash_buckets;
    for (uint32_t bucket = 0; bucket < elf->hash_buckets; bucket++) {
        for (uint32_t at = elf->hash[bucket]; at != 0; at = links[at]) {
            if (bucket_of[at] != 0)
                return image_defect(elf->image,
                                    "DT_HASH: symbol %u is in two chains or in a circle", at);
            bucket_of[at] = bucket + 1;
        }
    }
    return true;
}

static bool check_hash(struct elf *elf)
{
    uint32_t *bucket_of = calloc(elf->dynsym_count, sizeof bucket_of[0]);
    if (bucket_of == NULL)
        return elf_out_of_memory(elf);
    bool go_on = walk_chains(elf, bucket_of);
    for (uint32_t i = 1; go_on && i < elf->dynsym_count; i++) {
        const char *name = wanted(elf, i);
        if (name != NULL && bucket_of[i] != hash_of(name) % elf->hash_buckets + 1)
            go_on = not_found(elf, "DT_HASH", name);
    }
    free(bucket_of);
    return go_on;
}

static bool gnu_finds(const struct elf *elf, const char *name, uint32_t index, uint32_t run)
{
    uint32_t hash = gnu_hash_of(name), bits = 8 * elf->kind->word;
    uint64_t filter = elf->gnu_filter[hash / bits & (elf->gnu_filter_size - 1)];
    uint32_t bucket = elf->gnu_buckets[hash % elf->gnu_bucket_count];
    return (filter >> hash % bits & 1) != 0 &&
           (filter >> (hash >> elf->gnu_shift) % bits & 1) != 0 && bucket != 0 && bucket >= run &&
           bucket <= index && (elf->gnu_chains[index - elf->gnu_first] | 1) == (hash | 1);
}

static bool check_gnu_hash(struct elf *elf)
{
    /* The symbols from run on stand in one chain with this one. */
    uint32_t run = elf->gnu_first;
    for (uint32_t i = 1; i < elf->dynsym_count; i++) {
        const char *name = wanted(elf, i);
        bool inside = i >= elf->gnu_first && i < elf->gnu_end;
        if (name != NULL && (!inside || !gnu_finds(elf, name, i, run)))
            return not_found(elf, "DT_GNU_HASH", name);
        if (inside && (elf->gnu_chains[i - elf->gnu_first] & 1) != 0)
            run = i + 1;
    }
    return true;
}

bool elf_check_lookup(struct elf *elf)
{
    if (elf->hash != NULL && !check_hash(elf))
        return false;
    return elf->gnu_buckets == NULL || check_gnu_hash(elf);
}
