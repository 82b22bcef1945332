/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fuzz_image.c - any bytes at all: whatever comes out keeps the promises of image.h.
 *
 * Needs no corpus: the mutator starts from complete little modules, ELF64, both kinds of PE and a
 * flat image. Real modules as seeds (make fuzz has them) help all the same; of ELF for Arm there
 * are no others. What has no magic number is called .bin, so that it may be a flat image.
 *
 * FUZZ_FORMAT=elf, pe or flat in the environment keeps to one of them. At the end it says how many
 * inputs were of which, and how many of them were modules.
 *
 * Built a second time with FUZZ_DEEP it looks at debug information and machine code, too, which
 * takes a process and therefore its time (fuzz_image_deep).
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/image_private.h"
#include "image_support.h"
#include "image_support_pe.h"

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

enum format { ELF, PE, FLAT, FORMATS };

static const struct {
    const char *name, *magic;
    size_t magic_size;
} formats[FORMATS] = { { "elf", "\177ELF", 4 }, { "pe", "MZ", 2 }, { "flat", "", 0 } };

static struct {
    unsigned long long inputs, modules;
} seen[FORMATS];
static int only = FORMATS;

static enum format format_of(const uint8_t *data, size_t size)
{
    enum format format = ELF;
    while (size < formats[format].magic_size ||
           memcmp(data, formats[format].magic, formats[format].magic_size) != 0)
        format++;
    return format;
}

static void say_what_was_seen(void)
{
    for (int i = 0; i < FORMATS; i++)
        fprintf(stderr, "%s: %llu inputs, %llu of them modules\n", formats[i].name, seen[i].inputs,
                seen[i].modules);
}

int LLVMFuzzerInitialize(int *argument_count, char ***arguments)
{
    const char *wanted = getenv("FUZZ_FORMAT");
    (void)argument_count;
    (void)arguments;
    for (int i = 0; i < FORMATS; i++)
        if (wanted != NULL && strcmp(wanted, formats[i].name) == 0)
            only = i;
    atexit(say_what_was_seen);
    return 0;
}

#ifdef FUZZ_DEEP
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

static void look_deeper(const struct image *image)
{
    /* Debug information costs a process: one input in sixteen, the same ones each time. */
    if (!image->has_debug_lines || image->sha256[0] == '0')
        look_at_places(image);
    look_at_code(image);
}
#else
static void look_deeper(const struct image *image)
{
    (void)image;
}
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct image *image;
    char why[IMAGE_WHY];
    const enum format format = format_of(data, size);
    if (image_open_memory(&image, format != FLAT ? "fuzz" : "fuzz.bin", data, size, why) != 0)
        return 0;
    const char *broken = image_broken_promise(image);
    if (broken != NULL) {
        fprintf(stderr, "broken promise: %s\n", broken);
        abort();
    }
    seen[format].inputs++;
    seen[format].modules += image->defect[0] == '\0';
    image_export(image, "Program_01");
    look_deeper(image);
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

/* A flat image of one function and the SDK's table of two exports. */
static size_t flat_module(uint8_t *data)
{
    static const char magic[16] = "TGM-EXPORTS-1";
    const uint32_t code[] = { 0xe59f1000, 0xe12fff1e, 7 }; /* ldr r1, [pc]; bx lr */
    const uint32_t head[] = { IMAGE_FLAT_BASE + 16, 2 };
    memset(data, 0, 128);
    memcpy(data, code, sizeof code);
    memcpy(data + 16, magic, sizeof magic);
    memcpy(data + 32, head, sizeof head);
    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t place = IMAGE_FLAT_BASE + 4 * i;
        memcpy(data + 40 + (size_t)16 * i, &place, sizeof place);
        memcpy(data + 44 + (size_t)16 * i, i == 0 ? "Program_01" : "Program_02", 10);
    }
    return 128;
}

static size_t start_anew(uint8_t *data, size_t size, size_t max_size, unsigned int choice)
{
    static struct tiny tiny;
    static struct tiny_pe pe;
    const unsigned int format = only != FORMATS ? (unsigned int)only : choice % FORMATS;
    if (max_size < sizeof tiny || max_size < TINY_PE_SIZE)
        return size;
    switch (format) {
    case ELF:
        tiny_init(&tiny);
        memcpy(data, &tiny, sizeof tiny);
        return sizeof tiny;
    case PE:
        tiny_pe_init(&pe, choice / FORMATS % 2 == 1);
        memcpy(data, pe.bytes, TINY_PE_SIZE);
        return TINY_PE_SIZE;
    default:
        return flat_module(data);
    }
}

/* Back to the format that is wanted. */
static size_t keep_format(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    if (only == FORMATS || (int)format_of(data, size) == only)
        return size;
    if (only == FLAT || size < 64)
        return start_anew(data, size, max_size, seed);
    memcpy(data, formats[only].magic, formats[only].magic_size);
    return size;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    seed *= 2654435761u;
    if (size < 64 || seed % 64 == 0)
        size = start_anew(data, size, max_size, seed >> 8);
    if (seed % 4 == 1)
        size = LLVMFuzzerMutate(data, size, max_size);
    else
        change_field(data, size, seed);
    if (seed % 4 == 2)
        change_field(data, size, seed * 40503u + 1);
    return keep_format(data, size, max_size, seed >> 8);
}
