/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/plan.h"
#include "bus/frame.h"
#include "bus/segment.h"
#include "bus/slave_parts.h"

#include <string.h>

enum {
    PLAN_WRITE = 1,     /* the outputs, three buffers or plain memory, take their data */
    PLAN_READ = 2,      /* the inputs, likewise, give their data */
    PLAN_MAPPED = 4,    /* anything else the FMMUs do */
    PLAN_FOLLOW = 8,    /* a clock that follows */
    PLAN_REFERENCE = 16 /* the clock that is followed */
};

static bool logical(uint8_t command)
{
    return command == LRD || command == LWR || command == LRW;
}

static bool read_shape(const uint8_t *frame, size_t length, struct plan_shape *shape)
{
    const uint8_t *d = frame + ETHER_HEADER + ECAT_HEADER;
    uint16_t header = get_u16(frame + ETHER_HEADER);
    size_t claimed = header & ECAT_LENGTH, used;
    bool more;

    if (get_u16(frame + ETHER_TYPE) != ETHER_ECAT || header >> 12 != ECAT_DATAGRAMS ||
        claimed > length - ETHER_HEADER - ECAT_HEADER || claimed < DG_HEADER + DG_WKC ||
        !logical(d[0]))
        return false;
    *shape = (struct plan_shape){ .command = d[0],
                                  .address = get_u32(d + 2),
                                  .length = get_u16(d + 6) & DG_LENGTH };
    more = get_u16(d + 6) & DG_MORE;
    used = (size_t)shape->length + DG_HEADER + DG_WKC;
    if (!shape->length || used > claimed)
        return false;
    if (!more)
        return true;
    d += used;
    if (claimed < used + DG_HEADER + sizeof(uint64_t) + DG_WKC || d[0] != FRMW ||
        get_u16(d + 4) != REG_DC_SYSTEM_TIME || get_u16(d + 6) != sizeof(uint64_t))
        return false;
    shape->clock = true;
    shape->station = get_u16(d + 2);
    return true;
}

/* The sync manager that `fmmu` maps from its first to its last byte, within the datagram. */
static struct syncman *whole(struct slave *slave, const struct fmmu *fmmu,
                             const struct plan_shape *shape)
{
    size_t length = fmmu->last - fmmu->first + 1, span;
    struct syncman *sm = syncman_at(slave, fmmu->physical, length, &span);

    if (!sm || !fmmu->bytewise || sm->start != fmmu->physical || sm->length != length ||
        span != length || !sm->usable || sm->mailbox || fmmu->first < shape->address ||
        fmmu->last >= (uint64_t)shape->address + shape->length)
        return NULL;
    return sm;
}

/* What one mapping does; PLAN_MAPPED when it is nothing simple. */
static unsigned action(struct slave *slave, const struct fmmu *fmmu, const struct plan_shape *shape,
                       struct plan_stop *stop)
{
    bool reads = fmmu->reads && shape->command != LWR;
    bool writes = fmmu->writes && shape->command != LRD;
    struct syncman *sm;

    if (!fmmu->active || !(reads || writes) || fmmu->last < shape->address ||
        fmmu->first >= (uint64_t)shape->address + shape->length)
        return 0;
    sm = whole(slave, fmmu, shape);
    if (!sm || (reads && writes) || sm->master_writes != writes ||
        sm - slave->sm != (writes ? slave->output_sm : slave->input_sm))
        return PLAN_MAPPED;
    *(writes ? &stop->write : &stop->read) = (struct plan_move){
        .sm = sm,
        .status = slave->memory + REG_SM + (size_t)(sm - slave->sm) * SM_SIZE + SM_STATUS,
        .area = slave->memory + sm->start,
        .length = sm->length,
        .at = (uint16_t)(fmmu->first - shape->address),
    };
    return writes ? PLAN_WRITE : PLAN_READ;
}

static struct plan_stop stop_at(struct slave *slave, const struct plan_shape *shape)
{
    struct plan_stop stop = { .slave = slave };
    unsigned all = 0;

    for (unsigned i = 0; i < slave->fmmu_end; i++) {
        unsigned one = action(slave, &slave->fmmu[i], shape, &stop);

        all |= all & one ? PLAN_MAPPED : one;
    }
    if (all && ((all & PLAN_MAPPED) || slave->fmmu_crossed))
        all = PLAN_MAPPED;
    if (shape->clock && slave->type->dc && !slave->type->dc_delay_only)
        all |= slave_is_addressed(slave, shape->station) ? PLAN_REFERENCE : PLAN_FOLLOW;
    stop.actions = (uint8_t)all;
    return stop;
}

