/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_sections.c - the section table: what is mapped where, and are the data directories in it?
 */
#include "image/pe.h"

#include <stdlib.h>
#include <string.h>

typedef unsigned long long ull;

enum {
    SECTION_SHARED = 0x10000000,
    SECTION_EXECUTE = 0x20000000,
    SECTION_READ = 0x40000000,
};
#define SECTION_WRITE 0x80000000u

bool pe_section_at(const struct image *image, unsigned index, struct pe_section *section)
{
    const uint8_t *coff = image->bytes + pe_u32(image->bytes + 0x3c);
    if (index >= pe_u16(coff + 6))
        return false;
    const uint8_t *at =
        coff + PE_COFF_HEADER + pe_u16(coff + 20) + (size_t)PE_SECTION_HEADER * index;
    memcpy(section->name, at, 8);
    section->name[8] = '\0';
    section->virtual_size = pe_u32(at + 8);
    section->vaddr = pe_u32(at + 12);
    section->raw_size = pe_u32(at + 16);
    section->raw_offset = pe_u32(at + 20);
    section->characteristics = pe_u32(at + 36);
    return true;
}

const char *pe_section_name(const struct image *image, const struct pe_section *section)
{
    struct pe_strings strings;
    uint32_t count;
    if (section->name[0] != '/' || section->name[1] < '0' || section->name[1] > '9' ||
        pe_symbol_table(image, &count, &strings) == NULL)
        return section->name;
    const char *name = pe_coff_string(&strings, (uint32_t)strtoul(section->name + 1, NULL, 10));
    return name != NULL ? name : section->name;
}

static uint64_t align_up(uint64_t value, uint64_t alignment)
{
    return (value + alignment - 1) & ~(alignment - 1);
}

static unsigned permissions(uint32_t characteristics)
{
    return (characteristics & SECTION_READ ? IMAGE_READ : 0u) |
           (characteristics & SECTION_WRITE ? IMAGE_WRITE : 0u) |
           (characteristics & SECTION_EXECUTE ? IMAGE_EXEC : 0u);
}

static bool add_segment(struct pe *pe, const struct image_segment *segment)
{
    struct image *image = pe->image;
    if (!image_make_room(&image->segments, image->segment_count, sizeof *segment))
        return pe_out_of_memory(pe);
    image->segments[image->segment_count++] = *segment;
    return true;
}

static bool check_raw(struct pe *pe, unsigned index, const struct pe_section *section)
{
    struct image *image = pe->image;
    uint64_t end = (uint64_t)section->raw_offset + section->raw_size;
    if (section->raw_size == 0)
        return true;
    if (section->raw_offset == 0)
        return image_defect(
            image,
            "section %u (%s): SizeOfRawData is 0x%x, PointerToRawData says there is "
            "nothing",
            index, section->name, section->raw_size);
    if (section->raw_offset % pe->file_alignment != 0 ||
        section->raw_size % pe->file_alignment != 0)
        return image_defect(image,
                            "section %u (%s): PointerToRawData 0x%x, SizeOfRawData 0x%x, allowed "
                            "are multiples of FileAlignment 0x%x; loaders round differently",
                            index, section->name, section->raw_offset, section->raw_size,
                            pe->file_alignment);
    if (end > image->size)
        return image_defect(image,
                            "section %u (%s): PointerToRawData 0x%x + SizeOfRawData 0x%x lies "
                            "outside the file of %zu bytes: was it cut off?",
                            index, section->name, section->raw_offset, section->raw_size,
                            image->size);
    return true;
}

