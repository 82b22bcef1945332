/* SPDX-License-Identifier: GPL-2.0-or-later */
/* archive_parts.h - shared by archive_save.c and archive_open.c. */
#ifndef CONFORMANCE_ARCHIVE_PARTS_H
#define CONFORMANCE_ARCHIVE_PARTS_H

#include "conformance/archive.h"

#define ARCHIVE_PATH     4352
#define ARCHIVE_MANIFEST "manifest.json"
#define ARCHIVE_MODULE   "module"
#define ARCHIVE_BIN      "module.bin" /* a flat image is told by its name */

/* Of the file names in it. */
static inline void archive_scenario_name(size_t index, const char *ending, char name[64])
{
    snprintf(name, 64, "scenario-%zu.%s", index + 1, ending);
}

#endif
