/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "image_support.h"

#include <stdlib.h>
#include <string.h>

static const char dynamic_strings[] =
    "\0missing\0maybe\0Program_Ini\0Program_01\0shared\0pick\0slot\0"
    "libm.so\0front.so\0aside.so";
static const char static_strings[] = "\0local\0hidden_one\0null_weak\0null_strong\0Program_01@@V1\0"
                                     "label";
static const char section_names[] = "\0.symtab\0.strtab\0.shstrtab\0.ctors\0.debug_line";

/* Offset of a whole string in a table of strings. */
static uint32_t string_at(const char *table, size_t size, const char *string)
{
    size_t length = strlen(string) + 1;
    for (size_t i = 1; i + length <= size; i++) {
        if (table[i - 1] == '\0' && memcmp(table + i, string, length) == 0)
            return (uint32_t)i;
    }
    abort();
}

static uint32_t dynamic_string(const char *string)
{
    return string_at(dynamic_strings, sizeof dynamic_strings, string);
}

static uint32_t gnu_hash(const char *name)
{
    uint32_t hash = 5381;
    for (; *name != '\0'; name++)
        hash = 33 * hash + (unsigned char)*name;
    return hash;
}

static Elf64_Sym symbol(const char *name, unsigned binding, unsigned type, uint16_t section,
                        uint64_t value, uint64_t size)
{
    return (Elf64_Sym){ .st_name = dynamic_string(name),
                        .st_info = (unsigned char)ELF64_ST_INFO(binding, type),
                        .st_shndx = section,
                        .st_value = value,
                        .st_size = size };
}

static Elf64_Sym static_symbol(const char *name, unsigned binding, unsigned type, uint16_t section,
                               uint64_t value, uint64_t size)
{
    Elf64_Sym made = symbol("slot", binding, type, section, value, size);
    made.st_name = string_at(static_strings, sizeof static_strings, name);
    return made;
}

static void header(struct tiny *t)
{
    memcpy(t->eh.e_ident, ELFMAG, SELFMAG);
    t->eh.e_ident[EI_CLASS] = ELFCLASS64;
    t->eh.e_ident[EI_DATA] = ELFDATA2LSB;
    t->eh.e_ident[EI_VERSION] = EV_CURRENT;
    t->eh.e_type = ET_DYN;
    t->eh.e_machine = EM_X86_64;
    t->eh.e_version = EV_CURRENT;
    t->eh.e_phoff = offsetof(struct tiny, ph);
    t->eh.e_shoff = offsetof(struct tiny, sh);
    t->eh.e_ehsize = sizeof t->eh;
    t->eh.e_phentsize = sizeof t->ph[0];
    t->eh.e_phnum = 8;
    t->eh.e_shentsize = sizeof t->sh[0];
    t->eh.e_shnum = 6;
    t->eh.e_shstrndx = TINY_SHSTRTAB;
}

static Elf64_Phdr segment(uint32_t type, uint32_t flags, uint64_t offset, uint64_t vaddr,
                          uint64_t size)
{
    return (Elf64_Phdr){ .p_type = type,
                         .p_flags = flags,
                         .p_offset = offset,
                         .p_vaddr = vaddr,
                         .p_paddr = vaddr,
                         .p_filesz = size,
                         .p_memsz = size,
                         .p_align = type == PT_LOAD ? 0x1000 : 8 };
}

static void segments(struct tiny *t)
{
    size_t code = offsetof(struct tiny, code), data = offsetof(struct tiny, dyn);
    size_t end = offsetof(struct tiny, symtab);
    t->ph[TINY_R] = segment(PT_LOAD, PF_R, 0, 0, code);
    t->ph[TINY_RX] = segment(PT_LOAD, PF_R | PF_X, code, code + 0x1000, data - code);
    t->ph[TINY_RW] = segment(PT_LOAD, PF_R | PF_W, data, data + 0x2000, end - data);
    t->ph[TINY_RW].p_memsz += TINY_BSS;
    t->ph[TINY_DYNAMIC] = segment(PT_DYNAMIC, PF_R | PF_W, data, TINY_ADDRESS(dyn), sizeof t->dyn);
    t->ph[TINY_TLS] = segment(PT_TLS, PF_R, data, TINY_ADDRESS(dyn), 8);
    t->ph[TINY_TLS].p_memsz = 24;
    t->ph[TINY_STACK] = segment(PT_GNU_STACK, PF_R | PF_W, 0, 0, 0);
    t->ph[TINY_RELRO] = segment(PT_GNU_RELRO, PF_R, data, TINY_ADDRESS(dyn), sizeof t->dyn);
    t->ph[TINY_SPARE].p_type = PT_NULL;
}

