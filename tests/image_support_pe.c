/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "image_support_pe.h"

#include <string.h>

void pe_put(struct tiny_pe *t, size_t at, unsigned width, uint64_t value)
{
    for (unsigned i = 0; i < width; i++)
        t->bytes[at + i] = (uint8_t)(value >> (8 * i));
}

void pe_put_word(struct tiny_pe *t, size_t at, uint64_t value)
{
    pe_put(t, at, t->word, value);
}

void pe_put_directory(struct tiny_pe *t, unsigned index, uint32_t vaddr, uint32_t size)
{
    pe_put(t, t->directories + 8 * index, 4, vaddr);
    pe_put(t, t->directories + 8 * index + 4, 4, size);
}

void pe_put_section(struct tiny_pe *t, unsigned index, unsigned field, uint32_t value)
{
    pe_put(t, t->sections + 40 * index + field, 4, value);
}

static void put_text(struct tiny_pe *t, size_t at, const char *text)
{
    memcpy(t->bytes + at, text, strlen(text) + 1);
}

static void headers(struct tiny_pe *t)
{
    size_t size = t->wide ? 240 : 224;
    put_text(t, 0, "MZ");
    pe_put(t, PE_LFANEW, 4, PE_SIGNATURE);
    put_text(t, PE_SIGNATURE, "PE");
    pe_put(t, PE_MACHINE, 2, t->wide ? 0x8664 : 0x014c);
    pe_put(t, PE_NUMBER_OF_SECTIONS, 2, 4);
    pe_put(t, PE_POINTER_TO_SYMBOLS, 4, PE_SYMBOLS_AT);
    pe_put(t, PE_NUMBER_OF_SYMBOLS, 4, 4);
    pe_put(t, PE_SIZE_OF_OPTIONAL, 2, size);
    pe_put(t, PE_CHARACTERISTICS, 2, 0x2022);
    pe_put(t, PE_MAGIC, 2, t->wide ? 0x20b : 0x10b);
    pe_put(t, PE_ENTRY_POINT, 4, 0x1050);
    if (t->wide)
        pe_put(t, 0x70, 8, TINY_PE_BASE);
    else
        pe_put(t, 0x74, 4, TINY_PE_BASE);
    pe_put(t, PE_SECTION_ALIGNMENT, 4, 0x1000);
    pe_put(t, PE_FILE_ALIGNMENT, 4, 0x200);
    pe_put(t, PE_SIZE_OF_IMAGE, 4, 0x5000);
    pe_put(t, PE_SIZE_OF_HEADERS, 4, 0x200);
    pe_put(t, PE_DLL_CHARACTERISTICS, 2, 0x140);
    t->directories = PE_MAGIC + size - 128;
    t->sections = PE_MAGIC + size;
    pe_put(t, t->directories - 4, 4, 16);
}

static void sections(struct tiny_pe *t)
{
    static const struct {
        const char *name;
        uint32_t virtual_size, vaddr, raw_size, raw_offset, characteristics;
    } table[] = {
        { ".text", 0x100, 0x1000, 0x200, PE_TEXT_AT, 0x60000020 },
        { ".rdata", 0x400, 0x2000, 0x400, PE_RDATA_AT, 0x40000040 },
        { ".data", 0x300, 0x3000, 0x200, PE_DATA_AT, 0xc0000040 },
        { ".reloc", PE_RELOCS_SIZE, 0x4000, 0x200, PE_RELOCS_AT, 0x42000040 },
    };
    for (unsigned i = 0; i < 4; i++) {
        put_text(t, t->sections + 40 * i, table[i].name);
        pe_put_section(t, i, 8, table[i].virtual_size);
        pe_put_section(t, i, 12, table[i].vaddr);
        pe_put_section(t, i, 16, table[i].raw_size);
        pe_put_section(t, i, 20, table[i].raw_offset);
        pe_put_section(t, i, 36, table[i].characteristics);
    }
}

