/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Where things are in the process image: the mapping as the slaves tell it, over CoE or, without
 * CoE, in the PDO categories of their SII. */
#include "bus/client.h"
#include "bus/bytes.h"

#include <errno.h>
#include <string.h>

static int add(struct client_map *map, uint32_t *at, uint16_t index, uint8_t subindex, uint8_t bits)
{
    struct client_entry *entry = &map->entry[map->count];

    /* Gaps only take room. */
    if (index) {
        if (map->count == CLIENT_ENTRIES)
            return -EOVERFLOW;
        *entry = (struct client_entry){ index, subindex, bits, *at };
        map->count++;
    }
    *at += bits;
    return 0;
}

static int sdo_number(struct bus *bus, size_t slave, uint16_t index, uint8_t subindex,
                      uint32_t *value)
{
    uint8_t bytes[4] = { 0 };
    size_t size = sizeof bytes;
    int error = bus_sdo_read(bus, slave, index, subindex, bytes, &size, NULL);

    *value = get_u32(bytes);
    return error;
}

static int coe_pdo(struct bus *bus, size_t slave, struct client_map *map, uint16_t pdo,
                   uint32_t *at)
{
    uint32_t count, entry;
    int error = sdo_number(bus, slave, pdo, 0, &count);

    for (unsigned i = 1; !error && i <= count; i++) {
        error = sdo_number(bus, slave, pdo, (uint8_t)i, &entry);
        if (!error)
            error = add(map, at, (uint16_t)(entry >> 16), (uint8_t)(entry >> 8), (uint8_t)entry);
    }
    return error;
}

/* SM n is assigned by object 0x1C10 + n; which of them carry process data says 0x1C00. */
static int coe_map(struct bus *bus, size_t slave)
{
    uint32_t managers, type, count, pdo, at[2] = { 0, 0 };
    int error = sdo_number(bus, slave, ECT_SDO_SMCOMMTYPE, 0, &managers);

    for (unsigned n = 2; !error && n < managers; n++) {
        enum bus_direction direction;

        error = sdo_number(bus, slave, ECT_SDO_SMCOMMTYPE, (uint8_t)(n + 1), &type);
        if (error || (type != SII_SM_OUTPUTS && type != SII_SM_INPUTS))
            continue;
        direction = type == SII_SM_OUTPUTS ? BUS_OUTPUT : BUS_INPUT;
        error = sdo_number(bus, slave, (uint16_t)(ECT_SDO_PDOASSIGN + n), 0, &count);
        for (unsigned i = 1; !error && i <= count; i++) {
            error = sdo_number(bus, slave, (uint16_t)(ECT_SDO_PDOASSIGN + n), (uint8_t)i, &pdo);
            if (!error && pdo)
                error =
                    coe_pdo(bus, slave, &bus->map[slave][direction], (uint16_t)pdo, &at[direction]);
        }
        at[direction] = (at[direction] + 7) & ~7u;
    }
    return error;
}

/* One byte at a time and in this order: every first touch of a place is a frame on the bus, and C
 * leaves the order inside an expression to the compiler. */
static void sii_bytes(struct bus *bus, size_t slave, unsigned at, uint8_t *bytes, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        bytes[i] = ecx_siigetbyte(&bus->context, (uint16)(slave + 1), (uint16)(at + i));
}

/* One walk over a PDO category for one sync manager. Headers and entries have eight bytes each. */
static int sii_manager(struct bus *bus, size_t slave, struct client_map *map, unsigned body,
                       unsigned end, unsigned manager, uint32_t *at)
{
    uint8_t pdo[8], entry[8];
    int error = 0;

    while (!error && body + sizeof pdo <= end) {
        sii_bytes(bus, slave, body, pdo, sizeof pdo);
        body += sizeof pdo;
        for (unsigned i = 0; i < pdo[2] && !error && body + sizeof entry <= end; i++) {
            sii_bytes(bus, slave, body, entry, sizeof entry);
            body += sizeof entry;
            if (pdo[3] == manager)
                error = add(map, at, get_u16(entry), entry[2], entry[5]);
        }
    }
    return error;
}

static int sii_map(struct bus *bus, size_t slave, enum bus_direction direction)
{
    uint16 category = direction == BUS_OUTPUT ? ECT_SII_PDO + 1 : ECT_SII_PDO;
    int at_length = ecx_siifind(&bus->context, (uint16)(slave + 1), category);
    uint8_t words[2];
    uint32_t at = 0;
    int error = 0;

    if (at_length <= 0)
        return 0;
    sii_bytes(bus, slave, (unsigned)at_length, words, sizeof words);
    for (unsigned manager = 0; !error && manager < EC_MAXSM; manager++) {
        unsigned body = (unsigned)at_length + 2;
        unsigned end = body + 2u * get_u16(words);

        error = sii_manager(bus, slave, &bus->map[slave][direction], body, end, manager, &at);
        at = (at + 7) & ~7u;
    }
    return error;
}

