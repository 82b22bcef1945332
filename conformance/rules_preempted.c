/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Rules about what an interrupt between two instructions leads to (host/races.h). */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules_cycle.h"

#define NAME_TEXT  200
#define VALUE_TEXT 40

/* The symbol that an address of the module's own data belongs to. */
static void name_own(const struct image *image, uint64_t vaddr, char name[NAME_TEXT])
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (!symbol->executable && vaddr - symbol->vaddr < symbol->size) {
            snprintf(name, NAME_TEXT, "the module's variable '%.60s'", symbol->name);
            return;
        }
    }
    snprintf(name, NAME_TEXT, "the module's own data at +0x%" PRIx64, vaddr);
}

/* What a word is, and how its values are written. False: it is no register of the layout. */
static bool line_of(const struct cycle_run *run, const struct evidence_word *word, uint32_t *offset,
                    struct catalogue_line *line)
{
    *offset = (uint32_t)word->offset + word->bit / 8;
    if (word->memory < 0 || !audit_line(run->catalogue, (unsigned)word->memory, *offset, line))
        return false;
    if (scalar_size(line->type) == 8)
        *offset = (uint32_t)word->offset;
    return true;
}

static void name_word(const struct cycle_run *run, const struct evidence_word *word,
                      char name[NAME_TEXT])
{
    struct catalogue_line line;
    uint32_t offset;
    if (word->memory < 0) {
        name_own(run->file->image, word->offset + word->bit / 8, name);
        return;
    }
    line_of(run, word, &offset, &line);
    audit_name(run->catalogue, (unsigned)word->memory, offset, name);
}

static void value_text(const struct cycle_run *run, const struct evidence_word *word,
                       uint64_t value, char text[VALUE_TEXT])
{
    struct catalogue_line line;
    uint32_t offset;
    const uint32_t half = (uint32_t)(value >> (word->bit & 32));
    if (!line_of(run, word, &offset, &line))
        snprintf(text, VALUE_TEXT, half < 1000000 ? "%" PRIu32 : "0x%08" PRIx32, half);
    else if (scalar_size(line.type) == 8)
        snprintf(text, VALUE_TEXT, "%.17g", scalar_get(line.type, &value));
    else
        snprintf(text, VALUE_TEXT, "%.9g", scalar_get(line.type, &half));
}

/* "; Program_04 writes it at x.tgm+0x1a4 (Program_04) x.c:88" */
static void tell_other(const struct cycle_run *run, const struct evidence_race *race,
                       const char *name, char *text, size_t size)
{
    struct finding where = { .count = 0 };
    char shared[NAME_TEXT];
    text[0] = '\0';
    if (!race->has_by_pc)
        return;
    finding_place(&where, run->file, race->by_pc);
    name_word(run, &race->shared, shared);
    snprintf(text, size, "; %s %s %.120s at %.160s", entry_name(race->by),
             race->by_writes ? "writes" : "reads", strcmp(shared, name) == 0 ? "it" : shared,
             where.place);
}

static struct finding *tell_neither(const struct cycle_run *run, const struct evidence_race *race)
{
    const struct evidence_word *word = &race->words[0];
    char name[NAME_TEXT], other[NAME_TEXT * 2], found[VALUE_TEXT], first[VALUE_TEXT],
        second[VALUE_TEXT];
    name_word(run, word, name);
    value_text(run, word, word->found, found);
    value_text(run, word, word->first, first);
    value_text(run, word, word->second, second);
    tell_other(run, race, name, other, sizeof other);
    const bool same = strcmp(first, second) == 0;
    return finding_add(run->findings,
                       "%s interrupted by %s leaves %s in %.150s; one after the other they leave "
                       "%s%s%s%s",
                       entry_name(race->entry), entry_name(race->by), found, name, first,
                       same ? "" : " or ", same ? "" : second, other);
}

static struct finding *tell_mixed(const struct cycle_run *run, const struct evidence_race *race)
{
    const struct evidence_word *words = race->words;
    char first[NAME_TEXT], second[NAME_TEXT], other[NAME_TEXT * 2];
    name_word(run, &words[0], first);
    name_word(run, &words[1], second);
    tell_other(run, race, first, other, sizeof other);
    if (strcmp(first, second) == 0)
        return finding_add(run->findings,
                           "%s interrupted by %s leaves half of %.100s as it is when %s runs "
                           "first, the other half as when %s does%s",
                           entry_name(race->entry), entry_name(race->by), first,
                           entry_name(race->entry), entry_name(race->by), other);
    return finding_add(run->findings,
                       "%s interrupted by %s leaves %.90s as it is when %s runs first, and %.90s "
                       "as when %s does%s",
                       entry_name(race->entry), entry_name(race->by), first,
                       entry_name(race->entry), second, entry_name(race->by), other);
}

static struct finding *tell_failed(const struct cycle_run *run, const struct evidence_race *race)
{
    const struct evidence_incident incident = {
        .entry = race->failed, .cycle = race->cycle, .kind = race->outcome, .fault = race->fault
    };
    struct finding where = { .count = 0 };
    char text[FINDING_TEXT];
    incident_describe(&incident, text);
    incident_place(&incident, &where, run->file);
    return finding_add(run->findings,
                       "%s interrupted by %s: %.200s%s%.160s; one after the other they return",
                       entry_name(race->entry), entry_name(race->by), text,
                       where.place[0] != '\0' ? " at " : "", where.place);
}

typedef struct finding *tell_race(const struct cycle_run *run, const struct evidence_race *race);
static tell_race *const tellers[] = {
    [RACE_NEITHER] = tell_neither, [RACE_MIXED] = tell_mixed, [RACE_FAILED] = tell_failed
};

/* The place is where the function was interrupted. */
static void judge(const struct cycle_run *run, bool failed)
{
    const struct evidence *evidence = run->evidence;
    if (evidence->tried_calls == 0 && evidence->instrumented) {
        finding_not_judged(run->findings, "interrupts are tried on this computer's own processor; "
                                          "the module runs on an emulated one");
        return;
    }
    for (unsigned i = 0; i < evidence->race_count; i++) {
        const struct evidence_race *race = &evidence->races[i];
        if ((race->kind == RACE_FAILED) != failed)
            continue;
        struct finding *finding = tellers[race->kind](run, race);
        finding_stamp(finding, run->experiment, race->entry, race->cycle);
        finding_place(finding, run->file, race->pc);
        finding->count = race->count;
    }
}

static void judge_torn(const struct cycle_run *run)
{
    judge(run, false);
}

static void judge_failed(const struct cycle_run *run)
{
    judge(run, true);
}

void check_no_torn_register(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_PREEMPTED, judge_torn, findings);
}

void check_survives_interrupts(const struct case_file *file, struct findings *findings)
{
    cycle_each(file, ON_PREEMPTED, judge_failed, findings);
}
