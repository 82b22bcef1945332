/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * bytes.h - little-endian fields in byte buffers: everything on an EtherCAT wire, in an SII and in
 * a mailbox is little-endian and unaligned, whatever the host is.
 */
#ifndef HARNESS_BUS_BYTES_H
#define HARNESS_BUS_BYTES_H

#include <stdint.h>

static inline uint16_t get_u16(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t get_u32(const uint8_t *p)
{
    return (uint32_t)get_u16(p) | (uint32_t)get_u16(p + 2) << 16;
}

static inline uint64_t get_u64(const uint8_t *p)
{
    return (uint64_t)get_u32(p) | (uint64_t)get_u32(p + 4) << 32;
}

static inline void put_u16(uint8_t *p, uint32_t value)
{
    p[0] = (uint8_t)value;
    p[1] = (uint8_t)(value >> 8);
}

static inline void put_u32(uint8_t *p, uint32_t value)
{
    put_u16(p, value & 0xffff);
    put_u16(p + 2, value >> 16);
}

static inline void put_u64(uint8_t *p, uint64_t value)
{
    put_u32(p, (uint32_t)value);
    put_u32(p + 4, (uint32_t)(value >> 32));
}

/* Bits first .. first + count - 1 of a bit string; bit 0 is bit 0 of byte 0. count <= 64. */
static inline uint64_t get_bits(const uint8_t *p, uint32_t first, unsigned count)
{
    uint64_t value = 0;

    for (unsigned i = 0; i < count; i++) {
        uint32_t bit = first + i;

        value |= (uint64_t)((p[bit / 8] >> (bit % 8)) & 1) << i;
    }
    return value;
}

static inline void put_bits(uint8_t *p, uint32_t first, unsigned count, uint64_t value)
{
    for (unsigned i = 0; i < count; i++) {
        uint32_t bit = first + i;
        uint8_t mask = (uint8_t)(1u << (bit % 8));

        if ((value >> i) & 1)
            p[bit / 8] |= mask;
        else
            p[bit / 8] &= (uint8_t)~mask;
    }
}

#endif
