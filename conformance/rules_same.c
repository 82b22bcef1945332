/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Rules that compare runs: under conditions that are not the module's business it does the same,
 * or at least goes on.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_cycle.h"

#define START_TEXT 40

static const struct catalogue *catalogue_of(const struct case_file *file)
{
    const struct product *product = product_find(file->profile->product);
    return catalogue_find(product->generation, (int)product->memory_id);
}

/* --- two runs -------------------------------------------------------------------------------- */

struct pair {
    const struct case_file *file;
    enum experiment_id usual, other;
    const struct evidence *a, *b; /* of usual and other */
};

/* False, and the rule not judged, when one of them has no evidence. */
static bool pair_up(const struct case_file *file, enum experiment_id usual,
                    enum experiment_id other, struct pair *pair, struct findings *findings)
{
    *pair = (struct pair){ .file = file, .usual = usual, .other = other };
    pair->a = case_evidence(file, usual, findings);
    pair->b = case_evidence(file, other, findings);
    return pair->a != NULL && pair->b != NULL;
}

/* How Program_Ini ended. What it did instead of returning is told by other rules. */
static void tell_start(const struct evidence *evidence, char text[START_TEXT])
{
    const struct evidence_calls *calls = &evidence->calls[ENTRY_INI];
    snprintf(text, START_TEXT, calls->count > 0 ? "returned %d" : "did not return",
             (int)calls->last_value);
}

/* The cycles have registers for a different end of the module to be seen in; what ended before them
 * is told here. */
static bool same_fate(const struct pair *pair, const char *when, struct findings *findings)
{
    const struct evidence *a = pair->a, *b = pair->b;
    char text[FINDING_TEXT], start[START_TEXT], otherwise[START_TEXT];
    const bool more_incidents = b->incident_count > 0 && a->incident_count == 0;
    if (more_incidents) {
        const struct evidence_incident *incident = &b->incidents[0];
        incident_describe(incident, text);
        struct finding *finding = finding_add(findings, "%s: %s", when, text);
        finding_stamp(finding, case_experiment(pair->file, pair->other), incident->entry,
                      incident->cycle);
        incident_place(incident, finding, pair->file);
        return false;
    }
    tell_start(b, start);
    tell_start(a, otherwise);
    if (strcmp(start, otherwise) == 0)
        return true;
    finding_add(findings, "%s: Program_Ini %s, otherwise it %s", when, start, otherwise)->function =
        entry_name(ENTRY_INI);
    return false;
}

/* What memories hold in the end can be compared of runs of the same length only. */
static bool differ(const struct pair *pair, struct digest_difference *difference)
{
    return digest_differ(catalogue_of(pair->file), &pair->a->digest, &pair->b->digest,
                         difference) &&
           (difference->early || pair->a->cycles_done == pair->b->cycles_done);
}

/* Registers and TGM_Data hold the same in every cycle that both have. */
static void expect_same(const struct pair *pair, const char *when, struct findings *findings)
{
    struct digest_difference difference;
    if (!same_fate(pair, when, findings) || !differ(pair, &difference))
        return;
    struct finding *finding = finding_add(findings, "%s: %s is not what it is otherwise", when,
                                          difference.name[0] != '\0'     ? difference.name
                                          : difference.memory[0] != '\0' ? difference.memory
                                                                         : "a register");
    if (!difference.early)
        return;
    finding_stamp(finding, case_experiment(pair->file, pair->other), ENTRY_04, difference.cycle);
    finding->cycles_needed = difference.cycle + 2; /* it is seen when the next one begins */
    finding->function = NULL;
}

/* --- registers of the machine, without TGM_Data ------------------------------------------------
 */

struct comparison {
    const struct digest *a, *b;
    size_t number; /* of the line that is visited */
    char name[160];
};

static bool is_machine(const struct catalogue_line *line)
{
    static const char *const roots[] = { "SERVO", "DIO", "GENERAL", "INTERPOLATOR" };
    for (size_t i = 0; i < sizeof roots / sizeof *roots; i++)
        if (strcmp(line->memory->root, roots[i]) == 0)
            return true;
    return false;
}

static void compare_line(void *argument, const struct catalogue_line *line)
{
    struct comparison *comparison = argument;
    const size_t number = comparison->number++;
    if (number < DIGEST_TRAILS - DIGEST_MEMORIES && comparison->name[0] == '\0' &&
        is_machine(line) && comparison->a->trails[number] != comparison->b->trails[number])
        snprintf(comparison->name, sizeof comparison->name, "%s", line->name);
}

/* The first line of the catalogue about the machine in which two runs of equal length differ; ""
 * when there is none. */
static void machine_difference(const struct pair *pair, char name[160])
{
    struct comparison comparison = { .a = &pair->a->digest, .b = &pair->b->digest };
    catalogue_walk(catalogue_of(pair->file), compare_line, &comparison);
    memcpy(name, comparison.name, sizeof comparison.name);
}

/* --- the rules ---------------------------------------------------------------------------------
 */

/* Whether the module repeats itself at all: what does not is a finding of `deterministic` only. */
static bool repeats(const struct case_file *file, struct findings *findings)
{
    struct pair pair;
    struct digest_difference difference;
    const bool known = pair_up(file, EXPERIMENT_CYCLE_500, EXPERIMENT_REPEATED, &pair, findings);
    const bool same = known && !differ(&pair, &difference);
    if (known && !same)
        finding_not_judged(findings, "not even two equal runs do the same (rule deterministic)");
    return same;
}

