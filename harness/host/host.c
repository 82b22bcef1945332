/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct bus_stimulus button = { .bit = 0,
                                            .period_ns = 400000000,
                                            .phase_ns = 100000000 };
static const struct bus_device default_devices[] = {
    { .type = "drive-cia402" },
    { .type = "dio-8x8", .stimuli = &button, .stimulus_count = 1 },
};
const struct plant plant_default = { default_devices, 2, 1, 1 };

static int bus_start(struct host *host, char why[HOST_WHY])
{
    const struct bus_config config = {
        .devices = host->config.plant->devices,
        .device_count = host->config.plant->device_count,
        .cycle_ns = host->config.cycle_us * 1000,
        .seed = host->config.seed,
        .capture = host->config.capture,
    };
    int r = bus_open(&host->bus, &config, why);
    if (r == 0)
        r = servo_open(host, why);
    if (r == 0)
        r = dio_open(host, why);
    if (r != 0)
        return r;
    if (host->axis_count != host->config.plant->servos ||
        host->terminal_count != host->config.plant->dios) {
        snprintf(why, HOST_WHY,
                 "the bus has %zu servos and %zu I/O units, the configuration says %u and %u",
                 host->axis_count, host->terminal_count, host->config.plant->servos,
                 host->config.plant->dios);
        return -ENODEV;
    }
    host->evidence->slaves = (unsigned)bus_slave_count(host->bus);
    host->system->Main.Found_Total_Number_Of_ECAT_Devices = host->evidence->slaves;
    host->system->Main.StateDistributedClock = 1;
    host->system->Main.Distributed_Clock = 1;
    host->bus_zero = bus_now(host->bus);
    return 0;
}

static int find_entries(struct host *host, char why[HOST_WHY])
{
    for (int entry = 0; entry < ENTRY_COUNT; entry++) {
        const struct image_symbol *symbol =
            image_export(host->image, entry_name((enum entry)entry));
        if (symbol == NULL || !symbol->executable) {
            snprintf(why, HOST_WHY, "the module does not export the function %s",
                     entry_name((enum entry)entry));
            return -ENOENT;
        }
        host->entry_address[entry] = symbol->vaddr;
    }
    return 0;
}

int host_open(struct host **out, const struct host_config *config, struct machine *machine,
              const struct image *image, struct evidence *evidence, char why[HOST_WHY])
{
    int r = -ENOMEM;
    struct host *host = calloc(1, sizeof *host);
    if (host == NULL) {
        snprintf(why, HOST_WHY, "no memory");
        return r;
    }
    host->config = *config;
    host->machine = machine;
    host->image = image;
    host->evidence = evidence;
    host->schedule = schedule_find(config->cycle_us);
    evidence->op_cycle = EVIDENCE_NO_CYCLE;
    for (int i = 0; i < 3; i++)
        if (host->config.program_period_us[i] == 0)
            host->config.program_period_us[i] = config->product->program_period_us[i];
    if (host->schedule == NULL || !product_allows_cycle(config->product, config->cycle_us)) {
        snprintf(why, HOST_WHY, "%s has no Cycle_Time of %u us", config->product->title,
                 config->cycle_us);
        r = -EINVAL;
        goto out;
    }
    r = find_entries(host, why);
    if (r == 0)
        r = memories_open(host, why);
    if (r == 0 && !config->without_bus)
        r = bus_start(host, why);
    if (r == 0)
        memories_mutate(host);
out:
    if (r != 0) {
        host_close(host);
        return r;
    }
    *out = host;
    return 0;
}

void host_close(struct host *host)
{
    if (host == NULL)
        return;
    if (host->bus != NULL)
        bus_close(host->bus);
    free(host);
}

static void record_incident(struct host *host, enum entry entry,
                            const struct machine_outcome *outcome)
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

/* One call of one function; a function that once failed to return is not called again. */
static bool call(struct host *host, enum entry entry)
{
    struct evidence *evidence = host->evidence;
    struct machine_outcome outcome;
    if (evidence->calls[entry].disabled)
        return false;
    evidence->entry = entry;
    evidence->stage = EVIDENCE_CALLING;
    machine_call(host->machine, host->entry_address[entry], host->plc_data_module[entry], &outcome);
    evidence->stage = EVIDENCE_BETWEEN;
    if (outcome.kind != MACHINE_RETURNED) {
        record_incident(host, entry, &outcome);
        return false;
    }
    evidence->calls[entry].count++;
    evidence->calls[entry].last_value = (int32_t)outcome.value;
    return true;
}

bool host_start(struct host *host)
{
    host->evidence->cycle = EVIDENCE_NO_CYCLE;
    if (!call(host, ENTRY_INI) || host->evidence->calls[ENTRY_INI].last_value != 1)
        return false;
    host->evidence->cycle = 0;
    if (host->bus != NULL)
        bus_request_op(host->bus);
    return true;
}