/* Ordinals from 5: Program_Ini, Program_01, away (elsewhere), one without a name, a hole. */
static void exports(struct tiny_pe *t)
{
    static const uint32_t functions[] = { 0x1000, 0x1010, PE_VADDR(PE_STRINGS_AT + 0x30), 0x1020,
                                          0 };
    static const uint32_t names[] = { 0x10, 0x1c, 0x28 };
    static const uint16_t ordinals[] = { 1, 0, 2 };
    put_text(t, PE_STRINGS_AT, "tiny.dll");
    put_text(t, PE_STRINGS_AT + 0x10, "Program_01");
    put_text(t, PE_STRINGS_AT + 0x1c, "Program_Ini");
    put_text(t, PE_STRINGS_AT + 0x28, "away");
    put_text(t, PE_STRINGS_AT + 0x30, "OTHER.Name");
    pe_put(t, PE_EXPORTS_AT + 12, 4, PE_VADDR(PE_STRINGS_AT));
    pe_put(t, PE_EXPORTS_AT + 16, 4, 5);
    pe_put(t, PE_EXPORTS_AT + 20, 4, 5);
    pe_put(t, PE_EXPORTS_AT + 24, 4, 3);
    pe_put(t, PE_EXPORTS_AT + 28, 4, PE_VADDR(PE_FUNCTIONS_AT));
    pe_put(t, PE_EXPORTS_AT + 32, 4, PE_VADDR(PE_NAMES_AT));
    pe_put(t, PE_EXPORTS_AT + 36, 4, PE_VADDR(PE_ORDINALS_AT));
    for (unsigned i = 0; i < 5; i++)
        pe_put(t, PE_FUNCTIONS_AT + 4 * i, 4, functions[i]);
    for (unsigned i = 0; i < 3; i++) {
        pe_put(t, PE_NAMES_AT + 4 * i, 4, PE_VADDR(PE_STRINGS_AT) + names[i]);
        pe_put(t, PE_ORDINALS_AT + 2 * i, 2, ordinals[i]);
    }
    pe_put_directory(t, 0, PE_VADDR(PE_EXPORTS_AT), 0xa0);
}

static void imports(struct tiny_pe *t)
{
    uint64_t by_ordinal = (uint64_t)1 << (8 * t->word - 1) | 12;
    put_text(t, PE_HINT_AT + 2, "Sleep");
    put_text(t, PE_LIBRARY_AT, "KERNEL32.dll");
    pe_put(t, PE_IMPORTS_AT, 4, PE_VADDR(PE_LOOKUP_AT));
    pe_put(t, PE_IMPORTS_AT + 12, 4, PE_VADDR(PE_LIBRARY_AT));
    pe_put(t, PE_IMPORTS_AT + 16, 4, PE_VADDR(PE_SLOTS_AT));
    for (unsigned table = 0; table < 2; table++) {
        size_t at = table == 0 ? PE_LOOKUP_AT : PE_SLOTS_AT;
        pe_put_word(t, at, PE_VADDR(PE_HINT_AT));
        pe_put_word(t, at + t->word, by_ordinal);
    }
    pe_put_directory(t, 1, PE_VADDR(PE_IMPORTS_AT), 40);
    pe_put_directory(t, 12, PE_VADDR(PE_SLOTS_AT), 3 * t->word);
}

static void delay_imports(struct tiny_pe *t)
{
    put_text(t, PE_DELAY_HINT_AT + 2, "later");
    put_text(t, PE_DELAY_LIBRARY_AT, "LATE.dll");
    pe_put(t, PE_DELAY_AT, 4, 1);
    pe_put(t, PE_DELAY_AT + 4, 4, PE_VADDR(PE_DELAY_LIBRARY_AT));
    pe_put(t, PE_DELAY_AT + 8, 4, 0x3200);
    pe_put(t, PE_DELAY_AT + 12, 4, PE_VADDR(PE_DELAY_SLOT_AT));
    pe_put(t, PE_DELAY_AT + 16, 4, PE_VADDR(PE_DELAY_NAMES_AT));
    pe_put_word(t, PE_DELAY_NAMES_AT, PE_VADDR(PE_DELAY_HINT_AT));
    pe_put_word(t, PE_DELAY_SLOT_AT, TINY_PE_BASE + 0x1040);
    pe_put_directory(t, 13, PE_VADDR(PE_DELAY_AT), 64);
}

