/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A sketch as curves with names and units. What never moved is left out. */
#include "conformance/chronicle.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *format, *unit; /* %u is the axis */
} axis_curves[SKETCH_OF_AXIS] = {
    [SKETCH_POSITION] = { "SERVO[%u].Position", "inc" },
    [SKETCH_WRITE_POSITION] = { "SERVO[%u].WritePosition", "inc" },
    [SKETCH_LAG] = { "SERVO[%u] commanded - measured", "inc behind" },
};

/* Something of it differs from something else of it. */
static bool moves(const struct sketch *sketch, unsigned curve)
{
    float least = INFINITY, greatest = -INFINITY;
    for (uint32_t i = 0; i < sketch->used; i++) {
        least = fminf(least, sketch->least[curve][i]);
        greatest = fmaxf(greatest, sketch->greatest[curve][i]);
    }
    return least < greatest;
}

static int add_curve(struct plot_report *plot, const struct sketch *sketch, unsigned curve,
                     const char *name, const char *unit)
{
    struct plot_curve *out = &plot->curves[plot->curve_count];
    snprintf(out->name, sizeof out->name, "%s", name);
    snprintf(out->unit, sizeof out->unit, "%s", unit);
    out->least = calloc(plot->buckets, sizeof *out->least);
    out->greatest = calloc(plot->buckets, sizeof *out->greatest);
    plot->curve_count++;
    if (out->least == NULL || out->greatest == NULL)
        return -ENOMEM;
    for (size_t i = 0; i < plot->buckets; i++) {
        out->least[i] = (double)sketch->least[curve][i];
        out->greatest[i] = (double)sketch->greatest[curve][i];
    }
    return 0;
}

static int add_curves(struct plot_report *plot, const struct sketch *sketch)
{
    int r = 0;
    char name[48];
    for (unsigned kind = 0; kind < SKETCH_OF_AXIS; kind++)
        for (unsigned axis = 0; axis < SKETCH_AXES && r == 0; axis++) {
            const unsigned curve = sketch_of_axis(axis, (enum sketch_curve)kind);
            if (!moves(sketch, curve))
                continue;
            snprintf(name, sizeof name, axis_curves[kind].format, axis);
            r = add_curve(plot, sketch, curve, name, axis_curves[kind].unit);
        }
    if (r == 0 && moves(sketch, SKETCH_INSTRUCTIONS))
        r = add_curve(plot, sketch, SKETCH_INSTRUCTIONS, "Program_04", "instructions");
    return r;
}

int chronicle_plot(struct plot_report *plot, const char *name, const struct experiment *experiment,
                   const struct sketch *sketch)
{
    const double cycle = experiment->host.cycle_us * 1e-6;
    *plot = (struct plot_report){ .buckets = sketch->used,
                                  .end = (double)sketch->used * sketch->per_bucket * cycle,
                                  .curves = calloc(SKETCH_CURVES, sizeof *plot->curves) };
    snprintf(plot->title, sizeof plot->title, "%s, Cycle_Time %u us", name,
             experiment->host.cycle_us);
    const int r = plot->curves != NULL ? add_curves(plot, sketch) : -ENOMEM;
    if (r != 0 || plot->curve_count == 0)
        chronicle_plot_free(plot);
    return r;
}

void chronicle_plot_free(struct plot_report *plot)
{
    for (size_t i = 0; i < plot->curve_count; i++) {
        free(plot->curves[i].least);
        free(plot->curves[i].greatest);
    }
    free(plot->curves);
    *plot = (struct plot_report){ .curve_count = 0 };
}