/* TIMERS: one step each millisecond; up counts for ever, down stops at 0. */
static void timers_advance(struct host *host)
{
    TIMERS *timers = &host->system->Timers;
    for (const uint64_t ms = host->now_ns / 1000000; host->timer_ms < ms; host->timer_ms++)
        for (int i = 0; i < MAX_TIMER_UP; i++) {
            timers->Timer_Up[i]++;
            timers->Timer_Down[i] -= timers->Timer_Down[i] > 0;
        }
}

static void note_bus(struct host *host)
{
    struct evidence *evidence = host->evidence;
    bool all_op = true;
    for (size_t i = 0; i < bus_slave_count(host->bus); i++)
        all_op = all_op && bus_slave(host->bus, i)->al_state == ETHERCAT_STATE_OP;
    evidence->all_op = all_op;
    if (all_op && evidence->op_cycle == EVIDENCE_NO_CYCLE)
        evidence->op_cycle = host->cycle;
}

static void note_axes(struct host *host)
{
    struct evidence *evidence = host->evidence;
    evidence->axis_count =
        (unsigned)(host->axis_count < EVIDENCE_AXES ? host->axis_count : EVIDENCE_AXES);
    for (unsigned i = 0; i < evidence->axis_count; i++)
        evidence->axis_position[i] = host->axes[i].reg->Position;
}

static void receive(struct host *host)
{
    host->system->Header.Life_Tick++;
    host->system->Main.Servo_Tick++;
    timers_advance(host);
    if (host->bus == NULL)
        return;
    if (host->cycle > 0) {
        const int wkc = bus_receive(host->bus, host->bus_zero + host->now_ns);
        host->exchanged = host->exchanged || wkc > 0;
        if (wkc < bus_expected_wkc(host->bus) && host->evidence->op_cycle != EVIDENCE_NO_CYCLE)
            host->evidence->wkc_errors++;
        bus_poll_state(host->bus, host->poll_next);
        host->poll_next = (host->poll_next + 1) % bus_slave_count(host->bus);
        note_bus(host);
    }
    servo_receive(host);
    dio_receive(host);
    note_axes(host);
}

static void send(struct host *host)
{
    if (host->bus == NULL)
        return;
    servo_send(host);
    dio_send(host);
    bus_send(host->bus, host->bus_zero + host->now_ns);
}

/* Program_03, 02, 01 in what is left of the slot, each when its period is due; missed periods are
 * not made up for (R6). */
static void background(struct host *host)
{
    for (int i = 2; i >= 0; i--) {
        const uint64_t period = host->config.program_period_us[i] * UINT64_C(1000);
        if (host->now_ns < host->due_ns[i])
            continue;
        call(host, (enum entry)(ENTRY_01 + i));
        while (host->due_ns[i] <= host->now_ns)
            host->due_ns[i] += period;
    }
}

static void slot_run(struct host *host, const struct slot *slot)
{
    host->now_ns =
        host->cycle * host->config.cycle_us * UINT64_C(1000) + slot->at_us * UINT64_C(1000);
    if (slot->actions & SLOT_RECEIVE)
        receive(host);
    if (slot->actions & SLOT_SEND)
        send(host);
    if (slot->actions & SLOT_PROGRAM_05)
        call(host, ENTRY_05);
    if (slot->actions & SLOT_PROGRAM_04)
        call(host, ENTRY_04);
    if ((slot->actions & SLOT_OSCILLOSCOPE) && host->sample != NULL)
        host->sample(host->sample_argument, host);
    background(host);
}

bool host_cycle(struct host *host)
{
    struct evidence *evidence = host->evidence;
    evidence->cycle = host->cycle;
    for (size_t i = 0; i < host->schedule->slot_count; i++)
        slot_run(host, &host->schedule->slots[i]);
    host->cycle++;
    evidence->cycles_done = host->cycle;
    evidence->time_ns = host_time(host);
    for (int entry = ENTRY_01; entry < ENTRY_COUNT; entry++)
        if (!evidence->calls[entry].disabled)
            return true;
    return false;
}

void host_on_sample(struct host *host, host_sample *sample, void *argument)
{
    host->sample = sample;
    host->sample_argument = argument;
}

uint64_t host_cycles(const struct host *host)
{
    return host->cycle;
}

uint64_t host_time(const struct host *host)
{
    return host->cycle * host->config.cycle_us * UINT64_C(1000);
}

const void *host_register(const struct host *host, const struct catalogue_register *reg)
{
    for (size_t i = 0; catalogue_memory(i) != NULL; i++)
        if (catalogue_memory(i) == reg->memory)
            return (const char *)host->memory[i] + reg->offset;
    return NULL;
}
