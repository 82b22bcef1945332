/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_dynamic.c - the dynamic table: where everything else is, and which files it wants.
 */
#include "image/elf.h"

typedef unsigned long long ull;

static const struct {
    int64_t tag;
    const char *name;
} elf_tags[ELF_TAGS] = {
    [ELF_STRTAB] = { DT_STRTAB, "DT_STRTAB" },
    [ELF_STRSZ] = { DT_STRSZ, "DT_STRSZ" },
    [ELF_SYMTAB] = { DT_SYMTAB, "DT_SYMTAB" },
    [ELF_SYMENT] = { DT_SYMENT, "DT_SYMENT" },
    [ELF_HASH] = { DT_HASH, "DT_HASH" },
    [ELF_GNU_HASH] = { DT_GNU_HASH, "DT_GNU_HASH" },
    [ELF_RELA] = { DT_RELA, "DT_RELA" },
    [ELF_RELASZ] = { DT_RELASZ, "DT_RELASZ" },
    [ELF_RELAENT] = { DT_RELAENT, "DT_RELAENT" },
    [ELF_REL] = { DT_REL, "DT_REL" },
    [ELF_RELSZ] = { DT_RELSZ, "DT_RELSZ" },
    [ELF_RELENT] = { DT_RELENT, "DT_RELENT" },
    [ELF_JMPREL] = { DT_JMPREL, "DT_JMPREL" },
    [ELF_PLTRELSZ] = { DT_PLTRELSZ, "DT_PLTRELSZ" },
    [ELF_PLTREL] = { DT_PLTREL, "DT_PLTREL" },
    [ELF_RELR] = { DT_RELR, "DT_RELR" },
    [ELF_RELRSZ] = { DT_RELRSZ, "DT_RELRSZ" },
    [ELF_RELRENT] = { DT_RELRENT, "DT_RELRENT" },
    [ELF_INIT] = { DT_INIT, "DT_INIT" },
    [ELF_FINI] = { DT_FINI, "DT_FINI" },
    [ELF_INIT_ARRAY] = { DT_INIT_ARRAY, "DT_INIT_ARRAY" },
    [ELF_INIT_ARRAYSZ] = { DT_INIT_ARRAYSZ, "DT_INIT_ARRAYSZ" },
    [ELF_FINI_ARRAY] = { DT_FINI_ARRAY, "DT_FINI_ARRAY" },
    [ELF_FINI_ARRAYSZ] = { DT_FINI_ARRAYSZ, "DT_FINI_ARRAYSZ" },
    [ELF_PREINIT_ARRAY] = { DT_PREINIT_ARRAY, "DT_PREINIT_ARRAY" },
    [ELF_PREINIT_ARRAYSZ] = { DT_PREINIT_ARRAYSZ, "DT_PREINIT_ARRAYSZ" },
    [ELF_VERSYM] = { DT_VERSYM, "DT_VERSYM" },
    [ELF_VERNEED] = { DT_VERNEED, "DT_VERNEED" },
    [ELF_VERDEF] = { DT_VERDEF, "DT_VERDEF" },
    [ELF_FLAGS_1] = { DT_FLAGS_1, "DT_FLAGS_1" },
};

/* Tags that name another file. */
static const struct {
    int64_t tag;
    enum image_import_kind kind;
    const char *name;
} library_tags[] = {
    { DT_NEEDED, IMAGE_IMPORT_LIBRARY, "DT_NEEDED" },
    { DT_FILTER, IMAGE_IMPORT_FILTER, "DT_FILTER" },
    { DT_AUXILIARY, IMAGE_IMPORT_FILTER, "DT_AUXILIARY" },
    { DT_AUDIT, IMAGE_IMPORT_FILTER, "DT_AUDIT" },
    { DT_DEPAUDIT, IMAGE_IMPORT_FILTER, "DT_DEPAUDIT" },
};

/* Relocations in Android's packed form would stay unseen: better no module than one whose
 * relocations nobody judged. */
enum { DT_ANDROID_REL = 0x6000000f, DT_ANDROID_RELA = 0x60000011, DT_ANDROID_RELR = 0x6fffe000 };

const char *elf_tag_name(enum elf_tag tag)
{
    return elf_tags[tag].name;
}

const void *elf_table(struct elf *elf, enum elf_record type, enum elf_tag tag, uint64_t count)
{
    uint64_t vaddr = elf->tag[tag], offset;
    uint64_t size = elf_record_size(elf, type);
    if (count <= elf->image->size / size &&
        image_file_range(elf->image, vaddr, count * size, &offset))
        return elf_records(elf, type, offset, count);
    image_defect(elf->image,
                 "%s: %llu entries of %llu bytes at 0x%llx do not lie in the file's part of one "
                 "segment",
                 elf_tag_name(tag), (ull)count, (ull)size, (ull)vaddr);
    return NULL;
}

bool elf_add_import(struct elf *elf, enum image_import_kind kind, const char *name)
{
    struct image *image = elf->image;
    if (image->import_count == IMAGE_MAX_IMPORTS)
        return image_defect(image, "has more than %u imports", IMAGE_MAX_IMPORTS);
    if (!image_make_room(&image->imports, image->import_count, sizeof image->imports[0]))
        return elf_out_of_memory(elf);
    image->imports[image->import_count++] = (struct image_import){ .kind = kind, .name = name };
    return true;
}

