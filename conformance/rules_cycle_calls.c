/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about calls as such: how the processor is given back, what services are used, how much. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_cycle.h"

/* The console of a controller is read by people, and every line takes time that the control loop
 * has a use for (decision H20). */
enum { CONSOLE_BEGIN = 20, CONSOLE_PER_SECOND = 10 };

bool cycle_run_open(struct cycle_run *run, const struct case_file *file, enum experiment_id id,
                    struct findings *findings)
{
    const struct product *product = product_find(file->profile->product);
    *run = (struct cycle_run){
        .file = file,
        .id = id,
        .experiment = case_experiment(file, id),
        .evidence = case_evidence(file, id, findings),
        .catalogue = catalogue_find(product->generation, (int)product->memory_id),
        .findings = findings,
    };
    return run->evidence != NULL;
}

void cycle_each(const struct case_file *file, uint64_t set, cycle_judge *judge,
                struct findings *findings)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        struct cycle_run run;
        if (!experiment_in(set, id) ||
            !cycle_run_open(&run, file, (enum experiment_id)id, findings))
            continue;
        judge(&run);
        case_complete(file, (enum experiment_id)id, findings);
    }
}

void cycle_place_function(const struct cycle_run *run, enum entry entry, struct finding *finding)
{
    const struct image_symbol *symbol = image_export(run->file->image, entry_name(entry));
    if (symbol != NULL)
        finding_place(finding, run->file, symbol->vaddr);
}

/* --- SleepFt --------------------------------------------------------------------------------- */

static void judge_sleep(const struct cycle_run *run)
{
    for (int entry = ENTRY_04; entry <= ENTRY_05; entry++) {
        const struct audit_function *function = &run->evidence->audit.functions[entry];
        if (function->sleeps == 0)
            continue;
        struct finding *finding =
            finding_add(run->findings, "%s called pSleepFt", entry_name((enum entry)entry));
        finding_stamp(finding, run->experiment, (enum entry)entry, function->sleep_cycle);
        finding->count += function->sleeps - 1;
        if (function->sleep_pc != 0)
            finding_place(finding, run->file, function->sleep_pc - 1); /* the call itself */
    }
}

void check_no_sleep(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_sleep, findings);
}

/* --- calling convention ---------------------------------------------------------------------- */

/* By bit of enum machine_abi. */
static const char *const parts_x86_64[] = {
    "rbx",
    "rbp",
    "r12",
    "r13",
    "r14",
    "r15",
    "the stack pointer",
    "the direction flag",
    "the trap, nested-task or alignment-check flag",
    "MXCSR (SSE rounding, masks or flush to zero)",
    "the x87 control word",
    "the x87 registers (left in use)",
    "the base of fs",
    "rdi",
    "rsi",
    "xmm6 to xmm15",
    "the base of gs",
};
static const char *const parts_i386[] = {
    "ebx",
    "ebp",
    "",
    "",
    "",
    "",
    "the stack pointer",
    "the direction flag",
    "the trap, nested-task or alignment-check flag",
    "MXCSR (SSE rounding, masks or flush to zero)",
    "the x87 control word",
    "the x87 registers (left in use)",
    "the base of fs",
    "edi",
    "esi",
    "",
    "the base of gs",
};
static const char *const parts_arm[] = {
    "r4",    "r5", "r6", "r7", "r8 or r9", "r10 or r11", "the stack pointer", "", "",
    "FPSCR", "",   "",   "",   "",         "",           "d8 to d15",         "",
};
_Static_assert(sizeof parts_x86_64 / sizeof *parts_x86_64 == MACHINE_ABI_BITS &&
                   sizeof parts_i386 / sizeof *parts_i386 == MACHINE_ABI_BITS &&
                   sizeof parts_arm / sizeof *parts_arm == MACHINE_ABI_BITS,
               "each bit has a name");

static const char *const *parts_of(const struct image *image)
{
    switch (image->target) {
    case IMAGE_TARGET_I386:
        return parts_i386;
    case IMAGE_TARGET_ARM:
        return parts_arm;
    default:
        return parts_x86_64;
    }
}

static void list_parts(const char *const *names, unsigned bits, char *text, size_t size)
{
    size_t at = 0;
    text[0] = '\0';
    for (unsigned bit = 0; bit < MACHINE_ABI_BITS && at < size; bit++)
        if (bits >> bit & 1)
            at += (size_t)snprintf(text + at, size - at, "%s%s", at > 0 ? ", " : "", names[bit]);
}

static void judge_convention(const struct cycle_run *run)
{
    char text[FINDING_TEXT / 2];
    for (int entry = 0; entry < ENTRY_COUNT; entry++) {
        const struct audit_function *function = &run->evidence->audit.functions[entry];
        if (function->abi_broken == 0)
            continue;
        list_parts(parts_of(run->file->image), function->abi_broken, text, sizeof text);
        struct finding *finding = finding_add(run->findings, "%s returned and had not put back: %s",
                                              entry_name((enum entry)entry), text);
        finding_stamp(finding, run->experiment, (enum entry)entry, function->abi_cycle);
        cycle_place_function(run, (enum entry)entry, finding);
    }
}

void check_calling_convention(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_GOOD_RUNS, judge_convention, findings);
}

/* --- console --------------------------------------------------------------------------------- */

static void judge_console(const struct cycle_run *run)
{
    const double seconds = (double)run->evidence->time_ns * 1e-9;
    const double allowed = CONSOLE_BEGIN + CONSOLE_PER_SECOND * seconds;
    uint64_t all = 0;
    enum entry most = ENTRY_01;
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++) {
        all += run->evidence->audit.functions[entry].messages;
        if (run->evidence->audit.functions[entry].messages >
            run->evidence->audit.functions[most].messages)
            most = (enum entry)entry;
    }
    if ((double)all <= allowed)
        return;
    struct finding *finding = finding_add(run->findings, "%s prints without end", entry_name(most));
    finding->function = entry_name(most);
    snprintf(finding->when, sizeof finding->when, "(%" PRIu64 " messages in %.3f s, %.0f at most)",
             all, seconds, allowed);
    cycle_place_function(run, most, finding);
}

void check_bounded_console(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_CYCLES, judge_console, findings);
}
