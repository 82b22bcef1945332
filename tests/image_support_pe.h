/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_support_pe.h - a complete PE module, byte for byte the same everywhere, in both widths.
 *
 * tiny_pe_init() makes one that is right in everything and has one of everything that struct image
 * can describe. A test changes what it wants to lie about. The places below are offsets in the
 * file; PE_VADDR() turns one into an address of the module.
 */
#ifndef TESTS_IMAGE_SUPPORT_PE_H
#define TESTS_IMAGE_SUPPORT_PE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TINY_PE_BASE 0x20000000u

enum {
    PE_LFANEW = 0x3c,
    PE_SIGNATURE = 0x40,
    PE_MACHINE = 0x44,
    PE_NUMBER_OF_SECTIONS = 0x46,
    PE_POINTER_TO_SYMBOLS = 0x4c,
    PE_NUMBER_OF_SYMBOLS = 0x50,
    PE_SIZE_OF_OPTIONAL = 0x54,
    PE_CHARACTERISTICS = 0x56,
    PE_MAGIC = 0x58,
    PE_ENTRY_POINT = 0x68,
    PE_SECTION_ALIGNMENT = 0x78,
    PE_FILE_ALIGNMENT = 0x7c,
    PE_SIZE_OF_IMAGE = 0x90,
    PE_SIZE_OF_HEADERS = 0x94,
    PE_DLL_CHARACTERISTICS = 0x9e,

    PE_TEXT_AT = 0x200,  /* 0x1000 */
    PE_RDATA_AT = 0x400, /* 0x2000 */
    PE_EXPORTS_AT = 0x400,
    PE_FUNCTIONS_AT = 0x428,
    PE_NAMES_AT = 0x440,
    PE_ORDINALS_AT = 0x450,
    PE_STRINGS_AT = 0x460, /* "tiny.dll", "Program_01", "Program_Ini", "away", "OTHER.Name" */
    PE_IMPORTS_AT = 0x500,
    PE_LOOKUP_AT = 0x540,
    PE_HINT_AT = 0x560,
    PE_LIBRARY_AT = 0x570,
    PE_DELAY_AT = 0x580,
    PE_DELAY_NAMES_AT = 0x5c0,
    PE_DELAY_HINT_AT = 0x5d0,
    PE_DELAY_LIBRARY_AT = 0x5e0,
    PE_TLS_AT = 0x600,
    PE_CALLBACKS_AT = 0x640,
    PE_CONFIG_AT = 0x680,
    PE_RDATA_END = 0x7f0,

    PE_DATA_AT = 0x800, /* 0x3000 */
    PE_SLOTS_AT = 0x800,
    PE_DELAY_SLOT_AT = 0x820,
    PE_TEMPLATE_AT = 0x840,
    PE_INDEX_AT = 0x850,
    PE_POINTER_AT = 0x860,
    PE_RELOCS_AT = 0xa00, /* 0x4000 */
    PE_SECOND_BLOCK_AT = 0xa14,
    PE_RELOCS_SIZE = 0x24,

    PE_SYMBOLS_AT = 0xc00,
    PE_COFF_STRINGS_AT = 0xc48,
    PE_CERTIFICATE_AT = 0xc60,
    TINY_PE_SIZE = 0xc70,
};

struct tiny_pe {
    bool wide;
    unsigned word;
    size_t directories, sections; /* where the tables begin */
    uint8_t *bytes;               /* the file: own, unless a test needs more room */
    uint8_t own[TINY_PE_SIZE];
};

#define PE_VADDR(at)                                                                               \
    ((at) < PE_RDATA_AT    ? (uint32_t)(at)-PE_TEXT_AT + 0x1000                                    \
     : (at) < PE_DATA_AT   ? (uint32_t)(at)-PE_RDATA_AT + 0x2000                                   \
     : (at) < PE_RELOCS_AT ? (uint32_t)(at)-PE_DATA_AT + 0x3000                                    \
                           : (uint32_t)(at)-PE_RELOCS_AT + 0x4000)

void tiny_pe_init(struct tiny_pe *t, bool wide);
void pe_put(struct tiny_pe *t, size_t at, unsigned width, uint64_t value);
/* As wide as an address of the module. */
void pe_put_word(struct tiny_pe *t, size_t at, uint64_t value);
/* Fields of the index-th directory (0 address, 4 size) and section (as in the file). */
void pe_put_directory(struct tiny_pe *t, unsigned index, uint32_t vaddr, uint32_t size);
void pe_put_section(struct tiny_pe *t, unsigned index, unsigned field, uint32_t value);

#endif
