/* SPDX-License-Identifier: GPL-2.0-or-later */
/* machine.h - which machine `tgm run` is to run a module on. */
#ifndef HARNESS_CLI_MACHINE_H
#define HARNESS_CLI_MACHINE_H

#include "cli/cli.h"
#include "host/experiment.h"

/* "native", "instrumented"; NULL: natively where the module runs so. 0 or EXIT_CALL, and what was
 * wrong has been said: of the word, or of the image, which does not run there. */
int machine_read(const struct command *command, const char *text, struct experiment *experiment);
int machine_check(const struct command *command, const char *text, const struct image *image,
                  const struct experiment *experiment);

#endif
