/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the machine code of the module consists of, and how much stack it takes. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_file.h"

/* Says why nothing is known of the code; then it holds nothing special either. */
static const struct image_code *read_code(const struct case_file *file, struct findings *findings)
{
    const struct image_code *code = image_code(file->image);
    if (!code->known)
        finding_not_judged(findings,
                           "the code could not be read: no process could be made for it, or it did "
                           "not end well");
    return code;
}

/* What was not followed was not read. */
static void note_incomplete(const struct case_file *file, const struct image_code *code,
                            struct findings *findings)
{
    if (!code->complete)
        finding_not_judged(findings,
                           "the code was not read to its end: the jump at %s+0x%" PRIx64
                           " could not be followed, and the file does not say where its function "
                           "ends",
                           file->name, code->lost);
}

/* Words of a flat image that only look like addresses of code lead anywhere. */
static bool is_sure(const struct image *image, const struct image_special *special)
{
    return special->how == IMAGE_SPECIAL_REACHED ||
           (special->how == IMAGE_SPECIAL_POINTER && image->format != IMAGE_FORMAT_FLAT);
}

static void judge_specials(const struct case_file *file, enum image_special_kind kind,
                           const char *does, struct findings *findings)
{
    if (file_unreadable(file, findings))
        return;
    const struct image_code *code = read_code(file, findings);
    for (size_t i = 0; i < code->special_count; i++) {
        const struct image_special *special = &code->specials[i];
        struct image_place from;
        if (special->kind != kind || !is_sure(file->image, special))
            continue;
        image_where(file->image, special->from, &from);
        struct finding *finding =
            finding_add(findings, "`%s` %s; control comes there from %s", special->text, does,
                        special->how == IMAGE_SPECIAL_POINTER ? "a call through a pointer"
                        : special->from == file->image->entry_point && file->image->has_entry_point
                            ? "the entry point"
                        : from.function != NULL ? from.function
                                                : "an export");
        finding_place(finding, file, special->vaddr);
    }
    note_incomplete(file, code, findings);
}

void check_no_system_instruction(const struct case_file *file, struct findings *findings)
{
    judge_specials(file, IMAGE_SPECIAL_SYSTEM, "asks an operating system, monitor or debugger",
                   findings);
}

void check_no_privileged_instruction(const struct case_file *file, struct findings *findings)
{
    judge_specials(file, IMAGE_SPECIAL_PRIVILEGED, "commands the processor or the machine itself",
                   findings);
}

void check_no_thread_block(const struct case_file *file, struct findings *findings)
{
    if (file->image->has_tls) /* who uses a thread-local variable looks there (rule no-tls) */
        return;
    judge_specials(file, IMAGE_SPECIAL_THREAD,
                   "looks into an operating system's block for the running thread", findings);
}

void check_repeatable_instructions(const struct case_file *file, struct findings *findings)
{
    judge_specials(file, IMAGE_SPECIAL_MACHINE, "answers differently on every machine or each time",
                   findings);
}

/* Note: nothing says that it is ever executed. */
void check_suspicious_code(const struct case_file *file, struct findings *findings)
{
    if (file_unreadable(file, findings))
        return;
    const struct image_code *code = read_code(file, findings);
    for (size_t i = 0; i < code->special_count; i++) {
        const struct image_special *special = &code->specials[i];
        if (is_sure(file->image, special) || special->kind == IMAGE_SPECIAL_MACHINE)
            continue;
        finding_place(finding_add(findings,
                                  special->how == IMAGE_SPECIAL_BYTES
                                      ? "the bytes of `%s` stand in executable memory, outside all "
                                        "code that was found"
                                      : "`%s` stands in a function that nothing was seen to call",
                                  special->text),
                      file, special->vaddr);
    }
}

/* ---- stack ---- */

static const char *const limit_texts[] = {
    [IMAGE_STACK_BOUNDED] = "",
    [IMAGE_STACK_RECURSION] = "a function is called again before it has returned",
    [IMAGE_STACK_POINTER] =
        "a call through a pointer may reach a function again that has not returned",
    [IMAGE_STACK_JUMP] = "a jump through a pointer or table could not be followed",
    [IMAGE_STACK_VARIABLE] =
        "the stack pointer moves by what is computed at run time (alloca, array of any length)",
    [IMAGE_STACK_LOOP] = "the stack grows with each turn of a loop",
    [IMAGE_STACK_UNBALANCED] = "more is taken off the stack than was put on",
    [IMAGE_STACK_CODE] = "control reaches what is no instruction of the file",
    [IMAGE_STACK_LARGE] = "there is more code, or more stack, than is looked at",
    [IMAGE_STACK_UNKNOWN] = "",
};

typedef void judge_routine(const struct case_file *, const char *name, const struct image_routine *,
                           struct findings *);

static void each_function(const struct case_file *file, judge_routine *judge,
                          struct findings *findings)
{
    if (file_unreadable(file, findings))
        return;
    for (const char *const *name = file->profile->exports; *name != NULL; name++) {
        const struct image_symbol *symbol = image_export(file->image, *name);
        const struct image_routine *routine =
            symbol != NULL ? image_routine(file->image, symbol->vaddr) : NULL;
        if (routine == NULL)
            continue;
        if (routine->limit == IMAGE_STACK_UNKNOWN)
            finding_not_judged(findings,
                               "the stack could not be measured: no process could be made "
                               "for it, or it did not end well");
        else
            judge(file, *name, routine, findings);
    }
}

static void judge_bound(const struct case_file *file, const char *name,
                        const struct image_routine *routine, struct findings *findings)
{
    if (routine->limit != IMAGE_STACK_BOUNDED)
        finding_place(finding_add(findings, "%s has no known bound on its stack: %s", name,
                                  limit_texts[routine->limit]),
                      file, routine->where);
}

static void judge_size(const struct case_file *file, const char *name,
                       const struct image_routine *routine, struct findings *findings)
{
    if (routine->stack > file->profile->stack_bytes)
        finding_place(
            finding_add(findings, "%s takes %" PRIu64 " bytes of stack%s, there are %" PRIu32, name,
                        routine->stack, routine->limit == IMAGE_STACK_BOUNDED ? "" : " or more",
                        file->profile->stack_bytes),
            file, routine->vaddr);
}

void check_stack_bounded(const struct case_file *file, struct findings *findings)
{
    each_function(file, judge_bound, findings);
}

void check_stack_size(const struct case_file *file, struct findings *findings)
{
    each_function(file, judge_size, findings);
}
