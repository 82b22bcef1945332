/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * fault_words.h - a line of a fault script as words, the values they can mean, and the bookkeeping
 * of what was expected where it went wrong.
 */
#ifndef HARNESS_BUS_FAULT_WORDS_H
#define HARNESS_BUS_FAULT_WORDS_H

#include "bus/fault_parts.h"

#define FAULT_WORDS       32 /* most words of a line */
#define FAULT_EXPECTED    24
#define FAULT_TIME_WANTED "a time such as 250ms"
#define FAULT_TIME_MAX    1000000000000000 /* ns: a million seconds */

struct fault_word {
    const char *at;
    size_t length;
    unsigned column; /* from 1 */
};

struct fault_line {
    const struct segment *segment;
    struct fault_word words[FAULT_WORDS + 1]; /* the last one is the end of the line, empty */
    size_t count;
    size_t place_at; /* word that named the slave */
    /* The furthest word at which something did not fit, what about it, and what would have. */
    size_t failed_at;
    char what[FAULTS_WHY / 2];
    unsigned expected_count;
    char expected[FAULT_EXPECTED][64];
};

/* Splits; a comment ends the line. False: too many words (a failure is noted). */
bool fault_line_split(struct fault_line *line, const struct segment *segment, const char *text,
                      size_t length);
/* Word n for messages: printable, not endless. */
const char *fault_word_text(const struct fault_line *line, size_t n, char text[48]);
bool fault_word_is(const struct fault_line *line, size_t n, const char *word);

/* Notes a failure at word n unless one further on is known; returns false. what NULL: the word as
 * such is unexpected. */
bool fault_fail(struct fault_line *line, size_t n, const char *what, const char *expected);
/* Forgets failures: only those from word n on count from here. */
void fault_start_over(struct fault_line *line, size_t n);
/* The same for a word of the language; true when it is there. */
bool fault_want(struct fault_line *line, size_t n, const char *word);
/* "WHAT; expected X, Y or Z" */
void fault_line_tell(const struct fault_line *line, char *text, size_t size);

/* Values of word n; false: it is none. */
bool fault_number(const struct fault_line *line, size_t n, uint64_t most, uint64_t *value);
bool fault_signed(const struct fault_line *line, size_t n, int64_t *value);
bool fault_time(const struct fault_line *line, size_t n, uint64_t *ns);
/* Decimal with a sign if `negative`, as an integer of 1 / 10^decimals. */
bool fault_decimal(const char *text, size_t length, unsigned decimals, bool negative,
                   int64_t *value);

/* fault_arguments.c: takes the argument `name` of a grammar at word *n, which moves on. False: it
 * is none, and noted. */
bool fault_argument(struct fault_line *line, size_t *n, const char *name,
                    struct fault_action *action);

#endif
