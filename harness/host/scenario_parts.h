/* SPDX-License-Identifier: GPL-2.0-or-later */
/* scenario_parts.h - a scenario as data, for the files that read it, play it and speak of it. */
#ifndef HARNESS_HOST_SCENARIO_PARTS_H
#define HARNESS_HOST_SCENARIO_PARTS_H

#include "host/scenario.h"
#include "host/scenario_value.h"

#define SCENARIO_STATEMENTS 1000
#define SCENARIO_REGISTERS  256   /* different ones */
#define SCENARIO_CODE       16384 /* operands and operators of all expressions */
#define SCENARIO_BLOCKS     8     /* repeats inside one another */
#define SCENARIO_ROUNDS     1000000
#define SCENARIO_TIME       UINT64_C(86400000000000) /* ns: no time and no scenario is longer */
#define SCENARIO_FOREVER    UINT64_MAX
#define SCENARIO_LOAD       UINT64_C(250000000) /* ns: no Run sequence takes longer */

enum scenario_kind {
    SCENARIO_SET,    /* reg = expression */
    SCENARIO_INPUT,  /* group[number] channel = expression */
    SCENARIO_FAULT,  /* text */
    SCENARIO_PLC,    /* control */
    SCENARIO_LOG,    /* text, and the expression when it has one */
    SCENARIO_EXPECT, /* expression, within `within` */
    SCENARIO_EVERY,  /* expression, every `every` from `from` to `to` */
    SCENARIO_WAIT,   /* expression, within `within` */
    SCENARIO_REPEAT, /* `rounds`; partner: its end */
    SCENARIO_END,    /* of a repeat; partner: its begin */
    SCENARIO_STOP    /* the scenario lasts until here at least */
};

/* PLC control, as Observer has it. */
enum scenario_control {
    CONTROL_RUN,   /* ends a pause, or runs a PLC that is stopped */
    CONTROL_STOP,  /* steps 1 to 4 of the Run sequence */
    CONTROL_PAUSE, /* no function is called */
    CONTROL_RELOAD /* the Run sequence, whatever the PLC is doing */
};

enum scenario_when {
    SCENARIO_NOW,  /* right behind the statement before */
    SCENARIO_AT,   /* `when` after the origin */
    SCENARIO_AFTER /* `when` after the statement before */
};

struct scenario_expression {
    size_t first, count; /* in code; count 0: there is none */
    const char *text;    /* as it was written */
    unsigned column;
};

struct scenario_statement {
    enum scenario_kind kind;
    enum scenario_when when;
    unsigned line, column; /* of the action */
    uint64_t when_ns;
    uint64_t within_ns, every_ns;
    bool from_given;
    uint64_t from_ns, to_ns; /* to: SCENARIO_FOREVER when open */
    uint64_t rounds;
    enum scenario_control control;
    size_t partner;
    struct scenario_expression expression;
    unsigned reg;    /* SET; its name stands at target_column */
    bool servo;      /* INPUT: of a servo, otherwise of an I/O unit */
    uint64_t number; /* of the group */
    uint64_t channel;
    unsigned target_column;
    const char *target; /* as it was written */
    const char *text;   /* message of an expectation, of a log; fault as written */
    const char *padded; /* the fault behind as many blanks as it has columns before it */
};

struct scenario_register {
    struct catalogue_register reg;
    const char *name;
};

struct scenario {
    const char *name;
    struct scenario_statement statements[SCENARIO_STATEMENTS];
    size_t statement_count;
    struct scenario_code code[SCENARIO_CODE];
    size_t code_count;
    struct scenario_register registers[SCENARIO_REGISTERS];
    size_t register_count;
    char *pool; /* texts */
    size_t pool_used, pool_size;
};

/* Registers that an expression reads, in order, each once; at most `most`. */
size_t scenario_reads(const struct scenario *scenario, const struct scenario_expression *expression,
                      unsigned *registers, size_t most);

/* The longest that it can take, in ns; SCENARIO_FOREVER past SCENARIO_TIME. */
uint64_t scenario_most(const struct scenario *scenario, uint64_t cycle_ns);

/* --- reading: scenario_words.c, scenario_expression.c, scenario_read.c --- */

enum token_kind {
    TOKEN_END,  /* of the line */
    TOKEN_WORD, /* letters, digits, _ . [ ] */
    TOKEN_NUMBER,
    TOKEN_TIME,
    TOKEN_TEXT, /* in double quotes */
    TOKEN_SIGN, /* operator or punctuation */
    TOKEN_BAD
};

struct token {
    enum token_kind kind;
    const char *at;
    size_t length;
    struct scenario_value value; /* NUMBER; TIME: ns */
};

struct reader {
    struct scenario *scenario;
    const struct catalogue *catalogue;
    const char *begin, *end; /* of the line */
    const char *at;          /* behind the token */
    unsigned line;
    struct token token; /* the next one */
    char *why;          /* "": nothing wrong so far */
};

void reader_line(struct reader *r, const char *begin, const char *end);
/* Takes the token: the next one becomes r->token. */
void reader_next(struct reader *r);
unsigned reader_column(const struct reader *r, const char *at);
bool reader_is(const struct reader *r, const char *word);
/* Takes the word or sign if it is next. */
bool reader_take(struct reader *r, const char *word);
/* "name:line:column: ..."; all return false. The first one counts. */
bool reader_fail(struct reader *r, const char *at, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
bool reader_fail_at(struct reader *r, const struct scenario_statement *statement,
                    const char *format, ...) __attribute__((format(printf, 3, 4)));
/* "unexpected 'x'; expected ..." at the next token. */
bool reader_unexpected(struct reader *r, const char *expected);
bool reader_no_memory(struct reader *r);
/* A copy that lives with the scenario. */
const char *reader_keep(struct reader *r, const char *at, size_t length);

bool reader_time(struct reader *r, const char *expected, uint64_t *ns);
bool reader_register(struct reader *r, const char *at, size_t length, unsigned *index);
bool reader_expression(struct reader *r, struct scenario_expression *expression);

#endif
