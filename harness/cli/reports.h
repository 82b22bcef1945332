/* SPDX-License-Identifier: GPL-2.0-or-later */
/* reports.h - --json, --junit, --sarif and --html: one report, in several files. */
#ifndef HARNESS_CLI_REPORTS_H
#define HARNESS_CLI_REPORTS_H

#include "cli/cli.h"
#include "report/report.h"

enum report_form { REPORT_JSON, REPORT_JUNIT, REPORT_SARIF, REPORT_HTML, REPORT_FORMS };

struct report_files {
    const char *paths[REPORT_FORMS]; /* as given, "-" is standard output; NULL: not asked for */
    struct output outputs[REPORT_FORMS];
};

/* Opens them all, before anything takes time: 0, or EXIT_CALL with the reason said and none open. A
 * report does not go where the module is, nor two to one place. */
int report_files_open(struct report_files *files, const struct command *command,
                      const char *module);

/* One of them goes to standard output: nothing else may. */
bool report_files_take_stdout(const struct report_files *files);

/* Writes and closes them all: 0, or EXIT_CALL with the reason said. */
int report_files_write(struct report_files *files, const struct command *command,
                       const struct report *report);

/* Closes them without leaving a file. */
void report_files_drop(struct report_files *files);

#endif
