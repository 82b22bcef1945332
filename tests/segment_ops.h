/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * segment_ops.h - a segment of one slave of every kind, driven by a string of bytes: frames of any
 * content at either port, time, cables, power, damage, faults. Shared by the libFuzzer target and
 * by the long run. What must hold after every frame is checked; abort() tells.
 */
#ifndef TESTS_SEGMENT_OPS_H
#define TESTS_SEGMENT_OPS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bus/bytes.h"
#include "bus/segment.h"
#include "bus/slave.h"

enum { FIELD_LEAST = 5, FIELD_MOST = 12, FIELD_HEADER = 16, FIELD_STATION = 0x1001 };

#define FIELD_PATIENCE_NS UINT64_C(150000000)

struct field {
    struct segment segment, segment_fresh;
    struct slave *slaves, *slaves_fresh;
    uint8_t *devices, *devices_fresh; /* all instances, one behind the other */
    struct device_type types[FIELD_MOST];
    size_t device_bytes;
    size_t count;
    uint64_t now;
    uint64_t frames, back; /* sent and come back since field_init() */
};

struct ops {
    const uint8_t *at, *end;
};

static inline unsigned ops_u8(struct ops *ops)
{
    return ops->at < ops->end ? *ops->at++ : 0;
}

static inline unsigned ops_u16(struct ops *ops)
{
    unsigned low = ops_u8(ops);

    return low | ops_u8(ops) << 8;
}

static inline void ops_bytes(struct ops *ops, uint8_t *to, size_t count)
{
    size_t there = (size_t)(ops->end - ops->at);
    size_t n = count < there ? count : there;

    memcpy(to, ops->at, n);
    memset(to + n, 0, count - n);
    ops->at += n;
}

#define FIELD_MUST(condition)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #condition);         \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

static inline size_t device_room(const struct device_type *type)
{
    return (type->size + 63) & ~(size_t)63;
}

/* Somebody waits for pulses, so that they come one by one. */
static inline void take_pulse(void *device, unsigned signal, uint64_t now_ns)
{
    (void)device, (void)now_ns;
    FIELD_MUST(signal < 2);
}

static inline void field_init(struct field *field)
{
    size_t types = 0, at = 0;

    memset(field, 0, sizeof *field);
    while (types < FIELD_MOST && device_type(types))
        types++;
    field->count = types < FIELD_LEAST ? FIELD_LEAST : types;
    for (size_t i = 0; i < field->count; i++) {
        field->types[i] = *device_type(i % types);
        if (!field->types[i].sync)
            field->types[i].sync = take_pulse;
        field->device_bytes += device_room(&field->types[i]);
    }
    field->slaves = calloc(field->count, sizeof *field->slaves);
    field->slaves_fresh = calloc(field->count, sizeof *field->slaves);
    field->devices = calloc(1, field->device_bytes);
    field->devices_fresh = calloc(1, field->device_bytes);
    FIELD_MUST(field->slaves && field->slaves_fresh && field->devices && field->devices_fresh);
    for (size_t i = 0; i < field->count; i++) {
        struct slave_setup setup = { .type = &field->types[i],
                                     .device = field->devices + at,
                                     .seed = 0x9e3779b97f4a7c15u * (i + 1),
                                     .serial = (uint32_t)i + 1,
                                     .alias = (uint16_t)(0x700 + i) };

        FIELD_MUST(slave_init(&field->slaves[i], &setup) == 0);
        at += device_room(setup.type);
    }
    segment_init(&field->segment, field->slaves, field->count);
    field->segment_fresh = field->segment;
    memcpy(field->slaves_fresh, field->slaves, field->count * sizeof *field->slaves);
    memcpy(field->devices_fresh, field->devices, field->device_bytes);
}

static inline void field_reset(struct field *field)
{
    field->segment = field->segment_fresh;
    memcpy(field->slaves, field->slaves_fresh, field->count * sizeof *field->slaves);
    memcpy(field->devices, field->devices_fresh, field->device_bytes);
    field->now = 0;
}

/* Header fields nobody may touch, lengths, and working counters within what the slaves can give. */
static inline void check_frame(const struct field *field, const uint8_t *before,
                               const uint8_t *after, size_t length)
{
    size_t at = FIELD_HEADER, end = at + (get_u16(before + 14) & 0x07ffu);
    bool more = get_u16(before + 12) == 0xa488 && get_u16(before + 14) >> 12 == 1;

    FIELD_MUST(memcmp(before, after, 6) == 0 && (before[6] | 2) == (after[6] | 2));
    FIELD_MUST(memcmp(before + 7, after + 7, FIELD_HEADER - 7) == 0);
    while (more && at + 12 <= end && end <= length) {
        unsigned word = get_u16(before + at + 6);
        size_t wkc = at + 10 + (word & 0x07ff);
        unsigned counted;

        if (wkc + 2 > end)
            return; /* destroyed by the first processing unit; in a ring nobody looks */
        FIELD_MUST(before[at] == after[at] && before[at + 1] == after[at + 1]);
        FIELD_MUST((word | 0x4000) == (get_u16(after + at + 6) | 0x4000u));
        counted = (uint16_t)(get_u16(after + wkc) - get_u16(before + wkc));
        FIELD_MUST(counted <= 3 * field->count);
        more = word & 0x8000;
        at = wkc + 2;
    }
    if (at < length && !more)
        FIELD_MUST(memcmp(before + at, after + at, length - at) == 0);
}

