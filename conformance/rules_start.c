/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about Program_Ini: what it returns under good and under bad conditions. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

/* Program_Ini returned and had looked at nothing that it was given, which is the only way to
 * everything else. As far as it is known: from the run in which every access is seen. */
static bool is_empty(const struct case_file *file)
{
    const struct evidence *evidence = &file->runs[EXPERIMENT_TRACED_500].result.evidence;
    return evidence->audit.traced && evidence->calls[ENTRY_INI].count > 0 &&
           evidence->audit.functions[ENTRY_INI].looked == 0;
}

/* Adds a finding when Program_Ini did not return `wanted` in the experiment; `where` says under
 * which conditions. */
static void expect_result(const struct case_file *file, enum experiment_id id, int32_t wanted,
                          const char *where, struct findings *findings)
{
    const struct evidence *evidence = case_evidence(file, id, findings);
    if (evidence == NULL)
        return;
    if (wanted == 0 && is_empty(file)) {
        finding_not_judged(findings, "Program_Ini looks at nothing (rule ini-body)");
        return;
    }
    if (evidence->incident_count > 0) {
        char text[FINDING_TEXT];
        incident_describe(&evidence->incidents[0], text);
        struct finding *finding =
            finding_add(findings, "%s: %s instead of returning %d", where, text, (int)wanted);
        incident_place(&evidence->incidents[0], finding, file);
        finding->function = entry_name(ENTRY_INI);
        return;
    }
    if (evidence->calls[ENTRY_INI].count == 0) {
        finding_add(findings, "%s: Program_Ini did not return", where)->function =
            entry_name(ENTRY_INI);
        return;
    }
    const int32_t value = evidence->calls[ENTRY_INI].last_value;
    if (value != 0 && value != 1)
        finding_not_judged(findings, "%s: Program_Ini returned %d (rule ini-zero-or-one)", where,
                           (int)value);
    if (value == wanted || (value != 0 && value != 1))
        return;
    struct finding *finding = finding_add(
        findings, "%s: Program_Ini returned %d, it must return %d", where, (int)value, (int)wanted);
    const struct image_symbol *symbol = image_export(file->image, entry_name(ENTRY_INI));
    if (symbol != NULL)
        finding_place(finding, file, symbol->vaddr);
    finding->function = entry_name(ENTRY_INI);
}

void check_ini_body(const struct case_file *file, struct findings *findings)
{
    const struct evidence *evidence = &file->runs[EXPERIMENT_TRACED_500].result.evidence;
    /* What became of the other functions does not matter. */
    const bool seen = evidence->audit.functions[ENTRY_INI].calls > 0;
    if (!seen && case_evidence(file, EXPERIMENT_TRACED_500, findings) != NULL)
        finding_not_judged(findings, "no call of Program_Ini was seen to its end");
    if (!seen || !is_empty(file))
        return;
    struct finding *finding =
        finding_add(findings, "Program_Ini is empty: it looks at nothing that TG Motion gives it");
    const struct image_symbol *symbol = image_export(file->image, entry_name(ENTRY_INI));
    if (symbol != NULL)
        finding_place(finding, file, symbol->vaddr);
    finding->function = entry_name(ENTRY_INI);
}

void check_ini_returns_one(const struct case_file *file, struct findings *findings)
{
    expect_result(file, EXPERIMENT_START, 1, "everything in order", findings);
}

void check_ini_null_data(const struct case_file *file, struct findings *findings)
{
    expect_result(file, EXPERIMENT_NULL_DATA, 0, "pData is NULL", findings);
}

void check_ini_struct_size(const struct case_file *file, struct findings *findings)
{
    static const enum experiment_id ids[] = { EXPERIMENT_SIZE_ZERO, EXPERIMENT_SIZE_OTHER,
                                              EXPERIMENT_SIZE_LESS, EXPERIMENT_SIZE_MORE };
    for (size_t i = 0; i < sizeof ids / sizeof *ids; i++) {
        char where[64];
        snprintf(where, sizeof where, "structSize is %" PRIu64,
                 case_experiment(file, ids[i])->host.mutation.value);
        expect_result(file, ids[i], 0, where, findings);
    }
}

