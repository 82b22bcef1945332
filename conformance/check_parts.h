/* SPDX-License-Identifier: GPL-2.0-or-later */
/* check_parts.h - what the files behind check.h share among themselves; nobody else includes it. */
#ifndef CONFORMANCE_CHECK_PARTS_H
#define CONFORMANCE_CHECK_PARTS_H

#include "conformance/budgets.h"
#include "conformance/check.h"
#include "conformance/chronicle.h"
#include "conformance/rule_book.h"

struct check {
    struct image *image;
    struct report report;
    struct rule_report *rules;
    const struct rule **chosen; /* by index of report.rules */
    struct findings *findings;  /* by index of report.rules */
    struct group_report groups[GROUP_COUNT];
    struct case_run *runs; /* by enum experiment_id */
    struct case_scenario *scenarios;
    struct budget_report budgets[BUDGETS_MOST];
    struct chronicle chronicle;
    struct waiver_report waivers[WAIVERS_MOST];
    struct archive *archive; /* that it was made from; NULL: it was run */
    char hash[65];           /* of the manifest of the evidence; "" when none was saved */
    char today[16];
    char title[96];
    char rule_book[RULE_BOOK_HASH];
    char cannot_run[FINDING_TEXT];
    bool sparing; /* the rules and the verdict are wanted, nothing else of the report */
};

/*
 * runs.c: runs each experiment of the set that is for this product, several at a time; the results
 * are the same and in the same place however many. 0, or negative errno with a reason.
 */
int check_run_experiments(struct check *check, const struct check_options *options, uint64_t wanted,
                          char why[CHECK_WHY]);
int check_run_scenarios(struct check *check, const struct check_options *options,
                        char why[CHECK_WHY]);

/* judge.c: findings, outcomes and verdict from what was run. 0 or -ENOMEM. */
int check_judge(struct check *check, const struct check_options *options);

/* again.c: the line that shows a finding again, and the one for gdb, if there is one. */
void check_add_reproduction(const struct check_options *options, const struct image *image,
                            const struct rule *rule, struct finding *finding);

#endif
