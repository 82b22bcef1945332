/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_header.c - is this ELF file one that runs here, and do its header's tables lie in the file?
 *
 * Runs before libelf sees the file: libelf allocates from the section count.
 */
#include "image/elf.h"

#include <stdio.h>

static const struct {
    uint16_t machine;
    enum image_target target;
    const char *name;
} machines[] = {
    { EM_X86_64, IMAGE_TARGET_X86_64, "x86-64" },
    { EM_386, IMAGE_TARGET_I386, "i386" },
    { EM_ARM, IMAGE_TARGET_ARM, "Arm" },
    { EM_AARCH64, IMAGE_TARGET_NONE, "AArch64" },
    { EM_RISCV, IMAGE_TARGET_NONE, "RISC-V" },
    { EM_PPC, IMAGE_TARGET_NONE, "PowerPC" },
    { EM_PPC64, IMAGE_TARGET_NONE, "PowerPC64" },
    { EM_MIPS, IMAGE_TARGET_NONE, "MIPS" },
    { EM_S390, IMAGE_TARGET_NONE, "S/390" },
    { EM_SPARC, IMAGE_TARGET_NONE, "SPARC" },
    { EM_SPARCV9, IMAGE_TARGET_NONE, "SPARC V9" },
    { EM_IA_64, IMAGE_TARGET_NONE, "Itanium" },
    { EM_LOONGARCH, IMAGE_TARGET_NONE, "LoongArch" },
    { EM_NONE, IMAGE_TARGET_NONE, "no machine" },
};

static const struct {
    uint16_t type;
    const char *what;
} wrong_types[] = {
    { ET_NONE, "states no file type" },
    { ET_REL, "an object file, not a module: compile and link it first (-shared)" },
    { ET_EXEC, "an executable, not a module: link it with -shared" },
    { ET_CORE, "a core dump, not a module" },
};

static void name_target(struct image *image, bool wide, unsigned machine)
{
    image->format = wide ? IMAGE_FORMAT_ELF64 : IMAGE_FORMAT_ELF32;
    image->format_name = wide ? "ELF64" : "ELF32";
    image->target_name = "unknown machine";
    for (size_t i = 0; i < sizeof machines / sizeof machines[0]; i++) {
        if (machines[i].machine == machine) {
            image->target = machines[i].target;
            image->target_name = machines[i].name;
        }
    }
}

static size_t header_size(unsigned class)
{
    return class == ELFCLASS32 ? sizeof(Elf32_Ehdr) : sizeof(Elf64_Ehdr);
}

bool elf_check_ident(struct image *image, const struct elf_kind **kind)
{
    const uint8_t *ident = image->bytes;
    size_t needed = header_size(image->size > EI_CLASS ? ident[EI_CLASS] : ELFCLASS64);
    /* e_type and e_machine stand behind e_ident in both classes; e_ident says in which order. */
    if (image->size < needed)
        return image_defect(image, "too short: %zu bytes, the ELF header alone takes %zu",
                            image->size, needed);
    unsigned class = ident[EI_CLASS], order = ident[EI_DATA];
    if (class != ELFCLASS64 && class != ELFCLASS32)
        return image_defect(
            image, "ELF class (EI_CLASS) is %u, allowed are 1 (32-bit) and 2 (64-bit)", class);
    if (order != ELFDATA2LSB && order != ELFDATA2MSB)
        return image_defect(image, "ELF byte order (EI_DATA) is %u, allowed is 1 (little-endian)",
                            order);
    bool little = order == ELFDATA2LSB;
    unsigned machine =
        little ? ident[18] | (unsigned)ident[19] << 8 : (unsigned)ident[18] << 8 | ident[19];
    name_target(image, class == ELFCLASS64, machine);
    *kind = elf_find_kind(class, machine);
    if (*kind == NULL || !little)
        return image_defect(image,
                            "a %s-bit %s-endian ELF file for %s (e_machine %u); a module is "
                            "little-endian, 64-bit for x86-64 (62) or 32-bit for Arm (40)",
                            class == ELFCLASS64 ? "64" : "32", little ? "little" : "big",
                            image->target_name, machine);
    if (ident[EI_VERSION] != EV_CURRENT)
        return image_defect(image, "ELF version (EI_VERSION) is %u, allowed is 1",
                            ident[EI_VERSION]);
    if (ident[EI_OSABI] != ELFOSABI_SYSV && ident[EI_OSABI] != ELFOSABI_GNU)
        return image_defect(image,
                            "operating system ABI (EI_OSABI) is %u, allowed are 0 (System V) "
                            "and 3 (GNU)",
                            ident[EI_OSABI]);
    if (ident[EI_ABIVERSION] != 0)
        return image_defect(image, "ABI version (EI_ABIVERSION) is %u, allowed is 0",
                            ident[EI_ABIVERSION]);
    return true;
}

