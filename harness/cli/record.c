/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/record.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scope.h"
#include "host/osc.h"

#define SERVO_NAMES 48 /* what a servo's name of every_servo() takes at most */

/* The shortest decimal that reads back as the same number, so that equal runs give equal files. */
static void print_number(FILE *stream, double value)
{
    char text[32];
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value || isnan(value))
            break;
    }
    fputs(text, stream);
}

static const struct catalogue *catalogue_of(const struct record *record)
{
    const struct product *product = record->host->product;
    return catalogue_find(product->generation, (int)product->memory_id);
}

/* The first rows are here, or there are none: now it is known which registers are there. */
static void begin_rows(struct record *record, const struct evidence *evidence)
{
    static char names[RECORD_MAX * SERVO_NAMES];
    if (record->shown > 0)
        return;
    record->shown = record->recording.count;
    if (record->servos) {
        const size_t servos = evidence->servo_count > 0 ? evidence->servo_count : 1;
        record->shown = servos < record->shown / 2 ? 2 * servos : record->shown;
        snprintf(names, sizeof names, "%s", record->names);
        char *end = names;
        for (size_t i = 0; i < record->shown; i++)
            end += strcspn(end, ",") + 1;
        end[-1] = '\0';
        record->names = names;
    }
    if (record->csv.stream != NULL)
        fprintf(record->csv.stream, "time_s,%s\n", record->names);
    if (record->plot_path != NULL)
        record->plot = plot_new(record->names, catalogue_of(record));
}

static void write_row(struct record *record, const double *row)
{
    fprintf(record->csv.stream, "%.6f", row[0]);
    for (size_t k = 1; k <= record->shown; k++) {
        fputc(',', record->csv.stream);
        print_number(record->csv.stream, row[k]);
    }
    fputc('\n', record->csv.stream);
}

void record_rows(struct record *record, const struct evidence *evidence, const double *rows,
                 size_t row_count)
{
    begin_rows(record, evidence);
    if (record->rows == 0)
        record->first = rows[0];
    record->rows += row_count;
    for (; row_count > 0; row_count--, rows += 1 + record->recording.count) {
        record->last = rows[0];
        if (record->csv.stream != NULL)
            write_row(record, rows);
        if (record->plot != NULL)
            plot_row(record->plot, rows);
    }
    if (record->csv.stream != NULL && ferror(record->csv.stream))
        record->failed = true;
}

/* "SERVO[0].Position,SERVO[0].WritePosition" */
static int read_registers(struct record *record, const char *option, const char *list)
{
    const struct product *product = record->host->product;
    const struct catalogue *catalogue = catalogue_of(record);
    const size_t most = strcmp(option, "--osc") == 0 ? OSC_CHANNELS : RECORD_MAX;
    char why[CATALOGUE_WHY];
    record->names = list;
    if (catalogue == NULL)
        return complain(record->command, "%s: no register names for %s", option, product->title);
    if (list[0] == '\0' || list[strlen(list) - 1] == ',')
        return complain(record->command, "%s needs register names with commas between them",
                        option);
    while (*list != '\0') {
        char name[128];
        const size_t length = strcspn(list, ",");
        if (record->recording.count == most)
            return complain(record->command, "%s takes at most %zu registers", option, most);
        if (length == 0 || length >= sizeof name)
            return complain(record->command,
                            "%s needs register names with commas between them, not '%s'", option,
                            list);
        memcpy(name, list, length);
        name[length] = '\0';
        if (catalogue_resolve(catalogue, name, &record->columns[record->recording.count], why) != 0)
            return complain(record->command, "%s: %s", option, why);
        if (!host_has_register(record->host, &record->columns[record->recording.count]))
            return complain(record->command, "%s: %s is past the end of %s on %s", option, name,
                            record->columns[record->recording.count].memory->name, product->title);
        record->recording.count++;
        list += length + (list[length] == ',');
    }
    record->recording.registers = record->columns;
    record->recording.every = 1;
    return 0;
}

/* "SERVO[0].WritePosition,SERVO[0].Position,SERVO[1]...": all that there may be. */
static const char *every_servo(const struct product *product)
{
    static char names[RECORD_MAX * SERVO_NAMES];
    for (unsigned i = 0, at = 0; i < product->max_servo && i < RECORD_MAX / 2; i++)
        at += (unsigned)snprintf(names + at, sizeof names - at,
                                 "%sSERVO[%u].WritePosition,SERVO[%u].Position", i > 0 ? "," : "",
                                 i, i);
    return names;
}

