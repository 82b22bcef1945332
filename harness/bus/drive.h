/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * drive.h - one axis of a CiA 402 servo drive: its objects, its state machine, its motion.
 *
 * The device file (dev_drive.c) gives it an identity and a process image; drive_od.c its object
 * dictionary. Positions of the master are increments, 2^20 to the revolution, relative to a zero
 * that homing moves; inside, positions are revolutions of the encoder.
 */
#ifndef HARNESS_BUS_DRIVE_H
#define HARNESS_BUS_DRIVE_H

#include "bus/axis.h"
#include "bus/cia402.h"
#include "bus/od.h"
#include "bus/sii.h"

enum drive_mode_number {
    DRIVE_PP = 1,
    DRIVE_PV = 3,
    DRIVE_HM = 6,
    DRIVE_CSP = 8,
    DRIVE_CSV = 9,
    DRIVE_CST = 10,
};

/* Error codes (0x603F). */
enum { DRIVE_ERROR_COMMUNICATION = 0x7500, DRIVE_ERROR_FOLLOWING = 0x8611 };

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
    int32_t following_error;       /* 60F4 */
    uint32_t digital_inputs;       /* 60FD */
    int32_t target_velocity;       /* 60FF, increments/s */
    uint32_t supported_modes;      /* 6502 */
};

enum homing_phase {
    HOMING_IDLE,
    HOMING_SEEK, /* fast, until the switch has the level the edge is approached from */
    HOMING_EDGE, /* slowly across the edge */
    HOMING_STOP, /* edge found, coming to rest */
    HOMING_DONE,
    HOMING_FAILED,
};

struct drive {
    struct drive_objects o;
    struct cia402 machine;
    struct axis axis;
    unsigned al_state;
    uint64_t next_ns; /* of the next sub-step */
    bool stale;       /* the actual values among the objects are older than the axis */

    double demand, demand_velocity; /* rev, rev/s: what the position loop follows */
    int64_t zero;                   /* encoder increments where the master's zero is */
    bool positioned;        /* the position loop is closed and the following error watched */
    uint32_t outside_steps; /* sub-steps the following error has been outside its window */

    /* Cyclic modes: a straight line from one set point to the next. */
    int64_t target; /* encoder increments, unwrapped */
    double target_velocity;
    uint32_t steps_left;
    uint64_t arrived_ns;  /* of the last set point */
    uint64_t interval_ns; /* between the last two */

    /* Profile position. */
    bool moving, acknowledged, buffered;
    int64_t next_target;

    enum homing_phase homing;
};

void drive_init(struct drive *drive, uint64_t seed);
/* The axis has coasted while there was no power. */
void drive_power_on(struct drive *drive, uint64_t now_ns);
void drive_al_state(struct drive *drive, unsigned state);
void drive_fault(struct drive *drive, uint16_t code);
/* The objects of the process image (or the controlword by SDO) have new values. */
void drive_command(struct drive *drive, uint64_t now_ns);
void drive_step(struct drive *drive, uint64_t now_ns);
/* Brings the actual values among the objects up to date; to be called before they are read. */
void drive_publish(struct drive *drive);

/* An operation mode. `start`: operation is enabled or the mode becomes active, the axis may be
 * moving. `command`: new objects. `step`: one sub-step. `status`: its statusword bits. */
struct drive_mode {
    int8_t number;
    void (*start)(struct drive *);
    void (*command)(struct drive *, uint64_t now_ns);
    void (*step)(struct drive *);
    uint16_t (*status)(const struct drive *);
};

/* drive_profile.c, drive_homing.c, drive_cyclic.c; ends with number 0. */
extern const struct drive_mode drive_profile_position, drive_profile_velocity, drive_homing;
extern const struct drive_mode drive_cyclic_position, drive_cyclic_velocity, drive_cyclic_torque;

/* Shared by the modes. */
double drive_revolutions(uint32_t increments);
int64_t drive_actual(const struct drive *drive); /* encoder increments */
/* Increments of the master (32 bits, wrapping) as encoder increments close to `near`. */
int64_t drive_unwrap(const struct drive *drive, int32_t user, int64_t near);
/* The demand starts from where the axis is and moves. */
void drive_demand_actual(struct drive *drive);
/* Velocity demand towards `velocity`, position demand along with it, axis after it. */
void drive_ramp(struct drive *drive, double velocity, double acceleration);
/* Towards a position with a trapezoid; true when there. */
bool drive_travel(struct drive *drive, double position, double speed, double acceleration,
                  double deceleration);

bool drive_homing_supported(int number);
bool drive_mode_supported(int number);

/* Object dictionary rows of one axis live in drive_od.c; check, refresh and written serve struct
 * od. */
uint32_t drive_check(void *device, uint16_t index, uint8_t subindex, int64_t value);
void drive_refresh(void *device);
void drive_written(void *device, uint16_t index, uint8_t subindex);

/* The whole device: one axis and its communication objects. */
#define DRIVE_NAME "Simulated servo drive CiA 402"
/* Longer than a mailbox: masters must read it in segments. */
#define DRIVE_HARDWARE                                                                             \
    "simulation: an inertia of one revolution per revolution between two hard stops, with "        \
    "friction, a home switch, and 2^20 increments; no mains, no motor, no heat"

enum {
    DRIVE_RX_MAPS = 4,
    DRIVE_TX_MAPS = 2,
    DRIVE_IMAGE_MAX = 0x100 / 3, /* three buffers in the 0x100 bytes between SM2 and SM3 */
};

struct drive_device {
    struct drive axis;
    uint8_t error_register; /* 1001 */
    uint32_t serial;        /* 1018:4 */
    struct pdo_assign assign[2];
    struct pdo_map rx[DRIVE_RX_MAPS], tx[DRIVE_TX_MAPS];
    struct pdo_image image[2];
};

extern const struct od drive_od;
/* Loads the default mapping; the tables of the SII come from the same source. */
void drive_od_defaults(struct drive_device *device);
extern const struct sii_pdo drive_rx_pdos[DRIVE_RX_MAPS], drive_tx_pdos[DRIVE_TX_MAPS];

#endif
