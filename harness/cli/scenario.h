/* SPDX-License-Identifier: GPL-2.0-or-later */
/* scenario.h - scenarios as files named on the command line. */
#ifndef HARNESS_CLI_SCENARIO_H
#define HARNESS_CLI_SCENARIO_H

#include "cli/cli.h"
#include "host/evidence.h"
#include "host/scenario.h"

/* The scenario in the file, for this product; NULL, and the reason said, when it is none. */
struct scenario *scenario_from_file(const struct command *command, const char *path,
                                    const struct product *product);

/* What failed, one line each, and a summary. Returns EXIT_OK, EXIT_MODULE when something failed,
 * EXIT_INCOMPLETE when it was not played to its end. */
int scenario_conclude(FILE *stream, const struct scenario *scenario, const char *path,
                      const struct evidence *evidence);

#endif
