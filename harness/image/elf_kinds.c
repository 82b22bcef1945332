/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_kinds.c - the kinds of ELF file that can be a module, and their relocations.
 */
#include "image/elf.h"

/* psABI x86-64, table 4.9. width: bytes patched; 0: none or unknown. */
static const struct elf_reloc_type x86_64_relocs[] = {
#define TYPE(name, kind, width) [R_X86_64_##name] = { "R_X86_64_" #name, IMAGE_RELOC_##kind, width }
    TYPE(NONE, OTHER, 0),        TYPE(64, SYMBOLIC, 8),         TYPE(PC32, SYMBOLIC, 4),
    TYPE(GOT32, OTHER, 4),       TYPE(PLT32, SYMBOLIC, 4),      TYPE(COPY, SYMBOLIC, 0),
    TYPE(GLOB_DAT, SYMBOLIC, 8), TYPE(JUMP_SLOT, SYMBOLIC, 8),  TYPE(RELATIVE, RELATIVE, 8),
    TYPE(GOTPCREL, OTHER, 4),    TYPE(32, SYMBOLIC, 4),         TYPE(32S, SYMBOLIC, 4),
    TYPE(16, SYMBOLIC, 2),       TYPE(PC16, SYMBOLIC, 2),       TYPE(8, SYMBOLIC, 1),
    TYPE(PC8, SYMBOLIC, 1),      TYPE(DTPMOD64, TLS, 8),        TYPE(DTPOFF64, TLS, 8),
    TYPE(TPOFF64, TLS, 8),       TYPE(TLSGD, TLS, 4),           TYPE(TLSLD, TLS, 4),
    TYPE(DTPOFF32, TLS, 4),      TYPE(GOTTPOFF, TLS, 4),        TYPE(TPOFF32, TLS, 4),
    TYPE(PC64, SYMBOLIC, 8),     TYPE(GOTOFF64, OTHER, 8),      TYPE(GOTPC32, OTHER, 4),
    TYPE(GOT64, OTHER, 8),       TYPE(GOTPCREL64, OTHER, 8),    TYPE(GOTPC64, OTHER, 8),
    TYPE(GOTPLT64, OTHER, 8),    TYPE(PLTOFF64, OTHER, 8),      TYPE(SIZE32, SYMBOLIC, 4),
    TYPE(SIZE64, SYMBOLIC, 8),   TYPE(GOTPC32_TLSDESC, TLS, 4), TYPE(TLSDESC_CALL, TLS, 0),
    TYPE(TLSDESC, TLS, 16),      TYPE(IRELATIVE, INDIRECT, 8),  TYPE(RELATIVE64, RELATIVE, 8),
    TYPE(GOTPCRELX, OTHER, 4),   TYPE(REX_GOTPCRELX, OTHER, 4),
#undef TYPE
};

/* ELF for the Arm architecture, tables of static and dynamic relocations; a linker of shared
 * objects leaves the dynamic ones. */
static const struct elf_reloc_type arm_relocs[] = {
#define TYPE(name, kind, width) [R_ARM_##name] = { "R_ARM_" #name, IMAGE_RELOC_##kind, width }
    TYPE(NONE, OTHER, 0),        TYPE(PC24, OTHER, 4),         TYPE(ABS32, SYMBOLIC, 4),
    TYPE(REL32, SYMBOLIC, 4),    TYPE(ABS16, SYMBOLIC, 2),     TYPE(ABS8, SYMBOLIC, 1),
    TYPE(THM_PC22, OTHER, 4),    TYPE(TLS_DESC, TLS, 8),       TYPE(TLS_DTPMOD32, TLS, 4),
    TYPE(TLS_DTPOFF32, TLS, 4),  TYPE(TLS_TPOFF32, TLS, 4),    TYPE(COPY, SYMBOLIC, 0),
    TYPE(GLOB_DAT, SYMBOLIC, 4), TYPE(JUMP_SLOT, SYMBOLIC, 4), TYPE(RELATIVE, RELATIVE, 4),
    TYPE(GOTOFF, OTHER, 4),      TYPE(GOTPC, OTHER, 4),        TYPE(GOT32, OTHER, 4),
    TYPE(PLT32, OTHER, 4),       TYPE(CALL, OTHER, 4),         TYPE(JUMP24, OTHER, 4),
    TYPE(THM_JUMP24, OTHER, 4),  TYPE(TARGET1, SYMBOLIC, 4),   TYPE(PREL31, SYMBOLIC, 4),
    TYPE(MOVW_ABS_NC, OTHER, 4), TYPE(MOVT_ABS, OTHER, 4),     TYPE(MOVW_PREL_NC, OTHER, 4),
    TYPE(MOVT_PREL, OTHER, 4),   TYPE(ABS32_NOI, SYMBOLIC, 4), TYPE(REL32_NOI, SYMBOLIC, 4),
    TYPE(TLS_GD32, TLS, 4),      TYPE(TLS_LDM32, TLS, 4),      TYPE(TLS_LDO32, TLS, 4),
    TYPE(TLS_IE32, TLS, 4),      TYPE(TLS_LE32, TLS, 4),       TYPE(IRELATIVE, INDIRECT, 4),
#undef TYPE
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const struct elf_kind kinds[] = {
    { .class = ELFCLASS64,
      .machine = EM_X86_64,
      .word = 8,
      .address_max = UINT64_MAX,
      .reloc_types = x86_64_relocs,
      .reloc_type_count = COUNT(x86_64_relocs),
      .reloc_none = R_X86_64_NONE,
      .reloc_relative = R_X86_64_RELATIVE,
      .reloc_absolute = R_X86_64_64 },
    { .class = ELFCLASS32,
      .machine = EM_ARM,
      .word = 4,
      .address_max = UINT32_MAX,
      .reloc_types = arm_relocs,
      .reloc_type_count = COUNT(arm_relocs),
      .reloc_none = R_ARM_NONE,
      .reloc_relative = R_ARM_RELATIVE,
      .reloc_absolute = R_ARM_ABS32,
      .thumb = true },
};

const struct elf_kind *elf_find_kind(unsigned class, unsigned machine)
{
    for (size_t i = 0; i < COUNT(kinds); i++) {
        if (kinds[i].class == class && kinds[i].machine == machine)
            return &kinds[i];
    }
    return NULL;
}
