/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Recordings as pictures. Gnuplot is told all through a pipe: no script and no data are left
 * behind. */
#include "cli/plot.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "report/picture.h"

struct plot {
    char *names; /* each ends with '\0' */
    struct picture_curve columns[PICTURE_CURVES];
    size_t count;
    struct curves *curves;
};

static bool kind_of(const char *path, enum picture_kind *kind)
{
    const char *dot = strrchr(path, '.');
    *kind = dot != NULL && strcmp(dot, ".svg") == 0 ? PICTURE_SVG : PICTURE_PNG;
    return dot != NULL && (*kind == PICTURE_SVG || strcmp(dot, ".png") == 0);
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
    enum picture_kind kind;
    if (!kind_of(path, &kind))
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

static void describe(struct picture_curve *column, const char *name,
                     const struct catalogue *catalogue)
{
    struct catalogue_register reg;
    *column = (struct picture_curve){ .name = name, .unit = "" };
    if (!resolve(catalogue, name, &reg))
        return;
    if (strcmp(reg.unit, "-") != 0 && strcmp(reg.unit, "?") != 0)
        column->unit = reg.unit;
    column->whole = reg.type != F32 && reg.type != F64;
}

struct plot *plot_new(const char *names, const struct catalogue *catalogue)
{
    struct plot *plot = calloc(1, sizeof *plot);
    if (plot == NULL)
        return NULL;
    plot->names = strdup(names);
    for (char *at = plot->names; at != NULL; plot->count++) {
        char *name = strsep(&at, ",");
        if (plot->count == PICTURE_CURVES)
            goto none;
        describe(&plot->columns[plot->count], name, catalogue);
    }
    plot->curves = plot->count > 0 ? curves_new(plot->count) : NULL;
    if (plot->curves != NULL)
        return plot;
none:
    plot_free(plot);
    return NULL;
}

void plot_free(struct plot *plot)
{
    if (plot == NULL)
        return;
    curves_free(plot->curves);
    free(plot->names);
    free(plot);
}

size_t plot_columns(const struct plot *plot)
{
    return plot->count;
}

void plot_row(struct plot *plot, const double *row)
{
    curves_add(plot->curves, row);
}

/* True when gnuplot took everything and ended well. */
static bool tell_gnuplot(const struct picture *picture, enum picture_kind kind, const char *path)
{
    /* A gnuplot that ends early must not end us. */
    void (*const before)(int) = signal(SIGPIPE, SIG_IGN);
    FILE *gnuplot = popen("exec gnuplot -d", "w");
    bool good = gnuplot != NULL;
    if (good) {
        picture_script(gnuplot, picture, kind, path);
        good = pclose(gnuplot) == 0;
    }
    signal(SIGPIPE, before);
    return good;
}

int plot_draw(const struct plot *plot, const struct command *command, const char *path,
              const char *title)
{
    const struct picture picture = { title, plot->columns, plot->count, plot->curves };
    enum picture_kind kind;
    struct output output;
    int status = plot_possible(command, path);
    if (status != 0)
        return status;
    if (curves_rows(plot->curves) == 0)
        return complain(command, "nothing was recorded: there is nothing to draw in '%s'", path);
    kind_of(path, &kind);
    int r = output_open(&output, path);
    if (r == 0) {
        char file[OUTPUT_FILE];
        output_file(&output, file);
        const bool good = tell_gnuplot(&picture, kind, file);
        r = output_close(&output, good);
        if (!good)
            return complain(command, "gnuplot could not draw '%s'", path);
    }
    return r == 0 ? 0 : complain(command, "cannot write '%s': %s", path, strerror(-r));
}

/* The head names the columns behind the first, which is the time. */
static int read_head(const struct command *command, const char *csv, char *line, struct plot **plot)
{
    line[strcspn(line, "\r\n")] = '\0';
    if (strncmp(line, "time_s,", 7) != 0)
        return complain(command, "%s:1: not a recording of tgm run: expected time_s and registers",
                        csv);
    *plot = plot_new(line + 7, NULL);
    return *plot != NULL
               ? 0
               : complain(command, "%s:1: at most %d registers can be drawn", csv, PICTURE_CURVES);
}

static bool read_row(const char *line, size_t count, double *row)
{
    for (size_t i = 0; i < count; i++) {
        char *end;
        row[i] = strtod(line, &end);
        if (end == line ||
            (i + 1 < count ? *end != ',' : *end != '\0' && strchr("\r\n", *end) == NULL))
            return false;
        line = end + 1;
    }
    return true;
}

static int read_rows(const struct command *command, const char *csv, FILE *file, struct plot **plot)
{
    char *line = NULL;
    size_t size = 0;
    double row[1 + PICTURE_CURVES], before = -INFINITY;
    int status = getline(&line, &size, file) > 0 ? read_head(command, csv, line, plot)
                                                 : complain(command, "'%s' is empty", csv);
    for (unsigned long n = 2; status == 0 && getline(&line, &size, file) > 0; n++) {
        if (!read_row(line, 1 + plot_columns(*plot), row))
            status = complain(command, "%s:%lu: expected %zu numbers with commas between them", csv,
                              n, 1 + plot_columns(*plot));
        else if (!(row[0] >= before && row[0] < INFINITY))
            status = complain(command, "%s:%lu: the time must not go back", csv, n);
        else
            plot_row(*plot, row);
        before = row[0];
    }
    if (status == 0 && ferror(file))
        status = complain(command, "cannot read '%s': %s", csv, strerror(errno));
    free(line);
    return status;
}

int command_plot(const struct command *command, int argc, char **argv)
{
    const char *csv = NULL, *path = NULL, *title = NULL;
    const struct option table[] = {
        { "--to", OPTION_TEXT, "FILE", "the picture: a name that ends in .png or .svg", &path, 0,
          0 },
        { "--title", OPTION_TEXT, "TEXT",
          "what stands over it (default: the name of the recording)", &title, 0, 0 },
        { 0 },
    };
    struct plot *plot = NULL;
    int words, status;
    if (!options_read(command, table, argc, argv, &csv, 1, &words, &status))
        return status;
    if (words == 0 || path == NULL)
        return complain(command, "usage: tgm plot %s", command->usage);
    if ((status = plot_possible(command, path)) != 0)
        return status;
    if (same_file(csv, path))
        return complain(command, "--to '%s' is the recording itself", path);
    FILE *file = fopen(csv, "r");
    if (file == NULL)
        return complain(command, "cannot read '%s': %s", csv, strerror(errno));
    status = read_rows(command, csv, file, &plot);
    fclose(file);
    if (status == 0)
        status = plot_draw(plot, command, path, title != NULL ? title : csv);
    plot_free(plot);
    return status;
}
