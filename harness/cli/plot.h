/* SPDX-License-Identifier: GPL-2.0-or-later */
/* plot.h - pictures of recordings, drawn by gnuplot. */
#ifndef HARNESS_CLI_PLOT_H
#define HARNESS_CLI_PLOT_H

#include "cli/cli.h"
#include "host/catalogue.h"

/* Is the picture of a kind that can be drawn, and is gnuplot there? Says what is wrong otherwise. 0
 * or EXIT_CALL. To be asked before a long run. */
int plot_possible(const struct command *command, const char *path);

struct plot;

/* For registers with commas between their names; units by the catalogue (NULL: of whichever product
 * knows the names). NULL when there is no memory, or no end of registers. */
struct plot *plot_new(const char *names, const struct catalogue *catalogue);
void plot_free(struct plot *plot);
size_t plot_columns(const struct plot *plot);
/* The time in seconds, and a value for every register. */
void plot_row(struct plot *plot, const double *row);
/* 0 or EXIT_CALL. The picture appears when it is complete. */
int plot_draw(const struct plot *plot, const struct command *command, const char *path,
              const char *title);

#endif
