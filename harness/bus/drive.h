/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * drive.h - one axis of a CiA 402 servo drive: its objects, its state machine, its motion.
 *
 * drive_device.h makes devices of one or two of them. Positions of the master are increments,
 * relative to a zero that homing moves; inside, positions are revolutions of the encoder.
 */
#ifndef HARNESS_BUS_DRIVE_H
#define HARNESS_BUS_DRIVE_H

#include "bus/axis.h"
#include "bus/cia402.h"

#include <math.h>

enum drive_mode_number {
    DRIVE_PP = 1,
    DRIVE_PV = 3,
    DRIVE_TQ = 4,
    DRIVE_HM = 6,
    DRIVE_IP = 7,
    DRIVE_CSP = 8,
    DRIVE_CSV = 9,
    DRIVE_CST = 10,
};

/* Bit of a mode in 0x6502. */
#define DRIVE_MODE(number) (1u << ((number)-1))

/* Those of the generic drives. */
#define DRIVE_MODES                                                                                \
    (DRIVE_MODE(DRIVE_PP) | DRIVE_MODE(DRIVE_PV) | DRIVE_MODE(DRIVE_HM) | DRIVE_MODE(DRIVE_CSP) |  \
     DRIVE_MODE(DRIVE_CSV) | DRIVE_MODE(DRIVE_CST))

/* Error codes (0x603F). */
enum { DRIVE_ERROR_COMMUNICATION = 0x7500, DRIVE_ERROR_FOLLOWING = 0x8611 };

/* What makes the drive of one axis different from another: const rows. */
struct drive_model {
    const struct axis_model *axis;
    uint32_t modes; /* DRIVE_MODE bits */
    uint16_t error_communication, error_following;
    uint16_t error_step;    /* a CSP set point out of the axis' reach; 0: no such watch */
    bool stops_at_switches; /* initial value of the limit switch reaction */
    /* Bit of an error code in error_mask, -1: none. NULL: every fault reaction is 0x605E's. */
    int (*error_bit)(uint16_t code);
};

/* Limit switch reactions (0x2001). */
enum { DRIVE_LIMIT_SHOWN, DRIVE_LIMIT_QUICK_STOP };

/* Values behind the profile objects of one axis; names follow CiA 402. */
struct drive_objects {
    uint16_t error_code;           /* 603F */
    uint16_t controlword;          /* 6040 */
    uint16_t statusword;           /* 6041 */
    struct cia402_options options; /* 605A 605B 605C 605E */
    int8_t mode, mode_display;     /* 6060 6061 */
    int32_t position_demand;       /* 6062 */
    int32_t position_actual;       /* 6064 */
    uint32_t following_window;     /* 6065, increments; 0xFFFFFFFF off */
    uint16_t following_time;       /* 6066, ms */
    uint32_t position_window;      /* 6067, increments */
    int32_t velocity_demand;       /* 606B, increments/s */
    int32_t velocity_actual;       /* 606C, increments/s */
    int16_t target_torque;         /* 6071, 0.1 % of rated */
    uint16_t max_torque;           /* 6072, 0.1 % of rated */
    int16_t torque_actual;         /* 6077, 0.1 % of rated */
    int32_t target_position;       /* 607A */
    int32_t home_offset;           /* 607C */
    int32_t software_limit[2];     /* 607D: increments; the ends of the type: off */
    uint32_t max_profile_velocity; /* 607F, increments/s */
    uint32_t rated_torque;         /* 6076, mNm */
    uint32_t max_motor_speed;      /* 6080, rev/min */
    uint32_t profile_velocity;     /* 6081, increments/s */
    uint32_t acceleration;         /* 6083, increments/s^2 */
    uint32_t deceleration;         /* 6084 */
    uint32_t quick_deceleration;   /* 6085 */
    uint32_t encoder[2];           /* 608F: increments, revolutions */
    int8_t homing_method;          /* 6098 */
    uint32_t homing_speed[2];      /* 6099: to the switch, to its edge */
    uint32_t homing_acceleration;  /* 609A */
    uint8_t period_value;          /* 60C2:1 */
    int8_t period_exponent;        /* 60C2:2 */
    uint16_t torque_high;          /* 60E0, 0.1 % of rated */
    uint16_t torque_low;           /* 60E1, in the negative direction */
    int32_t following_error;       /* 60F4 */
    uint32_t digital_inputs;       /* 60FD */
    int32_t target_velocity;       /* 60FF, increments/s */
    uint32_t user_outputs[2];      /* 60FE: levels, mask */
    int16_t torque_offset;         /* 60B2, 0.1 % of rated */
    uint8_t limit_reaction;        /* 2001, DRIVE_LIMIT_* */
    uint32_t error_mask;           /* errors whose reaction is the emergency ramp */
    uint32_t emergency_ramp;       /* rev/min/s */
};

