/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * scan.h - reading the project's own line-based files: one statement a line, words apart by blanks,
 * text in double quotes, # starts a comment. Every complaint says file, line, column, what is wrong
 * and what was expected.
 */
#ifndef HARNESS_BUS_SCAN_H
#define HARNESS_BUS_SCAN_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCAN_WHY    512
#define SCAN_LINE   1024 /* characters in a line */
#define SCAN_TOKENS 64   /* words in a line */
#define SCAN_FILE   (1024 * 1024)

struct place {
    unsigned line, column; /* from 1; column 0: not known */
};

struct scan_token {
    const char *text; /* ends with NUL; quotes and escapes are gone */
    unsigned column;
    bool quoted;
};

struct scan {
    const char *file; /* as it appears in messages */
    const char *at, *end;
    unsigned line;
    bool indented; /* the line starts with blanks */
    struct scan_token token[SCAN_TOKENS];
    unsigned count, next;
    char chars[SCAN_LINE + SCAN_TOKENS + 1];
    unsigned line_end; /* column behind the last word */
    bool failed;
    char *why; /* SCAN_WHY characters */
};

/* `text` (length bytes, need not end with NUL) stays the caller's. */
void scan_init(struct scan *scan, const char *file, const char *text, size_t length,
               char why[SCAN_WHY]);
/* The next line that has words; false at the end or when something failed. */
bool scan_line(struct scan *scan);
bool scan_more(const struct scan *scan);
/* Where the next word of the line stands. */
struct place scan_place(const struct scan *scan);
struct place scan_start(const struct scan *scan);

/* All of these return false, and set failed and why, when the next word is not what was asked for;
 * `what` names it ("a vendor id"). */
bool scan_word(struct scan *scan, const char *what, const char **word);
bool scan_text(struct scan *scan, const char *what, const char **text);
bool scan_number(struct scan *scan, const char *what, int64_t least, int64_t most, int64_t *value);
/* 0x6000:1A: both hexadecimal, as manuals write them. */
bool scan_object(struct scan *scan, const char *what, uint16_t *index, uint8_t *subindex);
/* -5..100 */
bool scan_range(struct scan *scan, int64_t *least, int64_t *most);
/* 400ms, 2s, 250us, 10ns; at most an hour. */
bool scan_duration(struct scan *scan, const char *what, uint64_t *ns);
/* One of `words`: its number. */
bool scan_choice(struct scan *scan, const char *what, const char *const *words, size_t count,
                 unsigned *choice);
bool scan_end(struct scan *scan);

/* Takes the next word if it is this one. */
bool scan_is(struct scan *scan, const char *word);

/* Complaints; both return false. At the word that was taken last, or at `place`. */
bool scan_fail(struct scan *scan, const char *format, ...) __attribute__((format(printf, 2, 3)));
bool scan_fail_at(struct scan *scan, struct place place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* "file:line:column: ..."; returns -EINVAL. */
int why_at(char why[SCAN_WHY], const char *file, struct place place, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
int why_at_v(char why[SCAN_WHY], const char *file, struct place place, const char *format,
             va_list arguments);

/* The word closest to `word`, NULL when none is close. */
const char *scan_nearest(const char *word, const char *const *words, size_t count);

/* The whole of a file of at most `most` bytes, to be freed; NULL with the reason in `why`. */
char *scan_read_file(const char *path, size_t most, size_t *length, int *error, char why[SCAN_WHY]);

#endif
