/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What became of a scenario, as lines for people. The evidence comes from a worker that is not
 * trusted: numbers are looked at before they lead anywhere. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/evidence.h"
#include "host/scenario_parts.h"

struct line {
    char *text;
    size_t used;
};

static void add(struct line *line, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(struct line *line, const char *format, ...)
{
    const size_t room = SCENARIO_TEXT - line->used;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line->text + line->used, room, format, arguments);
    va_end(arguments);
    line->used += length >= 0 && (size_t)length < room ? (size_t)length : room - 1;
}

/* The shortest decimal that reads back as the same number. */
static void add_value(struct line *line, struct scenario_value value)
{
    char text[32];
    if (!value.is_double) {
        add(line, "%" PRId64, value.i);
        return;
    }
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value.d);
        if (strtod(text, NULL) >= value.d && strtod(text, NULL) <= value.d)
            break;
    }
    add(line, "%s", text);
}

static void add_time(struct line *line, uint64_t ns)
{
    const bool us = ns % 1000000 != 0, one_ns = ns % 1000 != 0;
    add(line, "%" PRIu64 "%s",
        one_ns ? ns
        : us   ? ns / 1000
               : ns / 1000000,
        one_ns ? "ns"
        : us   ? "us"
               : "ms");
}

/* "it was 2"; "SERVO[0].Status was 2, DIO[0].In0 was 1" */
static void add_values(struct line *line, const struct scenario *scenario,
                       const struct scenario_expression *expression,
                       const struct evidence_failure *failure)
{
    unsigned registers[EVIDENCE_VALUES];
    const size_t reads = scenario_reads(scenario, expression, registers, EVIDENCE_VALUES);
    for (size_t i = 0; i < reads && i < failure->value_count; i++) {
        const char *name = scenario->registers[registers[i]].name;
        add(line, "%s%s was ", i == 0 ? ": " : ", ", reads == 1 ? "it" : name);
        add_value(line, failure->values[i]);
    }
}

static void tell_expectation(struct line *line, const struct scenario *scenario,
                             const struct scenario_statement *st,
                             const struct evidence_failure *failure)
{
    if (st->text != NULL)
        add(line, "%s: ", st->text);
    add(line, "%s", st->expression.text);
    if (st->kind == SCENARIO_WAIT || st->within_ns > 0) {
        add(line, " not within ");
        add_time(line, st->within_ns);
    } else {
        add(line, " is not so");
    }
    add_values(line, scenario, &st->expression, failure);
}

static const char *target_of(const struct scenario_statement *st)
{
    return st->target != NULL ? st->target : "";
}

static void tell_no_fit(struct line *line, const struct scenario *scenario,
                        const struct scenario_statement *st, const struct evidence_failure *failure)
{
    add_value(line, failure->values[0]);
    if (st->kind == SCENARIO_SET)
        add(line, " does not fit %s (%s)", target_of(st),
            scalar_name(scenario->registers[st->reg].reg.type));
    else
        add(line, " is no value of %s", target_of(st));
}

static void tell_refused(struct line *line, const struct scenario_statement *st,
                         const struct evidence_failure *failure)
{
    if (st->kind == SCENARIO_FAULT) {
        add(line, "fault %s: too many faults last at the same time", st->text);
        return;
    }
    add(line, "%s cannot be ", target_of(st));
    add_value(line, failure->values[0]);
}

void scenario_tell(const struct scenario *scenario, const struct evidence_failure *failure,
                   char text[SCENARIO_TEXT])
{
    struct line line = { text, 0 };
    text[0] = '\0';
    if (failure->statement >= scenario->statement_count) {
        add(&line, "%s: the worker tells of a statement that is not there", scenario->name);
        return;
    }
    const struct scenario_statement *st = &scenario->statements[failure->statement];
    const bool expectation = failure->kind == FAILURE_EXPECTATION && st->expression.count > 0;
    add(&line, "%s:%u:%u: ", scenario->name, st->line,
        expectation          ? st->expression.column
        : st->target != NULL ? st->target_column
                             : st->column);
    if (expectation)
        tell_expectation(&line, scenario, st, failure);
    else if (failure->kind == FAILURE_NO_FIT)
        tell_no_fit(&line, scenario, st, failure);
    else if (failure->kind == FAILURE_OVERWRITTEN)
        add(&line, "%s does not stay as it is set: TG Motion writes it every cycle", target_of(st));
    else
        tell_refused(&line, st, failure);
}

void scenario_tell_line(const struct scenario *scenario, const struct evidence_line *logged,
                        char text[SCENARIO_TEXT])
{
    struct line line = { text, 0 };
    text[0] = '\0';
    if (logged->statement >= scenario->statement_count)
        return;
    const struct scenario_statement *st = &scenario->statements[logged->statement];
    add(&line, "%s", st->text != NULL ? st->text : "");
    if (st->expression.count == 0)
        return;
    add(&line, " ");
    add_value(&line, logged->value);
}
