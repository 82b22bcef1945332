/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

static void decode(struct fmmu *fmmu, const uint8_t *r)
{
    uint32_t start = get_u32(r);
    uint16_t length = get_u16(r + 4);
    uint8_t type = r[11];

    memset(fmmu, 0, sizeof *fmmu);
    fmmu->first = start;
    fmmu->last = start + length - 1;
    fmmu->first_bit = r[6] & 7;
    fmmu->last_bit = r[7] & 7;
    fmmu->physical = get_u16(r + 8);
    fmmu->physical_bit = r[10] & 7;
    fmmu->reads = type & 1;
    fmmu->writes = type & 2;
    fmmu->bytewise = fmmu->first_bit == 0 && fmmu->last_bit == 7 && fmmu->physical_bit == 0;
    /* A mapping that wraps round the logical space or has no bit in it maps nothing. */
    fmmu->active = (r[12] & 1) && length && fmmu->last >= fmmu->first &&
                   !(length == 1 && fmmu->last_bit < fmmu->first_bit);
}

static void summarise(struct slave *slave)
{
    slave->fmmu_end = 0;
    slave->fmmu_crossed = false;
    slave->logical_first = UINT32_MAX;
    slave->logical_last = 0;
    for (unsigned i = 0; i < SLAVE_FMMUS; i++) {
        const struct fmmu *a = &slave->fmmu[i];

        if (!a->active)
            continue;
        slave->fmmu_end = (uint8_t)(i + 1);
        if (a->first < slave->logical_first)
            slave->logical_first = a->first;
        if (a->last > slave->logical_last)
            slave->logical_last = a->last;
        slave->fmmu_crossed |= a->reads && a->writes;
        for (unsigned k = 0; k < SLAVE_FMMUS; k++) {
            const struct fmmu *b = &slave->fmmu[k];

            if (b->active && a->reads && b->writes && a->first <= b->last && b->first <= a->last)
                slave->fmmu_crossed = true;
        }
    }
}

bool fmmu_write_registers(struct slave *slave, uint16_t address, const uint8_t *data, size_t length)
{
    memcpy(slave->memory + address, data, length);
    for (unsigned i = 0; i < SLAVE_FMMUS; i++)
        decode(&slave->fmmu[i], slave->memory + REG_FMMU + (size_t)i * FMMU_SIZE);
    summarise(slave);
    return true;
}

/* The part of one mapping that a datagram touches. */
struct overlap {
    uint32_t bit_in_data;
    uint32_t bit_in_memory; /* of the whole address space */
    uint32_t bits;
};

static bool overlap_of(const struct fmmu *fmmu, uint32_t address, size_t length, struct overlap *o)
{
    uint64_t first = (uint64_t)fmmu->first * 8 + fmmu->first_bit;
    uint64_t last = (uint64_t)fmmu->last * 8 + fmmu->last_bit;
    uint64_t from = (uint64_t)address * 8;
    uint64_t to = from + (uint64_t)length * 8 - 1;
    uint64_t begin = first > from ? first : from;
    uint64_t end = last < to ? last : to;

    if (!fmmu->active || begin > end)
        return false;
    o->bit_in_data = (uint32_t)(begin - from);
    o->bit_in_memory =
        (uint32_t)((uint64_t)fmmu->physical * 8 + fmmu->physical_bit + (begin - first));
    o->bits = (uint32_t)(end - begin + 1);
    return true;
}

static void copy_bits(uint8_t *to, uint32_t to_bit, const uint8_t *from, uint32_t from_bit,
                      uint32_t bits)
{
    while (bits) {
        unsigned n = bits < 32 ? bits : 32;

        put_bits(to, to_bit, n, get_bits(from, from_bit, n));
        to_bit += n;
        from_bit += n;
        bits -= n;
    }
}

/* Bytes of memory that `o` covers: at most a frame's data plus the two partly covered ends. */
#define SPAN_MAX 1536

static bool map_read(struct slave *slave, const struct fmmu *fmmu, const struct overlap *o,
                     uint8_t *data)
{
    uint32_t first = o->bit_in_memory / 8;
    uint32_t last = (o->bit_in_memory + o->bits - 1) / 8;
    uint8_t bytes[SPAN_MAX];

    if (last > 0xffff)
        return false;
    if (fmmu->bytewise)
        return slave_read(slave, (uint16_t)first, data + o->bit_in_data / 8, last - first + 1);
    /* Bytes that cannot be read must leave the datagram alone. */
    memset(bytes, 0, last - first + 1);
    if (!slave_read(slave, (uint16_t)first, bytes, last - first + 1))
        return false;
    copy_bits(data, o->bit_in_data, bytes, o->bit_in_memory % 8, o->bits);
    return true;
}

static bool map_write(struct slave *slave, const struct fmmu *fmmu, const struct overlap *o,
                      const uint8_t *data)
{
    uint32_t first = o->bit_in_memory / 8;
    uint32_t last = (o->bit_in_memory + o->bits - 1) / 8;
    uint8_t bytes[SPAN_MAX];

    if (last > 0xffff)
        return false;
    if (fmmu->bytewise)
        return slave_write(slave, (uint16_t)first, data + o->bit_in_data / 8, last - first + 1);
    /* Bits of the same physical bytes that this mapping does not reach keep their value. */
    for (uint32_t a = first; a <= last; a++)
        bytes[a - first] = syncman_peek(slave, a);
    copy_bits(bytes, o->bit_in_memory % 8, data, o->bit_in_data, o->bits);
    return slave_write(slave, (uint16_t)first, bytes, last - first + 1);
}

static unsigned run_mappings(struct slave *slave, uint32_t address, uint8_t *to,
                             const uint8_t *from, size_t length, bool reads, bool writes)
{
    unsigned done = 0;

    for (unsigned i = 0; i < slave->fmmu_end; i++) {
        const struct fmmu *fmmu = &slave->fmmu[i];
        struct overlap o;

        if (!((reads && fmmu->reads) || (writes && fmmu->writes)) ||
            !overlap_of(fmmu, address, length, &o))
            continue;
        slave_catch_up(slave);
        /* Old content goes out, new content comes in: read first. */
        if (reads && fmmu->reads && map_read(slave, fmmu, &o, to))
            done |= 1;
        if (writes && fmmu->writes && map_write(slave, fmmu, &o, from))
            done |= 2;
    }
    return done;
}

unsigned slave_logical(struct slave *slave, uint32_t address, uint8_t *data, size_t length,
                       bool reads, bool writes)
{
    uint8_t incoming[SPAN_MAX];

    if (!slave->fmmu_end || !length || length > SPAN_MAX ||
        slave->logical_first > slave->logical_last || address > slave->logical_last ||
        (uint64_t)address + length <= slave->logical_first)
        return 0;
    /* Overlapping input and output areas: writes must see the data as it came in. */
    if (reads && writes && slave->fmmu_crossed) {
        memcpy(incoming, data, length);
        return run_mappings(slave, address, data, incoming, length, reads, writes);
    }
    return run_mappings(slave, address, data, data, length, reads, writes);
}
