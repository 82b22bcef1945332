/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The words of a scenario's line, and complaints about them. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/scenario_parts.h"

#define NUMBER_LENGTH 64

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_path(char c)
{
    return is_letter(c) || is_digit(c) || c == '.' || c == '[' || c == ']';
}

unsigned reader_column(const struct reader *r, const char *at)
{
    return (unsigned)(at - r->begin) + 1;
}

static void fail_v(struct reader *r, unsigned line, unsigned column, const char *format,
                   va_list arguments)
{
    if (r->why[0] != '\0')
        return;
    const int used =
        snprintf(r->why, SCENARIO_WHY, "%.200s:%u:%u: ", r->scenario->name, line, column);
    vsnprintf(r->why + used, (size_t)(SCENARIO_WHY - used), format, arguments);
}

bool reader_fail(struct reader *r, const char *at, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail_v(r, r->line, reader_column(r, at), format, arguments);
    va_end(arguments);
    return false;
}

bool reader_fail_at(struct reader *r, const struct scenario_statement *statement,
                    const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fail_v(r, statement->line, statement->column, format, arguments);
    va_end(arguments);
    return false;
}

bool reader_no_memory(struct reader *r)
{
    return reader_fail(r, r->begin, "no memory");
}

bool reader_unexpected(struct reader *r, const char *expected)
{
    char word[48];
    size_t length = r->token.length < 40 ? r->token.length : 40;
    if (r->token.kind == TOKEN_END)
        return reader_fail(r, r->token.at, "the line ends here; expected %s", expected);
    for (size_t i = 0; i < length; i++)
        word[i] = r->token.at[i] >= ' ' && r->token.at[i] < 0x7F ? r->token.at[i] : '?';
    strcpy(word + length, length < r->token.length ? "..." : "");
    return reader_fail(r, r->token.at, "unexpected '%s'; expected %s", word, expected);
}

/* --- tokens --- */

static size_t span(const char *at, const char *end, bool (*is)(char))
{
    size_t length = 0;
    while (at + length < end && is(at[length]))
        length++;
    return length;
}

/* Digits, at most 9 behind a point, as an integer of 1 / 10^9; more would be rounded away. */
static bool scaled(const char *at, size_t length, uint64_t unit, uint64_t *ns)
{
    uint64_t sum = 0, part = unit;
    bool point = false;
    for (size_t i = 0; i < length; i++) {
        if (at[i] == '.') {
            point = true;
            continue;
        }
        const uint64_t digit = (uint64_t)(at[i] - '0');
        if (point && part % 10 != 0 && digit != 0)
            return false;
        if (point)
            part /= 10;
        sum = point ? sum + digit * part : sum * 10 + digit * unit;
        if (sum > SCENARIO_TIME)
            return false;
    }
    *ns = sum;
    return true;
}

/* "250", "1.5": false when it is another kind of number. */
static bool is_plain(const char *at, size_t length)
{
    size_t points = 0;
    for (size_t i = 0; i < length; i++)
        points += at[i] == '.';
    return points < 2 && length > 0 && at[length - 1] != '.' && is_digit(at[0]);
}

static bool time_token(struct token *token, size_t digits)
{
    static const struct {
        const char *name;
        uint64_t ns;
    } units[] = { { "ns", 1 }, { "us", 1000 }, { "ms", 1000000 }, { "s", 1000000000 } };
    const char *unit = token->at + digits;
    const size_t length = token->length - digits;
    uint64_t ns = 0;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strlen(units[i].name) == length && memcmp(units[i].name, unit, length) == 0) {
            if (!is_plain(token->at, digits) || !scaled(token->at, digits, units[i].ns, &ns))
                return false;
            token->kind = TOKEN_TIME;
            token->value = (struct scenario_value){ .is_double = false, .i = (int64_t)ns };
            return true;
        }
    return false;
}

static bool is_number_letter(char c)
{
    return is_letter(c) || is_digit(c) || c == '.';
}

/* strtod() reads the locale's point, but the program keeps the C locale. */
static bool number_token(struct token *token)
{
    char text[NUMBER_LENGTH], *end;
    if (token->length >= sizeof text)
        return false;
    memcpy(text, token->at, token->length);
    text[token->length] = '\0';
    const bool hex = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    errno = 0;
    if (hex || strpbrk(text, ".eE") == NULL) {
        const uint64_t u = strtoull(text, &end, hex ? 16 : 10);
        token->value = u > INT64_MAX
                           ? (struct scenario_value){ .is_double = true, .d = (double)u }
                           : (struct scenario_value){ .is_double = false, .i = (int64_t)u };
    } else {
        token->value = (struct scenario_value){ .is_double = true, .d = strtod(text, &end) };
    }
    token->kind = TOKEN_NUMBER;
    return *end == '\0' && end > text && errno == 0;
}

