/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/rule_book.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "conformance/check.h"
#include "image/sha256.h"

/* What is as usual is 0, and left out. */
static void number(FILE *out, const char *name, uint64_t value)
{
    if (value != 0)
        fprintf(out, " %s=%" PRIu64, name, value);
}

static void numbers(FILE *out, const char *name, const uint32_t values[3])
{
    fprintf(out, " %s=%" PRIu32 ",%" PRIu32 ",%" PRIu32, name, values[0], values[1], values[2]);
}

static void write_rule(FILE *out, const struct rule *rule, const struct planned *plan)
{
    fprintf(out, "rule %s %s %s\n", rule->id, rule_group_name(rule->group),
            severity_name(rule->severity));
    fprintf(out, "  %s; %s\n", rule->clause, rule->title);
    if (rule->experiments == ON_SCENARIOS)
        fputs("  on scenarios\n", out);
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        if (experiment_in(rule->experiments, id))
            fprintf(out, "  on %s\n", plan[id].row.name);
}

static void write_period(FILE *out, const struct period_rule *rule)
{
    fprintf(out, " period=%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%d", rule->least_us, rule->most_us,
            rule->step_us, rule->may_be_off);
}

static void write_product(FILE *out, const struct product *p)
{
    fprintf(out, "  product %s generation=%d ids=%" PRIu32 ",%" PRIu32 ",%" PRIu32 " text8=%d",
            p->name, p->generation, p->compatibility_id, p->memory_id, p->cnc_id, p->text8);
    number(out, "entries", p->entries);
    number(out, "schedule", p->schedule);
    number(out, "tick_us", p->tick_us);
    number(out, "margin_us", p->margin_us);
    for (const uint32_t *cycle = p->cycle_times_us; *cycle != 0; cycle++)
        number(out, "cycle_us", *cycle);
    for (int i = 0; i < 3; i++)
        write_period(out, &p->periods[i]);
    numbers(out, "program_us", p->program_period_us);
    number(out, "background_percent", p->budget.background_percent);
    number(out, "program_04_percent", p->budget.program_04_percent);
    number(out, "program_05_us", p->budget.program_05_us);
    number(out, "instructions_per_us", p->budget.instructions_per_us);
    fputc('\n', out);
}

static void write_experiment(FILE *out, const struct planned *planned)
{
    const struct experiment *e = &planned->experiment;
    char hash[RULE_BOOK_HASH];
    if (planned->inapplicable)
        return;
    fprintf(out, "  experiment %s", planned->row.name);
    number(out, "cycle_us", e->host.cycle_us);
    number(out, "cycles", e->cycles);
    number(out, "without_bus", e->host.without_bus);
    number(out, "mutation", e->host.mutation.kind);
    number(out, "value", e->host.mutation.value);
    number(out, "poison", e->poison);
    number(out, "places", e->places);
    number(out, "data_bytes", e->host.data_bytes);
    number(out, "counters", e->host.counters);
    number(out, "reload_ns", e->reload_ns);
    number(out, "digest_cycles", e->host.digest_cycles);
    number(out, "traced", e->traced);
    number(out, "preempt", e->host.preempt.mode);
    number(out, "at", e->host.preempt.at);
    number(out, "calls", e->host.preempt.calls);
    if (e->host.faults != NULL) {
        sha256_text(e->host.faults, strlen(e->host.faults), hash);
        fprintf(out, " faults=%s", hash);
    }
    fputc('\n', out);
}

static void write_profile(FILE *out, const struct profile *profile)
{
    const struct check_options options = { .profile = profile };
    struct planned plan[EXPERIMENT_COUNT];
    char wanted[PROFILE_WANTED];
    fprintf(out, "profile %s region=%" PRIu64 " stack=%" PRIu32 "\n", profile->name,
            profile->region_bytes, profile->stack_bytes);
    fprintf(out, "  %s\n  exports", profile_wanted(profile, wanted));
    for (const char *const *name = profile->exports; *name != NULL; name++)
        fprintf(out, " %s", *name);
    if (profile->optional != NULL)
        fprintf(out, " (%s)", profile->optional);
    fputc('\n', out);
    write_product(out, product_find(profile->product));
    plan_experiments(&options, plan);
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        write_experiment(out, &plan[id]);
}

void rule_book_write(FILE *out)
{
    const struct check_options options = { .profile = profile_at(0) };
    struct planned plan[EXPERIMENT_COUNT];
    plan_experiments(&options, plan);
    for (size_t i = 0; rule_at(i) != NULL; i++)
        write_rule(out, rule_at(i), plan);
    for (size_t i = 0; profile_at(i) != NULL; i++)
        write_profile(out, profile_at(i));
}

void rule_book_hash(char hash[RULE_BOOK_HASH])
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (out == NULL)
        abort(); /* a wrong hash would be worse */
    rule_book_write(out);
    if (fclose(out) != 0)
        abort();
    sha256_text(text, size, hash);
    free(text);
}
