/* SPDX-License-Identifier: GPL-2.0-or-later */
/* path.h - the option --path: a path for an interpolator from a file. */
#ifndef HARNESS_CLI_PATH_H
#define HARNESS_CLI_PATH_H

#include "cli/cli.h"
#include "host/interp_path.h"

/* 0 and the path, or the exit status after a complaint. `path->parts` is allocated; path_close()
 * frees it, also after a failure. */
int path_open(struct interp_path *path, const struct command *command, const char *file);
void path_close(struct interp_path *path);

#endif
