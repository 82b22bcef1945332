/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What happened in a run, in the order of time. */
#include "conformance/chronicle.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/scenario.h"

/* More than a run can have stored. */
#define EVENTS                                                                                     \
    (EVIDENCE_INCIDENTS + EVIDENCE_MESSAGES + EVIDENCE_FAULTS + EVIDENCE_FAILURES +                \
     EVIDENCE_LINES + 4)

struct teller {
    const struct experiment *experiment;
    const struct evidence *evidence;
    struct timeline_report *timeline;
};

static double cycle_seconds(const struct teller *teller, uint64_t cycle)
{
    return cycle == EVIDENCE_NO_CYCLE ? 0
                                      : (double)cycle * teller->experiment->host.cycle_us * 1e-6;
}

static struct timeline_event *add(const struct teller *teller, enum timeline_kind kind,
                                  double seconds, const char *source, const char *text)
{
    struct timeline_event *event = &teller->timeline->events[teller->timeline->event_count++];
    event->kind = kind;
    event->seconds = seconds;
    event->count = 1;
    snprintf(event->source, sizeof event->source, "%s", source);
    snprintf(event->text, sizeof event->text, "%s", text);
    return event;
}

static void add_in_cycle(const struct teller *teller, enum timeline_kind kind, uint64_t cycle,
                         const char *source, const char *text)
{
    struct timeline_event *event = add(teller, kind, cycle_seconds(teller, cycle), source, text);
    event->has_cycle = cycle != EVIDENCE_NO_CYCLE;
    event->cycle = event->has_cycle ? cycle : 0;
}

/* The same text again is one event with a count: a module that prints in every cycle. */
static void add_message(const struct teller *teller, const struct evidence_message *message)
{
    const char *speaker = evidence_speaker(message);
    struct timeline_report *timeline = teller->timeline;
    struct timeline_event *last =
        timeline->event_count > 0 ? &timeline->events[timeline->event_count - 1] : NULL;
    if (last != NULL && last->kind == TIMELINE_MESSAGE && strcmp(last->source, speaker) == 0 &&
        strncmp(last->text, message->text, sizeof last->text - 1) == 0)
        last->count++;
    else
        add_in_cycle(teller, TIMELINE_MESSAGE, message->cycle, speaker, message->text);
}

