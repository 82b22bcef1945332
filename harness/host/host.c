/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* AL states are read every so many cycles: more often than anything reacts to them. */
enum { POLL_CYCLES = 4 };

#define LIST_ACTS(host, moment)                                                                    \
    do {                                                                                           \
        size_t count_ = 0;                                                                         \
        for (size_t part_ = 0; host_parts[part_] != NULL; part_++)                                 \
            if (host_parts[part_]->moment != NULL)                                                 \
                (host)->acts.moment[count_++] = host_parts[part_]->moment;                         \
    } while (0)

/* Every part that wants to act at this moment, in order. */
#define ACT(host, moment)                                                                          \
    do {                                                                                           \
        for (void (**act_)(struct host *) = (host)->acts.moment; *act_ != NULL; act_++)            \
            (*act_)(host);                                                                         \
    } while (0)

static void list_acts(struct host *host)
{
    LIST_ACTS(host, cycle);
    LIST_ACTS(host, receive);
    LIST_ACTS(host, send);
    LIST_ACTS(host, profile);
    LIST_ACTS(host, slot);
    LIST_ACTS(host, sample);
}

static int parts_open(struct host *host, char why[HOST_WHY])
{
    int r = 0;
    list_acts(host);
    for (size_t i = 0; host_parts[i] != NULL && r == 0; i++)
        if (host_parts[i]->open != NULL)
            r = host_parts[i]->open(host, why);
    return r;
}

static int bus_start(struct host *host, char why[HOST_WHY])
{
    struct bus_startup *startup = calloc(BUS_MAX_SLAVES * (size_t)WIRE_STARTUP, sizeof *startup);
    if (startup == NULL) {
        snprintf(why, HOST_WHY, "no memory");
        return -ENOMEM;
    }
    const struct bus_config config = {
        .devices = host->config.plant->devices,
        .device_count = host->config.plant->device_count,
        .cycle_ns = host->config.cycle_us * 1000,
        .seed = host->config.seed,
        .faults = host->config.faults,
        .faults_name = host->config.faults_name,
        .capture = host->config.capture,
        .library = host->config.plant->library,
        .redundant = host->config.plant->redundant,
        .dc_sync = host->config.clock == CLOCK_ON,
        .startup = startup,
        .startup_count =
            wire_startup(&host->config, startup, BUS_MAX_SLAVES * (size_t)WIRE_STARTUP),
    };
    const int r = bus_open(&host->bus, &config, why);
    free(startup);
    return r;
}

static int bus_ready(struct host *host, char why[HOST_WHY])
{
    if (host->bus == NULL)
        return 0;
    if (host->config.plant->as_found) {
        host->system->Main.Number_Servos = (uint32_t)host->axis_count;
        host->system->Main.Number_Dios = (uint32_t)host->terminal_count;
    } else if (host->axis_count != host_servos(host) ||
               host->terminal_count != host->config.plant->dios) {
        snprintf(why, HOST_WHY,
                 "the bus has %zu servos and %zu I/O units, the configuration says %u and %u",
                 host->axis_count, host->terminal_count, host_servos(host),
                 host->config.plant->dios);
        return -ENODEV;
    }
    host->evidence->slaves = (unsigned)bus_slave_count(host->bus);
    host->system->Main.Found_Total_Number_Of_ECAT_Devices = host->evidence->slaves;
    host->bus_zero = bus_now(host->bus);
    return 0;
}

static void periods_open(struct host *host)
{
    for (int i = 0; i < 3; i++) {
        uint32_t *period = &host->config.program_period_us[i];
        if (*period == 0)
            *period = host->config.product->program_period_us[i];
        if (*period == PERIOD_OFF) {
            *period = 0;
            host->due_ns[i] = NEVER_DUE;
        }
    }
}

static void close_host(struct host *host)
{
    rewind_free(host);
    races_close(host);
    if (host->bus != NULL)
        bus_close(host->bus);
    interpolators_close(host);
    digest_close(host);
    free(host);
}

