/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/segment.h"
#include "bus/bytes.h"
#include "bus/frame.h"
#include "bus/slave_parts.h"
#include "bus/topology.h"

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

static unsigned access_logical(struct slave *s, enum command command, uint32_t address,
                               const struct datagram *d)
{
    unsigned done = slave_logical(s, address, d->data, d->length, command != LWR, command != LRD);

    return command == LRW ? steps(done) : done != 0;
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
    case LWR:
    case LRW:
        return s->mute ? 0 : access_logical(s, (enum command)h[0], get_u32(h + 2), d);
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

/* Turning round at a dead port 0 marks a frame; one that is marked already went round once and
 * would do so for ever. True: it goes on. */
static bool mark_circulating(uint8_t *at, const uint8_t *end)
{
    struct datagram d;

    do {
        unsigned word;

        if (!datagram_at(at, end, &d))
            return false;
        word = get_u16(d.header + 6);
        if (word & DG_CIRCULATING)
            return false;
        put_u16(d.header + 6, word | DG_CIRCULATING);
        at = d.wkc + DG_WKC;
    } while (d.more);
    return true;
}

/* What travels: at NULL, something that is not EtherCAT; end NULL, EtherCAT without datagrams. */
struct cargo {
    uint8_t *frame, *at;
    const uint8_t *end;
};

/* By `count` slaves of the route. False: one of them destroyed it. */
static bool pass_route(struct segment *segment, const struct route *route, size_t count,
                       const struct cargo *cargo, uint64_t now_ns)
{
    bool rerouted = false;

    if (count && route->turned && cargo->end && !mark_circulating(cargo->at, cargo->end))
        return false;
    for (size_t i = route->first; i < route->first + count; i++) {
        struct slave *s = &segment->slaves[i];
        bool forwarding = s->memory[REG_DL_CONTROL] & DL_CONTROL_FORWARDING;

        slave_meet(s, now_ns + s->delay_ns);
        if (!cargo->at) {
            /* Not for processing units: a slave told so destroys it, others let it through. */
            if (forwarding)
                return false;
            continue;
        }
        if (forwarding)
            cargo->frame[SOURCE_MAC] |= LOCAL_BIT;
        if (cargo->end)
            pass_slave(s, cargo->at, cargo->end);
        rerouted |= s->rerouted;
    }
    if (rerouted)
        segment->routes_until_ns = 0;
    return true;
}

/* False: not a frame that a processing unit takes; it is destroyed at the first one. */
static bool inspect(uint8_t *frame, size_t length, struct cargo *cargo)
{
    uint16_t header = get_u16(frame + ETHER_HEADER);
    size_t claimed = header & ECAT_LENGTH;

    *cargo = (struct cargo){ frame, NULL, NULL };
    if (get_u16(frame + ETHER_TYPE) != ETHER_ECAT)
        return true;
    cargo->at = frame + ETHER_HEADER + ECAT_HEADER;
    if (header >> 12 != ECAT_DATAGRAMS)
        return true;
    if (claimed > length - ETHER_HEADER - ECAT_HEADER)
        return false;
    cargo->end = cargo->at + claimed;
    return well_formed(cargo->at, cargo->end);
}

/* A frame that all slaves process, one after the other, and that comes back as it should. */
static bool plain(const struct segment *segment, const struct route *route)
{
    return route->end - route->first == segment->count && route->returns && !route->turned &&
           !route->knocks && segment->damage == SEGMENT_NO_CABLE;
}

bool segment_transfer(struct segment *segment, enum segment_port *port, uint8_t *frame,
                      size_t length, uint64_t now_ns, uint64_t *back_ns)
{
    const struct route *route = &segment->route[*port];
    struct cargo cargo;
    bool damaged = false;
    size_t count;

    if (length < SEGMENT_FRAME_MIN || length > SEGMENT_FRAME_MAX)
        return false;
    if (now_ns >= segment->routes_until_ns)
        topology_update(segment, now_ns);
    count = route->end - route->first;
    if (back_ns)
        *back_ns = now_ns + (length + ETHER_OVERHEAD) * BYTE_NS + route->trip_ns;
    if (plain(segment, route) && plan_transfer(segment, frame, length, now_ns)) {
        *port = route->exit;
        return true;
    }
    if (segment->damage != SEGMENT_NO_CABLE)
        count = topology_damage(segment, *port, &damaged);
    if (!inspect(frame, length, &cargo) && route->end != route->first) {
        if (count)
            registers_count(&segment->slaves[route->first], REG_PU_ERRORS);
        return false;
    }
    if (!pass_route(segment, route, count, &cargo, now_ns) || damaged)
        return false;
    topology_knock(segment, route);
    if (!route->returns)
        return false;
    *port = route->exit;
    return true;
}
