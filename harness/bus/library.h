/* SPDX-License-Identifier: GPL-2.0-or-later */
/* library.h - where device types are looked up by name: first those of device files, then those
 * that are built in. */
#ifndef HARNESS_BUS_LIBRARY_H
#define HARNESS_BUS_LIBRARY_H

#include "bus/device.h"

struct bus_library;

/* NULL when there is no such type; library NULL: built-in types only. */
const struct device_type *library_find(const struct bus_library *library, const char *name);

#endif
