/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * aside.c - calls that wait in a host service while others are made.
 *
 * A call that is set aside takes its level, and with it its stack, out of those that calls use one
 * inside the other; when it goes on it takes the place of the next one. Natively the service's
 * frames stay on the module's stack, and the processor leaves them as it leaves a call that is
 * abandoned, only that it can come back.
 */
#include <string.h>

#include "machine/machine_private.h"

struct machine_level *machine_level_at(struct machine *machine, unsigned depth)
{
    return &machine->levels[machine->order[depth]];
}

static void exchange(struct machine *machine, unsigned a, unsigned b)
{
    const unsigned level = machine->order[a];

    machine->order[a] = machine->order[b];
    machine->order[b] = level;
}

unsigned machine_level_aside(struct machine *machine, unsigned depth)
{
    const unsigned aside = machine->order[depth];

    exchange(machine, depth, --machine->levels_left);
    return aside;
}

/* At the end of those that are left. */
static void level_back(struct machine *machine, unsigned aside)
{
    unsigned at = machine->levels_left;

    while (machine->order[at] != aside)
        at++;
    exchange(machine, at, machine->levels_left++);
}

bool machine_set_aside(struct machine *machine)
{
    machine->aside =
        machine->config.asides && !machine->rehearsing && machine->ops->set_aside(machine);
    return machine->aside;
}

void machine_take_up(struct machine *machine, unsigned aside)
{
    level_back(machine, aside);
    exchange(machine, machine->ops->depth(machine), machine->levels_left - 1);
}

void machine_go_on(struct machine *machine, struct machine_outcome *outcome)
{
    machine->ops->go_on(machine, outcome);
}

void machine_drop(struct machine *machine, unsigned aside, struct machine_outcome *outcome)
{
    struct machine_level *level = &machine->levels[aside];

    memset(outcome, 0, sizeof *outcome);
    outcome->kind = MACHINE_HANG;
    outcome->fault.signal = SIGALRM;
    outcome->fault.service = level->service;
    outcome->fault.has_pc = machine_vaddr(machine, level->service_return, &outcome->fault.pc);
    machine_forget_frames(machine, level->stack);
    level->hook = NULL;
    level->after = MACHINE_NEVER;
    level->stepping = level->stepped = level->pending = false;
    level_back(machine, aside);
}

bool machine_native_set_aside(const struct machine *machine)
{
    return machine_incident.service_depth == 1 && !machine_incident.hung && machine_state.active &&
           machine->level + 1 < machine->levels_left;
}

/* On the module's stack. */
void machine_native_step_aside(struct machine *machine)
{
    struct machine_level *level = machine_level_at(machine, machine->level);

    level->service = machine_incident.service;
    level->service_return = machine_incident.service_return;
    machine_step_aside(&level->stack_pointer);
}

unsigned machine_native_depth(const struct machine *machine)
{
    return machine->level;
}

void machine_native_go_on(struct machine *machine, struct machine_outcome *outcome)
{
    const struct machine_level *level = machine_level_at(machine, machine->level);

    machine_level_set(machine, machine->level);
    machine_incident.service = level->service;
    machine_incident.service_return = level->service_return;
    machine_incident.service_depth = 1;
    machine_incident.hung = false;
    machine_came_back(machine, machine_enter_aside(level->stack_pointer), outcome);
}
