/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Where the module's functions are: in its table of exports, or, in a flat image, where its
 * GetProcAddress says each time the image has been loaded (docs/decisions.md, C4).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static bool is_flat(const struct host *host)
{
    return host->image->format == IMAGE_FORMAT_FLAT;
}

int entries_open(struct host *host, char why[HOST_WHY])
{
    for (int entry = 0; entry < ENTRY_COUNT && !is_flat(host); entry++) {
        const struct image_symbol *symbol =
            image_export(host->image, entry_name((enum entry)entry));
        if (symbol == NULL && entry >= (int)host->config.product->entries)
            continue; /* Program_05 where the product does not ask for it (R4) */
        if (symbol == NULL || !symbol->executable) {
            snprintf(why, HOST_WHY, "the module does not export the function %s",
                     entry_name((enum entry)entry));
            return -ENOENT;
        }
        host->entry_address[entry] = symbol->vaddr | symbol->thumb;
    }
    return 0;
}

/* Words of the module's memory; false when they do not lie in it. */
static bool read_words(const struct host *host, uint32_t address, uint32_t *words, size_t count)
{
    const unsigned char *at = (const unsigned char *)(uintptr_t)address;
    uint64_t vaddr;
    if (address % sizeof *words != 0 || !machine_vaddr(host->machine, at, &vaddr) ||
        !machine_vaddr(host->machine, at + count * sizeof *words - 1, &vaddr))
        return false;
    memcpy(words, at, count * sizeof *words);
    return true;
}

bool entries_load(struct host *host)
{
    struct evidence_lookup *lookup = &host->evidence->lookup;
    struct machine_outcome outcome;
    uint64_t vaddr;
    if (!is_flat(host))
        return true;
    memset(host->entry_address, 0, sizeof host->entry_address);
    *lookup = (struct evidence_lookup){ .asked = true };
    host->evidence->entry = ENTRY_INI;
    host->evidence->stage = EVIDENCE_CALLING;
    machine_call(host->machine, host->image->entry_point, NULL, &outcome);
    host->evidence->stage = EVIDENCE_BETWEEN;
    if (outcome.kind != MACHINE_RETURNED) {
        host_incident(host, ENTRY_INI, &outcome);
        return false;
    }
    lookup->table = (uint32_t)outcome.value;
    lookup->found =
        read_words(host, lookup->table, lookup->functions, host->config.product->entries);
    for (unsigned i = 0; i < host->config.product->entries && lookup->found; i++)
        if (machine_vaddr(host->machine, (const void *)(uintptr_t)lookup->functions[i], &vaddr))
            host->entry_address[i] = vaddr; /* bit 0: Thumb code */
    return host->entry_address[ENTRY_INI] != 0;
}