static bool has_controlword(const struct client_map *map, unsigned axis)
{
    for (unsigned i = 0; i < map->count; i++) {
        const struct client_entry *e = &map->entry[i];

        if (e->index == 0x6040 + 0x800 * axis && e->subindex == 0 && e->bits == 16)
            return true;
    }
    return false;
}

/* Axis n + 1 exists only next to axis n: 0x7040 of a terminal is not axis 3. */
static void count_axes(struct bus *bus, size_t slave)
{
    unsigned axes = 0;

    while (axes < 8 && has_controlword(&bus->map[slave][BUS_OUTPUT], axes))
        axes++;
    bus->slave[slave].axes = axes;
}

int client_map_read(struct bus *bus, size_t index)
{
    int error;

    if (bus->slavelist[index + 1].mbx_proto & ECT_MBXPROT_COE) {
        error = coe_map(bus, index);
    } else {
        error = sii_map(bus, index, BUS_OUTPUT);
        if (!error)
            error = sii_map(bus, index, BUS_INPUT);
    }
    if (!error)
        count_axes(bus, index);
    return error;
}

struct bus_entry bus_bits(const struct bus *bus, size_t slave, enum bus_direction direction,
                          unsigned first, unsigned count)
{
    struct bus_entry entry = { NULL, 0, 0 };
    const ec_slavet *s;
    const uint8 *soem;
    unsigned total, at;

    if (slave >= bus->slave_count || !count || count > 64)
        return entry;
    s = &bus->slavelist[slave + 1];
    total = direction == BUS_OUTPUT ? s->Obits : s->Ibits;
    if (count > total || first > total - count)
        return entry;
    at = first + (direction == BUS_OUTPUT ? s->Ostartbit : s->Istartbit);
    soem = (direction == BUS_OUTPUT ? s->outputs : s->inputs) + at / 8;
    entry.byte = bus->image + (soem - bus->iomap);
    entry.bit = (uint8_t)(at % 8);
    entry.bits = (uint8_t)count;
    return entry;
}

struct bus_entry bus_find(const struct bus *bus, size_t slave, enum bus_direction direction,
                          uint16_t index, uint8_t subindex)
{
    struct bus_entry none = { NULL, 0, 0 };

    if (slave >= bus->slave_count)
        return none;
    for (unsigned i = 0; i < bus->map[slave][direction].count; i++) {
        const struct client_entry *e = &bus->map[slave][direction].entry[i];

        if (e->index == index && e->subindex == subindex)
            return bus_bits(bus, slave, direction, e->first, e->bits);
    }
    return none;
}

bool bus_entry_at(const struct bus *bus, size_t slave, enum bus_direction direction, unsigned n,
                  struct bus_mapped *entry)
{
    const struct client_entry *e;

    if (slave >= bus->slave_count || n >= bus->map[slave][direction].count)
        return false;
    e = &bus->map[slave][direction].entry[n];
    *entry = (struct bus_mapped){ .index = e->index,
                                  .subindex = e->subindex,
                                  .first = e->first,
                                  .place =
                                      bus_bits(bus, slave, direction, e->first, e->bits) };
    return true;
}

/* The one group begins at logical address 0, laid out like the image. */
uint32_t bus_logical_address(const struct bus *bus, size_t slave, enum bus_direction direction)
{
    struct bus_entry first = bus_bits(bus, slave, direction, 0, 1);

    return first.bits ? (uint32_t)(first.byte - bus->image) : 0;
}

uint64_t bus_entry_get(struct bus_entry entry)
{
    if (entry.bit == 0) {
        switch (entry.bits) {
        case 8:
            return *entry.byte;
        case 16:
            return get_u16(entry.byte);
        case 32:
            return get_u32(entry.byte);
        case 64:
            return get_u64(entry.byte);
        }
    }
    if (entry.bits == 1)
        return (unsigned)*entry.byte >> entry.bit & 1u;
    return get_bits(entry.byte, entry.bit, entry.bits);
}

int64_t bus_entry_sign(struct bus_entry entry)
{
    unsigned unused = 64u - entry.bits;

    if (!entry.bits)
        return 0;
    return (int64_t)(bus_entry_get(entry) << unused) >> unused;
}

void bus_entry_set(struct bus_entry entry, uint64_t value)
{
    if (entry.bit == 0) {
        switch (entry.bits) {
        case 8:
            *entry.byte = (uint8_t)value;
            return;
        case 16:
            put_u16(entry.byte, (uint16_t)value);
            return;
        case 32:
            put_u32(entry.byte, (uint32_t)value);
            return;
        case 64:
            put_u64(entry.byte, value);
            return;
        }
    }
    if (entry.bits == 1)
        *entry.byte = (uint8_t)((*entry.byte & ~(1u << entry.bit)) | (value & 1u) << entry.bit);
    else
        put_bits(entry.byte, entry.bit, entry.bits, value);
}
