/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * cia402.h - the CiA 402 power state machine: controlword in, state out. It decides; what moving,
 * stopping and switching power means is its owner's business.
 */
#ifndef HARNESS_BUS_CIA402_H
#define HARNESS_BUS_CIA402_H

#include <stdbool.h>
#include <stdint.h>

enum cia402_state {
    CIA402_NOT_READY,
    CIA402_SWITCH_ON_DISABLED,
    CIA402_READY_TO_SWITCH_ON,
    CIA402_SWITCHED_ON,
    CIA402_OPERATION_ENABLED,
    CIA402_QUICK_STOP_ACTIVE,
    CIA402_FAULT_REACTION,
    CIA402_FAULT,
    CIA402_STATES,
};

enum {
    CW_SWITCH_ON = 1 << 0,
    CW_VOLTAGE = 1 << 1,
    CW_QUICK_STOP = 1 << 2, /* 0 stops */
    CW_ENABLE = 1 << 3,
    CW_MODE_4 = 1 << 4, /* PP: new set point; HM: start; IP: interpolate */
    CW_FAULT_RESET = 1 << 7,
    CW_HALT = 1 << 8,

    SW_WARNING = 1 << 7,
    SW_REMOTE = 1 << 9,
    SW_TARGET_REACHED = 1 << 10,
    SW_INTERNAL_LIMIT = 1 << 11,
    SW_MODE_12 = 1 << 12, /* CSP, CSV, CST: follows the command */
    SW_MODE_13 = 1 << 13, /* CSP: following error */
};

/* Option codes, as in 0x605A, 0x605B, 0x605C, 0x605E. */
struct cia402_options {
    int16_t quick_stop, shutdown, disable, fault_reaction;
};

struct cia402 {
    enum cia402_state state;
    /* Operation enabled on the way out: the axis ramps down and the state changes at standstill. */
    bool leaving;
    enum cia402_state leave_to;
    /* A controlword that led nowhere from this state: most evaluations repeat it. */
    enum cia402_state still_state;
    uint16_t still_word;
    bool reset_seen; /* level of the fault reset bit at the last evaluation */
};

/* Power-on: transitions 0 and 1. */
void cia402_init(struct cia402 *machine);

/* One evaluation of a controlword. At most one transition, except 3 and 4 together. */
void cia402_command(struct cia402 *machine, uint16_t controlword,
                    const struct cia402_options *options, bool fault_gone);

/* Transition 11 for a reason of the drive's own. False when operation is not enabled. */
bool cia402_quick_stop(struct cia402 *machine, const struct cia402_options *options);

/* Transition 13. False when a fault is already being handled. */
bool cia402_fail(struct cia402 *machine);

/* The axis stands still: ends ramps (transitions 5, 8, 12, 14). */
void cia402_standstill(struct cia402 *machine, const struct cia402_options *options);

/* Bits 0..6 of the statusword. */
uint16_t cia402_status(const struct cia402 *machine);

/* The power stage is on. */
bool cia402_powered(const struct cia402 *machine);
/* Power is on but the axis must be brought to a stop. */
bool cia402_stopping(const struct cia402 *machine);

#endif