static int open_host(struct host **out, const struct host_config *config, struct machine *machine,
                     const struct image *image, struct evidence *evidence, char why[HOST_WHY])
{
    int r = -ENOMEM;
    struct host *host = calloc(1, sizeof *host);
    if (host == NULL) {
        snprintf(why, HOST_WHY, "no memory");
        return r;
    }
    host->ops = &HOST_OPS;
    host->config = *config;
    host->machine = machine;
    host->image = image;
    host->evidence = evidence;
    host->real = config->real;
    host->schedule = schedule_find(config->product->schedule, config->cycle_us);
    evidence->op_cycle = EVIDENCE_NO_CYCLE;
    periods_open(host);
    if (host->schedule == NULL || !product_allows_cycle(config->product, config->cycle_us)) {
        snprintf(why, HOST_WHY, "%s has no Cycle_Time of %u us", config->product->title,
                 config->cycle_us);
        r = -EINVAL;
        goto out;
    }
    r = entries_open(host, why);
    if (r == 0)
        r = memories_open(host, why);
    if (r == 0 && !config->without_bus && config->plant->device_count > 0)
        r = bus_start(host, why);
    if (r == 0)
        r = parts_open(host, why);
    if (r == 0)
        plc_open(host);
    if (r == 0)
        r = bus_ready(host, why);
    if (r == 0)
        r = races_open(host, why);
    if (r == 0)
        memories_mutate(host);
out:
    if (r != 0) {
        close_host(host);
        return r;
    }
    *out = host;
    return 0;
}

void host_incident(struct host *host, enum entry entry, const struct machine_outcome *outcome)
{
    struct evidence *evidence = host->evidence;
    evidence->calls[entry].disabled = true;
    if (evidence->incident_count == EVIDENCE_INCIDENTS)
        return;
    struct evidence_incident *incident = &evidence->incidents[evidence->incident_count++];
    incident->entry = entry;
    incident->cycle = evidence->cycle;
    incident->kind = outcome->kind;
    incident->fault = outcome->fault;
    if (outcome->fault.service != NULL)
        snprintf(incident->service, sizeof incident->service, "%s", outcome->fault.service);
    incident->fault.service = NULL;
}

void host_calling(struct host *host, enum entry entry)
{
    host->evidence->entry = entry;
    host->evidence->stage = EVIDENCE_CALLING;
    host->preempt.called |= 1u << entry;
    watch_begin(host, entry);
}

bool host_called(struct host *host, enum entry entry, const struct machine_outcome *outcome)
{
    struct evidence *evidence = host->evidence;
    evidence->entry = entry;
    evidence->stage = EVIDENCE_BETWEEN;
    watch_end(host, entry, outcome);
    if (outcome->kind == MACHINE_ASIDE) {
        sleep_begins(host, entry, outcome->aside);
        return false;
    }
    preempt_done(host, entry);
    if (outcome->kind != MACHINE_RETURNED) {
        host_incident(host, entry, outcome);
        return false;
    }
    statistics_call(host, entry, outcome->elapsed_ns);
    evidence->calls[entry].count++;
    if (entry == ENTRY_04 && outcome->instructions != 0)
        sketch_note(&evidence->sketch, SKETCH_INSTRUCTIONS, (double)outcome->instructions);
    evidence->calls[entry].last_value = (int32_t)outcome->value;
    return true;
}

/* One call of one function; a function that once failed to return is not called again until the
 * module is loaded again. */
bool host_call(struct host *host, enum entry entry)
{
    struct evidence *evidence = host->evidence;
    struct machine_outcome outcome;
    if (evidence->calls[entry].disabled || host->entry_address[entry] == 0)
        return false;
    evidence->called_cycle[entry] = evidence->cycle;
    if (host->races != NULL)
        races_try(host, entry);
    preempt_plan(host, entry);
    host_calling(host, entry);
    machine_call(host->machine, host->entry_address[entry], host->plc_data_module[entry], &outcome);
    return host_called(host, entry, &outcome);
}

static bool start(struct host *host)
{
    if (host->config.resettable && host->copy == NULL)
        rewind_keep(host);
    host->evidence->cycle = EVIDENCE_NO_CYCLE;
    if (!host->config.no_autostart && !plc_begin(host))
        return false;
    if (host->real != NULL)
        realtime_start(host->real, host_time_of(host));
    host->evidence->cycle = 0;
    if (host->bus != NULL) {
        bus_supervise(host->bus, true);
        bus_request_op(host->bus);
        bus_faults_begin(host->bus, host->bus_zero);
    }
    return true;
}

static void note_bus(struct host *host)
{
    struct evidence *evidence = host->evidence;
    bool all_op = true;
    for (size_t i = 0; i < bus_slave_count(host->bus); i++)
        all_op = all_op && bus_slave(host->bus, i)->al_state == ETHERCAT_STATE_OP;
    evidence->all_op = all_op;
    host->in_op = host->in_op || all_op;
    if (all_op && evidence->op_cycle == EVIDENCE_NO_CYCLE)
        evidence->op_cycle = host->cycle;
}

