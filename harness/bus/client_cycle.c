/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What happens while the bus runs: process data, states, SDOs. Nothing here allocates. */
#include "bus/client.h"

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

int bus_set_input(struct bus *bus, size_t slave, unsigned channel, int64_t value)
{
    struct slave *s = &bus->slaves[slave];

    if (slave >= bus->slave_count || !s->type->set_input)
        return -EINVAL;
    slave_advance(s, bus->clock.now_ns);
    return s->type->set_input(s->device, channel, value);
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

void bus_poll_state(struct bus *bus, size_t slave)
{
    struct bus_clock *previous;
    ec_alstatust status = { 0, 0, 0 };

    if (slave >= bus->slave_count)
        return;
    previous = bus_clock_enter(&bus->clock);
    /* A slave that does not answer has no state: both stay 0. */
    ecx_FPRD(&bus->port, bus->slavelist[slave + 1].configadr, ECT_REG_ALSTAT, sizeof status,
             &status, EC_TIMEOUTRET);
    bus->slave[slave].al_state = etohs(status.alstatus);
    bus->slave[slave].al_code = etohs(status.alstatuscode);
    bus_clock_enter(previous);
}

static bool has_coe(const struct bus *bus, size_t slave)
{
    return slave < bus->slave_count && (bus->slavelist[slave + 1].mbx_proto & ECT_MBXPROT_COE);
}

/* SOEM tells the reason of a failed SDO only through its error list. */
static int sdo_result(struct bus *bus, int wkc, uint32_t *abort)
{
    ec_errort error;
    int result = wkc > 0 ? 0 : -ETIMEDOUT;

    while (ecx_poperror(&bus->context, &error)) {
        if (wkc > 0)
            continue;
        if (error.Etype == EC_ERR_TYPE_SDO_ERROR) {
            result = -EPROTO;
            if (abort)
                *abort = (uint32_t)error.AbortCode;
        } else if (error.Etype == EC_ERR_TYPE_PACKET_ERROR) {
            result = error.ErrorCode == 3 ? -ENOSPC : -EBADMSG;
        } else if (error.Etype == EC_ERR_TYPE_MBX_ERROR) {
            result = -EBADMSG;
        }
    }
    return result;
}

int bus_sdo_read(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, void *data,
                 size_t *size, uint32_t *abort)
{
    struct bus_clock *previous;
    int room = *size > INT32_MAX ? INT32_MAX : (int)*size;
    int result;

    if (abort)
        *abort = 0;
    if (!has_coe(bus, slave))
        return slave < bus->slave_count ? -EOPNOTSUPP : -EINVAL;
    previous = bus_clock_enter(&bus->clock);
    result = ecx_SDOread(&bus->context, (uint16)(slave + 1), index, subindex, FALSE, &room, data,
                         EC_TIMEOUTRXM);
    result = sdo_result(bus, result, abort);
    bus_clock_enter(previous);
    if (!result)
        *size = (size_t)room;
    return result;
}

int bus_sdo_write(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex, const void *data,
                  size_t size, uint32_t *abort)
{
    struct bus_clock *previous;
    int result;

    if (abort)
        *abort = 0;
    if (!has_coe(bus, slave) || size > INT32_MAX)
        return slave < bus->slave_count ? -EOPNOTSUPP : -EINVAL;
    previous = bus_clock_enter(&bus->clock);
    result = ecx_SDOwrite(&bus->context, (uint16)(slave + 1), index, subindex, FALSE, (int)size,
                          data, EC_TIMEOUTRXM);
    result = sdo_result(bus, result, abort);
    bus_clock_enter(previous);
    return result;
}
