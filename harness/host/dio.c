/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The DIO register groups: digital terminals, their bits in words as the generation has them. */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>

static void words(const struct host *host, size_t slave, enum bus_direction direction,
                  unsigned bits, struct bus_entry entries[DIO_WORDS])
{
    for (unsigned word = 0; word < DIO_WORDS; word++) {
        const unsigned first = word * DIO_WORD_BITS;
        const unsigned left = first >= bits ? 0 : bits - first;
        const unsigned count = left < DIO_WORD_BITS ? left : DIO_WORD_BITS;
        entries[word] = count > 0 ? bus_bits(host->bus, slave, direction, first, count)
                                  : (struct bus_entry){ 0 };
    }
}

static int dio_open(struct host *host, char why[HOST_WHY])
{
    DIO *dios = host->memory[SHARED_MEMORY_DIO];
    for (size_t i = 0; host->bus != NULL && i < bus_slave_count(host->bus); i++) {
        const struct bus_slave *slave = bus_slave(host->bus, i);
        if (wire_axes(host->bus, host->config.plant, i) > 0 ||
            slave->input_bits + slave->output_bits == 0)
            continue;
        if (host->terminal_count == HOST_TERMINALS) {
            snprintf(why, HOST_WHY, "more than %d I/O units on the bus", HOST_TERMINALS);
            return -E2BIG;
        }
        struct terminal *terminal = &host->terminals[host->terminal_count];
        terminal->reg = &dios[host->terminal_count];
        terminal->slave = i;
        words(host, i, BUS_INPUT, slave->input_bits, terminal->in);
        words(host, i, BUS_OUTPUT, slave->output_bits, terminal->out);
        terminal->reg->Number = (dio_word)host->terminal_count;
        terminal->reg->Node = (dio_word)i + 1;
        terminal->reg->NumberIn = (dio_word)((slave->input_bits + 7) / 8);
        terminal->reg->NumberOut = (dio_word)((slave->output_bits + 7) / 8);
        terminal->reg->ECATBusPosition = (uint32_t)i;
        host->terminal_count++;
    }
    return 0;
}

static void dio_receive(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++) {
        struct terminal *terminal = &host->terminals[i];
        DIO *reg = terminal->reg;
        dio_word *in = DIO_IN(reg);
        reg->EtherCATState = bus_slave(host->bus, terminal->slave)->al_state & 0x0Fu;
        reg->Status = reg->EtherCATState == ETHERCAT_STATE_OP;
        for (unsigned word = 0; word < DIO_WORDS; word++)
            if (terminal->in[word].bits > 0)
                in[word] = (dio_word)bus_entry_get(terminal->in[word]);
    }
}

static void dio_send(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++) {
        struct terminal *terminal = &host->terminals[i];
        const dio_word *out = DIO_OUT(terminal->reg);
        for (unsigned word = 0; word < DIO_WORDS; word++)
            if (terminal->out[word].bits > 0)
                bus_entry_set(terminal->out[word], (uint64_t)(uint32_t)out[word]);
    }
}

const struct host_part host_dio = {
    .name = "dio", .open = dio_open, .receive = dio_receive, .send = dio_send
};
