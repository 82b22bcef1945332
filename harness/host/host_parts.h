/* SPDX-License-Identifier: GPL-2.0-or-later */
/* host_parts.h - what the files of the host room share among themselves; nobody else includes it.
 */
#ifndef HARNESS_HOST_PARTS_H
#define HARNESS_HOST_PARTS_H

#define TGM_HOST
#include <tgm_plc.h>

#include "host/host.h"
#include "host/schedule.h"

#define HOST_MEMORIES  16
#define HOST_AXES      32
#define HOST_TERMINALS 16

/* A servo register group and the drive axis behind it. */
struct axis {
    SERVO *reg;
    size_t slave;
    struct bus_entry control, mode, target;                /* outputs */
    struct bus_entry status, mode_display, actual, inputs; /* inputs; bits == 0 when not mapped */
    uint32_t raw;                                          /* last position on the wire, wraps */
    bool seen;                                             /* raw is valid */
    double sent;                                           /* last set-point sent, inc */
    double sent_speed;
    bool tracking; /* the set-point follows the axis because it is not enabled */
};

/* An I/O register group and the terminal behind it. */
struct terminal {
    DIO *reg;
    size_t slave;
    struct bus_entry in[16], out[16]; /* octets, as generation 4 has them; bits == 0 past the end */
};

struct host {
    struct host_config config;
    struct machine *machine;
    const struct image *image;
    struct evidence *evidence;
    const struct schedule *schedule;

    const struct catalogue *catalogue; /* the product's layout */
    void *memory[HOST_MEMORIES];       /* by catalogue index */
    SYSTEM *system;
    PLC_DATA *plc_data[ENTRY_COUNT];    /* the host's view */
    void *plc_data_module[ENTRY_COUNT]; /* what the module is given: read-only */
    uint64_t entry_address[ENTRY_COUNT];

    struct bus *bus;
    uint64_t bus_zero; /* bus time of the first cycle */
    bool exchanged;    /* process data have come back at least once: inputs mean something */
    struct axis axes[HOST_AXES];
    size_t axis_count;
    struct terminal terminals[HOST_TERMINALS];
    size_t terminal_count;

    uint64_t cycle, now_ns, timer_ms;
    uint64_t due_ns[3]; /* Program_01..03 */
    host_sample *sample;
    void *sample_argument;
};

/* services.c: fills the function table of a PLC_DATA; the services act for this host from now on.
 */
void services_bind(struct host *host, PLC_IMPORT_FUNCTIONS *functions);

/* memories.c */
int memories_open(struct host *host, char why[HOST_WHY]);
void memories_mutate(struct host *host);

/* servo.c */
int servo_open(struct host *host, char why[HOST_WHY]);
void servo_receive(struct host *host);
void servo_send(struct host *host);

/* dio.c */
int dio_open(struct host *host, char why[HOST_WHY]);
void dio_receive(struct host *host);
void dio_send(struct host *host);

/* Seconds in a Cycle_Time. */
static inline double host_cycle_seconds(const struct host *host)
{
    return host->config.cycle_us * 1e-6;
}

#endif
