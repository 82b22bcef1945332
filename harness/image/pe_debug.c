/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_debug.c - the debug sections of a mingw module in the one form that libdw reads: an ELF file
 * with nothing else in it.
 *
 * Works from headers that were checked when the image was opened.
 */
#include "image/pe.h"

#include <elf.h>
#include <stdlib.h>
#include <string.h>

static const char *const wanted[] = { ".debug_abbrev",   ".debug_info",     ".debug_line",
                                      ".debug_line_str", ".debug_str",      ".debug_addr",
                                      ".debug_ranges",   ".debug_rnglists" };
enum { WANTED = sizeof wanted / sizeof wanted[0], SECTIONS = WANTED + 2 };

/* A section's bytes in the file. */
struct piece {
    const uint8_t *bytes;
    uint64_t size;
};

static void find_pieces(const struct image *image, struct piece pieces[WANTED])
{
    struct pe_section section;
    for (unsigned i = 0; pe_section_at(image, i, &section); i++) {
        uint32_t size =
            section.raw_size < section.virtual_size ? section.raw_size : section.virtual_size;
        const char *name = pe_section_name(image, &section);
        for (size_t k = 0; k < WANTED; k++) {
            if (size != 0 && strcmp(name, wanted[k]) == 0)
                pieces[k] = (struct piece){ image->bytes + section.raw_offset, size };
        }
    }
}

struct wrapper {
    Elf64_Ehdr header;
    Elf64_Shdr sections[SECTIONS]; /* none, the debug sections, their names */
    char names[256];
};

static void describe(struct wrapper *elf, const struct piece pieces[WANTED])
{
    static const unsigned char ident[EI_NIDENT] = { 0x7f,       'E',         'L',       'F',
                                                    ELFCLASS64, ELFDATA2LSB, EV_CURRENT };
    uint64_t at = sizeof *elf;
    size_t name = 1;
    memcpy(elf->header.e_ident, ident, sizeof ident);
    elf->header.e_type = ET_EXEC;
    elf->header.e_machine = EM_X86_64;
    elf->header.e_version = EV_CURRENT;
    elf->header.e_shoff = offsetof(struct wrapper, sections);
    elf->header.e_ehsize = sizeof elf->header;
    elf->header.e_shentsize = sizeof elf->sections[0];
    elf->header.e_shnum = SECTIONS;
    elf->header.e_shstrndx = SECTIONS - 1;
    for (size_t i = 0; i < WANTED; i++) {
        strcpy(elf->names + name, wanted[i]);
        elf->sections[i + 1] = (Elf64_Shdr){ .sh_name = (Elf64_Word)name,
                                             .sh_type = SHT_PROGBITS,
                                             .sh_offset = at,
                                             .sh_size = pieces[i].size,
                                             .sh_addralign = 1 };
        at += pieces[i].size;
        name += strlen(wanted[i]) + 1;
    }
    elf->sections[SECTIONS - 1] = (Elf64_Shdr){ .sh_type = SHT_STRTAB,
                                                .sh_offset = offsetof(struct wrapper, names),
                                                .sh_size = sizeof elf->names,
                                                .sh_addralign = 1 };
}

void *pe_debug_as_elf(const struct image *image, size_t *size)
{
    struct piece pieces[WANTED] = { { NULL, 0 } };
    find_pieces(image, pieces);
    *size = sizeof(struct wrapper);
    for (size_t i = 0; i < WANTED; i++)
        *size += pieces[i].size;
    uint8_t *made = calloc(1, *size);
    if (made == NULL)
        return NULL;
    struct wrapper elf = { 0 };
    describe(&elf, pieces);
    memcpy(made, &elf, sizeof elf);
    uint8_t *at = made + sizeof elf;
    for (size_t i = 0; i < WANTED; i++) {
        if (pieces[i].size != 0)
            memcpy(at, pieces[i].bytes, pieces[i].size);
        at += pieces[i].size;
    }
    return made;
}
