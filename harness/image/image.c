/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image.c - gets the bytes, hashes them, finds out what they are; what the bytes mean is elf*.c,
 * pe*.c and flat.c.
 */
#include "image/image_private.h"
#include "image/sha256.h"

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAX_FILE   ((size_t)1 << 30)
#define TEXT_PROBE 4096u

bool image_defect(struct image *image, const char *format, ...)
{
    if (image->defect[0] != '\0')
        return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(image->defect, sizeof image->defect, format, arguments);
    va_end(arguments);
    /* A symbol name may hold terminal escapes or line breaks. */
    for (char *c = image->defect; *c != '\0'; c++) {
        if ((unsigned char)*c < 0x20 || (unsigned char)*c > 0x7e)
            *c = '?';
    }
    return false;
}

bool image_make_room(void *array_pointer, size_t count, size_t item_size)
{
    if (count != 0 && (count < 16 || (count & (count - 1)) != 0))
        return true;
    void *array;
    memcpy(&array, array_pointer, sizeof array);
    array = reallocarray(array, count == 0 ? 16 : 2 * count, item_size);
    if (array == NULL)
        return false;
    memcpy(array_pointer, &array, sizeof array);
    return true;
}

/* ---- reading ---- */

static int refuse(int error, char why[IMAGE_WHY], const char *path, const char *reason)
{
    snprintf(why, IMAGE_WHY, "%s: %s", path, reason);
    return -error;
}

static const char *file_type(mode_t mode)
{
    switch (mode & S_IFMT) {
    case S_IFIFO:
        return "is a FIFO, not a regular file";
    case S_IFCHR:
        return "is a character device, not a regular file";
    case S_IFBLK:
        return "is a block device, not a regular file";
    case S_IFSOCK:
        return "is a socket, not a regular file";
    default:
        return "is not a regular file";
    }
}

/* Reads up to size bytes; fewer only at the end of the file. Negative errno on failure. */
static ssize_t read_all(int fd, uint8_t *bytes, size_t size)
{
    size_t done = 0;
    while (done < size) {
        ssize_t got = read(fd, bytes + done, size - done);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return -errno;
        if (got == 0)
            break;
        done += (size_t)got;
    }
    return (ssize_t)done;
}

static int read_open_file(int fd, const char *path, uint8_t **bytes, size_t *size,
                          char why[IMAGE_WHY])
{
    struct stat status;
    if (fstat(fd, &status) != 0)
        return refuse(errno, why, path, strerror(errno));
    if (S_ISDIR(status.st_mode))
        return refuse(EISDIR, why, path, "is a directory");
    if (!S_ISREG(status.st_mode))
        return refuse(EINVAL, why, path, file_type(status.st_mode));
    if (status.st_size < 0 || (uintmax_t)status.st_size > MAX_FILE)
        return refuse(EFBIG, why, path, "is larger than 1 GiB");
    *size = (size_t)status.st_size;
    /* One byte more than there should be, to notice a file that is being written to. */
    *bytes = malloc(*size + 1);
    if (*bytes == NULL)
        return refuse(ENOMEM, why, path, "no memory to read it");
    ssize_t got = read_all(fd, *bytes, *size + 1);
    if (got < 0)
        return refuse((int)-got, why, path, strerror((int)-got));
    if ((size_t)got != *size)
        return refuse(EAGAIN, why, path, "changed while it was being read");
    return 0;
}

