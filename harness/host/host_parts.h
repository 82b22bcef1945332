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

#include "host/can.h"
#include "host/channel.h"
#include "host/console.h"
#include "host/general.h"
#include "host/angle.h"
#include "host/host_ops.h"
#include "host/interpolator.h"
#include "host/motion.h"
#include "host/osc.h"
#include "host/plc.h"
#include "host/preempt.h"
#include "host/races.h"
#include "host/realtime.h"
#include "host/scenario_play.h"
#include "host/schedule.h"
#include "host/servo_wire.h"
#include "host/sleep.h"

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

/* SERVO.ControlWord and StatusWord. */
#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
typedef uint32_t servo_word;
#else
typedef int32_t servo_word;
#endif

#define HOST_MEMORIES  16
#define HOST_AXES      256
#define HOST_TERMINALS 16

/* A servo register group and the drive axis behind it, if there is one. */
struct axis {
    SERVO *reg;
    size_t slave; /* or NO_SLAVE */
    struct servo_wire wire;
    double scale;    /* increments on the wire for one of the register */
    uint64_t raw;    /* last position on the wire, wraps */
    double position; /* the same, counting on */
    bool seen;       /* raw is valid */
    double actual;   /* where it is, inc; SERVO.Position, whatever the module makes of that */
    double sent;     /* last set-point sent, inc */
    double sent_speed;
    bool tracking;          /* the set-point follows the axis because it is not enabled */
    bool asked;             /* it was to be enabled when the outputs left */
    uint64_t unable_cycles; /* unable.c: in a row; and where its set-point was in the latest */
    double unable_at;

    /* safety.c: the stop that is being carried out, 0: none; and its set-point. */
    uint32_t stopping;
    double stop_at, stop_speed, stop_deceleration;

    struct axis_motion motion;
};

/* Some digital bits and their place in a word of the register group. */
struct terminal_piece {
    struct bus_entry place;
    uint8_t word, shift;
};

#define TERMINAL_PIECES 128
#define TERMINAL_ANALOG 16
#define TERMINAL_GAUGES 8

/* Inputs or outputs. */
struct terminal_side {
    struct terminal_piece pieces[TERMINAL_PIECES];
    unsigned piece_count, bits;
    struct bus_entry analog[TERMINAL_ANALOG];
    unsigned analog_count;
};

/* An I/O register group and the terminal behind it. */
struct terminal {
    DIO *reg;
    size_t slave;
    struct terminal_side side[2]; /* by enum bus_direction */
    struct bus_entry gauges[TERMINAL_GAUGES];
    unsigned gauge_count;
};

/* SERVO.Error: what is known of the fault of a drive, and the question for its code. */
struct axis_error {
    bool faulty, asked, stale;
    uint32_t bit;
    struct bus_job job;
};

/* SERVO.DigitalOut over CoE, one servo after the other. */
struct told_outputs {
    uint32_t values[HOST_AXES]; /* as the drives were told last */
    bool asked;
    struct bus_job job;
};

#define HOST_CHANNELS (2 * (HOST_AXES + HOST_TERMINALS))

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

/* Most parts have nothing to do at most moments, and slots are many: who acts is listed once. */
enum { HOST_PARTS_MOST = 24 };
struct host_acts {
    void (*cycle[HOST_PARTS_MOST])(struct host *host); /* each ends with NULL */
    void (*receive[HOST_PARTS_MOST])(struct host *host);
    void (*send[HOST_PARTS_MOST])(struct host *host);
    void (*profile[HOST_PARTS_MOST])(struct host *host);
    void (*slot[HOST_PARTS_MOST])(struct host *host);
    void (*sample[HOST_PARTS_MOST])(struct host *host);
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
    unsigned char *plc_data[ENTRY_COUNT]; /* the host's view, as wide as the module's pointers */
    void *plc_data_module[ENTRY_COUNT];   /* what the module is given: read-only */
    size_t word_bytes;                    /* of those pointers */
    void *device_info, *device_name;      /* the module's: pcGetDeviceInfo_v and its text */
    uint64_t entry_address[ENTRY_COUNT];  /* of the module; bit 0: Thumb code; 0: none */

