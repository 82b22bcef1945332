/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * What of the module ran in at least one run on the instrumented machine: all of it, the functions
 * that TG Motion calls, and others of which something never ran, those with the most first.
 */
#include "conformance/chronicle.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OTHERS 24 /* functions that are listed besides the exported ones */

struct function {
    const struct image_symbol *symbol;
    uint64_t size, executed;
};

static struct coverage *add_runs(const struct case_file *file)
{
    struct coverage *all = calloc(1, sizeof *all);
    for (int id = 0; all != NULL && id < EXPERIMENT_COUNT; id++)
        if (file->runs[id].ran)
            coverage_add(all, &file->runs[id].result.evidence.coverage);
    for (size_t i = 0; all != NULL && i < file->scenario_count; i++)
        if (file->scenarios[i].ran)
            coverage_add(all, &file->scenarios[i].result.evidence.coverage);
    return all;
}

/* How long it is: as the file says, else as its code shows. */
static uint64_t size_of(const struct image *image, const struct image_symbol *symbol)
{
    const struct image_routine *routine =
        symbol->size == 0 ? image_routine(image, symbol->vaddr) : NULL;
    return routine != NULL ? routine->size : symbol->size;
}

/* Two names of one place are one function. */
static size_t find_functions(const struct image *image, const struct coverage *all,
                             struct function *functions)
{
    size_t count = 0;
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        const uint64_t size = symbol->executable ? size_of(image, symbol) : 0;
        if (size == 0 || symbol->kind == IMAGE_SYMBOL_OBJECT)
            continue;
        struct function *last = count > 0 ? &functions[count - 1] : NULL;
        if (last != NULL && last->symbol->vaddr == symbol->vaddr) {
            if (symbol->exported)
                last->symbol = symbol;
            continue;
        }
        functions[count++] = (struct function){
            .symbol = symbol,
            .size = size,
            .executed = coverage_count(all, symbol->vaddr, size),
        };
    }
    return count;
}

static struct coverage_report *add_row(struct chronicle *chronicle, const char *name,
                                       uint64_t executed, uint64_t total)
{
    struct coverage_report *row = &chronicle->coverage[chronicle->coverage_count++];
    snprintf(row->name, sizeof row->name, "%s", name);
    row->executed = executed;
    row->total = total;
    return row;
}

static void add_function(struct chronicle *chronicle, const struct case_file *file,
                         const struct coverage *all, const struct function *function)
{
    struct finding place = { .count = 0 };
    struct coverage_report *row =
        add_row(chronicle, function->symbol->name, function->executed, function->size);
    if (function->executed == function->size)
        return;
    finding_place(&place, file, coverage_gap(all, function->symbol->vaddr, function->size));
    if (place.file[0] != '\0')
        snprintf(row->missed, sizeof row->missed, "%.200s:%d", place.file, place.line);
    else
        snprintf(row->missed, sizeof row->missed, "0x%" PRIx64, place.address);
}

static int by_missed(const void *a, const void *b)
{
    const struct function *x = a, *y = b;
    const uint64_t missed_x = x->size - x->executed, missed_y = y->size - y->executed;
    if (missed_x != missed_y)
        return missed_x > missed_y ? -1 : 1;
    return x->symbol->vaddr < y->symbol->vaddr ? -1 : x->symbol->vaddr > y->symbol->vaddr;
}

static void add_functions(struct chronicle *chronicle, const struct case_file *file,
                          const struct coverage *all, struct function *functions, size_t count)
{
    uint64_t executed = 0, total = 0;
    for (size_t i = 0; i < count; i++) {
        executed += functions[i].executed;
        total += functions[i].size;
    }
    if (total > 0)
        add_row(chronicle, "all functions", executed, total);
    for (const char *const *name = file->profile->exports; *name != NULL; name++)
        for (size_t i = 0; i < count; i++)
            if (functions[i].symbol->exported && strcmp(functions[i].symbol->name, *name) == 0)
                add_function(chronicle, file, all, &functions[i]);
    qsort(functions, count, sizeof *functions, by_missed);
    size_t others = 0;
    for (size_t i = 0; i < count && others < OTHERS; i++)
        if (!functions[i].symbol->exported && functions[i].executed < functions[i].size) {
            add_function(chronicle, file, all, &functions[i]);
            others++;
        }
}

int chronicle_coverage(struct chronicle *chronicle, const struct case_file *file)
{
    struct coverage *all = add_runs(file);
    struct function *functions = calloc(file->image->symbol_count + 1, sizeof *functions);
    chronicle->coverage = calloc(OTHERS + ENTRY_COUNT + 1, sizeof *chronicle->coverage);
    const bool memory = all != NULL && functions != NULL && chronicle->coverage != NULL;
    if (memory && all->size == 0)
        chronicle->coverage_reason =
            file->cannot_run[0] != '\0' ? "nothing was run"
                                        : "no run on the instrumented machine was asked for, or it "
                                          "could not run the module";
    else if (memory)
        add_functions(chronicle, file, all, functions, find_functions(file->image, all, functions));
    free(all);
    free(functions);
    return memory ? 0 : -ENOMEM;
}
