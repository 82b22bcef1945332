/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The statements of a scenario: one a line, each a row of the table below. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/scan.h"
#include "host/scenario_parts.h"

#define TIME_WANTED "a time such as 250ms"
#define LINE_LENGTH 1000

/* The whole text on its way. */
struct script {
    struct reader r;
    uint64_t last_ns; /* time of the statement before, from the origin */
    unsigned last_line;
    size_t open[SCENARIO_BLOCKS];
    size_t depth;
    bool over; /* nothing may follow */
};

typedef bool read_arguments(struct script *s, struct scenario_statement *st);

/* "250ms": the largest unit without a remainder. */
static void time_text(uint64_t ns, char text[32])
{
    static const struct {
        const char *name;
        uint64_t ns;
    } units[] = { { "s", 1000000000 }, { "ms", 1000000 }, { "us", 1000 }, { "ns", 1 } };
    size_t i = 0;
    while (ns % units[i].ns != 0)
        i++;
    snprintf(text, 32, "%" PRIu64 "%s", ns / units[i].ns, units[i].name);
}

static bool expect_end(struct reader *r, const char *or_else)
{
    char expected[128];
    snprintf(expected, sizeof expected, "%s%sthe end of the line", or_else,
             or_else[0] != '\0' ? " or " : "");
    return r->token.kind == TOKEN_END || reader_unexpected(r, expected);
}

static bool read_text_of(struct reader *r, const char **text)
{
    *text = reader_keep(r, r->token.at + 1, r->token.length - 2);
    reader_next(r);
    return r->why[0] == '\0';
}

/* ["MESSAGE"] and the end of the line. */
static bool read_message(struct reader *r, struct scenario_statement *st, const char *or_else)
{
    char expected[96];
    if (r->token.kind == TOKEN_TEXT)
        return read_text_of(r, &st->text) && expect_end(r, "");
    snprintf(expected, sizeof expected, "an operator, %sa message in quotes", or_else);
    return expect_end(r, expected);
}

/* --- actions --- */

static bool read_set(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const struct token target = r->token;
    if (target.kind != TOKEN_WORD)
        return reader_unexpected(r, "a register such as SERVO[0].Mode");
    st->target_column = reader_column(r, target.at);
    st->target = reader_keep(r, target.at, target.length);
    if (!reader_register(r, target.at, target.length, &st->reg))
        return false;
    if (strcmp(r->scenario->registers[st->reg].reg.access, "reserved") == 0)
        return reader_fail(r, target.at, "this register is reserved; expected one that is not");
    reader_next(r);
    if (!reader_take(r, "="))
        return reader_unexpected(r, "'='");
    return reader_expression(r, &st->expression) && expect_end(r, "an operator");
}

/* "DIO[3]": which group, and which of them. */
static bool group(struct reader *r, struct scenario_statement *st)
{
    static const char *const names[] = { "DIO[", "SERVO[" };
    const struct token token = r->token;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const size_t length = strlen(names[i]);
        uint64_t number = 0;
        size_t at = length;
        if (token.kind != TOKEN_WORD || token.length < length + 2 ||
            memcmp(token.at, names[i], length) != 0)
            continue;
        while (at < token.length && token.at[at] >= '0' && token.at[at] <= '9' && number < 100000)
            number = number * 10 + (uint64_t)(token.at[at++] - '0');
        if (at == length || at + 1 != token.length || token.at[at] != ']')
            continue;
        st->servo = i == 1;
        st->number = number;
        reader_next(r);
        return true;
    }
    return reader_unexpected(r, "DIO[n] or SERVO[n]");
}

static bool read_input(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const char *begin = r->token.at;
    st->target_column = reader_column(r, begin);
    if (!group(r, st))
        return false;
    if (!reader_take(r, "channel") && !reader_take(r, "bit"))
        return reader_unexpected(r, "'channel'");
    if (r->token.kind != TOKEN_NUMBER || r->token.value.is_double || r->token.value.i > 9999)
        return reader_unexpected(r, "the number of a channel, from 0");
    st->channel = (uint64_t)r->token.value.i;
    st->target = reader_keep(r, begin, (size_t)(r->token.at + r->token.length - begin));
    reader_next(r);
    if (!reader_take(r, "="))
        return reader_unexpected(r, "'='");
    return reader_expression(r, &st->expression) && expect_end(r, "an operator");
}

