/* SPDX-License-Identifier: GPL-2.0-or-later */
/* library.h - where device types are looked up by name: first those of device files, then those
 * that are built in. */
#ifndef HARNESS_BUS_LIBRARY_H
#define HARNESS_BUS_LIBRARY_H

#include "bus/device.h"
#include "bus/library_open.h"

struct bus_library;
struct description;

/* NULL when there is no such type; library NULL: built-in types only. */
const struct device_type *library_find(const struct bus_library *library, const char *name);

/* What takes one description after the other; negative errno ends the reading. */
typedef int description_taker(void *argument, const struct description *d, char why[LIBRARY_WHY]);

/* esi.c: gives every device of an ESI file to `take`, or the one that `select` names (product code
 * or type; NULL: all). 0 or negative errno with why. */
int esi_read(const char *file, const char *text, size_t length, const char *select,
             description_taker *take, void *argument, char why[LIBRARY_WHY]);

#endif
