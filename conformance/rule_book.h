/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * rule_book.h - which rule book it is: what is judged and under which conditions, as text, and the
 * hash of that text.
 *
 * In it are, a line each: every rule with its severity, its experiments and what must hold; every
 * profile with its formats, exports, sizes, periods and budgets; every experiment as it is planned
 * for the profile, with the hash of its fault script. How advice is worded is not in it. What
 * judges by it is the program, which has a hash of its own.
 */
#ifndef CONFORMANCE_RULE_BOOK_H
#define CONFORMANCE_RULE_BOOK_H

#include <stdio.h>

void rule_book_write(FILE *out);

/* SHA-256 of what rule_book_write() writes, as lower-case hexadecimal. */
#define RULE_BOOK_HASH 65
void rule_book_hash(char hash[RULE_BOOK_HASH]);

#endif