static void symbols(struct tiny *t)
{
    uint64_t code = TINY_ADDRESS(code);
    uint32_t *gnu = t->gnu_header;
    memcpy(t->dynstr, dynamic_strings, sizeof dynamic_strings);
    t->dynsym[TINY_MISSING] = symbol("missing", STB_GLOBAL, STT_NOTYPE, SHN_UNDEF, 0, 0);
    t->dynsym[TINY_MAYBE] = symbol("maybe", STB_WEAK, STT_NOTYPE, SHN_UNDEF, 0, 0);
    t->dynsym[TINY_INI] = symbol("Program_Ini", STB_GLOBAL, STT_FUNC, 1, code, 16);
    t->dynsym[TINY_01] = symbol("Program_01", STB_GLOBAL, STT_FUNC, 1, code + 16, 32);
    t->dynsym[TINY_SHARED] = symbol("shared", STB_GLOBAL, STT_OBJECT, 1, TINY_ADDRESS(words), 8);
    t->dynsym[TINY_PICK] = symbol("pick", STB_WEAK, STT_GNU_IFUNC, 1, code + 48, 8);
    t->dynsym[TINY_SLOT] = symbol("slot", STB_GLOBAL, STT_TLS, 1, 0, 8);
    t->hash[0] = 1; /* buckets */
    t->hash[1] = 8; /* symbols */
    t->hash[2] = TINY_MISSING;
    for (uint32_t i = TINY_MISSING; i < TINY_SLOT; i++)
        t->hash[3 + i] = i + 1;
    gnu[0] = 1; /* buckets */
    gnu[1] = TINY_INI;
    gnu[2] = 1; /* filter words */
    gnu[3] = 6;
    t->bloom = UINT64_MAX;
    t->bucket = TINY_INI;
    for (uint32_t i = TINY_INI; i <= TINY_SLOT; i++)
        t->chain[i - TINY_INI] = gnu_hash(dynamic_strings + t->dynsym[i].st_name) & ~1u;
    t->chain[TINY_SLOT - TINY_INI] |= 1;
}

static void relocations(struct tiny *t)
{
    uint64_t code = TINY_ADDRESS(code);
    t->rela[0] = (Elf64_Rela){ TINY_ADDRESS(words[70]), ELF64_R_INFO(0, R_X86_64_RELATIVE),
                               (int64_t)code + 16 };
    t->rela[1] = (Elf64_Rela){ TINY_ADDRESS(init_array[0]), ELF64_R_INFO(0, R_X86_64_RELATIVE),
                               (int64_t)code + 64 };
    t->rela[2] = (Elf64_Rela){ TINY_ADDRESS(words[71]), ELF64_R_INFO(TINY_MAYBE, R_X86_64_64), 5 };
    t->rela[3] =
        (Elf64_Rela){ TINY_ADDRESS(words[72]), ELF64_R_INFO(TINY_MISSING, R_X86_64_GLOB_DAT), 0 };
    t->rela[4] = (Elf64_Rela){ TINY_ADDRESS(words[73]), ELF64_R_INFO(0, R_X86_64_IRELATIVE),
                               (int64_t)code + 48 };
    t->rela[5] =
        (Elf64_Rela){ TINY_ADDRESS(words[74]), ELF64_R_INFO(TINY_SLOT, R_X86_64_DTPMOD64), 0 };
    t->plt[0] =
        (Elf64_Rela){ TINY_ADDRESS(words[75]), ELF64_R_INFO(TINY_MISSING, R_X86_64_JUMP_SLOT), 0 };
    t->plt[1] =
        (Elf64_Rela){ TINY_ADDRESS(words[76]), ELF64_R_INFO(TINY_01, R_X86_64_JUMP_SLOT), 0 };
    t->rel[0] = (Elf64_Rel){ TINY_ADDRESS(words[77]), ELF64_R_INFO(0, R_X86_64_RELATIVE) };
    t->relr[0] = TINY_ADDRESS(words[0]);
    t->relr[1] = 1 | (uint64_t)1 << 1 | (uint64_t)1 << 63; /* words[1] and words[63] */
    t->words[0] = 0x10;
    t->words[1] = 0x11;
    t->words[63] = UINT64_MAX;
    t->words[77] = 0x77;
}

