/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/client.h"
#include "bus/fiber.h"
#include "bus/library.h"
#include "bus/spread.h"

#include <errno.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* SOEM's mapping code keeps static state: one configuration at a time in the process. */
static pthread_mutex_t configuring = PTHREAD_MUTEX_INITIALIZER;

static int fail(char why[BUS_WHY], int error, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, BUS_WHY, format, arguments);
    va_end(arguments);
    return error;
}

/* Consecutive slaves' seeds differ in all bits. */
static uint64_t slave_seed(uint64_t seed, size_t index)
{
    return spread(seed + SPREAD_STEP * (index + 1));
}

static int build_segment(struct bus *bus, const struct bus_config *config, char why[BUS_WHY])
{
    bus->slaves = calloc(config->device_count, sizeof *bus->slaves);
    if (!bus->slaves)
        return fail(why, -ENOMEM, "no memory for %zu slaves", config->device_count);
    for (size_t i = 0; i < config->device_count; i++) {
        const struct bus_device *device = &config->devices[i];
        struct slave_setup setup = { .type = library_find(config->library, device->type),
                                     .seed = slave_seed(config->seed, i),
                                     .serial = (uint32_t)(i + 1),
                                     .stimuli = device->stimuli,
                                     .stimulus_count = device->stimulus_count,
                                     .identity = &device->identity,
                                     .alias = device->alias };

        if (!setup.type)
            return fail(why, -EINVAL, "device %zu: no device type \"%s\"", i + 1, device->type);
        setup.device = bus->devices[i] = calloc(1, setup.type->size);
        if (!setup.device)
            return fail(why, -ENOMEM, "no memory for device %zu", i + 1);
        if (slave_init(&bus->slaves[i], &setup))
            return fail(why, -EINVAL, "device type \"%s\": its SII does not fit", device->type);
    }
    segment_init(&bus->segment, bus->slaves, config->device_count);
    bus->wire = (struct wire){ .segment = &bus->segment, .capture = config->capture };
    return 0;
}

static int open_faults(struct bus *bus, const struct bus_config *config, char why[BUS_WHY])
{
    const char *text = config->faults ? config->faults : "";
    int error = faults_open(&bus->faults, text, strlen(text),
                            config->faults_name ? config->faults_name : "faults", &bus->segment,
                            config->seed, why);

    if (!error && config->faults)
        bus->wire.faults = bus->faults;
    return error;
}

static void wire_context(struct bus *bus)
{
    bus->port.wire = &bus->wire;
    bus->port.clock = &bus->clock;
    bus->context = (ecx_contextt){
        .port = &bus->port,
        .slavelist = bus->slavelist,
        .slavecount = &bus->slavecount,
        .maxslave = BUS_MAX_SLAVES + 1,
        .grouplist = bus->grouplist,
        .maxgroup = EC_MAXGROUP,
        .esibuf = bus->esibuf,
        .esimap = bus->esimap,
        .elist = &bus->elist,
        .idxstack = &bus->idxstack,
        .ecaterror = &bus->ecaterror,
        .DCtime = &bus->dctime,
        .SMcommtype = bus->smcommtype,
        .PDOassign = bus->pdoassign,
        .PDOdesc = bus->pdodesc,
        .eepSM = &bus->eepsm,
        .eepFMMU = &bus->eepfmmu,
    };
}

static const char *state_name(unsigned state)
{
    switch (state & AL_STATE) {
    case AL_INIT:
        return "INIT";
    case AL_PREOP:
        return "PREOP";
    case AL_BOOT:
        return "BOOT";
    case AL_SAFEOP:
        return "SAFEOP";
    case AL_OP:
        return "OP";
    default:
        return "no state";
    }
}

static void take_states(struct bus *bus)
{
    ecx_readstate(&bus->context);
    for (size_t i = 0; i < bus->slave_count; i++) {
        bus->slave[i].al_state = bus->slavelist[i + 1].state;
        bus->slave[i].al_code = bus->slavelist[i + 1].ALstatuscode;
    }
}

/* SOEM reports only that not all slaves are there; people need to know which one, and why. */
static int reach(struct bus *bus, unsigned state, char why[BUS_WHY])
{
    if (ecx_statecheck(&bus->context, 0, (uint16)state, EC_TIMEOUTSTATE) == state) {
        take_states(bus);
        return 0;
    }
    take_states(bus);
    for (size_t i = 0; i < bus->slave_count; i++) {
        const struct bus_slave *s = &bus->slave[i];

        if ((s->al_state & AL_STATE) == state)
            continue;
        return fail(why, -EIO,
                    "slave %zu (%s) stays in %s%s instead of %s: AL status code 0x%04X, %s", i + 1,
                    s->name, state_name(s->al_state), s->al_state & AL_ERROR ? "+ERR" : "",
                    state_name(state), s->al_code, ec_ALstatuscode2string(s->al_code));
    }
    return fail(why, -EIO, "%s not reached", state_name(state));
}

static int init_port(struct bus *bus, bool redundant)
{
    static char second[] = "far end";

    if (!redundant)
        return ecx_init(&bus->context, "near end");
    return ecx_init_redundant(&bus->context, &bus->second_port, "near end", second);
}

