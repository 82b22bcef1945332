/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * archive.h - evidence on disk: a folder from which the same verdict is derived again, with nothing
 * run.
 *
 *   manifest.json           what was asked for (module, profile, seed, rules, waivers ...), on which
 *                           machine each run was, and of every other file its size and SHA-256
 *   module                  the module that was judged, with the ending of a flat image: what has
 *                           no header is told by its name
 *   NAME.evidence           of an experiment of experiments.def (host/evidence_file.h)
 *   scenario-N.scenario, scenario-N.evidence
 *
 * Whoever opens one trusts nothing in it: file names are made here and not read, hashes and sizes
 * are compared, what another version wrote is refused. The SHA-256 of the manifest stands for all
 * of it.
 */
#ifndef CONFORMANCE_ARCHIVE_H
#define CONFORMANCE_ARCHIVE_H

#include "conformance/check_parts.h"

#define ARCHIVE_FORM "tgm-evidence/1"
#define ARCHIVE_HASH 65

/* Makes the folder if need be; one that holds anything but an archive is refused. 0, or negative
 * errno with the reason. */
int archive_prepare(const char *folder, char why[CHECK_WHY]);
/* The same; an older archive in it is replaced. */
int archive_save(const struct check *check, const struct check_options *options, const char *folder,
                 char hash[ARCHIVE_HASH], char why[CHECK_WHY]);

struct archive; /* owns what its options point to */

/* 0, or negative errno with the reason: no archive, another form, a file that is not what was
 * written. */
int archive_open(struct archive **out, const char *folder, char why[CHECK_WHY]);
void archive_close(struct archive *archive);
/* As they were when it was saved; path is that of the module in the archive, shown that of the one
 * that was judged. */
const struct check_options *archive_options(const struct archive *archive);
const char *archive_hash(const struct archive *archive);
/* Fills runs (of the experiments of the set) and scenarios of a check that has been planned with
 * these options. */
int archive_fill(const struct archive *archive, struct check *check, uint64_t wanted,
                 char why[CHECK_WHY]);

#endif
