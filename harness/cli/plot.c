/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * Recordings as pictures. Gnuplot reads the CSV file by itself; what it is told goes through a
 * pipe, so no script is left behind. Registers of one unit share a panel; numbers without fractions
 * are drawn as steps.
 */
#include "cli/plot.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { COLUMNS = 64, PANEL_PIXELS = 300, HEAD_PIXELS = 60, WIDTH_PIXELS = 1200, POINTS = 20000 };

struct column {
    char name[160];
    const char *unit; /* "" when it has none */
    bool steps;
};

struct table {
    struct column columns[COLUMNS];
    unsigned count;
    unsigned long rows;
};

static const char *terminal_of(const char *path)
{
    const char *dot = strrchr(path, '.');
    if (dot != NULL && strcmp(dot, ".png") == 0)
        return "pngcairo";
    if (dot != NULL && strcmp(dot, ".svg") == 0)
        return "svg";
    return NULL;
}

static bool on_path(const char *program)
{
    const char *path = getenv("PATH");
    while (path != NULL && *path != '\0') {
        char file[4096];
        const size_t length = strcspn(path, ":");
        if (snprintf(file, sizeof file, "%.*s/%s", (int)length, path, program) < (int)sizeof file &&
            access(file, X_OK) == 0)
            return true;
        path += length + (path[length] == ':');
    }
    return false;
}

int plot_possible(const struct command *command, const char *path)
{
    if (terminal_of(path) == NULL)
        return complain(command, "a picture ends in .png or .svg, not '%s'", path);
    if (!on_path("gnuplot"))
        return complain(command, "gnuplot draws the pictures and is not installed: apt-get install "
                                 "gnuplot-nox");
    return 0;
}

static bool resolve(const struct catalogue *catalogue, const char *name,
                    struct catalogue_register *reg)
{
    static const struct {
        int generation, memory_id;
    } all[] = { { 4, 904 }, { 5, 906 }, { 5, 905 } };
    char why[CATALOGUE_WHY];
    if (catalogue != NULL)
        return catalogue_resolve(catalogue, name, reg, why) == 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (catalogue_resolve(catalogue_find(all[i].generation, all[i].memory_id), name, reg,
                              why) == 0)
            return true;
    return false;
}

static void describe(struct column *column, const struct catalogue *catalogue)
{
    struct catalogue_register reg;
    column->unit = "";
    if (!resolve(catalogue, column->name, &reg))
        return;
    if (strcmp(reg.unit, "-") != 0 && strcmp(reg.unit, "?") != 0)
        column->unit = reg.unit;
    column->steps = reg.type != F32 && reg.type != F64;
}

/* The head names the columns; behind the first, which is the time. */
static int read_head(const struct command *command, const char *csv, char *line,
                     const struct catalogue *catalogue, struct table *table)
{
    line[strcspn(line, "\r\n")] = '\0';
    char *at = strchr(line, ',');
    if (strncmp(line, "time_s,", 7) != 0)
        return complain(command, "%s:1: not a recording of tgm run: expected time_s and registers",
                        csv);
    while (at != NULL && table->count < COLUMNS) {
        struct column *column = &table->columns[table->count++];
        char *name = at + 1;
        at = strchr(name, ',');
        if (at != NULL)
            *at = '\0';
        snprintf(column->name, sizeof column->name, "%s", name);
        describe(column, catalogue);
    }
    return 0;
}

static int read_table(const struct command *command, const char *csv,
                      const struct catalogue *catalogue, struct table *table)
{
    FILE *file = fopen(csv, "r");
    char *line = NULL;
    size_t size = 0;
    if (file == NULL)
        return complain(command, "cannot read '%s': %s", csv, strerror(errno));
    int status = getline(&line, &size, file) > 0 ? read_head(command, csv, line, catalogue, table)
                                                 : complain(command, "'%s' is empty", csv);
    while (status == 0 && getline(&line, &size, file) > 0)
        table->rows++;
    free(line);
    fclose(file);
    if (status == 0 && table->rows == 0)
        status = complain(command, "'%s' has no rows: there is nothing to draw", csv);
    return status;
}

