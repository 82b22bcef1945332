/* SPDX-License-Identifier: GPL-2.0-or-later */
/* rack.h - slaves as a configuration lists them, switched on and wired into a segment. */
#ifndef HARNESS_BUS_RACK_H
#define HARNESS_BUS_RACK_H

#include "bus/bus.h"
#include "bus/segment.h"
#include "bus/slave.h"

struct rack {
    struct segment segment;
    struct slave *slaves; /* segment.count of them */
    void *devices[BUS_MAX_SLAVES];
};

/* Uses devices, library and seed of the configuration. 0, or negative errno with the reason in
 * `why`: -EINVAL no such type or too many, -ENOMEM. */
int rack_open(struct rack *rack, const struct bus_config *config, char why[BUS_WHY]);
void rack_close(struct rack *rack);

/* Prints the reason and returns the error: `return rack_fail(why, -EINVAL, ...)`. */
int rack_fail(char why[BUS_WHY], int error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
