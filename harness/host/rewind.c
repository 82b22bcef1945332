/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * TG Motion anew: everything as it stood right before the first Program_Ini.
 *
 * The shared memories are all zeros then but for a few pages, of which there are copies; the host
 * itself is one struct without anything allocated in it.
 */
#include "host/host_parts.h"

#include <stdlib.h>
#include <string.h>

#define COPY_PAGE 4096

struct page {
    size_t memory, offset;
    uint8_t bytes[COPY_PAGE];
};

struct host_copy {
    struct host host;
    struct bus_copy *bus;
    size_t count, room;
    struct page *pages;
};

static size_t page_size(const struct host *host, size_t memory, size_t offset)
{
    const size_t left = host->memory_bytes[memory] - offset;
    return left < COPY_PAGE ? left : COPY_PAGE;
}

static bool is_zero(const void *at, size_t size)
{
    const char *bytes = at;
    return bytes[0] == 0 && memcmp(bytes, bytes + 1, size - 1) == 0;
}

/* Called for every page of the shared memories until it returns false. */
typedef bool page_visit(struct host *host, struct host_copy *copy, size_t memory, size_t offset);

static bool each_page(struct host *host, struct host_copy *copy, page_visit *visit)
{
    for (size_t i = 0; catalogue_memory(host->catalogue, i) != NULL; i++)
        for (size_t offset = 0; offset < host->memory_bytes[i]; offset += COPY_PAGE)
            if (!visit(host, copy, i, offset))
                return false;
    return true;
}

static bool keep_page(struct host *host, struct host_copy *copy, size_t memory, size_t offset)
{
    const char *at = (const char *)host->memory[memory] + offset;
    const size_t size = page_size(host, memory, offset);
    if (is_zero(at, size))
        return true;
    if (copy->count == copy->room) {
        const size_t room = copy->room * 2 + 16;
        struct page *pages = realloc(copy->pages, room * sizeof *pages);
        if (pages == NULL)
            return false;
        copy->pages = pages;
        copy->room = room;
    }
    struct page *page = &copy->pages[copy->count++];
    page->memory = memory;
    page->offset = offset;
    memcpy(page->bytes, at, size);
    return true;
}

static bool clear_page(struct host *host, struct host_copy *copy, size_t memory, size_t offset)
{
    char *at = (char *)host->memory[memory] + offset;
    const size_t size = page_size(host, memory, offset);
    (void)copy;
    if (!is_zero(at, size))
        memset(at, 0, size);
    return true;
}

void rewind_keep(struct host *host)
{
    struct host_copy *copy = calloc(1, sizeof *copy);
    if (copy == NULL)
        return;
    host->copy = copy;
    copy->host = *host;
    if ((host->bus != NULL && bus_keep(host->bus, &copy->bus) != 0) ||
        !each_page(host, copy, keep_page)) {
        rewind_free(host);
        return;
    }
}

bool rewind_back(struct host *host)
{
    struct host_copy *copy = host->copy;
    char why[MACHINE_WHY];
    if (copy == NULL || machine_reload(host->machine, why) != 0)
        return false;
    host_sample *const sample = host->sample;
    void *const argument = host->sample_argument;
    *host = copy->host;
    host->sample = sample;
    host->sample_argument = argument;
    each_page(host, copy, clear_page);
    for (size_t i = 0; i < copy->count; i++)
        memcpy((char *)host->memory[copy->pages[i].memory] + copy->pages[i].offset,
               copy->pages[i].bytes, page_size(host, copy->pages[i].memory, copy->pages[i].offset));
    if (host->bus != NULL)
        bus_rewind(host->bus, copy->bus);
    for (int entry = 0; entry < ENTRY_COUNT; entry++)
        host->evidence->calls[entry].disabled = false;
    host->evidence->loads++;
    return true;
}

void rewind_free(struct host *host)
{
    if (host->copy == NULL)
        return;
    bus_copy_free(host->copy->bus);
    free(host->copy->pages);
    free(host->copy);
    host->copy = NULL;
}