enum homing_phase {
    HOMING_IDLE,
    HOMING_SEEK,  /* fast, until the switch has the level the edge is approached from */
    HOMING_EDGE,  /* slowly across the edge */
    HOMING_INDEX, /* on to the next index pulse */
    HOMING_STOP,  /* edge found, coming to rest */
    HOMING_DONE,
    HOMING_FAILED,
};

struct drive {
    struct drive_objects o;
    const struct drive_model *model;
    struct cia402 machine;
    struct axis axis;
    unsigned al_state;
    uint64_t next_ns;     /* of the next sub-step */
    uint64_t failed_ns;   /* of the sub-step in which error_code was set */
    bool stale;           /* the actual values among the objects are older than the axis */
    bool rest_stale;      /* those that drive_publish_cyclic() leaves out are */
    uint32_t user_inputs; /* bits 16..31 of the digital inputs */

    int32_t torque_high, torque_low; /* limits that the axis knows of, 0.1 % of rated; -1: none */
    double increments;               /* per revolution */
    double per_increment;            /* revolutions */
    double low, high;                /* software position limits, rev; +-AXIS_NEVER: off */

    double demand, demand_velocity; /* rev, rev/s: what the position loop follows */
    int64_t zero;                   /* encoder increments where the master's zero is */
    bool positioned;        /* the position loop is closed and the following error watched */
    uint32_t outside_steps; /* sub-steps the following error has been outside its window */
    uint32_t modes;         /* DRIVE_MODE bits of those that may be selected now */
    double reaction;        /* emergency ramp of the last fault, rev/s^2; 0: as 0x605E says */

    /* A limit switch has stopped the axis; this controlword, still standing, does not restart it.
     */
    bool limit_stop;
    uint16_t limit_word;

    /* Cyclic modes: a straight line from one set point to the next. */
    int64_t target; /* encoder increments, unwrapped */
    double end;     /* of the line, rev */
    double target_velocity;
    uint32_t steps_left;
    uint64_t arrived_ns;  /* of the last set point */
    uint64_t interval_ns; /* between the last two */
    /* Set points come here and not in the objects: rev, rev/s or a fraction of rated torque. */
    bool fine;
    double fine_set_point;

    /* Profile position. */
    bool moving, acknowledged, buffered;
    int64_t next_target;

    enum homing_phase homing;
    int64_t index; /* HOMING_INDEX: the revolution last seen */
};

/* The objects must have their initial values. */
void drive_init(struct drive *drive, const struct drive_model *model, uint64_t seed);
/* Switched on again: the axis stays where it is. */
void drive_power_on(struct drive *drive, uint64_t now_ns);
void drive_al_state(struct drive *drive, unsigned state);
/* Goes into fault reaction, unless a fault is already being handled. */
void drive_fault(struct drive *drive, uint16_t code);
/* The objects of the process image (or the controlword by SDO) have new values. */
void drive_command(struct drive *drive, uint64_t now_ns);
/* Limits have new values. */
void drive_limits(struct drive *drive);
/* So many increments make a revolution from now on; a homed zero is lost. */
void drive_resolution(struct drive *drive, double increments);
void drive_step(struct drive *drive, uint64_t now_ns);
/* No power: nothing but friction acts on the axis. */
bool drive_coasts(const struct drive *drive);
/* Brings the actual values among the objects up to date; to be called before they are read. */
void drive_publish(struct drive *drive);
/* Only those of the default mapping: 6041 6064 606C 60F4 60FD; they do for most cycles. */
void drive_publish_cyclic(struct drive *drive);

