/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * html.h - the parts of an HTML report, for html.c alone. Each writes a section, or nothing when
 * there is nothing to say.
 */
#ifndef HARNESS_REPORT_HTML_H
#define HARNESS_REPORT_HTML_H

#include "report/report.h"

/* html_parts.c */
void html_groups(const struct report *report, FILE *out);
void html_failed(const struct report *report, FILE *out);
void html_not_judged(const struct report *report, FILE *out);
void html_waivers(const struct report *report, FILE *out);
void html_rules(const struct report *report, FILE *out);

/* html_bars.c */
struct html_share {
    double share;      /* of the whole bar */
    const char *style; /* class of the style sheet: "fill-good" */
};
void html_bar(const struct html_share *shares, size_t count, FILE *out);
void html_budgets(const struct report *report, FILE *out);
void html_coverage(const struct report *report, FILE *out);

/* html_runs.c */
void html_runs(const struct report *report, FILE *out);

/* html_plots.c */
void html_plots(const struct report *report, FILE *out);

/* html_axis.c: round numbers on an axis, at most HTML_TICKS; the step between them, and what of
 * `from` to `to` it begins at. */
#define HTML_TICKS 12
struct html_axis {
    double from, to; /* what is shown */
    double first, step;
    int decimals;
};
void html_axis_fit(struct html_axis *axis, double from, double to, int about);
/* Writes the number of a tick. */
void html_axis_number(const struct html_axis *axis, double value, FILE *out);

#endif
