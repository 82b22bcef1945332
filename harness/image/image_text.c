/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * image_text.c - names that do not stand in the file as they are: "KERNEL32.dll!Sleep", "#7".
 *
 * A small file can ask for very many of them (a thousand libraries whose functions all share one
 * long name), so there is a limit.
 */
#include "image/image_private.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK    ((size_t)64 << 10)
#define MAX_TEXT ((size_t)16 << 20)

struct block {
    struct block *next;
    size_t used;
    char text[BLOCK];
};

const char *image_text(struct image *image, const char *format, ...)
{
    char text[2 * IMAGE_MAX_NAME + 64];
    va_list arguments;
    va_start(arguments, format);
    int made = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (made < 0 || (size_t)made >= sizeof text) {
        image_defect(image, "a name of %d bytes, allowed are up to %u", made, IMAGE_MAX_NAME);
        return NULL;
    }
    size_t size = (size_t)made + 1, total = 0;
    struct block *first = image->texts;
    if (first == NULL || size > BLOCK - first->used) {
        for (const struct block *block = first; block != NULL; block = block->next)
            total += BLOCK;
        if (total >= MAX_TEXT) {
            image_defect(image, "names of imports and exports take more than 16 MiB");
            return NULL;
        }
        struct block *block = malloc(sizeof *block);
        if (block == NULL)
            return NULL;
        block->next = first;
        block->used = 0;
        image->texts = first = block;
    }
    char *place = first->text + first->used;
    memcpy(place, text, size);
    first->used += size;
    return place;
}

void image_free_texts(struct image *image)
{
    struct block *block = image->texts;
    while (block != NULL) {
        struct block *next = block->next;
        free(block);
        block = next;
    }
    image->texts = NULL;
}
