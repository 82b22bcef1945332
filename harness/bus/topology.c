/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/topology.h"
#include "bus/slave_parts.h"

#include <string.h>

/* A frame under way: on a cable, bound up (towards port B) or down (towards port A). */
struct walk {
    size_t cable;
    bool up;
    struct slave *slave; /* that it has come to */
    unsigned port;       /* there */
    bool processed;
};

enum walked { WALK_ON, WALK_OUT, WALK_LOST };

static bool cable_linked(const struct segment *segment, size_t cable)
{
    if (segment->cut[cable])
        return false;
    if (cable > 0 && !segment->slaves[cable - 1].powered)
        return false;
    return cable < segment->count ? segment->slaves[cable].powered : segment->ring;
}

static bool walk_begin(const struct segment *segment, enum segment_port from, struct walk *walk)
{
    memset(walk, 0, sizeof *walk);
    walk->up = from == SEGMENT_PORT_A;
    walk->cable = walk->up ? 0 : segment->count;
    return segment->count && cable_linked(segment, walk->cable);
}

/* Along the cable and through the slave at its end, if there is one. */
static enum walked walk_step(const struct segment *segment, struct walk *walk)
{
    const struct port *port;
    size_t at = walk->up ? walk->cable : walk->cable - 1;
    unsigned out;

    walk->slave = NULL;
    walk->processed = false;
    if (walk->cable == (walk->up ? segment->count : 0))
        return WALK_OUT;
    walk->slave = &segment->slaves[at];
    walk->port = walk->up ? 0 : 1;
    port = walk->slave->port;
    if (port[walk->port].closed)
        return WALK_LOST;
    walk->processed = walk->port == 0 || port[0].closed;
    out = port[1 - walk->port].closed ? walk->port : 1 - walk->port;
    walk->up = out == 1;
    walk->cable = at + out;
    return port[out].link ? WALK_ON : WALK_LOST;
}

static void find_route(struct segment *segment, enum segment_port from)
{
    struct route *route = &segment->route[from];
    struct walk walk;
    enum walked walked = WALK_ON;

    memset(route, 0, sizeof *route);
    if (!walk_begin(segment, from, &walk))
        return;
    while (walked == WALK_ON) {
        size_t at;

        route->trip_ns += SEGMENT_HOP_NS;
        walked = walk_step(segment, &walk);
        if (walked == WALK_LOST && walk.slave->port[walk.port].closed) {
            route->knocks = walk.slave;
            route->knock_port = walk.port;
        }
        if (!walk.processed)
            continue;
        at = (size_t)(walk.slave - segment->slaves);
        if (route->first == route->end)
            route->first = at;
        route->end = at + 1;
        route->turned |= walk.port == 1 && ports_turn_round(walk.slave);
    }
    route->returns = walked == WALK_OUT;
    route->exit = walk.up ? SEGMENT_PORT_B : SEGMENT_PORT_A;
}

/* Tells the slaves of a route when its frames come by, and at which ports. A frame that nobody
 * processes concerns nobody. */
static void tell_slaves(struct segment *segment, enum segment_port from)
{
    const struct route *route = &segment->route[from];
    struct walk walk;
    uint32_t after_ns = 0;

    if (route->first == route->end || !walk_begin(segment, from, &walk))
        return;
    for (enum walked walked = WALK_ON; walked == WALK_ON;) {
        struct slave *s;

        after_ns += SEGMENT_HOP_NS;
        walked = walk_step(segment, &walk);
        s = walk.slave;
        if (!s || s->port[walk.port].closed)
            continue;
        s->port[walk.port].hears = true;
        if (walk.port == 1)
            s->port1_ns = (int32_t)after_ns;
        if (walk.processed)
            s->delay_ns = after_ns;
    }
    for (size_t i = route->first; i < route->end; i++)
        segment->slaves[i].port1_ns -= (int32_t)segment->slaves[i].delay_ns;
}

static void wire_links(struct segment *segment)
{
    for (size_t i = 0; i < segment->count; i++) {
        ports_link(&segment->slaves[i], 0, cable_linked(segment, i));
        ports_link(&segment->slaves[i], 1, cable_linked(segment, i + 1));
    }
}

void topology_update(struct segment *segment, uint64_t now_ns)
{
    segment->routes_until_ns = SLAVE_NEVER;
    segment->plans.changes++;
    wire_links(segment);
    for (size_t i = 0; i < segment->count; i++) {
        struct slave *s = &segment->slaves[i];

        ports_run(s, now_ns);
        if (s->loops_until_ns < segment->routes_until_ns)
            segment->routes_until_ns = s->loops_until_ns;
        s->rerouted = false;
        s->port[0].hears = s->port[1].hears = false;
        s->port1_ns = 0;
    }
    /* No slave is processed on both routes: what reaches its port 0 cannot find it closed. */
    for (unsigned from = SEGMENT_PORT_A; from <= SEGMENT_PORT_B; from++) {
        find_route(segment, (enum segment_port)from);
        tell_slaves(segment, (enum segment_port)from);
    }
}

static void count_damage(struct slave *s, unsigned port, bool first, bool processed)
{
    registers_count(s, first ? REG_RX_ERRORS + 2 * port : REG_FORWARDED_ERRORS + port);
    if (processed)
        registers_count(s, REG_PU_ERRORS);
}

size_t topology_damage(struct segment *segment, enum segment_port port, bool *damaged)
{
    const struct route *route = &segment->route[port];
    size_t good = 0;
    bool bad = false;
    struct walk walk;
    enum walked walked = WALK_ON;

    *damaged = false;
    if (!walk_begin(segment, port, &walk))
        return route->end - route->first;
    while (walked == WALK_ON) {
        bool first = !bad && walk.cable == segment->damage;

        bad |= first;
        walked = walk_step(segment, &walk);
        if (!walk.slave || walk.slave->port[walk.port].closed)
            break;
        if (bad)
            count_damage(walk.slave, walk.port, first, walk.processed);
        else
            good += walk.processed;
    }
    *damaged = bad;
    if (bad)
        segment->damage = SEGMENT_NO_CABLE;
    return good;
}

void topology_knock(struct segment *segment, const struct route *route)
{
    if (route->knocks && ports_knock(route->knocks, route->knock_port))
        segment->routes_until_ns = 0;
}

void segment_close_ring(struct segment *segment, bool ring, uint64_t now_ns)
{
    segment->ring = ring;
    topology_update(segment, now_ns);
}

void segment_cable(struct segment *segment, size_t behind, bool plugged, uint64_t now_ns)
{
    if (behind > segment->count)
        return;
    segment->cut[behind] = !plugged;
    topology_update(segment, now_ns);
}

void segment_power(struct segment *segment, size_t slave, bool on, uint64_t now_ns)
{
    struct slave *s;

    if (slave >= segment->count || segment->slaves[slave].powered == on)
        return;
    s = &segment->slaves[slave];
    if (on)
        slave_power_on(s, now_ns);
    else
        slave_power_off(s, now_ns);
    topology_update(segment, now_ns);
}

void segment_damage_next(struct segment *segment, size_t behind)
{
    segment->damage = behind <= segment->count ? behind : SEGMENT_NO_CABLE;
}

void segment_init(struct segment *segment, struct slave *slaves, size_t count)
{
    memset(segment, 0, sizeof *segment);
    segment->slaves = slaves;
    segment->count = count < SEGMENT_SLAVES ? count : SEGMENT_SLAVES;
    segment->damage = SEGMENT_NO_CABLE;
    for (size_t i = 0; i < segment->count; i++)
        slaves[i].changes = &segment->plans.changes;
    topology_update(segment, 0);
}
