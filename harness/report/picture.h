/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * picture.h - curves as a picture, in the words of gnuplot.
 *
 * Curves of one unit share a panel; those without a unit share one with their namesakes
 * (SERVO[0].Mode and SERVO[1].Mode). What is only ever 0 or 1 is drawn as the lanes of a logic
 * analyser. All panels have the same time axis.
 */
#ifndef HARNESS_REPORT_PICTURE_H
#define HARNESS_REPORT_PICTURE_H

#include <stdio.h>

#include "report/curves.h"

#define PICTURE_CURVES 64

enum picture_kind { PICTURE_PNG, PICTURE_SVG };

struct picture_curve {
    const char *name; /* "SERVO[0].Position" */
    const char *unit; /* "inc"; "" when it has none */
    bool whole;       /* an integer: changes in steps */
};

struct picture {
    const char *title;
    const struct picture_curve *curves;
    size_t count; /* 1..PICTURE_CURVES */
    const struct curves *data;
};

/* All that gnuplot must be told, data included, so that it draws the picture into the file. */
void picture_script(FILE *gnuplot, const struct picture *picture, enum picture_kind kind,
                    const char *path);

#endif