/* The bus reads it when the scenario is bound to one. */
static bool read_fault(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const char *begin = r->token.at;
    const char *hash = memchr(begin, '#', (size_t)(r->end - begin));
    const char *end = hash != NULL ? hash : r->end;
    char line[LINE_LENGTH + 1];
    if (r->token.kind == TOKEN_END)
        return reader_unexpected(r, "a fault such as unplug after 1");
    while (end[-1] == ' ' || end[-1] == '\t' || end[-1] == '\r')
        end--;
    st->text = reader_keep(r, begin, (size_t)(end - begin));
    memset(line, ' ', (size_t)(begin - r->begin));
    memcpy(line + (begin - r->begin), begin, (size_t)(end - begin));
    st->padded = reader_keep(r, line, (size_t)(end - r->begin));
    return r->why[0] == '\0';
}

static bool read_control(struct script *s, struct scenario_statement *st)
{
    (void)st;
    return expect_end(&s->r, "");
}

static bool read_log(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    if (r->token.kind != TOKEN_TEXT)
        return reader_unexpected(r, "a text in quotes");
    if (!read_text_of(r, &st->text))
        return false;
    if (r->token.kind == TOKEN_END)
        return true;
    return reader_expression(r, &st->expression) && expect_end(r, "an operator");
}

static bool read_expect(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    if (!reader_expression(r, &st->expression))
        return false;
    if (!reader_take(r, "within"))
        return read_message(r, st, "'within', ");
    return reader_time(r, TIME_WANTED, &st->within_ns) && read_message(r, st, "");
}

static bool read_wait(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    if (!reader_take(r, "until"))
        return reader_unexpected(r, "'until'");
    if (!reader_expression(r, &st->expression))
        return false;
    if (!reader_take(r, "within"))
        return reader_unexpected(r, "an operator or 'within' and a time");
    if (!reader_time(r, TIME_WANTED, &st->within_ns) || !read_message(r, st, ""))
        return false;
    s->last_ns = 0;
    return true;
}

static bool read_every(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const char *at = r->token.at;
    st->to_ns = SCENARIO_FOREVER;
    if (!reader_time(r, TIME_WANTED, &st->every_ns))
        return false;
    if (st->every_ns == 0)
        return reader_fail(r, at, "a time of 0 never passes; expected a longer one");
    if (reader_take(r, "from")) {
        st->from_given = true;
        if (!reader_time(r, TIME_WANTED, &st->from_ns))
            return false;
        at = r->token.at;
        if (reader_take(r, "to") && !reader_time(r, TIME_WANTED, &st->to_ns))
            return false;
        if (st->to_ns <= st->from_ns)
            return reader_fail(r, at, "the end is not behind the begin; expected a later time");
    }
    if (!reader_take(r, "expect"))
        return reader_unexpected(
            r, st->from_given ? st->to_ns == SCENARIO_FOREVER ? "'to' or 'expect'" : "'expect'"
                              : "'from' or 'expect'");
    if (s->depth > 0 && st->to_ns == SCENARIO_FOREVER)
        return reader_fail_at(r, st,
                              "a round of 'repeat' would never be over; expected from TIME "
                              "to TIME");
    return reader_expression(r, &st->expression) && read_message(r, st, "");
}

static bool read_repeat(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const struct token token = r->token;
    if (token.kind != TOKEN_NUMBER || token.value.is_double || token.value.i < 1 ||
        token.value.i > SCENARIO_ROUNDS)
        return reader_unexpected(r, "how often, 1 to 1000000");
    if (s->depth == SCENARIO_BLOCKS)
        return reader_fail_at(r, st, "more than %d repeats in one another", SCENARIO_BLOCKS);
    st->rounds = (uint64_t)token.value.i;
    s->open[s->depth++] = r->scenario->statement_count;
    s->last_ns = 0;
    reader_next(r);
    return expect_end(r, "");
}

