/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/scan.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int why_at_v(char why[SCAN_WHY], const char *file, struct place place, const char *format,
             va_list arguments)
{
    int n;

    if (place.column)
        n = snprintf(why, SCAN_WHY, "%.200s:%u:%u: ", file, place.line, place.column);
    else if (place.line)
        n = snprintf(why, SCAN_WHY, "%.200s:%u: ", file, place.line);
    else
        n = snprintf(why, SCAN_WHY, "%.200s: ", file);
    if (n > 0 && n < SCAN_WHY)
        vsnprintf(why + n, (size_t)(SCAN_WHY - n), format, arguments);
    return -EINVAL;
}

int why_at(char why[SCAN_WHY], const char *file, struct place place, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    why_at_v(why, file, place, format, arguments);
    va_end(arguments);
    return -EINVAL;
}

bool scan_fail_at(struct scan *scan, struct place place, const char *format, ...)
{
    va_list arguments;

    if (scan->failed)
        return false;
    scan->failed = true;
    va_start(arguments, format);
    why_at_v(scan->why, scan->file, place, format, arguments);
    va_end(arguments);
    return false;
}

bool scan_fail(struct scan *scan, const char *format, ...)
{
    struct place place = { scan->line, scan->next ? scan->token[scan->next - 1].column : 1 };
    va_list arguments;

    if (scan->failed)
        return false;
    scan->failed = true;
    va_start(arguments, format);
    why_at_v(scan->why, scan->file, place, format, arguments);
    va_end(arguments);
    return false;
}

void scan_init(struct scan *scan, const char *file, const char *text, size_t length,
               char why[SCAN_WHY])
{
    memset(scan, 0, sizeof *scan);
    scan->file = file;
    scan->at = text;
    scan->end = text + length;
    scan->why = why;
    why[0] = '\0';
}

static bool blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

/* Copies one quoted text, escapes resolved; *from stands behind the opening quote. */
static bool quoted(struct scan *scan, const char **from, const char *end, const char *line,
                   char **to)
{
    unsigned column = (unsigned)(*from - line);

    while (*from < end && **from != '"') {
        char c = *(*from)++;

        if (c == '\\' && *from < end && (**from == '"' || **from == '\\'))
            c = *(*from)++;
        *(*to)++ = c;
    }
    if (*from == end)
        return scan_fail_at(scan, (struct place){ scan->line, column },
                            "this text does not end; expected a closing \"");
    ++*from;
    if (*from < end && !blank(**from))
        return scan_fail_at(scan, (struct place){ scan->line, (unsigned)(*from - line) + 1 },
                            "something sticks to a text; expected a blank behind the closing \"");
    return true;
}

static bool split(struct scan *scan, const char *line, const char *end)
{
    const char *from = line;
    char *to = scan->chars;

    scan->count = scan->next = 0;
    scan->line_end = 1;
    scan->indented = from < end && blank(*from);
    for (;;) {
        struct scan_token *token = &scan->token[scan->count];

        while (from < end && blank(*from))
            from++;
        if (from == end || *from == '#')
            return true;
        if (scan->count == SCAN_TOKENS)
            return scan_fail_at(scan, (struct place){ scan->line, (unsigned)(from - line) + 1 },
                                "too many words; expected at most %d in a line", SCAN_TOKENS);
        *token = (struct scan_token){ to, (unsigned)(from - line) + 1, *from == '"' };
        if (token->quoted) {
            from++;
            if (!quoted(scan, &from, end, line, &to))
                return false;
        } else {
            while (from < end && !blank(*from) && *from != '#')
                *to++ = *from++;
        }
        *to++ = '\0';
        scan->count++;
        scan->line_end = (unsigned)(from - line) + 1;
    }
}

bool scan_line(struct scan *scan)
{
    scan->count = scan->next = 0;
    while (!scan->failed && scan->at < scan->end) {
        const char *line = scan->at;
        const char *end = memchr(line, '\n', (size_t)(scan->end - line));

        scan->line++;
        if (!end)
            end = scan->end;
        scan->at = end < scan->end ? end + 1 : end;
        if (end - line > SCAN_LINE)
            return scan_fail_at(scan, (struct place){ scan->line, SCAN_LINE + 1 },
                                "this line is too long; expected at most %d characters", SCAN_LINE);
        for (const char *c = line; c < end; c++) {
            if ((unsigned char)*c < 0x20 && !blank(*c))
                return scan_fail_at(scan, (struct place){ scan->line, (unsigned)(c - line) + 1 },
                                    "byte 0x%02X; expected text", (unsigned)(unsigned char)*c);
        }
        if (!split(scan, line, end))
            return false;
        if (scan->count)
            return true;
    }
    return false;
}

bool scan_more(const struct scan *scan)
{
    return scan->next < scan->count;
}