    struct bus *bus;
    uint64_t bus_zero; /* bus time of the first cycle */
    bool exchanged;    /* process data have come back at least once: inputs mean something */
    struct axis axes[HOST_AXES];
    size_t axis_count;
    uint64_t servo_tick; /* MAIN.Servo_Tick, counting on */
    struct terminal terminals[HOST_TERMINALS];
    size_t terminal_count;

    bool taken[BUS_MAX_SLAVES]; /* slaves that are servos or I/O units */

    struct channel channels[HOST_CHANNELS];
    size_t channel_count;
    struct axis_error errors[HOST_AXES]; /* as axes */
    struct told_outputs told_outputs;
    struct general generals[GENERAL_DEVICES];
    size_t general_count;

    uint32_t console_slots, console_written; /* of the ring in TGM_ODS */

    bool frame_back;        /* the exchange of this cycle brought something back */
    unsigned silent_cycles; /* exchanges in a row that did not */
    bool link_broken;
    uint16_t said_state[BUS_MAX_SLAVES]; /* AL states that messages have told */
    uint64_t frames_sent;
    bool has_clock; /* a slave has one */
    int64_t reference_zero;
    uint32_t clock_difference[BUS_MAX_SLAVES];
    struct bus_job clock_job;
    bool clock_asked;
    size_t clock_slave;
    uint64_t clock_due_ns;

    uint32_t eeprom_control; /* what is being done; 0: nothing */
    uint64_t eeprom_due_ns;

    struct can can;
    void *can_memory[CAN_CHANNELS];
    struct osc osc;
    struct play play;

    struct plc plc;
    struct preempt preempt;
    struct sleeper sleepers[3]; /* Program_01..03 */
    struct races *races;        /* NULL: interrupts are not tried out */
    struct realtime *real;      /* NULL: the clock is virtual */
    struct measured measured;
    struct digester *digester; /* NULL: no digest is wanted */
    struct host_copy *copy;    /* of the start; NULL: TG Motion cannot begin anew */
    struct interpolator interpolators[INTERPOLATORS_MOST];
    size_t interpolator_count;
    bool path_started; /* the one of the configuration */

    struct host_acts acts;
    uint64_t cycle, now_ns, timer_ms;
    size_t slot;          /* the next one of the cycle */
    bool loop;            /* the servo loop runs in this cycle */
    uint64_t loop_begin;  /* first cycle since it runs */
    bool in_op;           /* every slave, since the loop runs */
    uint64_t fault_noted; /* how many faults of the bus were told */
    uint64_t due_ns[3];   /* Program_01..03 */
    host_sample *sample;
    void *sample_argument;
};

/* In the order in which they act; ends with NULL. host_rows.c */
extern const struct host_part *const host_parts[HOST_PARTS_MOST];
extern const struct host_part host_servo_outputs;
extern const struct host_part host_scope;
extern const struct host_part host_scene;
extern const struct host_part host_unable;
extern const struct host_part host_watch;
extern const struct host_part host_timers, host_servo, host_capture, host_motion, host_dio;
extern const struct host_part host_digest;
extern const struct host_part host_console, host_statistics, host_eeprom, host_safety, host_general,
    host_channels, host_can;
extern const struct host_part host_timers, host_servo, host_capture, host_motion, host_dio,
    host_interpolator;

/* services.c: puts the functions into every PLC_DATA. */
int services_open(struct host *host, char why[HOST_WHY]);

