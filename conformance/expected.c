/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/expected.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INDENT "  "
#define MOST   ((size_t)1 << 20)

/* A text and how much of it is left. */
struct text {
    const char *at;
    size_t left;
};

/* The next line, without its end. False: there is none. */
static bool next_line(struct text *text, struct text *line)
{
    if (text->left == 0)
        return false;
    const char *end = memchr(text->at, '\n', text->left);
    *line = (struct text){ text->at, end != NULL ? (size_t)(end - text->at) : text->left };
    const size_t used = line->left + (end != NULL);
    *text = (struct text){ text->at + used, text->left - used };
    return true;
}

/* One star after the other takes as little as it can; only the last may have to take more. */
static bool fits(struct text pattern, struct text text)
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

bool expected_fits(const char *pattern, const char *text)
{
    return fits((struct text){ pattern, strlen(pattern) }, (struct text){ text, strlen(text) });
}

static bool is_name(struct text line)
{
    return line.left > 0 && line.at[0] != ' ' && line.at[0] != '#';
}

/* Moves to behind the line that is the module's name. */
static bool find_module(struct text *text, const char *module)
{
    for (struct text line; next_line(text, &line);)
        if (is_name(line) && line.left == strlen(module) && memcmp(line.at, module, line.left) == 0)
            return true;
    return false;
}

/* The next line of the same module. False, and an empty one: there is none. */
static bool next_expected(struct text *text, struct text *line)
{
    struct text rest = *text;
    const size_t indent = strlen(INDENT);
    if (!next_line(&rest, line) || line->left < indent || memcmp(line->at, INDENT, indent) != 0) {
        *line = (struct text){ "", 0 };
        return false;
    }
    *text = rest;
    *line = (struct text){ line->at + indent, line->left - indent };
    return true;
}

static bool compare(struct text expected, struct text found, char why[EXPECTED_WHY])
{
    for (struct text wanted, line;;) {
        const bool more = next_expected(&expected, &wanted), other = next_line(&found, &line);
        if (!more && !other)
            return true;
        if (more && other && fits(wanted, line))
            continue;
        snprintf(why, EXPECTED_WHY, "expected \"%.*s\", found \"%.*s\"", more ? (int)wanted.left : 0,
                 wanted.at, other ? (int)line.left : 0, other ? line.at : "");
        return false;
    }
}

bool expected_are(const char *path, const char *module, const char *findings,
                  char why[EXPECTED_WHY])
{
    FILE *file = fopen(path, "rb");
    char *bytes = file != NULL ? malloc(MOST) : NULL;
    bool same = true;
    if (bytes != NULL) {
        struct text text = { bytes, fread(bytes, 1, MOST, file) };
        if (find_module(&text, module)) {
            same = compare(text, (struct text){ findings, strlen(findings) }, why);
        } else {
            snprintf(why, EXPECTED_WHY, "%s does not say what is expected of it", path);
            same = false;
        }
    }
    free(bytes);
    if (file != NULL)
        fclose(file);
    return same;
}
