/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "cli/path.h"

#include <stdlib.h>
#include <string.h>

#include "host/interp_file.h"

int path_open(struct interp_path *path, const struct command *command, const char *file)
{
    char why[INTERP_FILE_WHY] = "no memory";
    char *text = read_text(command, "path", file);
    if (text == NULL)
        return EXIT_CALL;
    const size_t length = strlen(text), capacity = interp_file_parts(text, length);
    interp_path_init(path, calloc(capacity, sizeof *path->parts), capacity);
    const bool good = path->parts != NULL && interp_file_read(path, text, length, file, why) == 0;
    free(text);
    if (good)
        return 0;
    path_close(path);
    return complain(command, "%s", why);
}

void path_close(struct interp_path *path)
{
    free(path->parts);
    path->parts = NULL;
}
