/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * load.c - a module from its image into memory, as TG Motion does it: map, relocate relatively,
 * protect. Nothing is resolved, nothing is run.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/personality.h>
#include <unistd.h>

#include "machine/machine_private.h"

#define HWCAP2_FSGSBASE_BIT (1ul << 1)
#define TRAP_FILL           0xcc /* int3 */

int machine_fail(char why[MACHINE_WHY], int error, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, MACHINE_WHY, format, arguments);
    va_end(arguments);
    return error;
}

static int check_image(const struct image *image, char why[MACHINE_WHY])
{
    uint64_t span = image->span_end - image->span_begin;

    if (image->defect[0] != '\0')
        return machine_fail(why, -ENOEXEC, "%s", image->defect);
    if (image->format != IMAGE_FORMAT_ELF64 || image->target != IMAGE_TARGET_X86_64)
        return machine_fail(why, -ENOEXEC,
                            "only ELF64 modules for x86-64 run natively, this is %s %s",
                            image->format_name, image->target_name);
    if (image->span_begin >= image->span_end || (image->span_begin | image->span_end) % PAGE != 0)
        return machine_fail(why, -ENOEXEC, "nothing to map");
    if (span > HULL_LIMIT)
        return machine_fail(why, -EFBIG,
                            "the segments span %llu bytes of memory, at most %llu are mapped",
                            (unsigned long long)span, (unsigned long long)HULL_LIMIT);
    return 0;
}

/* Otherwise every readable page would be executable. */
static int check_process(char why[MACHINE_WHY])
{
    int persona = personality(0xffffffff);

    if (machine_incident.machine != NULL)
        return machine_fail(why, -EBUSY, "this process has loaded a module already");
    if (persona != -1 && (persona & READ_IMPLIES_EXEC))
        return machine_fail(why, -ENOTSUP, "the process runs with READ_IMPLIES_EXEC");
    return 0;
}

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

/* Protection page by page: segments may share one. A segment that is writable and executable is
 * mapped so, as a controller would: that it must not be is a rule's business, and nothing it holds
 * can do more than other module code. A page that code and data merely share is not writable. */
static void plan_access(struct machine *machine, const struct image *image)
{
    uint64_t first = first_page(image->span_begin);
    uint64_t count = first_page(image->span_end) - first;

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
static void fill_slack(const struct machine *machine)
{
    size_t count = (machine->span_end - machine->span_begin) / PAGE;

    for (size_t page = 0; page < count; page++)
        if (machine->page_access[page] & PROT_EXEC)
            memset(machine->hull + page * PAGE, TRAP_FILL, PAGE);
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

static void relocate(const struct machine *machine, const struct image *image)
{
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *reloc = &image->relocs[i];
        uint64_t value = (uint64_t)machine_address(machine, (uint64_t)reloc->addend);

        if (reloc->kind == IMAGE_RELOC_RELATIVE)
            memcpy(machine_address(machine, reloc->vaddr), &value, sizeof value);
    }
}

static int map_image(struct machine *machine, const struct image *image, char why[MACHINE_WHY])
{
    struct machine_region *region = machine_region_add(machine, "module");
    size_t span = image->span_end - image->span_begin;
    int error = machine_reserve(&region->around, machine_place_seed(machine), machine->region_count,
                                span + 2 * HULL_GUARD);

    if (error != 0)
        return machine_fail(why, error, "no address space for the module: %s", strerror(-error));
    machine->region_count++;
    machine->hull = region->around.base + HULL_GUARD;
    machine->span_begin = image->span_begin;
    machine->span_end = image->span_end;
    region->start = (uint64_t)machine->hull;
    region->size = span;

    machine->page_access = calloc(span / PAGE, 1);
    if (machine->page_access == NULL)
        return machine_fail(why, -ENOMEM, "no memory for the module's page table");
    plan_access(machine, image);
    error = protect(machine, true);
    if (error == 0) {
        fill_slack(machine);
        copy_segments(machine, image);
        if (machine->config.poison)
            machine_poison(image, machine->hull, machine->config.poison, machine->config.seed);
        relocate(machine, image);
        error = protect(machine, false);
    }
    return error == 0 ? 0
                      : machine_fail(why, error, "no memory for the module: %s", strerror(-error));
}

/* The module starts every call with the same callee-saved registers: no host address leaks in, and
 * a change is noticed. No canonical address, so that using one as a pointer faults. */
static void prepare_state(const struct machine *machine)
{
    struct machine_state fresh = { .has_fsgsbase = 0 };

    fresh.serial = machine_state.serial;
    for (unsigned i = 0; i < 6; i++)
        fresh.sentinel[i] =
            (machine_mix(machine->config.seed, 2, i) & 0x0000ffffffffffffu) | 0x5e00000000000000u;
    fresh.stack_top = machine_stack_top(machine, machine->stack);
    fresh.has_fsgsbase = (getauxval(AT_HWCAP2) & HWCAP2_FSGSBASE_BIT) != 0;
    __asm__("mov %%fs:0, %0" : "=r"(fresh.host_fs)); /* thread control block: points to itself */
    machine_state = fresh;
}

int machine_load(struct machine **out, const struct image *image,
                 const struct machine_config *config, char why[MACHINE_WHY])
{
    struct machine *machine;
    int error;

    *out = NULL;
    why[0] = '\0';
    error = check_image(image, why);
    if (error == 0)
        error = check_process(why);
    if (error != 0)
        return error;
    machine = calloc(1, sizeof *machine);
    if (machine == NULL)
        return machine_fail(why, -ENOMEM, "no memory");
    machine->config = *config;
    machine->process = getpid();
    if (machine->config.stack_size == 0)
        machine->config.stack_size = DEFAULT_STACK;
    if (machine->config.hang_ns == 0)
        machine->config.hang_ns = DEFAULT_HANG_NS;

    error = map_image(machine, image, why);
    if (error == 0)
        error = machine_map_stacks(machine, why);
    if (error == 0)
        error = machine_levels_open(machine, why);
    if (error == 0)
        error = machine_copy_keep(machine, why);
    if (error == 0) {
        prepare_state(machine);
        machine_incident = (struct machine_incident){ .machine = machine };
        error = machine_handlers_install(machine, why);
    }
    if (error == 0)
        error = machine_watchdog_start(machine, why);
    if (error != 0) {
        machine_unload(machine);
        return error;
    }
    *out = machine;
    return 0;
}

void machine_unload(struct machine *machine)
{
    if (machine == NULL)
        return;
    machine_watchdog_stop(machine);
    machine_levels_close(machine);
    machine_handlers_remove(machine);
    if (machine_incident.machine == machine)
        machine_incident.machine = NULL;
    machine_regions_release(machine);
    if (!machine->sealed)
        machine_release(&machine->signal_stack);
    machine_release(&machine->copy);
    free(machine->page_access);
    free(machine);
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