/* Event requests go the general way, except link events, of which none may be pending. */
static bool suits(struct slave *slave)
{
    unsigned mask = get_u16(slave->memory + REG_ECAT_EVENT_MASK);

    return !slave->protected && !(mask & ~(unsigned)EVENT_DL_STATUS) && !slave_irq(slave);
}

static void start_over(struct segment *segment)
{
    struct plans *plans = &segment->plans;

    plans->made_at = plans->changes;
    plans->count = plans->last = plans->stops = 0;
    plans->marks = false;
    plans->refused = false;
    for (size_t i = 0; i < segment->count; i++) {
        struct slave *slave = &segment->slaves[i];

        plans->refused |= !suits(slave);
        plans->marks |= slave->memory[REG_DL_CONTROL] & DL_CONTROL_FORWARDING;
    }
}

static const struct plan *make(struct segment *segment, const struct plan_shape *shape)
{
    struct plans *plans = &segment->plans;
    struct plan *plan;

    if (plans->count == PLAN_FRAMES || plans->stops + segment->count > PLAN_STOPS)
        plans->count = plans->stops = 0;
    plan = &plans->plan[plans->count];
    *plan = (struct plan){ .shape = *shape, .first = plans->stops };
    for (size_t i = 0; i < segment->count; i++) {
        struct plan_stop stop = stop_at(&segment->slaves[i], shape);

        if (!stop.actions)
            continue;
        plans->stop[plans->stops++] = stop;
        plan->count++;
    }
    plans->last = plans->count++;
    return plan;
}

static bool same(const struct plan_shape *a, const struct plan_shape *b)
{
    return a->address == b->address && a->length == b->length && a->command == b->command &&
           a->clock == b->clock && a->station == b->station;
}

/* Frames come round in the same order: the one behind the last is the likeliest. */
static const struct plan *find(struct plans *plans, const struct plan_shape *shape)
{
    unsigned at = plans->last;

    for (unsigned tried = 0; tried < plans->count; tried++) {
        at = at + 1u < plans->count ? at + 1u : 0;
        if (same(&plans->plan[at].shape, shape)) {
            plans->last = (uint16_t)at;
            return &plans->plan[at];
        }
    }
    return NULL;
}

/* Process data are some ten bytes, and mostly whole words that have just been stored: loads as wide
 * as the stores do not wait for them. */
static inline void copy(uint8_t *to, const uint8_t *from, size_t length)
{
    if (length % 4 || length > 64) {
        memcpy(to, from, length);
        return;
    }
    for (size_t i = 0; i < length; i += 4) {
        uint32_t word;

        memcpy(&word, from + i, 4);
        memcpy(to + i, &word, 4);
    }
}

static inline void show(const struct plan_move *move, unsigned set, unsigned clear)
{
    const unsigned gone = SM_STATUS_FULL | SM_STATUS_BUFFER | SM_STATUS_READING | SM_STATUS_WRITING;

    *move->status =
        (uint8_t)((*move->status & ~(gone | clear)) | set | (unsigned)move->sm->latest << 4);
}

/* The device fills a buffer, and the master takes it at once. */
static inline void fetch(struct slave *slave, const struct plan_move *move, uint8_t *data)
{
    struct syncman *sm = move->sm;
    uint8_t buffer = syncman_free_buffer(sm, sm->open ? sm->master_at : SYNCMAN_NO_BUFFER);
    uint8_t *from = move->area + (size_t)buffer * move->length;

    slave->type->inputs(slave->device, from, move->length);
    sm->latest = sm->device_at = sm->master_at = buffer;
    sm->open = false;
    copy(data, from, move->length);
    show(move, SM_STATUS_READ, SM_STATUS_WRITTEN);
}

static inline bool read_inputs(struct slave *slave, const struct plan_move *move, uint8_t *data)
{
    bool live = slave->state >= AL_SAFEOP || slave->type->al_emulation;

    if (!slave->behind || !live || !move->sm->buffered || slave->due_ns <= slave->frame_ns) {
        slave_catch_up(slave);
        return syncman_read_whole(slave, (unsigned)slave->input_sm, data + move->at);
    }
    slave->behind = false;
    slave_pass(slave, slave->frame_ns);
    fetch(slave, move, data + move->at);
    return true;
}

static inline void write_outputs(struct slave *slave, const struct plan_move *move,
                                 const uint8_t *data)
{
    struct syncman *sm = move->sm;

    slave_catch_up(slave);
    if (sm->buffered) {
        copy(move->area + (size_t)sm->master_at * move->length, data + move->at, move->length);
        sm->open = false;
        sm->latest = sm->master_at;
        sm->master_at = syncman_free_buffer(sm, sm->device_at);
        show(move, SM_STATUS_WRITTEN, SM_STATUS_READ);
    } else {
        memcpy(move->area, data + move->at, move->length);
    }
    if (sm->watchdog)
        watchdog_trigger(slave);
    slave->outputs_fresh = true;
}

