/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_lies_pe.h - the lies that a PE file can tell, one each, and what is said about them. Those
 * of ELF files: image_lies.h.
 */
#ifndef TESTS_IMAGE_LIES_PE_H
#define TESTS_IMAGE_LIES_PE_H

#include <string.h>

#include "image_support_pe.h"

#define PUT(at, width, value)     pe_put(t, at, width, value)
#define PE_WORD(at, value)        pe_put_word(t, at, value)
#define DIRECTORY(i, vaddr, size) pe_put_directory(t, i, vaddr, size)
#define SECTION(i, field, value)  pe_put_section(t, i, field, value)
#define ENTRY(i)                  (PE_RELOCS_AT + 8 + 2 * (i))
#define TYPE                      (t->wide ? 0xa000u : 0x3000u)
/* Its first relocation is there, its second one out of the way. */
#define SECOND_BLOCK(page, offset)                                                                 \
    (PUT(PE_SECOND_BLOCK_AT, 4, page), PUT(PE_SECOND_BLOCK_AT + 8, 2, TYPE | (offset)),            \
     PUT(PE_SECOND_BLOCK_AT + 10, 2, 0))
#define RAW_SIZE     16
#define RAW_OFFSET   20
#define VADDR        12
#define VIRTUAL_SIZE 8

