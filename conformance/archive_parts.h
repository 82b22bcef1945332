/* SPDX-License-Identifier: GPL-2.0-or-later */
/* archive_parts.h - shared by archive_save.c, archive_open.c and archive_read.c. */
#ifndef CONFORMANCE_ARCHIVE_PARTS_H
#define CONFORMANCE_ARCHIVE_PARTS_H

#include "conformance/archive.h"

#define ARCHIVE_PATH      4352
#define ARCHIVE_MANIFEST  "manifest.json"
#define ARCHIVE_MODULE    "module"
#define ARCHIVE_BIN       "module.bin" /* a flat image is told by its name */
#define ARCHIVE_SCENARIOS 32

/* Of the file names in it. */
static inline void archive_scenario_name(size_t index, const char *ending, char name[64])
{
    snprintf(name, 64, "scenario-%zu.%s", index + 1, ending);
}

/* A whole file of the folder, with a zero behind it; to be freed. NULL with the reason. */
char *archive_read(const char *folder, const char *name, size_t *size, char why[CHECK_WHY]);

#endif
