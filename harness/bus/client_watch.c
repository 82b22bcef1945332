/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The states of the slaves: read when asked, and with supervision on brought back to OP. The steps
 * are those that SOEM's own sample takes in a thread of its own: lost slaves are recovered by their
 * place and identity, fallen ones configured again, errors acknowledged.
 */
#include "bus/bytes.h"
#include "bus/client.h"

#include <errno.h>
#include <string.h>

enum {
    SILENT_POLLS = 3,       /* so many lost frames in a row make a lost slave */
    RETRY_NS = 10000000,    /* pause between two tries with one slave */
    GRACE_NS = 300000000,   /* what the first way to OP may take */
    OP_TIMEOUT_US = 200000, /* patience for OP: drives want outputs first */
    ACK_TIMEOUT_US = 20000,
};

static void take_state(struct bus *bus, size_t index)
{
    const ec_slavet *seen = &bus->slavelist[index + 1];
    struct bus_slave *slave = &bus->slave[index];

    slave->al_state = seen->state;
    slave->al_code = seen->ALstatuscode;
    if (!slave->al_state && !slave->lost)
        slave->losses++;
    slave->lost = !slave->al_state;
}

/* SOEM does not tell a lost frame from lost slaves: one datagram to all says whether anybody is
 * there to be asked. */
static void poll(struct bus *bus)
{
    uint16 all = 0;
    int wkc = ecx_BRD(&bus->port, 0, ECT_REG_ALSTAT, sizeof all, &all, EC_TIMEOUTRET);

    if (wkc == EC_NOFRAME && ++bus->silent < SILENT_POLLS)
        return;
    bus->silent = 0;
    if (wkc == (int)bus->slave_count && etohs(all) == AL_OP)
        for (int i = 1; i <= bus->slavecount; i++) {
            bus->slavelist[i].state = AL_OP;
            bus->slavelist[i].ALstatuscode = 0;
        }
    else
        ecx_readstate(&bus->context);
    for (size_t i = 0; i < bus->slave_count; i++)
        take_state(bus, i);
}

int client_startup(struct bus *bus, size_t index, const struct bus_startup **refused,
                   uint32_t *abort)
{
    for (size_t i = 0; i < bus->startup_count; i++) {
        const struct bus_startup *s = &bus->startup[i];
        struct bus_job write = { .kind = BUS_SDO_WRITE,
                                 .slave = index,
                                 .index = s->index,
                                 .subindex = s->subindex,
                                 .size = s->size };
        int error;

        if (s->slave != index)
            continue;
        for (unsigned k = 0; k < s->size && k < sizeof s->value; k++)
            write.data[k] = (uint8_t)(s->value >> 8 * k);
        error = client_sdo(bus, &write);
        if (error) {
            *refused = s;
            *abort = write.abort;
            return error;
        }
    }
    return 0;
}

/* Both clocks in one frame: what lies between is the way from one to the other. */
static bool read_clocks(struct bus *bus, uint16 reference, uint16 slave, uint8_t times[2][8])
{
    uint8 index = ecx_getindex(&bus->port);
    uint16 second;
    int wkc;

    ecx_setupdatagram(&bus->port, &bus->port.txbuf[index], EC_CMD_FPRD, index, reference,
                      ECT_REG_DCSYSTIME, 8, times[0]);
    second = (uint16)ecx_adddatagram(&bus->port, &bus->port.txbuf[index], EC_CMD_FPRD, index, FALSE,
                                     slave, ECT_REG_DCSYSTIME, 8, times[1]);
    wkc = ecx_srconfirm(&bus->port, index, EC_TIMEOUTRET);
    memcpy(times[0], &bus->port.rxbuf[index][EC_HEADERSIZE], 8);
    memcpy(times[1], &bus->port.rxbuf[index][second], 8);
    ecx_setbufstat(&bus->port, index, EC_BUF_EMPTY);
    return wkc > 0;
}

/* A slave that was switched off has lost offset and delay of its clock. The others are running and
 * must not be touched, so nothing is measured again: the line has not grown. */
