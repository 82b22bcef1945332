/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * load.c - a module from its image into memory, as TG Motion does it: map, relocate relatively,
 * protect. Nothing is resolved, nothing is run. The same for every machine and every target.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "machine/machine_private.h"

/* A byte that is no instruction to go on from, repeated: int3, udf (Thumb), undefined (Arm). */
#define TRAP_FILL_X86 0xcc
#define TRAP_FILL_ARM 0xde

static uint64_t first_page(uint64_t vaddr)
{
    return vaddr / PAGE;
}

static uint64_t end_page(uint64_t vaddr)
{
    return vaddr / PAGE + (vaddr % PAGE != 0);
}

#define PAGE_BOTH                                                                                  \
    0x80 /* in page_access while it is planned: one segment wants it written and executed */

/* The memory of a flat image goes on behind what its file fills. */
static uint64_t span_end_of(const struct image *image)
{
    return image->format == IMAGE_FORMAT_FLAT ? IMAGE_FLAT_BASE + IMAGE_FLAT_REGION
                                              : image->span_end;
}

/* Protection page by page: segments may share one. A segment that is writable and executable is
 * mapped so, as a controller would: that it must not be is a rule's business, and nothing it holds
 * can do more than other module code. A page that code and data merely share is not writable. */
static void plan_access(struct machine *machine, const struct image *image)
{
    uint64_t first = first_page(image->span_begin);
    uint64_t count = first_page(machine->span_end) - first;

    if (image->format == IMAGE_FORMAT_FLAT) {
        const uint64_t file = end_page(image->span_begin + image->size) - first;

        for (uint64_t page = 0; page < count; page++)
            machine->page_access[page] =
                (uint8_t)(PROT_READ | PROT_WRITE | (page < file ? PROT_EXEC : 0));
        return;
    }

    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        uint8_t access = PROT_READ;

        if (segment->mem_size == 0)
            continue;
        if (segment->perm & IMAGE_WRITE)
            access |= PROT_WRITE;
        if (segment->perm & IMAGE_EXEC)
            access |= PROT_EXEC;
        if ((segment->perm & IMAGE_WRITE) && (segment->perm & IMAGE_EXEC))
            access |= PAGE_BOTH;
        for (uint64_t page = first_page(segment->vaddr);
             page < end_page(segment->vaddr + segment->mem_size); page++)
            machine->page_access[page - first] |= access;
    }
    /* Rounded down at both ends, as the dynamic linker does. */
    if (image->relro_begin < image->relro_end)
        for (uint64_t page = first_page(image->relro_begin); page < first_page(image->relro_end);
             page++)
            if (page - first < count)
                machine->page_access[page - first] &= (uint8_t)~PROT_WRITE;
    for (uint64_t page = 0; page < count; page++) {
        uint8_t *access = &machine->page_access[page];

        if ((*access & PROT_EXEC) && !(*access & PAGE_BOTH))
            *access &= (uint8_t)~PROT_WRITE;
        *access &= (uint8_t)~PAGE_BOTH;
    }
}

/* Applies the plan, or opens every planned page for filling. */
static int protect(const struct machine *machine, bool filling)
{
    size_t count = (machine->span_end - machine->span_begin) / PAGE;

    for (size_t page = 0, run; page < count; page += run) {
        int access = machine->page_access[page];

        for (run = 1; page + run < count && machine->page_access[page + run] == access; run++)
            ;
        if (access != 0 && filling)
            access = PROT_READ | PROT_WRITE;
        if (mprotect(machine->hull + page * PAGE, run * PAGE, access) != 0)
            return -errno;
    }
    return 0;
}

/* What belongs to an executable page but to no segment must not run on as if it were code. */
static void fill_slack(const struct machine *machine, const struct image *image)
{
    const int fill = image->target == IMAGE_TARGET_ARM ? TRAP_FILL_ARM : TRAP_FILL_X86;
    size_t count = (machine->span_end - machine->span_begin) / PAGE;

    for (size_t page = 0; page < count; page++)
        if (machine->page_access[page] & PROT_EXEC)
            memset(machine->hull + page * PAGE, fill, PAGE);
}

static void copy_segments(const struct machine *machine, const struct image *image)
{
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        uint8_t *at = machine->hull + (segment->vaddr - image->span_begin);

        if (segment->file_size != 0)
            memcpy(at, image->bytes + segment->file_offset, segment->file_size);
        if (segment->perm & IMAGE_EXEC)
            memset(at + segment->file_size, 0, segment->mem_size - segment->file_size);
    }
}

/* A word becomes load address + addend, in as many bytes as it has. */
static void relocate(const struct machine *machine, const struct image *image)
{
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *reloc = &image->relocs[i];
        uint64_t value = (uint64_t)machine_address(machine, (uint64_t)reloc->addend);

        if (reloc->kind == IMAGE_RELOC_RELATIVE)
            memcpy(machine_address(machine, reloc->vaddr), &value,
                   reloc->width < sizeof value ? reloc->width : sizeof value);
    }
}

/* Where the module shall lie: its own choice when it runs nowhere else, ours otherwise. */
static int reserve_hull(struct machine *machine, const struct image *image,
                        struct machine_reservation *around, char why[MACHINE_WHY])
{
    const size_t size = span_end_of(image) - image->span_begin + 2 * HULL_GUARD;
    const uint64_t wanted = image->base + image->span_begin - HULL_GUARD;
    int error;

    if (!image->fixed) {
        error = machine_reserve(around, machine_place_seed(machine), machine->region_count,
                                machine->low, size);
        return error == 0 ? 0
                          : machine_fail(why, error, "no address space for the module: %s",
                                         strerror(-error));
    }
    error = machine_reserve_at(around, wanted, size);
    return error == 0 ? 0
                      : machine_fail(why, error,
                                     "the module runs at 0x%llx only, and that place is "
                                     "taken: %s",
                                     (unsigned long long)(image->base + image->span_begin),
                                     strerror(-error));
}

int machine_map_image(struct machine *machine, const struct image *image, char why[MACHINE_WHY])
{
    struct machine_region *region = machine_region_add(machine, "module");
    size_t span = span_end_of(image) - image->span_begin;
    int error = reserve_hull(machine, image, &region->around, why);

    if (error != 0)
        return error;
    machine->region_count++;
    machine->hull = region->around.base + HULL_GUARD;
    machine->span_begin = image->span_begin;
    machine->span_end = machine->span_begin + span;
    region->start = (uint64_t)machine->hull;
    region->size = span;

    machine->page_access = calloc(span / PAGE, 1);
    if (machine->page_access == NULL)
        return machine_fail(why, -ENOMEM, "no memory for the module's page table");
    plan_access(machine, image);
    error = protect(machine, true);
    if (error == 0) {
        fill_slack(machine, image);
        copy_segments(machine, image);
        if (machine->config.poison)
            machine_poison(image, machine->hull, machine->config.poison, machine->config.seed);
        relocate(machine, image);
        error = protect(machine, false);
    }
    return error == 0 ? 0
                      : machine_fail(why, error, "no memory for the module: %s", strerror(-error));
}

void *machine_address(const struct machine *machine, uint64_t vaddr)
{
    return (void *)((uint64_t)machine->hull + (vaddr - machine->span_begin));
}

bool machine_vaddr(const struct machine *machine, const void *address, uint64_t *vaddr)
{
    uint64_t offset = (uint64_t)address - (uint64_t)machine->hull;

    if (offset >= machine->span_end - machine->span_begin)
        return false;
    *vaddr = machine->span_begin + offset;
    return true;
}
