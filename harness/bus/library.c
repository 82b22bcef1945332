/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/library.h"
#include "bus/description.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define LIBRARY_TYPES 1024
#define ESI_FILE      (64 * 1024 * 1024)

struct library_type {
    struct terminal_type *type;
    char *file;
};

struct bus_library {
    size_t count;
    struct library_type types[LIBRARY_TYPES];
};

int library_open(struct bus_library **out)
{
    *out = calloc(1, sizeof **out);
    return *out ? 0 : -ENOMEM;
}

static void drop(struct bus_library *library, size_t count)
{
    while (library->count > count) {
        struct library_type *last = &library->types[--library->count];

        free(last->type);
        free(last->file);
    }
}

void library_close(struct bus_library *library)
{
    if (!library)
        return;
    drop(library, 0);
    free(library);
}

static const struct library_type *find(const struct bus_library *library, const char *name)
{
    for (size_t i = 0; library && i < library->count; i++) {
        if (strcmp(library->types[i].type->type.name, name) == 0)
            return &library->types[i];
    }
    return NULL;
}

const struct device_type *library_find(const struct bus_library *library, const char *name)
{
    const struct library_type *found = find(library, name);

    return found ? &found->type->type : device_type_find(name);
}

static int add(void *argument, const struct description *d, char why[LIBRARY_WHY])
{
    struct bus_library *library = argument;
    const struct library_type *other = find(library, d->type);
    struct library_type *to = &library->types[library->count];
    int error;

    if (other)
        return why_at(why, d->file, d->place,
                      "the type \"%s\" is defined already, by %.120s; expected another name",
                      d->type, other->file);
    if (library->count == LIBRARY_TYPES)
        return why_at(why, d->file, d->place, "too many types; expected at most %d", LIBRARY_TYPES);
    error = description_build(d, &to->type, why);
    if (error)
        return error;
    to->file = strdup(d->file);
    if (!to->file) {
        free(to->type);
        snprintf(why, LIBRARY_WHY, "%.200s: no memory", d->file);
        return -ENOMEM;
    }
    library->count++;
    return 0;
}

static int read_device_file(const char *path, description_taker *take, void *argument,
                            char why[LIBRARY_WHY])
{
    struct description *d;
    size_t length;
    int error = 0;
    char *text = scan_read_file(path, SCAN_FILE, &length, &error, why);

    if (!text)
        return error;
    d = description_new(path);
    if (!d) {
        snprintf(why, LIBRARY_WHY, "%.200s: no memory", path);
        error = -ENOMEM;
    }
    if (!error)
        error = device_file_read(d, text, length, why);
    if (!error)
        error = take(argument, d, why);
    free(d);
    free(text);
    return error;
}

/* Up to the "#" of "file.xml#EL1008", if there is one behind ".xml". */
static const char *esi_suffix(const char *path)
{
    const char *end = path + strlen(path), *dot;

    for (dot = strstr(path, ".xml"); dot; dot = strstr(dot + 1, ".xml")) {
        if (dot + 4 == end || dot[4] == '#')
            return dot + 4;
    }
    return NULL;
}

static int read_source(const char *source, description_taker *take, void *argument,
                       char why[LIBRARY_WHY])
{
    const char *suffix = esi_suffix(source);
    char *path, *text = NULL;
    size_t length;
    int error = 0;

    if (!suffix)
        return read_device_file(source, take, argument, why);
    path = strndup(source, (size_t)(suffix - source));
    if (!path) {
        snprintf(why, LIBRARY_WHY, "%.200s: no memory", source);
        return -ENOMEM;
    }
    text = scan_read_file(path, ESI_FILE, &length, &error, why);
    if (text)
        error = esi_read(path, text, length, *suffix ? suffix + 1 : NULL, take, argument, why);
    free(text);
    free(path);
    return error;
}

int library_load(struct bus_library *library, const char *path, char why[LIBRARY_WHY])
{
    size_t before = library->count;
    int error;

    why[0] = '\0';
    error = read_source(path, add, library, why);
    if (error)
        drop(library, before);
    return error;
}

size_t library_file_types(const struct bus_library *library)
{
    return library ? library->count : 0;
}

static unsigned default_bits(const struct sii_pdo *pdo, unsigned count)
{
    unsigned bits = 0;

    for (unsigned i = 0; i < count; i++) {
        for (unsigned k = 0; pdo[i].sm != 0xff && k < pdo[i].entry_count; k++)
            bits += pdo[i].entries[k].bits;
    }
    return bits;
}

int library_get(const struct bus_library *library, size_t index, struct library_entry *entry)
{
    size_t files = library_file_types(library);
    const struct device_type *type =
        index < files ? &library->types[index].type->type : device_type(index - files);

    if (!type)
        return 0;
    *entry =
        (struct library_entry){ .name = type->name,
                                .description = type->description,
                                .file = index < files ? library->types[index].file : NULL,
                                .device_name = type->sii->name,
                                .order = type->sii->order,
                                .vendor = type->sii->vendor,
                                .product = type->sii->product,
                                .revision = type->sii->revision,
                                .output_bits = default_bits(type->sii->rx, type->sii->rx_count),
                                .input_bits = default_bits(type->sii->tx, type->sii->tx_count),
                                .inputs = type->input_count,
                                .mailbox = type->sii->mailbox.out_size,
                                .objects = type->od ? (unsigned)type->od->count : 0 };
    if (terminal_is(type))
        entry->outputs = ((const struct terminal_type *)type->model)->output_count;
    return 1;
}

struct conversion {
    FILE *stream;
    unsigned count;
    char first[DESC_NAME + 1];
};

/* One file is one device: the second one is refused before it is written. */
static int write(void *argument, const struct description *d, char why[LIBRARY_WHY])
{
    struct conversion *c = argument;
    int error = description_check(d, why);

    if (error)
        return error;
    if (c->count++)
        return why_at(why, d->file, d->place,
                      "\"%s\" is a second device beside \"%s\"; expected one: %.100s#%s", d->type,
                      c->first, d->file, c->first);
    snprintf(c->first, sizeof c->first, "%s", d->type);
    device_file_write(d, c->stream);
    return 0;
}

int library_convert(const char *source, FILE *stream, char why[LIBRARY_WHY])
{
    struct conversion c = { .stream = stream };
    const char *text = device_text(source);

    why[0] = '\0';
    if (text) {
        fputs(text, stream);
        return 0;
    }
    return read_source(source, write, &c, why);
}
