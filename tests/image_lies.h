/* SPDX-License-Identifier: GPL-2.0-or-later */
/* image_lies.h - the lies that an ELF file can tell, one each, and what is said about them. */
#ifndef TESTS_IMAGE_LIES_H
#define TESTS_IMAGE_LIES_H

#include <string.h>

#include "image_support.h"

#define WORD(i)  TINY_ADDRESS(words[i])
#define DYN(tag) (tiny_dyn(t, tag)->d_un.d_val)

/* LIE(name, change of struct tiny *t, part of the sentence) */
#define ELF_LIES                                                                                   \
    LIE(class_32, t->eh.e_ident[EI_CLASS] = 1, "a 32-bit little-endian ELF file for x86-64")       \
    LIE(class_0, t->eh.e_ident[EI_CLASS] = 0, "ELF class (EI_CLASS) is 0, allowed are 1")          \
    LIE(order_big, (t->eh.e_ident[EI_DATA] = 2, t->eh.e_machine = EM_X86_64 << 8),                 \
        "a 64-bit big-endian ELF file for x86-64")                                                 \
    LIE(order_3, t->eh.e_ident[EI_DATA] = 3, "(EI_DATA) is 3")                                     \
    LIE(ident_version, t->eh.e_ident[EI_VERSION] = 0, "(EI_VERSION) is 0, allowed is 1")           \
    LIE(abi, t->eh.e_ident[EI_OSABI] = ELFOSABI_FREEBSD, "(EI_OSABI) is 9, allowed are 0")         \
    LIE(abi_version, t->eh.e_ident[EI_ABIVERSION] = 1, "(EI_ABIVERSION) is 1")                     \
    LIE(machine_arm, t->eh.e_machine = EM_ARM, "for Arm (e_machine 40)")                           \
    LIE(machine_aarch64, t->eh.e_machine = EM_AARCH64, "for AArch64 (e_machine 183)")              \
    LIE(machine_riscv, t->eh.e_machine = EM_RISCV, "for RISC-V (e_machine 243)")                   \
    LIE(machine_i386, t->eh.e_machine = EM_386, "for i386 (e_machine 3)")                          \
    LIE(machine_unheard, t->eh.e_machine = 4711, "for unknown machine (e_machine 4711)")           \
    LIE(type_none, t->eh.e_type = ET_NONE, "e_type 0")                                             \
    LIE(type_rel, t->eh.e_type = ET_REL, "an object file, not a module: compile and link it")      \
    LIE(type_exec, t->eh.e_type = ET_EXEC, "an executable, not a module")                          \
    LIE(type_core, t->eh.e_type = ET_CORE, "a core dump")                                          \
    LIE(type_os, t->eh.e_type = 0xfe00, "(e_type) is 0xfe00")                                      \
    LIE(version, t->eh.e_version = 2, "(e_version) is 2, allowed is 1")                            \
    LIE(header_size, t->eh.e_ehsize = 65, "(e_ehsize) is 65, allowed is 64")                       \
    LIE(no_segments, t->eh.e_phnum = 0, "has no program headers")                                  \
    LIE(segments_nowhere, t->eh.e_phoff = 0, "has no program headers")                             \
    LIE(many_segments, t->eh.e_phnum = PN_XNUM, "e_phnum is 65535")                                \
    LIE(segment_size, t->eh.e_phentsize = 32, "(e_phentsize) is 32, allowed is 56")                \
    LIE(segments_outside, t->eh.e_phoff = sizeof *t - 100, "program header table (e_phoff")        \
    LIE(segments_wrap, t->eh.e_phoff = UINT64_MAX - 8, "program header table (e_phoff")            \
    LIE(segments_too_many, t->eh.e_phnum = 1000, "program header table (e_phoff")                  \
    LIE(sections_without_table, t->eh.e_shoff = 0, "e_shoff says there is no table")               \
    LIE(table_without_sections, t->eh.e_shnum = 0, "but e_shnum is 0")                             \
    LIE(sections_too_many, t->eh.e_shnum = SHN_LORESERVE, "e_shnum is 65280")                      \
    LIE(section_size, t->eh.e_shentsize = 0, "(e_shentsize) is 0, allowed is 64")                  \
    LIE(sections_outside, t->eh.e_shoff += 1, "section header table (e_shoff")                     \
    LIE(sections_wrap, t->eh.e_shoff = UINT64_MAX, "section header table (e_shoff")                \
    LIE(load_outside, t->ph[TINY_RX].p_offset = 0x101000, "program header 1: p_offset 0x101000")   \
    LIE(load_offset_wraps, t->ph[TINY_RX].p_offset = UINT64_MAX, "program header 1: p_offset")     \
    LIE(load_size_wraps, t->ph[TINY_RX].p_filesz = UINT64_MAX, "program header 1: p_offset")       \
    LIE(load_shrinks, t->ph[TINY_RX].p_memsz = 4, "p_filesz 0x80 is larger than p_memsz 0x4")      \
    LIE(load_address_wraps, t->ph[TINY_RW].p_vaddr = UINT64_MAX - 0x1000, "end of the address sp") \
    LIE(load_memory_wraps, t->ph[TINY_RW].p_memsz = UINT64_MAX, "end of the address space")        \
    LIE(load_huge, t->ph[TINY_RW].p_memsz = 0x10000000, "allowed are 256 MiB")                     \
    LIE(load_far, t->ph[TINY_RW].p_vaddr += 0x40000000, "allowed are 256 MiB")                     \
    LIE(load_align_odd, t->ph[TINY_RX].p_align = 24, "p_align 0x18 is not a power of two")         \
    LIE(load_align_huge, t->ph[TINY_R].p_align = 1ull << 40, "allowed is up to 0x10000000")        \
    LIE(load_align_differs, t->ph[TINY_RX].p_vaddr += 8, "differ modulo p_align 0x1000")           \
    LIE(load_descends, t->ph[TINY_RW].p_vaddr -= 0x2000, "segments have to ascend")                \
    LIE(load_overlaps, t->ph[TINY_R].p_memsz = 0x1800, "overlaps the segment before it")           \
    LIE(load_shares_page,                                                                          \
        (t->ph[TINY_RX].p_vaddr -= 0x1000, t->ph[TINY_RX].p_memsz = t->ph[TINY_RX].p_filesz),      \
        "shares the page at 0x0")                                                                  \
    LIE(load_none, t->ph[TINY_R].p_type = t->ph[TINY_RX].p_type = t->ph[TINY_RW].p_type = PT_NULL, \
        "no loadable segment")                                                                     \
    LIE(dynamic_twice, (t->ph[TINY_SPARE] = t->ph[TINY_DYNAMIC]), "a second PT_DYNAMIC")           \
    LIE(tls_twice, (t->ph[TINY_SPARE] = t->ph[TINY_TLS]), "a second PT_TLS")                       \
    LIE(stack_twice, (t->ph[TINY_SPARE] = t->ph[TINY_STACK]), "a second PT_GNU_STACK")             \
    LIE(relro_twice, (t->ph[TINY_SPARE] = t->ph[TINY_RELRO]), "a second PT_GNU_RELRO")             \
    LIE(tls_outside, t->ph[TINY_TLS].p_offset = sizeof *t, "program header 4: p_offset")           \
    LIE(relro_wraps, t->ph[TINY_RELRO].p_memsz = UINT64_MAX, "end of the address space")           \
    LIE(relro_outside, t->ph[TINY_RELRO].p_memsz = 0x2000, "lies in no segment")                   \
    LIE(relro_nowhere, t->ph[TINY_RELRO].p_vaddr = 0x9000, "lies in no segment")                   \
    LIE(dynamic_none, t->ph[TINY_DYNAMIC].p_type = PT_NULL, "has no dynamic table")                \
    LIE(dynamic_outside, t->ph[TINY_DYNAMIC].p_vaddr = 0x9000, "dynamic table (p_vaddr 0x9000")    \
    LIE(dynamic_in_bss, t->ph[TINY_DYNAMIC].p_vaddr += 0x600, "dynamic table (p_vaddr")            \
    LIE(dynamic_elsewhere, t->ph[TINY_DYNAMIC].p_offset += 16, "p_offset says 0x")                 \
    LIE(dynamic_empty, (t->ph[TINY_DYNAMIC].p_filesz = 0, t->ph[TINY_DYNAMIC].p_memsz = 0),        \
        "lies in no segment")                                                                      \
    LIE(dynamic_small, t->ph[TINY_DYNAMIC].p_filesz = 8, "of 0x8 bytes has no entry")              \
    LIE(dynamic_endless, t->ph[TINY_DYNAMIC].p_filesz = 64, "has no end mark")                     \
    LIE(tag_twice, tiny_dyn_add(t, DT_SYMTAB, 0x40), "DT_SYMTAB is stated twice")                  \
    LIE(android, tiny_dyn_add(t, 0x60000011, 0x40), "packed Android relocations")                  \
    LIE(pie, tiny_dyn_add(t, DT_FLAGS_1, DF_1_PIE), "a position-independent executable")           \
    LIE(symbol_size, DYN(DT_SYMENT) = 16, "DT_SYMENT is 16, allowed is 24")                        \
    LIE(rela_entry, DYN(DT_RELAENT) = 0, "DT_RELAENT is 0, allowed is 24")                         \
    LIE(relr_entry, DYN(DT_RELRENT) = 4, "DT_RELRENT is 4, allowed is 8")                          \
    LIE(no_strings, tiny_dyn_remove(t, DT_STRTAB), "has no DT_STRTAB")                             \
    LIE(no_strings_size, tiny_dyn_remove(t, DT_STRSZ), "has no DT_STRSZ")                          \
    LIE(no_symbols, tiny_dyn_remove(t, DT_SYMTAB), "has no DT_SYMTAB")                             \
    LIE(strings_outside, DYN(DT_STRTAB) = 0x9000, "string table (DT_STRTAB 0x9000")                \
    LIE(strings_leave, DYN(DT_STRSZ) = 0x1000, "string table (DT_STRTAB")                          \
    LIE(strings_wrap, DYN(DT_STRSZ) = UINT64_MAX, "string table (DT_STRTAB")                       \
    LIE(strings_empty, DYN(DT_STRSZ) = 0, "string table (DT_STRTAB")                               \
    LIE(strings_endless, t->dynstr[127] = 'x', "does not end in a zero byte")                      \
    LIE(needed_outside, DYN(DT_NEEDED) = 128, "DT_NEEDED: name at 0x80 is outside")                \
    LIE(filter_outside, DYN(DT_FILTER) = UINT64_MAX, "DT_FILTER: name at")                         \
    LIE(symbols_outside, DYN(DT_SYMTAB) = 0x9000, "DT_SYMTAB: 8 entries of 24 bytes at 0x9000")    \
    LIE(symbols_wrap, DYN(DT_SYMTAB) = UINT64_MAX - 4, "DT_SYMTAB: 8 entries")                     \
    LIE(hash_outside, DYN(DT_HASH) = 0x9000, "DT_HASH 0x9000: 2 words")                            \
    LIE(hash_chains, t->hash[1] = 0x20000, "do not lie in the file's part")                        \
    LIE(hash_too_many, t->hash[1] = UINT32_MAX, "4294967295 dynamic symbols, allowed are up to")   \
    LIE(hash_buckets, t->hash[0] = UINT32_MAX, "DT_HASH 0x200: 4294967305 words")                  \
    LIE(hash_bucket, t->hash[2] = 8, "DT_HASH: word 2 names symbol 8 of 8")                        \
    LIE(hash_fewer, (t->hash[1] = 7, t->hash[9] = 0), "DT_GNU_HASH holds 8 symbols, DT_HASH 7")    \
    LIE(gnu_outside, DYN(DT_GNU_HASH) = UINT64_MAX, "DT_GNU_HASH")                                 \
    LIE(gnu_no_bucket, t->gnu_header[0] = 0, "0 buckets, 1 filter words")                          \
    LIE(gnu_filter, t->gnu_header[2] = 3, "1 buckets, 3 filter words")                             \
    LIE(gnu_filter_huge, t->gnu_header[2] = 0x80000000, "DT_GNU_HASH")                             \
    LIE(gnu_buckets, t->gnu_header[0] = UINT32_MAX, "4294967295 words")                            \
    LIE(gnu_bucket_low, t->bucket = 2, "bucket 0 names symbol 2, the first one in the table is 3") \
    LIE(gnu_bucket_high, t->bucket = 100000, "DT_GNU_HASH")                                        \
    LIE(gnu_chain_endless, t->chain[4] = 0, "DT_GNU_HASH holds 15 symbols, DT_HASH 8")             \
    LIE(hash_no_bucket, t->hash[0] = 0, "DT_HASH: 0 buckets")                                      \
    LIE(hash_circle, t->hash[3 + 7] = 1, "DT_HASH: symbol 1 is in two chains or in a circle")      \
    LIE(hash_misses, t->hash[3 + 4] = 6, "exports shared, but DT_HASH does not find it")           \
    LIE(gnu_shift, t->gnu_header[3] = 32, "shift 32; allowed is")                                  \
    LIE(gnu_filtered, t->bloom = 0, "exports Program_Ini, but DT_GNU_HASH does not find it")       \
    LIE(gnu_renamed, t->dynstr[t->dynsym[TINY_01].st_name] = 'p',                                  \
        "exports program_01, but DT_GNU_HASH does not find it")                                    \
    LIE(gnu_cut, t->chain[1] |= 1, "exports shared, but DT_GNU_HASH does not find it")             \
    LIE(gnu_skips, t->bucket = TINY_01, "exports Program_Ini, but DT_GNU_HASH does not find it")   \
    LIE(symbol_name, t->dynsym[TINY_01].st_name = 128, "dynamic symbol 4: its name at 0x80")       \
    LIE(symbol_nowhere, t->dynsym[TINY_01].st_value = 0x9000, "Program_01: 0x20 bytes at 0x9000")  \
    LIE(symbol_leaves, t->dynsym[TINY_01].st_size = 0x71, "runs past the end of its segment")      \
    LIE(symbol_wraps, t->dynsym[TINY_01].st_size = UINT64_MAX, "runs past the end")                \
    LIE(symbol_twice, t->dynsym[TINY_INI].st_name = t->dynsym[TINY_01].st_name,                    \
        "exports Program_01 twice")                                                                \
    LIE(rela_without_size, tiny_dyn_remove(t, DT_RELASZ), "DT_RELA without DT_RELASZ")             \
    LIE(size_without_rela, tiny_dyn_remove(t, DT_RELA), "DT_RELASZ without DT_RELA")               \
    LIE(rela_size, DYN(DT_RELASZ) = 25, "DT_RELASZ is 25, allowed is a multiple of 24")            \
    LIE(rela_outside, DYN(DT_RELASZ) = 0x3000 * 24, "DT_RELA: 12288 entries")                      \
    LIE(rela_wraps, DYN(DT_RELA) = UINT64_MAX, "DT_RELA: 6 entries")                               \
    LIE(rela_in_bss, DYN(DT_RELA) = TINY_ADDRESS(symtab), "DT_RELA: 6 entries")                    \
    LIE(rela_target, t->rela[0].r_offset = 0x9000, "patches 0x9000, which lies in no segment")     \
    LIE(rela_target_edge, t->rela[0].r_offset = TINY_ADDRESS(symtab) + TINY_BSS - 7,               \
        "R_X86_64_RELATIVE) patches")                                                              \
    LIE(rela_target_wraps, t->rela[0].r_offset = UINT64_MAX - 3, "lies in no segment")             \
    LIE(rela_symbol, t->rela[2].r_info = ELF64_R_INFO(8, R_X86_64_64), "dynamic symbol 8 of 8")    \
    LIE(rela_same_word, t->rela[0].r_offset = WORD(72), "two relocations patch the same bytes")    \
    LIE(rela_overlap, t->rela[0].r_offset = WORD(72) - 1, "two relocations patch the same bytes")  \
    LIE(relr_bitmap_first, t->relr[0] = 1, "DT_RELR starts with a bitmap")                         \
    LIE(relr_target, t->relr[0] = 0x9000, "DT_RELR: entry 0 (R_X86_64_RELATIVE) patches 0x9000")   \
    LIE(relr_bits, (t->relr[0] = WORD(60), t->relr[1] = UINT64_MAX), "DT_RELR: entry 1")           \
    LIE(relr_size, DYN(DT_RELRSZ) = 12, "DT_RELRSZ is 12, allowed is a multiple of 8")             \
    LIE(plt_kind, DYN(DT_PLTREL) = 1, "DT_PLTREL is 1, allowed are 7")                             \
    LIE(plt_without_size, tiny_dyn_remove(t, DT_PLTRELSZ), "DT_JMPREL without DT_PLTRELSZ")        \
    LIE(plt_without_table, tiny_dyn_remove(t, DT_JMPREL), "DT_PLTRELSZ without DT_JMPREL")         \
    LIE(array_size, DYN(DT_INIT_ARRAYSZ) = 12, "DT_INIT_ARRAYSZ is 12, allowed is a multiple")     \
    LIE(array_outside, DYN(DT_INIT_ARRAY) = 0x9000, "DT_INIT_ARRAY: 0x10 bytes at 0x9000")         \
    LIE(array_huge, DYN(DT_FINI_ARRAYSZ) = 0xfffffffffffffff8, "DT_FINI_ARRAY: 0xffff")            \
    LIE(array_alone, tiny_dyn_remove(t, DT_INIT_ARRAYSZ), "only one of DT_INIT_ARRAY and")

#define LIE(name, change, text)                                                                    \
    static void elf_lie_##name(struct tiny *t)                                                     \
    {                                                                                              \
        change;                                                                                    \
    }
ELF_LIES
#undef LIE

static const struct {
    const char *name;
    void (*tell)(struct tiny *t);
    const char *sentence;
} elf_lies[] = {
#define LIE(name, change, text) { #name, elf_lie_##name, text },
    ELF_LIES
#undef LIE
};

#endif
