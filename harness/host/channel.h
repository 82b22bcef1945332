/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * channel.h - the handshakes by which a PLC reaches objects and registers of a slave (M12).
 *
 * A channel is a few words of a shared memory and at most one request on its way over the bus.
 * Requests of all channels are carried out one after the other, beside the process data.
 *
 *   SDO, EXT_SDO            Control Status NumberByte Index SubIndex Data...
 *   ECAT_REGISTER, general  Control NumberByte Index Data...
 *
 * channel_step() is called once a cycle. It takes a request by making Status 1 (register: Control
 * 4); from then on the other words may be anything. At the end it writes Data, then Status, then
 * Control 0. A PLC waits for Control 0, then looks at Status. Failed: Status -1 and the code in
 * Data, which is what the slave aborted with or one of CHANNEL_...; register: Control 3, Data 0.
 */
#ifndef HARNESS_HOST_CHANNEL_H
#define HARNESS_HOST_CHANNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"

#define CHANNEL_NO_SLAVE SIZE_MAX

/* Abort codes of CiA 301 for what no slave answered. */
enum {
    CHANNEL_TIMEOUT = 0x05040000,     /* no answer, or nobody there */
    CHANNEL_BAD_COMMAND = 0x05040001, /* Control is neither 1 nor 2 */
    CHANNEL_NO_MAILBOX = 0x06010000,  /* the slave has no CoE */
    CHANNEL_NO_OBJECT = 0x06020000,   /* Index beyond 0xFFFF */
    CHANNEL_BAD_LENGTH = 0x06070010,  /* NumberByte is none that the channel has */
    CHANNEL_TOO_LONG = 0x06070012,    /* the object is longer than NumberByte */
    CHANNEL_NO_SUBINDEX = 0x06090011, /* SubIndex beyond 0xFF */
    CHANNEL_GENERAL = 0x08000000      /* what came was no answer */
};

enum channel_kind { CHANNEL_SDO, CHANNEL_REGISTER };

struct channel {
    enum channel_kind kind;
    volatile uint32_t *words; /* the first is Control */
    unsigned most;            /* bytes of Data; 4: lengths 1, 2, 4 only */
    size_t slave;             /* or CHANNEL_NO_SLAVE */
    int32_t *failures;        /* counts failed requests; may be NULL */

    bool complete; /* SDO: complete access for all lengths, not only above 4 bytes */
    bool active;   /* a request is on its way */
    size_t wanted; /* bytes that it asked for */
    struct bus_job job;
};

/* What channel_step() saw. `DONE` and `FAILED` come once a request; channel.job is that request. */
enum channel_event { CHANNEL_NOTHING, CHANNEL_DONE, CHANNEL_FAILED };

enum channel_event channel_step(struct channel *channel, struct bus *bus);

/* Ends a request that may not even begin, as if nobody had answered. */
enum channel_event channel_refuse(struct channel *channel);
/* Something is asked and not taken yet. */
bool channel_asked(const struct channel *channel);

#endif
