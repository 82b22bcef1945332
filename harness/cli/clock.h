/* SPDX-License-Identifier: GPL-2.0-or-later */
/* clock.h - what `tgm run` says of the real clock, of interrupts and of shared memory. */
#ifndef HARNESS_CLI_CLOCK_H
#define HARNESS_CLI_CLOCK_H

#include <stdio.h>

#include "cli/cli.h"
#include "host/experiment.h"
#include "host/shm.h"

/* "virtual", "real"; "seeded", "at=12". 0 or EXIT_CALL, and what was wrong has been said. */
int clock_read(const struct command *command, const char *text, struct experiment *experiment);
int preempt_read(const struct command *command, const char *text, struct experiment *experiment);
int shm_prefix_check(const struct command *command, const char *prefix);

/* While the run goes on: an interrupt from the keyboard ends it with the cycle, a second one at
 * once; shared memories are taken away in any case. */
void stop_catch(struct experiment *experiment, const struct shm *shm);
void stop_restore(void);

/* How punctual the run was, beside the empty loop; nothing on the virtual clock. */
void clock_tell(FILE *screen, const struct evidence_clock *clock);
/* Who was interrupted where and by whom. */
void interrupts_tell(FILE *screen, const struct evidence *evidence, const struct image *image);

#endif
