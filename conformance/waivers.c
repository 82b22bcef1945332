/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/waivers.h"

#include <ctype.h>
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "conformance/rules.h"

struct reader {
    const char *name;
    unsigned line;
    char *why;
};

static __attribute__((format(printf, 2, 3))) int wrong(const struct reader *r, const char *format,
                                                       ...)
{
    va_list arguments;
    const int at = snprintf(r->why, WAIVERS_WHY, "%.300s:%u: ", r->name, r->line);
    va_start(arguments, format);
    vsnprintf(r->why + at, WAIVERS_WHY - (size_t)at, format, arguments);
    va_end(arguments);
    return -EINVAL;
}

/* A day that there is: YYYY-MM-DD. */
static bool is_day(const char *text)
{
    static const int days[] = { 31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31 };
    static const char shape[] = "dddd-dd-dd";
    for (size_t i = 0; i < sizeof shape; i++)
        if (shape[i] == 'd' ? !isdigit((unsigned char)text[i]) : text[i] != shape[i])
            return false;
    const int year =
        (text[0] - '0') * 1000 + (text[1] - '0') * 100 + (text[2] - '0') * 10 + text[3] - '0';
    const int month = (text[5] - '0') * 10 + text[6] - '0',
              day = (text[8] - '0') * 10 + text[9] - '0';
    const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
    return month >= 1 && month <= 12 && day >= 1 && day <= days[month - 1] &&
           (leap || month != 2 || day < 29);
}

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t");
}

/* The next word, which ends at a blank. False when there is none or it is too long. */
static bool take_word(const char **at, char *out, size_t size)
{
    *at = skip_blanks(*at);
    const size_t length = strcspn(*at, " \t");
    if (length == 0 || length >= size)
        return false;
    memcpy(out, *at, length);
    out[length] = '\0';
    *at += length;
    return true;
}

static bool take_keyword(const char **at, const char *keyword)
{
    char word[16];
    return take_word(at, word, sizeof word) && strcmp(word, keyword) == 0;
}

/* Up to the colon, without blanks at its ends. */
static bool take_owner(const char **at, char *out, size_t size)
{
    *at = skip_blanks(*at);
    size_t length = strcspn(*at, ":");
    if ((*at)[length] != ':')
        return false;
    const char *const behind = *at + length + 1;
    while (length > 0 && isblank((unsigned char)(*at)[length - 1]))
        length--;
    if (length == 0 || length >= size)
        return false;
    memcpy(out, *at, length);
    out[length] = '\0';
    *at = behind;
    return true;
}

static int read_line(struct waivers *waivers, const struct reader *r, const char *line)
{
    struct waiver w;
    const char *at = line;
    if (!take_word(&at, w.rule, sizeof w.rule) || rule_find(w.rule) == NULL)
        return wrong(r, "'%.60s' is no rule; `tgm rules` lists them", w.rule);
    if (!take_keyword(&at, "until") || !take_word(&at, w.expiry, sizeof w.expiry) ||
        !is_day(w.expiry))
        return wrong(r, "'until' and a day (2027-03-31) must follow the rule");
    if (!take_keyword(&at, "by") || !take_owner(&at, w.owner, sizeof w.owner))
        return wrong(r, "'by', who answers for it, and ':' must follow the day");
    at = skip_blanks(at);
    if (*at == '\0')
        return wrong(r, "the reason is missing");
    if (strlen(at) >= sizeof w.reason)
        return wrong(r, "the reason is longer than %zu bytes", sizeof w.reason - 1);
    snprintf(w.reason, sizeof w.reason, "%s", at);
    for (size_t i = 0; i < waivers->count; i++)
        if (strcmp(waivers->list[i].rule, w.rule) == 0)
            return wrong(r, "a second waiver for %s", w.rule);
    if (waivers->count == WAIVERS_MOST)
        return wrong(r, "more than %d waivers", WAIVERS_MOST);
    waivers->list[waivers->count++] = w;
    return 0;
}

int waivers_read(struct waivers *waivers, const char *text, size_t length, const char *name,
                 char why[WAIVERS_WHY])
{
    struct reader r = { .name = name, .why = why };
    waivers->count = 0;
    for (const char *at = text, *end = text + length; at < end;) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        char line[1024];
        size_t size = (size_t)((stop != NULL ? stop : end) - at);
        r.line++;
        if (size >= sizeof line || memchr(at, '\0', size) != NULL)
            return wrong(&r, "this line is too long, or no text");
        memcpy(line, at, size);
        while (size > 0 && isspace((unsigned char)line[size - 1]))
            size--;
        line[size] = '\0';
        const char *begin = skip_blanks(line);
        const int result = *begin == '\0' || *begin == '#' ? 0 : read_line(waivers, &r, begin);
        if (result != 0)
            return result;
        at = stop != NULL ? stop + 1 : end;
    }
    return 0;
}

bool waiver_expired(const struct waiver *waiver, const char *today)
{
    return strcmp(today, waiver->expiry) > 0; /* days so written sort as text */
}