/* console.c: text of the module; id_and_severity as in generation 5. Reads text to its end. */
void console_text16(struct host *host, uint32_t id_and_severity, const uint16_t *text);
void console_text8(struct host *host, uint32_t id_and_severity, const char *text);
/* A message of TG Motion itself, in ASCII, if MAIN.Log_Ctrl has one of the bits of `log`. */
void console_log(struct host *host, uint32_t log, enum console_source source,
                 enum console_severity severity, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

/* channels.c: tells of a request that has ended. */
void channel_log(struct host *host, const struct channel *channel, enum channel_event event);

/* servo_error.c: SERVO.Error of a drive in fault, in every cycle of it; and of one that is not. */
void servo_faulty(struct host *host, struct axis *axis);
void servo_faultless(struct host *host, struct axis *axis);

/* safety.c: what becomes of the set-point of a servo that runs. */
double safety_set_point(const struct host *host, struct axis *axis, double wanted);

/* watch.c: around a call of the module; it has called SleepFt. */
void watch_begin(const struct host *host, enum entry entry);
void watch_end(const struct host *host, enum entry entry, const struct machine_outcome *outcome);
void watch_sleep(const struct host *host);

/* statistics.c: a function of the module has been called. */
void statistics_call(struct host *host, enum entry entry, uint64_t elapsed_ns);

/* can_memory.c: the PLC sends a telegram; 1 when it was taken. */
int32_t can_send(struct host *host, uint32_t number, uint32_t id, uint32_t length,
                 const uint8_t *data, bool remote);

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

/* plc.c */
void plc_open(struct host *host);
/* Program_Ini, and the cyclic calls may begin. */
bool plc_begin(struct host *host);
/* When a cycle begins; whether the servo loop runs in it. */
bool plc_cycle(struct host *host);
/* Whether cyclic functions are called at present. */
bool plc_calls(const struct host *host);
void plc_run(struct host *host);
void plc_stop(struct host *host);
void plc_pause(struct host *host, bool paused);
void plc_reset(struct host *host);
enum host_plc plc_state(const struct host *host);

/* preempt.c: plans how the call of Program_01 to Program_03 that follows is interrupted. */
void preempt_plan(struct host *host, enum entry entry);
void preempt_done(struct host *host, enum entry entry);
/* The same for a call that goes on after it was asleep since that time of realtime_now(). */
void preempt_plan_on(struct host *host, enum entry entry, uint64_t since_ns);

/* sleep.c: SleepFt of the function that runs, in 100 ns. */
void sleep_wanted(struct host *host, int64_t units);
/* Its call has been set aside for it. */
void sleep_begins(struct host *host, enum entry entry, unsigned aside);
bool sleep_is(const struct host *host, enum entry entry);
bool sleep_anyone(const struct host *host);
/* A function that is asleep: on with its call, if it is time. */
void sleep_goes_on(struct host *host, enum entry entry);
void sleep_drop_all(struct host *host);

/* rewind.c. No room for a copy: none is kept. */
void rewind_keep(struct host *host);
bool rewind_back(struct host *host);
void rewind_free(struct host *host);

/* measure.c: registers of what took how long, on the real clock */
extern const struct host_part host_measure;

/* host.c, for the files of PLC control */
bool host_call(struct host *host, enum entry entry);
/* Around a call that begins or goes on; true when it is over and has returned. */
void host_calling(struct host *host, enum entry entry);
bool host_called(struct host *host, enum entry entry, const struct machine_outcome *outcome);
/* A call that did not return as it should; the function is not called again. */
void host_incident(struct host *host, enum entry entry, const struct machine_outcome *outcome);
void host_slot(struct host *host); /* the next one of the schedule */
void host_clear_parts(struct host *host);
uint64_t host_time_of(const struct host *host);
/* When the next slot is due, from the first cycle. */
uint64_t host_next_slot_ns(const struct host *host);
/* interpolator.c: the CNC side (host.h), and what interpolator_command.c needs. */
int interpolator_load(struct host *host, unsigned number, const struct interp_path *path,
                      bool append, char why[HOST_WHY]);
bool interpolator_start(struct host *host, unsigned number);
void interpolator_stop(struct host *host, unsigned number, bool emergency, bool drop);
uint32_t interpolator_step_us(const struct host *host);
/* It stands there now, without having moved. */
void interpolator_place(struct interpolator *in, const double position[INTERP_AXES]);
void interpolators_close(struct host *host);
/* digest_take.c */
void digest_close(struct host *host);

/* interpolator_command.c: carries out INTERPOLATOR.Command, in front of a step. */
void interpolator_command(const struct host *host, struct interpolator *in);

/* entries.c: entry_address, when the host is made; and when a module has been loaded, before
 * Program_Ini is called. False when that one is not found. */
int entries_open(struct host *host, char why[HOST_WHY]);
bool entries_load(struct host *host);

/* memories.c */
int memories_open(struct host *host, char why[HOST_WHY]);
void memories_mutate(struct host *host);
/* A member of a PLC_DATA, by its offset in one of 64 bits: all of them are words, structSize and
 * pointers, so that on 32-bit targets everything is half as large and half as far. */
void plc_data_put(struct host *host, enum entry entry, size_t offset, uint64_t value);

/* Now, where things are measured, else 0. */
static inline uint64_t host_stopwatch(const struct host *host)
{
    return host->real != NULL ? realtime_now(host->real) : 0;
}

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
