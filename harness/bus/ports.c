/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The two ports of a slave controller: links, loops, DL control and DL status. */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    LOOP_AUTO,       /* closed while there is no link */
    LOOP_AUTO_CLOSE, /* closes by itself, opens when told or when a frame comes in */
    LOOP_OPEN,
    LOOP_CLOSED,

    TEMPORARY = 1 << 1, /* in DL control: the loop settings go back after a second */
    TEMPORARY_NS = 1000000000,
    PORTS_2_AND_3_CLOSED = 0x5000, /* no such ports */
};

static unsigned loop_mode(const struct slave *slave, unsigned port)
{
    return slave->memory[REG_DL_CONTROL + 1] >> 2 * port & 3u;
}

static void set_loop(struct slave *slave, unsigned port, bool rewritten)
{
    struct port *p = &slave->port[port];
    bool before = p->closed;

    switch (loop_mode(slave, port)) {
    case LOOP_AUTO:
        p->closed = !p->link;
        break;
    case LOOP_AUTO_CLOSE:
        p->closed = !p->link || (p->closed && !rewritten);
        break;
    default:
        p->closed = loop_mode(slave, port) == LOOP_CLOSED;
    }
    slave->rerouted |= p->closed != before;
}

static void publish(struct slave *slave)
{
    uint8_t *m = slave->memory;
    unsigned before = get_u16(m + REG_DL_STATUS);
    unsigned status = PORTS_2_AND_3_CLOSED | DL_STATUS_WD_PDI | (before & DL_STATUS_PDI);

    for (unsigned p = 0; p < 2; p++) {
        if (slave->port[p].link)
            status |= 1u << (4 + p) | 2u << (8 + 2 * p);
        if (slave->port[p].closed)
            status |= 1u << (8 + 2 * p);
    }
    put_u16(m + REG_DL_STATUS, status);
    if (status != before)
        put_u16(m + REG_ECAT_EVENT, get_u16(m + REG_ECAT_EVENT) | EVENT_DL_STATUS);
}

void ports_reset(struct slave *slave)
{
    slave->loops_until_ns = SLAVE_NEVER;
    for (unsigned p = 0; p < 2; p++)
        set_loop(slave, p, true);
    publish(slave);
}

void ports_link(struct slave *slave, unsigned port, bool link)
{
    struct port *p = &slave->port[port];

    if (p->link == link)
        return;
    p->link = link;
    if (!slave->powered)
        return;
    if (!link)
        registers_count(slave, REG_LOST_LINK + port);
    set_loop(slave, port, false);
    publish(slave);
}

bool ports_turn_round(const struct slave *slave)
{
    return !slave->port[0].link && loop_mode(slave, 0) <= LOOP_AUTO_CLOSE;
}

bool ports_knock(struct slave *slave, unsigned port)
{
    if (loop_mode(slave, port) != LOOP_AUTO_CLOSE)
        return false;
    set_loop(slave, port, true);
    publish(slave);
    return true;
}

static void set_loops(struct slave *slave, uint8_t loops)
{
    slave->memory[REG_DL_CONTROL + 1] = loops;
    for (unsigned p = 0; p < 2; p++)
        set_loop(slave, p, true);
    publish(slave);
}

bool ports_write_control(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    uint8_t *r = slave->memory + REG_DL_CONTROL;
    uint8_t before = r[1];

    memcpy(slave->memory + address, data, length);
    r[0] &= DL_CONTROL_FORWARDING | TEMPORARY;
    if (address > REG_DL_CONTROL + 1 || address + length <= REG_DL_CONTROL + 1)
        return true;
    if (!(r[0] & TEMPORARY)) {
        slave->loops_until_ns = SLAVE_NEVER;
    } else {
        if (slave->loops_until_ns == SLAVE_NEVER)
            slave->loops_before = before;
        slave->loops_until_ns = slave->now_ns + TEMPORARY_NS;
    }
    set_loops(slave, r[1]);
    slave->rerouted = true;
    return true;
}

void ports_run(struct slave *slave, uint64_t now_ns)
{
    if (now_ns < slave->loops_until_ns)
        return;
    slave->loops_until_ns = SLAVE_NEVER;
    slave->memory[REG_DL_CONTROL] &= (uint8_t)~TEMPORARY;
    set_loops(slave, slave->loops_before);
}
