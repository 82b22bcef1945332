/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The DIO register groups: digital terminals, one octet to a word as generation 4 has it. */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>

static void octets(const struct host *host, size_t slave, enum bus_direction direction,
                   unsigned bits, struct bus_entry entries[16])
{
    for (unsigned octet = 0; octet < 16; octet++) {
        const unsigned first = octet * 8;
        const unsigned count = first >= bits ? 0 : bits - first < 8 ? bits - first : 8;
        entries[octet] = count > 0 ? bus_bits(host->bus, slave, direction, first, count)
                                   : (struct bus_entry){ 0 };
    }
}

int dio_open(struct host *host, char why[HOST_WHY])
{
    DIO *dios = host->memory[SHARED_MEMORY_DIO];
    for (size_t i = 0; i < bus_slave_count(host->bus); i++) {
        const struct bus_slave *slave = bus_slave(host->bus, i);
        if (slave->axes > 0 || slave->input_bits + slave->output_bits == 0)
            continue;
        if (host->terminal_count == HOST_TERMINALS) {
            snprintf(why, HOST_WHY, "more than %d I/O units on the bus", HOST_TERMINALS);
            return -E2BIG;
        }
        struct terminal *terminal = &host->terminals[host->terminal_count];
        terminal->reg = &dios[host->terminal_count];
        terminal->slave = i;
        octets(host, i, BUS_INPUT, slave->input_bits, terminal->in);
        octets(host, i, BUS_OUTPUT, slave->output_bits, terminal->out);
        terminal->reg->Number = (int32_t)host->terminal_count;
        terminal->reg->Node = (int32_t)i + 1;
        terminal->reg->NumberIn = (int32_t)((slave->input_bits + 7) / 8);
        terminal->reg->NumberOut = (int32_t)((slave->output_bits + 7) / 8);
        terminal->reg->ECATBusPosition = (uint32_t)i;
        host->terminal_count++;
    }
    return 0;
}

void dio_receive(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++) {
        struct terminal *terminal = &host->terminals[i];
        DIO *reg = terminal->reg;
        int32_t *in = &reg->In0; /* In0..In7, Ext_In0..Ext_In7 follow one another: static asserts of
                                    the layout */
        reg->EtherCATState = bus_slave(host->bus, terminal->slave)->al_state & 0x0Fu;
        reg->Status = reg->EtherCATState == ETHERCAT_STATE_OP;
        for (unsigned octet = 0; octet < 16; octet++)
            if (terminal->in[octet].bits > 0)
                in[octet] = (int32_t)bus_entry_get(terminal->in[octet]);
    }
}

void dio_send(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++) {
        struct terminal *terminal = &host->terminals[i];
        const int32_t *out = &terminal->reg->Out0;
        for (unsigned octet = 0; octet < 16; octet++)
            if (terminal->out[octet].bits > 0)
                bus_entry_set(terminal->out[octet], (uint64_t)(uint32_t)out[octet]);
    }
}