static void tls(struct tiny_pe *t)
{
    unsigned word = t->word;
    pe_put_word(t, PE_TLS_AT, TINY_PE_BASE + PE_VADDR(PE_TEMPLATE_AT));
    pe_put_word(t, PE_TLS_AT + word, TINY_PE_BASE + PE_VADDR(PE_TEMPLATE_AT) + 8);
    pe_put_word(t, PE_TLS_AT + 2 * word, TINY_PE_BASE + PE_VADDR(PE_INDEX_AT));
    pe_put_word(t, PE_TLS_AT + 3 * word, TINY_PE_BASE + PE_VADDR(PE_CALLBACKS_AT));
    pe_put(t, PE_TLS_AT + 4 * word, 4, 16);
    pe_put_word(t, PE_CALLBACKS_AT, TINY_PE_BASE + 0x1060);
    pe_put_word(t, PE_CALLBACKS_AT + word, TINY_PE_BASE + 0x1070);
    pe_put_directory(t, 9, PE_VADDR(PE_TLS_AT), 4 * word + 8);
}

static void relocs(struct tiny_pe *t)
{
    unsigned type = t->wide ? 0xa000 : 0x3000, word = t->word, entry = 0;
    pe_put(t, PE_RELOCS_AT, 4, 0x2000);
    pe_put(t, PE_RELOCS_AT + 4, 4, 20);
    for (; entry < 4; entry++)
        pe_put(t, PE_RELOCS_AT + 8 + 2 * entry, 2, type | (0x200 + entry * word));
    for (; entry < 6; entry++)
        pe_put(t, PE_RELOCS_AT + 8 + 2 * entry, 2, type | (0x240 + (entry - 4) * word));
    pe_put(t, PE_SECOND_BLOCK_AT, 4, 0x3000);
    pe_put(t, PE_SECOND_BLOCK_AT + 4, 4, 16);
    pe_put(t, PE_SECOND_BLOCK_AT + 8, 2, type | 0x020);
    pe_put(t, PE_SECOND_BLOCK_AT + 10, 2, type | 0x060);
    pe_put(t, PE_SECOND_BLOCK_AT + 12, 2, 0);
    pe_put(t, PE_SECOND_BLOCK_AT + 14, 2, 0);
    pe_put_word(t, PE_POINTER_AT, TINY_PE_BASE + 0x3200);
    pe_put_directory(t, 5, PE_VADDR(PE_RELOCS_AT), PE_RELOCS_SIZE);
}

static void coff_symbol(struct tiny_pe *t, unsigned index, const char *name, uint32_t value,
                        unsigned section, unsigned type)
{
    size_t at = PE_SYMBOLS_AT + 18 * index;
    memcpy(t->bytes + at, name, strlen(name));
    pe_put(t, at + 8, 4, value);
    pe_put(t, at + 12, 2, section);
    pe_put(t, at + 14, 2, type);
    t->bytes[at + 16] = 3;
}

/* On i386 C names have a "_" in front. */
static void symbols(struct tiny_pe *t)
{
    coff_symbol(t, 0, t->wide ? "local" : "_local", 0x30, 1, 0x20);
    coff_symbol(t, 1, "", 0x10, 1, 0x20);
    pe_put(t, PE_SYMBOLS_AT + 18 + 4, 4, 4);
    coff_symbol(t, 2, ".text", 0, 1, 0);
    coff_symbol(t, 3, t->wide ? "variable" : "_variabl", 0x60, 3, 0);
    pe_put(t, PE_COFF_STRINGS_AT, 4, 16);
    put_text(t, PE_COFF_STRINGS_AT + 4, t->wide ? "Program_01" : "_Program_01");
    put_text(t, PE_CERTIFICATE_AT, "certificate");
    pe_put_directory(t, 4, PE_CERTIFICATE_AT, 16);
}

void tiny_pe_init(struct tiny_pe *t, bool wide)
{
    memset(t, 0, sizeof *t);
    t->bytes = t->own;
    t->wide = wide;
    t->word = wide ? 8 : 4;
    headers(t);
    sections(t);
    exports(t);
    imports(t);
    delay_imports(t);
    tls(t);
    relocs(t);
    symbols(t);
    pe_put(t, PE_CONFIG_AT, 4, 0x70);
    pe_put_directory(t, 10, PE_VADDR(PE_CONFIG_AT), 0x40);
}
