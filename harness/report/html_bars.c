/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <inttypes.h>
#include <string.h>

#include "report/html.h"
#include "report/markup.h"

/* Units of the drawing. */
enum { BAR_WIDTH = 300, BAR_HEIGHT = 8, BAR_LEAST = 2 };

/* The limit stands so far along a bar: what is beyond it is seen to be. */
#define LIMIT 0.8

static double bar_part(double at, double share, const char *style, FILE *out)
{
    double width = share * BAR_WIDTH;
    if (share > 0 && width < BAR_LEAST)
        width = BAR_LEAST;
    if (at + width > BAR_WIDTH)
        width = BAR_WIDTH - at;
    if (width > 0)
        fprintf(out, "<rect class=\"%s\" x=\"%.1f\" width=\"%.1f\" height=\"%d\"/>", style, at,
                width, BAR_HEIGHT);
    return at + width;
}

static void bar_begin(FILE *out)
{
    fprintf(out, "<svg viewBox=\"0 -2 %d %d\"><rect class=\"track\" width=\"%d\" height=\"%d\"/>",
            BAR_WIDTH, BAR_HEIGHT + 4, BAR_WIDTH, BAR_HEIGHT);
}

void html_bar(const struct html_share *shares, size_t count, FILE *out)
{
    double at = 0;
    bar_begin(out);
    for (size_t i = 0; i < count; i++)
        at = bar_part(at, shares[i].share, shares[i].style, out);
    fputs("</svg>", out);
}

static void limit_bar(double share, FILE *out)
{
    bar_begin(out);
    bar_part(0, share * LIMIT,
             share > 1     ? "fill-bad"
             : share > 0.8 ? "fill-warn"
                           : "fill-good",
             out);
    fprintf(out, "<line class=\"limit\" x1=\"%.1f\" x2=\"%.1f\" y1=\"-2\" y2=\"%d\"/></svg>",
            LIMIT * BAR_WIDTH, LIMIT * BAR_WIDTH, BAR_HEIGHT + 2);
}

/* 25.0 us, 640 bytes, 12.0 KiB */
static void amount(FILE *out, double value, const char *unit)
{
    if (strcmp(unit, "bytes") == 0 && value >= 10240) {
        fprintf(out, "%.1f KiB", value / 1024);
        return;
    }
    fprintf(out, "%.*f ",
            strcmp(unit, "bytes") == 0 ? 0
            : value < 0.095            ? 3
            : value < 0.95             ? 2
                                       : 1,
            value);
    markup_text(out, unit);
}

static void worst_call(const struct budget_report *budget, FILE *out)
{
    const char *comma = "";
    if (budget->has_cycle) {
        fprintf(out, "cycle %" PRIu64, budget->cycle);
        comma = ", ";
    }
    if (budget->cycle_us != 0) {
        fprintf(out, "%sCycle_Time %" PRIu32 " us", comma, budget->cycle_us);
        comma = ", ";
    }
    if (budget->instructions != 0)
        fprintf(out, "%s%" PRIu64 " instructions", comma, budget->instructions);
}

static void budget_row(const struct budget_report *budget, FILE *out)
{
    fputs("<tr><td class=\"n\">", out);
    markup_text(out, budget->name);
    if (budget->reason[0] != '\0') {
        fputs("</td><td class=\"open\" colspan=\"5\">", out);
        markup_text(out, budget->reason);
        fputs("</td></tr>\n", out);
        return;
    }
    fputs("</td><td class=\"bar\">", out);
    if (budget->allowed > 0)
        limit_bar(budget_share(budget), out);
    fputs("</td><td class=\"r\">", out);
    amount(out, budget->worst, budget->unit);
    fputs("</td><td class=\"r weak\">", out);
    if (budget->allowed > 0)
        amount(out, budget->allowed, budget->unit);
    fprintf(out, "</td><td class=\"r %s\">", budget_share(budget) > 1 ? "bad" : "");
    if (budget->allowed > 0)
        fprintf(out, "%.1f %%", budget_share(budget) * 100);
    fputs("</td><td class=\"weak\">", out);
    worst_call(budget, out);
    fputs("</td></tr>\n", out);
}

void html_budgets(const struct report *r, FILE *out)
{
    if (r->budget_count == 0)
        return;
    fputs(
        "<h2>Budgets</h2>\n<p class=\"weak\">The worst call of all runs. The line across a bar is "
        "the limit.</p>\n<table>\n<tr><th></th><th></th><th class=\"r\">worst</th><th "
        "class=\"r\">allowed</th><th class=\"r\">share</th><th>worst call</th></tr>\n",
        out);
    for (size_t i = 0; i < r->budget_count; i++)
        budget_row(&r->budgets[i], out);
    fputs("</table>\n", out);
}

static void coverage_row(const struct coverage_report *coverage, FILE *out)
{
    const double share =
        coverage->total != 0 ? (double)coverage->executed / (double)coverage->total : 0;
    const struct html_share shares[] = { { share, "fill-accent" } };
    fputs("<tr><td>", out);
    markup_text(out, coverage->name);
    fputs("</td><td class=\"bar\">", out);
    html_bar(shares, 1, out);
    fprintf(out,
            "</td><td class=\"r\">%.0f %%</td><td class=\"r weak\">%" PRIu64 " of %" PRIu64 " bytes"
            "</td><td class=\"weak missed\">",
            share * 100, coverage->executed, coverage->total);
    if (coverage->missed[0] != '\0') {
        fputs("never executed: <code>", out);
        markup_text(out, coverage->missed);
        fputs("</code>", out);
    }
    fputs("</td></tr>\n", out);
}

void html_coverage(const struct report *r, FILE *out)
{
    if (r->coverage_count == 0 && r->coverage_reason == NULL)
        return;
    fputs("<h2>Coverage</h2>\n", out);
    if (r->coverage_count == 0) {
        fputs("<p class=\"open\">", out);
        markup_text(out, r->coverage_reason);
        fputs("</p>\n", out);
        return;
    }
    fputs("<p class=\"weak\">Code that was executed in at least one run. What never ran, nobody "
          "has judged.</p>\n<table>\n",
          out);
    for (size_t i = 0; i < r->coverage_count; i++)
        coverage_row(&r->coverage[i], out);
    fputs("</table>\n", out);
}
