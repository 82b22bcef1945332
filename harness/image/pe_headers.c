/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * pe_headers.c - is this PE file a module, and do its headers lie in the file?
 */
#include "image/pe.h"

#include <string.h>

typedef unsigned long long ull;

enum {
    FILE_RELOCS_STRIPPED = 0x0001,
    FILE_EXECUTABLE_IMAGE = 0x0002,
    FILE_DLL = 0x2000,
    DLL_NX_COMPAT = 0x0100,
    MAGIC_PE32 = 0x010b,
    MAGIC_PE32_PLUS = 0x020b,
};

static const struct {
    uint16_t machine;
    enum image_target target;
    const char *name;
    uint16_t magic; /* of the optional header; 0: no module runs there */
} machines[] = {
    { 0x8664, IMAGE_TARGET_X86_64, "x86-64", MAGIC_PE32_PLUS },
    { 0x014c, IMAGE_TARGET_I386, "i386", MAGIC_PE32 },
    { 0x01c0, IMAGE_TARGET_ARM, "Arm", 0 },
    { 0x01c2, IMAGE_TARGET_ARM, "Arm", 0 },
    { 0x01c4, IMAGE_TARGET_ARM, "Arm", 0 },
    { 0xaa64, IMAGE_TARGET_NONE, "AArch64", 0 },
    { 0x0200, IMAGE_TARGET_NONE, "Itanium", 0 },
    { 0x5064, IMAGE_TARGET_NONE, "RISC-V", 0 },
    { 0x0ebc, IMAGE_TARGET_NONE, "EFI byte code", 0 },
};

static const struct {
    const char *name;
    const char *refused; /* why a module cannot have it; NULL when it can */
} directories[PE_DIRECTORIES] = {
    [PE_EXPORT] = { "export directory", NULL },
    [PE_IMPORT] = { "import directory", NULL },
    [PE_RESOURCE] = { "resource directory", NULL },
    [PE_EXCEPTION] = { "exception directory", NULL },
    [PE_CERTIFICATE] = { "certificate table", NULL },
    [PE_RELOC] = { "base relocation directory", NULL },
    [PE_DEBUG] = { "debug directory", NULL },
    [PE_ARCHITECTURE] = { "architecture directory", "it is reserved" },
    [PE_GLOBAL_POINTER] = { "global pointer", "these processors have none" },
    [PE_TLS] = { "TLS directory", NULL },
    [PE_LOAD_CONFIG] = { "load configuration directory", NULL },
    [PE_BOUND_IMPORT] = { "bound import directory",
                          "it holds addresses of another computer's libraries" },
    [PE_IAT] = { "import address table", NULL },
    [PE_DELAY_IMPORT] = { "delay import directory", NULL },
    [PE_CLR] = { "CLR header", "managed code (.NET) needs a runtime that no controller has" },
    [PE_RESERVED] = { "last data directory", "it is reserved" },
};

const char *pe_directory_name(enum pe_directory_index index)
{
    return directories[index].name;
}

/* Where "PE\0\0" stands. */
static bool find_headers(struct image *image, uint32_t *offset)
{
    *offset = image->size >= 0x40 ? pe_u32(image->bytes + 0x3c) : 0;
    if (*offset < 0x40 || image->size < PE_COFF_HEADER || *offset > image->size - PE_COFF_HEADER ||
        memcmp(image->bytes + *offset, "PE\0\0", 4) != 0)
        return image_defect(image, "starts with \"MZ\" but holds no PE header: not a module");
    return true;
}

/* Names the machine; *magic is what the optional header has to begin with. */
static bool check_machine(struct image *image, const uint8_t *coff, uint16_t *magic)
{
    uint16_t machine = pe_u16(coff + 4);
    image->format = IMAGE_FORMAT_PE;
    image->format_name = "PE";
    image->target_name = "unknown machine";
    *magic = 0;
    for (size_t i = 0; i < sizeof machines / sizeof machines[0]; i++) {
        if (machines[i].machine == machine) {
            image->target = machines[i].target;
            image->target_name = machines[i].name;
            *magic = machines[i].magic;
        }
    }
    if (*magic == 0)
        return image_defect(image,
                            "a PE file for %s (Machine 0x%04x); a module is for x86-64 (0x8664) or "
                            "i386 (0x014c)",
                            image->target_name, machine);
    return true;
}

static bool check_coff(struct pe *pe, uint32_t offset, const uint8_t *coff)
{
    struct image *image = pe->image;
    unsigned sections = pe_u16(coff + 6), characteristics = pe_u16(coff + 22);
    if (offset % 4 != 0)
        return image_defect(image, "PE header at 0x%x (e_lfanew), allowed is a multiple of 4",
                            offset);
    if ((characteristics & FILE_EXECUTABLE_IMAGE) == 0)
        return image_defect(image,
                            "Characteristics 0x%04x lack IMAGE_FILE_EXECUTABLE_IMAGE: the link did "
                            "not succeed",
                            characteristics);
    if ((characteristics & FILE_DLL) == 0)
        return image_defect(image,
                            "a program, not a module (Characteristics 0x%04x lack IMAGE_FILE_DLL): "
                            "link it as a DLL",
                            characteristics);
    if (sections == 0 || sections > PE_MAX_SECTIONS)
        return image_defect(image, "NumberOfSections is %u, allowed are 1 to %u", sections,
                            PE_MAX_SECTIONS);
    pe->relocs_stripped = (characteristics & FILE_RELOCS_STRIPPED) != 0;
    return true;
}

/* The optional header: its own size, the number of directories and what is there have to agree, or
 * one loader finds the section table where another sees directories. */
