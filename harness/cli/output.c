/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE 1
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
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

/* Where a link leads to, so that it stays a link, even when nothing is there yet; to be freed. */
static char *place_of(const char *path)
{
    char to[PATH_MAX], *place = realpath(path, NULL);
    const char *slash = strrchr(path, '/');
    const int folder = slash != NULL ? (int)(slash - path) + 1 : 0;
    const ssize_t length = place == NULL ? readlink(path, to, sizeof to - 1) : -1;
    if (place != NULL)
        return place;
    if (length <= 0)
        return strdup(path);
    to[length] = '\0';
    return asprintf(&place, "%.*s%s", to[0] == '/' ? 0 : folder, path, to) < 0 ? NULL : place;
}

/* A file without a name, which goes with this process however it ends. -1: there are none in that
 * folder. */
static int open_nameless(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash == NULL ? strdup(".") : strndup(path, (size_t)(slash - path) + 1);
    /* It gets its name by way of this folder. */
    const int fd = folder != NULL && access("/proc/self/fd", X_OK) == 0
                       ? open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666)
                       : -1;
    free(folder);
    return fd;
}

static int open_named(const struct output *output)
{
    const mode_t mask = umask(0);
    umask(mask);
    const int fd = mkstemp(output->temporary);
    if (fd >= 0 && fchmod(fd, 0666 & ~mask) != 0) {
        close(fd);
        unlink(output->temporary);
        return -1;
    }
    return fd;
}

/* 0, or negative errno. */
static int open_beside(struct output *output)
{
    const size_t size = strlen(output->path) + 8;
    output->temporary = malloc(size);
    if (output->temporary == NULL)
        return -ENOMEM;
    snprintf(output->temporary, size, "%s.XXXXXX", output->path);
    int fd = open_nameless(output->path);
    output->nameless = fd >= 0;
    if (fd < 0)
        fd = open_named(output);
    if (fd < 0)
        return -errno;
    output->stream = fdopen(fd, "w");
    if (output->stream != NULL)
        return 0;
    const int error = -errno;
    close(fd);
    if (!output->nameless)
        unlink(output->temporary);
    return error;
}

int output_open(struct output *output, const char *path)
{
    int r = 0;
    memset(output, 0, sizeof *output);
    output->path = place_of(path);
    if (output->path == NULL)
        return -ENOMEM;
    if (strcmp(path, "-") == 0) {
        output->stream = stdout;
        return 0;
    }
    if (written_in_place(path)) {
        output->stream = fopen(path, "w");
        r = output->stream == NULL ? -errno : 0;
    } else {
        r = open_beside(output);
    }
    if (r != 0) {
        free(output->temporary);
        free(output->path);
        memset(output, 0, sizeof *output);
    }
    return r;
}

void output_file(const struct output *output, char name[OUTPUT_FILE])
{
    if (output->nameless)
        snprintf(name, OUTPUT_FILE, "/proc/%ld/fd/%d", (long)getpid(), fileno(output->stream));
    else
        snprintf(name, OUTPUT_FILE, "%s",
                 output->temporary != NULL ? output->temporary : output->path);
}

/* Gives it a name, which rename() needs to put it over another file. */
static int name_it(struct output *output)
{
    char link[32];
    const int fd = fileno(output->stream);
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    /* A name that nobody has, which is then taken away again for the link to have. */
    const int taken = mkstemp(output->temporary);
    if (taken < 0)
        return -errno;
    close(taken);
    unlink(output->temporary);
    return linkat(AT_FDCWD, link, AT_FDCWD, output->temporary, AT_SYMLINK_FOLLOW) == 0 ? 0 : -errno;
}

int output_close(struct output *output, bool keep)
{
    int r = 0;
    if (output->stream == NULL)
        return 0;
    if (fflush(output->stream) != 0 || ferror(output->stream))
        r = -EIO;
    bool named = output->temporary != NULL && !output->nameless;
    if (output->nameless && keep && r == 0) {
        r = name_it(output);
        named = r == 0;
    }
    if (output->stream != stdout && fclose(output->stream) != 0 && r == 0)
        r = -errno;
    if (named && keep && r == 0 && rename(output->temporary, output->path) != 0)
        r = -errno;
    if (named && (r != 0 || !keep))
        unlink(output->temporary);
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
