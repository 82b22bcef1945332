/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * library_open.h - device types that users describe themselves, in device files
 * (docs/device-files.md) or in the vendor's ESI, beside those that are built in. For everybody
 * above the bus.
 */
#ifndef HARNESS_BUS_LIBRARY_OPEN_H
#define HARNESS_BUS_LIBRARY_OPEN_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define LIBRARY_WHY 512

struct bus_library;

/* What a type of the library defines, for listings. */
struct library_entry {
    const char *name, *description, *file; /* file: NULL when built in */
    const char *device_name, *order;
    uint32_t vendor, product, revision;
    unsigned output_bits, input_bits; /* by default */
    unsigned outputs, inputs;         /* channels */
    unsigned mailbox;                 /* bytes of SM0; 0: none */
    unsigned objects;                 /* of the dictionary; 0: no CoE */
};

/* 0 or -ENOMEM. */
int library_open(struct bus_library **out);
/* Nothing may use its types any more. NULL is fine. */
void library_close(struct bus_library *library);

/* Adds what a file defines: a device file, or ESI when the name ends with .xml.
 * "file.xml#0x03f03052" and "file.xml#EL1008" take one device of an ESI file. 0, or negative errno
 * with file, line and what was expected in `why`; the library is then as before. */
int library_load(struct bus_library *library, const char *path, char why[LIBRARY_WHY]);

/* Types by number: first those of files, then the built-in ones. False past the end. */
int library_get(const struct bus_library *library, size_t index, struct library_entry *entry);
size_t library_file_types(const struct bus_library *library);

/* Writes a device file that describes the same: of a built-in terminal by its name, of a device
 * file or of one device of ESI. 0 or negative errno with why. */
int library_convert(const char *source, FILE *stream, char why[LIBRARY_WHY]);

#endif