static bool check_optional_size(struct pe *pe, const uint8_t *optional, uint64_t room,
                                unsigned size, uint16_t magic)
{
    struct image *image = pe->image;
    unsigned fixed = magic == MAGIC_PE32_PLUS ? 112 : 96;
    if (room < size || size < fixed)
        return image_defect(image,
                            "SizeOfOptionalHeader is %u: the file has room for %llu, the header "
                            "takes %u",
                            size, (ull)room, fixed);
    if (pe_u16(optional) != magic)
        return image_defect(image,
                            "optional header starts with 0x%04x (Magic), allowed for %s is 0x%04x",
                            pe_u16(optional), image->target_name, magic);
    uint32_t count = pe_u32(optional + fixed - 4);
    if (count > PE_DIRECTORIES || size != fixed + 8 * count)
        return image_defect(image,
                            "SizeOfOptionalHeader is %u with NumberOfRvaAndSizes %u; allowed are "
                            "up to 16 directories in %u + 8 each",
                            size, count, fixed);
    return true;
}

static bool is_power_of_two(uint64_t value)
{
    return value != 0 && (value & (value - 1)) == 0;
}

static bool check_layout(struct pe *pe)
{
    struct image *image = pe->image;
    if (!is_power_of_two(pe->file_alignment) || pe->file_alignment < 512 ||
        pe->file_alignment > 65536)
        return image_defect(
            image, "FileAlignment is 0x%x, allowed is a power of two from 0x200 to 0x10000",
            pe->file_alignment);
    if (!is_power_of_two(pe->section_alignment) || pe->section_alignment < IMAGE_PAGE ||
        pe->section_alignment < pe->file_alignment || pe->section_alignment > IMAGE_MAX_SPAN)
        return image_defect(image,
                            "SectionAlignment is 0x%x, allowed is a power of two from 0x1000 on, "
                            "not below FileAlignment 0x%x",
                            pe->section_alignment, pe->file_alignment);
    if (pe->image_size == 0 || pe->image_size > IMAGE_MAX_SPAN ||
        pe->image_size % pe->section_alignment != 0)
        return image_defect(image,
                            "SizeOfImage is 0x%x, allowed is a multiple of SectionAlignment 0x%x "
                            "up to 256 MiB",
                            pe->image_size, pe->section_alignment);
    if (pe->headers_size > image->size || pe->headers_size % pe->file_alignment != 0)
        return image_defect(image,
                            "SizeOfHeaders is 0x%x, allowed is a multiple of FileAlignment 0x%x "
                            "inside the file of %zu bytes",
                            pe->headers_size, pe->file_alignment, image->size);
    uint64_t top = pe->word == 4 ? UINT32_MAX : UINT64_MAX;
    if (image->base % 65536 != 0 || image->base > top - pe->image_size)
        return image_defect(image,
                            "ImageBase is 0x%llx, allowed is a multiple of 0x10000 with room for "
                            "SizeOfImage 0x%x",
                            (ull)image->base, pe->image_size);
    return true;
}

static bool read_directories(struct pe *pe, const uint8_t *at, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        struct pe_directory *directory = &pe->directory[i];
        directory->vaddr = pe_u32(at + 8 * i);
        directory->size = pe_u32(at + 8 * i + 4);
        bool present = directory->vaddr != 0 || directory->size != 0;
        if (present && directories[i].refused != NULL)
            return image_defect(pe->image, "has a %s (0x%x, 0x%x bytes): %s", directories[i].name,
                                directory->vaddr, directory->size, directories[i].refused);
        if (present && (directory->vaddr == 0 || directory->size == 0))
            return image_defect(pe->image,
                                "%s: address 0x%x, size 0x%x; allowed is to have both or none",
                                directories[i].name, directory->vaddr, directory->size);
    }
    return true;
}

/* In both kinds most fields stand at the same offset. */
static bool read_optional(struct pe *pe, const uint8_t *optional)
{
    struct image *image = pe->image;
    unsigned fixed = pe->word == 8 ? 112 : 96;
    uint32_t entry = pe_u32(optional + 16);
    image->base = pe->word == 8 ? pe_word(pe, optional + 24) : pe_u32(optional + 28);
    pe->section_alignment = pe_u32(optional + 32);
    pe->file_alignment = pe_u32(optional + 36);
    pe->image_size = pe_u32(optional + 56);
    pe->headers_size = pe_u32(optional + 60);
    image->has_entry_point = entry != 0;
    image->entry_point = entry;
    image->exec_stack_stated = true;
    image->exec_stack = (pe_u16(optional + 70) & DLL_NX_COMPAT) == 0;
    image->align = pe->section_alignment;
    image->fixed = pe->relocs_stripped;
    return check_layout(pe) && read_directories(pe, optional + fixed, pe_u32(optional + fixed - 4));
}

bool pe_read_headers(struct pe *pe)
{
    struct image *image = pe->image;
    uint32_t offset;
    uint16_t magic;
    if (!find_headers(image, &offset))
        return false;
    const uint8_t *coff = image->bytes + offset;
    unsigned optional_size = pe_u16(coff + 20);
    uint64_t room = image->size - offset - PE_COFF_HEADER;
    if (!check_machine(image, coff, &magic) || !check_coff(pe, offset, coff) ||
        !check_optional_size(pe, coff + PE_COFF_HEADER, room, optional_size, magic))
        return false;
    pe->word = magic == MAGIC_PE32_PLUS ? 8 : 4;
    if (!read_optional(pe, coff + PE_COFF_HEADER))
        return false;
    uint64_t end = (uint64_t)offset + PE_COFF_HEADER + optional_size +
                   (uint64_t)PE_SECTION_HEADER * pe_u16(coff + 6);
    if (end > pe->headers_size)
        return image_defect(image, "headers and section table end at 0x%llx, SizeOfHeaders is 0x%x",
                            (ull)end, pe->headers_size);
    return true;
}
