/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Curves as line drawings: curves of one unit share a panel, each is a line in
 * a band between least and greatest value of every bucket, so that no peak of a single cycle is
 * lost. */
#include <math.h>
#include <string.h>

#include "report/html.h"
#include "report/markup.h"

/* Units of the drawing. */
enum { WIDTH = 860, LEFT = 84, RIGHT = 20, HEAD = 26, HEIGHT = 170, FOOT = 26, LETTER = 7 };

/* Told apart by the colour-blind as well, and in print by their darkness. */
static const char *const colours[] = { "#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                       "#000000", "#e69f00", "#7f3c8d", "#56b4e9" };
#define COLOURS (sizeof colours / sizeof *colours)

struct panel {
    const struct plot_report *plot;
    const char *unit;
    struct html_axis x, y;
};

static double x_of(const struct panel *panel, size_t bucket)
{
    return LEFT + ((double)bucket + 0.5) / (double)panel->plot->buckets * (WIDTH - LEFT - RIGHT);
}

static double y_of(const struct panel *panel, double value)
{
    return HEAD + HEIGHT - (value - panel->y.from) / (panel->y.to - panel->y.from) * HEIGHT;
}

static bool in_panel(const struct panel *panel, const struct plot_curve *curve)
{
    return strcmp(curve->unit, panel->unit) == 0;
}

static void fit(struct panel *panel)
{
    double least = INFINITY, greatest = -INFINITY;
    for (size_t i = 0; i < panel->plot->curve_count; i++) {
        const struct plot_curve *curve = &panel->plot->curves[i];
        for (size_t k = 0; in_panel(panel, curve) && k < panel->plot->buckets; k++) {
            least = fmin(least, curve->least[k]);
            greatest = fmax(greatest, curve->greatest[k]);
        }
    }
    if (!isfinite(least) || !isfinite(greatest))
        least = greatest = 0;
    const double room = (greatest - least) * 0.05;
    html_axis_fit(&panel->x, panel->plot->begin, panel->plot->end, 8);
    html_axis_fit(&panel->y, least - room, greatest + room, 4);
}

static void draw_grid(const struct panel *panel, FILE *out)
{
    const double bottom = HEAD + HEIGHT;
    for (int i = 0; i < HTML_TICKS && panel->y.first + i * panel->y.step <= panel->y.to; i++) {
        const double value = panel->y.first + i * panel->y.step, y = y_of(panel, value);
        fprintf(out,
                "<line class=\"grid\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>"
                "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">",
                LEFT, WIDTH - RIGHT, y, y, LEFT - 10, y + 4);
        html_axis_number(&panel->y, value, out);
        fputs("</text>\n", out);
    }
    fprintf(out, "<line class=\"axis\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>\n", LEFT,
            WIDTH - RIGHT, bottom, bottom);
    for (int i = 0; i < HTML_TICKS && panel->x.first + i * panel->x.step <= panel->x.to * 1.000001;
         i++) {
        const double value = panel->x.first + i * panel->x.step;
        const double x =
            LEFT + (value - panel->x.from) / (panel->x.to - panel->x.from) * (WIDTH - LEFT - RIGHT);
        fprintf(out,
                "<line class=\"axis\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>"
                "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">",
                x, x, bottom, bottom + 4, x, bottom + 18);
        html_axis_number(&panel->x, value, out);
        fputs(" s</text>\n", out);
    }
}

/* The buckets from `from` on that have values: a closed band, there by the greatest, back by the
 * least. */
static size_t draw_band(const struct panel *panel, const struct plot_curve *curve, size_t from,
                        const char *colour, FILE *out)
{
    size_t end = from;
    while (end < panel->plot->buckets && isfinite(curve->least[end]) &&
           isfinite(curve->greatest[end]))
        end++;
    fputs("<path d=\"M", out);
    for (size_t i = from; i < end; i++)
        fprintf(out, "%.1f %.1f ", x_of(panel, i), y_of(panel, curve->greatest[i]));
    for (size_t i = end; i-- > from;)
        fprintf(out, "%.1f %.1f ", x_of(panel, i), y_of(panel, curve->least[i]));
    fprintf(out, "Z\" fill=\"%s\" fill-opacity=\"0.3\"/>\n<path d=\"", colour);
    for (size_t i = from; i < end; i++)
        fprintf(out, "%c%.1f %.1f", i == from ? 'M' : 'L', x_of(panel, i),
                y_of(panel, (curve->least[i] + curve->greatest[i]) / 2));
    fprintf(out,
            "\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.5\" stroke-linejoin=\"round\"/>\n",
            colour);
    return end;
}

static void draw_curve(const struct panel *panel, const struct plot_curve *curve,
                       const char *colour, FILE *out)
{
    for (size_t i = 0; i < panel->plot->buckets;)
        if (isfinite(curve->least[i]) && isfinite(curve->greatest[i]))
            i = draw_band(panel, curve, i, colour, out);
        else
            i++;
}

static size_t draw_key(const struct plot_curve *curve, size_t x, const char *colour, FILE *out)
{
    fprintf(out,
            "<rect x=\"%zu\" y=\"8\" width=\"14\" height=\"3\" fill=\"%s\"/>"
            "<text class=\"name\" x=\"%zu\" y=\"14\">",
            x, colour, x + 20);
    markup_text(out, curve->name);
    fputs("</text>\n", out);
    return x + 44 + strlen(curve->name) * LETTER;
}

static void draw_panel(const struct plot_report *plot, const char *unit, FILE *out)
{
    struct panel panel = { .plot = plot, .unit = unit };
    size_t key = LEFT, colour = 0;
    fit(&panel);
    fprintf(out, "<svg viewBox=\"0 0 %d %d\">\n", WIDTH, HEAD + HEIGHT + FOOT);
    draw_grid(&panel, out);
    for (size_t i = 0; i < plot->curve_count; i++) {
        const struct plot_curve *curve = &plot->curves[i];
        if (!in_panel(&panel, curve))
            continue;
        draw_curve(&panel, curve, colours[colour % COLOURS], out);
        key = draw_key(curve, key, colours[colour++ % COLOURS], out);
    }
    fprintf(out, "<text x=\"%d\" y=\"14\" text-anchor=\"end\">", LEFT - 10);
    markup_text(out, unit);
    fputs("</text>\n</svg>\n", out);
}

static bool first_of_unit(const struct plot_report *plot, size_t index)
{
    for (size_t i = 0; i < index; i++)
        if (strcmp(plot->curves[i].unit, plot->curves[index].unit) == 0)
            return false;
    return true;
}

void html_plots(const struct report *r, FILE *out)
{
    if (r->plot_count > 0)
        fputs("<h2>What the machine did</h2>\n", out);
    for (size_t i = 0; i < r->plot_count; i++) {
        const struct plot_report *plot = &r->plots[i];
        fputs("<figure class=\"plots\">\n<figcaption class=\"weak\">", out);
        markup_text(out, plot->title);
        fputs("</figcaption>\n", out);
        for (size_t k = 0; k < plot->curve_count; k++)
            if (first_of_unit(plot, k))
                draw_panel(plot, plot->curves[k].unit, out);
        fputs("</figure>\n", out);
    }
}
