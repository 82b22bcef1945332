/* SPDX-License-Identifier: GPL-2.0-or-later */
/* configuration.h - --config FILE: a configuration with the bus file and the fault script that it
 * names. */
#ifndef HARNESS_CLI_CONFIGURATION_H
#define HARNESS_CLI_CONFIGURATION_H

#include "bus/busfile.h"
#include "cli/cli.h"
#include "host/config.h"

struct configuration {
    struct config config;
    struct config_store store;
    struct busfile *bus; /* of [Simulation] Bus; NULL: none */
    char *faults;        /* of [Simulation] Faults */
    char faults_path[4096];
};

/* Reads the file, says every problem on standard error, and puts what it means into `host`. Lives
 * as long as the host. 0, or EXIT_CALL when it cannot be used. */
int configuration_open(struct configuration *configuration, const struct command *command,
                       const char *path, const struct product *product, struct host_config *host);
void configuration_close(struct configuration *configuration);

/* Its problems, one a line: "TGM.INI:12: ...". */
void configuration_problems(const struct config *config, const char *path, FILE *stream);

#endif
