/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * reload.c - the module once more as it was loaded.
 *
 * The copy is of whole pages, in the order of the pages, of those that module code may write. It is
 * made before any module code runs and cannot be written afterwards.
 */
#define _GNU_SOURCE 1
#include <errno.h>
#include <string.h>
#include <sys/mman.h>

#include "machine/machine_private.h"

static size_t writable_bytes(const struct machine *machine)
{
    size_t count = (machine->span_end - machine->span_begin) / PAGE, bytes = 0;

    for (size_t page = 0; page < count; page++)
        if (machine->page_access[page] & PROT_WRITE)
            bytes += PAGE;
    return bytes;
}

/* Every writable page between its place and the copy. */
static void copy_pages(const struct machine *machine, bool back)
{
    size_t count = (machine->span_end - machine->span_begin) / PAGE;
    uint8_t *copy = machine->copy.base;

    for (size_t page = 0; page < count; page++) {
        uint8_t *own = machine->hull + page * PAGE;

        if (!(machine->page_access[page] & PROT_WRITE))
            continue;
        memcpy(back ? own : copy, back ? copy : own, PAGE);
        copy += PAGE;
    }
}

int machine_copy_keep(struct machine *machine, char why[MACHINE_WHY])
{
    size_t size = writable_bytes(machine);
    uint8_t *base;

    if (size == 0 || size > MACHINE_COPY_LIMIT)
        return 0;
    base = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (base == MAP_FAILED)
        return machine_fail(why, -errno, "no memory for a copy of the module: %s", strerror(errno));
    machine->copy = (struct machine_reservation){ base, size };
    copy_pages(machine, false);
    return mprotect(base, size, PROT_READ) != 0
               ? machine_fail(why, -errno, "copy of the module: %s", strerror(errno))
               : 0;
}

int machine_reload(struct machine *machine, char why[MACHINE_WHY])
{
    why[0] = '\0';
    if (machine->ops->busy(machine))
        return machine_fail(why, -EBUSY, "a call of the module is under way");
    if (machine->copy.size != writable_bytes(machine))
        return machine_fail(why, -EFBIG,
                            "%zu bytes of writable memory are too many to load the module again",
                            writable_bytes(machine));
    copy_pages(machine, true);
    machine->stack_deepest = machine_stack_used(machine);
    for (unsigned level = 0; level < machine->level_count; level++)
        machine_forget_frames(machine, machine->levels[level].stack);
    machine_fill_stacks(machine);
    if (machine->ops->reloaded != NULL)
        machine->ops->reloaded(machine);
    return 0;
}
