/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * elf_segments.c - program headers: what is mapped where, and what the file says about its stack,
 * its thread-local storage and the range that becomes read-only.
 */
#include "image/elf.h"

typedef unsigned long long ull;

static uint64_t page_down(uint64_t vaddr)
{
    return vaddr & ~(uint64_t)(IMAGE_PAGE - 1);
}

static uint64_t page_up(uint64_t vaddr)
{
    return page_down(vaddr + IMAGE_PAGE - 1);
}

/* A page to spare, so that rounding up cannot wrap. */
static bool leaves_address_space(const struct elf *elf, const Elf64_Phdr *ph)
{
    uint64_t top = elf->kind->address_max - IMAGE_PAGE;
    return ph->p_memsz > top || ph->p_vaddr > top - ph->p_memsz;
}

static bool check_file_range(const struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    struct image *image = elf->image;
    if (ph->p_offset > image->size || ph->p_filesz > image->size - ph->p_offset)
        return image_defect(image,
                            "program header %zu: p_offset 0x%llx + p_filesz 0x%llx lies outside "
                            "the file of %zu bytes",
                            index, (ull)ph->p_offset, (ull)ph->p_filesz, image->size);
    if (ph->p_filesz > ph->p_memsz)
        return image_defect(image,
                            "program header %zu: p_filesz 0x%llx is larger than p_memsz 0x%llx",
                            index, (ull)ph->p_filesz, (ull)ph->p_memsz);
    if (leaves_address_space(elf, ph))
        return image_defect(image,
                            "program header %zu: p_vaddr 0x%llx + p_memsz 0x%llx runs past the "
                            "end of the address space",
                            index, (ull)ph->p_vaddr, (ull)ph->p_memsz);
    return true;
}

static bool check_alignment(struct image *image, size_t index, const Elf64_Phdr *ph)
{
    if (ph->p_align > 1 && (ph->p_align & (ph->p_align - 1)) != 0)
        return image_defect(image, "program header %zu: p_align 0x%llx is not a power of two",
                            index, (ull)ph->p_align);
    if (ph->p_align > IMAGE_MAX_SPAN)
        return image_defect(image, "program header %zu: p_align 0x%llx, allowed is up to 0x%x",
                            index, (ull)ph->p_align, IMAGE_MAX_SPAN);
    if (ph->p_align > 1 && ((ph->p_vaddr - ph->p_offset) & (ph->p_align - 1)) != 0)
        return image_defect(image,
                            "program header %zu: p_vaddr 0x%llx and p_offset 0x%llx differ modulo "
                            "p_align 0x%llx",
                            index, (ull)ph->p_vaddr, (ull)ph->p_offset, (ull)ph->p_align);
    return true;
}

static unsigned permissions(uint32_t flags)
{
    return (flags & PF_R ? IMAGE_READ : 0u) | (flags & PF_W ? IMAGE_WRITE : 0u) |
           (flags & PF_X ? IMAGE_EXEC : 0u);
}

static bool check_order(struct image *image, size_t index, const struct image_segment *segment)
{
    if (image->segment_count == 0)
        return true;
    const struct image_segment *last = &image->segments[image->segment_count - 1];
    if (segment->vaddr < last->vaddr)
        return image_defect(image,
                            "program header %zu: p_vaddr 0x%llx is below the segment before it "
                            "(0x%llx); segments have to ascend",
                            index, (ull)segment->vaddr, (ull)last->vaddr);
    uint64_t end = last->vaddr + last->mem_size;
    if (segment->vaddr < end)
        return image_defect(image,
                            "program header %zu: p_vaddr 0x%llx overlaps the segment before it "
                            "(0x%llx to 0x%llx)",
                            index, (ull)segment->vaddr, (ull)last->vaddr, (ull)end);
    if (page_down(segment->vaddr) < page_up(end) && segment->perm != last->perm)
        return image_defect(image,
                            "program header %zu: shares the page at 0x%llx with a segment of "
                            "other permissions; memory is protected in pages of 4096 bytes",
                            index, (ull)page_down(segment->vaddr));
    return true;
}

static bool read_load(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    struct image *image = elf->image;
    struct image_segment segment = { .vaddr = ph->p_vaddr,
                                     .mem_size = ph->p_memsz,
                                     .file_size = ph->p_filesz,
                                     .file_offset = ph->p_offset,
                                     .perm = permissions(ph->p_flags) };
    if (!check_file_range(elf, index, ph))
        return false;
    if (ph->p_memsz == 0)
        return true; /* ld leaves one behind for a module without data */
    if (!check_alignment(image, index, ph) || !check_order(image, index, &segment))
        return false;
    if (image->segment_count == 0)
        image->span_begin = page_down(ph->p_vaddr);
    image->span_end = page_up(ph->p_vaddr + ph->p_memsz);
    if (image->span_end - image->span_begin > IMAGE_MAX_SPAN)
        return image_defect(image,
                            "program header %zu: the segments reach from 0x%llx to 0x%llx, "
                            "allowed are 256 MiB",
                            index, (ull)image->span_begin, (ull)image->span_end);
    if (ph->p_align > image->align)
        image->align = ph->p_align;
    if (!image_make_room(&image->segments, image->segment_count, sizeof segment))
        return elf_out_of_memory(elf);
    image->segments[image->segment_count++] = segment;
    return true;
}

