/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <string.h>

#include "cli/cli.h"
#include "cli/inspect.h"

size_t inspect_count_relocs(const struct image *image, struct inspect_relocs *types, size_t max)
{
    size_t count = 0;
    for (size_t i = 0; i < image->reloc_count; i++) {
        const struct image_reloc *reloc = &image->relocs[i];
        size_t k = 0;
        while (k < count && strcmp(types[k].type_name, reloc->type_name) != 0)
            k++;
        if (k == max)
            continue;
        if (k == count)
            types[count++] = (struct inspect_relocs){ reloc->type_name, reloc->kind, 0 };
        types[k].count++;
    }
    return count;
}

const char *inspect_symbol_kind(const struct image_symbol *symbol)
{
    switch (symbol->kind) {
    case IMAGE_SYMBOL_FUNC:
        return symbol->thumb ? "Thumb function" : "function";
    case IMAGE_SYMBOL_OBJECT:
        return "data";
    case IMAGE_SYMBOL_IFUNC:
        return "indirect function";
    case IMAGE_SYMBOL_TLS:
        return "thread-local";
    case IMAGE_SYMBOL_NONE:
        return symbol->executable ? "code" : "data";
    case IMAGE_SYMBOL_OTHER:
        break;
    }
    return symbol->forwarder != NULL ? "forwarded" : "other";
}

const char *inspect_import_kind(const struct image_import *import)
{
    switch (import->kind) {
    case IMAGE_IMPORT_SYMBOL:
        return import->delayed ? "delayed symbol" : "symbol";
    case IMAGE_IMPORT_WEAK:
        return "weak symbol";
    case IMAGE_IMPORT_LIBRARY:
        return import->delayed ? "delayed library" : "library";
    case IMAGE_IMPORT_FILTER:
        break;
    }
    return "filter";
}

const char *inspect_reloc_kind(enum image_reloc_kind kind)
{
    switch (kind) {
    case IMAGE_RELOC_RELATIVE:
        return "load address";
    case IMAGE_RELOC_SYMBOLIC:
        return "symbol";
    case IMAGE_RELOC_INDIRECT:
        return "runs code";
    case IMAGE_RELOC_TLS:
        return "thread-local";
    case IMAGE_RELOC_OTHER:
        break;
    }
    return "other";
}

const char *inspect_permissions(unsigned perm)
{
    static const char *const texts[] = { "---", "r--", "-w-", "rw-", "--x", "r-x", "-wx", "rwx" };
    return texts[perm & 7];
}

uint64_t inspect_size(const struct image *image, const struct image_symbol *symbol)
{
    const struct image_routine *routine =
        symbol->size == 0 && symbol->executable ? image_routine(image, symbol->vaddr) : NULL;
    return routine != NULL ? routine->size : symbol->size;
}

static const struct {
    const char *text, *id;
} limits[] = {
    [IMAGE_STACK_BOUNDED] = { "", "bounded" },
    [IMAGE_STACK_RECURSION] = { "a function is called again before it has returned", "recursion" },
    [IMAGE_STACK_POINTER] = { "a call through a pointer may come back to where it was made",
                              "pointer" },
    [IMAGE_STACK_JUMP] = { "a jump through a pointer that cannot be followed", "jump" },
    [IMAGE_STACK_VARIABLE] = { "the stack pointer moves by an amount computed at run time",
                               "variable" },
    [IMAGE_STACK_LOOP] = { "the stack grows with each turn of a loop", "loop" },
    [IMAGE_STACK_UNBALANCED] = { "more is taken off the stack than was put on", "unbalanced" },
    [IMAGE_STACK_CODE] = { "control goes where there is no instruction", "no-code" },
    [IMAGE_STACK_LARGE] = { "more code than is looked at", "large" },
    [IMAGE_STACK_UNKNOWN] = { "the code could not be read", "unknown" },
};

const char *inspect_limit(enum image_stack_limit limit)
{
    return limits[limit].text;
}

const char *inspect_limit_id(enum image_stack_limit limit)
{
    return limits[limit].id;
}

static bool is_deeper(const struct image_routine *routine, const struct image_routine *than)
{
    if (than == NULL)
        return true;
    const bool bounded = routine->limit == IMAGE_STACK_BOUNDED;
    if (bounded != (than->limit == IMAGE_STACK_BOUNDED))
        return !bounded;
    return routine->stack > than->stack;
}

const struct image_routine *inspect_deepest(const struct image *image, const char **name)
{
    const struct image_routine *deepest =
        image->has_entry_point ? image_routine(image, image->entry_point) : NULL;
    *name = "entry point";
    for (size_t i = 0; i < image->symbol_count; i++) {
        const struct image_symbol *symbol = &image->symbols[i];
        const struct image_routine *routine =
            symbol->exported && symbol->executable ? image_routine(image, symbol->vaddr) : NULL;
        if (routine == NULL || !is_deeper(routine, deepest))
            continue;
        deepest = routine;
        *name = symbol->name;
    }
    return deepest;
}

static int print(const struct command *command, const struct image *image, const char *json)
{
    struct output output = { 0 };
    int status = image->defect[0] == '\0' ? EXIT_OK : EXIT_MODULE;
    int r = json != NULL ? output_open(&output, json) : 0;
    if (r != 0)
        return complain(command, "cannot write '%s': %s", json, strerror(-r));
    FILE *text = output.stream == stdout ? stderr : stdout;
    if (json != NULL) {
        r = inspect_json(image, output.stream);
        const int closed = output_close(&output, r == 0);
        if (r != 0 || closed != 0)
            status =
                complain(command, "cannot write '%s': %s", json, strerror(r != 0 ? -r : -closed));
    }
    inspect_text(image, text);
    if (fflush(text) != 0 && errno != EPIPE)
        status = EXIT_CALL;
    return status;
}

int command_inspect(const struct command *command, int argc, char **argv)
{
    const char *module = NULL, *json = NULL;
    const struct option table[] = {
        { "--json", OPTION_TEXT, "FILE", "also write it as JSON, - for standard output", &json, 0,
          0 },
        { 0 },
    };
    char why[IMAGE_WHY];
    struct image *image;
    int words, status;
    if (!options_read(command, table, argc, argv, &module, 1, &words, &status))
        return status;
    if (words == 0)
        return complain(command, "which module? usage: tgm inspect %s", command->usage);
    if (image_open(&image, module, why) != 0)
        return complain(command, "%s", why);
    status = print(command, image, json);
    image_close(image);
    return status;
}
