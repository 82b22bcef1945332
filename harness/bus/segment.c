/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/segment.h"
#include "bus/bytes.h"
#include "bus/frame.h"
#include "bus/slave.h"

#include <string.h>

struct datagram {
    uint8_t *header;
    uint8_t *data;
    uint8_t *wkc;
    uint16_t length;
    bool more;
};

static bool datagram_at(uint8_t *at, const uint8_t *end, struct datagram *d)
{
    if (end - at < DG_HEADER + DG_WKC)
        return false;
    d->header = at;
    d->data = at + DG_HEADER;
    d->length = get_u16(at + 6) & DG_LENGTH;
    d->more = get_u16(at + 6) & DG_MORE;
    if (end - d->data < d->length + DG_WKC)
        return false;
    d->wkc = d->data + d->length;
    return true;
}

static bool well_formed(uint8_t *at, const uint8_t *end)
{
    struct datagram d;

    do {
        if (!datagram_at(at, end, &d))
            return false;
        at = d.wkc + DG_WKC;
    } while (d.more);
    return true;
}

/* Working counter steps of one slave: a successful read counts 1, a write inside a read-write
 * command 2, a write alone 1. */
static unsigned steps(unsigned done)
{
    return (done & 1 ? 1u : 0u) + (done & 2 ? 2u : 0u);
}

static unsigned broadcast_read(struct slave *s, uint16_t ado, uint8_t *data, uint16_t length)
{
    uint8_t own[SEGMENT_FRAME_MAX];

    memset(own, 0, length);
    if (!slave_read(s, ado, own, length))
        return 0;
    for (unsigned i = 0; i < length; i++)
        data[i] |= own[i];
    return 1;
}

/* What is written is the data as it arrived, before this slave's own content is ORed in. */
static unsigned broadcast_exchange(struct slave *s, uint16_t ado, uint8_t *data, uint16_t length)
{
    uint8_t incoming[SEGMENT_FRAME_MAX];
    unsigned done;

    memcpy(incoming, data, length);
    done = broadcast_read(s, ado, data, length);
    if (slave_write(s, ado, incoming, length))
        done |= 2;
    return steps(done);
}

static unsigned access_own(struct slave *s, enum command command, uint16_t ado, uint8_t *data,
                           uint16_t length)
{
    switch (command) {
    case APRD:
    case FPRD:
        return slave_read(s, ado, data, length);
    case APWR:
    case FPWR:
    case BWR:
        return slave_write(s, ado, data, length);
    case APRW:
    case FPRW:
        return steps(slave_exchange(s, ado, data, length));
    case BRD:
        return broadcast_read(s, ado, data, length);
    case BRW:
        return broadcast_exchange(s, ado, data, length);
    default:
        return 0;
    }
}

static unsigned process(struct slave *s, const struct datagram *d)
{
    uint8_t *h = d->header;
    uint16_t adp = get_u16(h + 2), ado = get_u16(h + 4);

    switch (h[0]) {
    case APRD:
    case APWR:
    case APRW:
        put_u16(h + 2, adp + 1u);
        return adp ? 0 : access_own(s, (enum command)h[0], ado, d->data, d->length);
    case FPRD:
    case FPWR:
    case FPRW:
        if (!slave_is_addressed(s, adp))
            return 0;
        return access_own(s, (enum command)h[0], ado, d->data, d->length);
    case BRD:
    case BWR:
    case BRW:
        put_u16(h + 2, adp + 1u);
        return access_own(s, (enum command)h[0], ado, d->data, d->length);
    case ARMW:
        put_u16(h + 2, adp + 1u);
        return adp ? slave_write(s, ado, d->data, d->length)
                   : slave_read(s, ado, d->data, d->length);
    case FRMW:
        return slave_is_addressed(s, adp) ? slave_read(s, ado, d->data, d->length)
                                          : slave_write(s, ado, d->data, d->length);
    case LRD:
        return slave_logical(s, get_u32(h + 2), d->data, d->length, true, false) ? 1 : 0;
    case LWR:
        return slave_logical(s, get_u32(h + 2), d->data, d->length, false, true) ? 1 : 0;
    case LRW:
        return steps(slave_logical(s, get_u32(h + 2), d->data, d->length, true, true));
    default:
        return 0;
    }
}

static void pass_slave(struct slave *s, uint8_t *at, const uint8_t *end)
{
    struct datagram d;

    do {
        unsigned counted;
        uint16_t irq = slave_irq(s);

        if (!datagram_at(at, end, &d))
            return;
        counted = process(s, &d);
        if (counted)
            put_u16(d.wkc, get_u16(d.wkc) + counted);
        if (irq)
            put_u16(d.header + 8, get_u16(d.header + 8) | irq);
        at = d.wkc + DG_WKC;
    } while (d.more);
    slave_settle(s);
}

