/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The scenario as a part of the host: its names become places in the memories, its inputs channels
 * of slaves. What comes from the bus cannot be written in a memory, because the next receive
 * overwrites it: `set` of an input word acts on the inputs of the terminal (docs/decisions.md, H8).
 */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>

static int refuse(const struct host *host, const struct scenario_statement *st, char why[HOST_WHY],
                  const char *what)
{
    snprintf(why, HOST_WHY, "%.200s:%u:%u: %s", host->config.scenario->name, st->line,
             st->target != NULL ? st->target_column : st->column, what);
    return -EINVAL;
}

/* Which bit of the slave's input process data it is; the first. */
static unsigned bit_of(const struct host *host, size_t slave, struct bus_entry place)
{
    const struct bus_entry first = bus_bits(host->bus, slave, BUS_INPUT, 0, 1);
    return (unsigned)((place.byte - first.byte) * 8 + place.bit - first.bit);
}

static int channel_at(const struct host *host, size_t slave, struct bus_entry place,
                      unsigned behind)
{
    return bus_input_at(host->bus, slave, bit_of(host, slave, place) + behind);
}

/* The digital input that is bit `bit` of an input word: its channel, -1: there is none. */
static int word_channel(const struct host *host, const struct terminal *terminal, unsigned word,
                        unsigned bit)
{
    const struct terminal_side *side = &terminal->side[BUS_INPUT];
    for (unsigned i = 0; i < side->piece_count; i++) {
        const struct terminal_piece *piece = &side->pieces[i];
        if (piece->word == word && bit >= piece->shift && bit < piece->shift + piece->place.bits)
            return channel_at(host, terminal->slave, piece->place, bit - piece->shift);
    }
    return -1;
}

/* The element of an array of registers that an address is; `count`: it is none. */
static size_t element(const void *at, const void *array, size_t size, size_t count)
{
    const uintptr_t offset = (uintptr_t)at - (uintptr_t)array;
    return offset < size * count ? offset / size : count;
}

/* Every bit of the word is a channel of its own, in the order of the bits. */
static int bind_word(const struct host *host, const struct scenario_statement *st,
                     const struct terminal *terminal, unsigned word, struct play_route *route,
                     char why[HOST_WHY])
{
    const unsigned bits = terminal->side[BUS_INPUT].bits, first = word * DIO_WORD_BITS;
    const unsigned left = first < bits ? bits - first : 0;
    char what[160];
    *route = (struct play_route){ .slave = terminal->slave,
                                  .channels = left < DIO_WORD_BITS ? left : DIO_WORD_BITS,
                                  .word = true };
    for (unsigned bit = 0; bit < route->channels; bit++) {
        const int channel = word_channel(host, terminal, word, bit);
        if (bit == 0 && channel >= 0)
            route->channel = (unsigned)channel;
        if (channel < 0 || (unsigned)channel != route->channel + bit) {
            snprintf(what, sizeof what,
                     "not all of it is single inputs; expected 'input DIO[%zu] channel C = ...'",
                     (size_t)(terminal - host->terminals));
            return refuse(host, st, why, what);
        }
    }
    return left > 0 ? 0 : refuse(host, st, why, "the unit has no inputs there");
}

/* AI[n] and Ext_MeasureAmpl[n]. */
static int bind_analog(const struct host *host, const struct scenario_statement *st,
                       const struct terminal *terminal, struct bus_entry place,
                       struct play_route *route, char why[HOST_WHY])
{
    const int channel = place.bits > 0 ? channel_at(host, terminal->slave, place, 0) : -1;
    if (channel < 0)
        return refuse(host, st, why, "the unit has no input there");
    *route = (struct play_route){ .slave = terminal->slave,
                                  .channel = (unsigned)channel,
                                  .channels = 1 };
    return 0;
}

static int bind_set(const struct host *host, const struct scenario_statement *st,
                    struct play_route *route, char why[HOST_WHY])
{
    const void *at = host->play.at[st->reg];
    route->slave = PLAY_NO_SLAVE;
    for (size_t i = 0; i < host->terminal_count; i++) {
        const struct terminal *terminal = &host->terminals[i];
        const DIO *reg = terminal->reg;
        const size_t word = element(at, DIO_IN(reg), sizeof(dio_word), DIO_WORDS);
        const size_t analog = element(at, reg->AI, sizeof reg->AI[0], TERMINAL_ANALOG);
        const size_t gauge =
            element(at, reg->Ext_MeasureAmpl, sizeof reg->Ext_MeasureAmpl[0], TERMINAL_GAUGES);
        if (word < DIO_WORDS)
            return bind_word(host, st, terminal, (unsigned)word, route, why);
        if (analog < TERMINAL_ANALOG)
            return bind_analog(host, st, terminal, terminal->side[BUS_INPUT].analog[analog], route,
                               why);
        if (gauge < TERMINAL_GAUGES)
            return bind_analog(host, st, terminal, terminal->gauges[gauge], route, why);
    }
    return 0;
}

