/* SPDX-License-Identifier: GPL-2.0-or-later */
/* scope.h - the words of the command line that set TG Motion's oscilloscope up. */
#ifndef HARNESS_CLI_SCOPE_H
#define HARNESS_CLI_SCOPE_H

#include "cli/cli.h"
#include "host/host.h"

/* "DIO[0].In0 rising 0.5". 0 or EXIT_CALL. */
int scope_read_trigger(const struct command *command, const struct catalogue *catalogue,
                       const char *text, struct host_osc *osc);

#endif
