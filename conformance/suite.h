/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * suite.h - what is done for a certificate, and nothing else: frozen sets of all that a check can
 * be told. A certificate names its suite; who reads it knows what was not left out.
 *
 * A suite that certificates were issued for does not change. What should be done differently is a
 * new one: another row in suite.c, another file in suites/.
 */
#ifndef CONFORMANCE_SUITE_H
#define CONFORMANCE_SUITE_H

#include "conformance/check.h"

struct suite {
    const char *name; /* "cert-1" */
    uint64_t seed;
    bool instrumented; /* wherever its rules decide the verdict, module code never runs on the
                          processor that judges it */
};

/* NULL past the end; the last one is what `tgm certify` uses. */
const struct suite *suite_at(size_t index);
const struct suite *suite_latest(void);

/* Seed, machine and rule book as text: conformance/suites/NAME.txt of the last one, which a test
 * holds against this. Who changes a rule decides there whether certificates still mean the same. */
void suite_write(const struct suite *suite, FILE *out);

/* Sets everything but what the module, the product and this computer are: path, shown, tool,
 * profile, jobs. */
void suite_apply(const struct suite *suite, struct check_options *options);

#endif
