/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/interp_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WORDS   64 /* of a line */
#define PER_MIN (1.0 / 60)

struct word {
    const char *at;
    size_t length;
    unsigned column; /* from 1 */
};

struct reader {
    struct interp_path *path;
    const char *name;
    unsigned line;
    struct word words[WORDS + 1]; /* the last one is the end of the line, empty */
    size_t count, next;
    struct interp_part part;   /* being read */
    bool given['Z' - 'A' + 1]; /* letters of this line */
    double feed;               /* what is said once holds on: mm/s; 0: not yet said */
    uint32_t tool, correction;
    char *why;
};

/* --- words --- */

static bool fail_at(struct reader *r, size_t n, const char *what, const char *expected)
{
    const struct word *word = &r->words[n];
    char text[40], unexpected[64];
    size_t length = word->length < sizeof text ? word->length : sizeof text - 1;
    for (size_t i = 0; i < length; i++)
        text[i] = word->at[i] > ' ' && word->at[i] < 0x7f ? word->at[i] : '?';
    text[length] = '\0';
    if (n < r->count)
        snprintf(unexpected, sizeof unexpected, "unexpected '%s'", text);
    else
        snprintf(unexpected, sizeof unexpected, "the line ends here");
    snprintf(r->why, INTERP_FILE_WHY, "%.200s:%u:%u: %s%s%s", r->name, r->line, word->column,
             what != NULL ? what : unexpected, expected[0] != '\0' ? "; expected " : "", expected);
    return false;
}

static bool fail(struct reader *r, const char *expected)
{
    return fail_at(r, r->next, NULL, expected);
}

static bool split(struct reader *r, const char *text, size_t length)
{
    size_t at = 0;
    r->count = r->next = 0;
    for (;;) {
        struct word *word = &r->words[r->count];
        while (at < length && (text[at] == ' ' || text[at] == '\t' || text[at] == '\r'))
            at++;
        *word = (struct word){ text + at, 0, (unsigned)at + 1 };
        if (at == length || text[at] == '#')
            return true;
        if (r->count == WORDS)
            return fail_at(r, r->count, "too many words", "the end of the line");
        while (at < length && strchr(" \t\r#", text[at]) == NULL)
            at++;
        word->length = (size_t)(text + at - word->at);
        r->count++;
    }
}

static bool is(const struct reader *r, const char *word)
{
    return r->words[r->next].length == strlen(word) &&
           memcmp(r->words[r->next].at, word, strlen(word)) == 0;
}

static bool take(struct reader *r, const char *word)
{
    const bool there = is(r, word);
    r->next += there;
    return there;
}

/* [-+]digits[.digits], and nothing else: strtod would take "nan" and "0x1p3", too. */
static bool decimal(const char *text, size_t length, double *value)
{
    char copy[40];
    size_t at = length > 0 && (text[0] == '-' || text[0] == '+'), digits = 0, points = 0;
    if (length >= sizeof copy)
        return false;
    for (; at < length; at++) {
        digits += text[at] >= '0' && text[at] <= '9';
        points += text[at] == '.';
        copy[at] = text[at];
        if ((text[at] < '0' || text[at] > '9') && text[at] != '.')
            return false;
    }
    memcpy(copy, text, length);
    copy[length] = '\0';
    *value = strtod(copy, NULL);
    return digits > 0 && points <= 1;
}

static bool number(struct reader *r, double *value)
{
    const struct word *word = &r->words[r->next];
    if (!decimal(word->at, word->length, value))
        return fail(r, "a number");
    if (*value > INTERP_LARGEST || *value < -INTERP_LARGEST)
        return fail_at(r, r->next, "the number is too large", "");
    r->next++;
    return true;
}

static bool positive(struct reader *r, double *value)
{
    if (!number(r, value))
        return false;
    return *value >= INTERP_LEAST || fail_at(r, r->next - 1, NULL, "a number above 0");
}

static bool whole(struct reader *r, double least, double most, double *value)
{
    if (!number(r, value))
        return false;
    return (*value >= least && *value <= most && *value == (double)(int64_t)*value) ||
           fail_at(r, r->next - 1, NULL, "a whole number in its range");
}

static bool duration(struct reader *r, double *value)
{
    static const struct {
        const char *name;
        double divisor;
    } units[] = { { "ns", 1e9 }, { "us", 1e6 }, { "ms", 1e3 }, { "s", 1 } };
    const struct word *word = &r->words[r->next];
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        const size_t unit = strlen(units[i].name);
        if (word->length > unit &&
            memcmp(word->at + word->length - unit, units[i].name, unit) == 0 &&
            decimal(word->at, word->length - unit, value) && *value >= 0) {
            *value /= units[i].divisor;
            r->next++;
            return true;
        }
    }
    return fail(r, "a time such as 100ms");
}

/* --- pieces of statements --- */

static const char axis_letters[] = "XYZCBUVWAO";

static bool at_end(const struct reader *r)
{
    return r->next == r->count;
}

