/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "conformance/profile.h"

#define NAMES_MAX 64

int complain(const struct command *command, const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "tgm%s%s: ", command != NULL ? " " : "", command != NULL ? command->name : "");
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    return EXIT_CALL;
}

static size_t least_of(size_t a, size_t b, size_t c)
{
    const size_t ab = a < b ? a : b;
    return ab < c ? ab : c;
}

/* Edit distance with neighbour swaps counted as two edits; words longer than the table are far
 * away. */
static size_t distance(const char *a, const char *b)
{
    size_t row[64];
    const size_t width = strlen(b);
    if (width + 1 > sizeof row / sizeof *row || strlen(a) > 63)
        return SIZE_MAX;
    for (size_t k = 0; k <= width; k++)
        row[k] = k;
    for (size_t i = 0; a[i] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t k = 0; k < width; k++) {
            const size_t above = row[k + 1];
            row[k + 1] = least_of(above + 1, row[k] + 1, diagonal + (a[i] != b[k]));
            diagonal = above;
        }
    }
    return row[width];
}

const char *nearest(const char *word, const char *const *names, size_t count)
{
    const char *best = NULL;
    size_t best_distance = strlen(word) / 3 + 1;
    for (size_t i = 0; i < count; i++) {
        const size_t d = distance(word, names[i]);
        if (d <= best_distance) {
            best_distance = d - (d > 0);
            best = names[i];
        }
    }
    return best;
}

static void print_help(const struct command *command, const struct option *options)
{
    printf("tgm %s %s\n%s\n\n", command->name, command->usage, command->summary);
    for (const struct option *o = options; o->name != NULL; o++) {
        char left[48];
        snprintf(left, sizeof left, "%s%s%s", o->name, o->value != NULL ? " " : "",
                 o->value != NULL ? o->value : "");
        printf("  %-22s %s\n", left, o->help);
    }
}

static int unknown_option(const struct command *command, const struct option *options,
                          const char *word)
{
    const char *names[NAMES_MAX];
    char all[512] = "";
    size_t count = 0, at = 0;
    for (; options[count].name != NULL && count < NAMES_MAX; count++) {
        names[count] = options[count].name;
        at += (size_t)snprintf(all + at, sizeof all - at, " %s", names[count]);
    }
    const char *close = nearest(word, names, count);
    if (close != NULL)
        return complain(command, "unknown option %s (did you mean %s?)", word, close);
    return complain(command, "unknown option %s; allowed:%s --help", word, all);
}

static bool read_number(const char *text, uint64_t *value, const char **rest)
{
    char *end;
    errno = 0;
    if (!isdigit((unsigned char)text[0]))
        return false;
    *value = strtoull(text, &end, text[0] == '0' && (text[1] == 'x' || text[1] == 'X') ? 16 : 10);
    *rest = end;
    return errno == 0;
}

static bool read_duration(const char *text, uint64_t *ns)
{
    static const struct {
        const char *unit;
        double factor;
    } units[] = { { "s", 1e9 }, { "ms", 1e6 }, { "us", 1e3 }, { "min", 60e9 } };
    char *end;
    if (!isdigit((unsigned char)text[0]))
        return false;
    const double value = strtod(text, &end);
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(end, units[i].unit) == 0 && value * units[i].factor < 1e18) {
            *ns = (uint64_t)(value * units[i].factor + 0.5);
            return true;
        }
    return false;
}

static int store(const struct command *command, const struct option *option, const char *text)
{
    struct option_texts *texts;
    uint64_t number = 0;
    const char *rest = "";
    switch (option->kind) {
    case OPTION_FLAG:
        *(bool *)option->target = true;
        return 0;
    case OPTION_TEXT:
        *(const char **)option->target = text;
        return 0;
    case OPTION_TEXTS:
        texts = option->target;
        if (texts->count == OPTION_TEXTS_MAX)
            return complain(command, "%s is given more than %d times", option->name,
                            OPTION_TEXTS_MAX);
        texts->texts[texts->count++] = text;
        return 0;
    case OPTION_NUMBER:
        if (!read_number(text, &number, &rest) || *rest != '\0')
            return complain(command, "%s needs a number such as 12 or 0x1f, not '%s'", option->name,
                            text);
        if (option->most != 0 && (number < option->least || number > option->most))
            return complain(command, "%s must be %" PRIu64 " to %" PRIu64 ", not %s", option->name,
                            option->least, option->most, text);
        *(uint64_t *)option->target = number;
        return 0;
    case OPTION_DURATION:
        if (!read_duration(text, &number) || number == 0)
            return complain(command, "%s needs a time such as 2s, 500ms or 250us, not '%s'",
                            option->name, text);
        *(uint64_t *)option->target = number;
        return 0;
    }
    return EXIT_CALL;
}

/* Option at argv[*at], with its value there ("--a=v") or behind it. */
static int read_option(const struct command *command, const struct option *options, int argc,
                       char **argv, int *at)
{
    const char *word = argv[*at];
    const char *equals = strchr(word, '=');
    const size_t length = equals != NULL ? (size_t)(equals - word) : strlen(word);
    for (const struct option *o = options; o->name != NULL; o++) {
        if (strlen(o->name) != length || strncmp(o->name, word, length) != 0)
            continue;
        if (o->kind == OPTION_FLAG)
            return equals == NULL ? store(command, o, NULL)
                                  : complain(command, "%s takes no value", o->name);
        if (equals != NULL)
            return store(command, o, equals + 1);
        if (*at + 1 >= argc)
            return complain(command, "%s needs a value: %s %s", o->name, o->name, o->value);
        return store(command, o, argv[++*at]);
    }
    return unknown_option(command, options, word);
}

bool options_read(const struct command *command, const struct option *options, int argc,
                  char **argv, const char **words, int max_words, int *word_count, int *status)
{
    bool over = false;
    *word_count = 0;
    for (int i = 0; i < argc; i++) {
        const char *word = argv[i];
        if (!over && strcmp(word, "--") == 0) {
            over = true;
        } else if (!over && (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)) {
            print_help(command, options);
            *status = EXIT_OK;
            return false;
        } else if (!over && word[0] == '-' && word[1] != '\0') {
            *status = read_option(command, options, argc, argv, &i);
            if (*status != 0)
                return false;
        } else if (*word_count == max_words) {
            *status = complain(command, "unexpected '%s'; usage: tgm %s %s", word, command->name,
                               command->usage);
            return false;
        } else {
            words[(*word_count)++] = word;
        }
    }
    return true;
}

bool patterns_join(const struct command *command, const struct option_texts *patterns,
                   char out[PATTERNS_MAX], const char **joined)
{
    size_t at = 0;
    for (size_t i = 0; i < patterns->count; i++) {
        const int length =
            snprintf(out + at, PATTERNS_MAX - at, "%s%s", i > 0 ? "," : "", patterns->texts[i]);
        if ((size_t)length >= PATTERNS_MAX - at) {
            complain(command, "too many patterns of rules");
            return false;
        }
        at += (size_t)length;
    }
    *joined = patterns->count > 0 ? out : NULL;
    return true;
}

const struct profile *profile_or_complain(const struct command *command, const char *name)
{
    const struct profile *profile = profile_find(name);
    if (profile != NULL)
        return profile;
    char all[256] = "";
    for (size_t i = 0, at = 0; profile_at(i) != NULL; i++)
        at += (size_t)snprintf(all + at, sizeof all - at, " %s", profile_at(i)->name);
    complain(command, "unknown profile '%s'; allowed:%s", name, all);
    return NULL;
}
