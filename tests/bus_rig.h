/* SPDX-License-Identifier: GPL-2.0-or-later */
/* bus_rig.h - a segment on the bench: slaves by type name, frames written by hand, time by hand. */
#ifndef TESTS_BUS_RIG_H
#define TESTS_BUS_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bus/bytes.h"
#include "bus/registers.h"
#include "bus/segment.h"
#include "bus/slave.h"
#include "bus/slave_parts.h"

enum { NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW };

#define RIG_MAX 8
#define HOP     ((uint32_t)SEGMENT_HOP_NS)

struct rig {
    struct segment segment;
    struct slave slaves[RIG_MAX];
    void *devices[RIG_MAX];
    size_t count;
    uint64_t now;
    /* The frame under construction, or the last one that came back. */
    uint8_t frame[SEGMENT_FRAME_MAX];
    size_t used;
    size_t last; /* header of the last datagram, 0 none */
};

static inline struct rig *rig_new(const char *const *types, size_t count)
{
    struct rig *rig = calloc(1, sizeof *rig);

    assert_non_null(rig);
    rig->count = count;
    for (size_t i = 0; i < count; i++) {
        struct slave_setup setup = { .type = device_type_find(types[i]),
                                     .seed = 1000 + i,
                                     .serial = (uint32_t)(i + 1) };

        assert_non_null(setup.type);
        setup.device = rig->devices[i] = calloc(1, setup.type->size);
        assert_non_null(setup.device);
        assert_int_equal(slave_init(&rig->slaves[i], &setup), 0);
    }
    segment_init(&rig->segment, rig->slaves, count);
    return rig;
}

static inline void rig_free(struct rig *rig)
{
    for (size_t i = 0; i < rig->count; i++)
        free(rig->devices[i]);
    free(rig);
}

static inline void frame_begin(struct rig *rig)
{
    static const uint8_t header[14] = { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x10,
                                        0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xa4 };

    memset(rig->frame, 0, sizeof rig->frame);
    memcpy(rig->frame, header, sizeof header);
    rig->used = 16;
    rig->last = 0;
    put_u16(rig->frame + 14, 1u << 12);
}

/* Returns the offset of the datagram's header in the frame. */
static inline size_t frame_add(struct rig *rig, uint8_t command, uint32_t address, const void *data,
                               size_t length)
{
    size_t at = rig->used;

    assert_true(at + 12 + length <= sizeof rig->frame);
    if (rig->last)
        put_u16(rig->frame + rig->last + 6, get_u16(rig->frame + rig->last + 6) | 0x8000u);
    rig->frame[at] = command;
    rig->frame[at + 1] = 0x5a;
    put_u32(rig->frame + at + 2, address);
    put_u16(rig->frame + at + 6, (uint32_t)length);
    if (data)
        memcpy(rig->frame + at + 10, data, length);
    rig->used = at + 12 + length;
    rig->last = at;
    put_u16(rig->frame + 14, (uint32_t)(rig->used - 16) | 1u << 12);
    return at;
}

/* *port: where the frame goes in, then where it came out. */
static inline bool frame_send_at(struct rig *rig, enum segment_port *port)
{
    size_t length = rig->used < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : rig->used;

    rig->now += 10000;
    return segment_transfer(&rig->segment, port, rig->frame, length, rig->now, NULL);
}

static inline bool frame_send(struct rig *rig)
{
    enum segment_port port = SEGMENT_PORT_A;

    return frame_send_at(rig, &port);
}

static inline unsigned frame_wkc(const struct rig *rig, size_t at)
{
    return get_u16(rig->frame + at + 10 + (get_u16(rig->frame + at + 6) & 0x07ff));
}

static inline const uint8_t *frame_data(const struct rig *rig, size_t at)
{
    return rig->frame + at + 10;
}

/* One datagram, one frame; data comes back in place. Returns the working counter. */
static inline unsigned exchange(struct rig *rig, uint8_t command, uint32_t address, void *data,
                                size_t length)
{
    size_t at;

    frame_begin(rig);
    at = frame_add(rig, command, address, data, length);
    assert_true(frame_send(rig));
    memcpy(data, frame_data(rig, at), length);
    return frame_wkc(rig, at);
}

#define AT(adp, ado) ((uint32_t)(uint16_t)(adp) | (uint32_t)(ado) << 16)

static inline unsigned write_u8(struct rig *rig, uint16_t station, uint16_t ado, uint8_t value)
{
    return exchange(rig, FPWR, AT(station, ado), &value, 1);
}

static inline unsigned write_u16(struct rig *rig, uint16_t station, uint16_t ado, uint16_t value)
{
    uint8_t bytes[2];

    put_u16(bytes, value);
    return exchange(rig, FPWR, AT(station, ado), bytes, 2);
}

