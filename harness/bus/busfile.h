/* SPDX-License-Identifier: GPL-2.0-or-later */
/* busfile.h - bus files: what stands on the bus, in wiring order (docs/bus-files.md). */
#ifndef HARNESS_BUS_BUSFILE_H
#define HARNESS_BUS_BUSFILE_H

#include "bus/bus.h"
#include "bus/library_open.h"

#define BUSFILE_STIMULI 1024

/* Goes into a struct bus_config piece by piece, and must outlive the bus. */
struct busfile {
    struct bus_library *library;
    struct bus_device devices[BUS_MAX_SLAVES];
    size_t device_count;
    bool redundant; /* "ring" */
    struct bus_stimulus stimuli[BUSFILE_STIMULI];
    size_t stimulus_count;
};

/* 0, or negative errno with file, line and what was expected in `why`. */
int busfile_read(struct busfile **out, const char *path, char why[LIBRARY_WHY]);
/* NULL is fine. */
void busfile_close(struct busfile *file);

#endif
