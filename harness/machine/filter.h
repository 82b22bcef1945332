/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * filter.h - system call filters from tables.
 *
 * libseccomp cannot ask where a system call was made from, and that question is the point of ours;
 * so the classic BPF program is put together here. Rules are tried in order, the first that fits
 * decides.
 */
#ifndef HARNESS_MACHINE_FILTER_H
#define HARNESS_MACHINE_FILTER_H

#include <linux/filter.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FILTER_CODE 1024

struct filter {
    struct sock_filter code[FILTER_CODE];
    unsigned length;
    bool too_long;
};

/* (argument & mask) compared with value. Rows of a table may name a run-time value: see
 * filter_rule. */
struct filter_condition {
    uint8_t argument;
    bool differs; /* fits when not equal */
    uint64_t mask;
    uint64_t value;
};

#define FILTER_CONDITIONS 3

struct filter_rule {
    int number;      /* system call */
    uint32_t action; /* SECCOMP_RET_... */
    unsigned count;
    struct filter_condition conditions[FILTER_CONDITIONS];
};

/* Begins with: calls that do not come through the 64-bit entry (int 0x80, x32) meet foreign. */
void filter_begin(struct filter *filter, uint32_t foreign);

/* Calls whose instruction pointer lies in [begin, end] meet action. Both must have the same upper
 * 32 bits. */
void filter_range(struct filter *filter, uint64_t begin, uint64_t end, uint32_t action);
void filter_rule(struct filter *filter, const struct filter_rule *rule);
void filter_end(struct filter *filter, uint32_t action);

/* Applies to the calling thread, for ever, with no new privileges. 0 or negative errno. */
int filter_install(const struct filter *filter);

#endif
