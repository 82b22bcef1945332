/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Reads configuration files: lines through inih, keys through the table. */
#include "host/config.h"

#include <errno.h>
#include <ini.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "bus/scan.h"

#define FILE_MOST 1048576
#define SECTION   64

/* One file on its way. inih is given line by line, so that it is known which line a key stands in.
 */
struct reading {
    struct config *config;
    const char *text;
    size_t left;
    unsigned line;
    bool open;  /* the line should be a key, and was not taken as one yet */
    bool known; /* keys of the section of now are looked at */
};

/* --- lines --- */

static void section_begins(struct reading *r, const char *line)
{
    char name[SECTION];
    const char *names[CONFIG_KEYS];
    size_t count = 0;
    const size_t length = strcspn(line + 1, "]");
    snprintf(name, sizeof name, "%.*s", (int)(length < SECTION ? length : SECTION - 1), line + 1);
    r->known = true;
    if (line[1 + length] != ']') {
        config_add_problem(r->config, r->line, false, "[%s has no ]", name);
        return;
    }
    for (size_t i = 0; config_key(i) != NULL; i++) {
        if (strcasecmp(config_key(i)->section, name) == 0)
            return;
        if (count == 0 || strcmp(names[count - 1], config_key(i)->section) != 0)
            names[count++] = config_key(i)->section;
    }
    r->known = false;
    const char *close = scan_nearest(name, names, count);
    config_add_problem(r->config, r->line, true, "section [%s] is unknown%s%s%s", name,
                       close != NULL ? " (did you mean [" : "", close != NULL ? close : "",
                       close != NULL ? "]?)" : "; its keys are left out");
}

static void line_ends(struct reading *r)
{
    if (r->open)
        config_add_problem(r->config, r->line, false,
                           "is neither [Section] nor Key=Value nor a comment");
    r->open = false;
}

/* Looks at a line before inih does. False: inih is not to see it. */
static bool line_begins(struct reading *r, const char *line, size_t length, size_t room)
{
    if (memchr(line, '\0', length) != NULL) {
        config_add_problem(r->config, r->line, false, "has a NUL character: this is no text file");
        return false;
    }
    if (length >= room) {
        config_add_problem(r->config, r->line, false, "is longer than %zu characters", room - 1);
        return false;
    }
    r->open = length > 0 && strchr(";#[", line[0]) == NULL;
    return true;
}

/* Blanks at the beginning are taken away: to inih they would mean that the value before goes on. */
static char *next_line(char *out, int room, void *stream)
{
    struct reading *r = stream;
    line_ends(r);
    if (r->left == 0)
        return NULL;
    const char *newline = memchr(r->text, '\n', r->left);
    const size_t whole = newline != NULL ? (size_t)(newline - r->text) + 1 : r->left;
    const char *line = r->text;
    size_t length = whole - (newline != NULL);
    r->line++;
    if (r->line == 1 && length >= 3 && memcmp(line, "\xEF\xBB\xBF", 3) == 0)
        line += 3, length -= 3;
    while (length > 0 && strchr(" \t", line[0]) != NULL && line[0] != '\0')
        line++, length--;
    while (length > 0 && strchr(" \t\r", line[length - 1]) != NULL && line[length - 1] != '\0')
        length--;
    if (!line_begins(r, line, length, (size_t)room - 1))
        length = 0;
    memcpy(out, line, length);
    out[length] = '\n';
    out[length + 1] = '\0';
    if (out[0] == '[') {
        out[length] = '\0';
        section_begins(r, out);
        out[length] = '\n';
    }
    r->text += whole;
    r->left -= whole;
    return out;
}

/* --- keys --- */

/* "Servo[03].Type" against "Servo[n].Type". */
static bool name_fits(const char *pattern, const char *name, unsigned *n)
{
    *n = 0;
    const char *at = strstr(pattern, "[n]");
    if (at == NULL)
        return strcasecmp(pattern, name) == 0;
    const size_t head = (size_t)(at - pattern) + 1;
    if (strncasecmp(pattern, name, head) != 0)
        return false;
    const size_t digits = strspn(name + head, "0123456789");
    if (digits < 1 || digits > 4)
        return false;
    *n = (unsigned)strtoul(name + head, NULL, 10);
    return strcasecmp(at + 2, name + head + digits) == 0;
}

/* How well a row answers to a key, from best to worst. */
enum fit { FIT, OTHER_SECTION, OTHER_PRODUCT, NO_FIT };

