/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * census_bytes.c - system calls by their bytes, for code that no walk has come to.
 *
 * Bytes inside an instruction that was found do not count: they are its address or number, and two
 * or four of them look like a system call by chance once in a few modules.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/census.h"
#include "image/stack.h"

#define MAX_SIZE (64u << 20) /* of a file whose bytes are searched */

struct pattern {
    const char *text;
    uint8_t bytes[4], size, step;
};

static const struct pattern x86_patterns[] = {
    { "syscall", { 0x0F, 0x05 }, 2, 1 },
    { "sysenter", { 0x0F, 0x34 }, 2, 1 },
    { "int 0x80", { 0xCD, 0x80 }, 2, 1 },
    { "int 0x2e", { 0xCD, 0x2E }, 2, 1 },
};

/* Of Linux and of FreeRTOS, unconditional. */
static const struct pattern arm_patterns[] = {
    { "svc #0", { 0x00, 0x00, 0x00, 0xEF }, 4, 4 },
};

/* One bit for each byte of the file that is part of an instruction. */
static uint8_t *mark_found(const struct census_search *search)
{
    const struct image *image = search->stack->code.image;
    uint8_t *marks = image->size <= MAX_SIZE ? calloc(image->size / 8 + 1, 1) : NULL;
    for (size_t i = 0; marks != NULL && i < search->found_count; i++) {
        const uint64_t key = search->found[i];
        const struct code_insn *insn = code_at(&search->stack->code, key >> 1, (key & 1) != 0);
        uint64_t offset;
        if (insn == NULL || !image_file_range(image, insn->vaddr, insn->size, &offset))
            continue;
        for (uint64_t at = offset; at < offset + insn->size; at++)
            marks[at / 8] |= (uint8_t)(1u << at % 8);
    }
    return marks;
}

static void search_segment(struct census_search *search, const struct image_segment *segment,
                           const struct pattern *pattern, const uint8_t *marks)
{
    const uint8_t *bytes = search->stack->code.image->bytes + segment->file_offset;
    for (uint64_t i = 0; i + pattern->size <= segment->file_size; i += pattern->step) {
        const uint64_t at = segment->file_offset + i;
        if (memcmp(bytes + i, pattern->bytes, pattern->size) != 0 ||
            (marks[at / 8] >> at % 8 & 1) != 0)
            continue;
        struct image_special special = { .vaddr = segment->vaddr + i,
                                         .from = segment->vaddr + i,
                                         .kind = IMAGE_SPECIAL_SYSTEM,
                                         .how = IMAGE_SPECIAL_BYTES };
        snprintf(special.text, sizeof special.text, "%s", pattern->text);
        census_add(search->census, &special);
    }
}

void census_bytes(struct census_search *search)
{
    const struct image *image = search->stack->code.image;
    const bool arm = image->target == IMAGE_TARGET_ARM;
    const struct pattern *patterns = arm ? arm_patterns : x86_patterns;
    const size_t count = arm ? sizeof arm_patterns / sizeof arm_patterns[0]
                             : sizeof x86_patterns / sizeof x86_patterns[0];
    uint8_t *marks = mark_found(search);
    for (size_t i = 0; marks != NULL && i < image->segment_count; i++)
        for (size_t k = 0; k < count && (image->segments[i].perm & IMAGE_EXEC) != 0; k++)
            search_segment(search, &image->segments[i], &patterns[k], marks);
    free(marks);
}
