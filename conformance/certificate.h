/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * certificate.h - that a module passed, as a signed statement that can be verified offline.
 *
 * The statement is an in-toto Statement (version 1) with a test-result predicate (version 0.1), in
 * a DSSE envelope. docs/certificates.md says what a signature means and what it does not.
 */
#ifndef CONFORMANCE_CERTIFICATE_H
#define CONFORMANCE_CERTIFICATE_H

#include "conformance/envelope.h"
#include "report/report.h"

#define CERTIFICATE_WHY   640
#define CERTIFICATE_NAME  256 /* of the module's file */
#define CERTIFICATE_TEXT  96
#define CERTIFICATE_HASH  65 /* SHA-256 as lower-case hexadecimal */
#define CERTIFICATE_RULES 512

struct certificate_rules {
    size_t count;
    char ids[CERTIFICATE_RULES][48];
};

struct certificate {
    char name[CERTIFICATE_NAME];    /* file name of the module, for people: the hash counts */
    char module[CERTIFICATE_HASH];  /* of all others, too: */
    char tool[CERTIFICATE_TEXT];    /* "tgm 0.1.0" */
    char program[CERTIFICATE_HASH]; /* the program that judged */
    char profile[CERTIFICATE_TEXT]; /* "cert-1/pc4" */
    char rule_book[CERTIFICATE_HASH];
    char evidence[CERTIFICATE_HASH]; /* manifest of the saved evidence */
    struct certificate_rules passed;
    struct certificate_rules warned; /* "should" and "note" rules that failed or were not judged */
};

/* What a report says that was made as `suite` ("cert-1") demands, by the program with that hash;
 * false with a sentence in why when it is nothing to sign: no PASS, waivers, a selection of rules,
 * evidence that was not saved. */
bool certificate_fill(struct certificate *certificate, const struct report *report,
                      const char *suite, const char *program, char why[CERTIFICATE_WHY]);

/* The signed text, to be freed; NULL when there is no memory. */
char *certificate_sign(const struct certificate *certificate, const struct secret_key *key);

/* 0, or -EINVAL with a sentence in why: the text, which may be anything, is not to the last byte a
 * certificate that the key has signed. */
int certificate_open(struct certificate *certificate, const char *text, size_t size,
                     const struct public_key *key, char why[CERTIFICATE_WHY]);

#endif
