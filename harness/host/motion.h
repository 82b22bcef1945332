/* SPDX-License-Identifier: GPL-2.0-or-later */
/* motion.h - what the motion functions of a servo remember from cycle to cycle. */
#ifndef HARNESS_HOST_MOTION_H
#define HARNESS_HOST_MOTION_H

#include "host/gear_motion.h"
#include "host/profile_motion.h"

/* What makes the set-point of a servo, besides the PLC; or-ed. */
enum motion_source { MOTION_PG = 1, MOTION_GEAR = 2 };

struct axis_motion {
    unsigned sources; /* enum motion_source, in this cycle; 0 while the servo is not enabled */
    bool restarted;   /* they are not those of the last cycle */
    struct profile profile;

    /* Gear. What it adds to the set-point is its output less `zero`. */
    struct gear_link link; /* of the linear gear */
    double ratio_in;       /* GEAR.ActualIn with its fraction */
    double part, zero;
    bool zero_next;                                /* the next good output is zero */
    uint32_t mode, source_number, source_position; /* as last calculated */
    uint64_t ordered;                              /* cycle + 1 in which its turn came */

    int32_t command;      /* COMMAND.Control that is being carried out; 0: none */
    bool command_started; /* the servo was enabled while it was carried out */

    uint32_t inputs; /* DigitalIn in the last cycle */
    bool inputs_seen;
};

#endif