/* `end` of a repeat, or of the whole scenario at some time. */
static bool read_end(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    const bool at = reader_is(r, "at"), after = reader_is(r, "after");
    if (at || after) {
        if (s->depth > 0)
            return reader_unexpected(r, "the end of the line: a repeat is open here");
        reader_next(r);
        const char *time = r->token.at;
        st->kind = SCENARIO_STOP;
        st->when = at ? SCENARIO_AT : SCENARIO_AFTER;
        s->over = true;
        if (!reader_time(r, TIME_WANTED, &st->when_ns))
            return false;
        if (at && st->when_ns < s->last_ns)
            return reader_fail(r, time, "this is before line %u; expected a later time",
                               s->last_line);
        return expect_end(r, "");
    }
    if (s->depth == 0)
        return reader_unexpected(r, "'at' or 'after' and a time: no repeat is open here");
    st->partner = s->open[--s->depth];
    r->scenario->statements[st->partner].partner = r->scenario->statement_count;
    s->last_ns = 0;
    return expect_end(r, "");
}

static const struct row {
    const char *word;
    enum scenario_kind kind;
    bool timed; /* may have a time in front */
    read_arguments *read;
    const char *grammar;
    enum scenario_control control;
} rows[] = {
    { "set", SCENARIO_SET, true, read_set, "set REGISTER = EXPRESSION", 0 },
    { "input", SCENARIO_INPUT, true, read_input, "input DIO[N] channel C = EXPRESSION", 0 },
    { "fault", SCENARIO_FAULT, true, read_fault, "fault FAULT", 0 },
    { "expect", SCENARIO_EXPECT, true, read_expect, "expect EXPRESSION [within TIME] [\"MESSAGE\"]",
      0 },
    { "every", SCENARIO_EVERY, false, read_every,
      "every TIME [from TIME [to TIME]] expect EXPRESSION [\"MESSAGE\"]", 0 },
    { "wait", SCENARIO_WAIT, true, read_wait, "wait until EXPRESSION within TIME [\"MESSAGE\"]",
      0 },
    { "repeat", SCENARIO_REPEAT, true, read_repeat, "repeat N", 0 },
    { "end", SCENARIO_END, false, read_end, "end", 0 },
    { "log", SCENARIO_LOG, true, read_log, "log \"TEXT\" [EXPRESSION]", 0 },
    { "run", SCENARIO_PLC, true, read_control, "run", CONTROL_RUN },
    { "stop", SCENARIO_PLC, true, read_control, "stop", CONTROL_STOP },
    { "pause", SCENARIO_PLC, true, read_control, "pause", CONTROL_PAUSE },
    { "reload", SCENARIO_PLC, true, read_control, "reload", CONTROL_RELOAD },
};

#define ROWS (sizeof rows / sizeof *rows)

/* Grammars that are no rows: times in front, and the end of the whole. */
static const char *const others[] = { "at TIME ...", "after TIME ...",
                                      "input SERVO[N] channel C = EXPRESSION", "end at TIME",
                                      "end after TIME" };

const char *scenario_grammar(size_t index)
{
    const size_t count = sizeof others / sizeof *others;
    return index < ROWS ? rows[index].grammar : index < ROWS + count ? others[index - ROWS] : NULL;
}

/* --- lines --- */

static bool unknown_word(struct reader *r, bool timed)
{
    char expected[160] = "", word[48];
    const char *names[ROWS + 2], *close = NULL;
    size_t count = 0, at = 0;
    for (size_t i = 0; i < ROWS; i++)
        if (!timed || rows[i].timed)
            names[count++] = rows[i].word;
    if (!timed) {
        names[count++] = "at";
        names[count++] = "after";
    }
    snprintf(word, sizeof word, "%.*s", (int)(r->token.length < 40 ? r->token.length : 40),
             r->token.at);
    if (r->token.kind == TOKEN_WORD)
        close = scan_nearest(word, names, count);
    if (close != NULL)
        return reader_fail(r, r->token.at, "unknown word '%s' (did you mean '%s'?)", word, close);
    for (size_t i = 0; i < count; i++)
        at += (size_t)snprintf(expected + at, sizeof expected - at, "%s%s",
                               i == 0           ? ""
                               : i + 1 == count ? " or "
                                                : ", ",
                               names[i]);
    return reader_unexpected(r, expected);
}