/* On the heap with exactly its length under a sanitizer, so that every byte too far shows. */
static inline bool field_send(struct field *field, const uint8_t *frame, size_t length,
                              enum segment_port port, uint8_t *answer)
{
    enum segment_port at = port;
    uint64_t back_ns = 0;
    bool back;
#ifdef SEGMENT_OPS_EXACT
    uint8_t *air = malloc(length);

    FIELD_MUST(air);
#else
    static uint8_t air[SEGMENT_FRAME_MAX];
#endif
    memcpy(air, frame, length);
    field->frames++;
    field->now += 7000;
    back = segment_transfer(&field->segment, &at, air, length, field->now, &back_ns);
    if (back) {
        field->back++;
        FIELD_MUST(at == SEGMENT_PORT_A || (at == SEGMENT_PORT_B && field->segment.ring));
        FIELD_MUST(back_ns > field->now);
        check_frame(field, frame, air, length);
        if (answer)
            memcpy(answer, air, length);
    }
#ifdef SEGMENT_OPS_EXACT
    free(air);
#endif
    return back;
}

static inline void put_header(uint8_t *frame)
{
    static const uint8_t header[14] = { 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x10,
                                        0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xa4 };

    memcpy(frame, header, sizeof header);
}

/* One datagram in a frame of its own. */
static inline bool field_datagram(struct field *field, unsigned command, unsigned adp, unsigned ado,
                                  const void *data, size_t length)
{
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 };
    size_t used = FIELD_HEADER + 12 + length;

    put_header(frame);
    put_u16(frame + 14, (uint32_t)(12 + length) | 1u << 12);
    frame[16] = (uint8_t)command;
    put_u16(frame + 18, adp);
    put_u16(frame + 20, ado);
    put_u16(frame + 22, (uint32_t)length);
    if (data)
        memcpy(frame + 26, data, length);
    return field_send(field, frame, used < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : used,
                      SEGMENT_PORT_A, NULL);
}

/* Where something is to be found. */
static inline unsigned pick_address(const struct field *field, unsigned how, unsigned raw)
{
    static const uint16_t registers[] = {
        0x0000, 0x0008, 0x0010, 0x0012, 0x0020, 0x0030, 0x0040, 0x0100, 0x0101, 0x0108, 0x0110,
        0x0120, 0x0130, 0x0134, 0x0200, 0x0204, 0x0210, 0x0220, 0x0300, 0x030c, 0x0310, 0x0400,
        0x0410, 0x0420, 0x0440, 0x0442, 0x0500, 0x0502, 0x0508, 0x0600, 0x0610, 0x0800, 0x0808,
        0x0810, 0x0818, 0x080e, 0x080f, 0x0900, 0x0910, 0x0918, 0x0920, 0x0928, 0x092c, 0x0930,
        0x0934, 0x0980, 0x0981, 0x0984, 0x098e, 0x0990, 0x0998, 0x09a0, 0x09a4, 0x0f00, 0x0f10,
    };
    const struct sii_info *sii = field->slaves[raw % field->count].type->sii;

    switch (how & 3) {
    case 0:
        return raw;
    case 1:
        return registers[raw % (sizeof registers / sizeof *registers)];
    case 2:
        return REG_RAM + raw % (SLAVE_RAM_KIB * 1024 + 16);
    default:
        return sii->sm_count ? sii->sm[(raw >> 8) % sii->sm_count].start : raw;
    }
}

