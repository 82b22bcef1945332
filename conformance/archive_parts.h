/* SPDX-License-Identifier: GPL-2.0-or-later */
/* archive_parts.h - shared by archive_save.c and archive_open.c. */
#ifndef CONFORMANCE_ARCHIVE_PARTS_H
#define CONFORMANCE_ARCHIVE_PARTS_H

#include <string.h>

#include "conformance/archive.h"

#define ARCHIVE_PATH     4352
#define ARCHIVE_MANIFEST "manifest.json"

/* Of the copy of the module: it ends as the module does where the ending says what a file is. */
static inline const char *archive_module_name(const char *path)
{
    static const char *const names[] = { "module.bin", "module.tgm_controller",
                                         "module.tgz_motion" };
    const size_t stem = strlen("module"), length = path != NULL ? strlen(path) : 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const char *ending = names[i] + stem;
        if (length > strlen(ending) && strcmp(path + length - strlen(ending), ending) == 0)
            return names[i];
    }
    return "module";
}

/* Of the file names in it. */
static inline void archive_scenario_name(size_t index, const char *ending, char name[64])
{
    snprintf(name, 64, "scenario-%zu.%s", index + 1, ending);
}

#endif
