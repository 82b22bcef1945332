/* SPDX-License-Identifier: GPL-2.0-or-later */
/* json_text.h - strings and numbers of a report as JSON. */
#ifndef HARNESS_REPORT_JSON_TEXT_H
#define HARNESS_REPORT_JSON_TEXT_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

/* Paths may hold any bytes, JSON holds UTF-8 only: what is no UTF-8 becomes U+FFFD. NULL: null. */
json_t *json_text(const char *value);

/* "0x1d2f" */
json_t *json_hex(uint64_t value);

/* Writes the document, two spaces a level, a line end behind it; takes it. 0 or negative errno. */
int json_document(json_t *root, FILE *stream);

#endif
