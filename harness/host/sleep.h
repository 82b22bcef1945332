/* SPDX-License-Identifier: GPL-2.0-or-later */
/* sleep.h - what the host keeps of functions that have called SleepFt (sleep.c). */
#ifndef HARNESS_HOST_SLEEP_H
#define HARNESS_HOST_SLEEP_H

#include <stdbool.h>
#include <stdint.h>

/* So much in one call is for ever. RTX, TG Motion's real-time extension on a PC, knows no longer
 * sleep. */
#define SLEEP_HANG_NS UINT64_C(1000000000)

struct sleeper {
    bool asleep;
    unsigned aside;     /* machine_set_aside() */
    uint64_t since_ns;  /* in machine time; on the real clock in realtime_now() */
    uint64_t wanted_ns; /* how long */
    uint64_t total_ns;  /* wanted in this call before */
};

#endif