/* at TIME, after TIME, or nothing. */
static bool read_when(struct script *s, struct scenario_statement *st)
{
    struct reader *r = &s->r;
    char given[32], before[32];
    st->when = reader_is(r, "at")      ? SCENARIO_AT
               : reader_is(r, "after") ? SCENARIO_AFTER
                                       : SCENARIO_NOW;
    if (st->when == SCENARIO_NOW)
        return true;
    reader_next(r);
    const char *at = r->token.at;
    if (!reader_time(r, TIME_WANTED, &st->when_ns))
        return false;
    if (st->when == SCENARIO_AT && st->when_ns < s->last_ns) {
        time_text(st->when_ns, given);
        time_text(s->last_ns, before);
        return reader_fail(r, at,
                           "%s is before the %s of line %u; expected statements in order of "
                           "time",
                           given, before, s->last_line);
    }
    s->last_ns = st->when == SCENARIO_AT ? st->when_ns : s->last_ns + st->when_ns;
    s->last_line = r->line;
    return true;
}

static bool read_statement(struct script *s)
{
    struct reader *r = &s->r;
    struct scenario *scenario = r->scenario;
    struct scenario_statement st = { .line = r->line };
    if (scenario->statement_count == SCENARIO_STATEMENTS)
        return reader_fail(r, r->token.at, "more than %d statements", SCENARIO_STATEMENTS);
    if (s->over)
        return reader_unexpected(r, "nothing more behind the end of the scenario");
    if (!read_when(s, &st))
        return false;
    const bool timed = st.when != SCENARIO_NOW;
    for (size_t i = 0; i < ROWS; i++) {
        if (!reader_is(r, rows[i].word) || (timed && !rows[i].timed))
            continue;
        st.kind = rows[i].kind;
        st.control = rows[i].control;
        st.column = reader_column(r, r->token.at);
        reader_next(r);
        if (!rows[i].read(s, &st))
            return false;
        scenario->statements[scenario->statement_count++] = st;
        return true;
    }
    return unknown_word(r, timed);
}

static bool printable(struct reader *r)
{
    for (const char *at = r->begin; at < r->end; at++) {
        const unsigned char c = (unsigned char)*at;
        if ((c < 0x20 && c != '\t' && (c != '\r' || at + 1 < r->end)) || c == 0x7F)
            return reader_fail(r, at, "a character that cannot be printed (0x%02X); expected text",
                               c);
    }
    if (r->end - r->begin > LINE_LENGTH)
        return reader_fail(r, r->begin + LINE_LENGTH,
                           "the line is too long; expected at most %d "
                           "characters",
                           LINE_LENGTH);
    return true;
}

static bool read_lines(struct script *s, const char *text, size_t length)
{
    struct reader *r = &s->r;
    const char *end = text + length;
    while (text < end) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        reader_line(r, text, newline != NULL ? newline : end);
        if (!printable(r) || (r->token.kind != TOKEN_END && !read_statement(s)))
            return false;
        text = newline != NULL ? newline + 1 : end;
    }
    return true;
}

/* What only the whole can tell. */
static bool check_whole(struct script *s)
{
    struct reader *r = &s->r;
    const struct scenario *scenario = r->scenario;
    const struct scenario_statement *last;
    if (scenario->statement_count == 0) {
        const struct scenario_statement first = { .line = 1, .column = 1 };
        return reader_fail_at(r, &first, "there is no statement; expected at least one");
    }
    if (s->depth > 0)
        return reader_fail_at(r, &scenario->statements[s->open[s->depth - 1]],
                              "this repeat has no 'end'");
    last = &scenario->statements[scenario->statement_count - 1];
    const uint64_t most = scenario_most(scenario, 0);
    if (most == SCENARIO_FOREVER)
        return reader_fail_at(r, last, "the scenario may last longer than a day; expected less");
    for (size_t i = 0; i < scenario->statement_count; i++)
        if (scenario->statements[i].kind == SCENARIO_EVERY && most == 0)
            return reader_fail_at(r, &scenario->statements[i],
                                  "nothing says how long this lasts; expected 'end at TIME' in the "
                                  "last line");
    return true;
}