static inline uint16_t read_u16(struct rig *rig, uint16_t station, uint16_t ado)
{
    uint8_t bytes[2] = { 0 };

    assert_int_equal(exchange(rig, FPRD, AT(station, ado), bytes, 2), 1);
    return get_u16(bytes);
}

static inline uint32_t read_u32(struct rig *rig, uint16_t station, uint16_t ado)
{
    uint8_t bytes[4] = { 0 };

    assert_int_equal(exchange(rig, FPRD, AT(station, ado), bytes, 4), 1);
    return get_u32(bytes);
}

/* Stations 0x1001, 0x1002, ... in wiring order. */
static inline void rig_address(struct rig *rig)
{
    for (size_t i = 0; i < rig->count; i++) {
        uint8_t bytes[2];

        put_u16(bytes, 0x1001u + (uint32_t)i);
        assert_int_equal(exchange(rig, APWR, AT(-(int)i, REG_STATION_ADDRESS), bytes, 2), 1);
    }
}

static inline void write_sm(struct rig *rig, uint16_t station, unsigned n, uint16_t start,
                            uint16_t length, uint8_t control, uint8_t activate)
{
    uint8_t sm[8] = { 0 };

    put_u16(sm, start);
    put_u16(sm + 2, length);
    sm[4] = control;
    sm[6] = activate;
    assert_int_equal(exchange(rig, FPWR, AT(station, REG_SM + n * SM_SIZE), sm, sizeof sm), 1);
}

static inline void write_fmmu(struct rig *rig, uint16_t station, unsigned n, uint32_t logical,
                              uint16_t length, uint8_t first_bit, uint8_t last_bit,
                              uint16_t physical, uint8_t physical_bit, uint8_t type)
{
    uint8_t f[16] = { 0 };

    put_u32(f, logical);
    put_u16(f + 4, length);
    f[6] = first_bit;
    f[7] = last_bit;
    put_u16(f + 8, physical);
    f[10] = physical_bit;
    f[11] = type;
    f[12] = 1;
    assert_int_equal(exchange(rig, FPWR, AT(station, REG_FMMU + n * FMMU_SIZE), f, sizeof f), 1);
}

static inline void rig_wait(struct rig *rig, uint64_t ns)
{
    rig->now += ns;
}

/* Asks for an AL state and lets the slave's application look at it. Returns AL status. */
static inline uint16_t al_request(struct rig *rig, uint16_t station, uint16_t control)
{
    write_u16(rig, station, REG_AL_CONTROL, control);
    rig_wait(rig, SLAVE_AL_NS);
    return read_u16(rig, station, REG_AL_STATUS);
}

static inline uint16_t al_code(struct rig *rig, uint16_t station)
{
    return read_u16(rig, station, REG_AL_STATUS_CODE);
}

/* A drive as SOEM configures it, up to the state before `state`'s own checks. */
static inline void drive_mailbox(struct rig *rig, uint16_t station)
{
    write_sm(rig, station, 0, 0x1000, 128, 0x26, 1);
    write_sm(rig, station, 1, 0x1080, 128, 0x22, 1);
}

static inline void drive_preop(struct rig *rig, uint16_t station)
{
    drive_mailbox(rig, station);
    assert_int_equal(al_request(rig, station, AL_PREOP), AL_PREOP);
}

static inline void drive_safeop(struct rig *rig, uint16_t station, uint32_t logical)
{
    drive_preop(rig, station);
    write_sm(rig, station, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, station, 3, 0x1200, 20, 0x20, 1);
    write_fmmu(rig, station, 0, logical, 8, 0, 7, 0x1100, 0, 2);
    write_fmmu(rig, station, 1, logical + 8, 20, 0, 7, 0x1200, 0, 1);
    assert_int_equal(al_request(rig, station, AL_SAFEOP), AL_SAFEOP);
}

/* --- SII and mailbox of a drive --- */

static inline uint16_t sii_command(struct rig *rig, uint16_t station, uint16_t command,
                                   uint32_t address)
{
    uint8_t request[6];

    put_u16(request, command);
    put_u32(request + 2, address);
    return (uint16_t)exchange(rig, FPWR, AT(station, REG_EEPROM_CONTROL), request, 6);
}

static inline bool mailbox_receive(struct rig *rig, uint16_t station, uint8_t box[128])
{
    rig_wait(rig, SLAVE_MAILBOX_NS);
    return exchange(rig, FPRD, AT(station, 0x1080), box, 128) == 1;
}

static inline void sdo_read_request(uint8_t box[128], uint8_t counter, uint16_t index)
{
    memset(box, 0, 128);
    put_u16(box, 10);
    box[5] = (uint8_t)(3 | counter << 4);
    put_u16(box + 6, 0x2000);
    box[8] = 0x40;
    put_u16(box + 9, index);
}

#endif
