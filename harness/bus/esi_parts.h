/* SPDX-License-Identifier: GPL-2.0-or-later */
/* esi_parts.h - what the readers of ESI share; nobody outside of esi*.c includes this. */
#ifndef HARNESS_BUS_ESI_PARTS_H
#define HARNESS_BUS_ESI_PARTS_H

#include "bus/description.h"
#include "bus/library.h"

#include <libxml/tree.h>

enum { ESI_TEXT = 256 }; /* longest text of an element or attribute; the rest is cut off */

/* A row of the dictionary before its place is known: files are not always sorted. */
struct esi_row {
    uint16_t index;
    const char *object;
    struct desc_row row;
};

struct esi {
    const char *file;
    char *why;
    xmlNode *types; /* DataTypes of the device being read, may be NULL */
    struct description *d;
    struct esi_row *rows; /* DESC_ROWS */
    unsigned row_count;
    uint32_t vendor;
};

struct place esi_place_of(xmlNode *node);
/* -EINVAL, with file and line of the node in why. */
int esi_fail(const struct esi *esi, xmlNode *node, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Elements by name: is it one, the first from here on, the first inside, the next one, along a path
 * that ends with NULL. NULL nodes are fine where a node comes out. */
bool esi_is(const xmlNode *node, const char *name);
xmlNode *esi_from(xmlNode *node, const char *name);
xmlNode *esi_child(xmlNode *node, const char *name);
xmlNode *esi_next(xmlNode *node, const char *name);
xmlNode *esi_down(xmlNode *node, const char *const *path);

/* Texts without the blanks around them, empty when there are none; they return `to`. */
const char *esi_content(xmlNode *node, char to[ESI_TEXT]);
const char *esi_attribute(xmlNode *node, const char *name, char to[ESI_TEXT]);
bool esi_flag(xmlNode *node, const char *name);

bool esi_number(const char *text, uint32_t *value);
/* Numbers up to `most`, or a complaint that expects `what`. An absent attribute leaves *value
 * alone. */
int esi_need(const struct esi *esi, xmlNode *node, const char *text, const char *what,
             uint32_t most, uint32_t *value);
int esi_need_child(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                   uint32_t most, uint32_t *value);
int esi_may_attribute(const struct esi *esi, xmlNode *node, const char *name, const char *what,
                      uint32_t most, uint32_t *value);
/* Bytes from hexadecimal digits; -1 when they are none, or too many. */
int esi_bytes_of(const char *text, uint8_t *bytes, size_t room);

/* Copies into the description. */
int esi_keep(const struct esi *esi, xmlNode *node, const char *text, const char **to);
int esi_keep_name(const struct esi *esi, xmlNode *node, size_t most, const char **to);

/* enum od_type; 0: a terminal cannot hold it. */
uint8_t esi_type_of(const char *name, uint32_t bits);

/* esi_dictionary.c */
int esi_read_dictionary(struct esi *esi, xmlNode *device);

#endif