static bool read_tag(struct elf *elf, const Elf64_Dyn *dyn)
{
    for (unsigned i = 0; i < ELF_TAGS; i++) {
        if (elf_tags[i].tag != dyn->d_tag)
            continue;
        if (elf->has_tag[i])
            return image_defect(elf->image,
                                "%s is stated twice (0x%llx and 0x%llx), allowed is once",
                                elf_tags[i].name, (ull)elf->tag[i], (ull)dyn->d_un.d_val);
        elf->has_tag[i] = true;
        elf->tag[i] = dyn->d_un.d_val;
    }
    if (dyn->d_tag == DT_ANDROID_REL || dyn->d_tag == DT_ANDROID_RELA ||
        dyn->d_tag == DT_ANDROID_RELR)
        return image_defect(elf->image,
                            "has packed Android relocations (dynamic tag 0x%llx); allowed are "
                            "DT_RELA, DT_REL, DT_JMPREL and DT_RELR",
                            (ull)dyn->d_tag);
    return true;
}

static bool read_tags(struct elf *elf, const Elf64_Dyn *dyn, uint64_t count, uint64_t *used)
{
    for (uint64_t i = 0; i < count; i++) {
        if (dyn[i].d_tag == DT_NULL) {
            *used = i;
            return true;
        }
        if (!read_tag(elf, &dyn[i]))
            return false;
    }
    return image_defect(elf->image, "dynamic table of %llu entries has no end mark (DT_NULL)",
                        (ull)count);
}

static bool check_entry_sizes(struct elf *elf)
{
    static const struct {
        enum elf_tag tag;
        enum elf_record record;
    } sizes[] = {
        { ELF_SYMENT, ELF_RECORD_SYM },
        { ELF_RELAENT, ELF_RECORD_RELA },
        { ELF_RELENT, ELF_RECORD_REL },
        { ELF_RELRENT, ELF_RECORD_ADDRESS },
    };
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        enum elf_tag tag = sizes[i].tag;
        size_t size = elf_record_size(elf, sizes[i].record);
        if (elf->has_tag[tag] && elf->tag[tag] != size)
            return image_defect(elf->image, "%s is %llu, allowed is %zu", elf_tags[tag].name,
                                (ull)elf->tag[tag], size);
    }
    return true;
}

static bool read_strings(struct elf *elf)
{
    static const enum elf_tag wanted[] = { ELF_STRTAB, ELF_STRSZ, ELF_SYMTAB };
    uint64_t vaddr = elf->tag[ELF_STRTAB], size = elf->tag[ELF_STRSZ], offset;
    for (size_t i = 0; i < sizeof wanted / sizeof wanted[0]; i++) {
        if (!elf->has_tag[wanted[i]])
            return image_defect(elf->image, "dynamic table has no %s", elf_tags[wanted[i]].name);
    }
    if (!image_file_range(elf->image, vaddr, size, &offset))
        return image_defect(elf->image,
                            "string table (DT_STRTAB 0x%llx, DT_STRSZ 0x%llx) does not lie in the "
                            "file's part of one segment",
                            (ull)vaddr, (ull)size);
    if (!elf_strings_at(elf->image, offset, size, &elf->dynstr))
        return image_defect(elf->image,
                            "string table (DT_STRTAB 0x%llx, DT_STRSZ 0x%llx) does not "
                            "end in a zero byte",
                            (ull)vaddr, (ull)size);
    return true;
}

static bool read_libraries(struct elf *elf, const Elf64_Dyn *dyn, uint64_t count)
{
    for (uint64_t i = 0; i < count; i++) {
        for (size_t k = 0; k < sizeof library_tags / sizeof library_tags[0]; k++) {
            if (library_tags[k].tag != dyn[i].d_tag)
                continue;
            const char *name = elf_string(&elf->dynstr, dyn[i].d_un.d_val);
            if (name == NULL)
                return image_defect(elf->image,
                                    "%s: name at 0x%llx is outside the string table of 0x%llx "
                                    "bytes or longer than %u",
                                    library_tags[k].name, (ull)dyn[i].d_un.d_val,
                                    (ull)elf->dynstr.size, IMAGE_MAX_NAME);
            if (!elf_add_import(elf, library_tags[k].kind, name))
                return false;
        }
    }
    return true;
}

bool elf_read_dynamic(struct elf *elf)
{
    uint64_t count = elf->dynamic.p_filesz / elf_record_size(elf, ELF_RECORD_DYN), used = 0;
    if (count == 0)
        return image_defect(elf->image, "dynamic table of 0x%llx bytes has no entry",
                            (ull)elf->dynamic.p_filesz);
    const Elf64_Dyn *dyn = elf_records(elf, ELF_RECORD_DYN, elf->dynamic.p_offset, count);
    if (dyn == NULL || !read_tags(elf, dyn, count, &used))
        return false;
    if (elf->has_tag[ELF_FLAGS_1] && (elf->tag[ELF_FLAGS_1] & DF_1_PIE) != 0)
        return image_defect(elf->image, "a position-independent executable, not a module "
                                        "(DT_FLAGS_1 has DF_1_PIE); link it with -shared");
    return check_entry_sizes(elf) && read_strings(elf) && read_libraries(elf, dyn, used);
}
