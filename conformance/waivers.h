/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * waivers.h - failures that somebody answers for: rule, until when, who, why.
 *
 * A text file, one waiver a line; '#' begins a comment line:
 *
 *   budget-program-04 until 2027-03-31 by jana@example.com: runs alone on its controller
 *
 * A waiver covers every failure of its rule, up to and including the day. One that is out of date
 * fails the module, needed or not: it is to be renewed or taken away.
 */
#ifndef CONFORMANCE_WAIVERS_H
#define CONFORMANCE_WAIVERS_H

#include <stdbool.h>
#include <stddef.h>

#define WAIVERS_MOST 64
#define WAIVERS_FILE 65536 /* bytes of such a file, at most */
#define WAIVERS_WHY  512

struct waiver {
    char rule[64], expiry[16], owner[96], reason[256];
};

struct waivers {
    size_t count;
    struct waiver list[WAIVERS_MOST];
};

/* 0, or -EINVAL with "name:line: what is wrong" in why: an unknown rule, no such day, two for one
 * rule. */
int waivers_read(struct waivers *waivers, const char *text, size_t length, const char *name,
                 char why[WAIVERS_WHY]);
/* The day ("2026-11-27") is over for it. */
bool waiver_expired(const struct waiver *waiver, const char *today);

#endif
