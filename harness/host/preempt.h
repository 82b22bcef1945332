/* SPDX-License-Identifier: GPL-2.0-or-later */
/* preempt.h - what the host keeps of interrupts (preempt.c). */
#ifndef HARNESS_HOST_PREEMPT_H
#define HARNESS_HOST_PREEMPT_H

#include <stdint.h>

#include "host/product.h"

struct preempt {
    enum entry interrupted; /* the highest that is; ENTRY_INI: none */
    unsigned called;        /* functions called of late: bit n is enum entry n */
    uint64_t drawn;         /* how many random numbers */
    uint64_t length[3];     /* instructions of the longest call so far of Program_01..03 */
    uint64_t begun_ns[3];   /* real clock: when the call began */
    uint64_t away_ns[3];    /* and how long it was interrupted */
};

#endif
