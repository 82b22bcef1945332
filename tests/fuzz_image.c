/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fuzz_image.c - any bytes at all: whatever comes out keeps the promises of image.h.
 *
 * Needs no corpus: the mutator starts from the complete little modules of image_support.h and
 * image_support_pe.h. Real modules as seeds help all the same; Arm has no others. What has no magic
 * number is called .bin, so that it may be a flat image.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/image_private.h"
#include "image_support.h"
#include "image_support_pe.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

static void look_at_places(const struct image *image)
{
    struct image_place place;
    for (size_t i = 0; i < image->symbol_count && i < 4; i++)
        image_where(image, image->symbols[i].vaddr + 1, &place);
    for (size_t i = 0; i < image->segment_count && i < 4; i++)
        image_where(image, image->segments[i].vaddr, &place);
    image_where(image, UINT64_MAX, &place);
}

/* In this process: the child's work is what the sanitizers are here for. */
static void look_at_code(const struct image *image)
{
    struct image_routine routines[4] = { 0 };
    size_t count = 0;
    for (size_t i = 0; i < image->symbol_count && count < 4; i++) {
        if (image->symbols[i].exported && image->symbols[i].executable)
            routines[count++].vaddr = image->symbols[i].vaddr;
    }
    if (image->has_entry_point && count < 4)
        routines[count++].vaddr = image->entry_point;
    stack_measure(image, routines, count);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct image *image;
    char why[IMAGE_WHY];
    bool magic = size >= 2 && (memcmp(data, "MZ", 2) == 0 || memcmp(data, "\177E", 2) == 0);
    if (image_open_memory(&image, magic ? "fuzz" : "fuzz.bin", data, size, why) != 0)
        return 0;
    const char *broken = image_broken_promise(image);
    if (broken != NULL) {
        fprintf(stderr, "broken promise: %s\n", broken);
        abort();
    }
    image_export(image, "Program_01");
    /* Debug information costs a process: one input in sixteen, the same ones each time. */
    if (!image->has_debug_lines || image->sha256[0] == '0')
        look_at_places(image);
    look_at_code(image);
    image_close(image);
    return 0;
}

/* Values that are interesting where a file keeps an address, an offset, a size or a count. */
static uint64_t interesting(uint64_t old, size_t size, unsigned int choice)
{
    const uint64_t values[] = { 0,          1,        7,          8,        0xfff,
                                0x1000,     size,     size - 1,   size + 1, UINT32_MAX,
                                UINT64_MAX, old + 1,  old - 1,    old + 8,  old - 8,
                                old << 1,   old >> 1, old ^ 0xff, -old,     (uint64_t)1 << 63 };
    return values[choice % (sizeof values / sizeof values[0])];
}

static void change_field(uint8_t *data, size_t size, unsigned int seed)
{
    static const size_t widths[] = { 8, 8, 4, 2 };
    size_t width = widths[seed >> 4 & 3];
    uint64_t value = 0;
    if (size < width)
        return;
    size_t at = (seed >> 6) % (size / width) * width;
    memcpy(&value, data + at, width);
    value = interesting(value, size, seed >> 20);
    memcpy(data + at, &value, width);
}

static size_t start_anew(uint8_t *data, size_t size, size_t max_size, unsigned int choice)
{
    static struct tiny tiny;
    static struct tiny_pe pe;
    if (max_size < sizeof tiny || max_size < TINY_PE_SIZE)
        return size;
    if (choice % 3 == 0) {
        tiny_init(&tiny);
        memcpy(data, &tiny, sizeof tiny);
        return sizeof tiny;
    }
    tiny_pe_init(&pe, choice % 3 == 1);
    memcpy(data, pe.bytes, TINY_PE_SIZE);
    return TINY_PE_SIZE;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    seed *= 2654435761u;
    if (size < 64 || seed % 64 == 0)
        size = start_anew(data, size, max_size, seed >> 8);
    if (seed % 4 == 1)
        return LLVMFuzzerMutate(data, size, max_size);
    change_field(data, size, seed);
    if (seed % 4 == 2)
        change_field(data, size, seed * 40503u + 1);
    return size;
}
