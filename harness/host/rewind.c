/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * TG Motion anew: everything as it stood right before the first Program_Ini.
 *
 * The shared memories, and what else lies outside the host's struct (memory_at), are all zeros then
 * but for a few pages, of which there are copies. A part that allocates has its row there.
 */
#include "host/host_parts.h"

#include <stdlib.h>
#include <string.h>

#define COPY_PAGE 4096

struct page {
    char *at;
    size_t size;
    uint8_t bytes[COPY_PAGE];
};

struct host_copy {
    struct host host;
    struct bus_copy *bus;
    size_t count, room;
    struct page *pages;
};

/* What lies outside the struct, by number: false past the end. */
static bool memory_at(const struct host *host, size_t number, char **at, size_t *bytes)
{
    *at = NULL;
    if (number < HOST_MEMORIES) {
        *at = host->memory[number];
        *bytes = host->memory_bytes[number];
    } else if ((number -= HOST_MEMORIES) < CAN_CHANNELS) {
        *at = host->can_memory[number];
        *bytes = CAN_IDS * CAN_ENTRY_BYTES;
    } else if ((number -= CAN_CHANNELS) < host->interpolator_count) {
        const struct interp_path *path = &host->interpolators[number].path;
        *at = (char *)path->parts;
        *bytes = path->capacity * sizeof *path->parts;
    } else {
        return false;
    }
    if (*at == NULL)
        *bytes = 0;
    return true;
}

static bool is_zero(const void *at, size_t size)
{
    const char *bytes = at;
    return bytes[0] == 0 && memcmp(bytes, bytes + 1, size - 1) == 0;
}

/* Called for every page of them until it returns false. */
typedef bool page_visit(struct host_copy *copy, char *at, size_t size);

static bool each_page(struct host *host, page_visit *visit)
{
    char *at;
    size_t bytes;
    for (size_t i = 0; memory_at(host, i, &at, &bytes); i++)
        for (size_t offset = 0; offset < bytes; offset += COPY_PAGE)
            if (!visit(host->copy, at + offset,
                       bytes - offset < COPY_PAGE ? bytes - offset : COPY_PAGE))
                return false;
    return true;
}

static bool keep_page(struct host_copy *copy, char *at, size_t size)
{
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
    page->at = at;
    page->size = size;
    memcpy(page->bytes, at, size);
    return true;
}

static bool clear_page(struct host_copy *copy, char *at, size_t size)
{
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
        !each_page(host, keep_page)) {
        rewind_free(host);
        return;
    }
}

bool rewind_back(struct host *host)
{
    struct host_copy *copy = host->copy;
    char why[MACHINE_WHY];
    sleep_drop_all(host);
    if (copy == NULL || machine_reload(host->machine, why) != 0)
        return false;
    host_sample *const sample = host->sample;
    void *const argument = host->sample_argument;
    *host = copy->host;
    host->sample = sample;
    host->sample_argument = argument;
    each_page(host, clear_page);
    for (size_t i = 0; i < copy->count; i++)
        memcpy(copy->pages[i].at, copy->pages[i].bytes, copy->pages[i].size);
    if (host->bus != NULL)
        bus_rewind(host->bus, copy->bus);
    for (int entry = 0; entry < ENTRY_COUNT; entry++)
        host->evidence->calls[entry].disabled = false;
    if (host->play.scenario != NULL)
        play_begin(&host->play, 0); /* how far it is stands in the evidence */
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