static void dynamic(struct tiny *t)
{
    const struct {
        int64_t tag;
        uint64_t value;
    } entries[] = {
        { DT_NEEDED, dynamic_string("libm.so") },
        { DT_FILTER, dynamic_string("front.so") },
        { DT_AUXILIARY, dynamic_string("aside.so") },
        { DT_STRTAB, TINY_ADDRESS(dynstr) },
        { DT_STRSZ, sizeof t->dynstr },
        { DT_SYMTAB, TINY_ADDRESS(dynsym) },
        { DT_SYMENT, sizeof t->dynsym[0] },
        { DT_HASH, TINY_ADDRESS(hash) },
        { DT_GNU_HASH, TINY_ADDRESS(gnu_header) },
        { DT_RELA, TINY_ADDRESS(rela) },
        { DT_RELASZ, sizeof t->rela },
        { DT_RELAENT, sizeof t->rela[0] },
        { DT_RELR, TINY_ADDRESS(relr) },
        { DT_RELRSZ, sizeof t->relr },
        { DT_RELRENT, sizeof t->relr[0] },
        { DT_JMPREL, TINY_ADDRESS(plt) },
        { DT_PLTRELSZ, sizeof t->plt },
        { DT_PLTREL, DT_RELA },
        { DT_INIT, TINY_ADDRESS(code[0]) },
        { DT_FINI, TINY_ADDRESS(code[16]) },
        { DT_INIT_ARRAY, TINY_ADDRESS(init_array) },
        { DT_INIT_ARRAYSZ, sizeof t->init_array },
        { DT_FINI_ARRAY, TINY_ADDRESS(fini_array) },
        { DT_FINI_ARRAYSZ, sizeof t->fini_array },
        { DT_PREINIT_ARRAY, TINY_ADDRESS(preinit_array) },
        { DT_PREINIT_ARRAYSZ, sizeof t->preinit_array },
    };
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; i++)
        tiny_dyn_add(t, entries[i].tag, entries[i].value);
    t->init_array[1] = TINY_ADDRESS(code[80]);
    t->fini_array[0] = TINY_ADDRESS(code[64]);
    t->preinit_array[0] = 0;
    t->ctors[0] = UINT64_MAX;
    t->ctors[1] = TINY_ADDRESS(code[96]);
}

static Elf64_Shdr section(const char *name, uint32_t type, uint64_t flags, uint64_t offset,
                          uint64_t size)
{
    return (Elf64_Shdr){ .sh_name = string_at(section_names, sizeof section_names, name),
                         .sh_type = type,
                         .sh_flags = flags,
                         .sh_offset = offset,
                         .sh_size = size };
}

static void sections(struct tiny *t)
{
    uint64_t code = TINY_ADDRESS(code);
    t->symtab[1] = static_symbol("local", STB_LOCAL, STT_FUNC, 1, code + 64, 16);
    t->symtab[2] = static_symbol("hidden_one", STB_GLOBAL, STT_FUNC, 1, code + 80, 8);
    t->symtab[2].st_other = STV_HIDDEN;
    t->symtab[3] = static_symbol("null_weak", STB_WEAK, STT_NOTYPE, SHN_UNDEF, 0, 0);
    t->symtab[4] = static_symbol("null_strong", STB_GLOBAL, STT_NOTYPE, SHN_UNDEF, 0, 0);
    t->symtab[5] = static_symbol("Program_01@@V1", STB_GLOBAL, STT_FUNC, 1, code + 16, 32);
    t->symtab[6] = static_symbol("label", STB_LOCAL, STT_NOTYPE, 1, code + 96, 0);
    memcpy(t->strtab, static_strings, sizeof static_strings);
    memcpy(t->shstrtab, section_names, sizeof section_names);
    t->sh[TINY_SYMTAB] =
        section(".symtab", SHT_SYMTAB, 0, offsetof(struct tiny, symtab), sizeof t->symtab);
    t->sh[TINY_SYMTAB].sh_link = TINY_STRTAB;
    t->sh[TINY_SYMTAB].sh_entsize = sizeof t->symtab[0];
    t->sh[TINY_STRTAB] =
        section(".strtab", SHT_STRTAB, 0, offsetof(struct tiny, strtab), sizeof t->strtab);
    t->sh[TINY_SHSTRTAB] =
        section(".shstrtab", SHT_STRTAB, 0, offsetof(struct tiny, shstrtab), sizeof t->shstrtab);
    t->sh[TINY_CTORS] = section(".ctors", SHT_PROGBITS, SHF_ALLOC | SHF_WRITE,
                                offsetof(struct tiny, ctors), sizeof t->ctors);
    t->sh[TINY_CTORS].sh_addr = TINY_ADDRESS(ctors);
    t->sh[TINY_DEBUG_LINE] =
        section(".debug_line", SHT_PROGBITS, 0, offsetof(struct tiny, shstrtab), 0);
}

void tiny_init(struct tiny *tiny)
{
    memset(tiny, 0, sizeof *tiny);
    header(tiny);
    segments(tiny);
    symbols(tiny);
    relocations(tiny);
    dynamic(tiny);
    sections(tiny);
}

Elf64_Dyn *tiny_dyn(struct tiny *tiny, int64_t tag)
{
    for (size_t i = 0; i < sizeof tiny->dyn / sizeof tiny->dyn[0]; i++) {
        if (tiny->dyn[i].d_tag == tag)
            return &tiny->dyn[i];
    }
    abort();
}

