/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The memory that the module asks for: how much, and what may be done with it. */
#include <inttypes.h>

#include "conformance/rules_file.h"

void check_no_writable_code(const struct case_file *file, struct findings *findings)
{
    if (file_unreadable(file, findings))
        return;
    for (size_t i = 0; i < file->image->segment_count; i++) {
        const struct image_segment *segment = &file->image->segments[i];
        if ((segment->perm & IMAGE_WRITE) != 0 && (segment->perm & IMAGE_EXEC) != 0)
            finding_place(finding_add(findings,
                                      "segment %zu (0x%" PRIx64 ", %" PRIu64
                                      " bytes) is writable and executable",
                                      i, segment->vaddr, segment->mem_size),
                          file, segment->vaddr);
    }
}

void check_no_executable_stack(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings) || !image->exec_stack)
        return;
    if (image->format == IMAGE_FORMAT_PE)
        finding_add(findings, "the file is not marked NX compatible: link with --nxcompat");
    else
        finding_add(
            findings,
            image->exec_stack_stated
                ? "the file asks for an executable stack (PT_GNU_STACK has the execute flag)"
                : "the file does not rule out an executable stack (it has no PT_GNU_STACK)");
}

/* The largest thing that has a name: mostly what has to be made smaller. */
static const struct image_symbol *largest(const struct image *image)
{
    const struct image_symbol *found = NULL;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->kind != IMAGE_SYMBOL_TLS && symbol->kind != IMAGE_SYMBOL_OTHER &&
            symbol->size > (found != NULL ? found->size : 0))
            found = symbol;
    }
    return found;
}

void check_fits_memory(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings))
        return;
    const uint64_t span = image->span_end - image->span_begin, room = file->profile->region_bytes;
    if (span <= room)
        return;
    const struct image_symbol *symbol = largest(image);
    if (symbol == NULL)
        finding_add(findings, "the module takes %" PRIu64 " bytes of memory, there are %" PRIu64,
                    span, room);
    else
        finding_place(finding_add(findings,
                                  "the module takes %" PRIu64 " bytes of memory, there are %" PRIu64
                                  "; the largest thing in it is %s (%" PRIu64 " bytes)",
                                  span, room, symbol->name, symbol->size),
                      file, symbol->vaddr);
}

/* ---- notes ---- */

static bool is_flat(const struct case_file *file, struct findings *findings, const char *reason)
{
    if (file->image->format != IMAGE_FORMAT_FLAT)
        return false;
    finding_not_judged(findings, "%s", reason);
    return true;
}

/* An exported one is a matter of export-code. */
static bool holds_data(const struct image *image, const struct image_segment *segment)
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (symbol->kind == IMAGE_SYMBOL_OBJECT && symbol->size > 0 && !symbol->exported &&
            symbol->vaddr >= segment->vaddr && symbol->vaddr - segment->vaddr < segment->mem_size)
            return true;
    }
    return false;
}

static void judge_data(const struct case_file *file, const struct image_segment *segment,
                       struct findings *findings)
{
    /* An ELF file begins with its headers. */
    if (segment->file_offset == 0 && segment->file_size > 0 && file_is_elf(file->image))
        finding_add(findings, "the file's own headers are in executable memory");
    else if (holds_data(file->image, segment))
        finding_place(finding_add(findings, "constants lie in executable memory, beside the code"),
                      file, segment->vaddr);
}

void check_data_not_executable(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    if (file_unreadable(file, findings) ||
        is_flat(file, findings, "a flat image does not say which of its bytes are data"))
        return;
    for (size_t i = 0; i < image->segment_count; i++)
        if ((image->segments[i].perm & IMAGE_EXEC) != 0 &&
            (image->segments[i].perm & IMAGE_WRITE) == 0)
            judge_data(file, &image->segments[i], findings);
}

void check_debug_information(const struct case_file *file, struct findings *findings)
{
    const struct image *image = file->image;
    bool named = false;
    if (file_unreadable(file, findings) ||
        is_flat(file, findings, "a flat image has no place for debug information") ||
        image->has_debug_lines || image->debug_file != NULL)
        return; /* a .pdb is debug information, though nobody reads it here (decision H15) */
    for (size_t i = 0; i < image->symbol_count; i++)
        named |= !image->symbols[i].exported;
    if (named)
        finding_add(
            findings,
            "no line information in the file: findings name functions and offsets, not source "
            "lines");
    else
        finding_add(findings, "stripped of symbols and line information: findings name offsets "
                              "from the exports, not functions and lines");
}