/* In quotes of gnuplot's, in which a quote is doubled. */
static void quoted(FILE *gnuplot, const char *text)
{
    fputc('\'', gnuplot);
    for (; *text != '\0'; text++) {
        if (*text == '\'')
            fputc('\'', gnuplot);
        fputc((unsigned char)*text < 0x20 ? '?' : *text, gnuplot);
    }
    fputc('\'', gnuplot);
}

static bool first_of_unit(const struct table *table, unsigned i)
{
    for (unsigned k = 0; k < i; k++)
        if (strcmp(table->columns[k].unit, table->columns[i].unit) == 0)
            return false;
    return true;
}

static void draw_panel(FILE *gnuplot, const char *csv, const struct table *table, unsigned first)
{
    const unsigned long every = (table->rows + POINTS - 1) / POINTS;
    const char *separator = "plot ";
    fprintf(gnuplot, "set ylabel ");
    quoted(gnuplot, table->columns[first].unit[0] != '\0' ? table->columns[first].unit : "value");
    fprintf(gnuplot, " noenhanced\n");
    for (unsigned i = first; i < table->count; i++) {
        const struct column *column = &table->columns[i];
        if (strcmp(column->unit, table->columns[first].unit) != 0)
            continue;
        fputs(separator, gnuplot);
        quoted(gnuplot, csv);
        fprintf(gnuplot, " every %lu::1 using 1:%u with %s linewidth 1.5 title ", every, i + 2,
                column->steps ? "steps" : "lines");
        quoted(gnuplot, column->name);
        fprintf(gnuplot, " noenhanced");
        separator = ", ";
    }
    fputc('\n', gnuplot);
}

static void draw(FILE *gnuplot, const char *csv, const char *path, const char *title,
                 const struct table *table)
{
    unsigned panels = 0, drawn = 0;
    for (unsigned i = 0; i < table->count; i++)
        panels += first_of_unit(table, i);
    fprintf(gnuplot, "set terminal %s size %d,%u font 'sans,11'\nset output ", terminal_of(path),
            WIDTH_PIXELS, HEAD_PIXELS + panels * PANEL_PIXELS);
    quoted(gnuplot, path);
    fprintf(gnuplot,
            "\nset datafile separator ','\nset grid linecolor rgb '#dddddd'\nset border 3\n"
            "set tics nomirror\nset key outside right top\nset lmargin 14\nset rmargin 34\n"
            "set format y '%%.6g'\n");
    fprintf(gnuplot, "set multiplot layout %u,1 title ", panels);
    quoted(gnuplot, title);
    fprintf(gnuplot, " noenhanced\n");
    for (unsigned i = 0; i < table->count; i++) {
        if (!first_of_unit(table, i))
            continue;
        if (++drawn == panels)
            fprintf(gnuplot, "set xlabel 'time (s)'\n");
        draw_panel(gnuplot, csv, table, i);
    }
    fprintf(gnuplot, "unset multiplot\n");
}

int plot_draw(const struct command *command, const char *csv, const char *path, const char *title,
              const struct catalogue *catalogue)
{
    struct table *table = calloc(1, sizeof *table);
    FILE *gnuplot = NULL;
    if (table == NULL)
        return complain(command, "no memory");
    int status = plot_possible(command, path);
    if (status == 0)
        status = read_table(command, csv, catalogue, table);
    if (status == 0) {
        signal(SIGPIPE, SIG_IGN);
        gnuplot = popen("exec gnuplot", "w");
        if (gnuplot == NULL)
            status = complain(command, "cannot run gnuplot: %s", strerror(errno));
    }
    if (gnuplot != NULL) {
        draw(gnuplot, csv, path, title, table);
        if (pclose(gnuplot) != 0)
            status = complain(command, "gnuplot could not draw '%s'", path);
    }
    free(table);
    return status;
}

int command_plot(const struct command *command, int argc, char **argv)
{
    const char *csv = NULL, *picture = NULL;
    const struct option table[] = {
        { "--to", OPTION_TEXT, "FILE", "the picture: a name that ends in .png or .svg", &picture, 0,
          0 },
        { 0 },
    };
    int words, status;
    if (!options_read(command, table, argc, argv, &csv, 1, &words, &status))
        return status;
    if (words == 0 || picture == NULL)
        return complain(command, "usage: tgm plot %s", command->usage);
    return plot_draw(command, csv, picture, csv, NULL);
}
