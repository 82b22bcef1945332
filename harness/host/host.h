/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * host.h - the emulated TG Motion around one module: memories, schedule, services, servos, I/O,
 * bus.
 *
 * The host runs in a worker process next to the machine. host_open() does all allocation and the
 * blocking part of the bus start (scan to SAFEOP); after it, host_start() and host_cycle() allocate
 * nothing and make no system call. Time is simulated: it advances by the schedule only.
 *
 * TG Motion 4.21, 5.00 and 5.02 lay their memories out differently. What touches registers is
 * compiled once for each layout (host_parts.h); the functions below find the one that the product
 * needs. Nothing outside the host room sees a layout.
 *
 * Which slave becomes which register group: bus order; every CiA 402 axis is the next SERVO, every
 * slave without axes that has process data is the next DIO.
 */
#ifndef HARNESS_HOST_HOST_H
#define HARNESS_HOST_HOST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"
#include "host/catalogue.h"
#include "host/evidence.h"
#include "host/product.h"
#include "machine/machine.h"

#define HOST_WHY 512

/* What stands around the module. */
struct plant {
    const struct bus_device *devices;
    size_t device_count;
    unsigned servos, dios; /* what the configuration announces: MAIN.Number_Servos, Number_Dios */
};

/* One CiA 402 drive and one digital terminal whose input 0 goes on and off (docs/decisions.md, H3).
 */
extern const struct plant plant_default;

/* How the call of Program_Ini deviates from good conditions; value as the kind needs it. */
enum mutation_kind {
    MUTATION_NONE,
    MUTATION_NULL_DATA,     /* pData is NULL */
    MUTATION_STRUCT_SIZE,   /* structSize = value */
    MUTATION_NULL_FUNCTION, /* value is an enum plc_function: its pointer is NULL */
    MUTATION_COMPATIBILITY  /* HEADER.Compatibility_Id = value */
};

/* The functions that the manual advises a module to test against NULL. Generation 5 has the first
 * and the last. */
enum plc_function { PLC_STRING, PLC_LONG, PLC_SWPRINTF, PLC_SLEEP };

struct mutation {
    enum mutation_kind kind;
    uint64_t value;
};

struct host_config {
    const struct product *product;
    uint32_t cycle_us;             /* one the product allows */
    uint32_t program_period_us[3]; /* Program_01..03; 0 = the product's default */
    uint64_t seed;
    const struct plant *plant;
    const char *faults,
        *faults_name; /* what goes wrong on the bus (docs/faults.md); NULL: nothing */
    bool without_bus; /* no slaves are made: for experiments that only call Program_Ini */
    struct mutation mutation;
    struct pcap *capture; /* where the frames of the bus go; NULL: nowhere */
};

struct host; /* its first member says which layout it was made for */

/* Taken right after Program_04 of every cycle, where the oscilloscope samples. */
typedef void host_sample(void *argument, struct host *host);

/* Makes memories, services and bus for the machine's module. 0, or negative errno with a reason. */
int host_open(struct host **out, const struct host_config *config, struct machine *machine,
              const struct image *image, struct evidence *evidence, char why[HOST_WHY]);
void host_close(struct host *host);

/* Calls Program_Ini. True when it returned 1 and the cycles may begin. */
bool host_start(struct host *host);

/* One Cycle_Time. False when no function of the module can be called any more. */
bool host_cycle(struct host *host);

void host_on_sample(struct host *host, host_sample *sample, void *argument);

uint64_t host_cycles(const struct host *host);
/* Simulated nanoseconds since the first cycle began. */
uint64_t host_time(const struct host *host);
/* Address of a resolved register in the host's memory. */
const void *host_register(const struct host *host, const struct catalogue_register *reg);

#endif
