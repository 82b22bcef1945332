/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * stimulus.h - what the outside world does to an input, as a function of time and seed alone. All
 * arithmetic is integer or a single correctly rounded division: the same on every machine.
 */
#ifndef HARNESS_BUS_STIMULUS_H
#define HARNESS_BUS_STIMULUS_H

#include "bus/bus.h"

#define STIMULUS_NEVER UINT64_MAX

/* Raw value of an analog input. */
int64_t stimulus_value(const struct bus_stimulus *stimulus, uint64_t seed, uint64_t now_ns);
/* Level of a digital input. */
bool stimulus_high(const struct bus_stimulus *stimulus, uint64_t seed, uint64_t now_ns);
/* Until (not including) this time both stay as they are at now_ns. */
uint64_t stimulus_next(const struct bus_stimulus *stimulus, uint64_t now_ns);

#endif
