/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "conformance/archive_parts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_MOST ((size_t)64 << 20)

char *archive_read(const char *folder, const char *name, size_t *size, char why[CHECK_WHY])
{
    char path[ARCHIVE_PATH];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        snprintf(why, CHECK_WHY, "'%.900s': %s", path, strerror(errno));
        return NULL;
    }
    size_t room = 65536, used = 0;
    char *bytes = malloc(room + 1);
    while (bytes != NULL) {
        used += fread(bytes + used, 1, room - used, file);
        if (used < room || room >= FILE_MOST)
            break;
        char *more = realloc(bytes, 2 * room + 1);
        if (more == NULL) {
            free(bytes);
            bytes = NULL;
        } else {
            bytes = more;
            room *= 2;
        }
    }
    const bool bad = ferror(file) != 0 || used >= FILE_MOST;
    fclose(file);
    if (bytes == NULL || bad) {
        free(bytes);
        snprintf(why, CHECK_WHY, "'%.900s' cannot be read", path);
        return NULL;
    }
    bytes[used] = '\0';
    *size = used;
    return bytes;
}
