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
    size_t size;
} records[ELF_RECORDS] = {
    [ELF_RECORD_DYN] = { ELF_T_DYN, sizeof(Elf64_Dyn) },
    [ELF_RECORD_SYM] = { ELF_T_SYM, sizeof(Elf64_Sym) },
    [ELF_RECORD_RELA] = { ELF_T_RELA, sizeof(Elf64_Rela) },
    [ELF_RECORD_REL] = { ELF_T_REL, sizeof(Elf64_Rel) },
    [ELF_RECORD_WORD] = { ELF_T_WORD, sizeof(Elf64_Word) },
    [ELF_RECORD_XWORD] = { ELF_T_XWORD, sizeof(Elf64_Xword) },
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

size_t elf_record_size(enum elf_record type)
{
    return records[type].size;
}

const void *elf_records(struct elf *elf, enum elf_record type, uint64_t offset, uint64_t count)
{
    /* The caller has found the range inside the file, so this cannot wrap. */
    errno = 0;
    Elf_Data *data = elf_getdata_rawchunk(elf->handle, (int64_t)offset,
                                          (size_t)count * records[type].size, records[type].type);
    if (data != NULL && data->d_buf != NULL && data->d_size == count * records[type].size)
        return data->d_buf;
    libelf_refused(elf, "table");
    return NULL;
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
    return strnlen(text, ELF_MAX_NAME + 1) <= ELF_MAX_NAME ? text : NULL;
}

/* ---- reading ---- */

static bool read_header(struct elf *elf)
{
    Elf_Data from = { .d_buf = elf->image->bytes,
                      .d_type = ELF_T_EHDR,
                      .d_version = EV_CURRENT,
                      .d_size = sizeof elf->header };
    Elf_Data to = from;
    to.d_buf = &elf->header;
    errno = 0;
    if (elf64_xlatetom(&to, &from, elf->image->bytes[EI_DATA]) == NULL)
        return libelf_refused(elf, "ELF header");
    return elf_check_header(elf->image, &elf->header);
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
    if (!elf_check_ident(elf->image) || !read_header(elf))
        return;
    errno = 0;
    elf->handle = elf_handle_new(elf->image);
    if (elf->handle == NULL) {
        libelf_refused(elf, "file");
        return;
    }
    if (!read_program_headers(elf) || !elf_read_dynamic(elf) || !elf_read_dynamic_symbols(elf) ||
        !elf_read_relocs(elf) || !elf_read_initialisers(elf) || !elf_read_symtab(elf))
        return;
    look_for_debug_lines(elf);
}

int elf_read(struct image *image)
{
    struct elf elf = { .image = image };
    read_all(&elf);
    free(elf.import_of);
    free(elf.exports);
    elf_handle_free(elf.handle);
    return elf.error;
}

struct Elf *elf_handle_new(const struct image *image)
{
    if (elf_version(EV_CURRENT) == EV_NONE)
        return NULL;
    /* libelf wants a writable pointer and does not write through it. */
    Elf *handle = elf_memory((char *)image->bytes, image->size);
    if (handle != NULL && elf_kind(handle) == ELF_K_ELF)
        return handle;
    elf_end(handle);
    return NULL;
}

void elf_handle_free(struct Elf *handle)
{
    elf_end(handle);
}
