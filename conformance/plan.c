/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/plan.h"

#include "conformance/check.h"

static void read_rows(const struct product *product, struct planned plan[EXPERIMENT_COUNT])
{
    const struct experiment_row rows[EXPERIMENT_COUNT] = {
#define EXPERIMENT(symbol, name_, ...) [EXPERIMENT_##symbol] = { .name = name_, __VA_ARGS__ },
#include "conformance/experiments.def"
#undef EXPERIMENT
    };
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        plan[i] = (struct planned){ .row = rows[i],
                                    .inapplicable = rows[i].generation != 0 &&
                                                    rows[i].generation != product->generation };
}

/* Under a configuration there is one Cycle_Time, and of the experiments that differ in nothing else
 * one has it. */
static void one_cycle_only(struct planned *planned, int id)
{
    if (id == EXPERIMENT_CYCLE_250 || id == EXPERIMENT_CYCLE_1000 || id == EXPERIMENT_TRACED_250 ||
        id == EXPERIMENT_TRACED_1000)
        planned->inapplicable = true;
    if (id == EXPERIMENT_CYCLE_500)
        planned->experiment.name = "cycle";
    if (id == EXPERIMENT_TRACED_500)
        planned->experiment.name = "traced";
}

static uint64_t cycles_of(const struct check_options *options, const struct experiment_row *row,
                          uint32_t cycle_us)
{
    const uint32_t milliseconds =
        row->milliseconds != 0 ? row->milliseconds : CHECK_SECONDS * UINT32_C(1000);
    if (row->cycle_us == 0)
        return 0;
    const uint64_t least = row->least_ms * UINT64_C(1000) / cycle_us;
    const uint64_t wanted =
        options->cycles != 0 ? options->cycles : milliseconds * UINT64_C(1000) / cycle_us;
    return wanted > least ? wanted : least;
}

/* Runs of different length are compared as far as each of them goes. */
static uint32_t digest_cycles(const struct experiment *experiment)
{
    const uint64_t wanted = CHECK_DIGEST_MS * UINT64_C(1000) / experiment->host.cycle_us;
    const uint64_t most = wanted < DIGEST_STATES ? wanted : DIGEST_STATES;
    return (uint32_t)(most < experiment->cycles ? most : experiment->cycles);
}

/* Under a configuration as well, which `tgm run` takes, too. */
static bool is_plain(const struct experiment_row *row, const struct experiment *e)
{
    return row->mutation.kind == MUTATION_NONE && row->poison == MACHINE_POISON_NONE &&
           row->places == 0 && !e->instrumented && row->counters == 0 && row->restart_ms == 0 &&
           row->preempt.mode == PREEMPT_NONE && row->faults == NULL && row->data_bytes == 0;
}

static void plan_one(const struct check_options *options, const struct product *product, int id,
                     struct planned *planned)
{
    const struct experiment_row *row = &planned->row;
    struct experiment *e = &planned->experiment;
    e->name = row->name;
    e->host = (struct host_config){ .plant = &plant_default };
    if (options->around != NULL)
        e->host = *options->around;
    e->host.product = product;
    planned->inapplicable = planned->inapplicable || (row->usual_bus && options->around != NULL);
    if (options->around == NULL)
        e->host.cycle_us = row->cycle_us != 0 ? row->cycle_us : product->default_cycle_us;
    else
        one_cycle_only(planned, id);
    e->host.seed = options->seed;
    /* What a bus file announces is known when the bus is there. */
    e->host.without_bus = row->cycle_us == 0 && !e->host.plant->as_found;
    e->host.mutation = row->mutation;
    e->poison = row->poison;
    e->places = row->places;
    /* Interrupts are tried on this computer's processor alone. */
    e->instrumented =
        row->instrumented || (options->instrumented && row->preempt.mode == PREEMPT_NONE);
    e->traced = row->traced;
    if (row->data_bytes != 0)
        e->host.data_bytes = row->data_bytes;
    e->host.counters = row->counters;
    e->host.kept_module = row->restart_ms != 0;
    e->reload_ns = row->restart_ms * UINT64_C(1000000);
    e->host.preempt = row->preempt;
    if (row->faults != NULL) {
        e->host.faults = row->faults;
        e->host.faults_name = row->name;
    }
    e->cycles = cycles_of(options, row, e->host.cycle_us);
    e->plain = is_plain(row, e);
    if (row->digest)
        e->host.digest_cycles = digest_cycles(e);
}

void plan_experiments(const struct check_options *options, struct planned plan[EXPERIMENT_COUNT])
{
    const struct product *product = product_find(options->profile->product);
    read_rows(product, plan);
    for (int i = 0; i < EXPERIMENT_COUNT; i++)
        plan_one(options, product, i, &plan[i]);
}
