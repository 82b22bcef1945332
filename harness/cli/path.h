/* SPDX-License-Identifier: GPL-2.0-or-later */
/* path.h - the option --path: a path for an interpolator from a file. */
#ifndef HARNESS_CLI_PATH_H
#define HARNESS_CLI_PATH_H

#include "cli/cli.h"
#include "host/interp_path.h"

/* 0 and a path to be closed, or the exit status after a complaint. */
int path_open(struct interp_path *path, const struct command *command, const char *file);
/* Also of a path that is all zeros. */
void path_close(struct interp_path *path);

#endif
