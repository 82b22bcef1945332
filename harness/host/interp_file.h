/* SPDX-License-Identifier: GPL-2.0-or-later */
/* interp_file.h - a path for an interpolator as a text (docs/path-files.md). */
#ifndef HARNESS_HOST_INTERP_FILE_H
#define HARNESS_HOST_INTERP_FILE_H

#include "host/interp_path.h"

#define INTERP_FILE_WHY 512

/* How many parts the text can have at most. */
size_t interp_file_parts(const char *text, size_t length);

/* Reads into a path that was initialised. 0, or -EINVAL with "NAME:LINE:COLUMN: what; expected ..."
 */
int interp_file_read(struct interp_path *path, const char *text, size_t length, const char *name,
                     char why[INTERP_FILE_WHY]);

#endif