static void note_axes(struct host *host)
{
    struct evidence *evidence = host->evidence;
    evidence->servo_count = (unsigned)host->axis_count;
    evidence->axis_count =
        (unsigned)(host->axis_count < EVIDENCE_AXES ? host->axis_count : EVIDENCE_AXES);
    for (unsigned i = 0; i < evidence->axis_count; i++)
        evidence->axis_position[i] = host->axes[i].actual;
}

/* As they are when the cycle is over: what the module commanded, what the drives answered. */
static void note_course(struct host *host)
{
    struct sketch *sketch = &host->evidence->sketch;
    for (unsigned i = 0; i < host->evidence->axis_count && i < SKETCH_AXES; i++) {
        const double position = host->axes[i].actual;
        const double commanded = host->axes[i].reg->WritePosition;
        sketch_note(sketch, sketch_of_axis(i, SKETCH_POSITION), position);
        sketch_note(sketch, sketch_of_axis(i, SKETCH_WRITE_POSITION), commanded);
        sketch_note(sketch, sketch_of_axis(i, SKETCH_LAG), commanded - position);
    }
    sketch_cycle(sketch);
}

static void note_faults(struct host *host)
{
    struct evidence *evidence = host->evidence;
    struct bus_fault_event event;
    for (; bus_fault_log(host->bus, host->fault_noted, &event); host->fault_noted++) {
        if (evidence->fault_count < EVIDENCE_FAULTS) {
            struct evidence_fault *fault = &evidence->faults[evidence->fault_count];
            fault->time_ns = (int64_t)(event.time_ns - host->bus_zero);
            snprintf(fault->text, sizeof fault->text, "%s", event.text);
        }
        evidence->fault_count++;
    }
}

static void receive(struct host *host)
{
    ACT(host, cycle);
    if (host->bus != NULL && host->cycle > host->loop_begin) {
        const uint64_t begin = host_stopwatch(host);
        const int wkc = bus_receive(host->bus, host->bus_zero + host->now_ns);
        host->measured.bus_ns += host_stopwatch(host) - begin;
        host->frame_back = wkc > 0;
        host->silent_cycles = host->frame_back ? 0 : host->silent_cycles + 1;
        host->exchanged = host->exchanged || host->frame_back;
        if (wkc < bus_expected_wkc(host->bus) && host->in_op)
            host->evidence->wkc_errors++;
        if (host->cycle % POLL_CYCLES == 0)
            bus_poll_states(host->bus);
        note_bus(host);
    }
    ACT(host, receive);
    note_axes(host);
}

static void send(struct host *host)
{
    ACT(host, send);
    if (host->bus == NULL)
        return;
    const uint64_t begin = host_stopwatch(host);
    bus_send(host->bus, host->bus_zero + host->now_ns);
    host->measured.bus_ns += host_stopwatch(host) - begin;
}

/* True when a call of the function has come to its end. */
static bool run_due(struct host *host, enum entry entry)
{
    if (sleep_is(host, entry))
        sleep_goes_on(host, entry);
    else if (host->now_ns >= host->due_ns[entry - ENTRY_01] && plc_calls(host))
        host_call(host, entry);
    else
        return false;
    return !sleep_is(host, entry);
}

/* Program_03, 02, 01, each when it is due or has slept long enough, and only if it is above the one
 * that is interrupted. */
static void call_due(struct host *host)
{
    const struct host_config *config = &host->config;
    const uint64_t base = host->plc.run_cycle * config->cycle_us * UINT64_C(1000);
    for (int i = 2; i >= 0 && ENTRY_01 + i > (int)host->preempt.interrupted; i--) {
        if (run_due(host, (enum entry)(ENTRY_01 + i)))
            host->due_ns[i] = base + schedule_due(config->product, config->program_period_us[i],
                                                  host->now_ns - base);
    }
}

/* In what is left of the slot; where the product has ticks, at those until the next slot. What is
 * interrupted on the real clock does not wait for ticks. */
static void background(struct host *host)
{
    const uint64_t tick = host->config.product->tick_us * UINT64_C(1000);
    if (tick == 0 || (host->real != NULL && host->preempt.interrupted != ENTRY_INI)) {
        call_due(host);
        return;
    }
    for (uint64_t at = (host->now_ns + tick - 1) / tick * tick; at < host_next_slot_ns(host);
         at = (host->now_ns / tick + 1) * tick) {
        if (host->real != NULL)
            realtime_pause(host->real, at);
        host->now_ns = at;
        call_due(host);
    }
}

static void exchange(struct host *host, const struct slot *slot)
{
    if (slot->actions & SLOT_RECEIVE)
        receive(host);
    if (slot->actions & SLOT_SEND)
        send(host);
    if (slot->actions & SLOT_PROFILE)
        ACT(host, profile);
    ACT(host, slot);
}

