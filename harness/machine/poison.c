/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * poison.c - writable data as TG Motion leaves it: not initialised.
 *
 * A byte's poison depends on the seed and its address in the module only, so that it is the same
 * wherever the module is mapped.
 */
#include <string.h>

#include "machine/machine_private.h"

#define POISON_ORDINAL 0x706f69736f6eu

struct pattern {
    enum machine_poison kind;
    uint64_t seed;
};

static uint64_t word_of(const struct pattern *pattern, uint64_t vaddr)
{
    uint64_t word = machine_mix(pattern->seed, POISON_ORDINAL, vaddr);

    switch (pattern->kind) {
    case MACHINE_POISON_ZERO:
        return 0;
    case MACHINE_POISON_INVERTED:
        return ~word;
    case MACHINE_POISON_NONE:
    case MACHINE_POISON_SEEDED:
        break;
    }
    return word;
}

static void poison_range(uint8_t *hull, const struct image *image, uint64_t begin, uint64_t end,
                         const struct pattern *pattern)
{
    while (begin < end) {
        uint64_t word = word_of(pattern, begin & ~7ull);
        size_t skip = begin & 7;
        size_t count = 8 - skip < end - begin ? 8 - skip : (size_t)(end - begin);

        memcpy(hull + (begin - image->span_begin), (const uint8_t *)&word + skip, count);
        begin += count;
    }
}

/* Poisons what of [begin, end) lies outside the RELRO range. */
static void poison_segment(uint8_t *hull, const struct image *image, uint64_t begin, uint64_t end,
                           const struct pattern *pattern)
{
    uint64_t keep_begin = image->relro_begin, keep_end = image->relro_end;

    if (keep_begin >= keep_end || keep_end <= begin || keep_begin >= end) {
        poison_range(hull, image, begin, end, pattern);
        return;
    }
    poison_range(hull, image, begin, keep_begin, pattern);
    poison_range(hull, image, keep_end, end, pattern);
}

static uint8_t initial_byte(const struct image *image, const struct image_segment *segment,
                            uint64_t vaddr)
{
    uint64_t offset = vaddr - segment->vaddr;

    return offset < segment->file_size ? image->bytes[segment->file_offset + offset] : 0;
}

/* A word that a relocation patches is not data but the loader's: it keeps its value. */
static void restore_word(uint8_t *hull, const struct image *image,
                         const struct image_segment *segment, const struct image_reloc *reloc)
{
    const unsigned width = reloc->width != 0 ? reloc->width : 8;

    for (uint64_t at = reloc->vaddr; at < reloc->vaddr + width; at++)
        if (at - segment->vaddr < segment->mem_size)
            hull[at - image->span_begin] = initial_byte(image, segment, at);
}

void machine_poison(const struct image *image, uint8_t *hull, enum machine_poison poison,
                    uint64_t seed)
{
    const struct pattern pattern = { poison, seed };

    /* Nobody clears what its file does not fill. */
    if (image->format == IMAGE_FORMAT_FLAT)
        poison_range(hull, image, image->span_begin + image->size,
                     IMAGE_FLAT_BASE + IMAGE_FLAT_REGION, &pattern);
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];

        /* Code among the data would not survive it. */
        if (!(segment->perm & IMAGE_WRITE) || (segment->perm & IMAGE_EXEC))
            continue;
        poison_segment(hull, image, segment->vaddr, segment->vaddr + segment->mem_size, &pattern);
        for (size_t r = 0; r < image->reloc_count; r++)
            restore_word(hull, image, segment, &image->relocs[r]);
    }
}