/* A number swallows letters behind it: it may be a time. 1e-3 has a sign inside. */
static void numeric(struct reader *r, struct token *token)
{
    token->length = span(token->at, r->end, is_number_letter);
    const char *last = token->at + token->length - 1, *behind = token->at + token->length;
    const bool hex = token->length > 1 && token->at[0] == '0' && (token->at[1] | 0x20) == 'x';
    if (!hex && token->length > 1 && (*last == 'e' || *last == 'E') && behind + 1 < r->end &&
        (*behind == '-' || *behind == '+') && is_digit(behind[1]))
        token->length += 1 + span(behind + 1, r->end, is_digit);
    size_t digits = 0;
    while (digits < token->length && (is_digit(token->at[digits]) || token->at[digits] == '.'))
        digits++;
    if (!time_token(token, digits) && !number_token(token))
        token->kind = TOKEN_BAD;
}

static void quoted(struct reader *r, struct token *token)
{
    const char *close = memchr(token->at + 1, '"', (size_t)(r->end - token->at - 1));
    token->kind = close != NULL ? TOKEN_TEXT : TOKEN_BAD;
    token->length = (size_t)((close != NULL ? close + 1 : r->end) - token->at);
}

static void sign(struct reader *r, struct token *token)
{
    static const char *const signs[] = { "==", "!=", "<=", ">=", "&&", "||", "+", "-",
                                         "*",  "/",  "%",  "<",  ">",  "=",  "!", "&",
                                         "|",  "^",  "~",  "(",  ")",  "," };
    const size_t left = (size_t)(r->end - token->at);
    token->kind = TOKEN_BAD;
    token->length = 1;
    for (size_t i = 0; i < sizeof signs / sizeof *signs; i++)
        if (strlen(signs[i]) <= left && memcmp(signs[i], token->at, strlen(signs[i])) == 0) {
            token->kind = TOKEN_SIGN;
            token->length = strlen(signs[i]);
            return;
        }
}

void reader_next(struct reader *r)
{
    struct token token = { .kind = TOKEN_END };
    while (r->at < r->end && (*r->at == ' ' || *r->at == '\t' || *r->at == '\r'))
        r->at++;
    token.at = r->at;
    if (r->at == r->end || *r->at == '#') {
        r->token = token;
        return;
    }
    if (is_digit(*r->at)) {
        numeric(r, &token);
    } else if (is_letter(*r->at)) {
        token.kind = TOKEN_WORD;
        token.length = span(r->at, r->end, is_path);
    } else if (*r->at == '"') {
        quoted(r, &token);
    } else {
        sign(r, &token);
    }
    r->at += token.length;
    r->token = token;
}

void reader_line(struct reader *r, const char *begin, const char *end)
{
    r->begin = r->at = begin;
    r->end = end;
    r->line++;
    reader_next(r);
}

bool reader_is(const struct reader *r, const char *word)
{
    return (r->token.kind == TOKEN_WORD || r->token.kind == TOKEN_SIGN) &&
           r->token.length == strlen(word) && memcmp(r->token.at, word, r->token.length) == 0;
}

bool reader_take(struct reader *r, const char *word)
{
    if (!reader_is(r, word))
        return false;
    reader_next(r);
    return true;
}

bool reader_time(struct reader *r, const char *expected, uint64_t *ns)
{
    if (r->token.kind != TOKEN_TIME)
        return reader_unexpected(r, expected);
    *ns = (uint64_t)r->token.value.i;
    reader_next(r);
    return true;
}

const char *reader_keep(struct reader *r, const char *at, size_t length)
{
    struct scenario *s = r->scenario;
    if (s->pool_used + length + 1 > s->pool_size) {
        reader_no_memory(r);
        return "";
    }
    char *to = s->pool + s->pool_used;
    memcpy(to, at, length);
    to[length] = '\0';
    s->pool_used += length + 1;
    return to;
}

bool reader_register(struct reader *r, const char *at, size_t length, unsigned *index)
{
    struct scenario *s = r->scenario;
    struct catalogue_register reg;
    char name[160], why[CATALOGUE_WHY];
    if (length >= sizeof name)
        return reader_fail(r, at, "no register has so long a name; expected a register");
    memcpy(name, at, length);
    name[length] = '\0';
    if (catalogue_resolve(r->catalogue, name, &reg, why) != 0)
        return reader_fail(r, at, "%s", why);
    for (unsigned i = 0; i < s->register_count; i++)
        if (s->registers[i].reg.memory == reg.memory && s->registers[i].reg.offset == reg.offset &&
            s->registers[i].reg.type == reg.type) {
            *index = i;
            return true;
        }
    if (s->register_count == SCENARIO_REGISTERS)
        return reader_fail(r, at, "more than %d different registers", SCENARIO_REGISTERS);
    *index = (unsigned)s->register_count++;
    s->registers[*index] = (struct scenario_register){ reg, reader_keep(r, at, length) };
    return r->why[0] == '\0';
}
