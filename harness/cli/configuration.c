/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/configuration.h"

#include <stdlib.h>
#include <string.h>

void configuration_problems(const struct config *config, const char *path, FILE *stream)
{
    for (size_t i = 0; i < config->problem_count; i++) {
        const struct config_problem *problem = &config->problems[i];
        fprintf(stream, "%s:", path);
        if (problem->line != 0)
            fprintf(stream, "%u:", problem->line);
        fprintf(stream, " %s%s\n", problem->warning ? "warning: " : "", problem->text);
    }
    const size_t all = config->errors + config->warnings;
    if (all > config->problem_count)
        fprintf(stream, "%s: and %zu problems more\n", path, all - config->problem_count);
}

/* Names in a file are relative to it. */
static bool beside(const char *path, const char *name, char *out, size_t size)
{
    const char *slash = name[0] == '/' ? NULL : strrchr(path, '/');
    const int folder = slash != NULL ? (int)(slash - path) + 1 : 0;
    return (size_t)snprintf(out, size, "%.*s%s", folder, path, name) < size;
}

static int open_bus(struct configuration *c, const struct command *command, const char *path)
{
    char name[4096], why[LIBRARY_WHY];
    if (!beside(path, c->config.bus, name, sizeof name))
        return complain(command, "%s: the name of Bus is too long", path);
    if (busfile_read(&c->bus, name, why) != 0)
        return complain(command, "%s: Bus in [Simulation]: %s", path, why);
    c->store.plant = (struct plant){ .devices = c->bus->devices,
                                     .device_count = c->bus->device_count,
                                     .library = c->bus->library,
                                     .redundant = c->bus->redundant || c->config.redundancy != 0,
                                     .as_found = true };
    return 0;
}

static int open_faults(struct configuration *c, const struct command *command, const char *path)
{
    if (!beside(path, c->config.faults, c->faults_path, sizeof c->faults_path))
        return complain(command, "%s: the name of Faults is too long", path);
    c->faults = read_text(command, "fault script", c->faults_path);
    return c->faults != NULL ? 0 : EXIT_CALL;
}

int configuration_open(struct configuration *c, const struct command *command, const char *path,
                       const struct product *product, struct host_config *host)
{
    char why[CONFIG_WHY];
    int status = 0;
    c->bus = NULL;
    c->faults = NULL;
    if (config_read(&c->config, product, path, why) != 0)
        return complain(command, "%s", why);
    configuration_problems(&c->config, path, stderr);
    if (c->config.errors > 0)
        return complain(command, "'%s' cannot be used: %u problem%s", path, c->config.errors,
                        c->config.errors == 1 ? "" : "s");
    config_apply(&c->config, &c->store, host);
    if (c->config.bus[0] != '\0')
        status = open_bus(c, command, path);
    else
        config_plant(&c->config, &c->store);
    if (status == 0 && c->config.faults[0] != '\0')
        status = open_faults(c, command, path);
    host->plant = &c->store.plant;
    host->faults = c->faults;
    host->faults_name = c->faults != NULL ? c->faults_path : NULL;
    if (status != 0)
        configuration_close(c);
    return status;
}

void configuration_close(struct configuration *c)
{
    busfile_close(c->bus);
    free(c->faults);
    c->bus = NULL;
    c->faults = NULL;
}