/* Working counter steps of the logical datagram. */
static inline unsigned move_data(const struct plan_stop *stop, const struct plan_shape *shape,
                                 uint8_t *data)
{
    unsigned done = 0;

    if (stop->actions & PLAN_MAPPED)
        done = slave_logical(stop->slave, shape->address, data, shape->length,
                             shape->command != LWR, shape->command != LRD);
    if ((stop->actions & PLAN_READ) && read_inputs(stop->slave, &stop->read, data))
        done |= 1;
    if (stop->actions & PLAN_WRITE) {
        write_outputs(stop->slave, &stop->write, data);
        done |= 2;
    }
    return shape->command == LRW ? done : done != 0;
}

/* As slave_settle(), for outputs that a planned write has brought. */
static inline void settle(struct slave *slave, const struct plan_move *move)
{
    struct syncman *sm = move->sm;

    if (slave->state != AL_OP || slave->al.wait_outputs || !sm || !sm->buffered ||
        !slave->type->outputs) {
        slave_settle(slave);
        return;
    }
    slave->outputs_fresh = false;
    slave->al.outputs_seen = true;
    sm->device_at = sm->latest;
    slave->type->outputs(slave->device, move->area + (size_t)sm->latest * move->length,
                         move->length, slave->now_ns);
}

/* Time passes for four devices at once, if nothing else is due at any of them. */
static inline void step_four(const struct plan_stop *stop, uint64_t now_ns)
{
    void (*together)(void *const *, const uint64_t *) = stop->slave->type->step_four;
    void *devices[4];
    uint64_t at[4];

    if (!together)
        return;
    for (unsigned i = 0; i < 4; i++) {
        struct slave *slave = stop[i].slave;

        at[i] = now_ns + slave->delay_ns;
        devices[i] = slave->device;
        if (!(stop[i].actions & (PLAN_READ | PLAN_WRITE)) || slave->mute || at[i] < slave->frame_ns ||
            slave->due_ns <= at[i] || slave->type->step_four != together)
            return;
    }
    together(devices, at);
}

static void travel(struct segment *segment, const struct plan *plan, uint8_t *datagrams,
                   uint64_t now_ns)
{
    const struct plan_stop *stop = segment->plans.stop + plan->first;
    const struct plan_shape *shape = &plan->shape;
    uint8_t *data = datagrams + DG_HEADER, *wkc = data + shape->length;
    uint8_t *time = wkc + DG_WKC + DG_HEADER;
    unsigned counted = get_u16(wkc), clocks = 0;

    for (unsigned i = 0; i < plan->count; i++, stop++) {
        struct slave *slave = stop->slave;

        if (i % 4 == 0 && i + 4 <= plan->count)
            step_four(stop, now_ns);
        slave_meet(slave, now_ns + slave->delay_ns);
        if ((stop->actions & (PLAN_READ | PLAN_WRITE | PLAN_MAPPED)) && !slave->mute)
            counted += move_data(stop, shape, data);
        if (stop->actions & PLAN_FOLLOW) {
            if (slave_awaits_pulse(slave))
                slave_catch_up(slave);
            dc_follow(slave, get_u32(time));
            clocks++;
        } else if (stop->actions & PLAN_REFERENCE) {
            clocks += slave_read(slave, REG_DC_SYSTEM_TIME, time, sizeof(uint64_t));
        }
        if (slave->outputs_fresh)
            settle(slave, &stop->write);
    }
    put_u16(wkc, counted);
    if (shape->clock)
        put_u16(time + sizeof(uint64_t), get_u16(time + sizeof(uint64_t)) + clocks);
}

bool plan_transfer(struct segment *segment, uint8_t *frame, size_t length, uint64_t now_ns)
{
    struct plans *plans = &segment->plans;
    struct plan_shape shape;
    const struct plan *plan;

    if (plans->off || !read_shape(frame, length, &shape))
        return false;
    if (plans->made_at != plans->changes)
        start_over(segment);
    if (plans->refused)
        return false;
    plan = find(plans, &shape);
    if (!plan)
        plan = make(segment, &shape);
    plans->served++;
    if (plans->marks)
        frame[SOURCE_MAC] |= LOCAL_BIT;
    travel(segment, plan, frame + ETHER_HEADER + ECAT_HEADER, now_ns);
    return true;
}