static bool check_type(struct image *image, const Elf64_Ehdr *header)
{
    for (size_t i = 0; i < sizeof wrong_types / sizeof wrong_types[0]; i++) {
        if (wrong_types[i].type == header->e_type)
            return image_defect(image, "%s (e_type %u, allowed is 3, ET_DYN)", wrong_types[i].what,
                                header->e_type);
    }
    if (header->e_type != ET_DYN)
        return image_defect(image, "file type (e_type) is 0x%x, allowed is 3 (ET_DYN)",
                            header->e_type);
    return true;
}

/* A loader has no use for the section table, but a file whose table lies outside was cut off, and
 * libelf and libdw would work from it. */
static bool check_section_table(struct image *image, const struct elf_kind *kind,
                                const Elf64_Ehdr *header)
{
    size_t entry = kind->class == ELFCLASS32 ? sizeof(Elf32_Shdr) : sizeof(Elf64_Shdr);
    if (header->e_shoff == 0 && header->e_shnum == 0)
        return true;
    if (header->e_shoff == 0)
        return image_defect(image, "e_shnum says %u sections, e_shoff says there is no table",
                            header->e_shnum);
    if (header->e_shnum == 0)
        return image_defect(image,
                            "e_shoff is 0x%llx but e_shnum is 0; allowed is a table of 1 to "
                            "65279 sections or none",
                            (unsigned long long)header->e_shoff);
    if (header->e_shnum >= SHN_LORESERVE)
        return image_defect(image, "e_shnum is %u, allowed is up to 65279", header->e_shnum);
    if (header->e_shentsize != entry)
        return image_defect(image, "section header size (e_shentsize) is %u, allowed is %zu",
                            header->e_shentsize, entry);
    uint64_t size = header->e_shnum * (uint64_t)entry;
    if (header->e_shoff > image->size || size > image->size - header->e_shoff)
        return image_defect(image,
                            "section header table (e_shoff 0x%llx, %u entries) lies outside "
                            "the file of %zu bytes: was it cut off?",
                            (unsigned long long)header->e_shoff, header->e_shnum, image->size);
    return true;
}

static bool check_program_table(struct image *image, const struct elf_kind *kind,
                                const Elf64_Ehdr *header)
{
    size_t entry = kind->class == ELFCLASS32 ? sizeof(Elf32_Phdr) : sizeof(Elf64_Phdr);
    if (header->e_phnum == 0 || header->e_phoff == 0)
        return image_defect(image,
                            "has no program headers (e_phoff 0x%llx, e_phnum %u): nothing "
                            "to map",
                            (unsigned long long)header->e_phoff, header->e_phnum);
    if (header->e_phnum == PN_XNUM)
        return image_defect(image, "e_phnum is 65535, allowed is up to 65534");
    if (header->e_phentsize != entry)
        return image_defect(image, "program header size (e_phentsize) is %u, allowed is %zu",
                            header->e_phentsize, entry);
    uint64_t size = header->e_phnum * (uint64_t)entry;
    if (header->e_phoff > image->size || size > image->size - header->e_phoff)
        return image_defect(image,
                            "program header table (e_phoff 0x%llx, %u entries) lies outside "
                            "the file of %zu bytes",
                            (unsigned long long)header->e_phoff, header->e_phnum, image->size);
    return true;
}

/* What the code expects of the processor and of its callers. */
static bool check_arm_flags(struct image *image, const Elf64_Ehdr *header)
{
    if ((header->e_flags & EF_ARM_EABIMASK) != EF_ARM_EABI_VER5)
        return image_defect(image, "Arm EABI version (e_flags 0x%x) is %u, allowed is 5",
                            header->e_flags, (header->e_flags & EF_ARM_EABIMASK) >> 24);
    if ((header->e_flags & EF_ARM_BE8) != 0)
        return image_defect(image, "big-endian Arm data (e_flags 0x%x has EF_ARM_BE8)",
                            header->e_flags);
    return true;
}

bool elf_check_header(struct image *image, const struct elf_kind *kind, const Elf64_Ehdr *header)
{
    if (!check_type(image, header))
        return false;
    if (header->e_version != EV_CURRENT)
        return image_defect(image, "ELF version (e_version) is %u, allowed is 1",
                            header->e_version);
    if (header->e_ehsize != header_size(kind->class))
        return image_defect(image, "ELF header size (e_ehsize) is %u, allowed is %zu",
                            header->e_ehsize, header_size(kind->class));
    if (kind->machine == EM_ARM && !check_arm_flags(image, header))
        return false;
    return check_program_table(image, kind, header) && check_section_table(image, kind, header);
}
