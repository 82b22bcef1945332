/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The DIO register groups. What a terminal has is read from its mapping (C8): entries up to 8 bits
 * are digital, in words as the generation has them; 16 bits are analog; inputs of 32 bits are
 * strain gauges, outputs of 32 bits analog. Small entries of the object that an analog value
 * belongs to are its status and no inputs. RxBuffer and TxBuffer are memory: there is no serial
 * terminal.
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>

enum { DIGITAL_BITS = DIO_WORDS * DIO_WORD_BITS };

static bool is_analog(const struct bus_mapped *entry)
{
    return entry->place.bits == 16 || entry->place.bits == 32;
}

static bool is_status(const struct host *host, size_t slave, enum bus_direction direction,
                      const struct bus_mapped *entry)
{
    struct bus_mapped other;
    for (unsigned n = 0; bus_entry_at(host->bus, slave, direction, n, &other); n++)
        if (other.index == entry->index && is_analog(&other))
            return true;
    return false;
}

/* The place lies right behind the last piece, on the wire as in its word: one piece then. */
static bool joined(struct terminal_side *side, const struct terminal_piece *next)
{
    if (side->piece_count == 0)
        return false;
    struct terminal_piece *last = &side->pieces[side->piece_count - 1];
    if (next->word != last->word || next->shift != last->shift + last->place.bits ||
        (next->place.byte - last->place.byte) * 8 + next->place.bit !=
            last->place.bit + last->place.bits)
        return false;
    last->place.bits = (uint8_t)(last->place.bits + next->place.bits);
    return true;
}

/* Digital bits go into words one after the other; a piece of a word each. */
static bool add_bits(struct host *host, struct terminal *terminal, enum bus_direction direction,
                     unsigned first, unsigned count)
{
    struct terminal_side *side = &terminal->side[direction];
    while (count > 0) {
        const unsigned shift = side->bits % DIO_WORD_BITS;
        const unsigned room = DIO_WORD_BITS - shift, part = count < room ? count : room;
        if (side->bits + part > DIGITAL_BITS)
            return false;
        const struct terminal_piece piece = {
            .place = bus_bits(host->bus, terminal->slave, direction, first, part),
            .word = (uint8_t)(side->bits / DIO_WORD_BITS),
            .shift = (uint8_t)shift,
        };
        if (!joined(side, &piece)) {
            if (side->piece_count == TERMINAL_PIECES)
                return false;
            side->pieces[side->piece_count++] = piece;
        }
        side->bits += part;
        first += part;
        count -= part;
    }
    return true;
}

static bool add_analog(struct terminal *terminal, enum bus_direction direction,
                       const struct bus_mapped *entry)
{
    struct terminal_side *side = &terminal->side[direction];
    if (direction == BUS_INPUT && entry->place.bits == 32) {
        if (terminal->gauge_count == TERMINAL_GAUGES)
            return false;
        terminal->gauges[terminal->gauge_count++] = entry->place;
        return true;
    }
    if (side->analog_count == TERMINAL_ANALOG)
        return false;
    side->analog[side->analog_count++] = entry->place;
    return true;
}

/* False when this is no plain I/O terminal. */
static bool read_side(struct host *host, struct terminal *terminal, enum bus_direction direction)
{
    struct bus_mapped entry;
    for (unsigned n = 0; bus_entry_at(host->bus, terminal->slave, direction, n, &entry); n++) {
        bool fits = true;
        if (is_analog(&entry))
            fits = add_analog(terminal, direction, &entry);
        else if (entry.place.bits == 0 || entry.place.bits > 8)
            fits = false;
        else if (!is_status(host, terminal->slave, direction, &entry))
            fits = add_bits(host, terminal, direction, entry.first, entry.place.bits);
        if (!fits)
            return false;
    }
    return true;
}

#if TGM_GENERATION == 4
/* There is nothing else that such a slave could be: its bits as they lie, as many as there is room
 * for. */
static void raw_bits(struct host *host, struct terminal *terminal)
{
    const struct bus_slave *slave = bus_slave(host->bus, terminal->slave);
    const unsigned most = DIGITAL_BITS;
    *terminal = (struct terminal){ .slave = terminal->slave };
    add_bits(host, terminal, BUS_INPUT, 0, slave->input_bits < most ? slave->input_bits : most);
    add_bits(host, terminal, BUS_OUTPUT, 0, slave->output_bits < most ? slave->output_bits : most);
}
#endif

static void publish(struct host *host, struct terminal *terminal)
{
    DIO *dios = host->memory[SHARED_MEMORY_DIO];
    DIO *reg = terminal->reg = &dios[host->terminal_count];
    const struct terminal_side *in = &terminal->side[BUS_INPUT], *out = &terminal->side[BUS_OUTPUT];
    reg->Number = (dio_word)host->terminal_count;
    reg->Node = (dio_word)terminal->slave + 1;
    reg->NumberIn = (dio_word)((in->bits + 7) / 8);
    reg->NumberOut = (dio_word)((out->bits + 7) / 8);
    reg->NumberAI = in->analog_count;
    reg->NumberAO = out->analog_count;
    reg->Number_MeasureAmpl = terminal->gauge_count;
    reg->ECATBusPosition = (uint32_t)terminal->slave;
    host->terminal_count++;
}