/* An operation mode. `start`: operation is enabled or the mode becomes active, the axis may be
 * moving. `command`: new objects. `step`: one sub-step. `status`: its statusword bits. `run` (may
 * be NULL): 1 to `steps` sub-steps, as `step`, and stops behind the first that leaves the window of
 * the following error; returns how many. */
struct drive_mode {
    int8_t number;
    void (*start)(struct drive *);
    void (*command)(struct drive *, uint64_t now_ns);
    void (*step)(struct drive *);
    uint16_t (*status)(const struct drive *);
    uint32_t (*run)(struct drive *, uint32_t steps);
};

/* drive_profile.c, drive_homing.c, drive_cyclic.c */
extern const struct drive_mode drive_profile_position, drive_profile_velocity, drive_homing;
extern const struct drive_mode drive_cyclic_position, drive_cyclic_velocity, drive_cyclic_torque;
extern const struct drive_mode drive_interpolated_position, drive_profile_torque;

/* Shared by the modes. */
static inline double drive_revolutions(const struct drive *drive, uint32_t increments)
{
    return (double)increments * drive->per_increment;
}

static inline int64_t drive_increments(const struct drive *drive, double revolutions)
{
    return axis_floor(revolutions * drive->increments);
}

/* In encoder increments. */
static inline int64_t drive_actual(const struct drive *drive)
{
    return drive_increments(drive, drive->axis.position);
}

/* Of the following error, in revolutions. */
static inline double drive_window(const struct drive *drive)
{
    return drive->o.following_window == UINT32_MAX
               ? INFINITY
               : drive_revolutions(drive, drive->o.following_window);
}

static inline double drive_lesser(double a, double b)
{
    return a < b ? a : b;
}

/* They may come with every cycle, and seldom change. */
static inline void drive_take_torque_limits(struct drive *drive)
{
    const struct drive_objects *o = &drive->o;
    uint16_t high = o->torque_high < o->max_torque ? o->torque_high : o->max_torque;
    uint16_t low = o->torque_low < o->max_torque ? o->torque_low : o->max_torque;

    if (high != drive->torque_high) {
        drive->torque_high = high;
        drive->axis.torque_high = drive_lesser(high / 1000.0, drive->axis.peak);
    }
    if (low != drive->torque_low) {
        drive->torque_low = low;
        drive->axis.torque_low = drive_lesser(low / 1000.0, drive->axis.peak);
    }
}

/* After every sub-step of a closed position loop. */
void drive_watch_following_error(struct drive *drive);

/* Values beyond an object's 32 bits show as its limit. */
static inline int32_t drive_rounded(double value)
{
    double limited = value < INT32_MAX ? value : INT32_MAX;

    limited = limited > INT32_MIN ? limited : INT32_MIN;
    return (int32_t)(limited + copysign(0.5, limited));
}

/* Increments of the master (32 bits, wrapping) as encoder increments close to `near`. */
int64_t drive_unwrap(const struct drive *drive, int32_t user, int64_t near);
/* The demand starts from where the axis is and moves. */
void drive_demand_actual(struct drive *drive);
/* Velocity demand towards `velocity`, position demand along with it, axis after it. */
void drive_ramp(struct drive *drive, double velocity, double acceleration);
/* Towards a position with a trapezoid; true when there. */
bool drive_travel(struct drive *drive, double position, double speed, double acceleration,
                  double deceleration);

/* A position within the software limits; a velocity that does not lead further out of them. */
double drive_within(const struct drive *drive, double position);
double drive_inward(const struct drive *drive, double velocity);

bool drive_homing_supported(int number);
bool drive_mode_supported(const struct drive *drive, int number);

#endif
