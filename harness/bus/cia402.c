/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/cia402.h"

#include <stddef.h>

void cia402_init(struct cia402 *machine)
{
    *machine = (struct cia402){ .state = CIA402_SWITCH_ON_DISABLED };
}

/* Which option code, if any, lets the axis ramp down before the state changes. */
enum ramp { NOW, BY_SHUTDOWN, BY_DISABLE, BY_QUICK_STOP };

/* The command table of CiA 402: pattern of bits 7 and 3..0. First match wins. Transition 4 follows
 * 3 in the same evaluation; everything else waits for the next controlword. */
static const struct transition {
    uint8_t number;
    enum cia402_state from;
    uint8_t mask, value;
    enum cia402_state to;
    enum ramp ramp;
} transitions[] = {
    { 2, CIA402_SWITCH_ON_DISABLED, 0x87, 0x06, CIA402_READY_TO_SWITCH_ON, NOW },
    { 3, CIA402_READY_TO_SWITCH_ON, 0x87, 0x07, CIA402_SWITCHED_ON, NOW },
    { 7, CIA402_READY_TO_SWITCH_ON, 0x82, 0x00, CIA402_SWITCH_ON_DISABLED, NOW },
    { 7, CIA402_READY_TO_SWITCH_ON, 0x86, 0x02, CIA402_SWITCH_ON_DISABLED, NOW },
    { 4, CIA402_SWITCHED_ON, 0x8f, 0x0f, CIA402_OPERATION_ENABLED, NOW },
    { 6, CIA402_SWITCHED_ON, 0x87, 0x06, CIA402_READY_TO_SWITCH_ON, NOW },
    { 10, CIA402_SWITCHED_ON, 0x82, 0x00, CIA402_SWITCH_ON_DISABLED, NOW },
    { 10, CIA402_SWITCHED_ON, 0x86, 0x02, CIA402_SWITCH_ON_DISABLED, NOW },
    { 5, CIA402_OPERATION_ENABLED, 0x8f, 0x07, CIA402_SWITCHED_ON, BY_DISABLE },
    { 8, CIA402_OPERATION_ENABLED, 0x87, 0x06, CIA402_READY_TO_SWITCH_ON, BY_SHUTDOWN },
    { 9, CIA402_OPERATION_ENABLED, 0x82, 0x00, CIA402_SWITCH_ON_DISABLED, NOW },
    { 11, CIA402_OPERATION_ENABLED, 0x86, 0x02, CIA402_QUICK_STOP_ACTIVE, BY_QUICK_STOP },
    { 12, CIA402_QUICK_STOP_ACTIVE, 0x82, 0x00, CIA402_SWITCH_ON_DISABLED, NOW },
    { 16, CIA402_QUICK_STOP_ACTIVE, 0x8f, 0x0f, CIA402_OPERATION_ENABLED, NOW },
};

static const struct transition *match(enum cia402_state from, uint16_t controlword)
{
    for (size_t i = 0; i < sizeof transitions / sizeof *transitions; i++) {
        const struct transition *t = &transitions[i];

        if (t->from == from && (controlword & t->mask) == t->value)
            return t;
    }
    return NULL;
}

static bool stays_in_quick_stop(const struct cia402_options *options)
{
    return options->quick_stop >= 5;
}

/* Option 0: no ramp, power off at once. */
static enum cia402_state quick_stop_state(const struct cia402_options *options)
{
    return options->quick_stop == 0 ? CIA402_SWITCH_ON_DISABLED : CIA402_QUICK_STOP_ACTIVE;
}

static void take(struct cia402 *machine, const struct transition *t,
                 const struct cia402_options *options)
{
    bool ramp = (t->ramp == BY_DISABLE && options->disable == 1) ||
                (t->ramp == BY_SHUTDOWN && options->shutdown == 1);

    if (t->number == 16 && !stays_in_quick_stop(options))
        return;
    machine->leaving = ramp;
    if (ramp) {
        machine->leave_to = t->to;
        return;
    }
    machine->state = t->ramp == BY_QUICK_STOP ? quick_stop_state(options) : t->to;
}

void cia402_command(struct cia402 *machine, uint16_t controlword,
                    const struct cia402_options *options, bool fault_gone)
{
    bool reset = controlword & CW_FAULT_RESET;
    bool edge = reset && !machine->reset_seen;
    const struct transition *t;

    machine->reset_seen = reset;
    if (machine->state == CIA402_FAULT) {
        if (edge && fault_gone)
            machine->state = CIA402_SWITCH_ON_DISABLED;
        return;
    }
    if (machine->state == machine->still_state && controlword == machine->still_word)
        t = NULL;
    else
        t = match(machine->state, controlword);
    if (!t) {
        machine->still_state = machine->state;
        machine->still_word = controlword;
        /* Enable operation again takes a ramping axis back. */
        if (machine->state == CIA402_OPERATION_ENABLED && (controlword & 0x8f) == 0x0f)
            machine->leaving = false;
        return;
    }
    take(machine, t, options);
    if (t->number == 3) {
        t = match(machine->state, controlword);
        if (t && t->number == 4)
            take(machine, t, options);
    }
}

bool cia402_quick_stop(struct cia402 *machine, const struct cia402_options *options)
{
    if (machine->state != CIA402_OPERATION_ENABLED)
        return false;
    machine->leaving = false;
    machine->state = quick_stop_state(options);
    return true;
}

bool cia402_fail(struct cia402 *machine)
{
    if (machine->state == CIA402_FAULT || machine->state == CIA402_FAULT_REACTION)
        return false;
    /* Without power there is nothing to bring to a stop: 13 and 14 at once. */
    machine->state = cia402_powered(machine) ? CIA402_FAULT_REACTION : CIA402_FAULT;
    machine->leaving = false;
    return true;
}

void cia402_standstill(struct cia402 *machine, const struct cia402_options *options)
{
    if (machine->leaving) {
        machine->state = machine->leave_to;
        machine->leaving = false;
    } else if (machine->state == CIA402_FAULT_REACTION) {
        machine->state = CIA402_FAULT;
    } else if (machine->state == CIA402_QUICK_STOP_ACTIVE && !stays_in_quick_stop(options)) {
        machine->state = CIA402_SWITCH_ON_DISABLED;
    }
}

uint16_t cia402_status(const struct cia402 *machine)
{
    /* Voltage enabled (bit 4) is up: the DC link of this drive always is. */
    static const uint8_t bits[CIA402_STATES] = {
        [CIA402_NOT_READY] = 0x00,          [CIA402_SWITCH_ON_DISABLED] = 0x50,
        [CIA402_READY_TO_SWITCH_ON] = 0x31, [CIA402_SWITCHED_ON] = 0x33,
        [CIA402_OPERATION_ENABLED] = 0x37,  [CIA402_QUICK_STOP_ACTIVE] = 0x17,
        [CIA402_FAULT_REACTION] = 0x1f,     [CIA402_FAULT] = 0x18,
    };

    return bits[machine->state];
}

bool cia402_powered(const struct cia402 *machine)
{
    return machine->state == CIA402_SWITCHED_ON || machine->state == CIA402_OPERATION_ENABLED ||
           machine->state == CIA402_QUICK_STOP_ACTIVE || machine->state == CIA402_FAULT_REACTION;
}

bool cia402_stopping(const struct cia402 *machine)
{
    return machine->leaving || machine->state == CIA402_QUICK_STOP_ACTIVE ||
           machine->state == CIA402_FAULT_REACTION;
}