/* One to eight datagrams: command, how to address, address, length, data. */
static inline void op_frame(struct field *field, struct ops *ops, enum segment_port port)
{
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 };
    size_t at = FIELD_HEADER, last = 0;
    unsigned count = 1 + (ops_u8(ops) & 7);

    put_header(frame);
    while (count-- && at + 12 < sizeof frame) {
        unsigned command = ops_u8(ops), how = ops_u8(ops), raw = ops_u16(ops);
        unsigned length = how >= 0xf8 ? ops_u16(ops) & 0x07ff : how >> 4 & 7 ? ops_u8(ops) & 31 : 1;
        unsigned own = raw % (unsigned)field->count;

        if (at + 12 + length > sizeof frame)
            length = (unsigned)(sizeof frame - at - 12);
        if (last)
            put_u16(frame + last + 6, get_u16(frame + last + 6) | 0x8000u);
        frame[at] = (uint8_t)(command & 0x80 ? command : command % 16);
        frame[at + 1] = (uint8_t)raw;
        if (frame[at] >= 10 && frame[at] <= 12) {
            put_u32(frame + at + 2, how & 1 ? raw & 0x3ff : raw << 16 | raw);
        } else {
            put_u16(frame + at + 2, how & 4 ? 0u - own : how & 8 ? FIELD_STATION + own : 0u);
            put_u16(frame + at + 4, pick_address(field, how, raw));
        }
        put_u16(frame + at + 6, length | (command & 0x40 ? 0x4000u : 0));
        ops_bytes(ops, frame + at + 10, length);
        last = at;
        at += 12 + length;
    }
    put_u16(frame + 14, (uint32_t)(at - FIELD_HEADER) | 1u << 12);
    field_send(field, frame, at < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : at, port, NULL);
}

/* Any bytes behind the addresses, any lengths in them. */
static inline void op_raw(struct field *field, struct ops *ops)
{
    uint8_t frame[SEGMENT_FRAME_MAX];
    unsigned how = ops_u8(ops);
    size_t length = SEGMENT_FRAME_MIN + (how >= 0xf0 ? ops_u16(ops) % 1455 : ops_u8(ops) & 63);

    put_header(frame);
    ops_bytes(ops, frame + 12, length - 12);
    if (how & 2) {
        frame[12] = 0x88;
        frame[13] = 0xa4;
    }
    if (how & 4)
        put_u16(frame + 14, (get_u16(frame + 14) & 0x07ffu) | 1u << 12);
    if (how & 8)
        put_u16(frame + 14, ((uint32_t)length - FIELD_HEADER) | 1u << 12);
    field_send(field, frame, length, how & 0x10 ? SEGMENT_PORT_B : SEGMENT_PORT_A, NULL);
}

static inline void request_state(struct field *field, unsigned station, uint8_t state)
{
    uint8_t control[2] = { state | AL_ERROR, 0 };

    field_datagram(field, 5, station, REG_AL_CONTROL, control, 2);
    field->now += SLAVE_AL_NS;
    field_datagram(field, 4, station, REG_AL_STATUS, NULL, 6);
}

/* A slave on its way up as a master takes it, as far as `how` says. */
static inline void op_bring_up(struct field *field, struct ops *ops)
{
    unsigned which = ops_u8(ops) % (unsigned)field->count, how = ops_u8(ops);
    unsigned station = FIELD_STATION + which;
    const struct sii_info *sii = field->slaves[which].type->sii;
    uint32_t logical = (how & 0x40 ? 0 : which * 0x40);
    uint8_t bytes[64] = { 0 };

    put_u16(bytes, station);
    field_datagram(field, 2, 0u - which, REG_STATION_ADDRESS, bytes, 2);
    if (how & 0x80)
        request_state(field, station, AL_INIT);
    for (unsigned n = 0, fmmu = 0; n < sii->sm_count; n++) {
        const struct sii_sm *sm = &sii->sm[n];
        uint8_t r[16] = { 0 };

        put_u16(r, sm->start);
        put_u16(r + 2, sm->length);
        r[4] = sm->control;
        r[6] = sm->length && sm->type;
        field_datagram(field, 5, station, REG_SM + n * SM_SIZE, r, SM_SIZE);
        if (sm->type < SII_SM_OUTPUTS || !sm->length)
            continue;
        memset(r, 0, sizeof r);
        put_u32(r, logical);
        put_u16(r + 4, sm->length);
        r[7] = 7;
        put_u16(r + 8, sm->start);
        r[11] = sm->type == SII_SM_OUTPUTS ? 2 : 1;
        r[12] = 1;
        field_datagram(field, 5, station, REG_FMMU + fmmu++ * FMMU_SIZE, r, FMMU_SIZE);
        logical += sm->length;
    }
    request_state(field, station, AL_PREOP);
    if (how & 3)
        request_state(field, station, AL_SAFEOP);
    if (how & 2) {
        field_datagram(field, 12, (which * 0x40) & 0xffff, 0, bytes, sizeof bytes);
        request_state(field, station, AL_OP);
    }
}

/* A mailbox message of any body, most of them SDO requests of objects that exist; then its answer.
 */
