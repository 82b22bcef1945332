/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * markup.h - text from outside, on its way into a report.
 *
 * Names in a hostile file may hold any bytes. Whatever they are, what is written is UTF-8 that can
 * end no attribute and begin no element, moves no cursor and turns no writing direction: bytes that
 * are no UTF-8, control characters and marks of direction are replaced.
 */
#ifndef HARNESS_REPORT_MARKUP_H
#define HARNESS_REPORT_MARKUP_H

#include <stdint.h>
#include <stdio.h>

#define MARKUP_REPLACEMENT 0xFFFD

/* The next character, *text moved past it; MARKUP_REPLACEMENT for a byte that begins none and for
 * what no report may hold. Not at the end of the text. */
uint32_t markup_next(const char **text);

/* For XML and HTML, as text or between double quotes. */
void markup_text(FILE *out, const char *text);

/* For a terminal: what may not be there becomes '?'. */
void markup_plain(FILE *out, const char *text);

/* For a URI: what is neither unreserved nor '/' is percent-encoded, byte by byte. */
void markup_uri(const char *text, char *out, size_t size);

#endif
