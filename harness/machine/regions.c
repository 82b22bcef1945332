/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * regions.c - address space: where things go, what is around them, and what an address belongs to.
 *
 * Places are drawn from a part of the address space that Linux leaves empty (between the
 * executable's and the libraries' ends of it, clear also of the sanitizers' shadows), so that the
 * same seed finds the same places free every time.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <string.h>
#include <sys/mman.h>

#include "machine/machine_private.h"

#ifndef MAP_FIXED_NOREPLACE
#define MAP_FIXED_NOREPLACE 0x100000
#endif

#define PLACES_BEGIN   (1ull << 45)
#define PLACES_SIZE    (1ull << 45)
#define LOW_BEGIN      0x10000000ull /* above the place of flat images */
#define LOW_SIZE       0x6f000000ull /* the address sanitizer's shadow begins at 2 GiB */
#define PLACES_ORDINAL 0x706c61636573u
#define PLACE_TRIES    64

/* splitmix64 over a point in three dimensions. */
uint64_t machine_mix(uint64_t seed, uint64_t a, uint64_t b)
{
    uint64_t x = seed + a * 0x9e3779b97f4a7c15u + b * 0xd1b54a32d192ed03u + 0x2545f4914f6cdd1du;

    for (int round = 0; round < 2; round++) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        x ^= x >> 31;
    }
    return x;
}

static size_t page_up(size_t size)
{
    return (size + PAGE - 1) & ~(size_t)(PAGE - 1);
}

/* Reserves at address, which the kernel may take as a hint only when it is old. */
static bool reserve_at(struct machine_reservation *out, uint64_t address, size_t size)
{
    void *base = mmap((void *)address, size, PROT_NONE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE, -1, 0);

    if (base == MAP_FAILED)
        return false;
    if ((uint64_t)base != address) {
        munmap(base, size);
        errno = EEXIST;
        return false;
    }
    *out = (struct machine_reservation){ base, size };
    return true;
}

uint64_t machine_place_seed(const struct machine *machine)
{
    const struct machine_config *config = &machine->config;

    return config->places == 0 ? config->seed
                               : machine_mix(config->seed, PLACES_ORDINAL, config->places);
}

/*
 * Reserves size bytes at the first free place of a sequence that seed and ordinal determine. Never
 * across a multiple of 4 GiB: the system call filter compares only the lower half of an address.
 */
int machine_reserve(struct machine_reservation *out, uint64_t seed, unsigned ordinal, bool low,
                    size_t size)
{
    const uint64_t begin = low ? LOW_BEGIN : PLACES_BEGIN;
    const uint64_t room = low ? LOW_SIZE : PLACES_SIZE + size;

    if (size >= room)
        return -ENOMEM;
    for (unsigned attempt = 0; attempt < PLACE_TRIES; attempt++) {
        uint64_t places = (room - size) / PLACE_ALIGN;
        uint64_t address = begin + machine_mix(seed, ordinal, attempt) % places * PLACE_ALIGN;

        if (address >> 32 != (address + size) >> 32)
            continue;
        if (reserve_at(out, address, size))
            return 0;
        if (errno != EEXIST)
            return -errno;
    }
    return -EADDRINUSE;
}

int machine_reserve_at(struct machine_reservation *out, uint64_t address, size_t size)
{
    if (address >> 32 != (address + size) >> 32)
        return -EADDRNOTAVAIL;
    return reserve_at(out, address, size) ? 0 : -errno;
}

void machine_release(struct machine_reservation *reservation)
{
    if (reservation->size != 0)
        munmap(reservation->base, reservation->size);
    *reservation = (struct machine_reservation){ NULL, 0 };
}

/* The next free row of the table, not counted yet; NULL when the table is full or the name bad. */
struct machine_region *machine_region_add(struct machine *machine, const char *name)
{
    struct machine_region *region = &machine->regions[machine->region_count];

    if (machine->region_count == MAX_REGIONS || strlen(name) >= sizeof region->name)
        return NULL;
    memset(region, 0, sizeof *region);
    strcpy(region->name, name);
    return region;
}

