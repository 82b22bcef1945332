/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/budgets.h"

#include <stdio.h>
#include <string.h>

/* 0: not called, or as often as there is time for. */
static uint32_t period_us(const struct experiment *experiment, enum entry entry)
{
    const uint32_t configured = experiment->host.program_period_us[entry - ENTRY_01];
    if (configured == PERIOD_OFF)
        return 0;
    return configured != 0 ? configured
                           : experiment->host.product->program_period_us[entry - ENTRY_01];
}

double budget_allowed_us(const struct experiment *experiment, enum entry entry)
{
    const struct product_budget *budget = &experiment->host.product->budget;
    switch (entry) {
    case ENTRY_01:
    case ENTRY_02:
    case ENTRY_03:
        return period_us(experiment, entry) * budget->background_percent / 100.0;
    case ENTRY_04:
        return experiment->host.cycle_us * budget->program_04_percent / 100.0;
    case ENTRY_05:
        return budget->program_05_us;
    default:
        return 0;
    }
}

double budget_us(const struct experiment *experiment, uint64_t instructions)
{
    const uint32_t rate = experiment->host.product->budget.instructions_per_us;
    return rate != 0 ? (double)instructions / rate : 0;
}

static bool is_usable(const struct case_file *file, int id)
{
    const struct case_run *run = &file->runs[id];
    return experiment_in(ON_TRACED, id) && run->ran && run->result.evidence.audit.traced;
}

/* The run in which the call comes nearest to what it may take; -1: none. */
static int tightest(const struct case_file *file, enum entry entry)
{
    int best = -1;
    double most = -1;
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        if (!is_usable(file, id))
            continue;
        const struct experiment *experiment = &file->runs[id].plan.experiment;
        const struct audit_function *function =
            &file->runs[id].result.evidence.audit.functions[entry];
        const double allowed = budget_allowed_us(experiment, entry);
        const double share =
            allowed > 0 ? budget_us(experiment, function->worst_instructions) / allowed : 0;
        if (function->calls > 0 && share > most) {
            most = share;
            best = id;
        }
    }
    return best;
}

/* A traced run ended in the function, so that no call of it was counted. */
static bool is_uncounted(const struct case_file *file, enum entry entry)
{
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        for (unsigned i = 0;
             is_usable(file, id) && i < file->runs[id].result.evidence.incident_count; i++)
            if (file->runs[id].result.evidence.incidents[i].entry == entry)
                return true;
    return false;
}

static bool fill(const struct case_file *file, enum entry entry, struct budget_report *out)
{
    const int id = tightest(file, entry);
    if (id < 0) {
        *out = (struct budget_report){ .name = entry_name(entry),
                                       .unit = "us",
                                       .reason = "no call of it was counted to its end" };
        return is_uncounted(file, entry);
    }
    const struct experiment *experiment = &file->runs[id].plan.experiment;
    const struct audit_function *function = &file->runs[id].result.evidence.audit.functions[entry];
    *out = (struct budget_report){
        .name = entry_name(entry),
        .unit = "us",
        .worst = budget_us(experiment, function->worst_instructions),
        .allowed = budget_allowed_us(experiment, entry),
        .has_cycle = function->worst_cycle != EVIDENCE_NO_CYCLE,
        .cycle = function->worst_cycle,
        .cycle_us = experiment->host.cycle_us,
        .instructions = function->worst_instructions,
    };
    return true;
}

static bool fill_stack(const struct case_file *file, struct budget_report *out)
{
    bool found = false;
    *out = (struct budget_report){ .name = "stack", .unit = "bytes" };
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        for (int entry = 0; is_usable(file, id) && entry < ENTRY_COUNT; entry++) {
            const double bytes =
                (double)file->runs[id].result.evidence.audit.functions[entry].stack_bytes;
            found = true;
            out->allowed = file->profile->stack_bytes;
            if (bytes > out->worst)
                out->worst = bytes;
        }
    return found;
}

size_t budgets_report(const struct case_file *file, struct budget_report out[BUDGETS_MOST])
{
    static const enum entry order[] = { ENTRY_04, ENTRY_05, ENTRY_01, ENTRY_02, ENTRY_03 };
    size_t count = 0;
    for (size_t i = 0; i < sizeof order / sizeof *order; i++)
        count += fill(file, order[i], &out[count]);
    count += fill_stack(file, &out[count]);
    return count;
}