/* The slave of the group; NO_SLAVE with a sentence when there is none. */
static size_t slave_of(const struct host *host, const struct scenario_statement *st, char what[160])
{
    const size_t count = st->servo ? host->axis_count : host->terminal_count;
    size_t slave = NO_SLAVE;
    if (st->number < count)
        slave = st->servo ? host->axes[st->number].slave : host->terminals[st->number].slave;
    if (st->number >= count && count == 0)
        snprintf(what, 160, "there is no %s", st->servo ? "servo" : "I/O unit");
    else if (st->number >= count)
        snprintf(what, 160, "there is no such %s; expected 0 to %zu",
                 st->servo ? "servo" : "I/O unit", count - 1);
    else if (slave == NO_SLAVE)
        snprintf(what, 160, "a virtual servo has no inputs");
    return slave;
}

static int bind_input(const struct host *host, const struct scenario_statement *st,
                      struct play_route *route, char why[HOST_WHY])
{
    char what[160] = "";
    const size_t slave = slave_of(host, st, what);
    if (slave == NO_SLAVE)
        return refuse(host, st, why, what);
    const unsigned first = st->servo ? (host->axes[st->number].reg->Axis - 1) * 32 : 0;
    *route = (struct play_route){ .slave = slave,
                                  .channel = first + (unsigned)st->channel,
                                  .channels = 1 };
    if ((!st->servo || st->channel < 32) && bus_has_input(host->bus, slave, route->channel))
        return 0;
    snprintf(what, sizeof what, "slave %zu (%s) has no input %llu", slave + 1,
             bus_slave(host->bus, slave)->name, (unsigned long long)st->channel);
    return refuse(host, st, why, what);
}

static int bind_fault(const struct host *host, const struct scenario_statement *st,
                      char why[HOST_WHY])
{
    char place[160], reason[BUS_WHY];
    if (host->bus == NULL)
        return refuse(host, st, why, "there is no bus");
    snprintf(place, sizeof place, "%.120s:%u", host->config.scenario->name, st->line);
    if (bus_fault_check(host->bus, st->padded, place, reason) == 0)
        return 0;
    snprintf(why, HOST_WHY, "%s", reason);
    return -EINVAL;
}

static int bind_registers(struct host *host, char why[HOST_WHY])
{
    const struct scenario *scenario = host->config.scenario;
    for (size_t i = 0; i < scenario->register_count; i++) {
        const void *at = host_register(host, &scenario->registers[i].reg);
        if (at == NULL) {
            snprintf(why, HOST_WHY, "%.200s: %s has no %s", scenario->name,
                     host->config.product->title, scenario->registers[i].name);
            return -EINVAL;
        }
        host->play.at[i] = (void *)(uintptr_t)at;
    }
    return 0;
}

static void control(void *argument, enum scenario_control what)
{
    struct host *host = argument;
    const enum host_plc now = host_plc(host);
    switch (what) {
    case CONTROL_STOP:
        host_stop(host);
        break;
    case CONTROL_PAUSE:
        host_pause(host, true);
        break;
    case CONTROL_RELOAD:
        host_run(host);
        break;
    case CONTROL_RUN:
        host_pause(host, false);
        if (now == HOST_PLC_STOPPED || now == HOST_PLC_ERROR)
            host_run(host);
        break;
    }
}

static int scene_open(struct host *host, char why[HOST_WHY])
{
    const struct scenario *scenario = host->config.scenario;
    struct play *play = &host->play;
    if (scenario == NULL)
        return 0;
    play->evidence = host->evidence;
    play->bus = host->bus;
    play->control = control;
    play->control_argument = host;
    play->cycle_ns = host->config.cycle_us * UINT64_C(1000);
    play->scenario = scenario;
    int r = bind_registers(host, why);
    for (size_t i = 0; i < scenario->statement_count && r == 0; i++) {
        const struct scenario_statement *st = &scenario->statements[i];
        if (st->kind == SCENARIO_SET)
            r = bind_set(host, st, &play->route[i], why);
        else if (st->kind == SCENARIO_INPUT)
            r = bind_input(host, st, &play->route[i], why);
        else if (st->kind == SCENARIO_FAULT)
            r = bind_fault(host, st, why);
    }
    if (r == 0)
        play_begin(play, 0);
    return r;
}

static void scene_cycle(struct host *host)
{
    if (host->play.scenario == NULL)
        return;
    host->play.bus_zero = host->bus_zero;
    play_before(&host->play, host->cycle, host->now_ns);
}

static void scene_receive(struct host *host)
{
    if (host->play.scenario != NULL)
        play_received(&host->play, host->cycle, host->now_ns);
}

/* A cycle's expectations count at its begin, whichever slot they are judged in. */
static void scene_sample(struct host *host)
{
    if (host->play.scenario != NULL)
        play_after(&host->play, host->cycle, host->cycle * host->config.cycle_us * UINT64_C(1000));
}

const struct host_part host_scene = {
    .name = "scene",
    .open = scene_open,
    .cycle = scene_cycle,
    .receive = scene_receive,
    .sample = scene_sample,
};