/* A single capital letter that has not been here yet; '\0': fails. */
static char letter(struct reader *r, const char *allowed, const char *expected)
{
    const struct word *word = &r->words[r->next];
    const char c = word->length == 1 ? word->at[0] : '\0';
    if (c == '\0' || strchr(allowed, c) == NULL) {
        fail(r, expected);
        return '\0';
    }
    if (r->given[c - 'A']) {
        fail_at(r, r->next, "given twice", "");
        return '\0';
    }
    r->given[c - 'A'] = true;
    r->next++;
    return c;
}

/* "X 10 Y 20 F 6000" to the end of the line. */
static bool places(struct reader *r, const char *allowed, const char *expected, double *place)
{
    while (!at_end(r)) {
        double value;
        const char c = letter(r, allowed, expected);
        if (c == '\0' || (c == 'F' ? !positive(r, &value) : !number(r, &value)))
            return false;
        r->part.letters[c - 'A'] = value;
        if (c == 'F')
            r->feed = value * PER_MIN;
        else
            place[strchr(axis_letters, c) - axis_letters] = value;
    }
    return true;
}

static bool add(struct reader *r)
{
    const char *what;
    r->part.feed = r->feed;
    r->part.tool = r->tool;
    r->part.correction = r->correction;
    r->part.line = r->line;
    if (r->feed == 0 && r->part.kind >= INTERP_LINE && r->part.kind <= INTERP_CCW)
        return fail_at(r, r->count, "no feed so far", "F and a number");
    if (interp_path_add(r->path, &r->part, &what) != 0)
        return fail_at(r, 0, what, "");
    return true;
}

static bool early(struct reader *r)
{
    return r->path->count == 0 || fail_at(r, 0, "this belongs in front of the first part", "");
}

/* --- statements --- */

static bool read_line(struct reader *r)
{
    r->part.kind = INTERP_LINE;
    return places(r, "XYZCBUVWAOF", "an axis or F", r->part.end) && add(r);
}

static bool read_rapid(struct reader *r)
{
    r->part.kind = INTERP_RAPID;
    return places(r, axis_letters, "an axis", r->part.end) && add(r);
}

static bool read_plane(struct reader *r)
{
    static const struct {
        const char *name;
        enum interp_plane plane;
    } planes[] = { { "XY", INTERP_XY }, { "XZ", INTERP_XZ }, { "YZ", INTERP_YZ } };
    for (size_t i = 0; i < sizeof planes / sizeof *planes; i++)
        if (take(r, planes[i].name)) {
            r->part.plane = planes[i].plane;
            return true;
        }
    return fail(r, "XY, XZ or YZ");
}

static bool two_numbers(struct reader *r, double value[2])
{
    return number(r, &value[0]) && number(r, &value[1]);
}

/* "to 10 0 cw": the end in the plane, and which way round. */
static bool read_arc_end(struct reader *r, unsigned axes[2])
{
    double end[2];
    if (!take(r, "to"))
        return fail(r, "'to'");
    if (!two_numbers(r, end))
        return false;
    for (int i = 0; i < 2; i++)
        r->part.end[axes[i]] = end[i];
    if (!is(r, "cw") && !is(r, "ccw"))
        return fail(r, "'cw' or 'ccw'");
    r->part.kind = is(r, "cw") ? INTERP_CW : INTERP_CCW;
    r->next++;
    return true;
}

static bool read_arc(struct reader *r)
{
    unsigned axes[2];
    double radius = 0;
    if (!read_plane(r))
        return false;
    interp_plane_axes(r->part.plane, axes);
    const size_t form = r->next;
    const bool centred = take(r, "centre");
    if (!centred && !take(r, "radius"))
        return fail(r, "'centre' or 'radius'");
    if (centred ? !two_numbers(r, r->part.centre) : !number(r, &radius))
        return false;
    const double *from = interp_path_end(r->path);
    if (!read_arc_end(r, axes))
        return false;
    const double start[2] = { from[axes[0]], from[axes[1]] };
    const double end[2] = { r->part.end[axes[0]], r->part.end[axes[1]] };
    if (!centred &&
        !interp_arc_centre(start, end, radius, r->part.kind == INTERP_CW, r->part.centre))
        return fail_at(r, form, "there is no such arc", "a radius that reaches from start to end");
    for (int i = 0; i < 2; i++) {
        r->given[axis_letters[axes[i]] - 'A'] = true;
        r->part.letters[axis_letters[axes[i]] - 'A'] = end[i];
    }
    return places(r, "XYZCBUVWAOF", "an axis or F", r->part.end) && add(r);
}

static bool read_m(struct reader *r)
{
    double code;
    r->part.kind = INTERP_M;
    if (!whole(r, 0, INTERP_LARGEST, &code))
        return false;
    r->part.code = (int32_t)code;
    while (!at_end(r)) {
        double value;
        /* G, M, N and P are reserved. */
        const char c = letter(r, "ABCDEFHIJKLOQRSTUVWXYZ", "a letter but G, M, N, P");
        if (c == '\0' || !number(r, &value))
            return false;
        r->part.letters[c - 'A'] = value;
    }
    return add(r);
}

