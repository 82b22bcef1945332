/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * record.h - what tgm run records and where it goes: registers cycle by cycle or the channels of
 * TG Motion's oscilloscope; a CSV file, a picture, or both.
 *
 * First the command line is read into it, then record_choose() to record_close() in their order.
 */
#ifndef HARNESS_CLI_RECORD_H
#define HARNESS_CLI_RECORD_H

#include "cli/cli.h"
#include "cli/plot.h"
#include "host/experiment.h"

#define RECORD_MAX 64

struct record {
    /* As the command line says it; NULL and 0: not said. */
    const char *registers, *osc, *trigger;
    uint64_t every, pretrigger;
    const char *csv_path, *plot_path;

    /* Of record.c alone. */
    const struct command *command;
    const struct host_config *host;
    struct catalogue_register columns[RECORD_MAX];
    struct recording recording;
    struct host_osc scope;
    const char *names; /* of the columns, with commas */
    bool servos;       /* every servo is recorded: how many there are is not known before */
    size_t shown;      /* of the columns; 0 until the first row */
    struct output csv;
    struct plot *plot;
    uint64_t rows;      /* so far */
    double first, last; /* their times */
    bool failed;        /* the CSV file could not be written */
};

/* Resolves names and finds contradictions; the product stands in `host`, which stays where it is.
 * 0 or EXIT_CALL. */
int record_choose(struct record *record, const struct command *command,
                  const struct host_config *host);
/* For experiment_run(); NULL when nothing is recorded. */
const struct recording *record_recording(const struct record *record);
/* Opens the CSV file. 0 or EXIT_CALL. */
int record_open(struct record *record);
void record_rows(struct record *record, const struct evidence *evidence, const double *rows,
                 size_t row_count);
/* The run is over with `status`: says what the oscilloscope has, puts the files in their places.
 * Returns the status as it is then; a call in vain replaces no file. */
int record_finish(struct record *record, const struct evidence *evidence, int status,
                  const char *module, FILE *screen);
/* In any case, whatever came before. */
void record_close(struct record *record);

#endif