void tiny_dyn_add(struct tiny *tiny, int64_t tag, uint64_t value)
{
    Elf64_Dyn *entry = tiny_dyn(tiny, DT_NULL);
    entry->d_tag = tag;
    entry->d_un.d_val = value;
}

void tiny_dyn_remove(struct tiny *tiny, int64_t tag)
{
    /* DT_DEBUG means nothing here, so the other entries may stay where they are. */
    tiny_dyn(tiny, tag)->d_tag = DT_DEBUG;
}

/* ---- promises ---- */

static bool printable_line(const char *text)
{
    for (; *text != '\0'; text++) {
        if (*text < 0x20 || *text > 0x7e)
            return false;
    }
    return true;
}

static const char *broken_segment(const struct image *image)
{
    uint64_t end = 0;
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *s = &image->segments[i];
        if (s->mem_size == 0 || s->file_size > s->mem_size || s->file_offset > image->size ||
            s->file_size > image->size - s->file_offset)
            return "segment outside the file";
        if (s->vaddr < end || s->vaddr + s->mem_size < s->vaddr)
            return "segments overlap";
        end = s->vaddr + s->mem_size;
        if (s->vaddr < image->span_begin || end > image->span_end)
            return "segment outside the hull";
    }
    if (image->span_begin % 4096 != 0 || image->span_end % 4096 != 0 ||
        image->span_end - image->span_begin > (256u << 20))
        return "bad hull";
    if (image->align < 4096 || (image->align & (image->align - 1)) != 0)
        return "bad alignment";
    if (image->has_entry_point && image_segment_at(image, image->entry_point, 1) == NULL)
        return "entry point outside every segment";
    return image->relro_begin > image->relro_end || image->relro_end > image->span_end ? "bad RELRO"
                                                                                       : NULL;
}

/* Ends within the longest name that there can be; where it does not belong to the image, a checking
 * allocator sees the read. */
static bool readable(const char *text)
{
    return text != NULL && strnlen(text, 2 * 1024 + 2) <= 2 * 1024 + 1;
}

static const char *broken_symbol(const struct image *image)
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *s = &image->symbols[i];
        if (!readable(s->name) || s->name[0] == '\0')
            return "symbol name outside the file";
        if (s->forwarder != NULL && (!readable(s->forwarder) || !s->exported || s->executable))
            return "forwarder that is a place";
        const struct image_segment *segment = image_segment_at(image, s->vaddr, 1);
        if (s->executable && (segment == NULL || (segment->perm & IMAGE_EXEC) == 0))
            return "symbol is not executable";
        if (s->executable && s->size > segment->vaddr + segment->mem_size - s->vaddr)
            return "symbol leaves its segment";
        if (i > 0 && (s[-1].vaddr > s->vaddr ||
                      (s[-1].vaddr == s->vaddr && strcmp(s[-1].name, s->name) >= 0)))
            return "symbols are not sorted";
    }
    for (size_t i = 0; i < image->import_count; i++) {
        if (!readable(image->imports[i].name))
            return "import name outside the file";
    }
    return NULL;
}

static const char *broken_reloc(const struct image *image)
{
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *r = &image->relocs[i];
        if (r->width > 16 || (r->kind == IMAGE_RELOC_RELATIVE && r->width == 0))
            return "relocation of no width";
        if (image_segment_at(image, r->vaddr, r->width != 0 ? r->width : 1) == NULL)
            return "relocation outside every segment";
        if (r->type_name == NULL || (r->symbol != NULL && !readable(r->symbol)))
            return "relocation without a name";
        if (i > 0 && (r[-1].vaddr >= r->vaddr || r->vaddr - r[-1].vaddr < r[-1].width))
            return "relocations overlap";
    }
    for (size_t i = 0; i < image->initialiser_count; i++) {
        if (image->initialisers[i].what == NULL)
            return "initialiser without a name";
    }
    return NULL;
}

const char *image_broken_promise(const struct image *image)
{
    const char *broken;
    if (strlen(image->sha256) != 64 || image->format_name == NULL || image->target_name == NULL)
        return "no hash or names";
    if (!printable_line(image->defect))
        return "defect is not one printable line";
    if (image->defect[0] != '\0')
        return image->segment_count + image->symbol_count + image->import_count +
                           image->reloc_count + image->initialiser_count + image->span_end !=
                       0
                   ? "defective image with contents"
                   : NULL;
    if (image->segment_count == 0)
        return "neither defect nor segments";
    if (image->debug_file != NULL && strlen(image->debug_file) >= image->size)
        return "debug file without a name that ends";
    broken = broken_segment(image);
    if (broken == NULL)
        broken = broken_symbol(image);
    return broken != NULL ? broken : broken_reloc(image);
}
