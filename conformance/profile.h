/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * profile.h - what is demanded of a module for one TG Motion product: the product the host plays,
 * the file format it loads, the functions it looks up. Rows in profiles/; adding one is adding a
 * file and a line.
 */
#ifndef CONFORMANCE_PROFILE_H
#define CONFORMANCE_PROFILE_H

#include <stddef.h>
#include <stdint.h>

#include "host/product.h"
#include "image/image.h"

struct profile {
    const char *name;    /* "pc4" */
    const char *product; /* row of host/product.c */
    enum image_format format;
    enum image_target target;
    const char *wanted;         /* format and target in words, for messages */
    const char *const *exports; /* names a module must export, and no others; ends with NULL */
    const char *optional;       /* one that it may export; NULL: none */
    uint64_t region_bytes;      /* memory that there is for the module */
    uint32_t stack_bytes;       /* stack that one call of it may take */
};

/* By name or index, NULL when there is none. */
const struct profile *profile_find(const char *name);
const struct profile *profile_at(size_t index);

#endif
