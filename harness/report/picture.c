/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "report/picture.h"

#include <math.h>
#include <string.h>

/* Pixels. */
enum {
    WIDTH = 1200,
    LEFT = 150, /* at least: labels of the y axis */
    LABEL = 22, /* where what is on the axis stands */
    RIGHT = 30,
    HEAD = 58,
    FOOT = 56,
    GAP = 16,
    LANE = 34,
    KEY_LINE = 19,
    KEY_SAMPLE = 60, /* what stands beside a name in the legend */
    LETTER = 8       /* width, on average and rounded up */
};

/* Told apart by the colour-blind as well, and in print by their darkness. */
static const char *const colours[] = { "#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                       "#000000", "#e69f00", "#7f3c8d", "#56b4e9" };
#define COLOURS (sizeof colours / sizeof *colours)

#define TICKS 6     /* about */
#define MOST  1e300 /* what is beyond is outside of the picture: gnuplot subtracts */

/* How high a panel is when there are so many. */
static const struct {
    unsigned panels, height;
} heights[] = { { 1, 400 }, { 2, 300 }, { 10, 240 }, { PICTURE_CURVES, 120 } };

struct panel {
    const char *key; /* the unit, or the last part of the name */
    bool lanes;
    size_t curves[PICTURE_CURVES], count;
    unsigned top, height; /* of the plotted area */
};

struct layout {
    struct panel panels[PICTURE_CURVES];
    size_t count;
    unsigned left, height;
    double begin, end, scale; /* scale: 1000 when milliseconds are shown */
};

static const char *last_part(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot != NULL ? dot + 1 : name;
}

static bool is_lane(const struct picture *picture, size_t i)
{
    return picture->curves[i].whole && picture->curves[i].unit[0] == '\0' &&
           curves_binary(picture->data, i);
}

static const char *key_of(const struct picture_curve *curve)
{
    return curve->unit[0] != '\0' ? curve->unit : last_part(curve->name);
}

static struct panel *panel_for(const struct picture *picture, struct layout *layout, size_t i)
{
    const bool lane = is_lane(picture, i);
    const char *key = key_of(&picture->curves[i]);
    for (size_t k = 0; k < layout->count; k++) {
        const struct panel *p = &layout->panels[k];
        const bool units = picture->curves[p->curves[0]].unit[0] != '\0';
        if (lane ? p->lanes
                 : !p->lanes && units == (picture->curves[i].unit[0] != '\0') &&
                       strcmp(p->key, key) == 0)
            return &layout->panels[k];
    }
    layout->panels[layout->count] = (struct panel){ .key = key, .lanes = lane };
    return &layout->panels[layout->count++];
}

static unsigned longest_name(const struct picture *picture, const struct panel *panel)
{
    size_t longest = 0;
    for (size_t i = 0; i < panel->count; i++) {
        const size_t length = strlen(picture->curves[panel->curves[i]].name);
        longest = length > longest ? length : longest;
    }
    return (unsigned)longest * LETTER;
}

/* Names side by side above a panel. */
static unsigned key_columns(const struct picture *picture, const struct layout *layout,
                            const struct panel *panel)
{
    const unsigned columns =
        (WIDTH - layout->left - RIGHT) / (longest_name(picture, panel) + KEY_SAMPLE);
    return columns > 0 ? columns : 1;
}

static unsigned key_height(const struct picture *picture, const struct layout *layout,
                           const struct panel *panel)
{
    const unsigned columns = key_columns(picture, layout, panel);
    if (panel->lanes)
        return 0;
    return ((unsigned)panel->count + columns - 1) / columns * KEY_LINE;
}

/* Lanes bear their names where other panels have numbers. */
static unsigned left_margin(const struct picture *picture, const struct layout *layout)
{
    unsigned left = LEFT;
    for (size_t i = 0; i < layout->count; i++) {
        const unsigned names = longest_name(picture, &layout->panels[i]) + 20;
        if (layout->panels[i].lanes && names > left)
            left = names < WIDTH / 2 ? names : WIDTH / 2;
    }
    return left;
}

static unsigned panel_height(const struct layout *layout)
{
    size_t i = 0, high = 0;
    for (size_t k = 0; k < layout->count; k++)
        high += !layout->panels[k].lanes;
    while (heights[i].panels < high)
        i++;
    return heights[i].height;
}

static void lay_out(const struct picture *picture, struct layout *layout)
{
    memset(layout, 0, sizeof *layout);
    for (size_t i = 0; i < picture->count; i++) {
        struct panel *panel = panel_for(picture, layout, i);
        panel->curves[panel->count++] = i;
    }
    layout->left = left_margin(picture, layout);
    unsigned at = HEAD;
    for (size_t i = 0; i < layout->count; i++) {
        struct panel *panel = &layout->panels[i];
        panel->top = at + key_height(picture, layout, panel);
        panel->height = panel->lanes ? (unsigned)panel->count * LANE : panel_height(layout);
        at = panel->top + panel->height + GAP;
    }
    layout->height = at + FOOT;
    layout->begin = curves_begin(picture->data);
    layout->end = curves_end(picture->data);
    layout->scale = layout->end - layout->begin < 0.5 ? 1000 : 1;
    if (layout->end <= layout->begin) {
        layout->begin -= 0.5 / layout->scale;
        layout->end += 0.5 / layout->scale;
    }
}

/* In quotes of gnuplot's, in which a quote is doubled and nothing else has a meaning. */
static void quoted(FILE *gnuplot, const char *text)
{
    fputc('\'', gnuplot);
    for (; *text != '\0'; text++) {
        if (*text == '\'')
            fputc('\'', gnuplot);
        fputc((unsigned char)*text < 0x20 || *text == 0x7f ? '?' : *text, gnuplot);
    }
    fputc('\'', gnuplot);
}

/* A value that stands still needs its first and its last point only. */
struct points {
    FILE *gnuplot;
    double scale, factor, shift;
    double written, time, value; /* the last value written, and the point that waits */
    bool any, waits;
};

static void write_point(struct points *p, double time, double value)
{
    fprintf(p->gnuplot, "%.9g ", time * p->scale);
    if (isnan(value))
        fputs("NaN\n", p->gnuplot);
    else
        fprintf(p->gnuplot, "%.12g\n", value * p->factor + p->shift);
    p->written = value;
    p->any = true;
}

static void take_point(void *argument, double time, double value)
{
    struct points *p = argument;
    if (p->waits && (p->value != p->written || p->value != value)) {
        write_point(p, p->time, p->value);
        p->waits = false;
    }
    if (!p->any) {
        write_point(p, time, value);
        return;
    }
    p->time = time;
    p->value = value;
    p->waits = true;
}

static void write_data(FILE *gnuplot, const struct picture *picture, const struct layout *layout)
{
    for (size_t i = 0; i < layout->count; i++) {
        const struct panel *panel = &layout->panels[i];
        for (size_t k = 0; k < panel->count; k++) {
            struct points points = { .gnuplot = gnuplot, .scale = layout->scale, .factor = 1 };
            if (panel->lanes) {
                points.factor = 0.7;
                points.shift = (double)(panel->count - 1 - k) + 0.15;
            }
            fprintf(gnuplot, "$c%zu << end\n", panel->curves[k]);
            curves_walk(picture->data, panel->curves[k], take_point, &points);
            if (points.waits)
                write_point(&points, points.time, points.value);
            fprintf(gnuplot, "end\n");
        }
    }
}

/* 1, 2 or 5 times a power of ten. */
static double tick_step(double span)
{
    const double rough = span / TICKS;
    const double power = pow(10, floor(log10(rough)));
    const double times = rough / power;
    return power * (times <= 1 ? 1 : times <= 2 ? 2 : times <= 5 ? 5 : 10);
}

/* 1 250 000: thousands apart. */
static void write_number(FILE *gnuplot, double value, double step)
{
    char text[64];
    int decimals = 0;
    while (decimals < 9 && step * pow(10, decimals) < 0.999)
        decimals++;
    if (step >= 1e12 || step < 1e-9) {
        fprintf(gnuplot, "%.9g", value);
        return;
    }
    snprintf(text, sizeof text, "%.*f", decimals, fabs(value) < step / 1000 ? 0 : value);
    const char *at = text;
    if (*at == '-')
        fputc(*at++, gnuplot);
    for (size_t left = strcspn(at, "."); *at != '\0'; at++, left--) {
        fputc(*at, gnuplot);
        if (left > 1 && left < 16 && (left - 1) % 3 == 0)
            fputc(' ', gnuplot);
        if (left == 1) {
            fputs(at + 1, gnuplot);
            break;
        }
    }
}

static void panel_range(const struct picture *picture, const struct panel *panel, double *least,
                        double *greatest)
{
    bool any = false;
    *least = -1;
    *greatest = 1;
    for (size_t k = 0; k < panel->count; k++) {
        double low, high;
        if (!curves_range(picture->data, panel->curves[k], &low, &high))
            continue;
        low = fmax(low, -MOST);
        high = fmin(high, MOST);
        *least = !any || low < *least ? low : *least;
        *greatest = !any || high > *greatest ? high : *greatest;
        any = true;
    }
}

/* A register that stands still lies in the middle. */
static void value_axis(FILE *gnuplot, const struct picture *picture, const struct panel *panel)
{
    double least, greatest;
    panel_range(picture, panel, &least, &greatest);
    double margin = (greatest - least) * 0.04;
    if (margin <= fmax(fabs(least), fabs(greatest)) * 1e-14)
        margin = greatest != 0 ? fabs(greatest) / 2 : 1;
    const double low = least - margin, high = greatest + margin;
    const double step = tick_step(high - low);
    fprintf(gnuplot, "set yrange [%.17g:%.17g]\nset ytics (", low, high);
    const char *separator = "";
    for (double n = ceil(low / step); n * step <= high; n++) {
        const double value = n * step + 0.0; /* no -0 */
        fprintf(gnuplot, "%s'", separator);
        write_number(gnuplot, value, step);
        fprintf(gnuplot, "' %.17g", value);
        separator = ", ";
    }
    fprintf(gnuplot, ")\n");
}

static void lane_axis(FILE *gnuplot, const struct picture *picture, const struct panel *panel)
{
    fprintf(gnuplot, "set yrange [0:%zu]\nset ytics (", panel->count);
    for (size_t k = 0; k < panel->count; k++) {
        fputs(k > 0 ? ", " : "", gnuplot);
        quoted(gnuplot, picture->curves[panel->curves[k]].name);
        fprintf(gnuplot, " %zu.5", panel->count - 1 - k);
    }
    fprintf(gnuplot, ")\n");
}

/* "Position (inc)" when all are one register of several servos, else "inc". Gnuplot's own label of
 * an axis would be left out when wide numbers leave it no room. */
static void axis_label(FILE *gnuplot, const struct picture *picture, const struct panel *panel)
{
    char label[256];
    const char *unit = picture->curves[panel->curves[0]].unit;
    const char *part = last_part(picture->curves[panel->curves[0]].name);
    for (size_t k = 1; k < panel->count; k++)
        if (strcmp(last_part(picture->curves[panel->curves[k]].name), part) != 0)
            part = "";
    snprintf(label, sizeof label, unit[0] == '\0' || part[0] == '\0' ? "%s%s" : "%s (%s)", part,
             unit);
    fputs("set label 3 ", gnuplot);
    quoted(gnuplot, panel->lanes ? "" : label);
    fprintf(gnuplot, " at screen %.6f, graph 0.5 center rotate by 90\n", (double)LABEL / WIDTH);
}

/* Set-points lie wide under what follows them, so that both are seen. */
static bool is_set_point(const struct picture *picture, const struct panel *panel, size_t k)
{
    return panel->count > 1 && !panel->lanes &&
           strncmp(last_part(picture->curves[panel->curves[k]].name), "Write", 5) == 0;
}

/* "SERVO[0]." of both */
static bool same_group(const struct picture *picture, const struct panel *panel, size_t a, size_t b)
{
    const char *x = picture->curves[panel->curves[a]].name;
    const char *y = picture->curves[panel->curves[b]].name;
    const size_t length = (size_t)(last_part(x) - x);
    return length == (size_t)(last_part(y) - y) && strncmp(x, y, length) == 0;
}

/* A set-point has the colour of the first that may follow it. */
static size_t colour_of(const struct picture *picture, const struct panel *panel, size_t k)
{
    if (is_set_point(picture, panel, k))
        for (size_t i = 0; i < panel->count; i++)
            if (!is_set_point(picture, panel, i) && same_group(picture, panel, i, k))
                return colour_of(picture, panel, i);
    size_t colour = 0;
    const bool set_point = is_set_point(picture, panel, k);
    for (size_t i = 0; i < panel->count; i++)
        if (is_set_point(picture, panel, i) ? set_point && i < k : set_point || i < k)
            colour++;
    return colour;
}

static void draw_curve(FILE *gnuplot, const struct picture *picture, const struct panel *panel,
                       size_t k, const char *separator)
{
    const struct picture_curve *curve = &picture->curves[panel->curves[k]];
    const bool wide = is_set_point(picture, panel, k);
    const size_t colour = colour_of(picture, panel, k);
    double least, greatest;
    fputs(separator, gnuplot);
    if (curves_range(picture->data, panel->curves[k], &least, &greatest))
        fprintf(gnuplot, "$c%zu using 1:2", panel->curves[k]);
    else
        fputs("NaN", gnuplot);
    fprintf(gnuplot, " with %s linewidth %s dashtype %zu linecolor rgb '%s%s' ",
            curves_rows(picture->data) == 1 ? "points pointtype 7"
            : curve->whole                  ? "steps"
                                            : "lines",
            wide ? "6" : "1.6", panel->lanes ? 1 : 1 + colour / COLOURS, wide ? "#a0" : "#",
            colours[colour % COLOURS] + 1);
    if (panel->lanes) {
        fputs("notitle", gnuplot);
    } else {
        fputs("title ", gnuplot);
        quoted(gnuplot, curve->name);
    }
}

static void draw_curves(FILE *gnuplot, const struct picture *picture, const struct panel *panel)
{
    const char *separator = "plot ";
    for (int wide = 1; wide >= 0; wide--)
        for (size_t k = 0; k < panel->count; k++)
            if (is_set_point(picture, panel, k) == wide) {
                draw_curve(gnuplot, picture, panel, k, separator);
                separator = ", \\\n    ";
            }
    fputc('\n', gnuplot);
}

static void draw_panel(FILE *gnuplot, const struct picture *picture, const struct layout *layout,
                       size_t i)
{
    const struct panel *panel = &layout->panels[i];
    const double height = layout->height, top = 1 - panel->top / height;
    fprintf(gnuplot, "set tmargin at screen %.6f\nset bmargin at screen %.6f\n", top,
            1 - (panel->top + panel->height) / height);
    fprintf(gnuplot, "set key at screen %.6f,%.6f left bottom horizontal maxcols %u\n",
            (double)layout->left / WIDTH, top + 3 / height, key_columns(picture, layout, panel));
    if (panel->lanes)
        lane_axis(gnuplot, picture, panel);
    else
        value_axis(gnuplot, picture, panel);
    axis_label(gnuplot, picture, panel);
    if (i + 1 == layout->count)
        fprintf(gnuplot, "set format x '%%g'\nset xlabel 'time (%s)'\n",
                layout->scale == 1 ? "s" : "ms");
    draw_curves(gnuplot, picture, panel);
}

static void write_terminal(FILE *gnuplot, const struct layout *layout, enum picture_kind kind,
                           const char *path)
{
    if (kind == PICTURE_PNG)
        fprintf(gnuplot, "set terminal pngcairo noenhanced size %d,%u font 'sans,11'\n", WIDTH,
                layout->height);
    else
        fprintf(
            gnuplot,
            "set terminal svg noenhanced size %d,%u dynamic font 'sans,14' background '#ffffff'\n",
            WIDTH, layout->height);
    /* A name that begins with | would be a program to gnuplot. */
    char name[4096];
    snprintf(name, sizeof name, "%s%s", path[0] == '/' ? "" : "./", path);
    fputs("set output ", gnuplot);
    quoted(gnuplot, name);
    fputc('\n', gnuplot);
}

/* Over everything: the title and, in grey, what of the time is shown. */
static void write_title(FILE *gnuplot, const struct picture *picture, const struct layout *layout)
{
    char span[128];
    const double begin = curves_begin(picture->data), end = curves_end(picture->data);
    snprintf(span, sizeof span, "%.9g %s to %.9g %s, %llu sample%s", begin * layout->scale,
             layout->scale == 1 ? "s" : "ms", end * layout->scale, layout->scale == 1 ? "s" : "ms",
             (unsigned long long)curves_rows(picture->data),
             curves_rows(picture->data) == 1 ? "" : "s");
    fputs("set label 1 ", gnuplot);
    quoted(gnuplot, picture->title);
    fprintf(gnuplot, " at screen %.6f,%.6f left font ',14'\nset label 2 ",
            (double)layout->left / WIDTH, 1 - 18.0 / layout->height);
    quoted(gnuplot, span);
    fprintf(gnuplot, " at screen %.6f,%.6f left textcolor rgb '#606060'\n",
            (double)layout->left / WIDTH, 1 - 40.0 / layout->height);
}

void picture_script(FILE *gnuplot, const struct picture *picture, enum picture_kind kind,
                    const char *path)
{
    struct layout layout;
    lay_out(picture, &layout);
    write_data(gnuplot, picture, &layout);
    write_terminal(gnuplot, &layout, kind, path);
    fprintf(gnuplot,
            "set multiplot\nset lmargin at screen %.6f\nset rmargin at screen %.6f\n"
            "set border 3 linecolor rgb '#404040'\nset tics nomirror out scale 0.6\n"
            "set grid xtics ytics linetype 1 linecolor rgb '#e4e4e4' linewidth 0.8\n"
            "set key Left reverse samplen 2\nset xrange [%.12g:%.12g]\nset format x ''\n",
            (double)layout.left / WIDTH, 1 - (double)RIGHT / WIDTH, layout.begin * layout.scale,
            layout.end * layout.scale);
    /* Where the oscilloscope triggered, if there is something before it. */
    if (layout.begin < 0 && layout.end > 0)
        fprintf(gnuplot, "set arrow 1 from first 0, graph 0 to first 0, graph 1 nohead dashtype 2 "
                         "linecolor rgb '#808080'\n");
    write_title(gnuplot, picture, &layout);
    for (size_t i = 0; i < layout.count; i++) {
        draw_panel(gnuplot, picture, &layout, i);
        fputs("unset label\n", gnuplot);
    }
    fputs("unset multiplot\nunset output\n", gnuplot);
}