/* Generation 5 has general devices for what is no plain terminal, and for terminals past those that
 * the configuration announces. */
static bool becomes_dio(struct host *host, struct terminal *terminal)
{
    const size_t slave = terminal->slave;
    bool plain;
#if TGM_GENERATION == 5
    const struct plant *plant = host->config.plant;
    if (host->terminal_count >= (plant->as_found ? HOST_TERMINALS : plant->dios))
        return false;
#endif
    plain = read_side(host, terminal, BUS_INPUT) && read_side(host, terminal, BUS_OUTPUT);
#if TGM_GENERATION == 4
    if (!plain)
        raw_bits(host, terminal);
    plain = true;
#endif
    host->taken[slave] = plain;
    return plain;
}

static int dio_open(struct host *host, char why[HOST_WHY])
{
    for (size_t i = 0; host->bus != NULL && i < bus_slave_count(host->bus); i++) {
        const struct bus_slave *slave = bus_slave(host->bus, i);
        struct terminal terminal = { .slave = i };
        if (host->taken[i] || wire_axes(host->bus, host->config.plant, i) > 0 ||
            slave->input_bits + slave->output_bits == 0)
            continue;
        if (!becomes_dio(host, &terminal))
            continue;
        if (host->terminal_count == HOST_TERMINALS) {
            snprintf(why, HOST_WHY, "more than %d I/O units on the bus", HOST_TERMINALS);
            return -E2BIG;
        }
        host->terminals[host->terminal_count] = terminal;
        publish(host, &host->terminals[host->terminal_count]);
    }
    return 0;
}

/* The first fault stays until it is reset: what the slave controller says of its state. */
static void note_error(DIO *reg, const struct bus_slave *slave)
{
    if ((slave->al_state & 0x10) != 0 && reg->Error == 0)
        reg->Error = (dio_word)slave->al_code;
    if (((uint32_t)reg->Control & DIO_RESET_FAULT_BIT0) == 0)
        return;
    reg->Error = 0;
    reg->Control = (dio_word)((uint32_t)reg->Control & ~(uint32_t)DIO_RESET_FAULT_BIT0);
}

static void terminal_receive(struct host *host, struct terminal *terminal)
{
    DIO *reg = terminal->reg;
    const struct bus_slave *slave = bus_slave(host->bus, terminal->slave);
    const struct terminal_side *side = &terminal->side[BUS_INPUT];
    dio_word *in = DIO_IN(reg);
    reg->EtherCATState = slave->al_state & 0x0Fu;
    reg->Status = reg->EtherCATState == ETHERCAT_STATE_OP;
    note_error(reg, slave);
    for (unsigned i = 0; i < side->piece_count; i++) {
        const struct terminal_piece *piece = &side->pieces[i];
        const uint32_t bits = (uint32_t)bus_entry_get(piece->place) << piece->shift;
        in[piece->word] = (dio_word)(piece->shift == 0 ? bits : (uint32_t)in[piece->word] | bits);
    }
    for (unsigned i = 0; i < side->analog_count; i++)
        reg->AI[i] = (int32_t)bus_entry_sign(side->analog[i]);
    for (unsigned i = 0; i < terminal->gauge_count; i++)
        reg->Ext_MeasureAmpl[i] = (int32_t)bus_entry_sign(terminal->gauges[i]);
}

static void terminal_send(struct terminal *terminal)
{
    const struct terminal_side *side = &terminal->side[BUS_OUTPUT];
    const dio_word *out = DIO_OUT(terminal->reg);
    for (unsigned i = 0; i < side->piece_count; i++)
        bus_entry_set(side->pieces[i].place,
                      (uint32_t)out[side->pieces[i].word] >> side->pieces[i].shift);
    for (unsigned i = 0; i < side->analog_count; i++)
        bus_entry_set(side->analog[i], (uint64_t)(int64_t)terminal->reg->AO[i]);
}

static void dio_receive(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++)
        terminal_receive(host, &host->terminals[i]);
}

/* A controlled stop takes all outputs to 0 (R12). */
static void outputs_off(DIO *reg)
{
    for (unsigned word = 0; word < DIO_WORDS; word++)
        DIO_OUT(reg)[word] = 0;
    for (unsigned i = 0; i < TERMINAL_ANALOG; i++)
        reg->AO[i] = 0;
}

static void dio_send(struct host *host)
{
    for (size_t i = 0; i < host->terminal_count; i++) {
        if (host->system->Main.SafetyEvent == MAIN_SAFETYEVENT_CONTROLLED_STOP)
            outputs_off(host->terminals[i].reg);
        terminal_send(&host->terminals[i]);
    }
}

const struct host_part host_dio = {
    .name = "dio", .open = dio_open, .receive = dio_receive, .send = dio_send
};
