/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <math.h>

#include "report/html.h"

/* 1, 2 or 5 times a power of ten, near the width. */
static double round_step(double width)
{
    const double power = pow(10, floor(log10(width)));
    const double part = width / power;
    return (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10) * power;
}

void html_axis_fit(struct html_axis *axis, double from, double to, int about)
{
    if (!(to - from > 1e-12 * (fabs(from) + fabs(to)))) { /* one value, or none */
        const double room = from != 0 ? fabs(from) * 0.1 : 1;
        from -= room;
        to += room;
    }
    axis->from = from;
    axis->to = to;
    axis->step = round_step((to - from) / about);
    axis->first = ceil(from / axis->step - 1e-9) * axis->step;
    const double digits = -floor(log10(axis->step) + 1e-9);
    axis->decimals = digits > 0 && digits < 10 ? (int)digits : 0;
}

void html_axis_number(const struct html_axis *axis, double value, FILE *out)
{
    if (fabs(value) < axis->step / 1e6)
        value = 0;
    if (fabs(value) >= 1e9 || axis->step < 1e-6)
        fprintf(out, "%.3g", value);
    else
        fprintf(out, "%.*f", axis->decimals, value);
}
