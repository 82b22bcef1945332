/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * evidence_file.h - what became of an experiment, as bytes for a file, and back.
 *
 * The form does not depend on how a compiler lays structures out: members one after the other as
 * evidence_rows.c lists them, little-endian, without padding, long rows of zeros as their number.
 * It begins with a magic word, the number of the form and a hash of the list of members: what
 * another version of the program wrote is refused, not misread. Reading takes any bytes; what comes
 * out is clean (evidence_clean).
 */
#ifndef HARNESS_HOST_EVIDENCE_FILE_H
#define HARNESS_HOST_EVIDENCE_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "host/experiment.h"

#define EVIDENCE_WHY 256

/* One member of a structure: `count` values of `size` bytes (1, 2, 4 or 8), or of structures. */
struct evidence_row {
    const char *name; /* NULL: the end of the list */
    size_t offset, size, count;
    const struct evidence_row *of; /* NULL: plain values */
};

/* Of struct experiment_result. */
extern const struct evidence_row evidence_result_rows[];

/* Any structure, by its rows. 0 with *bytes (to be freed) and *size, or -ENOMEM. */
int rows_encode(const struct evidence_row *rows, const void *from, uint8_t **bytes, size_t *size);
/* 0, or -EINVAL with the reason. What is in no row of `to` is left as it is. */
int rows_decode(const struct evidence_row *rows, void *to, const uint8_t *bytes, size_t size,
                char why[EVIDENCE_WHY]);

/* 0 with *bytes (to be freed) and *size, or -ENOMEM. */
int evidence_encode(const struct experiment_result *result, uint8_t **bytes, size_t *size);
/* 0, or -EINVAL with the reason: other bytes, another form, too short, too long. */
int evidence_decode(struct experiment_result *result, const uint8_t *bytes, size_t size,
                    char why[EVIDENCE_WHY]);

#endif
