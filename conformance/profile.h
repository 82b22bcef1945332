/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * profile.h - what is demanded of a module for one TG Motion product: the product the host plays,
 * the file formats it loads, the functions it looks up. Rows in profiles/; adding one is adding a
 * file and a line.
 */
#ifndef CONFORMANCE_PROFILE_H
#define CONFORMANCE_PROFILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/product.h"
#include "image/image.h"

/* A kind of file, in words for messages ("the profile loads ..."). */
struct profile_format {
    enum image_format format;
    enum image_target target;
    const char *title;
};

#define PROFILE_FORMATS 4
#define PROFILE_WANTED  256

struct profile {
    const char *name;    /* "pc4" */
    const char *product; /* row of host/product.c */
    /* What is loaded: the product's own formats, and the rebuild for this SDK's ELF64 target, of
     * which a verdict says nothing about the file for the product (decision H13). Ends with
     * IMAGE_FORMAT_NONE. */
    struct profile_format formats[PROFILE_FORMATS];
    const char *const *exports; /* names a module must export, and no others; ends with NULL */
    const char *optional;       /* one that it may export; NULL: none */
    uint64_t region_bytes;      /* memory that there is for the module */
    uint32_t stack_bytes;       /* stack that one call of it may take */
};

/* By name or index, NULL when there is none. */
const struct profile *profile_find(const char *name);
const struct profile *profile_at(size_t index);

/* Whether the image is of a kind that the profile loads, whatever else is wrong with it. */
bool profile_loads(const struct profile *profile, const struct image *image);
/* The first profile that loads the image: pc4 for ELF64 and PE, tgmmini for ELF32, tgmcontroller for
 * flat images. NULL when none does, as for a file that is no module. */
const struct profile *profile_of_image(const struct image *image);
/* All kinds: "an ELF64 x86-64 shared object or a PE32 DLL for i386". */
const char *profile_wanted(const struct profile *profile, char text[PROFILE_WANTED]);

#endif