int machine_region_done(struct machine *machine, uint8_t *pages, size_t size,
                        enum machine_region_access access, char why[MACHINE_WHY])
{
    const struct machine_region *region = &machine->regions[machine->region_count++];

    return machine->ops->mapped != NULL
               ? machine->ops->mapped(machine, region, pages, size, access, why)
               : 0;
}

static int map_stack(struct machine *machine, uint8_t **stack, char why[MACHINE_WHY])
{
    struct machine_region *region = machine_region_add(machine, "stack");
    size_t size = page_up(machine->config.stack_size);
    int error;

    if (size > STACK_LIMIT)
        return machine_fail(why, -EFBIG, "module stack of %zu bytes is too large", size);
    error = machine_reserve(&region->around, machine_place_seed(machine), machine->region_count,
                            machine->low, HULL_GUARD + size + REGION_GUARD);
    if (error != 0)
        return machine_fail(why, error, "no address space for the module stack: %s",
                            strerror(-error));
    *stack = region->around.base + HULL_GUARD;
    machine->stack_size = size;
    region->start = (uint64_t)*stack;
    region->size = size;
    if (mprotect(*stack, size, PROT_READ | PROT_WRITE) != 0)
        error = machine_fail(why, -errno, "no memory for the module stack: %s", strerror(errno));
    machine->region_count++;
    return error;
}

void machine_fill_stacks(struct machine *machine)
{
    for (unsigned level = 0; level < machine->level_count; level++)
        for (size_t i = 0; i < machine->stack_size; i += sizeof machine->stack_pattern)
            memcpy(machine->levels[level].stack + i, &machine->stack_pattern,
                   sizeof machine->stack_pattern);
}

int machine_map_stacks(struct machine *machine, char why[MACHINE_WHY])
{
    const bool several = machine->config.interruptible || machine->config.asides;
    const unsigned wanted = several ? MACHINE_LEVELS : 1;
    int error = 0;

    for (unsigned level = 0; level < wanted && error == 0; level++)
        error = map_stack(machine, &machine->levels[level].stack, why);
    if (error != 0)
        return error;
    machine->level_count = machine->levels_left = wanted;
    for (unsigned level = 0; level < wanted; level++)
        machine->order[level] = level;
    machine->stack = machine->levels[0].stack;
    machine->stack_pattern = machine_mix(machine->config.seed, 1, UINT64_MAX);
    machine_fill_stacks(machine);
    return 0;
}

/* One page range seen twice: by the module, read-only, and by the host, anywhere, between guards.
 */
static int map_twice(struct machine_region *region, uint8_t *module, size_t pages, uint8_t **host)
{
    uint8_t *base = mmap(NULL, pages + 2 * REGION_GUARD, PROT_NONE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);

    if (base == MAP_FAILED)
        return -errno;
    region->host = (struct machine_reservation){ base, pages + 2 * REGION_GUARD };
    *host = base + REGION_GUARD;
    if (mmap(*host, pages, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_FIXED, -1, 0) ==
        MAP_FAILED)
        return -errno;
    /* mremap() of nothing makes a second mapping of shared pages. */
    if (mremap(*host, 0, pages, MREMAP_MAYMOVE | MREMAP_FIXED, module) == MAP_FAILED)
        return -errno;
    return mprotect(module, pages, PROT_READ) != 0 ? -errno : 0;
}

static int map_once(uint8_t *module, size_t pages, uint8_t **host)
{
    *host = module;
    return mprotect(module, pages, PROT_READ | PROT_WRITE) != 0 ? -errno : 0;
}

static int check_region(const struct machine *machine, const struct machine_region *region,
                        const char *name, size_t size, char why[MACHINE_WHY])
{
    if (machine->sealed)
        return machine_fail(why, -EPERM, "%s: memory cannot be mapped after machine_seal()", name);
    if (region == NULL)
        return machine_fail(why, -EINVAL, "%s: name too long, or more than %d regions", name,
                            MAX_REGIONS);
    if (size == 0 || size > REGION_LIMIT)
        return machine_fail(why, -EINVAL, "%s: %zu bytes cannot be mapped", name, size);
    return 0;
}

