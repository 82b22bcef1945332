/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * host_parts.h - what the files of the host room share among themselves; nobody else includes it.
 *
 * Every file that includes it is compiled once for each layout of the shared memories, with
 * TGM_GENERATION and TGM_MEMORY_ID set; all symbols but the table HOST_OPS are then made local to
 * that layout (Makefile). Where names differ between the layouts, the macros below have both.
 *
 * The host is a row of parts. Each is one file that looks after one group of registers and says at
 * which moments of a cycle it wants to act; host.c walks the rows.
 */
#ifndef HARNESS_HOST_PARTS_H
#define HARNESS_HOST_PARTS_H

#define TGM_HOST
#include <tgm_plc.h>

#include "host/host_ops.h"
#include "host/schedule.h"

#if TGM_GENERATION == 4
#define GENERATION(four, five) four
#define DIO_WORD_BITS          8 /* of every input and output word */
/* In0..In7, Ext_In0..Ext_In7 follow one another: static asserts of the layout. */
#define DIO_IN(reg)  (&(reg)->In0)
#define DIO_OUT(reg) (&(reg)->Out0)
typedef int32_t dio_word;
#else
#define GENERATION(four, five) five
#define DIO_WORD_BITS          32
#define DIO_IN(reg)            ((reg)->In)
#define DIO_OUT(reg)           ((reg)->Out)
typedef uint32_t dio_word;
#endif
#define DIO_WORDS 16

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
    struct bus_entry in[DIO_WORDS], out[DIO_WORDS]; /* bits == 0 past the end */
};

struct host;

/*
 * One part of the host. Every member but name may be NULL. Moments, in the order of a cycle:
 * receive and cycle belong to slot 0, send to slot 1, profile to slot 2; slot comes in every slot
 * before Program_05; sample comes right after Program_04. `cycle` is before everything else.
 */
struct host_part {
    const char *name;
    int (*open)(struct host *host, char why[HOST_WHY]); /* memories are there, and the bus if any */
    void (*clear)(struct host *host);                   /* the Run sequence, before Program_Ini */
    void (*cycle)(struct host *host);
    void (*receive)(struct host *host); /* inputs have come: bus, if any, is up to date */
    void (*send)(struct host *host);    /* outputs leave right after this */
    void (*profile)(struct host *host);
    void (*slot)(struct host *host);
    void (*sample)(struct host *host);
};

struct host {
    const struct host_ops *ops; /* first: host_select.c */
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

/* In the order in which they act; ends with NULL. host_rows.c */
extern const struct host_part *const host_parts[];
extern const struct host_part host_timers, host_servo, host_dio;

/* services.c: fills the functions of a PLC_DATA; the services act for this host from now on. */
void services_bind(struct host *host, PLC_DATA *data);

/* memories.c */
int memories_open(struct host *host, char why[HOST_WHY]);
void memories_mutate(struct host *host);

/* Seconds in a Cycle_Time. */
static inline double host_cycle_seconds(const struct host *host)
{
    return host->config.cycle_us * 1e-6;
}

#endif
