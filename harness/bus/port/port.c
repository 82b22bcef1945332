/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "oshw.h"
#include "osal.h"
#include "bus/bytes.h"
#include "bus/wire.h"

#include <string.h>

enum {
    HEADER = 14,
    FRAME_MIN = 60,
    US = 1000,
};

/* Frames are marked with this source address; the segment changes its second bit on the way. */
const uint16 priMAC[3] = { 0x0101, 0x0101, 0x0101 };
const uint16 secMAC[3] = { 0x0404, 0x0404, 0x0404 };

uint16 oshw_htons(uint16 hostshort)
{
    uint8_t bytes[2] = { (uint8_t)(hostshort >> 8), (uint8_t)hostshort };
    uint16 network;

    memcpy(&network, bytes, sizeof network);
    return network;
}

uint16 oshw_ntohs(uint16 networkshort)
{
    return oshw_htons(networkshort);
}

ec_adaptert *oshw_find_adapters(void)
{
    return NULL;
}

void oshw_free_adapters(ec_adaptert *adapter)
{
    (void)adapter;
}

void ec_setupheader(void *p)
{
    static const uint8_t header[HEADER] = { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01,
                                            0x01, 0x01, 0x01, 0x01, 0x01, 0x88, 0xa4 };

    memcpy(p, header, sizeof header);
}

int ecx_setupnic(ecx_portt *port, const char *ifname, int secondary)
{
    (void)ifname;
    if (!port->wire || !port->clock)
        return 0;
    if (secondary) {
        port->redundant = true;
        return 1;
    }
    port->redundant = false;
    port->lastidx = 0;
    for (int i = 0; i < EC_MAXBUF; i++) {
        ec_setupheader(port->txbuf[i]);
        port->rxbufstat[i] = EC_BUF_EMPTY;
    }
    return 1;
}

int ecx_closenic(ecx_portt *port)
{
    port->wire = NULL;
    return 0;
}

/* When all are taken the oldest is reused: what is still in flight under it is lost. */
uint8 ecx_getindex(ecx_portt *port)
{
    unsigned idx = port->lastidx;

    for (unsigned tried = 0; tried < EC_MAXBUF; tried++) {
        idx = (idx + 1) % EC_MAXBUF;
        if (port->rxbufstat[idx] == EC_BUF_EMPTY)
            break;
    }
    port->rxbufstat[idx] = EC_BUF_ALLOC;
    port->lastidx = (uint8)idx;
    return (uint8)idx;
}

void ecx_setbufstat(ecx_portt *port, uint8 idx, int bufstat)
{
    port->rxbufstat[idx] = bufstat;
}

/* In a closed ring a frame comes back at the other end, with all slaves behind it. Where the ring
 * is broken it comes back where it went in, and takes the other way to reach the rest: working
 * counters and data of both parts add up in it, as in SOEM's own port. */
static bool around(ecx_portt *port, size_t length, uint64_t *back_ns)
{
    enum segment_port side = SEGMENT_PORT_A;
    uint64_t now_ns = port->clock->now_ns, later_ns;
    bool back = wire_transfer(port->wire, &side, port->air, length, now_ns, back_ns);

    if (!port->redundant || (back && side == SEGMENT_PORT_B))
        return back;
    port->one_sided++;
    side = SEGMENT_PORT_B;
    if (wire_transfer(port->wire, &side, port->air, length, back ? *back_ns : now_ns, &later_ns))
        *back_ns = later_ns;
    else
        return back;
    return true;
}

/* SOEM sends the same txbuf again when an answer stays away, so it must stay as it is: the segment
 * works on a copy. */
int ecx_outframe_red(ecx_portt *port, uint8 idx)
{
    size_t length = (size_t)port->txbuflength[idx];
    size_t padded = length < FRAME_MIN ? FRAME_MIN : length;

    port->rxbufstat[idx] = EC_BUF_TX;
    memcpy(port->air, port->txbuf[idx], length);
    memset(port->air + length, 0, padded - length);
    port->sent++;
    if (!around(port, padded, &port->back_ns[idx]))
        return (int)padded;
    port->received++;
    memcpy(port->rxbuf[idx], port->air + HEADER, length - HEADER);
    port->rxbufstat[idx] = EC_BUF_RCVD;
    return (int)padded;
}

/* Working counter of the last datagram: two bytes behind what the EtherCAT header counts. */
static int last_wkc(const uint8 *frame)
{
    return get_u16(frame + (get_u16(frame) & 0x07ff));
}

int ecx_waitinframe(ecx_portt *port, uint8 idx, int timeout)
{
    uint64_t patience_ns = port->clock->now_ns + (uint64_t)timeout * US;

    if (port->rxbufstat[idx] != EC_BUF_RCVD || port->back_ns[idx] > patience_ns) {
        bus_clock_wait(port->clock, patience_ns);
        return EC_NOFRAME;
    }
    bus_clock_wait(port->clock, port->back_ns[idx]);
    port->rxbufstat[idx] = EC_BUF_COMPLETE;
    return last_wkc(port->rxbuf[idx]);
}

int ecx_srconfirm(ecx_portt *port, uint8 idx, int timeout)
{
    uint64_t until_ns = port->clock->now_ns + (uint64_t)timeout * US;
    int wkc;

    do {
        ecx_outframe_red(port, idx);
        wkc = ecx_waitinframe(port, idx, timeout < EC_TIMEOUTRET ? timeout : EC_TIMEOUTRET);
    } while (wkc <= EC_NOFRAME && port->clock->now_ns < until_ns);
    return wkc;
}
