/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * flat.c - the image of TGMcontroller and TGZ+Motion: raw Arm code, linked at a fixed address, with
 * GetProcAddress first.
 *
 * It has no header, so nothing is taken for one that is not called so (.bin) and does not begin
 * like a function: from its first word on there have to be Arm instructions that stay inside the
 * image, up to a return. What it exports is in no table of the format: GetProcAddress tells whoever
 * runs it. Images made by this project's SDK carry a table of its own (sdk/src/flat.c), which
 * counts only where it says that it lies; other images simply have no exports here.
 */
#include "image/image_private.h"

#include <errno.h>
#include <string.h>

#define MAX_FUNCTION 1024u /* words from the beginning to the first return */

static bool has_suffix(const struct image *image, const char *suffix)
{
    size_t length = strlen(image->path), wanted = strlen(suffix);
    return length > wanted && strcmp(image->path + length - wanted, suffix) == 0;
}

static uint32_t word_at(const struct image *image, size_t offset)
{
    const uint8_t *at = image->bytes + offset;
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* The Arm Architecture Reference Manual's A32 encodings; the condition is not part of them. */
static bool is_branch(uint32_t word)
{
    return (word >> 28) != 0xf && (word & 0x0e000000) == 0x0a000000; /* B, BL */
}

/* BLX: a linker makes it of BL where the function is Thumb code, as newlib's are. */
static bool is_thumb_call(uint32_t word)
{
    return (word & 0xfe000000) == 0xfa000000;
}

static bool is_literal_load(uint32_t word)
{
    return (word & 0x0f3f0000) == 0x051f0000; /* LDR Rt, [PC, #+-imm12] */
}

/* Goes away and does not come back: BX LR, LDM with PC, a write of PC, B. */
static bool is_return(uint32_t word)
{
    return (word >> 28) == 0xe && ((word & 0x0ffffff0) == 0x012fff10 ||   /* BX Rm */
                                   ((word & 0x0e108000) == 0x08108000) || /* LDM Rn, {..., PC} */
                                   ((word & 0x0c10f000) == 0x0410f000) || /* LDR PC, [...] */
                                   ((word & 0x0feffff0) == 0x01a0f000) || /* MOV PC, Rm */
                                   (is_branch(word) && (word & 0x01000000) == 0)); /* B */
}

/* Words that no compiler makes out of code, though some of them would decode. */
static bool is_no_code(uint32_t word)
{
    return ((word >> 28) == 0xf && !is_thumb_call(word)) || word == 0 ||
           (word & 0x0ff000f0) == 0x07f000f0 || /* permanently undefined */
           (word & 0x0f000000) == 0x0f000000;   /* SVC: there is no operating system */
}

static bool stays_inside(const struct image *image, size_t offset, uint32_t word)
{
    int64_t target = (int64_t)offset + 8;
    if (is_thumb_call(word))
        target += ((int32_t)(word << 8) >> 6) + ((word & 0x01000000) != 0 ? 2 : 0);
    else if (is_branch(word))
        target += (int32_t)(word << 8) >> 6;
    else if (is_literal_load(word))
        target += (word & 0x00800000) != 0 ? (int64_t)(word & 0xfff) : -(int64_t)(word & 0xfff);
    else
        return true;
    return target >= 0 && (uint64_t)target + 4 <= image->size;
}

static bool begins_with_a_function(struct image *image)
{
    uint32_t first = image->size >= 4 ? word_at(image, 0) : 0;
    if ((first >> 28) != 0xe)
        return image_defect(image,
                            "starts with the word 0x%08x, which is no Arm instruction that begins "
                            "a function; a flat image starts with the code of GetProcAddress",
                            first);
    for (size_t i = 0; i < MAX_FUNCTION && 4 * i + 4 <= image->size; i++) {
        uint32_t word = word_at(image, 4 * i);
        if (is_no_code(word) || !stays_inside(image, 4 * i, word))
            return image_defect(image,
                                "the word 0x%08x at 0x%zx, in the code that the file starts with, "
                                "is no Arm instruction of a flat image",
                                word, 4 * i);
        if (is_return(word))
            return true;
    }
    return image_defect(image,
                        "does not start with a function: no return instruction in the first "
                        "%u words",
                        MAX_FUNCTION);
}

enum { EXPORT_MAGIC = 16, EXPORT_HEAD = 24, EXPORT_ENTRY = 16, EXPORT_NAME = 12, EXPORT_MOST = 64 };

/* Offset of the SDK's export table, 0 when there is none. */
static size_t find_export_table(const struct image *image)
{
    static const char magic[EXPORT_MAGIC] = "TGM-EXPORTS-1";
    for (size_t at = 4; at + EXPORT_HEAD <= image->size; at += 4)
        if (memcmp(image->bytes + at, magic, sizeof magic) == 0 &&
            word_at(image, at + EXPORT_MAGIC) == IMAGE_FLAT_BASE + at)
            return at;
    return 0;
}

static bool add_export(struct image *image, size_t entry)
{
    const char *name = (const char *)image->bytes + entry + 4;
    uint32_t address = word_at(image, entry), place = address & ~1u;
    size_t length = strnlen(name, EXPORT_NAME);
    if (length == 0 || length == EXPORT_NAME || place < IMAGE_FLAT_BASE ||
        place - IMAGE_FLAT_BASE + 4 > image->size)
        return image_defect(
            image, "the export table at 0x%zx has an entry without a name or outside the image",
            entry);
    const char *copy = image_text(image, "%s", name);
    if (copy == NULL)
        return false;
    image->symbols[image->symbol_count++] = (struct image_symbol){ .name = copy,
                                                                   .vaddr = place,
                                                                   .kind = IMAGE_SYMBOL_FUNC,
                                                                   .exported = true,
                                                                   .executable = true,
                                                                   .thumb = (address & 1) != 0 };
    return true;
}

static void add_exports(struct image *image, int *error)
{
    size_t table = find_export_table(image);
    uint32_t count = table != 0 ? word_at(image, table + EXPORT_MAGIC + 4) : 0;
    if (count == 0)
        return;
    if (count > EXPORT_MOST || table + EXPORT_HEAD + (size_t)count * EXPORT_ENTRY > image->size) {
        image_defect(image, "the export table at 0x%zx says %u entries, there is room for fewer",
                     table, count);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (!image_make_room(&image->symbols, image->symbol_count, sizeof image->symbols[0])) {
            *error = -ENOMEM;
            return;
        }
        if (!add_export(image, table + EXPORT_HEAD + i * EXPORT_ENTRY))
            return;
    }
    image_sort_symbols(image);
}

static void describe_flat(struct image *image, int *error)
{
    image->format = IMAGE_FORMAT_FLAT;
    image->target = IMAGE_TARGET_ARM;
    image->format_name = "flat";
    image->target_name = "Arm";
    if (image->size > IMAGE_FLAT_REGION) {
        image_defect(image, "%zu bytes, a flat image has room for %u (0x%08x to 0x%08x)",
                     image->size, IMAGE_FLAT_REGION, IMAGE_FLAT_BASE,
                     IMAGE_FLAT_BASE + IMAGE_FLAT_REGION);
        return;
    }
    if (!begins_with_a_function(image))
        return;
    if (!image_make_room(&image->segments, 0, sizeof image->segments[0])) {
        *error = -ENOMEM;
        return;
    }
    image->segments[0] = (struct image_segment){ .vaddr = IMAGE_FLAT_BASE,
                                                 .mem_size = image->size,
                                                 .file_size = image->size,
                                                 .perm = IMAGE_READ | IMAGE_EXEC };
    image->segment_count = 1;
    image->span_begin = IMAGE_FLAT_BASE;
    image->span_end =
        (IMAGE_FLAT_BASE + image->size + IMAGE_PAGE - 1) & ~(uint64_t)(IMAGE_PAGE - 1);
    image->align = IMAGE_PAGE;
    image->fixed = true;
    image->has_entry_point = true;
    image->entry_point = IMAGE_FLAT_BASE;
    add_exports(image, error);
}

bool flat_recognise(struct image *image, int *error)
{
    static const char *const stamped[] = { ".tgm_controller", ".tgz_motion" };
    for (size_t i = 0; i < sizeof stamped / sizeof stamped[0]; i++) {
        if (!has_suffix(image, stamped[i]))
            continue;
        image_defect(image,
                     "a %s file, and the vendor's stamp is not documented: judge the .tgm.bin that "
                     "was stamped",
                     stamped[i]);
        return true;
    }
    if (!has_suffix(image, ".bin"))
        return false;
    describe_flat(image, error);
    return true;
}
