/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * expected.h - what the findings of fixtures must say: the file `expected` beside a rule's modules.
 *
 *   bad.tgm
 *     Program_04 wrote MAIN.Life_Tick (read-only)|in cycle 0 at ...|(Program_04) bad.c:9|Program_04|60
 *
 * After the name of a module, two spaces and a line for each of its findings, in their order: what,
 * when, where (without the address), function, how often. A * stands for any text: for what a
 * compiler may make otherwise.
 */
#ifndef CONFORMANCE_EXPECTED_H
#define CONFORMANCE_EXPECTED_H

#include <stdbool.h>

#define EXPECTED_WHY 512

/*
 * Whether the findings, a line each, are what the file expects of the module. False with the reason:
 * the first line that differs, or that nothing is expected of it. Where there is no such file
 * everything is.
 */
bool expected_are(const char *path, const char *module, const char *findings,
                  char why[EXPECTED_WHY]);

/* Whether the text is what the pattern says; * is any text. */
bool expected_fits(const char *pattern, const char *text);

#endif
