/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf.h - one ELF file being read; private to elf*.c.
 *
 * The reader sees what a loader sees: program headers and the dynamic table. Section headers are
 * hints only (names of local functions, weak symbols that the linker resolved to null, .ctors);
 * what they say is checked like everything else and dropped when it does not hold.
 *
 * Only elf.c includes libelf. It hands out records of the file in the host's byte order and as the
 * Elf64 structures of <elf.h>, whatever the file's class is, from ranges that were checked against
 * the file before. What differs by class or machine is in struct elf_kind.
 */
#ifndef HARNESS_IMAGE_ELF_H
#define HARNESS_IMAGE_ELF_H

#include <elf.h>

#include "image/image_private.h"

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
    ELF_RECORD_WORD,    /* uint32_t in both classes */
    ELF_RECORD_ADDRESS, /* a word as wide as an address; uint64_t here */
    ELF_RECORDS
};

struct elf_reloc_type {
    const char *name; /* NULL: no such type */
    enum image_reloc_kind kind;
    unsigned width; /* bytes patched; 0: none or unknown */
};

/* A kind of ELF file that can be a module. */
struct elf_kind {
    unsigned char class;
    uint16_t machine;
    unsigned word;        /* bytes of an address in the file */
    uint64_t address_max; /* the highest one */
    const struct elf_reloc_type *reloc_types;
    size_t reloc_type_count;
    uint32_t reloc_none;     /* patches nothing */
    uint32_t reloc_relative; /* what DT_RELR means */
    uint32_t reloc_absolute; /* the address of a symbol and nothing else */
    bool thumb;              /* bit 0 of a function's address says that it is Thumb code */
};

/* A string table whose last byte is known to be zero, so every string in it ends. */
struct elf_strings {
    const char *text;
    uint64_t size;
};

struct elf {
    struct image *image;
    const struct elf_kind *kind;
    struct Elf *handle;
    struct elf_copy *copies; /* tables handed out that libelf does not own */
    int error;               /* negative errno: the harness's trouble, not the file's */
    Elf64_Ehdr header;

    bool has_dynamic; /* PT_DYNAMIC was seen and checked */
    Elf64_Phdr dynamic;
    uint64_t tag[ELF_TAGS];
    bool has_tag[ELF_TAGS];

    /* Hash tables, NULL when there are none. Every symbol number in them is checked. */
    const Elf64_Word *hash; /* buckets, then one link per symbol */
    uint32_t hash_buckets;
    const uint64_t *gnu_filter; /* words of as many bits as an address has */
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
/* Bytes of a record in the file. */
size_t elf_record_size(const struct elf *elf, enum elf_record type);
/* Header and name ("" when unknown) of a section. False when there is no such section. */
bool elf_section(struct elf *elf, size_t index, Elf64_Shdr *header, const char **name);
/* The section's bytes lie in the file. */
bool elf_section_in_file(const struct elf *elf, const Elf64_Shdr *header);
bool elf_strings_at(const struct image *image, uint64_t offset, uint64_t size,
                    struct elf_strings *strings);
/* NULL when index lies outside the table or the string is longer than IMAGE_MAX_NAME. */
const char *elf_string(const struct elf_strings *strings, uint64_t index);

/* elf_header.c */
/* Sets *kind. */
bool elf_check_ident(struct image *image, const struct elf_kind **kind);
bool elf_check_header(struct image *image, const struct elf_kind *kind, const Elf64_Ehdr *header);

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
/* Appends a defined symbol; finish with image_sort_symbols(). */
bool elf_add_symbol(struct elf *elf, const Elf64_Sym *symbol, const char *name, bool exported);
/* The symbol's value without the Thumb bit. */
uint64_t elf_symbol_vaddr(const struct elf *elf, const Elf64_Sym *symbol);
/* Why the symbol's range cannot be, NULL when it can. */
const char *elf_symbol_lie(const struct elf *elf, const Elf64_Sym *symbol);
const struct image_symbol *elf_find_export(const struct elf *elf, const char *name);

/* elf_symtab.c: never a defect, what lies there is left out. */
bool elf_read_symtab(struct elf *elf);

/* elf_kinds.c: NULL when there is no such kind of module. */
const struct elf_kind *elf_find_kind(unsigned class, unsigned machine);

/* elf_relocs.c */
bool elf_read_relocs(struct elf *elf);

/* elf_initialisers.c */
bool elf_read_initialisers(struct elf *elf);

#endif