struct place scan_place(const struct scan *scan)
{
    return (struct place){ scan->line,
                           scan_more(scan) ? scan->token[scan->next].column : scan->line_end };
}

struct place scan_start(const struct scan *scan)
{
    return (struct place){ scan->line, scan->count ? scan->token[0].column : 1 };
}

/* NULL, and the complaint, when the line has ended or the word is of the other kind. */
static const char *take(struct scan *scan, const char *what, bool text)
{
    const struct scan_token *token = &scan->token[scan->next];

    if (scan->failed)
        return NULL;
    if (!scan_more(scan)) {
        scan_fail_at(scan, scan_place(scan), "the line ends here; expected %s", what);
        return NULL;
    }
    scan->next++;
    if (token->quoted == text)
        return token->text;
    if (text)
        scan_fail(scan, "\"%.40s\" is not in quotes; expected %s in quotes", token->text, what);
    else
        scan_fail(scan, "a text in quotes; expected %s", what);
    return NULL;
}

bool scan_word(struct scan *scan, const char *what, const char **word)
{
    *word = take(scan, what, false);
    return *word != NULL;
}

bool scan_text(struct scan *scan, const char *what, const char **text)
{
    *text = take(scan, what, true);
    return *text != NULL;
}

/* Decimal or 0x..., with a sign; *rest behind it. Values above INT64_MAX wrap as 64-bit patterns.
 */
static bool number(const char *text, int64_t *value, const char **rest)
{
    bool negative = *text == '-';
    const char *digits = text + (*text == '-' || *text == '+');
    bool hexadecimal = digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X');
    unsigned long long magnitude;
    char *end;

    if (hexadecimal ? !strchr("0123456789abcdefABCDEF", digits[2]) || !digits[2]
                    : *digits < '0' || *digits > '9')
        return false;
    errno = 0;
    magnitude = strtoull(digits, &end, hexadecimal ? 16 : 10);
    *rest = end;
    if (errno || (negative && magnitude > (unsigned long long)INT64_MAX + 1))
        return false;
    *value = (int64_t)(negative ? 0 - magnitude : magnitude);
    return negative || hexadecimal || magnitude <= INT64_MAX;
}

static void describe(char text[64], int64_t least, int64_t most)
{
    if (least == INT64_MIN && most == INT64_MAX)
        snprintf(text, 64, "a number");
    else if (least >= 0 && most > 255)
        snprintf(text, 64, "%lld to 0x%llX", (long long)least, (unsigned long long)most);
    else
        snprintf(text, 64, "%lld to %lld", (long long)least, (long long)most);
}

bool scan_number(struct scan *scan, const char *what, int64_t least, int64_t most, int64_t *value)
{
    const char *word, *rest;
    char allowed[64];

    describe(allowed, least, most);
    if (!scan_word(scan, what, &word))
        return false;
    if (!number(word, value, &rest) || *rest)
        return scan_fail(scan, "\"%.40s\" is not a number; expected %s, %s", word, what, allowed);
    if (*value < least || *value > most)
        return scan_fail(scan, "%.40s is out of range; expected %s, %s", word, what, allowed);
    return true;
}

/* At most eight digits, so that nothing overflows. */
static const char *hexadecimal(const char *text, uint32_t *value)
{
    const char *digits = "0123456789abcdef", *at = text, *digit;

    for (*value = 0; *at && at - text < 8; at++) {
        digit = strchr(digits, *at >= 'A' && *at <= 'F' ? *at - 'A' + 'a' : *at);
        if (!digit)
            break;
        *value = *value << 4 | (uint32_t)(digit - digits);
    }
    return at == text ? NULL : at;
}

bool scan_object(struct scan *scan, const char *what, uint16_t *index, uint8_t *subindex)
{
    const char *word, *rest, *end;
    uint32_t high, low;

    if (!scan_word(scan, what, &word))
        return false;
    rest = hexadecimal(word + (strncmp(word, "0x", 2) == 0 ? 2 : 0), &high);
    end = rest && *rest == ':' ? hexadecimal(rest + 1, &low) : NULL;
    if (!end || *end)
        return scan_fail(scan, "\"%.40s\" names no object; expected %s like 0x6000:01", word, what);
    if (high < 1 || high > 0xffff || low > 0xff)
        return scan_fail(scan,
                         "%.40s is out of range; expected an index 1 to 0xFFFF and a "
                         "subindex 0 to FF",
                         word);
    *index = (uint16_t)high;
    *subindex = (uint8_t)low;
    return true;
}

bool scan_range(struct scan *scan, int64_t *least, int64_t *most)
{
    const char *word, *rest, *end = NULL;

    if (!scan_word(scan, "a range like 0..100", &word))
        return false;
    if (!number(word, least, &rest) || strncmp(rest, "..", 2) != 0 ||
        !number(rest + 2, most, &end) || *end)
        return scan_fail(scan, "\"%.40s\" is no range; expected two numbers like 0..100", word);
    if (*least > *most)
        return scan_fail(scan, "%.40s is empty; expected the smaller number first", word);
    return true;
}

