/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * inspect_json.c - a module for programs. Addresses are strings ("0x1000"): JSON readers round
 * large numbers.
 */
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/inspect.h"

#define TYPES_MAX 64

/* Names may hold any bytes, JSON holds UTF-8 only: what is not UTF-8 is written as U+FFFD. */
static json_t *text(const char *value)
{
    json_t *string = json_string(value);
    char *clean = string == NULL ? malloc(3 * strlen(value) + 1) : NULL, *at = clean;
    if (clean == NULL)
        return string;
    for (; *value != '\0'; value++) {
        if ((unsigned char)*value < 0x80)
            *at++ = *value;
        else
            at = stpcpy(at, "\xEF\xBF\xBD");
    }
    *at = '\0';
    string = json_string(clean);
    free(clean);
    return string;
}

static json_t *address(uint64_t value)
{
    char buffer[24];
    snprintf(buffer, sizeof buffer, "0x%" PRIx64, value);
    return json_string(buffer);
}

static void put(json_t *object, const char *key, json_t *value)
{
    json_object_set_new(object, key, value);
}

static json_t *number(uint64_t value)
{
    return json_integer((json_int_t)value);
}

static void put_place(json_t *object, const struct image *image, uint64_t vaddr)
{
    struct image_place place;
    image_where(image, vaddr, &place);
    if (place.function != NULL)
        put(object, "function", text(place.function));
    if (place.file == NULL)
        return;
    put(object, "file", text(place.file));
    put(object, "line", json_integer(place.line));
}

/* null: nothing is known. */
static json_t *stack(const struct image *image, const struct image_routine *routine)
{
    if (routine == NULL || routine->limit == IMAGE_STACK_UNKNOWN)
        return json_null();
    json_t *object = json_object();
    put(object, "bytes", number(routine->stack));
    put(object, "limit", text(inspect_limit_id(routine->limit)));
    put(object, "services", json_boolean(routine->outside));
    if (routine->limit != IMAGE_STACK_BOUNDED) {
        put(object, "where", address(routine->where));
        put_place(object, image, routine->where);
    }
    return object;
}

static json_t *exports(const struct image *image)
{
    json_t *array = json_array();
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        if (!symbol->exported)
            continue;
        json_t *object = json_object();
        put(object, "name", text(symbol->name));
        put(object, "kind", text(inspect_symbol_kind(symbol)));
        if (symbol->forwarder != NULL)
            put(object, "forwarder", text(symbol->forwarder));
        else
            put(object, "address", address(symbol->vaddr));
        const uint64_t size = inspect_size(image, symbol);
        if (size != 0) {
            put(object, "size", number(size));
            put(object, "size_from", text(symbol->size != 0 ? "file" : "code"));
        }
        if (image->format == IMAGE_FORMAT_PE)
            put(object, "ordinal", number(symbol->ordinal));
        if (symbol->executable) {
            put_place(object, image, symbol->vaddr);
            put(object, "stack", stack(image, image_routine(image, symbol->vaddr)));
        }
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *imports(const struct image *image)
{
    json_t *array = json_array();
    for (size_t i = 0; i < image->import_count; i++) {
        json_t *object = json_object();
        put(object, "name", text(image->imports[i].name));
        put(object, "kind", text(inspect_import_kind(&image->imports[i])));
        if (image->imports[i].has_user)
            put(object, "user", address(image->imports[i].user));
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *initialisers(const struct image *image)
{
    json_t *array = json_array();
    for (size_t i = 0; i < image->initialiser_count; i++) {
        const struct image_initialiser *initialiser = &image->initialisers[i];
        json_t *object = json_object();
        put(object, "what", text(initialiser->what));
        put(object, "index", number(initialiser->index));
        if (initialiser->vaddr != 0)
            put(object, "address", address(initialiser->vaddr));
        put_place(object, image, initialiser->vaddr);
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *segments(const struct image *image)
{
    json_t *array = json_array();
    for (size_t i = 0; i < image->segment_count; i++) {
        const struct image_segment *segment = &image->segments[i];
        json_t *object = json_object();
        put(object, "address", address(segment->vaddr));
        put(object, "size", number(segment->mem_size));
        put(object, "file_offset", number(segment->file_offset));
        put(object, "file_size", number(segment->file_size));
        put(object, "permissions", text(inspect_permissions(segment->perm)));
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *relocations(const struct image *image)
{
    struct inspect_relocs types[TYPES_MAX];
    size_t count = inspect_count_relocs(image, types, TYPES_MAX);
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++) {
        json_t *object = json_object();
        put(object, "type", text(types[i].type_name));
        put(object, "kind", text(inspect_reloc_kind(types[i].kind)));
        put(object, "count", number(types[i].count));
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *module(const struct image *image)
{
    json_t *object = json_object();
    put(object, "path", text(image->path));
    put(object, "sha256", text(image->sha256));
    put(object, "size", number(image->size));
    put(object, "format", text(image->format_name));
    put(object, "target", text(image->target_name));
    return object;
}

static void contents(json_t *root, const struct image *image)
{
    /* A flat image without a table: nobody may read an empty list as "exports nothing". */
    const bool unknown = image->format == IMAGE_FORMAT_FLAT && image->symbol_count == 0;
    const char *name;
    put(root, "exports", unknown ? json_null() : exports(image));
    put(root, "imports", imports(image));
    put(root, "initialisers", initialisers(image));
    put(root, "entry_point", image->has_entry_point ? address(image->entry_point) : json_null());
    put(root, "thread_local", image->has_tls ? number(image->tls_size) : json_null());
    put(root, "base", address(image->base));
    put(root, "fixed", json_boolean(image->fixed));
    put(root, "segments", segments(image));
    put(root, "relocations", relocations(image));
    put(root, "stack", stack(image, inspect_deepest(image, &name)));
    put(root, "executable_stack", json_boolean(image->exec_stack));
    put(root, "source_lines", json_boolean(image->has_debug_lines));
    put(root, "debug_file", image->debug_file != NULL ? text(image->debug_file) : json_null());
}

int inspect_json(const struct image *image, FILE *out)
{
    json_t *root = json_object();
    if (root == NULL)
        return -ENOMEM;
    put(root, "schema", text("tgm-inspect/1"));
    put(root, "tool", text("tgm " TGM_VERSION_TEXT));
    put(root, "module", module(image));
    if (image->defect[0] != '\0')
        put(root, "defect", text(image->defect));
    else
        contents(root, image);
    int r = json_dumpf(root, out, JSON_INDENT(2) | JSON_ENSURE_ASCII);
    json_decref(root);
    return r != 0 || fputc('\n', out) == EOF ? -EIO : 0;
}