static bool check_section(struct pe *pe, unsigned index, const struct pe_section *section,
                          uint64_t expected)
{
    struct image *image = pe->image;
    if (section->vaddr != expected)
        return image_defect(image,
                            "section %u (%s): VirtualAddress is 0x%x, allowed is 0x%llx, where the "
                            "part before it ends",
                            index, section->name, section->vaddr, (ull)expected);
    if (section->virtual_size == 0)
        return image_defect(image,
                            "section %u (%s): VirtualSize is 0, SizeOfRawData 0x%x; loaders take "
                            "one or the other",
                            index, section->name, section->raw_size);
    if (section->virtual_size > pe->image_size - expected)
        return image_defect(image,
                            "section %u (%s): VirtualAddress 0x%x + VirtualSize 0x%x runs past "
                            "SizeOfImage 0x%x",
                            index, section->name, section->vaddr, section->virtual_size,
                            pe->image_size);
    if ((section->characteristics & SECTION_SHARED) != 0)
        return image_defect(image,
                            "section %u (%s) is shared between processes (Characteristics 0x%08x); "
                            "a module has one process and no such memory",
                            index, section->name, section->characteristics);
    return check_raw(pe, index, section);
}

bool pe_read_sections(struct pe *pe)
{
    struct image *image = pe->image;
    struct pe_section section;
    uint64_t next = align_up(pe->headers_size, pe->section_alignment);
    /* The headers are mapped, too, and directories may lie there. */
    if (!add_segment(pe, &(struct image_segment){ .mem_size = pe->headers_size,
                                                  .file_size = pe->headers_size,
                                                  .perm = IMAGE_READ }))
        return false;
    if (next > pe->image_size)
        return image_defect(image, "SizeOfHeaders 0x%x runs past SizeOfImage 0x%x",
                            pe->headers_size, pe->image_size);
    for (unsigned i = 0; pe_section_at(image, i, &section); i++) {
        if (section.virtual_size == 0 && section.raw_size == 0)
            continue;
        if (!check_section(pe, i, &section, next))
            return false;
        bool shorter = section.raw_size < section.virtual_size;
        if (!add_segment(pe, &(struct image_segment){
                                 .vaddr = section.vaddr,
                                 .mem_size = section.virtual_size,
                                 .file_size = shorter ? section.raw_size : section.virtual_size,
                                 .file_offset = section.raw_size != 0 ? section.raw_offset : 0,
                                 .perm = permissions(section.characteristics) }))
            return false;
        next = align_up(next + section.virtual_size, pe->section_alignment);
    }
    if (next != pe->image_size)
        return image_defect(image, "SizeOfImage is 0x%x, the last section ends at 0x%llx",
                            pe->image_size, (ull)next);
    image->span_end = next;
    if (image->has_entry_point && image_segment_at(image, image->entry_point, 1) == NULL)
        return image_defect(image, "AddressOfEntryPoint 0x%llx lies in no section",
                            (ull)image->entry_point);
    return true;
}

static bool check_load_config(struct pe *pe)
{
    const struct pe_directory *directory = &pe->directory[PE_LOAD_CONFIG];
    if (directory->size == 0)
        return true;
    const uint8_t *at = pe_bytes(pe, directory->vaddr, 4);
    if (at == NULL || image_segment_at(pe->image, directory->vaddr, pe_u32(at)) == NULL)
        return image_defect(pe->image,
                            "load configuration directory at 0x%x: its Size field is outside the "
                            "file or reaches past its section",
                            directory->vaddr);
    return true;
}

bool pe_check_directories(struct pe *pe)
{
    struct image *image = pe->image;
    for (unsigned i = 0; i < PE_DIRECTORIES; i++) {
        const struct pe_directory *directory = &pe->directory[i];
        uint64_t end = (uint64_t)directory->vaddr + directory->size;
        if (directory->size == 0)
            continue;
        /* The certificates' address is an offset in the file. */
        if (i == PE_CERTIFICATE
                ? end > image->size
                : image_segment_at(image, directory->vaddr, directory->size) == NULL)
            return image_defect(image, "%s (0x%x, 0x%x bytes) lies outside the %s",
                                pe_directory_name(i), directory->vaddr, directory->size,
                                i == PE_CERTIFICATE ? "file" : "sections");
    }
    return check_load_config(pe);
}