/* LIE(name, change of struct tiny_pe *t, part of the sentence): each is told in both widths. */
#define PE_LIES                                                                                    \
    LIE(no_pe, PUT(PE_SIGNATURE, 4, 0x4550 + 0x10000), "holds no PE header")                       \
    LIE(lfanew_wraps, PUT(PE_LFANEW, 4, UINT32_MAX), "holds no PE header")                         \
    LIE(lfanew_early, PUT(PE_LFANEW, 4, 4), "holds no PE header")                                  \
    LIE(machine_arm, PUT(PE_MACHINE, 2, 0x1c4), "a PE file for Arm (Machine 0x01c4)")              \
    LIE(machine_aarch64, PUT(PE_MACHINE, 2, 0xaa64), "for AArch64 (Machine 0xaa64)")               \
    LIE(machine_unheard, PUT(PE_MACHINE, 2, 4711), "for unknown machine (Machine 0x1267)")         \
    LIE(machine_other, PUT(PE_MACHINE, 2, t->wide ? 0x14c : 0x8664),                               \
        "optional header starts with")                                                             \
    LIE(rom, PUT(PE_MAGIC, 2, 0x107), "optional header starts with 0x0107 (Magic)")                \
    LIE(not_linked, PUT(PE_CHARACTERISTICS, 2, 0x2000), "lack IMAGE_FILE_EXECUTABLE_IMAGE")        \
    LIE(program, PUT(PE_CHARACTERISTICS, 2, 0x22), "a program, not a module")                      \
    LIE(no_section, PUT(PE_NUMBER_OF_SECTIONS, 2, 0), "NumberOfSections is 0, allowed are 1 to")   \
    LIE(many_sections, PUT(PE_NUMBER_OF_SECTIONS, 2, 97), "NumberOfSections is 97, allowed are")   \
    LIE(sections_past_headers, PUT(PE_NUMBER_OF_SECTIONS, 2, 9), "SizeOfHeaders is 0x200")         \
    LIE(optional_short, PUT(PE_SIZE_OF_OPTIONAL, 2, 80), "SizeOfOptionalHeader is 80")             \
    LIE(optional_long, PUT(PE_SIZE_OF_OPTIONAL, 2, 0xffff), "SizeOfOptionalHeader is 65535")       \
    LIE(optional_odd, PUT(PE_SIZE_OF_OPTIONAL, 2, 248), "NumberOfRvaAndSizes 16; allowed are up")  \
    LIE(directories_few, PUT(t->directories - 4, 4, 15), "with NumberOfRvaAndSizes 15")            \
    LIE(directories_many, PUT(t->directories - 4, 4, UINT32_MAX),                                  \
        "NumberOfRvaAndSizes 4294967295")                                                          \
    LIE(file_alignment_0, PUT(PE_FILE_ALIGNMENT, 4, 0), "FileAlignment is 0x0")                    \
    LIE(file_alignment_odd, PUT(PE_FILE_ALIGNMENT, 4, 0x300), "FileAlignment is 0x300")            \
    LIE(file_alignment_small, PUT(PE_FILE_ALIGNMENT, 4, 0x100), "FileAlignment is 0x100")          \
    LIE(file_alignment_large, PUT(PE_FILE_ALIGNMENT, 4, 0x20000), "FileAlignment is 0x20000")      \
    LIE(alignment_small, PUT(PE_SECTION_ALIGNMENT, 4, 0x200), "SectionAlignment is 0x200")         \
    LIE(alignment_odd, PUT(PE_SECTION_ALIGNMENT, 4, 0x1800), "SectionAlignment is 0x1800")         \
    LIE(alignment_huge, PUT(PE_SECTION_ALIGNMENT, 4, 0x80000000),                                  \
        "SectionAlignment is 0x80000000")                                                          \
    LIE(alignment_other, PUT(PE_SECTION_ALIGNMENT, 4, 0x2000), "SizeOfImage is 0x5000, allowed")   \
    LIE(image_size_0, PUT(PE_SIZE_OF_IMAGE, 4, 0), "SizeOfImage is 0x0")                           \
    LIE(image_size_huge, PUT(PE_SIZE_OF_IMAGE, 4, 0xfffff000), "SizeOfImage is 0xfffff000")        \
    LIE(image_size_more, PUT(PE_SIZE_OF_IMAGE, 4, 0x6000), "the last section ends at 0x5000")      \
    LIE(image_size_less, PUT(PE_SIZE_OF_IMAGE, 4, 0x4000), "runs past SizeOfImage 0x4000")         \
    LIE(headers_0, PUT(PE_SIZE_OF_HEADERS, 4, 0), "SizeOfHeaders is 0x0")                          \
    LIE(headers_odd, PUT(PE_SIZE_OF_HEADERS, 4, 0x201), "SizeOfHeaders is 0x201")                  \
    LIE(headers_large, PUT(PE_SIZE_OF_HEADERS, 4, 0x80000000), "SizeOfHeaders is 0x80000000")      \
    LIE(base_odd, PUT(t->wide ? 0x70 : 0x74, 4, 0x1000), "ImageBase is 0x1000")                    \
    LIE(base_wraps,                                                                                \
        (PUT(PE_SIZE_OF_IMAGE, 4, 0x20000), PE_WORD(t->wide ? 0x70 : 0x74, 0xffffffffffff0000)),   \
        "ImageBase is 0x")                                                                         \
    LIE(entry_nowhere, PUT(PE_ENTRY_POINT, 4, 0x1100), "AddressOfEntryPoint 0x1100 lies in no")    \
    LIE(entry_wraps, PUT(PE_ENTRY_POINT, 4, UINT32_MAX), "AddressOfEntryPoint 0xffffffff")         \
    LIE(section_gap, SECTION(1, VADDR, 0x3000), "section 1 (.rdata): VirtualAddress is 0x3000")    \
    LIE(section_overlap, SECTION(1, VADDR, 0x1000), "VirtualAddress is 0x1000, allowed is 0x2000") \
    LIE(section_first, SECTION(0, VADDR, 0), "section 0 (.text): VirtualAddress is 0x0")           \
    LIE(section_empty, SECTION(2, VIRTUAL_SIZE, 0), "section 2 (.data): VirtualSize is 0")         \
    LIE(section_huge, SECTION(0, VIRTUAL_SIZE, UINT32_MAX), "runs past SizeOfImage")               \
    LIE(section_nowhere, SECTION(0, RAW_OFFSET, 0), "PointerToRawData says there is nothing")      \
    LIE(section_raw_odd, SECTION(0, RAW_OFFSET, 0x201), "PointerToRawData 0x201")                  \
    LIE(section_size_odd, SECTION(0, RAW_SIZE, 0x201), "SizeOfRawData 0x201, allowed are")         \
    LIE(section_outside, SECTION(3, RAW_SIZE, 0x400), "lies outside the file of 3184 bytes")       \
    LIE(section_wraps, SECTION(3, RAW_OFFSET, 0xfffffe00), "PointerToRawData 0xfffffe00")          \
    LIE(section_shared, SECTION(2, 36, 0xd0000040), "section 2 (.data) is shared between")         \
    LIE(coff_outside, PUT(PE_POINTER_TO_SYMBOLS, 4, TINY_PE_SIZE), "COFF symbols")                 \
    LIE(coff_wraps, PUT(PE_POINTER_TO_SYMBOLS, 4, UINT32_MAX), "COFF symbols")                     \
    LIE(coff_many, PUT(PE_NUMBER_OF_SYMBOLS, 4, UINT32_MAX), "COFF symbols")                       \
    LIE(coff_strings, PUT(PE_COFF_STRINGS_AT, 4, 0x100), "and their names lie outside the file")   \
    LIE(managed, DIRECTORY(14, 0x2000, 72), "has a CLR header (0x2000, 0x48 bytes): managed code") \
    LIE(bound, DIRECTORY(11, 0x200, 16), "has a bound import directory")                           \
    LIE(architecture, DIRECTORY(7, 0x2000, 16), "has a architecture directory")                    \
    LIE(global_pointer, DIRECTORY(8, 0x2000, 0), "has a global pointer")                           \
    LIE(reserved, DIRECTORY(15, 0, 1), "has a last data directory")                                \
    LIE(export_size, DIRECTORY(0, 0x2000, 0), "export directory: address 0x2000, size 0x0")        \
    LIE(import_place, DIRECTORY(1, 0, 40), "import directory: address 0x0, size 0x28")             \
    LIE(resource_outside, DIRECTORY(2, 0x5000, 16), "resource directory (0x5000, 0x10 bytes)")     \
    LIE(exception_leaves, DIRECTORY(3, 0x2000, 0x401), "exception directory (0x2000, 0x401")       \
    LIE(exception_wraps, DIRECTORY(3, 0x2000, UINT32_MAX), "exception directory")                  \
    LIE(certificate_outside, DIRECTORY(4, PE_CERTIFICATE_AT, 17), "lies outside the file")         \
    LIE(certificate_wraps, DIRECTORY(4, UINT32_MAX, UINT32_MAX), "lies outside the file")          \
    LIE(config_size, PUT(PE_CONFIG_AT, 4, 0x1000), "load configuration directory at 0x2280")       \
    LIE(config_in_bss, DIRECTORY(10, 0x3200, 0x40), "load configuration directory at 0x3200")      \
    LIE(exports_small, DIRECTORY(0, 0x2000, 39), "its 40 bytes do not lie")                        \
    LIE(exports_in_bss, DIRECTORY(0, 0x3200, 40), "its 40 bytes do not lie")                       \
    LIE(export_base, PUT(PE_EXPORTS_AT + 16, 4, 65532), "ordinals end at 65535")                   \
    LIE(export_base_wraps, PUT(PE_EXPORTS_AT + 16, 4, UINT32_MAX), "ordinals end at 65535")        \
    LIE(export_many, PUT(PE_EXPORTS_AT + 20, 4, UINT32_MAX), "NumberOfFunctions 4294967295")       \
    LIE(export_names_many, PUT(PE_EXPORTS_AT + 24, 4, UINT32_MAX), "NumberOfNames is 4294967295")  \
    LIE(export_functions, PUT(PE_EXPORTS_AT + 28, 4, 0x23f0), "AddressOfFunctions (0x23f0, 5 ent") \
    LIE(export_names, PUT(PE_EXPORTS_AT + 32, 4, UINT32_MAX), "AddressOfNames (0xffffffff, 3 ent") \
    LIE(export_ordinals, PUT(PE_EXPORTS_AT + 36, 4, 0x3200), "AddressOfNameOrdinals (0x3200, 3")   \
    LIE(export_name_nowhere, PUT(PE_NAMES_AT, 4, 0x6000), "export name 0 at 0x6000 is empty")      \
    LIE(export_name_empty, PUT(PE_NAMES_AT, 4, 0x206b), "export name 0 at 0x206b is empty")        \
    LIE(export_name_number, memcpy(t->bytes + PE_STRINGS_AT + 0x10, "#8", 3), "reads as an ord")   \
    LIE(export_unsorted, t->bytes[PE_STRINGS_AT + 0x10] = 'Z', "not sorted: Zrogram_01 comes")     \
    LIE(export_twice, PUT(PE_NAMES_AT + 4, 4, PE_VADDR(PE_STRINGS_AT + 0x10)),                     \
        "exports Program_01 twice")                                                                \
    LIE(export_ordinal, PUT(PE_ORDINALS_AT, 2, 5), "exports Program_01 as function 5 of 5")        \
    LIE(export_hole, PUT(PE_ORDINALS_AT, 2, 4), "exports Program_01 at 0x0, which lies in no")     \
    LIE(export_nowhere, PUT(PE_FUNCTIONS_AT, 4, 0x1100), "exports Program_Ini at 0x1100")          \
    LIE(export_unnamed, PUT(PE_FUNCTIONS_AT + 12, 4, 0x9000), "exports #8 at 0x9000")              \
    LIE(forwarder_plain, t->bytes[PE_STRINGS_AT + 0x35] = '_', "exports away as a forwarder at")   \
    LIE(forwarder_no_library, PUT(PE_FUNCTIONS_AT + 8, 4, PE_VADDR(PE_STRINGS_AT + 0x35)),         \
        "which is no LIBRARY.Name")                                                                \
    LIE(forwarder_no_name, t->bytes[PE_STRINGS_AT + 0x36] = 0, "which is no LIBRARY.Name")         \
    LIE(forwarder_leaves, DIRECTORY(0, 0x2000, 0x94), "which is no LIBRARY.Name inside")           \
    LIE(forwarder_table, PUT(PE_FUNCTIONS_AT, 4, 0x2000), "exports Program_Ini as a forwarder")    \
    LIE(import_no_end, DIRECTORY(1, PE_VADDR(PE_IMPORTS_AT), 39),                                  \
        "import directory (0x2100, 0x27")                                                          \
    LIE(import_endless, memcpy(t->bytes + PE_IMPORTS_AT + 20, t->bytes + PE_IMPORTS_AT, 20),       \
        "import directory (0x2100, 0x28 bytes) has no end mark")                                   \
    LIE(import_half, PUT(PE_IMPORTS_AT + 12, 4, 0), "some loaders take that for the end")          \
    LIE(import_no_slots, PUT(PE_IMPORTS_AT + 16, 4, 0), "some loaders take that for the end")      \
    LIE(import_bound, PUT(PE_IMPORTS_AT + 4, 4, UINT32_MAX), "library 0 is bound (TimeDateStamp")  \
    LIE(import_library, PUT(PE_IMPORTS_AT + 12, 4, UINT32_MAX), "the name of library 0 at 0xfff")  \
    LIE(import_names, PUT(PE_IMPORTS_AT, 4, 0x3200), "the name table at 0x3200 has no end")        \
    LIE(import_names_wrap, PUT(PE_IMPORTS_AT, 4, UINT32_MAX), "the name table at 0xffffffff has")  \
    LIE(import_slots, PUT(PE_IMPORTS_AT + 16, 4, 0x6000), "the slot at 0x6000 lies in no section") \
    LIE(import_slots_in_bss, PUT(PE_IMPORTS_AT + 16, 4, 0x3200), "asks for something else than")   \
    LIE(import_slot, PE_WORD(PE_SLOTS_AT, 0x2170), "the slot at 0x3000 asks for something else")   \
    LIE(import_name, (PE_WORD(PE_LOOKUP_AT, 0x6000), PE_WORD(PE_SLOTS_AT, 0x6000)),                \
        "import from KERNEL32.dll: the word 0x6000 at 0x2140 is neither")                          \
    LIE(import_ordinal, (PE_WORD(PE_LOOKUP_AT, BAD_ORDINAL), PE_WORD(PE_SLOTS_AT, BAD_ORDINAL)),   \
        "is neither an ordinal nor the address of a name")                                         \
    LIE(import_slot_moved, PUT(ENTRY(6 + 4), 2, TYPE | 0), "two relocations patch the same bytes") \
    LIE(delay_old, PUT(PE_DELAY_AT, 4, 0), "library 0 has Attributes 0x0, allowed is 1")           \
    LIE(delay_no_end, DIRECTORY(13, PE_VADDR(PE_DELAY_AT), 63), "delay import directory (0x2180")  \
    LIE(delay_library, PUT(PE_DELAY_AT + 4, 4, 0), "the name of library 0 at 0x0")                 \
    LIE(delay_names, PUT(PE_DELAY_AT + 16, 4, 0x7000), "import from LATE.dll: the name table")     \
    LIE(delay_slots, PUT(PE_DELAY_AT + 12, 4, 0x7000), "import from LATE.dll: the slot at 0x7000") \
    LIE(reloc_in_bss, DIRECTORY(5, 0x3200, 12), "base relocation directory (0x3200, 0xc bytes)")   \
    LIE(reloc_stripped, PUT(PE_CHARACTERISTICS, 2, 0x2023), "and IMAGE_FILE_RELOCS_STRIPPED")      \
    LIE(reloc_block_0, PUT(PE_RELOCS_AT + 4, 4, 0), "has 0x0 bytes (SizeOfBlock)")                 \
    LIE(reloc_block_small, PUT(PE_RELOCS_AT + 4, 4, 4), "has 0x4 bytes (SizeOfBlock)")             \
    LIE(reloc_block_odd, PUT(PE_RELOCS_AT + 4, 4, 18), "has 0x12 bytes (SizeOfBlock)")             \
    LIE(reloc_block_large, PUT(PE_RELOCS_AT + 4, 4, 40), "to the 0x24 that are left")              \
    LIE(reloc_left_over, DIRECTORY(5, 0x4000, 0x20), "to the 0xc that are left")                   \
    LIE(reloc_page, PUT(PE_RELOCS_AT, 4, 0x2004), "relocation block for 0x2004 (VirtualAddress)")  \
    LIE(reloc_outside, PUT(PE_SECOND_BLOCK_AT, 4, 0x7000), "patches 0x7020, which lies in no")     \
    LIE(reloc_wraps, PUT(PE_SECOND_BLOCK_AT, 4, 0xfffff000), "patches 0xfffff020")                 \
    LIE(reloc_edge, PUT(ENTRY(0), 2, TYPE | 0x3fd), "patches 0x23fd, which lies in no section")    \
    LIE(reloc_twice, PUT(ENTRY(1), 2, TYPE | 0x200), "two relocations patch the same bytes")       \
    LIE(reloc_overlap, PUT(ENTRY(1), 2, TYPE | 0x201), "two relocations patch the same bytes")     \
    LIE(reloc_cut, PUT(ENTRY(5), 2, 0x4240), "in the middle of an IMAGE_REL_BASED_HIGHADJ")        \
    LIE(reloc_of_exports, PUT(PE_SECOND_BLOCK_AT, 4, 0x2000), "0x2020, which is part of the exp")  \
    LIE(reloc_of_imports, SECOND_BLOCK(0x2000, 0x100), "0x2100, which is part of the import dir")  \
    LIE(reloc_of_delays, SECOND_BLOCK(0x2000, 0x1bc), "0x21bc, which is part of the delay imp")    \
    LIE(reloc_of_relocs, SECOND_BLOCK(0x4000, 0x01c), "0x401c, which is part of the base reloc")   \
    LIE(tls_small, DIRECTORY(9, PE_VADDR(PE_TLS_AT), 4 * t->word + 7), "TLS directory (0x2200")    \
    LIE(tls_in_bss, DIRECTORY(9, 0x3200, 40), "TLS directory (0x3200, 0x28 bytes)")                \
    LIE(tls_backwards, PE_WORD(PE_TLS_AT + t->word, TINY_PE_BASE + 0x3000),                        \
        "from 0x3040 to 0x3000")                                                                   \
    LIE(tls_nowhere, PE_WORD(PE_TLS_AT, 0), "the template from 0x")                                \
    LIE(tls_zeroes, PUT(PE_TLS_AT + 4 * t->word, 4, UINT32_MAX), "SizeOfZeroFill is 0xffffffff")   \
    LIE(tls_index, PE_WORD(PE_TLS_AT + 2 * t->word, TINY_PE_BASE + 0x32fd),                        \
        "TLS AddressOfIndex lies")                                                                 \
    LIE(tls_callbacks, PE_WORD(PE_TLS_AT + 3 * t->word, TINY_PE_BASE + 0x3200), "TLS callback at") \
    LIE(tls_callback, PE_WORD(PE_CALLBACKS_AT, TINY_PE_BASE + 0x9000), "TLS callback 0 at 0x9000") \
    LIE(tls_unpatched, PUT(ENTRY(4), 2, 0), "TLS callback at 0x2240 holds 0x20001060, right at")

#define BAD_ORDINAL ((uint64_t)1 << (8 * t->word - 1) | 0x10001)

#define LIE(name, change, text)                                                                    \
    static void pe_lie_##name(struct tiny_pe *t)                                                   \
    {                                                                                              \
        change;                                                                                    \
    }
PE_LIES
#undef LIE

static const struct {
    const char *name;
    void (*tell)(struct tiny_pe *t);
    const char *sentence;
} pe_lies[] = {
#define LIE(name, change, text) { #name, pe_lie_##name, text },
    PE_LIES
#undef LIE
};

#endif
