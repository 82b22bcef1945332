/* SPDX-License-Identifier: GPL-2.0-or-later */
/* archive_parts.h - shared by archive_save.c, archive_open.c and archive_read.c. */
#ifndef CONFORMANCE_ARCHIVE_PARTS_H
#define CONFORMANCE_ARCHIVE_PARTS_H

#include <string.h>

#include "conformance/archive.h"

#define ARCHIVE_PATH      4352
#define ARCHIVE_MANIFEST  "manifest.json"
#define ARCHIVE_SCENARIOS 32

/* What the copy of the module may be called: a flat image is told by how its name ends. */
static const char *const archive_modules[] = { "module.bin", "module.tgm_controller",
                                               "module.tgz_motion", "module" };
enum { ARCHIVE_MODULES = sizeof archive_modules / sizeof archive_modules[0] };

/* What it is called for a module of that path; NULL: none. */
static inline const char *archive_module_name(const char *path)
{
    const size_t length = path != NULL ? strlen(path) : 0;
    for (size_t i = 0; i + 1 < ARCHIVE_MODULES; i++) {
        const char *ending = archive_modules[i] + strlen("module");
        if (length > strlen(ending) && strcmp(path + length - strlen(ending), ending) == 0)
            return archive_modules[i];
    }
    return archive_modules[ARCHIVE_MODULES - 1];
}

/* Of the file names in it. */
static inline void archive_scenario_name(size_t index, const char *ending, char name[64])
{
    snprintf(name, 64, "scenario-%zu.%s", index + 1, ending);
}

/* A whole file of the folder, with a zero behind it; to be freed. NULL with the reason. */
char *archive_read(const char *folder, const char *name, size_t *size, char why[CHECK_WHY]);

#endif