static bool read_tls(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    if (elf->image->has_tls)
        return image_defect(elf->image, "program header %zu: a second PT_TLS", index);
    elf->image->has_tls = true;
    elf->image->tls_size = ph->p_memsz;
    return check_file_range(elf, index, ph);
}

static bool read_stack(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    if (elf->image->exec_stack_stated)
        return image_defect(elf->image, "program header %zu: a second PT_GNU_STACK", index);
    elf->image->exec_stack_stated = true;
    elf->image->exec_stack = (ph->p_flags & PF_X) != 0;
    return true;
}

static bool read_relro(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    struct image *image = elf->image;
    if (ph->p_memsz == 0)
        return true;
    if (image->relro_begin != image->relro_end)
        return image_defect(image, "program header %zu: a second PT_GNU_RELRO", index);
    if (leaves_address_space(elf, ph))
        return image_defect(image,
                            "program header %zu: PT_GNU_RELRO 0x%llx + 0x%llx runs past the end "
                            "of the address space",
                            index, (ull)ph->p_vaddr, (ull)ph->p_memsz);
    image->relro_begin = ph->p_vaddr;
    image->relro_end = ph->p_vaddr + ph->p_memsz;
    return true;
}

static bool read_dynamic_header(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    if (elf->has_dynamic)
        return image_defect(elf->image, "program header %zu: a second PT_DYNAMIC", index);
    elf->has_dynamic = true;
    elf->dynamic = *ph;
    return check_file_range(elf, index, ph);
}

static const struct {
    uint32_t type;
    bool (*read)(struct elf *elf, size_t index, const Elf64_Phdr *ph);
} readers[] = {
    { PT_LOAD, read_load },       { PT_DYNAMIC, read_dynamic_header }, { PT_TLS, read_tls },
    { PT_GNU_STACK, read_stack }, { PT_GNU_RELRO, read_relro },
};

bool elf_read_segment(struct elf *elf, size_t index, const Elf64_Phdr *ph)
{
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; i++) {
        if (readers[i].type == ph->p_type)
            return readers[i].read(elf, index, ph);
    }
    return true;
}

/* lld rounds PT_GNU_RELRO up to the end of the last page that its segment touches. */
static bool check_relro(struct image *image)
{
    if (image->relro_begin == image->relro_end)
        return true;
    const struct image_segment *segment = image_segment_at(image, image->relro_begin, 1);
    if (segment == NULL || image->relro_end > page_up(segment->vaddr + segment->mem_size))
        return image_defect(image, "PT_GNU_RELRO 0x%llx to 0x%llx lies in no segment",
                            (ull)image->relro_begin, (ull)image->relro_end);
    return true;
}

/* The dynamic table is found by address when loaded and by offset in the file: both have to mean
 * the same bytes, else the harness would judge another table than the one that counts. */
static bool check_dynamic(struct elf *elf)
{
    const Elf64_Phdr *ph = &elf->dynamic;
    uint64_t offset;
    if (!elf->has_dynamic)
        return image_defect(elf->image, "has no dynamic table (PT_DYNAMIC): it exports nothing; "
                                        "link it with -shared");
    if (!image_file_range(elf->image, ph->p_vaddr, ph->p_filesz, &offset))
        return image_defect(elf->image,
                            "dynamic table (p_vaddr 0x%llx, p_filesz 0x%llx) lies in no segment",
                            (ull)ph->p_vaddr, (ull)ph->p_filesz);
    if (offset != ph->p_offset)
        return image_defect(elf->image,
                            "dynamic table: p_offset says 0x%llx, the segment that holds p_vaddr "
                            "0x%llx says 0x%llx",
                            (ull)ph->p_offset, (ull)ph->p_vaddr, (ull)offset);
    return true;
}

bool elf_finish_segments(struct elf *elf)
{
    struct image *image = elf->image;
    if (image->segment_count == 0)
        return image_defect(image, "has no loadable segment (PT_LOAD): nothing to map");
    if (image->align < IMAGE_PAGE)
        image->align = IMAGE_PAGE;
    if (!image->exec_stack_stated)
        image->exec_stack = true;
    return check_relro(image) && check_dynamic(elf);
}
