/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE /* memrchr() */

#include "conformance/expected.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define INDENT 2
#define REASON "not judged: "

/* The next line, without its end. False, and an empty one: there is none. */
static bool next_line(struct expected *text, struct expected *line)
{
    *line = (struct expected){ "", 0 };
    if (text->left == 0)
        return false;
    const char *end = memchr(text->at, '\n', text->left);
    *line = (struct expected){ text->at, end != NULL ? (size_t)(end - text->at) : text->left };
    const size_t used = line->left + (end != NULL);
    *text = (struct expected){ text->at + used, text->left - used };
    return true;
}

static bool is_indented(struct expected line)
{
    return line.left > INDENT && memcmp(line.at, "  ", INDENT) == 0;
}

bool expected_find(struct expected text, const char *module, struct expected *out)
{
    struct expected line, rest;
    while (next_line(&text, &line))
        if (line.left == strlen(module) && memcmp(line.at, module, line.left) == 0)
            break;
    if (line.left == 0)
        return false;
    for (rest = text; next_line(&rest, &line) && is_indented(line);)
        ;
    *out = (struct expected){ text.at, (size_t)((line.left > 0 ? line.at : rest.at) - text.at) };
    return true;
}

/* A star takes as little as it can; of several only the last may have to take more. */
static bool fits(struct expected pattern, struct expected text)
{
    size_t p = 0, t = 0, star = SIZE_MAX, taken = 0;
    while (t < text.left) {
        if (p < pattern.left && pattern.at[p] == '*') {
            star = p++;
            taken = t;
        } else if (p < pattern.left && pattern.at[p] == text.at[t]) {
            p++;
            t++;
        } else if (star != SIZE_MAX) {
            p = star + 1;
            t = ++taken;
        } else {
            return false;
        }
    }
    while (p < pattern.left && pattern.at[p] == '*')
        p++;
    return p == pattern.left;
}

static struct expected whole(const char *text)
{
    return (struct expected){ text, strlen(text) };
}

bool expected_fits(const char *pattern, const char *text)
{
    return fits(whole(pattern), whole(text));
}

/* The next line about a finding, or about what was not judged, without what it begins with. */
static bool next_of(struct expected *text, bool reasons, struct expected *line)
{
    while (next_line(text, line)) {
        if (!is_indented(*line))
            continue;
        *line = (struct expected){ line->at + INDENT, line->left - INDENT };
        const bool reason =
            line->left > strlen(REASON) && memcmp(line->at, REASON, strlen(REASON)) == 0;
        if (reason != reasons)
            continue;
        if (reason)
            *line = (struct expected){ line->at + strlen(REASON), line->left - strlen(REASON) };
        return true;
    }
    return false;
}

bool expected_findings(struct expected expected, const char *findings, char why[EXPECTED_WHY])
{
    struct expected found = whole(findings), wanted, line;
    for (;;) {
        const bool more = next_of(&expected, false, &wanted), other = next_line(&found, &line);
        if (!more && !other)
            return true;
        if (more && other && fits(wanted, line))
            continue;
        snprintf(why, EXPECTED_WHY, "expected \"%.*s\", found \"%.*s\"", (int)wanted.left,
                 wanted.at, (int)line.left, line.at);
        return false;
    }
}

/* "RULE RULE RULE" */
static bool is_listed(struct expected list, const char *rule)
{
    const size_t length = strlen(rule);
    while (list.left > 0) {
        const char *end = memchr(list.at, ' ', list.left);
        const size_t size = end != NULL ? (size_t)(end - list.at) : list.left;
        if (size == length && memcmp(list.at, rule, size) == 0)
            return true;
        list =
            (struct expected){ list.at + size + (end != NULL), list.left - size - (end != NULL) };
    }
    return false;
}

bool expected_reason(struct expected expected, const char *rule, const char *reason,
                     char why[EXPECTED_WHY])
{
    struct expected wanted = { "", 0 };
    for (struct expected line; wanted.left == 0 && next_of(&expected, true, &line);) {
        const char *mark = memrchr(line.at, '|', line.left);
        if (mark == NULL)
            continue;
        const size_t size = (size_t)(mark - line.at);
        if (is_listed((struct expected){ mark + 1, line.left - size - 1 }, rule))
            wanted = (struct expected){ line.at, size };
    }
    if (fits(wanted, whole(reason)))
        return true;
    snprintf(why, EXPECTED_WHY, "%s not judged because \"%.200s\", expected \"%.*s\"", rule, reason,
             (int)wanted.left, wanted.at);
    return false;
}
