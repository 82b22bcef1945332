/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * nicdrv.h - SOEM's network port, here a wire into a function instead of a socket.
 *
 * SOEM reaches into txbuf, txbuflength and rxbuf (received frames without the Ethernet header) and
 * into the fields of redundancy; everything else is ours.
 */
#ifndef HARNESS_BUS_PORT_NICDRV_H
#define HARNESS_BUS_PORT_NICDRV_H

#include <stdbool.h>
#include <stddef.h>

#include "bus/port/clock.h"

struct wire; /* the far end of the cable: wire.h */

/* With redundancy both ends of the segment belong to one port structure, because they lead to one
 * wire: nothing is left for the second one. */
typedef struct {
    int unused;
} ecx_redportt;

typedef struct {
    struct wire *wire;       /* set before ecx_init() */
    struct bus_clock *clock; /* likewise */
    uint8 lastidx;
    int rxbufstat[EC_MAXBUF];
    uint64_t back_ns[EC_MAXBUF]; /* arrival of a frame in flight (EC_BUF_TX, or EC_BUF_RCVD) */
    int txbuflength[EC_MAXBUF];
    ec_bufT txbuf[EC_MAXBUF];
    ec_bufT rxbuf[EC_MAXBUF];
    ec_bufT air;

    uint64_t sent, received; /* frames */

    bool redundant;    /* a frame that comes back where it went in is sent into the other end */
    uint64_t one_sided; /* frames for which that was necessary */

    /* Named by ecx_init_redundant() only. */
    ecx_redportt *redport;
    ec_bufT txbuf2;
    int txbuflength2;
} ecx_portt;

extern const uint16 priMAC[3];
extern const uint16 secMAC[3];

void ec_setupheader(void *p);
int ecx_setupnic(ecx_portt *port, const char *ifname, int secondary);
int ecx_closenic(ecx_portt *port);
void ecx_setbufstat(ecx_portt *port, uint8 idx, int bufstat);
uint8 ecx_getindex(ecx_portt *port);
int ecx_outframe_red(ecx_portt *port, uint8 idx);
int ecx_waitinframe(ecx_portt *port, uint8 idx, int timeout);
int ecx_srconfirm(ecx_portt *port, uint8 idx, int timeout);

#endif