static void count_error(struct slave *s)
{
    if (s->memory[REG_PU_ERRORS] < 0xff)
        s->memory[REG_PU_ERRORS]++;
}

/* Slaves in front of the first break. */
static size_t reachable(const struct segment *segment)
{
    size_t n = 0;

    while (n < segment->count && !segment->cut[n] && segment->slaves[n].powered)
        n++;
    return n;
}

bool segment_is_whole(const struct segment *segment)
{
    return reachable(segment) == segment->count;
}

static bool pass_all(struct segment *segment, uint8_t *frame, uint8_t *at, const uint8_t *end,
                     uint64_t now_ns)
{
    for (size_t i = 0; i < reachable(segment); i++) {
        struct slave *s = &segment->slaves[i];
        bool forwarding = s->memory[REG_DL_CONTROL] & DL_CONTROL_FORWARDING;

        slave_meet(s, now_ns + s->delay_ns);
        if (!at) {
            /* Not for processing units: a slave told so destroys it, others let it through. */
            if (forwarding)
                return false;
            continue;
        }
        if (forwarding)
            frame[SOURCE_MAC] |= LOCAL_BIT;
        if (end)
            pass_slave(s, at, end);
    }
    return true;
}

bool segment_transfer(struct segment *segment, enum segment_port *port, uint8_t *frame,
                      size_t length, uint64_t now_ns, uint64_t *back_ns)
{
    size_t reached = reachable(segment);
    const struct slave *last = reached ? &segment->slaves[reached - 1] : NULL;
    uint8_t *datagrams = frame + ETHER_HEADER + ECAT_HEADER;
    uint16_t header;
    size_t claimed;

    if (length < SEGMENT_FRAME_MIN || length > SEGMENT_FRAME_MAX || !last ||
        *port != SEGMENT_PORT_A)
        return false;
    if (back_ns)
        *back_ns = now_ns + (length + ETHER_OVERHEAD) * BYTE_NS + 2u * last->delay_ns;
    if (plan_transfer(segment, frame, length, now_ns))
        return true;
    if (get_u16(frame + ETHER_TYPE) != ETHER_ECAT)
        return pass_all(segment, frame, NULL, NULL, now_ns);
    header = get_u16(frame + ETHER_HEADER);
    if (header >> 12 != ECAT_DATAGRAMS)
        return pass_all(segment, frame, frame, NULL, now_ns);
    claimed = header & ECAT_LENGTH;
    if (claimed > length - ETHER_HEADER - ECAT_HEADER ||
        !well_formed(datagrams, datagrams + claimed)) {
        count_error(&segment->slaves[0]);
        return false;
    }
    return pass_all(segment, frame, datagrams, datagrams + claimed, now_ns);
}

void segment_close_ring(struct segment *segment, bool ring, uint64_t now_ns)
{
    (void)now_ns;
    segment->ring = ring;
    segment->plans.changes++;
}

void segment_cable(struct segment *segment, size_t behind, bool plugged, uint64_t now_ns)
{
    (void)now_ns;
    if (behind <= segment->count)
        segment->cut[behind] = !plugged;
    segment->plans.changes++;
}

void segment_power(struct segment *segment, size_t slave, bool on, uint64_t now_ns)
{
    struct slave *s = &segment->slaves[slave];

    if (slave >= segment->count || s->powered == on)
        return;
    s->powered = on;
    segment->plans.changes++;
    if (on)
        slave_power_on(s, now_ns);
}

void segment_init(struct segment *segment, struct slave *slaves, size_t count)
{
    memset(segment, 0, sizeof *segment);
    segment->slaves = slaves;
    segment->count = count;
    segment->plans.changes = 1;
    for (size_t i = 0; i < count; i++) {
        bool last = i + 1 == count;

        slaves[i].changes = &segment->plans.changes;
        slaves[i].delay_ns = (uint32_t)((i + 1) * SEGMENT_HOP_NS);
        slaves[i].return_ns = (uint32_t)(2 * (count - 1 - i) * SEGMENT_HOP_NS);
        /* Port 0 always linked and communicating, port 1 unless last, ports 2 and 3 closed. */
        put_u16(slaves[i].memory + REG_DL_STATUS,
                (last ? 0x5610u : 0x5a30u) | DL_STATUS_WD_PDI |
                    (slaves[i].memory[REG_DL_STATUS] & DL_STATUS_PDI));
    }
}
