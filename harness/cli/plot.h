/* SPDX-License-Identifier: GPL-2.0-or-later */
/* plot.h - pictures of recordings, drawn by gnuplot. */
#ifndef HARNESS_CLI_PLOT_H
#define HARNESS_CLI_PLOT_H

#include "cli/cli.h"
#include "host/catalogue.h"

/* Is the picture of a kind that can be drawn, and is gnuplot there? Says what is wrong otherwise. 0
 * or EXIT_CALL. To be asked before a long run. */
int plot_possible(const struct command *command, const char *path);

/* Draws a CSV file as tgm run writes it: one panel a unit, units by the catalogue (NULL: of
 * whichever product knows the names). 0 or EXIT_CALL. */
int plot_draw(const struct command *command, const char *csv, const char *path, const char *title,
              const struct catalogue *catalogue);

#endif
