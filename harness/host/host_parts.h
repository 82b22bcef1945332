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

#include "host/angle.h"
#include "host/host_ops.h"
#include "host/interpolator.h"
#include "host/motion.h"
#include "host/osc.h"
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
#define HOST_AXES      256
#define HOST_TERMINALS 16

#define NO_SLAVE SIZE_MAX /* of a virtual servo */

/* A servo register group and the drive axis behind it, if there is one. */
struct axis {
    SERVO *reg;
    size_t slave;                                          /* or NO_SLAVE */
    struct bus_entry control, mode, target;                /* outputs */
    struct bus_entry status, mode_display, actual, inputs; /* inputs; bits == 0 when not mapped */
    uint32_t raw;                                          /* last position on the wire, wraps */
    bool seen;                                             /* raw is valid */
    double sent;                                           /* last set-point sent, inc */
    double sent_speed;
    bool tracking; /* the set-point follows the axis because it is not enabled */
    bool asked;    /* it was to be enabled when the outputs left */
    struct axis_motion motion;
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
    size_t memory_bytes[HOST_MEMORIES];
    SYSTEM *system;
    PLC_DATA *plc_data[ENTRY_COUNT];    /* the host's view */
    void *plc_data_module[ENTRY_COUNT]; /* what the module is given: read-only */
    uint64_t entry_address[ENTRY_COUNT];

    struct bus *bus;
    uint64_t bus_zero; /* bus time of the first cycle */
    bool exchanged;    /* process data have come back at least once: inputs mean something */
    struct axis axes[HOST_AXES];
    size_t axis_count;
    uint64_t servo_tick; /* MAIN.Servo_Tick, counting on */
    struct terminal terminals[HOST_TERMINALS];
    size_t terminal_count;

    struct osc osc;

    struct interpolator interpolators[INTERPOLATORS_MOST];
    size_t interpolator_count;
    bool path_started; /* the one of the configuration */

    uint64_t cycle, now_ns, timer_ms;
    uint64_t due_ns[3]; /* Program_01..03 */
    host_sample *sample;
    void *sample_argument;
};

/* In the order in which they act; ends with NULL. host_rows.c */
extern const struct host_part *const host_parts[];
extern const struct host_part host_scope;
extern const struct host_part host_timers, host_servo, host_capture, host_motion, host_dio,
    host_interpolator;

/* services.c: fills the functions of a PLC_DATA; the services act for this host from now on. */
void services_bind(struct host *host, PLC_DATA *data);

/* servo.c: whether the PLC wants the axis enabled; whether it is, and follows its set-point. */
bool servo_wanted(const struct host *host, const struct axis *axis);
bool servo_runs(const struct host *host, const struct axis *axis);

/* command.c: SERVO.Command, before the generators of a cycle and after them. */
void command_before(struct host *host, struct axis *axis);
void command_after(const struct host *host, struct axis *axis);

/* motion.c: where a generator takes over the set-point. */
double motion_start(const struct host *host, const struct axis *axis);

/* The axis counts its positions from elsewhere: RefPosition becomes `reference`, and
 * nothing moves. */
void motion_refer(struct axis *axis, double reference);

/* scope.c: host.h's functions for the oscilloscope. */
int scope_arm(struct host *host, const struct host_osc *wanted, char why[HOST_WHY]);
size_t scope_samples(const struct host *host);
void scope_row(const struct host *host, size_t index, double *row);

/* interpolator.c: the CNC side (host.h), and what interpolator_command.c needs. */
int interpolator_load(struct host *host, unsigned number, const struct interp_path *path,
                      bool append, char why[HOST_WHY]);
bool interpolator_start(struct host *host, unsigned number);
void interpolator_stop(struct host *host, unsigned number, bool emergency, bool drop);
uint32_t interpolator_step_us(const struct host *host);
/* It stands there now, without having moved. */
void interpolator_place(struct interpolator *in, const double position[INTERP_AXES]);
void interpolators_close(struct host *host);

/* interpolator_command.c: carries out INTERPOLATOR.Command, in front of a step. */
void interpolator_command(const struct host *host, struct interpolator *in);

/* memories.c */
int memories_open(struct host *host, char why[HOST_WHY]);
void memories_mutate(struct host *host);

/* Seconds in a Cycle_Time. */
static inline double host_cycle_seconds(const struct host *host)
{
    return host->config.cycle_us * 1e-6;
}

/* How many servos the configuration announces. */
static inline unsigned host_servos(const struct host *host)
{
    return host->config.servos != NULL ? host->config.servo_count : host->config.plant->servos;
}

static inline const struct servo_modes *host_modes(const struct host *host)
{
    return host->config.modes != NULL ? host->config.modes : &servo_modes_default;
}

#endif
