/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * scenario.h - a machine played from a text (docs/scenarios.md): what the world does to it, and
 * what is expected of the module.
 *
 *     at 10ms input DIO[0] channel 0 = 1
 *     at 50ms fault unplug after 1 for 20ms
 *     wait until SERVO[0].Status == SERVO_READY_ENABLE within 500ms
 *     every 1ms expect abs(SERVO[0].PositionError) < 500
 *     end at 2s
 *
 * Reading is done once, in the process of whoever asks; the host binds the scenario to its memories
 * and its bus and plays it, and what it saw is in the evidence. Nothing of a scenario is changed by
 * playing it.
 */
#ifndef HARNESS_HOST_SCENARIO_H
#define HARNESS_HOST_SCENARIO_H

#include "host/catalogue.h"

#define SCENARIO_WHY  512
#define SCENARIO_TEXT 512     /* one line for people */
#define SCENARIO_FILE 1048576 /* bytes of a scenario, at most */

struct scenario;
struct evidence_failure;
struct evidence_line;

/* Names of registers and constants are those of the catalogue. 0, -ENOMEM, or -EINVAL with
 * "name:line:column: what; expected ..." in why. The text may go away afterwards. */
int scenario_read(struct scenario **out, const char *text, size_t length, const char *name,
                  const struct catalogue *catalogue, char why[SCENARIO_WHY]);
void scenario_close(struct scenario *scenario);

/* The most cycles that it can take at this Cycle_Time. */
uint64_t scenario_cycles(const struct scenario *scenario, uint32_t cycle_us);

/* "gantry.scenario:12:16: SERVO[0].Status == 3 not within 20ms: it was 2". What the evidence says
 * is not trusted. */
void scenario_tell(const struct scenario *scenario, const struct evidence_failure *failure,
                   char text[SCENARIO_TEXT]);
/* What a `log` said. */
void scenario_tell_line(const struct scenario *scenario, const struct evidence_line *line,
                        char text[SCENARIO_TEXT]);

/* The language, for documents and completion: NULL past the end. */
const char *scenario_grammar(size_t index);

#endif
