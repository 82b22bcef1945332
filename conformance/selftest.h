/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * selftest.h - the rule book proves itself: each bad fixture of a rule trips exactly that rule,
 * each good one none.
 *
 * The fixtures are modules that were built with the program: FOLDER/RULE/bad*.tgm and good*.tgm
 * (.tgm.bin: flat images), and bad-x.scenario or, for all of them, machine.scenario where the rule
 * needs one. A rule without both kinds is not proven. FOLDER/RULE/expected has what is said of each
 * bad one (expected.h).
 *
 * What the modules did can be kept and judged again: a rule is changed, and all fixtures tell in
 * seconds what that did.
 */
#ifndef CONFORMANCE_SELFTEST_H
#define CONFORMANCE_SELFTEST_H

#include <stdbool.h>
#include <stddef.h>

#include "conformance/rules.h"

#define SELFTEST_WHY 1024

/* One module and what became of it. */
struct selftest_fixture {
    const struct rule *rule;
    char path[1024];
    char name[96]; /* of the file */
    bool bad;
    bool right;
    bool tried;
    char *findings; /* of its rule, a line each (expected.h); NULL: not judged by it */
    char *reasons;  /* why rules did not judge it, a line each; NULL: it could not be tried */
    char why[SELFTEST_WHY]; /* what was wrong: "tripped returns, too"; "" when nothing was */
};

struct selftest {
    struct selftest_fixture *fixtures; /* in the order of the rules, then of the names */
    size_t count;
    size_t wrong;    /* of them */
    size_t tried;    /* of them: all, unless the first wrong one was the end */
    size_t rules;    /* that were to be proven */
    size_t unproven; /* of them without a bad or without a good fixture */
};

/* How a rule stands. */
struct selftest_tally {
    size_t bad, bad_right, good, good_right;
};

struct selftest_options {
    const char *folder;
    const char *rules; /* as in check_options; NULL: all */
    unsigned jobs;     /* 0: one for each core */
    bool first_only; /* judges by the fixture's own rule alone, not all: quicker, and proves less */
    const char *judges;        /* by these rules alone, as in check_options; NULL: all */
    const char *evidence;      /* folder that what each module did is kept in; NULL: none */
    const char *from_evidence; /* such a folder: nothing is run; NULL: everything is */
    bool first_wrong;          /* what comes after the first fixture that is wrong is left out */
};

/* 0 with *out to be freed by selftest_free(), or negative errno with a sentence in why. */
int selftest_run(struct selftest *out, const struct selftest_options *options,
                 char why[SELFTEST_WHY]);
void selftest_tally(const struct selftest *test, const struct rule *rule,
                    struct selftest_tally *tally);
bool selftest_proves(const struct selftest_tally *tally);
void selftest_free(struct selftest *test);

#endif