int machine_map_shared(struct machine *machine, const char *name, size_t size, int fd,
                       void **memory, char why[MACHINE_WHY])
{
    struct machine_region *region = machine_region_add(machine, name);
    const size_t pages = page_up(size);
    int error = check_region(machine, region, name, size, why);

    if (error != 0)
        return error;
    error = machine_reserve(&region->around, machine_place_seed(machine), machine->region_count,
                            machine->low, pages + 2 * REGION_GUARD);
    if (error == 0) {
        *memory = region->around.base + REGION_GUARD;
        if (mmap(*memory, pages, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, fd, 0) ==
            MAP_FAILED)
            error = -errno;
    }
    if (error != 0) {
        machine_release(&region->around);
        return machine_fail(why, error, "%s: cannot map %zu bytes: %s", name, size,
                            strerror(-error));
    }
    region->start = (uint64_t)*memory;
    region->size = size;
    return machine_region_done(machine, *memory, pages, MACHINE_REGION_READ_WRITE, why);
}

int machine_map(struct machine *machine, const char *name, size_t size,
                enum machine_region_access access, void **host, void **module,
                char why[MACHINE_WHY])
{
    struct machine_region *region = machine_region_add(machine, name);
    size_t rounded = (size + 15) & ~(size_t)15, pages = page_up(rounded);
    uint8_t *module_pages, *host_pages = NULL;
    int error = check_region(machine, region, name, size, why);

    if (error != 0)
        return error;
    error = machine_reserve(&region->around, machine_place_seed(machine), machine->region_count,
                            machine->low, pages + 2 * REGION_GUARD);
    if (error == 0) {
        module_pages = region->around.base + REGION_GUARD;
        error = access == MACHINE_REGION_READ ? map_twice(region, module_pages, pages, &host_pages)
                                              : map_once(module_pages, pages, &host_pages);
    }
    if (error != 0) {
        machine_release(&region->host);
        machine_release(&region->around);
        return machine_fail(why, error, "%s: cannot map %zu bytes: %s", name, size,
                            strerror(-error));
    }
    memset(host_pages, SLACK_BYTE, pages - rounded);
    memset(host_pages + pages - rounded + size, SLACK_BYTE, rounded - size);
    *host = host_pages + pages - rounded;
    *module = module_pages + pages - rounded;
    region->start = (uint64_t)*module;
    region->size = size;
    return machine_region_done(machine, module_pages, pages, access, why);
}

void machine_regions_release(struct machine *machine)
{
    while (machine->region_count > 0) {
        struct machine_region *region = &machine->regions[--machine->region_count];

        machine_release(&region->host);
        machine_release(&region->around);
    }
}

/* Names the region whose reservation (guards included) holds the address. Runs in the signal
 * handler. */
void machine_describe_address(const struct machine *machine, struct machine_fault *fault)
{
    for (unsigned i = 0; i < machine->region_count; i++) {
        const struct machine_region *region = &machine->regions[i];

        if (fault->address - (uint64_t)region->around.base >= region->around.size)
            continue;
        memcpy(fault->region, region->name, sizeof fault->region);
        fault->region_offset = (int64_t)(fault->address - region->start);
        fault->region_size = region->size;
        return;
    }
}

static size_t stack_used(const struct machine *machine, const uint8_t *stack)
{
    uint64_t at = (uint64_t)stack, top = machine_stack_top(machine, stack);

    while (at < top && machine_peek(at) == machine->stack_pattern)
        at += sizeof machine->stack_pattern;
    return top - at;
}

size_t machine_stack_deepest(const struct machine *machine)
{
    size_t deepest = machine->stack_deepest;

    for (unsigned level = 0; level < machine->level_count; level++) {
        size_t used = stack_used(machine, machine->levels[level].stack);

        if (used > deepest)
            deepest = used;
    }
    return deepest;
}