bool scan_duration(struct scan *scan, const char *what, uint64_t *ns)
{
    static const struct {
        const char *unit;
        uint64_t ns;
    } units[] = { { "ns", 1 }, { "us", 1000 }, { "ms", 1000000 }, { "s", 1000000000 } };
    const uint64_t hour = 3600000000000u;
    const char *word, *rest;
    int64_t value;

    if (!scan_word(scan, what, &word))
        return false;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        if (!number(word, &value, &rest) || value < 0 || strcmp(rest, units[i].unit) != 0)
            continue;
        if ((uint64_t)value > hour / units[i].ns)
            return scan_fail(scan, "%.40s is too long; expected %s of at most 3600s", word, what);
        *ns = (uint64_t)value * units[i].ns;
        return true;
    }
    return scan_fail(scan, "\"%.40s\" is no time; expected %s like 400ms, 2s, 250us or 10ns", word,
                     what);
}

bool scan_choice(struct scan *scan, const char *what, const char *const *words, size_t count,
                 unsigned *choice)
{
    char all[256] = "";
    const char *word, *close;
    size_t used = 0;

    if (!scan_word(scan, what, &word))
        return false;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(word, words[i]) == 0) {
            *choice = (unsigned)i;
            return true;
        }
        if (used < sizeof all)
            used +=
                (size_t)snprintf(all + used, sizeof all - used, "%s%s", i ? ", " : "", words[i]);
    }
    close = scan_nearest(word, words, count);
    if (close)
        return scan_fail(scan, "unknown word \"%.40s\" (did you mean \"%s\"?); expected %s", word,
                         close, what);
    return scan_fail(scan, "unknown word \"%.40s\"; expected %s: %s", word, what, all);
}

bool scan_end(struct scan *scan)
{
    if (scan->failed)
        return false;
    if (!scan_more(scan))
        return true;
    scan->next++;
    return scan_fail(scan, "\"%.40s\" is too much; expected the end of the line",
                     scan->token[scan->next - 1].text);
}

bool scan_is(struct scan *scan, const char *word)
{
    const struct scan_token *token = &scan->token[scan->next];

    if (scan->failed || !scan_more(scan) || token->quoted || strcmp(token->text, word) != 0)
        return false;
    scan->next++;
    return true;
}

/* Levenshtein over words of at most this length; longer ones are not close to anything. */
enum { WORD = 32 };

static size_t distance(const char *a, const char *b)
{
    size_t row[WORD + 1], m = strlen(a), n = strlen(b);

    if (m > WORD || n > WORD)
        return WORD;
    for (size_t j = 0; j <= n; j++)
        row[j] = j;
    for (size_t i = 1; i <= m; i++) {
        size_t corner = row[0];

        row[0] = i;
        for (size_t j = 1; j <= n; j++) {
            size_t best = corner + (a[i - 1] != b[j - 1]);

            corner = row[j];
            if (row[j] + 1 < best)
                best = row[j] + 1;
            if (row[j - 1] + 1 < best)
                best = row[j - 1] + 1;
            row[j] = best;
        }
    }
    return row[n];
}

const char *scan_nearest(const char *word, const char *const *words, size_t count)
{
    size_t best = strlen(word) / 3 + 2;
    const char *close = NULL;

    for (size_t i = 0; i < count; i++) {
        size_t d = distance(word, words[i]);

        if (d < best) {
            best = d;
            close = words[i];
        }
    }
    return close;
}

static char *cannot(const char *path, int number_of, const char *what, int *error,
                    char why[SCAN_WHY])
{
    *error = -number_of;
    snprintf(why, SCAN_WHY, "%.200s: %s", path, what);
    return NULL;
}

char *scan_read_file(const char *path, size_t most, size_t *length, int *error, char why[SCAN_WHY])
{
    FILE *file = fopen(path, "rbe");
    char *text;

    if (!file)
        return cannot(path, errno, strerror(errno), error, why);
    text = malloc(most + 1);
    if (!text) {
        fclose(file);
        return cannot(path, ENOMEM, "no memory", error, why);
    }
    *length = fread(text, 1, most + 1, file);
    if (ferror(file)) {
        cannot(path, EIO, "cannot be read", error, why);
    } else if (*length > most) {
        cannot(path, EFBIG, "the file is too large", error, why);
        snprintf(why, SCAN_WHY, "%.200s: the file is too large; expected at most %zu bytes", path,
                 most);
    } else {
        fclose(file);
        return text;
    }
    fclose(file);
    free(text);
    return NULL;
}
