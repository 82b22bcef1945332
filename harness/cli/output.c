/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/cli.h"

#define TEXT_MAX 1048576 /* bytes of a text file that is read whole */

/* Devices and pipes are written in place: there is nothing to replace. */
static bool written_in_place(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && !S_ISREG(s.st_mode);
}

bool same_file(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

int output_open(struct output *output, const char *path)
{
    memset(output, 0, sizeof *output);
    output->path = strdup(path);
    if (output->path == NULL)
        return -ENOMEM;
    if (strcmp(path, "-") == 0) {
        output->stream = stdout;
        return 0;
    }
    int fd = -1;
    if (written_in_place(path)) {
        output->stream = fopen(path, "w");
    } else {
        const size_t size = strlen(path) + 8;
        output->temporary = malloc(size);
        if (output->temporary != NULL) {
            snprintf(output->temporary, size, "%s.XXXXXX", path);
            fd = mkstemp(output->temporary);
            const mode_t mask = umask(0);
            umask(mask);
            if (fd >= 0 && fchmod(fd, 0666 & ~mask) == 0)
                output->stream = fdopen(fd, "w");
        }
    }
    if (output->stream != NULL)
        return 0;
    const int error = errno != 0 ? -errno : -EIO;
    if (fd >= 0) {
        close(fd);
        unlink(output->temporary);
    }
    free(output->temporary);
    free(output->path);
    return error;
}

int output_close(struct output *output, bool keep)
{
    int r = 0;
    if (output->stream == NULL)
        return 0;
    if (fflush(output->stream) != 0 || ferror(output->stream))
        r = -EIO;
    if (output->stream != stdout && fclose(output->stream) != 0 && r == 0)
        r = -errno;
    if (output->temporary != NULL) {
        if (r == 0 && keep && rename(output->temporary, output->path) != 0)
            r = -errno;
        if (r != 0 || !keep)
            unlink(output->temporary);
    }
    free(output->temporary);
    free(output->path);
    memset(output, 0, sizeof *output);
    return r;
}

/* The whole file as a string; NULL, and the reason said, when that is not possible. */
char *read_text(const struct command *command, const char *what, const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = malloc(TEXT_MAX + 1);
    size_t size = 0;
    int error = file == NULL ? errno : text == NULL ? ENOMEM : 0;
    if (error == 0) {
        errno = 0;
        size = fread(text, 1, TEXT_MAX + 1, file);
        error = ferror(file) ? (errno != 0 ? errno : EIO) : size > TEXT_MAX ? EFBIG : 0;
    }
    if (file != NULL)
        fclose(file);
    if (error == 0 && memchr(text, '\0', size) == NULL) {
        text[size] = '\0';
        return text;
    }
    complain(command, "cannot read %s '%s': %s", what, path,
             error != 0 ? strerror(error) : "it is no text");
    free(text);
    return NULL;
}
