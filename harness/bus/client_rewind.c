/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Back to an earlier moment: master, slaves, devices and the script of faults, as they stood.
 *
 * All of them are blocks of memory at places of their own, so that bytes put back bring everything
 * back. The fiber was idle when the copy was made and begins anew.
 */
#include "bus/client.h"
#include "bus/fault_parts.h"
#include "bus/fiber.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define BLOCKS (BUS_MAX_SLAVES + 4)

struct block {
    void *at;
    size_t size;
    uint8_t *copy;
};

struct bus_copy {
    size_t count;
    struct block blocks[BLOCKS];
};

static int keep(struct bus_copy *copy, void *at, size_t size)
{
    struct block *block = &copy->blocks[copy->count];

    if (size == 0)
        return 0;
    block->copy = malloc(size);
    if (!block->copy)
        return -ENOMEM;
    memcpy(block->copy, at, size);
    block->at = at;
    block->size = size;
    copy->count++;
    return 0;
}

static int keep_all(struct bus *bus, struct bus_copy *copy)
{
    struct faults *faults = bus->faults;
    int error = keep(copy, bus, sizeof *bus);

    if (!error)
        error = keep(copy, bus->rack.slaves, bus->slave_count * sizeof *bus->rack.slaves);
    if (!error)
        error = keep(copy, faults, sizeof *faults);
    if (!error)
        error = keep(copy, faults->statements, faults->room * sizeof *faults->statements);
    for (size_t i = 0; i < bus->slave_count && !error; i++)
        error = keep(copy, bus->rack.devices[i], bus->rack.slaves[i].type->size);
    return error;
}

int bus_keep(struct bus *bus, struct bus_copy **out)
{
    struct bus_copy *copy = calloc(1, sizeof *copy);
    int error = !copy ? -ENOMEM : bus->job_first ? -EBUSY : keep_all(bus, copy);

    if (error) {
        bus_copy_free(copy);
        copy = NULL;
    }
    *out = copy;
    return error;
}

void bus_rewind(struct bus *bus, const struct bus_copy *copy)
{
    for (size_t i = 0; i < copy->count; i++)
        memcpy(copy->blocks[i].at, copy->blocks[i].copy, copy->blocks[i].size);
    fiber_restart(bus->clock.fiber);
}

void bus_copy_free(struct bus_copy *copy)
{
    for (size_t i = 0; copy && i < copy->count; i++)
        free(copy->blocks[i].copy);
    free(copy);
}