static int read_file(const char *path, uint8_t **bytes, size_t *size, char why[IMAGE_WHY])
{
    *bytes = NULL;
    /* O_NONBLOCK: opening a FIFO must not wait for its writer. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    if (fd < 0)
        return refuse(errno, why, path, strerror(errno));
    int error = read_open_file(fd, path, bytes, size, why);
    close(fd);
    if (error != 0) {
        free(*bytes);
        *bytes = NULL;
    }
    return error;
}

/* ---- what is it ---- */

static const struct {
    const char *magic;
    size_t size;
    const char *what;
} strangers[] = {
    { "!<arch>\n", 8, "a static library (ar archive), not a module: link it into one first" },
    { "!<thin>\n", 8, "a static library (thin archive), not a module: link it into one first" },
    { "BC\xC0\xDE", 4, "LLVM bitcode, not a module: compile and link it first" },
    { "\xCF\xFA\xED\xFE", 4, "a 64-bit Mach-O file (macOS), not a module for this platform" },
    { "\xCE\xFA\xED\xFE", 4, "a 32-bit Mach-O file (macOS), not a module for this platform" },
    { "PK\x03\x04", 4, "a ZIP archive, not a module" },
    { "\x1F\x8B", 2, "gzip-compressed data, not a module" },
    { "\xFD"
      "7zXZ",
      5, "xz-compressed data, not a module" },
};

static bool is_text(const uint8_t *bytes, size_t size)
{
    size_t probe = size < TEXT_PROBE ? size : TEXT_PROBE;
    size_t high = 0;
    if (size >= 2 &&
        ((bytes[0] == 0xff && bytes[1] == 0xfe) || (bytes[0] == 0xfe && bytes[1] == 0xff)))
        return true; /* UTF-16 with its mark */
    for (size_t i = 0; i < probe; i++) {
        if (bytes[i] >= 0x80)
            high++;
        else if (bytes[i] == 0x7f ||
                 (bytes[i] < 0x20 && strchr("\t\n\r\f\v\x1b", bytes[i]) == NULL) || bytes[i] == 0)
            return false;
    }
    return high <= probe / 3;
}

static bool known_stranger(struct image *image)
{
    for (size_t i = 0; i < sizeof strangers / sizeof strangers[0]; i++) {
        if (image->size >= strangers[i].size &&
            memcmp(image->bytes, strangers[i].magic, strangers[i].size) == 0) {
            image_defect(image, "this is %s", strangers[i].what);
            return true;
        }
    }
    if (!is_text(image->bytes, image->size))
        return false;
    image_defect(image, "this is text, not a module");
    return true;
}

static void describe_unknown(struct image *image)
{
    char start[3 * 4 + 1] = "";
    for (size_t i = 0; i < 4 && i < image->size; i++)
        snprintf(start + 3 * i, 4, " %02x", image->bytes[i]);
    image_defect(image,
                 "starts with the bytes%s; a module starts with 7f 45 4c 46 (ELF) or 4d 5a (PE)",
                 start);
}

static int describe(struct image *image)
{
    if (image->size == 0) {
        image_defect(image, "the file is empty");
        return 0;
    }
    if (image->size >= 2 && memcmp(image->bytes, "MZ", 2) == 0)
        return pe_read(image);
    size_t magic = image->size < SELFMAG ? image->size : SELFMAG;
    if (memcmp(image->bytes, ELFMAG, magic) == 0)
        return elf_read(image);
    int error = 0;
    if (!known_stranger(image) && !flat_recognise(image, &error))
        describe_unknown(image);
    return error;
}

/* A file that lied once has no contents: nobody works with the half that looked fine. */
static void drop_contents(struct image *image)
{
    free(image->segments);
    free(image->symbols);
    free(image->imports);
    free(image->relocs);
    free(image->initialisers);
    image->segments = NULL;
    image->symbols = NULL;
    image->imports = NULL;
    image->relocs = NULL;
    image->initialisers = NULL;
    image->segment_count = image->symbol_count = image->import_count = 0;
    image->reloc_count = image->initialiser_count = 0;
    image->span_begin = image->span_end = image->align = 0;
    image->relro_begin = image->relro_end = 0;
    image->has_tls = image->exec_stack = image->exec_stack_stated = false;
    image->has_debug_lines = false;
    image->debug_file = NULL;
    image->tls_size = 0;
    image->base = image->entry_point = 0;
    image->fixed = image->has_entry_point = false;
    image_free_texts(image);
}

/* Takes over bytes in any case. */
static int open_bytes(struct image **out, const char *path, uint8_t *bytes, size_t size,
                      char why[IMAGE_WHY])
{
    struct image *image = calloc(1, sizeof *image);
    if (image == NULL) {
        free(bytes);
        return refuse(ENOMEM, why, path, "no memory");
    }
    image->bytes = bytes;
    image->size = size;
    image->format_name = "";
    image->target_name = "";
    image->path = strdup(path);
    image->lines = lines_new();
    image->routines = stack_new();
    int error =
        image->path == NULL || image->lines == NULL || image->routines == NULL ? -ENOMEM : 0;
    if (error == 0) {
        sha256_text(image->bytes, image->size, image->sha256);
        error = describe(image);
    }
    if (error != 0) {
        image_close(image);
        return refuse(-error, why, path, "no memory to describe it");
    }
    if (image->defect[0] != '\0')
        drop_contents(image);
    *out = image;
    return 0;
}

/* ---- the public side ---- */

int image_open(struct image **out, const char *path, char why[IMAGE_WHY])
{
    uint8_t *bytes;
    size_t size = 0;
    *out = NULL;
    why[0] = '\0';
    int error = read_file(path, &bytes, &size, why);
    return error != 0 ? error : open_bytes(out, path, bytes, size, why);
}

int image_open_memory(struct image **out, const char *path, const void *bytes, size_t size,
                      char why[IMAGE_WHY])
{
    *out = NULL;
    why[0] = '\0';
    if (size > MAX_FILE)
        return refuse(EFBIG, why, path, "is larger than 1 GiB");
    uint8_t *copy = malloc(size != 0 ? size : 1); /* no spare byte to over-read unnoticed */
    if (copy == NULL)
        return refuse(ENOMEM, why, path, "no memory to copy it");
    if (size != 0)
        memcpy(copy, bytes, size);
    return open_bytes(out, path, copy, size, why);
}

void image_close(struct image *image)
{
    if (image == NULL)
        return;
    drop_contents(image);
    lines_free(image->lines);
    stack_free(image->routines);
    free(image->path);
    free(image->bytes);
    free(image);
}

const struct image_symbol *image_export(const struct image *image, const char *name)
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        if (image->symbols[i].exported && strcmp(image->symbols[i].name, name) == 0)
            return &image->symbols[i];
    }
    return NULL;
}

const struct image_segment *image_segment_at(const struct image *image, uint64_t vaddr,
                                             uint64_t size)
{
    size_t low = 0, high = image->segment_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (image->segments[middle].vaddr <= vaddr)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0)
        return NULL;
    const struct image_segment *segment = &image->segments[low - 1];
    uint64_t offset = vaddr - segment->vaddr;
    bool inside = offset < segment->mem_size && size <= segment->mem_size - offset;
    return inside ? segment : NULL;
}

bool image_file_range(const struct image *image, uint64_t vaddr, uint64_t size, uint64_t *offset)
{
    const struct image_segment *segment = image_segment_at(image, vaddr, size);
    if (segment == NULL || size == 0)
        return false;
    uint64_t inside = vaddr - segment->vaddr;
    if (inside >= segment->file_size || size > segment->file_size - inside)
        return false;
    *offset = segment->file_offset + inside;
    return true;
}

uint64_t image_word(const struct image *image, uint64_t vaddr, unsigned width)
{
    uint64_t word = 0, offset;
    for (unsigned i = 0; i < width; i++) {
        if (image_file_range(image, vaddr + i, 1, &offset))
            word |= (uint64_t)image->bytes[offset] << (8 * i);
    }
    return word;
}
