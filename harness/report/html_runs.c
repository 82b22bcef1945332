/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Runs: when something happened, as marks in a lane a kind along the time, and in words. */
#include <inttypes.h>

#include "report/html.h"
#include "report/markup.h"

/* Units of the drawing. */
enum { WIDTH = 860, LEFT = 100, RIGHT = 20, LANE = 24, FOOT = 24, MARK = 4, ROWS = 60 };

static const struct {
    const char *lane, *style;
} kinds[TIMELINE_KINDS] = {
    [TIMELINE_STATE] = { "states", "fill-accent" },
    [TIMELINE_FAULT] = { "bus faults", "fill-warn" },
    [TIMELINE_MESSAGE] = { "messages", "fill-weak" },
    [TIMELINE_EXPECTATION] = { "expectations", "fill-bad" },
    [TIMELINE_INCIDENT] = { "incidents", "fill-bad" },
};

static double across(const struct html_axis *axis, double seconds)
{
    const double share = (seconds - axis->from) / (axis->to - axis->from);
    return LEFT + (share < 0 ? 0 : share > 1 ? 1 : share) * (WIDTH - LEFT - RIGHT);
}

static void draw_lane(const struct timeline_report *timeline, enum timeline_kind kind, int y,
                      const struct html_axis *axis, FILE *out)
{
    fprintf(out,
            "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%s</text>"
            "<line class=\"lane\" x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n",
            LEFT - 12, y + 4, kinds[kind].lane, LEFT, WIDTH - RIGHT, y, y);
    for (size_t i = 0; i < timeline->event_count; i++)
        if (timeline->events[i].kind == kind)
            fprintf(out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%d\" r=\"%d\"/>\n",
                    kinds[kind].style, across(axis, timeline->events[i].seconds), y, MARK);
}

static void draw_axis(const struct html_axis *axis, int y, FILE *out)
{
    fprintf(out, "<line class=\"axis\" x1=\"%d\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n", LEFT,
            WIDTH - RIGHT, y, y);
    for (int i = 0; i < HTML_TICKS && axis->first + i * axis->step <= axis->to * 1.000001; i++) {
        const double at = axis->first + i * axis->step;
        fprintf(out,
                "<line class=\"axis\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>"
                "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">",
                across(axis, at), across(axis, at), y, y + 4, across(axis, at), y + 18);
        html_axis_number(axis, at, out);
        fputs(" s</text>\n", out);
    }
}

static bool has_kind(const struct timeline_report *timeline, enum timeline_kind kind)
{
    for (size_t i = 0; i < timeline->event_count; i++)
        if (timeline->events[i].kind == kind)
            return true;
    return false;
}

static void draw(const struct timeline_report *timeline, FILE *out)
{
    struct html_axis axis;
    int lanes = 0, y = LANE / 2;
    html_axis_fit(&axis, 0, timeline->seconds > 0 ? timeline->seconds : 1, 8);
    for (enum timeline_kind kind = 0; kind < TIMELINE_KINDS; kind++)
        lanes += has_kind(timeline, kind);
    fprintf(out, "<svg viewBox=\"0 0 %d %d\">\n", WIDTH, lanes * LANE + FOOT);
    for (enum timeline_kind kind = 0; kind < TIMELINE_KINDS; kind++)
        if (has_kind(timeline, kind)) {
            draw_lane(timeline, kind, y, &axis, out);
            y += LANE;
        }
    draw_axis(&axis, lanes * LANE + 2, out);
    fputs("</svg>\n", out);
}

static void event_row(const struct timeline_event *event, FILE *out)
{
    fprintf(out, "<tr><td class=\"n\">%.4f s</td><td class=\"n weak\">", event->seconds);
    if (event->has_cycle)
        fprintf(out, "cycle %" PRIu64, event->cycle);
    fputs("</td><td class=\"n weak\">", out);
    markup_text(out, event->source);
    fputs("</td><td>", out);
    markup_text(out, event->text);
    if (event->count > 1)
        fprintf(out, " <span class=\"weak\">&#215; %" PRIu64 "</span>", event->count);
    fputs("</td></tr>\n", out);
}

static void run(const struct timeline_report *timeline, FILE *out)
{
    const size_t rows = timeline->event_count < ROWS ? timeline->event_count : ROWS;
    const uint64_t more = timeline->event_count - rows + timeline->dropped;
    fputs("<figure>\n<figcaption><h3>", out);
    markup_text(out, timeline->name);
    fputs("</h3><span class=\"weak\">", out);
    markup_text(out, timeline->about);
    fputs("</span></figcaption>\n", out);
    draw(timeline, out);
    fputs("</figure>\n<table class=\"quiet events\">\n", out);
    for (size_t i = 0; i < rows; i++)
        event_row(&timeline->events[i], out);
    if (more > 0)
        fprintf(out,
                "<tr><td></td><td></td><td></td><td class=\"weak\">and %" PRIu64
                " more</td></tr>\n",
                more);
    fputs("</table>\n", out);
}

/* One as the others: a line is enough. */
static bool quiet(const struct timeline_report *timeline)
{
    return !timeline->in_full && !has_kind(timeline, TIMELINE_FAULT) &&
           !has_kind(timeline, TIMELINE_EXPECTATION) && !has_kind(timeline, TIMELINE_INCIDENT);
}

static const struct timeline_event *first_state(const struct timeline_report *timeline)
{
    for (size_t i = 0; i < timeline->event_count; i++)
        if (timeline->events[i].kind == TIMELINE_STATE)
            return &timeline->events[i];
    return NULL;
}

static uint64_t messages(const struct timeline_report *timeline)
{
    uint64_t count = timeline->dropped;
    for (size_t i = 0; i < timeline->event_count; i++)
        if (timeline->events[i].kind == TIMELINE_MESSAGE)
            count += timeline->events[i].count;
    return count;
}

static void quiet_row(const struct timeline_report *timeline, FILE *out)
{
    fputs("<tr><td class=\"n\">", out);
    markup_text(out, timeline->name);
    fputs("</td><td class=\"weak\">", out);
    markup_text(out, timeline->about);
    fprintf(out, "</td><td class=\"r\">%.3g s</td><td class=\"weak\">", timeline->seconds);
    const struct timeline_event *state = first_state(timeline);
    if (state != NULL) {
        markup_text(out, state->text);
        fprintf(out, " after %.4f s", state->seconds);
    }
    fprintf(out, "</td><td class=\"r weak\">%" PRIu64 " message%s", messages(timeline),
            messages(timeline) == 1 ? "" : "s");
    fputs("</td></tr>\n", out);
}

static void quiet_runs(const struct report *r, FILE *out)
{
    bool any = false;
    for (size_t i = 0; i < r->timeline_count; i++) {
        if (!quiet(&r->timelines[i]))
            continue;
        if (!any)
            fputs("<h3>Without incident</h3>\n<table class=\"quiet\">\n", out);
        any = true;
        quiet_row(&r->timelines[i], out);
    }
    if (any)
        fputs("</table>\n", out);
}

void html_runs(const struct report *r, FILE *out)
{
    if (r->timeline_count == 0)
        return;
    fputs("<h2>Runs</h2>\n", out);
    for (size_t i = 0; i < r->timeline_count; i++)
        if (!quiet(&r->timelines[i]))
            run(&r->timelines[i], out);
    quiet_runs(r, out);
}