static int scan(struct bus *bus, size_t expected, bool redundant, char why[BUS_WHY])
{
    int found;

    if (init_port(bus, redundant) <= 0)
        return fail(why, -EIO, "SOEM does not take the port");
    found = ecx_config_init(&bus->context, FALSE);
    if (found < 0 || (size_t)found != expected)
        return fail(why, -EIO, "%d slaves answer, %zu are wired", found, expected);
    bus->slave_count = (size_t)found;
    for (size_t i = 0; i < bus->slave_count; i++) {
        const ec_slavet *s = &bus->slavelist[i + 1];

        snprintf(bus->slave[i].name, sizeof bus->slave[i].name, "%s", s->name);
        bus->slave[i].vendor = s->eep_man;
        bus->slave[i].product = s->eep_id;
        bus->slave[i].revision = s->eep_rev;
    }
    return reach(bus, AL_PREOP, why);
}

/* SOEM calls this whenever it takes a slave from PREOP to SAFEOP. */
static int to_safeop(ecx_contextt *context, uint16 slave)
{
    struct bus *bus = (struct bus *)((char *)context - offsetof(struct bus, context));
    const struct bus_startup *refused;
    uint32_t abort;

    if (bus->supervise)
        client_restore_clock(bus, (size_t)slave - 1);
    return client_startup(bus, (size_t)slave - 1, &refused, &abort) == 0;
}

/* The mapping is read in PREOP, behind the startup values that may choose it: SOEM's own pass over
 * it keeps only the sums. */
static int read_maps(struct bus *bus, char why[BUS_WHY])
{
    for (size_t i = 0; i < bus->slave_count; i++) {
        const struct bus_startup *s;
        uint32_t abort;
        int error = client_startup(bus, i, &s, &abort);

        if (error)
            return fail(why, error,
                        "slave %zu (%s): the startup value 0x%04X:%02X = 0x%X is not taken: "
                        "abort 0x%08X",
                        i + 1, bus->slave[i].name, s->index, s->subindex, s->value, abort);
        bus->slavelist[i + 1].PO2SOconfigx = to_safeop;
        error = client_map_read(bus, i);
        if (error)
            return fail(why, error, "slave %zu (%s): its PDO mapping cannot be read", i + 1,
                        bus->slave[i].name);
    }
    return 0;
}

/* SYNC0 in the middle of the cycle: behind the frame, before the next. */
static void start_sync(struct bus *bus)
{
    for (size_t i = 0; i < bus->slave_count; i++) {
        if (bus->slave[i].axes && bus->slavelist[i + 1].hasdc)
            ecx_dcsync0(&bus->context, (uint16)(i + 1), TRUE, bus->cycle_ns,
                        (int32)(bus->cycle_ns / 2));
    }
}

static int configure(struct bus *bus, char why[BUS_WHY])
{
    int bytes;

    pthread_mutex_lock(&configuring);
    bytes = ecx_config_map_group(&bus->context, bus->iomap, 0);
    pthread_mutex_unlock(&configuring);
    if (bytes < 0 || bytes > CLIENT_IMAGE_MAX)
        return fail(why, -EOVERFLOW, "process image of %d bytes is too large", bytes);
    ecx_configdc(&bus->context);
    if (bus->dc_sync)
        start_sync(bus);
    for (size_t i = 0; i < bus->slave_count; i++) {
        bus->slave[i].output_bits = bus->slavelist[i + 1].Obits;
        bus->slave[i].input_bits = bus->slavelist[i + 1].Ibits;
    }
    return reach(bus, AL_SAFEOP, why);
}

static int open_fiber(struct bus *bus, const struct bus_config *config, char why[BUS_WHY])
{
    bus->clock.wake_ns = BUS_CLOCK_NEVER;
    bus->startup = calloc(config->startup_count + 1, sizeof *bus->startup);
    if (!bus->startup || fiber_open(&bus->clock.fiber, client_jobs, bus))
        return fail(why, -ENOMEM, "no memory for the bus");
    if (config->startup_count)
        memcpy(bus->startup, config->startup, config->startup_count * sizeof *bus->startup);
    bus->startup_count = config->startup_count;
    return 0;
}

int bus_open(struct bus **out, const struct bus_config *config, char why[BUS_WHY])
{
    struct bus_clock *previous;
    struct bus *bus;
    int error;

    why[0] = '\0';
    *out = NULL;
    if (!config->device_count || config->device_count > BUS_MAX_SLAVES || !config->cycle_ns)
        return fail(why, -EINVAL, "a bus has 1 to %d devices and a cycle; asked for %zu devices",
                    BUS_MAX_SLAVES, config->device_count);
    bus = calloc(1, sizeof *bus);
    if (!bus)
        return fail(why, -ENOMEM, "no memory for the bus");
    bus->cycle_ns = config->cycle_ns;
    bus->dc_sync = config->dc_sync;
    bus->image = bus->image_bytes;
    wire_context(bus);
    previous = bus_clock_enter(&bus->clock);
    error = open_fiber(bus, config, why);
    if (!error)
        error = build_segment(bus, config, why);
    if (!error)
        error = open_faults(bus, config, why);
    if (!error)
        error = scan(bus, config->device_count, config->redundant, why);
    if (!error)
        error = read_maps(bus, why);
    if (!error)
        error = configure(bus, why);
    /* After the delays have been measured: in a closed ring the last port of every slave hears
     * nothing, and SOEM would take it for the end of the line. */
    if (!error && config->redundant)
        segment_close_ring(&bus->segment, true, bus->clock.now_ns);
    bus_clock_enter(previous);
    if (error)
        bus_close(bus);
    else
        *out = bus;
    return error;
}

void bus_close(struct bus *bus)
{
    if (!bus)
        return;
    faults_close(bus->faults);
    for (size_t i = 0; i < BUS_MAX_SLAVES; i++)
        free(bus->devices[i]);
    fiber_close(bus->clock.fiber);
    free(bus->startup);
    free(bus->slaves);
    free(bus);
}
