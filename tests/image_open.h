/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_open.h - opening images in a test: a broken promise or an unexpected defect fails it.
 */
#ifndef TESTS_IMAGE_OPEN_H
#define TESTS_IMAGE_OPEN_H

#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "image_support.h"

#ifndef TEST_MODULES_DIR
#define TEST_MODULES_DIR "build/modules"
#endif

/* valgrind knows no seccomp, without which there are no lines, and has its own allocator. */
static inline bool under_valgrind(void)
{
    const char *preload = getenv("LD_PRELOAD");
    return preload != NULL && strstr(preload, "vgpreload") != NULL;
}

/* Any bytes; look at defect. */
static inline struct image *open_bytes(const void *bytes, size_t size)
{
    struct image *image;
    char why[IMAGE_WHY];
    if (image_open_memory(&image, "bytes", bytes, size, why) != 0)
        fail_msg("%s", why);
    const char *broken = image_broken_promise(image);
    if (broken != NULL)
        fail_msg("%s (defect: %s)", broken, image->defect);
    return image;
}

/* A file made by tests/modules/image.mk; look at defect. */
static inline struct image *open_any_module(const char *name)
{
    char path[PATH_MAX], why[IMAGE_WHY];
    struct image *image;
    const char *directory = getenv("TEST_MODULES_DIR");
    snprintf(path, sizeof path, "%s/%s", directory != NULL ? directory : TEST_MODULES_DIR, name);
    if (image_open(&image, path, why) != 0)
        fail_msg("%s", why);
    const char *broken = image_broken_promise(image);
    if (broken != NULL)
        fail_msg("%s: %s", name, broken);
    return image;
}

/* The same without a defect. */
static inline struct image *open_module(const char *name)
{
    struct image *image = open_any_module(name);
    if (image->defect[0] != '\0')
        fail_msg("%s: %s", name, image->defect);
    return image;
}

static inline struct image *open_tiny(const struct tiny *tiny)
{
    struct image *image = open_bytes(tiny, sizeof *tiny);
    if (image->defect[0] != '\0')
        fail_msg("%s", image->defect);
    return image;
}

static inline const struct image_symbol *symbol(const struct image *image, const char *name)
{
    for (size_t i = 0; i < image->symbol_count; i++) {
        if (strcmp(image->symbols[i].name, name) == 0)
            return &image->symbols[i];
    }
    fail_msg("no symbol %s", name);
    return NULL;
}

static inline const struct image_import *import(const struct image *image, const char *name)
{
    for (size_t i = 0; i < image->import_count; i++) {
        if (strcmp(image->imports[i].name, name) == 0)
            return &image->imports[i];
    }
    return NULL;
}

static inline const struct image_initialiser *initialiser(const struct image *image,
                                                          const char *what, unsigned index)
{
    for (size_t i = 0; i < image->initialiser_count; i++) {
        if (strcmp(image->initialisers[i].what, what) == 0 && image->initialisers[i].index == index)
            return &image->initialisers[i];
    }
    return NULL;
}

#endif
