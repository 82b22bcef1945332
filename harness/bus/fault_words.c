/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/fault_words.h"

#include <stdio.h>
#include <string.h>

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

bool fault_line_split(struct fault_line *line, const struct segment *segment, const char *text,
                      size_t length)
{
    size_t at = 0;

    memset(line, 0, sizeof *line);
    line->segment = segment;
    for (;;) {
        struct fault_word *word = &line->words[line->count];

        while (at < length && is_space(text[at]))
            at++;
        *word = (struct fault_word){ text + at, 0, (unsigned)at + 1 };
        if (at == length || text[at] == '#')
            return true;
        if (line->count == FAULT_WORDS)
            return fault_fail(line, line->count, "more words than any statement has",
                              "the end of the line");
        while (at < length && !is_space(text[at]) && text[at] != '#')
            at++;
        word->length = (size_t)(text + at - word->at);
        line->count++;
    }
}

const char *fault_word_text(const struct fault_line *line, size_t n, char text[48])
{
    const struct fault_word *word = &line->words[n];
    size_t length = word->length < 40 ? word->length : 40;

    for (size_t i = 0; i < length; i++)
        text[i] = word->at[i] > ' ' && word->at[i] < 0x7f ? word->at[i] : '?';
    strcpy(text + length, length < word->length ? "..." : "");
    return text;
}

bool fault_word_is(const struct fault_line *line, size_t n, const char *word)
{
    size_t length = strlen(word);

    return line->words[n].length == length && memcmp(line->words[n].at, word, length) == 0;
}

static void expect(struct fault_line *line, const char *expected)
{
    for (unsigned i = 0; i < line->expected_count; i++) {
        if (strcmp(line->expected[i], expected) == 0)
            return;
    }
    if (line->expected_count < FAULT_EXPECTED)
        snprintf(line->expected[line->expected_count++], sizeof line->expected[0], "%s", expected);
}

void fault_start_over(struct fault_line *line, size_t n)
{
    line->failed_at = n;
    line->expected_count = 0;
    line->what[0] = '\0';
}

bool fault_fail(struct fault_line *line, size_t n, const char *what, const char *expected)
{
    if (n < line->failed_at)
        return false;
    if (n > line->failed_at)
        fault_start_over(line, n);
    if (what && !line->what[0])
        snprintf(line->what, sizeof line->what, "%s", what);
    expect(line, expected);
    return false;
}

bool fault_want(struct fault_line *line, size_t n, const char *word)
{
    char quoted[48];

    if (fault_word_is(line, n, word))
        return true;
    snprintf(quoted, sizeof quoted, "'%s'", word);
    return fault_fail(line, n, NULL, quoted);
}

void fault_line_tell(const struct fault_line *line, char *text, size_t size)
{
    char word[48];
    int at;

    if (line->what[0])
        at = snprintf(text, size, "%s", line->what);
    else if (line->failed_at == line->count)
        at = snprintf(text, size, "the line ends here");
    else
        at = snprintf(text, size, "unexpected '%s'", fault_word_text(line, line->failed_at, word));
    for (unsigned i = 0; i < line->expected_count && at >= 0 && (size_t)at < size; i++)
        at += snprintf(text + at, size - (size_t)at, "%s%s",
                       i == 0                          ? "; expected "
                       : i + 1 == line->expected_count ? " or "
                                                       : ", ",
                       line->expected[i]);
}

static int digit(char c, unsigned base)
{
    int value = c >= '0' && c <= '9'   ? c - '0'
                : c >= 'a' && c <= 'f' ? c - 'a' + 10
                : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                       : 99;

    return value < (int)base ? value : -1;
}

/* Decimal, or hexadecimal behind 0x. */
static bool number(const char *text, size_t length, uint64_t most, uint64_t *value)
{
    bool hex = length > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    unsigned base = hex ? 16 : 10;
    uint64_t sum = 0;

    for (size_t i = hex ? 2 : 0; i < length; i++) {
        int d = digit(text[i], base);

        if (d < 0 || sum > (UINT64_MAX - (unsigned)d) / base)
            return false;
        sum = sum * base + (unsigned)d;
    }
    *value = sum;
    return length > 0 && sum <= most;
}

bool fault_number(const struct fault_line *line, size_t n, uint64_t most, uint64_t *value)
{
    return number(line->words[n].at, line->words[n].length, most, value);
}

bool fault_signed(const struct fault_line *line, size_t n, int64_t *value)
{
    const struct fault_word *word = &line->words[n];
    bool minus = word->length > 0 && word->at[0] == '-';
    uint64_t size;

    if (!number(word->at + minus, word->length - minus, INT64_MAX, &size))
        return false;
    *value = minus ? -(int64_t)size : (int64_t)size;
    return true;
}

/* Digits beyond the given decimals must be zeros: nothing is rounded away. */
bool fault_decimal(const char *text, size_t length, unsigned decimals, bool negative,
                   int64_t *value)
{
    bool minus = negative && length > 0 && text[0] == '-';
    size_t at = minus || (negative && length > 0 && text[0] == '+');
    unsigned behind = 0, digits = 0;
    bool point = false;
    int64_t sum = 0;

    for (; at < length; at++) {
        int d = digit(text[at], 10);

        if (text[at] == '.' && !point && digits) {
            point = true;
            continue;
        }
        if (d < 0 || sum > FAULT_TIME_MAX || (point && behind == decimals && d))
            return false;
        digits++;
        if (point && behind == decimals)
            continue;
        behind += point;
        sum = sum * 10 + d;
    }
    for (; behind < decimals && sum <= FAULT_TIME_MAX; behind++)
        sum *= 10;
    *value = minus ? -sum : sum;
    return digits > 0 && text[length - 1] != '.' && sum <= FAULT_TIME_MAX;
}

bool fault_time(const struct fault_line *line, size_t n, uint64_t *ns)
{
    static const struct {
        const char *name;
        unsigned decimals;
    } units[] = { { "ns", 0 }, { "us", 3 }, { "ms", 6 }, { "s", 9 } };
    const struct fault_word *word = &line->words[n];
    int64_t value;

    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        size_t unit = strlen(units[i].name);

        if (word->length <= unit ||
            memcmp(word->at + word->length - unit, units[i].name, unit) != 0)
            continue;
        if (!fault_decimal(word->at, word->length - unit, units[i].decimals, false, &value))
            continue;
        *ns = (uint64_t)value;
        return true;
    }
    return false;
}
