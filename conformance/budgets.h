/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * budgets.h - what a call of a function may take and what it took, in microseconds of the product's
 * processor (decision H10), and the report's table of it.
 */
#ifndef CONFORMANCE_BUDGETS_H
#define CONFORMANCE_BUDGETS_H

#include "conformance/rules.h"

#define BUDGETS_MOST 7

/* 0: no document gives a figure, or the function is not called in the experiment. */
double budget_allowed_us(const struct experiment *experiment, enum entry entry);
/* 0: the product has no rate. */
double budget_us(const struct experiment *experiment, uint64_t instructions);

/* Fills the table: functions with a budget, each at the Cycle_Time at which it is tightest, and the
 * stack. Number of lines; none when no run was traced. */
size_t budgets_report(const struct case_file *file, struct budget_report out[BUDGETS_MOST]);

#endif
