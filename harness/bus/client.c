/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/client.h"
#include "bus/fiber.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* SOEM's mapping code keeps static state: one configuration at a time in the process. */
static pthread_mutex_t configuring = PTHREAD_MUTEX_INITIALIZER;

static int open_faults(struct bus *bus, const struct bus_config *config, char why[BUS_WHY])
{
    const char *text = config->faults ? config->faults : "";
    int error = faults_open(&bus->faults, text, strlen(text),
                            config->faults_name ? config->faults_name : "faults",
                            &bus->rack.segment, config->seed, why);

    if (!error && config->faults)
        bus->wire.faults = bus->faults;
    return error;
}

static void wire_context(struct bus *bus, const struct bus_config *config)
{
    bus->wire = (struct wire){ .segment = &bus->rack.segment, .capture = config->capture };
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
        return rack_fail(
            why, -EIO, "slave %zu (%s) stays in %s%s instead of %s: AL status code 0x%04X, %s",
            i + 1, s->name, state_name(s->al_state), s->al_state & AL_ERROR ? "+ERR" : "",
            state_name(state), s->al_code, ec_ALstatuscode2string(s->al_code));
    }
    return rack_fail(why, -EIO, "%s not reached", state_name(state));
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
        return rack_fail(why, -EIO, "SOEM does not take the port");
    found = ecx_config_init(&bus->context, FALSE);
    if (found < 0 || (size_t)found != expected)
        return rack_fail(why, -EIO, "%d slaves answer, %zu are wired", found, expected);
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
            return rack_fail(why, error,
                             "slave %zu (%s): the startup value 0x%04X:%02X = 0x%X is not taken: "
                             "abort 0x%08X",
                             i + 1, bus->slave[i].name, s->index, s->subindex, s->value, abort);
        bus->slavelist[i + 1].PO2SOconfigx = to_safeop;
        error = client_map_read(bus, i);
        if (error)
            return rack_fail(why, error, "slave %zu (%s): its PDO mapping cannot be read", i + 1,
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
        return rack_fail(why, -EOVERFLOW, "process image of %d bytes is too large", bytes);
    ecx_configdc(&bus->context);
    if (bus->dc_sync)
        start_sync(bus);
    for (size_t i = 0; i < bus->slave_count; i++) {
        bus->slave[i].output_bits = bus->slavelist[i + 1].Obits;
        bus->slave[i].input_bits = bus->slavelist[i + 1].Ibits;
        bus->slave[i].has_clock = bus->slavelist[i + 1].hasdc;
    }
    return reach(bus, AL_SAFEOP, why);
}

static int open_fiber(struct bus *bus, const struct bus_config *config, char why[BUS_WHY])
{
    bus->clock.wake_ns = BUS_CLOCK_NEVER;
    bus->startup = calloc(config->startup_count + 1, sizeof *bus->startup);
    if (!bus->startup || fiber_open(&bus->clock.fiber, client_jobs, bus))
        return rack_fail(why, -ENOMEM, "no memory for the bus");
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
        return rack_fail(why, -EINVAL,
                         "a bus has 1 to %d devices and a cycle; asked for %zu devices",
                         BUS_MAX_SLAVES, config->device_count);
    bus = calloc(1, sizeof *bus);
    if (!bus)
        return rack_fail(why, -ENOMEM, "no memory for the bus");
    bus->cycle_ns = config->cycle_ns;
    bus->dc_sync = config->dc_sync;
    bus->image = bus->image_bytes;
    wire_context(bus, config);
    previous = bus_clock_enter(&bus->clock);
    error = open_fiber(bus, config, why);
    if (!error)
        error = rack_open(&bus->rack, config, why);
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
        segment_close_ring(&bus->rack.segment, true, bus->clock.now_ns);
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
    rack_close(&bus->rack);
    fiber_close(bus->clock.fiber);
    free(bus->startup);
    free(bus);
}