static int read_osc(struct record *record)
{
    record->scope = (struct host_osc){ .channels = record->columns,
                                       .count = record->recording.count,
                                       .every = record->every > 0 ? (uint32_t)record->every : 1,
                                       .pretrigger = (uint32_t)record->pretrigger };
    record->recording.osc = &record->scope;
    if (record->trigger == NULL)
        return 0;
    const int status =
        scope_read_trigger(record->command, catalogue_of(record), record->trigger, &record->scope);
    if (status == 0 && !host_has_register(record->host, &record->scope.trigger))
        return complain(record->command, "--osc-trigger: '%s' is past the end of %s on %s",
                        record->trigger, record->scope.trigger.memory->name,
                        record->host->product->title);
    return status;
}

int record_choose(struct record *record, const struct command *command,
                  const struct host_config *host)
{
    const char *names = record->osc != NULL ? record->osc : record->registers;
    int status;
    record->command = command;
    record->host = host;
    if (record->osc != NULL && record->registers != NULL)
        return complain(command, "--osc and --record exclude each other");
    if (record->osc == NULL && (record->trigger || record->every || record->pretrigger))
        return complain(command, "--osc-trigger, --osc-pretrigger and --osc-every belong to --osc");
    record->servos = names == NULL && record->plot_path != NULL;
    if (record->servos)
        names = every_servo(record->host->product);
    if ((names == NULL) != (record->csv_path == NULL && record->plot_path == NULL))
        return complain(command,
                        "%s and --csv or --plot go together: which registers, and where to",
                        record->osc != NULL ? "--osc" : "--record");
    if (names == NULL)
        return 0;
    if (record->plot_path != NULL && (status = plot_possible(command, record->plot_path)) != 0)
        return status;
    status = read_registers(record, record->osc != NULL ? "--osc" : "--record", names);
    return status == 0 && record->osc != NULL ? read_osc(record) : status;
}

/* What TG Motion's oscilloscope has recorded; a trigger that never came is no fault of anybody. */
static void tell_osc(const struct record *record, FILE *screen)
{
    if (record->recording.osc == NULL)
        return;
    if (record->rows == 0)
        fprintf(screen, "  oscilloscope: %s\n",
                record->scope.triggered ? "the trigger did not come; nothing was recorded"
                                        : "nothing was recorded");
    else
        fprintf(screen, "  oscilloscope: %" PRIu64 " samples, %.6g s to %.6g s%s\n", record->rows,
                record->first, record->last, record->scope.triggered ? " of the trigger" : "");
}

static int draw_plot(const struct record *record, const char *module)
{
    char title[512];
    const struct product *product = record->host->product;
    if (record->plot == NULL)
        return complain(record->command, "no memory for the picture");
    snprintf(title, sizeof title, "%s on %s, Cycle_Time %u us", module, product->title,
             record->host->cycle_us);
    return plot_draw(record->plot, record->command, record->plot_path, title);
}

int record_open(struct record *record)
{
    const int r = record->csv_path != NULL ? output_open(&record->csv, record->csv_path) : 0;
    return r == 0
               ? 0
               : complain(record->command, "cannot write '%s': %s", record->csv_path, strerror(-r));
}

/* A module that ended before the first sample has been told of: no picture is its smallest
 * trouble. */
static int finish_plot(const struct record *record, const struct evidence *evidence, int status,
                       const char *module)
{
    if (record->plot_path == NULL || status == EXIT_CALL ||
        (status == EXIT_MODULE && record->rows == 0))
        return status;
    if (record->servos && record->rows > 0 && evidence->servo_count == 0)
        return complain(record->command, "there is no servo to draw; --record says what else");
    return draw_plot(record, module) != 0 ? EXIT_CALL : status;
}

int record_finish(struct record *record, const struct evidence *evidence, int status,
                  const char *module, FILE *screen)
{
    if (record->recording.count == 0)
        return status;
    begin_rows(record, evidence);
    if (status != EXIT_CALL)
        tell_osc(record, screen);
    if (record->csv.stream != NULL) {
        const int r = output_close(&record->csv, status != EXIT_CALL);
        if (r != 0 || record->failed)
            status = complain(record->command, "cannot write '%s': %s", record->csv_path,
                              r != 0 ? strerror(-r) : "write error");
    }
    return finish_plot(record, evidence, status, module);
}

const struct recording *record_recording(const struct record *record)
{
    return record->recording.count > 0 ? &record->recording : NULL;
}

void record_close(struct record *record)
{
    output_close(&record->csv, false);
    plot_free(record->plot);
    record->plot = NULL;
}
