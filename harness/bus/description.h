/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * description.h - a terminal as somebody describes it, in a device file or in ESI, before it
 * becomes a device type. Readers fill it in, description_build() checks it as a whole and makes the
 * type. Every part remembers where it was read, for the complaint.
 */
#ifndef HARNESS_BUS_DESCRIPTION_H
#define HARNESS_BUS_DESCRIPTION_H

#include "bus/scan.h"
#include "bus/terminal.h"

#include <stdio.h>

#define DESC_PDOS     64
#define DESC_ENTRIES  1024 /* of all PDOs */
#define DESC_OBJECTS  512
#define DESC_ROWS     4096 /* entries of all objects */
#define DESC_CHANNELS 256
#define DESC_TEXT     65536
#define DESC_NAME     63 /* characters of a type name */
#define DESC_NO_SM    0xff

enum desc_dc { DESC_DC_NONE, DESC_DC_DELAY, DESC_DC_FULL };

struct desc_sm {
    struct place place;
    uint16_t start, length;
    uint8_t control, enable, type; /* type: enum sii_sm_type */
};

struct desc_entry {
    struct place place;
    uint16_t index; /* 0: a gap */
    uint8_t subindex, type, bits;
    const char *name;
};

struct desc_pdo {
    struct place place;
    enum pdo_direction direction;
    uint16_t index, flags;
    uint8_t sm;
    unsigned first, count; /* of entries */
    const char *name;
};

struct desc_row {
    struct place place;
    uint8_t subindex, type;
    uint16_t access;
    int64_t initial, least, most;
    bool ranged;
    const char *name, *text;
};

struct desc_object {
    struct place place;
    uint16_t index;
    uint8_t code;          /* enum od_code */
    unsigned first, count; /* of rows */
    const char *name;
};

struct desc_ref {
    struct place place;
    uint16_t index; /* 0: none */
    uint8_t subindex;
};

struct desc_channel {
    struct desc_ref value, flag[TERMINAL_FLAGS];
    int64_t safe;
};

struct description {
    const char *file;
    struct place place;       /* of the device itself */
    const char *type, *about; /* as on the bus; one line for people */
    const char *name, *order, *group;
    uint32_t vendor, product, revision;
    uint16_t pdi_control, pdi_config, pdi_config_ext, sync_pulse, ports, dc_assign;
    int16_t current;
    bool emulation, hold;
    enum desc_dc dc;
    struct place coe_place;
    uint8_t coe_details; /* 0: no CoE */
    struct desc_sm sm[SII_MAX_SM];
    uint8_t fmmu[SII_MAX_FMMU];
    unsigned sm_count, fmmu_count, pdo_count, entry_count, object_count, row_count;
    unsigned input_count, output_count;
    struct desc_pdo pdo[DESC_PDOS];
    struct desc_entry entry[DESC_ENTRIES];
    struct desc_object object[DESC_OBJECTS];
    struct desc_row row[DESC_ROWS];
    struct desc_channel input[DESC_CHANNELS], output[DESC_CHANNELS];
    char text[DESC_TEXT];
    size_t text_used;
};

/* Empty, with the defaults of both formats. To be freed. NULL: no memory. */
struct description *description_new(const char *file);
/* Copies a text; NULL when there is no room. */
const char *description_text(struct description *d, const char *text, size_t length);

/* Names of data types in both directions: "u16", "bool", "bit3". 0 or NULL: unknown. */
uint8_t description_type(const char *name);
const char *description_type_name(uint8_t type);
/* What a value of a type may be. */
void description_limits(uint8_t type, int64_t *least, int64_t *most);
/* Objects that every terminal with CoE gets from its other data, and that cannot be described:
 * identity, mapping, sync managers, assignment. */
bool description_generates(const struct description *d, uint16_t index);

const struct desc_entry *description_entry(const struct description *d,
                                           enum pdo_direction direction, uint16_t index,
                                           uint8_t subindex);
unsigned description_image_bits(const struct description *d, enum pdo_direction direction);
bool description_coe(const struct description *d);
int description_sm(const struct description *d, uint8_t type); /* -1: none */

/* 0, or -EINVAL with file, place and expectation in why. */
int description_check(const struct description *d, char why[SCAN_WHY]);
/* Checks, and makes the type in one piece of memory that free() takes back whole. */
int description_build(const struct description *d, struct terminal_type **out, char why[SCAN_WHY]);

/* device_file.c: reads the text of a device file. 0 or negative errno with why. */
int device_file_read(struct description *d, const char *text, size_t length, char why[SCAN_WHY]);
/* device_write.c: writes a device file that reads back to the same type. */
void device_file_write(const struct description *d, FILE *stream);

#endif