static enum fit fit_of(const struct config_key *key, const struct product *product,
                       const char *section, const char *name, unsigned *n)
{
    if (!name_fits(key->name, name, n))
        return NO_FIT;
    const bool here = strcasecmp(key->section, section) == 0;
    if (config_key_is_for(key, product))
        return here ? FIT : OTHER_SECTION;
    return here ? OTHER_PRODUCT : NO_FIT;
}

static enum fit find_key(const struct product *product, const char *section, const char *name,
                         size_t *index, unsigned *n)
{
    enum fit best = NO_FIT;
    for (size_t i = 0; config_key(i) != NULL; i++) {
        unsigned number;
        const enum fit fit = fit_of(config_key(i), product, section, name, &number);
        if (fit < best) {
            best = fit;
            *index = i;
            *n = number;
        }
    }
    return best;
}

static void unknown_key(struct reading *r, const char *section, const char *name)
{
    const char *names[CONFIG_KEYS];
    size_t count = 0;
    for (size_t i = 0; config_key(i) != NULL; i++)
        if (strcasecmp(config_key(i)->section, section) == 0 &&
            config_key_is_for(config_key(i), r->config->product))
            names[count++] = config_key(i)->name;
    const char *close = scan_nearest(name, names, count);
    config_add_problem(r->config, r->line, true, "%s in [%s] is unknown%s%s%s", name, section,
                       close != NULL ? " (did you mean " : "", close != NULL ? close : "",
                       close != NULL ? "?)" : "");
}

static void take_value(struct reading *r, size_t index, unsigned n, const char *name,
                       const char *value)
{
    const struct config_key *key = config_key(index);
    struct config *config = r->config;
    char range[CONFIG_TEXT / 2];
    const unsigned count = config_key_count(key, config->product);
    if (n >= count) {
        config_add_problem(config, r->line, false, "%s in [%s]: %s has 0 to %u", name, key->section,
                           config->product->title, count - 1);
        return;
    }
    if (config->line[index][n] != 0) {
        config_add_problem(config, r->line, false, "%s in [%s] stands in lines %u and %u", name,
                           key->section, config->line[index][n], r->line);
        return;
    }
    config->line[index][n] = r->line;
    if (config_key_take(key, config, n, value))
        return;
    config_key_range(key, config->product, range, sizeof range);
    config_add_problem(config, r->line, false, "%s=%.40s in [%s]: %s takes %s", name, value,
                       key->section, config->product->title, range);
}

static int handle(void *user, const char *section, const char *name, const char *value)
{
    struct reading *r = user;
    char products[CONFIG_TEXT / 2];
    size_t index = 0;
    unsigned n = 0;
    r->open = false;
    if (section[0] == '\0') {
        config_add_problem(r->config, r->line, false, "%s stands before the first [Section]", name);
        return 1;
    }
    if (!r->known)
        return 1;
    switch (find_key(r->config->product, section, name, &index, &n)) {
    case FIT:
        take_value(r, index, n, name, value);
        break;
    case OTHER_SECTION:
        config_add_problem(r->config, r->line, true, "%s in [%s] belongs into [%s]", name, section,
                           config_key(index)->section);
        break;
    case OTHER_PRODUCT:
        config_key_products(config_key(index), products, sizeof products);
        config_add_problem(r->config, r->line, true, "%s in [%s] is a key of %s, not of %s", name,
                           section, products, r->config->product->title);
        break;
    case NO_FIT:
        unknown_key(r, section, name);
        break;
    }
    return 1;
}

/* --- the whole --- */

/* Those of one line stay in the order in which they were found. */
static void sort_by_line(struct config_problem *problems, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        const struct config_problem moving = problems[i];
        size_t k = i;
        for (; k > 0 && problems[k - 1].line > moving.line; k--)
            problems[k] = problems[k - 1];
        problems[k] = moving;
    }
}

void config_parse(struct config *config, const struct product *product, const char *text,
                  size_t length)
{
    struct reading reading = { .config = config, .text = text, .left = length };
    config_defaults(config, product);
    /* What it returns is the line of an error that next_line() has told. */
    ini_parse_stream(next_line, &reading, handle, &reading);
    line_ends(&reading);
    config_check(config);
    sort_by_line(config->problems, config->problem_count);
}

int config_read(struct config *config, const struct product *product, const char *path,
                char why[CONFIG_WHY])
{
    size_t length = 0;
    int error = 0;
    char *text = scan_read_file(path, FILE_MOST, &length, &error, why);
    if (text == NULL)
        return error;
    config_parse(config, product, text, length);
    free(text);
    return 0;
}
