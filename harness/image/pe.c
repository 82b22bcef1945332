/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe.c - the order in which a PE file is read, and how its bytes are reached.
 */
#include "image/pe.h"

#include <errno.h>
#include <string.h>

uint16_t pe_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | (unsigned)at[1] << 8);
}

uint32_t pe_u32(const uint8_t *at)
{
    return pe_u16(at) | (uint32_t)pe_u16(at + 2) << 16;
}

uint64_t pe_word(const struct pe *pe, const uint8_t *at)
{
    return pe->word == 4 ? pe_u32(at) : pe_u32(at) | (uint64_t)pe_u32(at + 4) << 32;
}

bool pe_out_of_memory(struct pe *pe)
{
    pe->error = -ENOMEM;
    return false;
}

const uint8_t *pe_bytes(const struct pe *pe, uint64_t vaddr, uint64_t size)
{
    uint64_t offset;
    return image_file_range(pe->image, vaddr, size, &offset) ? pe->image->bytes + offset : NULL;
}

const char *pe_string(const struct pe *pe, uint64_t vaddr)
{
    const struct image_segment *segment = image_segment_at(pe->image, vaddr, 1);
    /* Address 0 means that there is none, though the file's "MZ" is there. */
    if (vaddr == 0 || segment == NULL || vaddr - segment->vaddr >= segment->file_size)
        return NULL;
    uint64_t inside = vaddr - segment->vaddr, room = segment->file_size - inside;
    const char *text = (const char *)pe->image->bytes + segment->file_offset + inside;
    size_t length = strnlen(text, room < IMAGE_MAX_NAME + 1 ? (size_t)room : IMAGE_MAX_NAME + 1);
    return length != 0 && length < room && length <= IMAGE_MAX_NAME ? text : NULL;
}

const char *pe_text(struct pe *pe, const char *text)
{
    const char *kept = image_text(pe->image, "%s", text);
    if (kept == NULL && pe->image->defect[0] == '\0')
        pe_out_of_memory(pe);
    return kept;
}

bool pe_add_reloc(struct pe *pe, const struct image_reloc *reloc)
{
    struct image *image = pe->image;
    if (image->reloc_count == IMAGE_MAX_RELOCS)
        return image_defect(image, "has more than %u relocations", IMAGE_MAX_RELOCS);
    if (!image_make_room(&image->relocs, image->reloc_count, sizeof *reloc))
        return pe_out_of_memory(pe);
    image->relocs[image->reloc_count++] = *reloc;
    return true;
}

bool pe_add_symbol(struct pe *pe, const struct image_symbol *symbol)
{
    struct image *image = pe->image;
    if (!image_make_room(&image->symbols, image->symbol_count, sizeof *symbol))
        return pe_out_of_memory(pe);
    image->symbols[image->symbol_count++] = *symbol;
    return true;
}

static void look_for_debug_lines(struct image *image)
{
    struct pe_section section;
    for (unsigned i = 0; pe_section_at(image, i, &section); i++) {
        if (strcmp(pe_section_name(image, &section), ".debug_line") == 0 &&
            section.virtual_size != 0 && section.raw_size != 0)
            image->has_debug_lines = true;
    }
}

/* The name of the .pdb file: in a CodeView record of the debug directory. A hint only. */
static void look_for_debug_file(const struct pe *pe)
{
    enum { ENTRY = 28, TYPE_CODEVIEW = 2, NAME = 24 };
    const struct pe_directory *directory = &pe->directory[PE_DEBUG];
    const uint8_t *entries = pe_bytes(pe, directory->vaddr, directory->size);
    for (uint32_t at = 0; entries != NULL && at + ENTRY <= directory->size; at += ENTRY) {
        const uint32_t size = pe_u32(entries + at + 16), place = pe_u32(entries + at + 24);
        const uint8_t *record = pe->image->bytes + place;
        if (pe_u32(entries + at + 12) == TYPE_CODEVIEW && place < pe->image->size &&
            size <= pe->image->size - place && size > NAME && memcmp(record, "RSDS", 4) == 0 &&
            record[NAME] != '\0' && memchr(record + NAME, '\0', size - NAME) != NULL)
            pe->image->debug_file = (const char *)record + NAME;
    }
}

int pe_read(struct image *image)
{
    struct pe pe = { .image = image };
    /* Imports have slots that a loader patches: they come before the relocations are sorted, and
     * TLS, which is found through relocated words, after. */
    if (pe_read_headers(&pe) && pe_read_sections(&pe) && pe_check_directories(&pe) &&
        pe_check_symbol_table(&pe) && pe_read_imports(&pe) && pe_read_delay_imports(&pe) &&
        pe_read_relocs(&pe) && pe_read_exports(&pe) && pe_read_tls(&pe) && pe_check_relocs(&pe) &&
        pe_read_symbols(&pe) && pe_read_lists(&pe)) {
        pe_read_unwind(&pe);
        look_for_debug_lines(image);
        look_for_debug_file(&pe);
    }
    return pe.error;
}
