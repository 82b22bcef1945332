/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fuzz_code.c - any bytes at all as machine code of every processor: the analysis of the stack ends
 * and touches nothing but its own memory.
 *
 * In the harness this work is done in a confined child; here it is done without, so that the
 * sanitizers see it. The first byte chooses the processor, the next four are offsets where
 * functions and pointers to code are.
 */
#include <stdlib.h>
#include <string.h>

#include "image/census.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { HEAD = 5, ROUTINES = 2, POINTERS = 2, RX_AT = 0x1000 };

static const struct kind {
    enum image_format format;
    enum image_target target;
    bool thumb;
    uint64_t base, at;
} kinds[] = {
    { IMAGE_FORMAT_ELF64, IMAGE_TARGET_X86_64, false, 0, RX_AT },
    { IMAGE_FORMAT_PE, IMAGE_TARGET_X86_64, false, 0x180000000, RX_AT },
    { IMAGE_FORMAT_PE, IMAGE_TARGET_I386, false, 0x10000000, RX_AT },
    { IMAGE_FORMAT_ELF32, IMAGE_TARGET_ARM, false, 0, RX_AT },
    { IMAGE_FORMAT_ELF32, IMAGE_TARGET_ARM, true, 0, RX_AT },
    { IMAGE_FORMAT_FLAT, IMAGE_TARGET_ARM, false, 0, IMAGE_FLAT_BASE },
};

static void check(const struct image_routine *routine, size_t size)
{
    if (routine->limit > IMAGE_STACK_UNKNOWN || routine->size > size + 64)
        abort();
}

static void check_special(const struct image_special *special, uint64_t at, size_t size)
{
    if (special->vaddr < at || special->vaddr >= at + size ||
        special->kind > IMAGE_SPECIAL_MACHINE ||
        memchr(special->text, '\0', sizeof special->text) == NULL)
        abort();
}

static void measure(const struct kind *kind, const uint8_t *head, uint8_t *bytes, size_t size)
{
    struct image_segment segment = {
        .vaddr = kind->at, .mem_size = size, .file_size = size, .perm = IMAGE_READ | IMAGE_EXEC
    };
    struct image_routine routines[ROUTINES] = { 0 };
    struct image_symbol symbols[ROUTINES] = { 0 };
    struct image_reloc relocs[POINTERS] = { 0 };
    const uint64_t step = kind->target == IMAGE_TARGET_ARM ? 4 : 1;
    for (unsigned i = 0; i < ROUTINES; i++) {
        routines[i].vaddr = kind->at + (i == 0 ? 0 : head[0] * step % size);
        symbols[i] = (struct image_symbol){ .name = i == 0 ? "a" : "b",
                                            .vaddr = routines[i].vaddr,
                                            .kind = IMAGE_SYMBOL_FUNC,
                                            .exported = true,
                                            .executable = true,
                                            .thumb = kind->thumb };
    }
    for (unsigned i = 0; i < POINTERS; i++)
        relocs[i] = (struct image_reloc){ .vaddr = kind->at + (size - 16) + 8 * i,
                                          .addend = (int64_t)(kind->at + head[1 + i] % size),
                                          .kind = IMAGE_RELOC_RELATIVE,
                                          .width = 4 };
    const struct image image = { .bytes = bytes,
                                 .size = size,
                                 .format = kind->format,
                                 .target = kind->target,
                                 .segments = &segment,
                                 .segment_count = 1,
                                 .span_begin = kind->at & ~(uint64_t)4095,
                                 .span_end = (kind->at + size + 4095) & ~(uint64_t)4095,
                                 .base = kind->base,
                                 .fixed = kind->format == IMAGE_FORMAT_FLAT,
                                 .symbols = symbols,
                                 .symbol_count = ROUTINES,
                                 .relocs = relocs,
                                 .reloc_count = kind->format == IMAGE_FORMAT_FLAT ? 0 : POINTERS };
    struct census *census = calloc(1, sizeof *census);
    if (census == NULL)
        return;
    stack_measure(&image, routines, ROUTINES, census);
    for (size_t i = 0; i < census->special_count; i++)
        check_special(&census->specials[i], kind->at, size);
    free(census);
    for (unsigned i = 0; i < ROUTINES; i++)
        check(&routines[i], size);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < HEAD + 16)
        return 0;
    const struct kind *kind = &kinds[data[0] % (sizeof kinds / sizeof kinds[0])];
    uint8_t *copy = malloc(size - HEAD);
    if (copy == NULL)
        return 0;
    memcpy(copy, data + HEAD, size - HEAD);
    measure(kind, data + 1, copy, size - HEAD);
    free(copy);
    return 0;
}
