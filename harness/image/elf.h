/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf.h - one ELF file being read; private to elf*.c.
 *
 * The reader sees what a loader sees: program headers and the dynamic table. Section headers are
 * hints only (names of local functions, weak symbols that the linker resolved to null, .ctors);
 * what they say is checked like everything else and dropped when it does not hold.
 *
 * Only elf.c includes libelf. It hands out records of the file in the host's byte order, as the
 * Elf64 structures of <elf.h>, from ranges that were checked against the file before.
 */
#ifndef HARNESS_IMAGE_ELF_H
#define HARNESS_IMAGE_ELF_H

#include <elf.h>

#include "image/image_private.h"

/* More than any controller program has, and few enough that no file makes the reader slow. */
#define ELF_MAX_SPAN         (256u << 20)
#define ELF_MAX_SYMBOLS      (1u << 18)
#define ELF_MAX_RELOCS       (1u << 20)
#define ELF_MAX_IMPORTS      (1u << 18)
#define ELF_MAX_INITIALISERS (1u << 16)
#define ELF_MAX_NAME         1024u
#define ELF_PAGE             4096u

/* The dynamic tags that may be stated once; rows of elf_tags[] in elf_dynamic.c. */
enum elf_tag {
    ELF_STRTAB,
    ELF_STRSZ,
    ELF_SYMTAB,
    ELF_SYMENT,
    ELF_HASH,
    ELF_GNU_HASH,
    ELF_RELA,
    ELF_RELASZ,
    ELF_RELAENT,
    ELF_REL,
    ELF_RELSZ,
    ELF_RELENT,
    ELF_JMPREL,
    ELF_PLTRELSZ,
    ELF_PLTREL,
    ELF_RELR,
    ELF_RELRSZ,
    ELF_RELRENT,
    ELF_INIT,
    ELF_FINI,
    ELF_INIT_ARRAY,
    ELF_INIT_ARRAYSZ,
    ELF_FINI_ARRAY,
    ELF_FINI_ARRAYSZ,
    ELF_PREINIT_ARRAY,
    ELF_PREINIT_ARRAYSZ,
    ELF_VERSYM,
    ELF_VERNEED,
    ELF_VERDEF,
    ELF_FLAGS_1,
    ELF_TAGS
};

enum elf_record {
    ELF_RECORD_DYN,
    ELF_RECORD_SYM,
    ELF_RECORD_RELA,
    ELF_RECORD_REL,
    ELF_RECORD_WORD,
    ELF_RECORD_XWORD,
    ELF_RECORDS
};

/* A string table whose last byte is known to be zero, so every string in it ends. */
struct elf_strings {
    const char *text;
    uint64_t size;
};

struct elf {
    struct image *image;
    struct Elf *handle;
    int error; /* negative errno: the harness's trouble, not the file's */
    Elf64_Ehdr header;

    bool has_dynamic; /* PT_DYNAMIC was seen and checked */
    Elf64_Phdr dynamic;
    uint64_t tag[ELF_TAGS];
    bool has_tag[ELF_TAGS];

    /* Hash tables, NULL when there are none. Every symbol number in them is checked. */
    const Elf64_Word *hash; /* buckets, then one link per symbol */
    uint32_t hash_buckets;
    const Elf64_Xword *gnu_filter;
    uint32_t gnu_filter_size, gnu_shift;
    const Elf64_Word *gnu_buckets;
    uint32_t gnu_bucket_count;
    const Elf64_Word *gnu_chains; /* of the symbols from gnu_first to before gnu_end */
    uint32_t gnu_first, gnu_end;

    struct elf_strings dynstr;
    const Elf64_Sym *dynsym; /* entry 0 is the null symbol */
    uint32_t dynsym_count;
    uint32_t *import_of; /* per dynamic symbol: its import's index + 1, 0 when it is none */
    const struct image_symbol **exports; /* sorted by name; valid until elf_read_symtab() */
    size_t export_count;
};

/* elf.c. The functions below return false when the reader has to stop: defect or error is set. */
bool elf_out_of_memory(struct elf *elf);
const void *elf_records(struct elf *elf, enum elf_record type, uint64_t offset, uint64_t count);
size_t elf_record_size(enum elf_record type);
/* Header and name ("" when unknown) of a section. False when there is no such section. */
bool elf_section(struct elf *elf, size_t index, Elf64_Shdr *header, const char **name);
/* The section's bytes lie in the file. */
bool elf_section_in_file(const struct elf *elf, const Elf64_Shdr *header);
bool elf_strings_at(const struct image *image, uint64_t offset, uint64_t size,
                    struct elf_strings *strings);
/* NULL when index lies outside the table or the string is longer than ELF_MAX_NAME. */
const char *elf_string(const struct elf_strings *strings, uint64_t index);

/* elf_header.c */
bool elf_check_ident(struct image *image);
bool elf_check_header(struct image *image, const Elf64_Ehdr *header);

/* elf_segments.c */
bool elf_read_segment(struct elf *elf, size_t index, const Elf64_Phdr *ph);
bool elf_finish_segments(struct elf *elf);

/* elf_dynamic.c */
bool elf_read_dynamic(struct elf *elf);
const char *elf_tag_name(enum elf_tag tag);
/* count records of type at the address in tag: NULL with a defect unless the file has them. */
const void *elf_table(struct elf *elf, enum elf_record type, enum elf_tag tag, uint64_t count);
bool elf_add_import(struct elf *elf, enum image_import_kind kind, const char *name);

/* elf_hash.c: number of dynamic symbols, the null symbol included. Sets the hash tables. */
bool elf_count_symbols(struct elf *elf, uint64_t *count);

/* elf_lookup.c: the hash tables find every exported symbol. */
bool elf_check_lookup(struct elf *elf);

/* elf_symbols.c */
bool elf_read_dynamic_symbols(struct elf *elf);
/* The symbol's binding and visibility let others see it. */
bool elf_is_exported(const Elf64_Sym *symbol);
/* Appends a defined symbol; finish with elf_sort_symbols(). */
bool elf_add_symbol(struct elf *elf, const Elf64_Sym *symbol, const char *name, bool exported);
/* By address, then name; of equal ones the exported one stays. */
void elf_sort_symbols(struct image *image);
/* Why the symbol's range cannot be, NULL when it can. */
const char *elf_symbol_lie(const struct image *image, const Elf64_Sym *symbol);
const struct image_symbol *elf_find_export(const struct elf *elf, const char *name);

/* elf_symtab.c: never a defect, what lies there is left out. */
bool elf_read_symtab(struct elf *elf);

/* elf_relocs.c */
bool elf_read_relocs(struct elf *elf);

/* elf_initialisers.c */
bool elf_read_initialisers(struct elf *elf);

#endif