int client_restore_clock(struct bus *bus, size_t index)
{
    const ec_slavet *slave = &bus->slavelist[index + 1];
    const ec_slavet *reference = &bus->slavelist[bus->slavelist[0].DCnext];
    uint8_t times[2][8] = { { 0 } }, offset[8] = { 0 };

    if (!slave->hasdc || slave == reference)
        return 0;
    ecx_FPWR(&bus->port, slave->configadr, ECT_REG_DCSYSOFFSET, sizeof offset, offset,
             EC_TIMEOUTRET);
    if (!read_clocks(bus, reference->configadr, slave->configadr, times))
        return -ETIMEDOUT;
    put_u64(offset,
            get_u64(times[0]) + (uint64_t)(slave->pdelay - reference->pdelay) - get_u64(times[1]));
    ecx_FPWR(&bus->port, slave->configadr, ECT_REG_DCSYSOFFSET, sizeof offset, offset,
             EC_TIMEOUTRET);
    put_u32(offset, (uint32_t)slave->pdelay);
    ecx_FPWR(&bus->port, slave->configadr, ECT_REG_DCSYSDELAY, 4, offset, EC_TIMEOUTRET);
    /* Its control loop has pulled towards the wrong time meanwhile: from the beginning. */
    ecx_FPWRw(&bus->port, slave->configadr, ECT_REG_DCSPEEDCNT, htoes(0x1000), EC_TIMEOUTRET);
    if (bus->dc_sync && bus->slave[index].axes)
        ecx_dcsync0(&bus->context, (uint16)(index + 1), TRUE, bus->cycle_ns,
                    (int32)(bus->cycle_ns / 2));
    return 0;
}

static bool asked(struct bus *bus)
{
    if (!bus->poll)
        return false;
    bus->poll = false;
    poll(bus);
    return true;
}

static void request(struct bus *bus, size_t index, unsigned state, int timeout_us)
{
    uint16 slave = (uint16)(index + 1);

    bus->slavelist[slave].state = (uint16)state;
    ecx_writestate(&bus->context, slave);
    ecx_statecheck(&bus->context, slave, (uint16)(state & AL_STATE), timeout_us);
}

/* Found at its place, and the same device: it has its station address again. */
static bool found(struct bus *bus, size_t index)
{
    return ecx_recover_slave(&bus->context, (uint16)(index + 1), EC_TIMEOUTRET) > 0;
}

static void bring_back(struct bus *bus, size_t index)
{
    struct bus_slave *slave = &bus->slave[index];

    bus->care_ns[index] = bus->clock.now_ns + RETRY_NS;
    if (slave->lost && !found(bus, index))
        return;
    poll(bus);
    if (slave->al_state & AL_ERROR && (slave->al_state & AL_STATE) >= AL_SAFEOP)
        request(bus, index, (slave->al_state & AL_STATE) | AL_ERROR, ACK_TIMEOUT_US);
    else if (slave->al_state && (slave->al_state & AL_STATE) < AL_SAFEOP)
        ecx_reconfig_slave(&bus->context, (uint16)(index + 1), EC_TIMEOUTRET);
    poll(bus);
    if (slave->al_state == AL_SAFEOP)
        request(bus, index, AL_OP, OP_TIMEOUT_US);
    poll(bus);
    if (slave->al_state == AL_OP)
        slave->recoveries++;
    bus->care_ns[index] = bus->clock.now_ns + RETRY_NS;
}

static bool supervised(struct bus *bus)
{
    for (size_t i = 0; bus->supervise && i < bus->slave_count; i++) {
        if (bus->slave[i].al_state == AL_OP || bus->clock.now_ns < bus->care_ns[i])
            continue;
        bring_back(bus, i);
        return true;
    }
    return false;
}

/* Supervision comes last: its waits are long, and an SDO of the module must not stand behind the
 * patience for a slave that is gone for more than one of them. */
bool client_watch(struct bus *bus)
{
    return asked(bus) || (!bus->job_first && supervised(bus));
}

void bus_poll_states(struct bus *bus)
{
    bus->poll = true;
    if (bus->clock.wake_ns == BUS_CLOCK_NEVER)
        bus->clock.wake_ns = bus->clock.now_ns;
}

void bus_supervise(struct bus *bus, bool on)
{
    bus->supervise = on;
    for (size_t i = 0; i < bus->slave_count; i++)
        bus->care_ns[i] = bus->clock.now_ns + GRACE_NS;
}
