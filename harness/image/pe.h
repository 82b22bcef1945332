/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe.h - one PE file being read; private to pe*.c.
 *
 * The reader sees what a loader sees: headers, section table, data directories, all through the
 * memory that the sections describe. It demands what the Windows loader demands (ascending sections
 * without gaps, SizeOfImage that ends with the last one) and refuses what that loader repairs in
 * silence, because the loader of TG Motion is another one. COFF symbols and debug sections are
 * hints only: what lies there is left out.
 *
 * Not checked: CheckSum (Windows looks at it for drivers only), TimeDateStamp, versions, subsystem.
 * Names of fields are those of Microsoft's PE format specification.
 */
#ifndef HARNESS_IMAGE_PE_H
#define HARNESS_IMAGE_PE_H

#include "image/image_private.h"

enum {
    PE_MAX_SECTIONS = 96, /* of the Windows loader */
    PE_COFF_HEADER = 24,  /* with the signature */
    PE_SECTION_HEADER = 40,
    PE_COFF_SYMBOL = 18,
};

enum pe_directory_index {
    PE_EXPORT,
    PE_IMPORT,
    PE_RESOURCE,
    PE_EXCEPTION,
    PE_CERTIFICATE,
    PE_RELOC,
    PE_DEBUG,
    PE_ARCHITECTURE,
    PE_GLOBAL_POINTER,
    PE_TLS,
    PE_LOAD_CONFIG,
    PE_BOUND_IMPORT,
    PE_IAT,
    PE_DELAY_IMPORT,
    PE_CLR,
    PE_RESERVED,
    PE_DIRECTORIES
};

/* Absent: both 0. Present ones (but for certificates, which are never mapped) lie in one segment.
 */
struct pe_directory {
    uint32_t vaddr, size;
};

struct pe_section {
    char name[9]; /* the header's own eight bytes */
    uint32_t virtual_size, vaddr, raw_size, raw_offset, characteristics;
};

struct pe {
    struct image *image;
    int error;     /* negative errno: the harness's trouble, not the file's */
    unsigned word; /* bytes of an address: 4 in PE32, 8 in PE32+ */
    uint32_t section_alignment, file_alignment, image_size, headers_size;
    bool relocs_stripped;
    struct pe_directory directory[PE_DIRECTORIES];
};

/* The functions below return false (or NULL) when the reader has to stop: defect or error is set;
 * where they do not, it says so. */

/* pe.c */
uint16_t pe_u16(const uint8_t *at);
uint32_t pe_u32(const uint8_t *at);
uint64_t pe_word(const struct pe *pe, const uint8_t *at);
bool pe_out_of_memory(struct pe *pe);
/* The file's bytes behind a piece of the module, NULL (and no defect) unless all of it is there. */
const uint8_t *pe_bytes(const struct pe *pe, uint64_t vaddr, uint64_t size);
/* The string there, NULL (and no defect) when it is empty, longer than IMAGE_MAX_NAME or has no end
 * in the file's part of its segment. */
const char *pe_string(const struct pe *pe, uint64_t vaddr);
/* image_text() that tells lack of memory from a defect. */
const char *pe_text(struct pe *pe, const char *text);
bool pe_add_reloc(struct pe *pe, const struct image_reloc *reloc);
bool pe_add_symbol(struct pe *pe, const struct image_symbol *symbol);

/* pe_headers.c */
bool pe_read_headers(struct pe *pe);
const char *pe_directory_name(enum pe_directory_index index);

/* pe_sections.c. The first two trust the headers, which pe_read_headers() has checked. */
bool pe_section_at(const struct image *image, unsigned index, struct pe_section *section);
/* The name, also one of more than eight bytes, which stands in the COFF string table. */
const char *pe_section_name(const struct image *image, const struct pe_section *section);
bool pe_read_sections(struct pe *pe);
bool pe_check_directories(struct pe *pe);

/* pe_relocs.c */
bool pe_read_relocs(struct pe *pe);
/* Nothing that was read is patched by a relocation. Call when all relocations are there. */
bool pe_check_relocs(struct pe *pe);
/*
 * The address that stands in the word at vaddr, as an address of the module; *null when there is
 * none. A defect when the word would be wrong anywhere but at ImageBase. what names the word.
 */
bool pe_pointer(struct pe *pe, const char *what, uint64_t vaddr, uint64_t *target, bool *null);

/* pe_exports.c, pe_imports.c, pe_initialisers.c */
bool pe_read_exports(struct pe *pe);
bool pe_read_imports(struct pe *pe);
bool pe_read_delay_imports(struct pe *pe);
bool pe_add_import(struct pe *pe, const struct image_import *import);
bool pe_read_tls(struct pe *pe);
/* After the symbols. */
bool pe_read_lists(struct pe *pe);

/* pe_symbols.c */
struct pe_strings {
    const char *text; /* NULL when there are none */
    uint32_t size;    /* the four bytes of this number included */
};
bool pe_check_symbol_table(struct pe *pe);
/* The COFF symbols (count of them) and their strings; NULL (and no defect) when there are none. */
const uint8_t *pe_symbol_table(const struct image *image, uint32_t *count,
                               struct pe_strings *strings);
const char *pe_coff_string(const struct pe_strings *strings, uint32_t offset);
/* False for lack of memory only. */
bool pe_read_symbols(struct pe *pe);

/* pe_unwind.c: after the symbols */
void pe_read_unwind(struct pe *pe);

#endif