static inline void op_mailbox(struct field *field, struct ops *ops)
{
    unsigned which = ops_u8(ops) % (unsigned)field->count, how = ops_u8(ops), raw = ops_u16(ops);
    unsigned station = FIELD_STATION + which;
    const struct device_type *type = field->slaves[which].type;
    const struct sii_mailbox *m = &type->sii->mailbox;
    uint8_t box[MAILBOX_MAX] = { 0 };

    if (!m->out_size || !type->od)
        return;
    ops_bytes(ops, box + 6, how & 0x40 ? m->out_size - 6u : 20u);
    put_u16(box, how & 0x80 ? raw : 10u + (how >> 2 & 7));
    box[5] = (uint8_t)(raw % 16 == 15 ? raw >> 4 : 3 | (field->frames % 7 + 1) << 4);
    if (how & 1) {
        put_u16(box + 6, how & 2 ? 0x8000 : 0x2000);
        put_u16(box + (how & 2 ? 12 : 9), type->od->objects[raw % type->od->count].index);
        if (how & 2)
            box[8] &= 7;
    }
    field_datagram(field, 5, station, m->out_start, box, m->out_size);
    field->now += SLAVE_MAILBOX_NS;
    field_datagram(field, 4, station, m->in_start, NULL, m->in_size);
}

static inline void op_trouble(struct field *field, struct ops *ops)
{
    struct segment *segment = &field->segment;
    unsigned what = ops_u8(ops), which = ops_u8(ops);
    struct slave *slave = &field->slaves[which % field->count];

    switch (what & 7) {
    case 0:
        segment_cable(segment, which % (field->count + 2), what & 8, field->now);
        break;
    case 1:
        segment_power(segment, which % (field->count + 1), what & 8, field->now);
        break;
    case 2:
        segment_damage_next(segment, which % (field->count + 2));
        break;
    case 3:
        segment_close_ring(segment, what & 8, field->now);
        break;
    case 4:
        slave->mute = what & 8;
        break;
    case 5:
        if (slave->type->fault && slave->powered)
            slave->type->fault(slave->device, what >> 3, (uint16_t)ops_u16(ops), slave->now_ns);
        break;
    case 6:
        if (slave->type->set_input)
            slave->type->set_input(slave->device, what >> 3, (int16_t)ops_u16(ops));
        break;
    default:
        mailbox_emergency(slave, (uint16_t)ops_u16(ops), (uint8_t)what, NULL);
    }
}

static inline void check_slaves(const struct field *field)
{
    for (size_t i = 0; i < field->count; i++) {
        const struct slave *s = &field->slaves[i];
        unsigned state = s->state;

        FIELD_MUST(state == AL_INIT || state == AL_PREOP || state == AL_SAFEOP || state == AL_OP);
        FIELD_MUST(!s->powered || s->memory[REG_TYPE] == 0x11);
        FIELD_MUST(s->type->al_emulation || !s->powered ||
                   (s->memory[REG_AL_STATUS] & AL_STATE) == state);
        FIELD_MUST(s->mailbox.queued <= MAILBOX_QUEUE && s->mailbox.emergencies <= EMERGENCIES);
    }
}

/* Plugged and switched on, everybody answers, whatever came before. */
static inline void check_revival(struct field *field)
{
    uint8_t frame[SEGMENT_FRAME_MIN] = { 0 }, answer[SEGMENT_FRAME_MIN];

    segment_close_ring(&field->segment, false, field->now);
    segment_damage_next(&field->segment, SEGMENT_NO_CABLE);
    for (size_t i = 0; i < field->count; i++) {
        segment_cable(&field->segment, i, true, field->now);
        segment_power(&field->segment, i, false, field->now);
        segment_power(&field->segment, i, true, field->now);
    }
    put_header(frame);
    put_u16(frame + 14, 14u | 1u << 12);
    frame[16] = 7;
    put_u16(frame + 22, 2);
    FIELD_MUST(field_send(field, frame, sizeof frame, SEGMENT_PORT_A, answer));
    FIELD_MUST(get_u16(answer + 28) == field->count);
}

static inline void field_run(struct field *field, const uint8_t *data, size_t size)
{
    struct ops ops = { data, data + size };

    while (ops.at < ops.end) {
        unsigned op = ops_u8(&ops);

        switch (op & 15) {
        case 0:
            op_raw(field, &ops);
            break;
        case 1:
            op_frame(field, &ops, SEGMENT_PORT_B);
            break;
        case 2:
            field->now += ops_u16(&ops) * UINT64_C(1000);
            break;
        case 3:
            /* Drives live through every step of it, so there is not much of it. */
            if (field->now < FIELD_PATIENCE_NS)
                field->now += ops_u8(&ops) * (op >> 4 ? UINT64_C(10000) : UINT64_C(5000000));
            break;
        case 4:
            op_bring_up(field, &ops);
            break;
        case 5:
        case 6:
            op_mailbox(field, &ops);
            break;
        case 7:
            op_trouble(field, &ops);
            break;
        default:
            op_frame(field, &ops, SEGMENT_PORT_A);
        }
    }
    check_slaves(field);
}

#endif