void check_globals(const struct case_file *file, struct findings *findings)
{
    static const struct {
        enum experiment_id id;
        const char *when;
    } others[] = {
        { EXPERIMENT_POISON_INVERTED, "with other values in the globals before Program_Ini" },
        { EXPERIMENT_POISON_ZERO, "with zeros in the globals before Program_Ini" },
    };
    struct pair pair;
    if (!repeats(file, findings))
        return;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (!pair_up(file, EXPERIMENT_CYCLE_500, others[i].id, &pair, findings))
            continue;
        expect_same(&pair, others[i].when, findings);
        if (findings->count > 0)
            return; /* zeros are other values */
        case_complete(file, others[i].id, findings);
    }
}

/* Addresses in TGM_Data are of no use to anybody, and do no harm: the machine's registers count. */
static void judge_places(const struct case_file *file, struct findings *findings)
{
    static const char when[] = "with module and memories at other addresses";
    struct pair pair;
    char name[160];
    if (!pair_up(file, EXPERIMENT_REPEATED, EXPERIMENT_PLACES, &pair, findings) ||
        !same_fate(&pair, when, findings))
        return;
    machine_difference(&pair, name);
    if (name[0] != '\0' && pair.a->digest.state_count == pair.b->digest.state_count)
        finding_add(findings, "%s: %s is not what it is otherwise", when, name);
}

void check_deterministic(const struct case_file *file, struct findings *findings)
{
    static const enum experiment_id others[] = { EXPERIMENT_REPEATED, EXPERIMENT_PLACES };
    struct pair pair;
    if (pair_up(file, EXPERIMENT_CYCLE_500, EXPERIMENT_REPEATED, &pair, findings))
        expect_same(&pair, "in a second run of the same", findings);
    if (findings->count == 0)
        judge_places(file, findings);
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        case_complete(file, others[i], findings);
}

void check_data_size(const struct case_file *file, struct findings *findings)
{
    static const enum experiment_id ids[] = { EXPERIMENT_DATA_LESS, EXPERIMENT_DATA_MORE };
    const struct evidence *usual = case_evidence(file, EXPERIMENT_CYCLE_500, findings);
    char text[FINDING_TEXT];
    for (size_t i = 0; i < sizeof ids / sizeof *ids && usual != NULL; i++) {
        const struct evidence *evidence = case_evidence(file, ids[i], findings);
        const uint32_t bytes = case_experiment(file, ids[i])->host.data_bytes;
        if (evidence == NULL || evidence->incident_count == 0 || usual->incident_count > 0)
            continue;
        const struct evidence_incident *incident = &evidence->incidents[0];
        incident_describe(incident, text);
        struct finding *finding =
            finding_add(findings, "with %u bytes of TGM_Data: %s", bytes, text);
        finding_stamp(finding, case_experiment(file, ids[i]), incident->entry, incident->cycle);
        incident_place(incident, finding, file);
    }
}

/* A module that acts by the absolute value of a counter does something else in each of the runs;
 * only one that does so in none but the wrapping run has met the wrap. */
void check_counter_wrap(const struct case_file *file, struct findings *findings)
{
    static const char when[] = "when the counters pass 4294967295";
    static const enum experiment_id others[] = { EXPERIMENT_COUNTERS, EXPERIMENT_COUNTERS_FAR };
    struct pair wrap, far;
    char name[160];
    if (!pair_up(file, EXPERIMENT_COUNTERS_ZERO, EXPERIMENT_COUNTERS, &wrap, findings) ||
        !pair_up(file, EXPERIMENT_COUNTERS_ZERO, EXPERIMENT_COUNTERS_FAR, &far, findings))
        return;
    if (same_fate(&wrap, when, findings)) {
        machine_difference(&far, name);
        if (name[0] == '\0')
            machine_difference(&wrap, name);
        else
            name[0] = '\0';
        if (name[0] != '\0')
            finding_add(findings, "%s: %s is not what it is otherwise", when, name);
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        case_complete(file, others[i], findings);
}

void check_restart(const struct case_file *file, struct findings *findings)
{
    const struct evidence *usual = case_evidence(file, EXPERIMENT_CYCLE_500, findings);
    const struct evidence *evidence = case_evidence(file, EXPERIMENT_RESTART, findings);
    char text[FINDING_TEXT];
    if (usual == NULL || evidence == NULL)
        return;
    if (evidence->incident_count > 0 && usual->incident_count == 0) {
        incident_describe(&evidence->incidents[0], text);
        struct finding *finding = finding_add(findings, "when the PLC is run again: %s", text);
        finding_stamp(finding, case_experiment(file, EXPERIMENT_RESTART),
                      evidence->incidents[0].entry, evidence->incidents[0].cycle);
        incident_place(&evidence->incidents[0], finding, file);
        return;
    }
    const int32_t value = evidence->calls[ENTRY_INI].last_value;
    if (usual->calls[ENTRY_INI].last_value != 1)
        finding_not_judged(findings, "the module does not start at all (rule ini-returns-one)");
    else if (usual->incident_count > 0) {
        incident_describe(&usual->incidents[0], text);
        finding_not_judged(findings, "even without being run again: %s", text);
    } else if (evidence->loads == 0)
        finding_not_judged(findings, "the PLC was not run again");
    else if (value != 1) {
        struct finding *finding =
            finding_add(findings, "when the PLC is run again, Program_Ini returns %d", (int)value);
        const struct image_symbol *symbol = image_export(file->image, entry_name(ENTRY_INI));
        if (symbol != NULL)
            finding_place(finding, file, symbol->vaddr);
        finding->function = entry_name(ENTRY_INI);
    }
}
