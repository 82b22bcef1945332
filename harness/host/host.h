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
 * Which slave becomes which register group: the list of servos, where there is one, otherwise bus
 * order; every CiA 402 axis is the next SERVO, every slave without axes that has process data is
 * the next DIO. In generation 5 what is no plain terminal, or past the announced number of those,
 * is the next GENERAL_DEVICE (docs/decisions.md, C8).
 */
#ifndef HARNESS_HOST_HOST_H
#define HARNESS_HOST_HOST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"
#include "host/catalogue.h"
#include "host/evidence.h"
#include "host/interp_path.h"
#include "host/product.h"
#include "host/scenario.h"
#include "machine/machine.h"

#define HOST_WHY 512

struct realtime; /* realtime.h */

/* What stands around the module. */
struct plant {
    const struct bus_device *devices;
    size_t device_count;
    unsigned servos, dios; /* what the configuration announces: MAIN.Number_Servos, Number_Dios */
    bool as_found;         /* instead: as many as there are on the bus */
    const struct bus_library *library; /* of bus_config */
    bool redundant;
};

/* One CiA 402 drive and one digital terminal whose input 0 goes on and off (docs/decisions.md, H3).
 */
extern const struct plant plant_default;

/* How the call of Program_Ini deviates from good conditions; value as the kind needs it. */
enum mutation_kind {
    MUTATION_NONE,
    MUTATION_NULL_DATA,     /* pData is NULL */
    MUTATION_STRUCT_SIZE,   /* structSize = value; half of it where pointers have 32 bits */
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

/* One SERVO register group, in the order of the configuration. */
struct host_servo {
    uint32_t type;       /* SERVO_TYPE_...; 0 is a virtual servo, behind which there is no slave */
    uint32_t node;       /* place of its slave on the bus, from 1 */
    uint32_t axis;       /* of a drive with several, from 1; 0 means 1 */
    uint32_t feedback;   /* SERVO.FeedbackType, where the layout has it */
    uint32_t resolution; /* inc/rev of a virtual servo, 0: 2^20; a drive tells its own */
};

/* SERVO.Mode: which value selects which source of motion (docs/decisions.md, M1). */
struct servo_modes {
    int32_t off;          /* none; the axis is disabled */
    int32_t position;     /* the PLC writes WritePosition */
    int32_t pg;           /* the profile generator, SERVO.Pg */
    int32_t gear;         /* linear gear or cam, SERVO.Gear */
    int32_t pg_gear;      /* the sum of both */
    int32_t interpolator; /* the axis of an interpolator that SERVO.Cnc names */
    int32_t user;         /* TransformedPosition */
};

extern const struct servo_modes servo_modes_default;

/* The period of a function that is not called at all. */
#define PERIOD_OFF UINT32_MAX

/* The distributed clock: on without SYNC0 unless configured; off; on, and drives follow SYNC0. */
enum clock_choice { CLOCK_DEFAULT, CLOCK_OFF, CLOCK_ON };
/*
 * How Program_01 to Program_03 are interrupted by what is above them (R18). Run to completion: not;
 * on the virtual clock a call takes no time. Otherwise a call is stopped before some instruction,
 * slots of the schedule go by, with everything that is due in them, and the call goes on.
 */
enum preempt_mode {
    PREEMPT_NONE,
    PREEMPT_SEEDED, /* places and numbers of slots are a function of the seed */
    PREEMPT_AT,     /* before instruction `at`; slots go by until Program_04 has been called */
    PREEMPT_TRIED   /* not, but what interrupts would lead to is tried out on the side (races.c) */
};

struct host_preempt {
    enum preempt_mode mode;
    uint64_t at;    /* AT: the instruction; TRIED: cycles that the calls are spread over */
    uint32_t calls; /* TRIED: of each function, about so many; 0 = 100 */
};

struct host_config {
    const struct product *product;
    uint32_t cycle_us;              /* one the product allows */
    uint32_t program_period_us[3];  /* Program_01..03; 0 = the product's default, or PERIOD_OFF */
    uint32_t data_bytes, osc_bytes; /* TGM_Data, TGM_Oscilloscope; 0 = the product's default */
    uint32_t eeprom_bytes;          /* MAIN.Size_EEPROM_Memory; 0 = all there is */
    uint32_t can_kbit, log_ctrl;    /* MAIN.PLC_CAN_BaudRate, MAIN.Log_Ctrl */
    uint32_t interpolator_items[3]; /* INTERPOLATOR.Buffer_Size; 0 = 2000 */
    unsigned interpolators;         /* 0 = as many as the product has */
    enum clock_choice clock;
    uint64_t seed;
    const struct plant *plant;
    const struct host_servo *servos; /* NULL: every axis of the bus, in bus order */
    unsigned servo_count;
    const struct servo_modes *modes; /* NULL: servo_modes_default */
    const char *faults,
        *faults_name; /* what goes wrong on the bus (docs/faults.md); NULL: nothing */
    const struct scenario *scenario; /* what is played; NULL: nothing */
    const void *eeprom; /* what is stored there, eeprom_size bytes; NULL: nothing yet */
    size_t eeprom_size;
    const char *can, *can_name; /* script of the CAN buses (can.h); NULL: there are none */
    struct audit *audit; /* opened; takes what an instrumented machine sees; NULL: nothing */
    bool without_bus;           /* no slaves are made: for experiments that only call Program_Ini */
    struct mutation mutation;
    struct pcap *capture;   /* where the frames of the bus go; NULL: nowhere */
    bool no_autostart;      /* host_start() starts TG Motion, not the PLC: host_run() does */
    bool kept_module;       /* running the PLC again does not load the file again: globals hold what
                               they held */
    uint32_t counters;      /* where HEADER.Life_Tick, MAIN.Servo_Tick and TIMERS.Timer_Up begin */
    uint32_t digest_cycles; /* how many cycles are followed by evidence.digest, at most
                               DIGEST_STATES */
    bool resettable;        /* keeps a copy of the start, for host_reset() and the like */
    struct host_preempt preempt;
    struct realtime *real; /* opened: slots come when they are due by the wall clock */
    const char
        *shm; /* memories are POSIX shared memory with this in front of their names (shm.h) */
    const struct interp_path *path; /* for interpolator 0, which is started at that time */
    uint64_t path_start_ns;
};

/* Size of a shared memory of the product so configured: what the layout leaves to the product. */
size_t host_memory_bytes(const struct host_config *config, const struct catalogue_memory *memory);
/* Whether the product so configured has the register: SERVO[100] is not on a TGMcontroller. */
bool host_has_register(const struct host_config *config, const struct catalogue_register *reg);

struct host; /* its first member says which layout it was made for */

/* What TG Motion's oscilloscope is to record: its registers, as Observer would write them. */
struct host_osc {
    const struct catalogue_register *channels;
    size_t count;
    uint32_t every; /* cycles */
    bool triggered, falling;
    struct catalogue_register trigger;
    double level;
    uint32_t pretrigger; /* samples; needs 5.02 and a trigger */
};

/* Taken right after Program_04 of every cycle, where the oscilloscope samples. */
typedef void host_sample(void *argument, struct host *host);

/* Makes memories, services and bus for the machine's module. 0, or negative errno with a reason. */
int host_open(struct host **out, const struct host_config *config, struct machine *machine,
              const struct image *image, struct evidence *evidence, char why[HOST_WHY]);
void host_close(struct host *host);

/* Calls Program_Ini. True when it returned 1 and the cycles may begin. */
bool host_start(struct host *host);

/* One Cycle_Time. False when no function of the module can be called any more, or TG Motion was
 * told to end. */
bool host_cycle(struct host *host);

/*
 * PLC control as Observer has it (docs/decisions.md, R1; plc.h): what these ask for begins with the
 * next cycle, like what other programs write to MAIN.PLC_Ctrl.
 *   run    the Run sequence: stop, clear, load, Program_Ini, cyclic calls; also restarts
 *   stop   steps 1 to 4 of it
 *   pause  no function is called, everything else goes on; and back
 *   reset  TG Motion itself begins anew, machine included: what follows is what followed
 *          host_start(), to the last byte; needs host_config.resettable. host_cycles() and
 *          host_time() count from 0 again.
 */
void host_run(struct host *host);
void host_stop(struct host *host);
void host_pause(struct host *host, bool paused);
void host_reset(struct host *host);

enum host_plc {
    HOST_PLC_STOPPED,
    HOST_PLC_CHANGING, /* on the way: stopping, clearing, loading */
    HOST_PLC_RUNNING,
    HOST_PLC_PAUSED,
    HOST_PLC_ERROR /* the last load failed: no such module, or Program_Ini did not return 1 */
};
enum host_plc host_plc(const struct host *host);

/* Simulated nanoseconds since the first cycle of the present run of the PLC. */
uint64_t host_run_time(const struct host *host);

/* The scenario is at its end, or given up. */
bool host_played(const struct host *host);

void host_on_sample(struct host *host, host_sample *sample, void *argument);

/* Sets the oscilloscope up and starts it. 0, or -EINVAL with the reason: too many channels, a
 * register of a type that cannot be recorded, a pre-trigger where there is none. */
int host_osc_arm(struct host *host, const struct host_osc *wanted, char why[HOST_WHY]);
/* What it has recorded: samples, and of each a row with time (s, from the trigger, or from the
 * first sample) and values. */
size_t host_osc_samples(const struct host *host);
void host_osc_row(const struct host *host, size_t index, double *row);

uint64_t host_cycles(const struct host *host);
/* Simulated nanoseconds since the first cycle began. */
uint64_t host_time(const struct host *host);
/* Address of a resolved register in the host's memory; NULL past the end of it. */
const void *host_register(const struct host *host, const struct catalogue_register *reg);

/*
 * The CNC side of an interpolator, which a PLC has no access to. Call between cycles; nothing is
 * allocated.
 *
 * load fills the buffer with a copy of the path, or appends to one that said there would be more.
 * 0; -EBUSY while it moves; -ENOSPC; -EINVAL; with a reason. start: false when there is nothing to
 * run or it runs. stop: along the path, on the normal or the emergency ramp; drop forgets what is
 * left of the path, otherwise start goes on.
 */
int host_interpolator_load(struct host *host, unsigned number, const struct interp_path *path,
                           bool append, char why[HOST_WHY]);
bool host_interpolator_start(struct host *host, unsigned number);
void host_interpolator_stop(struct host *host, unsigned number, bool emergency, bool drop);

#endif
