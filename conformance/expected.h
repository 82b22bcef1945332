/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * expected.h - what is said of fixtures: the file `expected` beside a rule's modules.
 *
 *   bad.tgm
 *     Program_04 divided by zero|in cycle 19 at ...|at (Program_04) bad.c:10|Program_04|3| --seed
 *     not judged: the module fails without any disturbance, too|disturbed-returns
 *
 * After the name of a module, two spaces and a line for each finding of its rule, in their order:
 * what, when, where (without the address), function, how often, what is behind the rule's name in
 * the call that shows it again, where a debugger is to stop and how it is to run the module. Then a
 * line for each reason that something was not judged for, and which rules that were. A * stands for
 * any text: what a compiler may make otherwise.
 */
#ifndef CONFORMANCE_EXPECTED_H
#define CONFORMANCE_EXPECTED_H

#include <stdbool.h>
#include <stddef.h>

#define EXPECTED_WHY 512

/* A stretch of text. */
struct expected {
    const char *at;
    size_t left;
};

/* What is expected of the module: a part of the text. False when the text does not say. */
bool expected_find(struct expected text, const char *module, struct expected *out);
/* Whether these findings, a line each, are. False with the first that differs. */
bool expected_findings(struct expected expected, const char *findings, char why[EXPECTED_WHY]);
/* Whether the rule was not to be judged, for this reason; "" : it was to be. */
bool expected_reason(struct expected expected, const char *rule, const char *reason,
                     char why[EXPECTED_WHY]);
/* Whether the text is what the pattern says. */
bool expected_fits(const char *pattern, const char *text);

#endif
