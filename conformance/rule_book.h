/* SPDX-License-Identifier: GPL-2.0-or-later */
/* rule_book.h - which rule book it is: a hash of what rules, experiments and profiles are in it. */
#ifndef CONFORMANCE_RULE_BOOK_H
#define CONFORMANCE_RULE_BOOK_H

/* SHA-256 as lower-case hexadecimal. It changes with every line of rules.def, experiments.def and
 * profiles/; what judges by them is the program, which has a hash of its own. */
#define RULE_BOOK_HASH 65
void rule_book_hash(char hash[RULE_BOOK_HASH]);

#endif
