/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf.c - the boundary to libelf, and the order in which an ELF file is read.
 *
 * libelf gets the file only after elf_header.c has found its tables inside the file, and is asked
 * only for ranges that were checked. What it gives back is checked once, here.
 */
#include "image/elf.h"

#include <errno.h>
#include <gelf.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    Elf_Type type;
    size_t size32, size64;
} records[ELF_RECORDS] = {
    [ELF_RECORD_DYN] = { ELF_T_DYN, sizeof(Elf32_Dyn), sizeof(Elf64_Dyn) },
    [ELF_RECORD_SYM] = { ELF_T_SYM, sizeof(Elf32_Sym), sizeof(Elf64_Sym) },
    [ELF_RECORD_RELA] = { ELF_T_RELA, sizeof(Elf32_Rela), sizeof(Elf64_Rela) },
    [ELF_RECORD_REL] = { ELF_T_REL, sizeof(Elf32_Rel), sizeof(Elf64_Rel) },
    [ELF_RECORD_WORD] = { ELF_T_WORD, sizeof(Elf32_Word), sizeof(Elf64_Word) },
    [ELF_RECORD_ADDRESS] = { ELF_T_ADDR, sizeof(Elf32_Addr), sizeof(Elf64_Addr) },
};

/* A table of a 32-bit file as its 64-bit counterpart. */
struct elf_copy {
    struct elf_copy *next;
    max_align_t records[];
};

bool elf_out_of_memory(struct elf *elf)
{
    elf->error = -ENOMEM;
    return false;
}

/* errno was 0 before libelf was called: its own number for lack of memory is not public, and a
 * file must not be called defective because of it. */
static bool libelf_refused(struct elf *elf, const char *what)
{
    if (errno == ENOMEM)
        return elf_out_of_memory(elf);
    const char *message = elf_errmsg(-1);
    return image_defect(elf->image, "libelf cannot read the %s: %s", what,
                        message != NULL ? message : "no reason given");
}

size_t elf_record_size(const struct elf *elf, enum elf_record type)
{
    return elf->kind->class == ELFCLASS32 ? records[type].size32 : records[type].size64;
}

/* The index-th record as a 64-bit one. */
static bool widen(Elf_Data *data, enum elf_record type, int index, void *wide)
{
    switch (type) {
    case ELF_RECORD_DYN:
        return gelf_getdyn(data, index, (GElf_Dyn *)wide + index) != NULL;
    case ELF_RECORD_SYM:
        return gelf_getsym(data, index, (GElf_Sym *)wide + index) != NULL;
    case ELF_RECORD_RELA:
        return gelf_getrela(data, index, (GElf_Rela *)wide + index) != NULL;
    case ELF_RECORD_REL:
        return gelf_getrel(data, index, (GElf_Rel *)wide + index) != NULL;
    default:
        ((uint64_t *)wide)[index] = ((const Elf32_Addr *)data->d_buf)[index];
        return true;
    }
}

static const void *widened(struct elf *elf, Elf_Data *data, enum elf_record type, uint64_t count)
{
    /* count * size64 is at most four times the size of a file, which is at most 1 GiB. */
    struct elf_copy *copy = malloc(sizeof *copy + (size_t)count * records[type].size64);
    if (copy == NULL) {
        elf_out_of_memory(elf);
        return NULL;
    }
    copy->next = elf->copies;
    elf->copies = copy;
    for (int i = 0; i < (int)count; i++) {
        errno = 0;
        if (!widen(data, type, i, copy->records)) {
            libelf_refused(elf, "table");
            return NULL;
        }
    }
    return copy->records;
}

const void *elf_records(struct elf *elf, enum elf_record type, uint64_t offset, uint64_t count)
{
    /* The caller has found the range inside the file, so this cannot wrap. */
    size_t size = (size_t)count * elf_record_size(elf, type);
    errno = 0;
    Elf_Data *data = elf_getdata_rawchunk(elf->handle, (int64_t)offset, size, records[type].type);
    if (data == NULL || data->d_buf == NULL || data->d_size != size) {
        libelf_refused(elf, "table");
        return NULL;
    }
    bool wide = records[type].size64 == elf_record_size(elf, type);
    return wide ? data->d_buf : widened(elf, data, type, count);
}

bool elf_section_in_file(const struct elf *elf, const Elf64_Shdr *header)
{
    size_t size = elf->image->size;
    return header->sh_type != SHT_NOBITS && header->sh_offset <= size &&
           header->sh_size <= size - header->sh_offset;
}

static bool section_header(struct elf *elf, size_t index, Elf64_Shdr *header)
{
    errno = 0;
    if (gelf_getshdr(elf_getscn(elf->handle, index), header) != NULL)
        return true;
    return errno == ENOMEM ? elf_out_of_memory(elf) : false;
}

bool elf_section(struct elf *elf, size_t index, Elf64_Shdr *header, const char **name)
{
    Elf64_Shdr table;
    struct elf_strings names;
    *name = NULL;
    if (index >= elf->header.e_shnum || !section_header(elf, index, header))
        return false;
    if (elf->header.e_shstrndx < elf->header.e_shnum &&
        section_header(elf, elf->header.e_shstrndx, &table) && elf_section_in_file(elf, &table) &&
        elf_strings_at(elf->image, table.sh_offset, table.sh_size, &names))
        *name = elf_string(&names, header->sh_name);
    if (*name == NULL)
        *name = "";
    return true;
}

