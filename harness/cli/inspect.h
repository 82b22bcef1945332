/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * inspect.h - what `tgm inspect` says of a module, for people and for programs.
 */
#ifndef HARNESS_CLI_INSPECT_H
#define HARNESS_CLI_INSPECT_H

#include <stdio.h>

#include "image/image.h"

/* Relocations of one type. */
struct inspect_relocs {
    const char *type_name;
    enum image_reloc_kind kind;
    size_t count;
};

/* Counts the relocations by type; returns how many types there are (of at most max). */
size_t inspect_count_relocs(const struct image *image, struct inspect_relocs *types, size_t max);

/* "function", "data" ... */
const char *inspect_symbol_kind(const struct image_symbol *symbol);
const char *inspect_import_kind(const struct image_import *import);
const char *inspect_reloc_kind(enum image_reloc_kind kind);
/* "r-x" */
const char *inspect_permissions(unsigned perm);

/* Escapes what could steer a terminal in every name that the file gives. */
void inspect_text(const struct image *image, FILE *out);
/* Schema tgm-inspect/1, docs/json.md. 0 or negative errno. */
int inspect_json(const struct image *image, FILE *out);

#endif