int scenario_read(struct scenario **out, const char *text, size_t length, const char *name,
                  const struct catalogue *catalogue, char why[SCENARIO_WHY])
{
    struct scenario *scenario = calloc(1, sizeof *scenario);
    struct script script = { .r = { .scenario = scenario, .catalogue = catalogue, .why = why } };
    why[0] = '\0';
    *out = NULL;
    if (scenario != NULL) {
        /* A line's texts are parts of it, a fault and its blanks are twice the line. */
        scenario->pool_size = 3 * length + strlen(name) + 64;
        scenario->pool = malloc(scenario->pool_size);
    }
    if (scenario == NULL || scenario->pool == NULL) {
        free(scenario);
        snprintf(why, SCENARIO_WHY, "%.200s: no memory", name);
        return -ENOMEM;
    }
    scenario->name = reader_keep(&script.r, name, strlen(name));
    if (length > SCENARIO_FILE)
        snprintf(why, SCENARIO_WHY, "%.200s:1:1: the file is too large; expected at most %d bytes",
                 scenario->name, SCENARIO_FILE);
    else if (read_lines(&script, text, length) && check_whole(&script)) {
        *out = scenario;
        return 0;
    }
    scenario_close(scenario);
    return -EINVAL;
}

void scenario_close(struct scenario *scenario)
{
    if (scenario == NULL)
        return;
    free(scenario->pool);
    free(scenario);
}

/* --- how long --- */

static uint64_t sum(uint64_t a, uint64_t b)
{
    return a > SCENARIO_TIME || b > SCENARIO_TIME - a ? SCENARIO_FOREVER : a + b;
}

static uint64_t times(uint64_t a, uint64_t n)
{
    return a > SCENARIO_TIME / n ? SCENARIO_FOREVER : a * n;
}

static uint64_t later(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

uint64_t scenario_most(const struct scenario *scenario, uint64_t cycle_ns)
{
    struct {
        uint64_t begin, over, rounds;
    } blocks[SCENARIO_BLOCKS];
    uint64_t origin = 0, last = 0, over = 0, late = 0, rounds = 1;
    size_t depth = 0;
    for (size_t i = 0; i < scenario->statement_count; i++) {
        const struct scenario_statement *st = &scenario->statements[i];
        if (st->when != SCENARIO_NOW)
            last = sum(st->when == SCENARIO_AT ? origin : last, st->when_ns);
        over = later(over, sum(last, cycle_ns));
        switch (st->kind) {
        case SCENARIO_EXPECT:
            over = later(over, sum(last, sum(st->within_ns, 2 * cycle_ns)));
            break;
        case SCENARIO_EVERY:
            if (st->to_ns != SCENARIO_FOREVER)
                over = later(over, sum(origin, sum(st->to_ns, 2 * cycle_ns)));
            break;
        case SCENARIO_PLC: /* while the module is loaded nothing acts: all the rest may come late */
            late = sum(late, times(SCENARIO_LOAD, rounds));
            break;
        case SCENARIO_WAIT:
            origin = last = sum(last, sum(st->within_ns, 2 * cycle_ns));
            over = later(over, origin);
            break;
        case SCENARIO_REPEAT:
            blocks[depth].begin = last;
            blocks[depth].rounds = rounds;
            blocks[depth++].over = over;
            origin = over = last;
            rounds = times(rounds, st->rounds);
            break;
        case SCENARIO_END:
            depth--;
            over = later(over, last);
            if (over != SCENARIO_FOREVER)
                over = sum(over - blocks[depth].begin, 2 * cycle_ns);
            origin = last =
                sum(blocks[depth].begin, times(over, scenario->statements[st->partner].rounds));
            over = later(origin, blocks[depth].over);
            rounds = blocks[depth].rounds;
            break;
        default:
            break;
        }
    }
    return sum(later(over, last), late);
}

uint64_t scenario_cycles(const struct scenario *scenario, uint32_t cycle_us)
{
    const uint64_t cycle_ns = cycle_us * UINT64_C(1000);
    const uint64_t most = scenario_most(scenario, cycle_ns);
    return (most > SCENARIO_TIME ? SCENARIO_TIME : most) / cycle_ns + 2;
}

size_t scenario_reads(const struct scenario *scenario, const struct scenario_expression *expression,
                      unsigned *registers, size_t most)
{
    size_t count = 0;
    for (size_t i = 0; i < expression->count && count < most; i++) {
        const struct scenario_code *code = &scenario->code[expression->first + i];
        size_t k = 0;
        while (k < count && registers[k] != code->index)
            k++;
        if (code->op == SCENARIO_REGISTER && k == count)
            registers[count++] = code->index;
    }
    return count;
}
