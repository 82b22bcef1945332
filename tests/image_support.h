/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_support.h - a complete ELF module as one C structure, byte for byte the same everywhere.
 *
 * tiny_init() makes one that is right in everything and has one of everything that struct image
 * can describe. A test changes what it wants to lie about. Fields of the first part have module
 * address == file offset; code and data are one and two pages further up.
 */
#ifndef TESTS_IMAGE_SUPPORT_H
#define TESTS_IMAGE_SUPPORT_H

#include <elf.h>
#include <stddef.h>
#include <stdint.h>

#include "image/image.h"

enum tiny_segment {
    TINY_R,
    TINY_RX,
    TINY_RW,
    TINY_DYNAMIC,
    TINY_TLS,
    TINY_STACK,
    TINY_RELRO,
    TINY_SPARE
};
enum tiny_symbol {
    TINY_MISSING = 1,
    TINY_MAYBE,
    TINY_INI,
    TINY_01,
    TINY_SHARED,
    TINY_PICK,
    TINY_SLOT
};
enum tiny_section { TINY_SYMTAB = 1, TINY_STRTAB, TINY_SHSTRTAB, TINY_CTORS, TINY_DEBUG_LINE };

#define TINY_BSS 0x100u

struct tiny {
    Elf64_Ehdr eh;
    Elf64_Phdr ph[8];
    uint32_t hash[2 + 1 + 8 + 1]; /* one to spare: the next table has to follow without a gap */
    uint32_t gnu_header[4];
    uint64_t bloom;
    uint32_t bucket;
    uint32_t chain[5];
    Elf64_Sym dynsym[8];
    char dynstr[128];
    Elf64_Rela rela[6];
    uint64_t relr[2];
    Elf64_Rela plt[2];
    Elf64_Rel rel[1];

    uint8_t code[128];

    Elf64_Dyn dyn[40];
    uint64_t init_array[2];
    uint64_t fini_array[1];
    uint64_t preinit_array[1];
    uint64_t ctors[3];
    uint64_t words[80];

    Elf64_Sym symtab[7];
    char strtab[96];
    char shstrtab[64];
    Elf64_Shdr sh[6];
};

/* Module address of a field of struct tiny. */
#define TINY_ADDRESS(field)                                                                        \
    (offsetof(struct tiny, field) +                                                                \
     (offsetof(struct tiny, field) < offsetof(struct tiny, code)  ? 0u                             \
      : offsetof(struct tiny, field) < offsetof(struct tiny, dyn) ? 0x1000u                        \
                                                                  : 0x2000u))

void tiny_init(struct tiny *tiny);
/* The first dynamic entry with that tag. tiny_dyn_add() puts one in front of the end mark. */
Elf64_Dyn *tiny_dyn(struct tiny *tiny, int64_t tag);
void tiny_dyn_add(struct tiny *tiny, int64_t tag, uint64_t value);
void tiny_dyn_remove(struct tiny *tiny, int64_t tag);

/* What image.h promises of every image, whatever the file was: NULL when it holds, else what does
 * not. */
const char *image_broken_promise(const struct image *image);

#endif