bool elf_strings_at(const struct image *image, uint64_t offset, uint64_t size,
                    struct elf_strings *strings)
{
    strings->text = (const char *)image->bytes + offset;
    strings->size = size;
    return size != 0 && strings->text[size - 1] == '\0';
}

const char *elf_string(const struct elf_strings *strings, uint64_t index)
{
    if (index >= strings->size)
        return NULL;
    const char *text = strings->text + index;
    return strnlen(text, IMAGE_MAX_NAME + 1) <= IMAGE_MAX_NAME ? text : NULL;
}

/* ---- reading ---- */

static void widen_header(const Elf32_Ehdr *from, Elf64_Ehdr *to)
{
    *to = (Elf64_Ehdr){ .e_type = from->e_type,
                        .e_machine = from->e_machine,
                        .e_version = from->e_version,
                        .e_entry = from->e_entry,
                        .e_phoff = from->e_phoff,
                        .e_shoff = from->e_shoff,
                        .e_flags = from->e_flags,
                        .e_ehsize = from->e_ehsize,
                        .e_phentsize = from->e_phentsize,
                        .e_phnum = from->e_phnum,
                        .e_shentsize = from->e_shentsize,
                        .e_shnum = from->e_shnum,
                        .e_shstrndx = from->e_shstrndx };
    memcpy(to->e_ident, from->e_ident, sizeof to->e_ident);
}

static bool read_header(struct elf *elf)
{
    Elf32_Ehdr narrow;
    bool is_narrow = elf->kind->class == ELFCLASS32;
    Elf_Data from = { .d_buf = elf->image->bytes,
                      .d_type = ELF_T_EHDR,
                      .d_version = EV_CURRENT,
                      .d_size = is_narrow ? sizeof narrow : sizeof elf->header };
    Elf_Data to = from;
    to.d_buf = is_narrow ? (void *)&narrow : (void *)&elf->header;
    errno = 0;
    unsigned order = elf->image->bytes[EI_DATA];
    if ((is_narrow ? elf32_xlatetom(&to, &from, order) : elf64_xlatetom(&to, &from, order)) == NULL)
        return libelf_refused(elf, "ELF header");
    if (is_narrow)
        widen_header(&narrow, &elf->header);
    return elf_check_header(elf->image, elf->kind, &elf->header);
}

static bool read_program_headers(struct elf *elf)
{
    size_t count;
    errno = 0;
    if (elf_getphdrnum(elf->handle, &count) != 0 || count != elf->header.e_phnum)
        return libelf_refused(elf, "program headers");
    for (size_t i = 0; i < count; i++) {
        GElf_Phdr ph;
        errno = 0;
        if (gelf_getphdr(elf->handle, (int)i, &ph) == NULL)
            return libelf_refused(elf, "program headers");
        if (!elf_read_segment(elf, i, &ph))
            return false;
    }
    return elf_finish_segments(elf);
}

static void look_for_debug_lines(struct elf *elf)
{
    Elf64_Shdr header;
    const char *name;
    for (size_t i = 1; elf_section(elf, i, &header, &name); i++) {
        bool lines = strcmp(name, ".debug_line") == 0 || strcmp(name, ".zdebug_line") == 0;
        if (lines && header.sh_size != 0 && elf_section_in_file(elf, &header))
            elf->image->has_debug_lines = true;
    }
}

static void read_all(struct elf *elf)
{
    if (!elf_check_ident(elf->image, &elf->kind) || !read_header(elf))
        return;
    errno = 0;
    elf->handle = elf_handle_new(elf->image->bytes, elf->image->size);
    if (elf->handle == NULL) {
        libelf_refused(elf, "file");
        return;
    }
    if (!read_program_headers(elf) || !elf_read_dynamic(elf) || !elf_read_dynamic_symbols(elf) ||
        !elf_read_relocs(elf) || !elf_read_initialisers(elf) || !elf_read_symtab(elf))
        return;
    look_for_debug_lines(elf);
}

static void free_copies(struct elf *elf)
{
    while (elf->copies != NULL) {
        struct elf_copy *next = elf->copies->next;
        free(elf->copies);
        elf->copies = next;
    }
}

int elf_read(struct image *image)
{
    struct elf elf = { .image = image };
    read_all(&elf);
    free(elf.import_of);
    free(elf.exports);
    free_copies(&elf);
    elf_handle_free(elf.handle);
    return elf.error;
}

struct Elf *elf_handle_new(const void *bytes, size_t size)
{
    if (elf_version(EV_CURRENT) == EV_NONE)
        return NULL;
    /* libelf wants a writable pointer and does not write through it. */
    Elf *handle = elf_memory((char *)(uintptr_t)bytes, size);
    if (handle != NULL && elf_kind(handle) == ELF_K_ELF)
        return handle;
    elf_end(handle);
    return NULL;
}

void elf_handle_free(struct Elf *handle)
{
    elf_end(handle);
}
