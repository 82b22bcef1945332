/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Experiments, each in a worker process, as many at a time as there are jobs. */
#include "conformance/check_parts.h"

#include <errno.h>
#include <inttypes.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define JOBS_MOST 64

/* What the threads that start workers share. Each takes the next of the queue until it is empty. */
struct queue {
    struct check *check;
    const struct check_options *options;
    int ids[EXPERIMENT_COUNT];
    int count;
    atomic_int next;
    double seconds[EXPERIMENT_COUNT]; /* by place in ids */
    int errors[EXPERIMENT_COUNT];     /* likewise */
};

static void run_one(struct queue *queue, int place)
{
    struct case_run *run = &queue->check->runs[queue->ids[place]];
    struct experiment *experiment = &run->plan.experiment;
    const struct check_options *options = queue->options;
    const double begin = check_seconds();
    if (options->capture != NULL && !experiment->host.without_bus)
        experiment->host.capture = options->capture(options->capture_argument, experiment->name);
    queue->errors[place] =
        experiment_run(experiment, queue->check->image, NULL, NULL, NULL, &run->result);
    run->ran = queue->errors[place] == 0;
    queue->seconds[place] = check_seconds() - begin;
}

static void *work(void *argument)
{
    struct queue *queue = argument;
    for (int place; (place = atomic_fetch_add(&queue->next, 1)) < queue->count;)
        run_one(queue, place);
    return NULL;
}

/* A capture is written by one run at a time. */
static unsigned jobs_of(const struct check_options *options)
{
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const unsigned jobs = options->jobs != 0 ? options->jobs : cores > 0 ? (unsigned)cores : 1;
    if (options->capture != NULL)
        return 1;
    return jobs < JOBS_MOST ? jobs : JOBS_MOST;
}

/* A worker that a thread forks goes on with that thread's arena of the allocator, which grows by a
 * system call that a sealed process may not make; the main one does not. */
void check_share_arena(void)
{
    mallopt(M_ARENA_MAX, 1);
}

static void run_all(struct queue *queue)
{
    pthread_t threads[JOBS_MOST];
    const unsigned jobs = jobs_of(queue->options);
    unsigned made = 1;
    check_share_arena();
    while (made < jobs && made < (unsigned)queue->count &&
           pthread_create(&threads[made], NULL, work, queue) == 0)
        made++;
    work(queue); /* this thread is one of them, and all of them when no other could be made */
    while (--made > 0)
        pthread_join(threads[made], NULL);
}

/* The group of rules that an experiment is made for: that of the first rule that wants it. */
static enum rule_group group_of(const struct check *check, int id)
{
    for (size_t i = 0; i < check->report.rule_count; i++)
        if (experiment_in(check->chosen[i]->experiments, id))
            return check->chosen[i]->group;
    return GROUP_CYCLE;
}

/* The time that went by, in proportion to what each took. */
static void share_time(struct queue *queue, double elapsed)
{
    double all = 0;
    for (int i = 0; i < queue->count; i++)
        all += queue->seconds[i];
    for (int i = 0; i < queue->count && all > 0; i++)
        queue->check->groups[group_of(queue->check, queue->ids[i])].seconds +=
            elapsed * queue->seconds[i] / all;
}

int check_run_experiments(struct check *check, const struct check_options *options, uint64_t wanted,
                          char why[CHECK_WHY])
{
    struct queue queue = { .check = check, .options = options };
    const double begin = check_seconds();
    if (check->cannot_run[0] != '\0')
        return 0;
    for (int id = 0; id < EXPERIMENT_COUNT; id++)
        if (experiment_in(wanted, id) && !check->runs[id].plan.inapplicable)
            queue.ids[queue.count++] = id;
    run_all(&queue);
    share_time(&queue, check_seconds() - begin);
    for (int i = 0; i < queue.count; i++)
        if (queue.errors[i] != 0) {
            snprintf(why, CHECK_WHY, "experiment %s: no worker process: %s",
                     check->runs[queue.ids[i]].plan.experiment.name, strerror(-queue.errors[i]));
            return queue.errors[i];
        }
    return 0;
}

/* A run that could not begin because of the scenario is a wrong call. */
static int run_scenario(struct check *check, const struct check_options *options, size_t index,
                        char why[CHECK_WHY])
{
    struct case_scenario *played = &check->scenarios[index];
    const struct product *product = product_find(options->profile->product);
    char name[40];
    snprintf(name, sizeof name, "scenario-%zu", index + 1);
    played->scenario = options->scenarios[index].scenario;
    played->name = options->scenarios[index].path;
    struct host_config around = { .plant = &plant_default, .cycle_us = product->default_cycle_us };
    if (options->around != NULL)
        around = *options->around;
    around.product = product;
    around.seed = options->seed;
    around.scenario = played->scenario;
    if (options->capture != NULL)
        around.capture = options->capture(options->capture_argument, name);
    played->experiment =
        (struct experiment){ .name = "scenario",
                             .host = around,
                             .cycles = scenario_cycles(played->scenario, around.cycle_us),
                             .until_played = true };
    int r = experiment_run(&played->experiment, check->image, NULL, NULL, NULL, &played->result);
    if (r != 0) {
        snprintf(why, CHECK_WHY, "%s: no worker process: %s", played->name, strerror(-r));
        return r;
    }
    played->ran = true;
    if (played->result.evidence.play == PLAY_NONE && played->result.evidence.trouble[0] != '\0') {
        snprintf(why, CHECK_WHY, "%s", played->result.evidence.trouble);
        return -EINVAL;
    }
    return 0;
}

int check_run_scenarios(struct check *check, const struct check_options *options,
                        char why[CHECK_WHY])
{
    const double begin = check_seconds();
    check->scenarios = calloc(options->scenario_count, sizeof *check->scenarios);
    if (check->scenarios == NULL) {
        snprintf(why, CHECK_WHY, "no memory");
        return -ENOMEM;
    }
    for (size_t i = 0; i < options->scenario_count && check->cannot_run[0] == '\0'; i++) {
        int r = run_scenario(check, options, i, why);
        if (r != 0)
            return r;
    }
    check->groups[GROUP_MACHINE].seconds = check_seconds() - begin;
    return 0;
}