static bool read_dwell(struct reader *r)
{
    r->part.kind = INTERP_DWELL;
    return duration(r, &r->part.dwell) && add(r);
}

static bool read_wait(struct reader *r)
{
    double value;
    r->part.kind = INTERP_WAIT;
    if (!take(r, "external"))
        return fail(r, "'external'");
    if (!whole(r, -INTERP_LARGEST, INTERP_LARGEST, &value))
        return false;
    r->part.external = (int32_t)value;
    return add(r);
}

static bool read_tool(struct reader *r)
{
    double value;
    if (!whole(r, 0, INTERP_LARGEST, &value))
        return false;
    r->tool = (uint32_t)value;
    return true;
}

static bool read_correction(struct reader *r)
{
    static const struct {
        const char *name;
        uint32_t value;
    } sides[] = { { "left", 41 }, { "right", 42 }, { "off", 0 } };
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++)
        if (take(r, sides[i].name)) {
            r->correction = sides[i].value;
            return true;
        }
    return fail(r, "'left', 'right' or 'off'");
}

static bool read_from(struct reader *r)
{
    return early(r) && places(r, axis_letters, "an axis", r->path->start);
}

static bool read_acceleration(struct reader *r)
{
    struct interp_limits *limits = &r->path->limits;
    if (!early(r) || !positive(r, &limits->acceleration))
        return false;
    limits->deceleration = limits->acceleration;
    if (limits->emergency < limits->deceleration)
        limits->emergency = limits->deceleration;
    return true;
}

static bool read_deceleration(struct reader *r)
{
    struct interp_limits *limits = &r->path->limits;
    if (!early(r) || !positive(r, &limits->deceleration))
        return false;
    if (limits->emergency < limits->deceleration)
        limits->emergency = limits->deceleration;
    return true;
}

static bool read_emergency(struct reader *r)
{
    struct interp_limits *limits = &r->path->limits;
    if (!early(r) || !positive(r, &limits->emergency))
        return false;
    return limits->emergency >= limits->deceleration ||
           fail_at(r, 1, "the emergency ramp is slower than the normal one", "");
}

static bool read_rapid_speed(struct reader *r)
{
    if (!early(r) || !positive(r, &r->path->limits.rapid))
        return false;
    r->path->limits.rapid *= PER_MIN;
    return r->path->limits.rapid >= INTERP_LEAST || fail_at(r, 1, "that is no speed", "");
}

static bool read_corner(struct reader *r)
{
    double degrees;
    if (!early(r) || !number(r, &degrees))
        return false;
    r->path->limits.corner = degrees / 180;
    return (degrees >= 0 && degrees <= 180) || fail_at(r, 1, NULL, "0 to 180 degrees");
}

/* "backlash 2 X 20 Y 15": step, and what each axis has. */
static bool read_backlash(struct reader *r)
{
    struct interp_limits *limits = &r->path->limits;
    return early(r) && positive(r, &limits->backlash_step) &&
           places(r, axis_letters, "an axis", limits->backlash);
}

static const struct statement {
    const char *name;
    bool (*read)(struct reader *r);
} statements[] = {
    { "line", read_line },
    { "rapid", read_rapid },
    { "arc", read_arc },
    { "m", read_m },
    { "dwell", read_dwell },
    { "wait", read_wait },
    { "tool", read_tool },
    { "correction", read_correction },
    { "from", read_from },
    { "acceleration", read_acceleration },
    { "deceleration", read_deceleration },
    { "emergency", read_emergency },
    { "rapid-speed", read_rapid_speed },
    { "corner", read_corner },
    { "backlash", read_backlash },
};

static bool read_statement(struct reader *r)
{
    char expected[INTERP_FILE_WHY / 2] = "";
    memset(r->given, 0, sizeof r->given);
    r->part = (struct interp_part){ .kind = INTERP_M };
    memcpy(r->part.end, interp_path_end(r->path), sizeof r->part.end);
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++) {
        const size_t at = strlen(expected);
        if (take(r, statements[i].name))
            return statements[i].read(r) && (at_end(r) || fail(r, "the end of the line"));
        snprintf(expected + at, sizeof expected - at, "%s%s", i > 0 ? ", " : "",
                 statements[i].name);
    }
    return fail(r, expected);
}

size_t interp_file_parts(const char *text, size_t length)
{
    size_t lines = 1;
    for (size_t i = 0; i < length; i++)
        lines += text[i] == '\n';
    return lines;
}

int interp_file_read(struct interp_path *path, const char *text, size_t length, const char *name,
                     char why[INTERP_FILE_WHY])
{
    struct reader r = { .path = path, .name = name, .why = why };
    const char *end = text + length;
    why[0] = '\0';
    while (text < end) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        const size_t size = (size_t)((newline != NULL ? newline : end) - text);
        r.line++;
        if (!split(&r, text, size) || (r.count > 0 && !read_statement(&r)))
            return -EINVAL;
        text += size + (newline != NULL);
    }
    return 0;
}