static void slot_run(struct host *host, const struct slot *slot)
{
    if (host->real != NULL)
        host->measured.latency_ns = realtime_wait(host->real, host->now_ns);
    if (!host->loop)
        return;
    if (host->real != NULL)
        measure_begin(&host->measured, slot->actions & SLOT_RECEIVE);
    exchange(host, slot);
    if (host->real != NULL)
        measure_end(&host->measured);
    if ((slot->actions & SLOT_PROGRAM_05) && plc_calls(host))
        host_call(host, ENTRY_05);
    if ((slot->actions & SLOT_PROGRAM_04) && plc_calls(host))
        host_call(host, ENTRY_04);
    if (slot->actions & SLOT_OSCILLOSCOPE) {
        ACT(host, sample);
        if (host->sample != NULL)
            host->sample(host->sample_argument, host);
    }
}

uint64_t host_time_of(const struct host *host)
{
    return host->cycle * host->config.cycle_us * UINT64_C(1000);
}

uint64_t host_next_slot_ns(const struct host *host)
{
    return host_time_of(host) + host->schedule->slots[host->slot].at_us * UINT64_C(1000);
}

void host_clear_parts(struct host *host)
{
    for (size_t i = 0; host_parts[i] != NULL; i++)
        if (host_parts[i]->clear != NULL)
            host_parts[i]->clear(host);
}

static void cycle_begin(struct host *host)
{
    host->evidence->cycle = host->cycle;
    if (host->real != NULL)
        realtime_cycle(host->real, host_time_of(host));
    if (host->preempt.interrupted == ENTRY_INI)
        host->loop = plc_cycle(host);
    host->in_op = host->in_op && host->loop;
}

static void cycle_end(struct host *host)
{
    struct evidence *evidence = host->evidence;
    if (host->bus != NULL)
        note_faults(host);
    note_course(host);
    host->slot = 0;
    host->cycle++;
    evidence->cycles_done = host->cycle;
    evidence->time_ns = host_time_of(host);
    if (host->real != NULL)
        realtime_cycle_end(host->real, evidence->time_ns);
}

/* What is in the background may be interrupted by further slots: everything of this one is over
 * then. */
void host_slot(struct host *host)
{
    if (host->slot == 0)
        cycle_begin(host);
    host->now_ns = host_next_slot_ns(host);
    slot_run(host, &host->schedule->slots[host->slot++]);
    if (host->slot == host->schedule->slot_count)
        cycle_end(host);
    if (host->loop)
        background(host);
}

static bool cycle(struct host *host)
{
    struct evidence *evidence = host->evidence;
    if (host->plc.anew) {
        host->plc.anew = false;
        if (rewind_back(host) && !start(host))
            return false;
    }
    for (const uint64_t number = host->cycle; host->cycle == number;)
        host_slot(host);
    if (host->plc.leave)
        return false;
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++)
        if (!evidence->calls[entry].disabled)
            return true;
    return false;
}

static bool played(const struct host *host)
{
    return host->play.scenario != NULL && host->evidence->play != PLAY_RUNNING;
}

static void on_sample(struct host *host, host_sample *sample, void *argument)
{
    host->sample = sample;
    host->sample_argument = argument;
}

static uint64_t cycles(const struct host *host)
{
    return host->cycle;
}

static uint64_t run_time(const struct host *host)
{
    return (host->cycle - host->plc.run_cycle) * host->config.cycle_us * UINT64_C(1000);
}

static const void *register_at(const struct host *host, const struct catalogue_register *reg)
{
    for (size_t i = 0; catalogue_memory(host->catalogue, i) != NULL; i++)
        if (catalogue_memory(host->catalogue, i) == reg->memory)
            return host_has_register(&host->config, reg)
                       ? (const char *)host->memory[i] + reg->offset
                       : NULL;
    return NULL;
}

const struct host_ops HOST_OPS = {
    .generation = TGM_GENERATION,
    .memory_id = ID_MEMORY_COMPATIBILITY,
    .open = open_host,
    .close = close_host,
    .start = start,
    .cycle = cycle,
    .played = played,
    .run = plc_run,
    .stop = plc_stop,
    .pause = plc_pause,
    .reset = plc_reset,
    .plc = plc_state,
    .run_time = run_time,
    .on_sample = on_sample,
    .osc_arm = scope_arm,
    .osc_samples = scope_samples,
    .osc_row = scope_row,
    .cycles = cycles,
    .time = host_time_of,
    .register_at = register_at,
    .interpolator_load = interpolator_load,
    .interpolator_start = interpolator_start,
    .interpolator_stop = interpolator_stop,
};