void check_ini_null_functions(const struct case_file *file, struct findings *findings)
{
    const int generation = product_find(file->profile->product)->generation;
    expect_result(file, EXPERIMENT_NO_STRING, 0,
                  generation == 4 ? "pRtWprintf_String is NULL"
                                  : "pRtWprintf_String_Severity is NULL",
                  findings);
    expect_result(file, EXPERIMENT_NO_LONG, 0, "pRtWprintf_Long is NULL", findings);
    expect_result(file, EXPERIMENT_NO_SWPRINTF, 0, "pswprintf is NULL", findings);
    expect_result(file, EXPERIMENT_NO_SLEEP, 0, "pSleepFt is NULL", findings);
}

static const enum experiment_id wrong_ids[] = { EXPERIMENT_OLDER_ID, EXPERIMENT_NEWER_ID };

void check_ini_compatibility(const struct case_file *file, struct findings *findings)
{
    for (size_t i = 0; i < sizeof wrong_ids / sizeof *wrong_ids; i++) {
        char where[64];
        snprintf(where, sizeof where, "HEADER.Compatibility_Id is %" PRIu64,
                 case_experiment(file, wrong_ids[i])->host.mutation.value);
        expect_result(file, wrong_ids[i], 0, where, findings);
    }
}

/* What stood before Program_Ini in the experiment, in the words of the other rules' titles. */
static void judge_value(const struct case_file *file, enum experiment_id id,
                        struct findings *findings)
{
    const struct evidence *evidence = case_evidence(file, id, findings);
    if (evidence == NULL || evidence->incident_count > 0 || evidence->calls[ENTRY_INI].count == 0)
        return;
    const int32_t value = evidence->calls[ENTRY_INI].last_value;
    if (value == 0 || value == 1)
        return;
    struct finding *finding = finding_add(findings, "Program_Ini returned %d", (int)value);
    const struct image_symbol *symbol = image_export(file->image, entry_name(ENTRY_INI));
    if (symbol != NULL)
        finding_place(finding, file, symbol->vaddr);
    snprintf(finding->when, sizeof finding->when, "(experiment %.40s)",
             case_experiment(file, id)->name);
    finding->function = entry_name(ENTRY_INI);
}

void check_ini_zero_or_one(const struct case_file *file, struct findings *findings)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        if (experiment_in(ON_EVERY_START, id))
            judge_value(file, (enum experiment_id)id, findings);
}

/* The number as a word of its own: 4033 is not found in 14033. */
static bool has_number(const char *text, uint64_t number)
{
    char digits[24];
    const int length = snprintf(digits, sizeof digits, "%" PRIu64, number);
    for (const char *at = strstr(text, digits); at != NULL; at = strstr(at + length, digits)) {
        const bool before = at > text && at[-1] >= '0' && at[-1] <= '9';
        const bool after = at[length] >= '0' && at[length] <= '9';
        if (!before && !after)
            return true;
    }
    return false;
}

static bool printed(const struct evidence *evidence, uint64_t number)
{
    for (unsigned i = 0; i < EVIDENCE_MESSAGES; i++) /* what was not printed is empty */
        if (has_number(evidence->messages[i].text, number))
            return true;
    return false;
}

void check_ini_reports_ids(const struct case_file *file, struct findings *findings)
{
    const uint64_t own = product_find(file->profile->product)->compatibility_id;
    for (size_t i = 0; i < sizeof wrong_ids / sizeof *wrong_ids; i++) {
        const struct evidence *evidence = case_evidence(file, wrong_ids[i], findings);
        const uint64_t wrong = case_experiment(file, wrong_ids[i])->host.mutation.value;
        /* A module that starts nevertheless, or crashes, has its finding in ini-compatibility. */
        if (evidence == NULL || evidence->incident_count > 0 ||
            evidence->calls[ENTRY_INI].last_value != 0)
            continue;
        if (printed(evidence, own) && printed(evidence, wrong))
            continue;
        struct finding *finding =
            evidence->message_count == 0
                ? finding_add(findings,
                              "HEADER.Compatibility_Id is %" PRIu64 ": Program_Ini printed nothing",
                              wrong)
                : finding_add(findings,
                              "HEADER.Compatibility_Id is %" PRIu64
                              ": \"%s\" does not name both %" PRIu64 " and %" PRIu64,
                              wrong, evidence->messages[0].text, own, wrong);
        finding->function = entry_name(ENTRY_INI);
    }
}
