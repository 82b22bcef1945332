/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fiber.h - a second stack in the same thread, for code that waits.
 *
 * SOEM's mailbox transfers and its recovery of lost slaves are written to block. On a fiber they
 * can: when they wait they yield, the cyclic exchange goes on, and they are resumed at the virtual
 * time they waited for. No threads, no system call, no allocation after fiber_open(): it works in a
 * sealed worker, and the order of events is a function of the inputs alone.
 */
#ifndef HARNESS_BUS_FIBER_H
#define HARNESS_BUS_FIBER_H

#include <stdbool.h>

#define FIBER_STACK (256 * 1024)

struct fiber;

/* `entry` never returns; it yields whenever it has nothing to do. 0 or -ENOMEM. */
int fiber_open(struct fiber **out, void (*entry)(void *argument), void *argument);
/* Gives the stack back, wherever the fiber stands. NULL is allowed. */
void fiber_close(struct fiber *fiber);

/* As after fiber_open(): what stood on its stack is forgotten. Not from inside it. */
void fiber_restart(struct fiber *fiber);

/* Lets the fiber run until it yields. Not from inside it. */
void fiber_resume(struct fiber *fiber);
/* From inside: back to whoever resumed it. */
void fiber_yield(struct fiber *fiber);
/* Is this the fiber's own code that is running? */
bool fiber_inside(const struct fiber *fiber);

#endif
