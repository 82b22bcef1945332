/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * tgz.h - the TG Drives TGZ servo drive as its manuals describe it, with one or two axes: fixed
 * PDO maps for CiA 402 (0x1701..0x1703 with 0x1b01, 40 bytes) and native (0x1721 with 0x1b21, 44
 * bytes), vendor registers, D-Modes, error bits, emergency stop.
 *
 * The manuals do not publish identity and the entries of the maps: the identity is configuration
 * (bus_device.identity), the entries name the registers that hold the same values. Where no
 * register has the width, objects 0x4010..0x4012 are ours. Offsets and lengths are the manual's.
 *
 * Both axes' objects exist on a one-axis drive; those of axis 2 are dead and show a fault.
 *
 * Inputs that the outside world can hold (bus_set_input):
 *   0, 1, 2; 32, 33, 34   limit and home switches of axis 1; 2, as in drive_device.h
 *   16 .. 23              digital inputs 1..8, shared by the axes
 *   64, 65                analog inputs 1, 2: 0..32767 = 0..10 V
 */
#ifndef HARNESS_BUS_TGZ_H
#define HARNESS_BUS_TGZ_H

#include "bus/drive_device.h"

enum {
    TGZ_RX_CSP = 0x1701,
    TGZ_RX_CSV = 0x1702,
    TGZ_RX_CST = 0x1703,
    TGZ_RX_NATIVE = 0x1721,
    TGZ_TX_COE = 0x1b01,
    TGZ_TX_NATIVE = 0x1b21,
    TGZ_RX_MAPS = 4,
    TGZ_TX_MAPS = 2,
    TGZ_COE_BYTES = 40,
    TGZ_NATIVE_BYTES = 44,
};

/* Control and status of the native maps. */
enum {
    TGZ_CONTROL_CLEAR = 1 << 0,
    TGZ_CONTROL_POWER = 1 << 1,
    TGZ_CONTROL_OUTPUTS = 28, /* bits 28..30: outputs 1, 3, 5 of axis 1, 2, 4, 6 of axis 2 */

    TGZ_STATUS_POWER = 1 << 0,
    TGZ_STATUS_HARDWARE = 1 << 1,
    TGZ_STATUS_SOFTWARE = 1 << 2,
    TGZ_STATUS_BRAKE = 1 << 3, /* released */
    TGZ_STATUS_NO_ERROR = 1 << 4,
    TGZ_STATUS_INITIALISED = 1 << 5,
    TGZ_STATUS_FIELDBUS = 1 << 6,
    TGZ_STATUS_RAMP = 1 << 8, /* emergency ramp active */
    TGZ_STATUS_RAMPED = 1 << 9,
    TGZ_STATUS_INPUTS = 28, /* bits 28..31: inputs 1, 3, 5, 7 of axis 1, 2, 4, 6, 8 of axis 2 */
};

/* D-Mode: what the drive does; a CiA 402 mode that does not match it is ignored. */
enum {
    TGZ_MODE_POSITION = 3,
    TGZ_MODE_GENERATOR_SPEED = 6,
    TGZ_MODE_GENERATOR_POSITION = 7,
    TGZ_MODE_CURRENT = 9,
    TGZ_MODE_SPEED = 10,
};

enum {
    TGZ_FULL_SCALE = 32767,   /* of currents, limits and analog values */
    TGZ_RATED_CURRENT = 5000, /* mA, M-Inull; M-Ipeak is as much above it as the peak torque */
    TGZ_GUARD_KEY = 0xaa55,
    TGZ_ERROR_STO = 5,
    TGZ_ERROR_EMERGENCY = 20,
    TGZ_CODE_HOST = 0x8100,
    TGZ_CODE_FOLLOWING = 0x8612,
    TGZ_CODE_STEP = 0x8611,
    TGZ_CODE_EMERGENCY = 0xf001,
};

/* Registers of one axis; the number is that of axis 1. */
struct tgz_axis {
    uint32_t d_mode;          /* 2303 */
    uint32_t input_mask;      /* 2318: digital inputs that stop, bit 0 = input 1 */
    uint32_t guard_ms;        /* 2319: 0 off */
    uint32_t guard_reset;     /* 310D */
    uint64_t guard_due_ns;    /* 0: not running */
    int32_t iq_ma, speed_rpm; /* 3306, 3312 */
    uint32_t angle;           /* 3310: 2^32 per revolution */
    int32_t revolutions;      /* 3311 */
    uint32_t status, errors;  /* 3325, 3326 */
    uint32_t set_angle;       /* 332B: as received */
    int32_t set_revolutions;  /* 332C */
    uint32_t control;         /* 332D */
    int16_t set_current;      /* 4010, shown as 332E */
    uint16_t current_limit;   /* 4011, shown as 332F: 0 none, TGZ_FULL_SCALE no current */
    uint32_t shown_current, shown_limit;
    int16_t current; /* 4012 */
    uint16_t analog; /* 4002, shown as 3328 */
    uint32_t shown_analog;
    uint16_t status_low; /* 4003 */
};

/* 0x6502 */
#define TGZ_MODES (DRIVE_MODES | DRIVE_MODE(DRIVE_TQ) | DRIVE_MODE(DRIVE_IP))

struct tgz_device {
    struct drive_device drive; /* first: its callbacks see the device as theirs */
    struct tgz_axis reg[DRIVE_AXES];
    uint8_t inputs, outputs;               /* 4000, 4001 */
    uint32_t shown_inputs, shown_outputs;  /* 3330, 333C */
    int32_t external;                      /* 333E: nothing is connected */
    uint32_t node_id;                      /* 200D */
    uint32_t sync_us, cycle_us, packet_us; /* 200E, 2010, 3340 */
    uint64_t outputs_ns;                   /* of the last process data */
    uint64_t pulse_ns[2];                  /* of the last SYNC0 and SYNC1 */
    uint64_t period_ns[2];                 /* between the last two */
    unsigned wrong_periods;                /* in a row */
};

extern const struct od tgz_od;
/* Entries of the fixed maps; which one is assigned says the sm field of a row of a device. */
extern const struct sii_pdo tgz_rx_coe[TGZ_RX_MAPS], tgz_rx_native[TGZ_RX_MAPS];
extern const struct sii_pdo tgz_tx_coe[TGZ_TX_MAPS], tgz_tx_native[TGZ_TX_MAPS];

/* tgz_errors.c: bit of an error code, -1 when the drive has no such error; the rules of 0x1001 and
 * 0x1003. */
int tgz_error_bit(uint16_t code);
uint8_t tgz_error_register(const struct drive_device *device);
uint32_t tgz_history_entry(unsigned axis, uint16_t code);
/* Enters what has happened into the error words, and stops on inputs. */
void tgz_watch(struct tgz_device *tgz);
/* Time passes for the axes and the guards. */
void tgz_pass(struct tgz_device *tgz, uint64_t now_ns);
void tgz_guard_start(struct tgz_device *tgz, unsigned axis);

/* tgz_native.c: the native maps as set points and actual values of the axes. */
bool tgz_is_native(const struct tgz_device *tgz);
void tgz_native_command(struct tgz_device *tgz, unsigned axis, uint64_t now_ns);
void tgz_publish(struct tgz_device *tgz);
/* CiA 402 modes that a D-Mode lets through; 0: no such D-Mode here. */
uint32_t tgz_allowed_modes(uint32_t d_mode);

/* Callbacks of struct od. */
uint32_t tgz_check(void *device, uint16_t index, uint8_t subindex, int64_t value);
void tgz_refresh(void *device);
void tgz_written(void *device, uint16_t index, uint8_t subindex);

#endif