static uint64_t least_of(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static void tell_messages(const struct teller *teller)
{
    const struct evidence *evidence = teller->evidence;
    const uint64_t stored = least_of(evidence->message_count, EVIDENCE_MESSAGES);
    for (uint64_t i = 0; i < stored; i++)
        add_message(teller, &evidence->messages[i]);
    teller->timeline->dropped += evidence->message_count - stored;
}

static void tell_faults(const struct teller *teller)
{
    const struct evidence *evidence = teller->evidence;
    const uint64_t stored = least_of(evidence->fault_count, EVIDENCE_FAULTS);
    for (uint64_t i = 0; i < stored; i++)
        add(teller, TIMELINE_FAULT, (double)evidence->faults[i].time_ns * 1e-9, "bus",
            evidence->faults[i].text);
    teller->timeline->dropped += evidence->fault_count - stored;
}

static void tell_incidents(const struct teller *teller)
{
    char text[FINDING_TEXT];
    for (unsigned i = 0; i < teller->evidence->incident_count; i++) {
        const struct evidence_incident *incident = &teller->evidence->incidents[i];
        incident_describe(incident, text);
        add_in_cycle(teller, TIMELINE_INCIDENT, incident->cycle, entry_name(incident->entry), text);
    }
}

static void tell_scenario(const struct teller *teller, const struct scenario *scenario)
{
    const struct evidence *evidence = teller->evidence;
    const uint64_t lines = least_of(evidence->line_count, EVIDENCE_LINES);
    char text[SCENARIO_TEXT];
    if (scenario == NULL)
        return;
    for (unsigned i = 0; i < evidence->failure_count; i++) {
        const struct evidence_failure *failure = &evidence->failures[i];
        scenario_tell(scenario, failure, text);
        add(teller, TIMELINE_EXPECTATION, (double)failure->time_ns * 1e-9, "scenario", text)
            ->count = failure->count > 0 ? failure->count : 1;
    }
    for (uint64_t i = 0; i < lines; i++) {
        scenario_tell_line(scenario, &evidence->lines[i], text);
        add(teller, TIMELINE_MESSAGE, (double)evidence->lines[i].time_ns * 1e-9, "scenario", text);
    }
    teller->timeline->dropped += evidence->line_count - lines;
}

static void tell_states(const struct teller *teller, const struct experiment_result *result)
{
    const struct evidence *evidence = teller->evidence;
    const bool cycles = evidence->cycles_done > 0 && evidence->slaves > 0;
    const double end = (double)evidence->time_ns * 1e-9;
    if (cycles && evidence->op_cycle != EVIDENCE_NO_CYCLE)
        add_in_cycle(teller, TIMELINE_STATE, evidence->op_cycle, "bus",
                     evidence->slaves == 1 ? "the slave is in OP" : "every slave is in OP");
    else if (cycles)
        add(teller, TIMELINE_STATE, end, "bus", "not every slave has reached OP");
    if (evidence->trouble[0] != '\0')
        add(teller, TIMELINE_STATE, end, "harness", evidence->trouble);
    else if (result->worker.end != WORKER_DONE)
        add(teller, TIMELINE_STATE, end, "harness", "the process of the run was ended");
}

/* Events of one moment keep their order. */
static void sort_by_time(struct timeline_report *timeline)
{
    for (size_t i = 1; i < timeline->event_count; i++) {
        const struct timeline_event event = timeline->events[i];
        size_t at = i;
        for (; at > 0 && timeline->events[at - 1].seconds > event.seconds; at--)
            timeline->events[at] = timeline->events[at - 1];
        timeline->events[at] = event;
    }
}

int chronicle_timeline(struct timeline_report *timeline, const struct experiment *experiment,
                       const struct experiment_result *result, const struct scenario *scenario)
{
    const struct teller teller = { experiment, &result->evidence, timeline };
    const struct evidence *evidence = &result->evidence;
    *timeline = (struct timeline_report){ .events = calloc(EVENTS, sizeof *timeline->events) };
    if (timeline->events == NULL)
        return -ENOMEM;
    snprintf(timeline->name, sizeof timeline->name, "%s", experiment->name);
    if (experiment->cycles > 0)
        snprintf(timeline->about, sizeof timeline->about, "Cycle_Time %u us, %" PRIu64 " cycles%s",
                 experiment->host.cycle_us, evidence->cycles_done,
                 evidence->instrumented ? ", instrumented" : "");
    else
        snprintf(timeline->about, sizeof timeline->about, "Program_Ini alone%s",
                 evidence->instrumented ? ", instrumented" : "");
    timeline->seconds = (double)evidence->time_ns * 1e-9;
    tell_states(&teller, result);
    tell_messages(&teller);
    tell_faults(&teller);
    tell_incidents(&teller);
    tell_scenario(&teller, scenario);
    sort_by_time(timeline);
    return 0;
}

static int add_run(struct chronicle *chronicle, const struct experiment *experiment,
                   const struct experiment_result *result, const struct case_scenario *played,
                   bool in_full)
{
    struct timeline_report *timeline = &chronicle->timelines[chronicle->timeline_count];
    const int r =
        chronicle_timeline(timeline, experiment, result, played != NULL ? played->scenario : NULL);
    if (r != 0)
        return r;
    chronicle->timeline_count++;
    timeline->in_full = in_full;
    if (played != NULL)
        snprintf(timeline->name, sizeof timeline->name, "%s", played->name);
    return 0;
}

/* What Program_Ini alone does is in the rules of its group; here only what went wrong in it. */
static bool worth_telling(const struct case_run *run)
{
    return run->ran &&
           (run->plan.experiment.cycles > 0 || run->result.evidence.incident_count > 0 ||
            run->result.evidence.trouble[0] != '\0');
}

/* The usual run at the product's default Cycle_Time. */
static bool worth_drawing(const struct case_file *file, int id)
{
    const struct case_run *run = &file->runs[id];
    return run->ran && experiment_in(ON_CYCLES, id) &&
           (run->plan.experiment.host.cycle_us ==
                product_find(file->profile->product)->default_cycle_us ||
            id == EXPERIMENT_CYCLE_500);
}

static int add_plot(struct chronicle *chronicle, const char *name,
                    const struct experiment *experiment, const struct sketch *sketch)
{
    struct plot_report *plot = &chronicle->plots[chronicle->plot_count];
    const int r = chronicle_plot(plot, name, experiment, sketch);
    if (r == 0 && plot->curve_count > 0)
        chronicle->plot_count++;
    return r;
}

static int add_all(struct chronicle *chronicle, const struct case_file *file)
{
    bool drawn = false;
    int r = 0;
    for (int id = 0; id < EXPERIMENT_COUNT && r == 0; id++)
        if (worth_telling(&file->runs[id]))
            r = add_run(chronicle, &file->runs[id].plan.experiment, &file->runs[id].result, NULL,
                        worth_drawing(file, id));
    for (size_t i = 0; i < file->scenario_count && r == 0; i++)
        if (file->scenarios[i].ran)
            r = add_run(chronicle, &file->scenarios[i].experiment, &file->scenarios[i].result,
                        &file->scenarios[i], true);
    for (int id = 0; id < EXPERIMENT_COUNT && r == 0 && !drawn; id++)
        if ((drawn = worth_drawing(file, id)))
            r = add_plot(chronicle, file->runs[id].plan.experiment.name,
                         &file->runs[id].plan.experiment, &file->runs[id].result.evidence.sketch);
    for (size_t i = 0; i < file->scenario_count && r == 0; i++)
        if (file->scenarios[i].ran)
            r = add_plot(chronicle, file->scenarios[i].name, &file->scenarios[i].experiment,
                         &file->scenarios[i].result.evidence.sketch);
    return r == 0 ? chronicle_coverage(chronicle, file) : r;
}

int chronicle_make(struct chronicle *chronicle, const struct case_file *file)
{
    const size_t most = EXPERIMENT_COUNT + file->scenario_count;
    *chronicle = (struct chronicle){ .timelines = calloc(most, sizeof *chronicle->timelines),
                                     .plots = calloc(most, sizeof *chronicle->plots) };
    const int r = chronicle->timelines != NULL && chronicle->plots != NULL
                      ? add_all(chronicle, file)
                      : -ENOMEM;
    if (r != 0)
        chronicle_free(chronicle);
    return r;
}

void chronicle_free(struct chronicle *chronicle)
{
    for (size_t i = 0; i < chronicle->timeline_count; i++)
        free(chronicle->timelines[i].events);
    for (size_t i = 0; i < chronicle->plot_count; i++)
        chronicle_plot_free(&chronicle->plots[i]);
    free(chronicle->timelines);
    free(chronicle->plots);
    free(chronicle->coverage);
    *chronicle = (struct chronicle){ 0 };
}
