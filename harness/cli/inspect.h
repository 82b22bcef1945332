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

/* Bytes of an export: as the file states them, else as far as its code shows; 0: not known. */
uint64_t inspect_size(const struct image *image, const struct image_symbol *symbol);

/* Why a stack figure is no bound: for a person and for a program; "" and "bounded" when it is. */
const char *inspect_limit(enum image_stack_limit limit);
const char *inspect_limit_id(enum image_stack_limit limit);

/* The export or entry point that takes most stack: one without a bound before all that have one.
 * *name is its own. NULL when there is none. */
const struct image_routine *inspect_deepest(const struct image *image, const char **name);

/* Escapes what could steer a terminal in every name that the file gives. */
void inspect_text(const struct image *image, FILE *out);
/* Schema tgm-inspect/1, docs/json.md. 0 or negative errno. */
int inspect_json(const struct image *image, FILE *out);

#endif
