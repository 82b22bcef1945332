/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * drive_cruise.h - the short way between the process image and an axis that does what axes do
 * nearly always: operation enabled, cyclic synchronous position, the default mapping. To the last
 * bit what the general way does (drive_device.c); false: that has to do it, or what is left of it.
 * The objects
 * behind the inputs stay stale meanwhile; drive_publish() fills them when somebody asks.
 */
#ifndef HARNESS_BUS_DRIVE_CRUISE_H
#define HARNESS_BUS_DRIVE_CRUISE_H

#include "bus/drive.h"
#include "bus/od.h"

/* The axis is the only one, and its mapping the one the functions below are made for. */
bool drive_cruise_fits(const struct pdo_image *outputs, const struct pdo_image *inputs);

bool drive_cruise_step(struct drive *drive, uint64_t now_ns);
/* Begins the step of four axes at once; does nothing where they do not go together. */
void drive_cruise_step_four(struct drive *const drive[4], const uint64_t now_ns[4]);
bool drive_cruise_inputs(struct drive *drive, uint8_t *data);
bool drive_cruise_outputs(struct drive *drive, const uint8_t *data, uint64_t now_ns);

#endif
