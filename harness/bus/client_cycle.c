/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What happens while the bus runs: process data and the way to OP. Nothing here allocates. */
#include "bus/client.h"
#include "bus/terminal.h"

#include <errno.h>
#include <string.h>

uint64_t bus_now(const struct bus *bus)
{
    return bus->clock.now_ns;
}

size_t bus_slave_count(const struct bus *bus)
{
    return bus->slave_count;
}

const struct bus_slave *bus_slave(const struct bus *bus, size_t index)
{
    return index < bus->slave_count ? &bus->slave[index] : NULL;
}

void bus_send(struct bus *bus, uint64_t now_ns)
{
    struct bus_clock *previous = bus_clock_enter(&bus->clock);

    client_run_jobs(bus, now_ns);
    bus_clock_reach(&bus->clock, now_ns);
    /* SOEM adds the working counters of everything sent since the last receive. */
    if (bus->idxstack.pushed)
        ecx_receive_processdata(&bus->context, 0);
    memcpy(bus->iomap, bus->image, bus->grouplist[0].Obytes);
    ecx_send_processdata(&bus->context);
    bus_clock_enter(previous);
}

int bus_receive(struct bus *bus, uint64_t now_ns)
{
    struct bus_clock *previous = bus_clock_enter(&bus->clock);
    size_t inputs = bus->grouplist[0].Obytes;
    int wkc;

    client_run_jobs(bus, now_ns);
    bus_clock_reach(&bus->clock, now_ns);
    wkc = ecx_receive_processdata(&bus->context, (int)(bus->cycle_ns / 1000));
    bus_clock_enter(previous);
    if (wkc <= EC_NOFRAME)
        return -1;
    memcpy(bus->image + inputs, bus->iomap + inputs, bus->grouplist[0].Ibytes);
    return wkc;
}

int bus_expected_wkc(const struct bus *bus)
{
    return bus->grouplist[0].outputsWKC * 2 + bus->grouplist[0].inputsWKC;
}

struct bus_statistics bus_statistics(const struct bus *bus)
{
    return (struct bus_statistics){ .sent = bus->port.sent,
                                    .received = bus->port.received,
                                    .reference_ns = bus->dctime };
}

int bus_set_input(struct bus *bus, size_t slave, unsigned channel, int64_t value)
{
    struct slave *s = &bus->rack.slaves[slave];

    if (slave >= bus->slave_count || !s->type->set_input)
        return -EINVAL;
    slave_advance(s, bus->clock.now_ns);
    return s->type->set_input(s->device, channel, value);
}

bool bus_has_input(const struct bus *bus, size_t slave, unsigned channel)
{
    const struct slave *s = &bus->rack.slaves[slave];
    int64_t value;

    if (slave >= bus->slave_count || !s->type->set_input)
        return false;
    if (s->type->get_input)
        return s->type->get_input(s->device, channel, &value) == 0;
    return channel < s->type->input_count;
}

int bus_input_at(const struct bus *bus, size_t slave, unsigned bit)
{
    const struct slave *s = &bus->rack.slaves[slave];

    return slave < bus->slave_count && terminal_is(s->type) ? terminal_input_at(s->device, bit)
                                                            : -1;
}

void bus_faults_begin(struct bus *bus, uint64_t now_ns)
{
    faults_begin(bus->faults, now_ns);
}

int bus_fault(struct bus *bus, const char *text, uint64_t now_ns, char why[BUS_WHY])
{
    bus_clock_reach(&bus->clock, now_ns);
    bus->wire.faults = bus->faults;
    return faults_command(bus->faults, text, bus->clock.now_ns, why);
}

int bus_fault_check(const struct bus *bus, const char *text, const char *place, char why[BUS_WHY])
{
    return fault_check(text, &bus->rack.segment, place, why);
}

bool bus_fault_log(const struct bus *bus, uint64_t number, struct bus_fault_event *event)
{
    return faults_event(bus->faults, number, event);
}

static void write_state(struct bus *bus, size_t slave, unsigned state)
{
    bus->slavelist[slave].state = (uint16)state;
    ecx_writestate(&bus->context, (uint16)slave);
}

/* One broadcast, unless a slave shows an error: that one needs its acknowledge, and terminals that
 * copy AL control into AL status must not get one. */
void bus_request_op(struct bus *bus)
{
    struct bus_clock *previous = bus_clock_enter(&bus->clock);
    unsigned errors = 0;

    for (size_t i = 0; i < bus->slave_count; i++)
        errors |= bus->slave[i].al_state & AL_ERROR;
    if (!errors) {
        write_state(bus, 0, AL_OP);
    } else {
        for (size_t i = 0; i < bus->slave_count; i++)
            write_state(bus, i + 1, AL_OP | (bus->slave[i].al_state & AL_ERROR));
    }
    bus_clock_enter(previous);
}
