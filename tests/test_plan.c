/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The planned way of process data frames against the general one: two segments live through the
 * same bytes, one of them without plans, and must not differ in a bit. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "bus/frame.h"
#include "segment_ops.h"

enum { LIVES = 60, CHAPTERS = 12, CHAPTER_BYTES = 300, CYCLES = 40, WINDOW = 0x40 };

static uint64_t next_random(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

struct twins {
    struct field planned, general;
    uint64_t random;
};

static void twins_init(struct twins *t)
{
    field_init(&t->planned);
    field_init(&t->general);
    t->general.segment_fresh.plans.off = true;
}

static void twins_reset(struct twins *t, uint64_t seed)
{
    field_reset(&t->planned);
    field_reset(&t->general);
    t->random = seed | 1;
}

static void twins_fini(struct twins *t)
{
    struct field *both[] = { &t->planned, &t->general };

    for (size_t i = 0; i < 2; i++) {
        free(both[i]->slaves);
        free(both[i]->slaves_fresh);
        free(both[i]->devices);
        free(both[i]->devices_fresh);
    }
}

#define SAME(member)                                                                               \
    assert_memory_equal(&t->planned.slaves[i].member, &t->general.slaves[i].member,                \
                        sizeof t->planned.slaves[i].member)

static void assert_same(const struct twins *t)
{
    assert_int_equal(t->planned.back, t->general.back);
    for (size_t i = 0; i < t->planned.count; i++) {
        SAME(memory);
        SAME(sm);
        SAME(dc);
        SAME(sync);
        SAME(watchdog);
        SAME(al);
        SAME(state);
        SAME(now_ns);
        SAME(outputs_fresh);
    }
}

/* The same frame into both; what comes back is the same, too. */
static bool twins_send(struct twins *t, const uint8_t *frame, size_t length)
{
    uint8_t a[SEGMENT_FRAME_MAX], b[SEGMENT_FRAME_MAX];
    bool back = field_send(&t->planned, frame, length, SEGMENT_PORT_A, a);

    assert_int_equal(field_send(&t->general, frame, length, SEGMENT_PORT_A, b), back);
    if (back)
        assert_memory_equal(a, b, length);
    return back;
}

static unsigned pick(struct twins *t, unsigned below)
{
    return (unsigned)(next_random(&t->random) >> 20) % below;
}

/* Outputs that drives go along with, most of the time: they switch on, run in some mode, stop. */
static void fill_outputs(struct twins *t, uint8_t *data, unsigned cycle)
{
    static const uint16_t words[] = { 0x86, 6, 7, 15, 15, 15, 15, 0x1f, 15, 2 };
    static const uint8_t modes[] = { 8, 8, 8, 8, 9, 10, 1, 3, 6, 0 };

    for (size_t i = 0; i < t->planned.count; i++) {
        uint8_t *own = data + i * WINDOW;

        for (unsigned k = 0; k < WINDOW; k++)
            own[k] = (uint8_t)next_random(&t->random);
        put_u16(own, words[cycle / 4 % 10]);
        own[2] = modes[pick(t, 10)];
        put_u32(own + 4, 0x80000 + 100 * cycle);
    }
}

/* Process data as a master sends them: all of it or a part, read, written or both, with or without
 * a clock behind. */
static void cyclic_frame(struct twins *t, unsigned cycle)
{
    unsigned all = (unsigned)t->planned.count * WINDOW;
    unsigned from = pick(t, 4) ? 0 : pick(t, all), length = pick(t, 4) ? all : 1 + pick(t, all);
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 }, data[FIELD_MOST * WINDOW];
    static const uint8_t commands[] = { LRD, LWR, LRW, LRW, LRW, LRW };
    size_t at = FIELD_HEADER, used;

    length = length > all - from ? all - from : length;
    fill_outputs(t, data, cycle);
    put_header(frame);
    frame[at] = commands[pick(t, 6)];
    put_u32(frame + at + 2, from);
    put_u16(frame + at + 6, length);
    memcpy(frame + at + 10, data + from, length);
    put_u16(frame + at + 10 + length, pick(t, 8) ? 0 : 0xfffe);
    used = at + 12 + length;
    if (pick(t, 3)) {
        put_u16(frame + at + 6, length | 0x8000);
        frame[used] = FRMW;
        put_u16(frame + used + 2, FIELD_STATION + pick(t, (unsigned)t->planned.count + 1));
        put_u16(frame + used + 4, REG_DC_SYSTEM_TIME);
        put_u16(frame + used + 6, 8);
        put_u64(frame + used + 10, next_random(&t->random));
        used += 12 + 8;
    }
    put_u16(frame + 14, (uint32_t)(used - FIELD_HEADER) | 1u << 12);
    twins_send(t, frame, used < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : used);
}

static void bring_up(struct twins *t)
{
    for (unsigned i = 0; i < t->planned.count; i++) {
        uint8_t bytes[3] = { 4, (uint8_t)i, 3 };

        field_run(&t->planned, bytes, sizeof bytes);
        field_run(&t->general, bytes, sizeof bytes);
    }
    assert_same(t);
}

static void pause_for(struct twins *t, uint64_t ns)
{
    t->planned.now += ns;
    t->general.now += ns;
}

static void cycles(struct twins *t, unsigned count)
{
    static const uint32_t periods[] = { 250000, 1000000, 125000, 60000 };
    uint32_t period = periods[pick(t, 4)];

    for (unsigned i = 0; i < count; i++) {
        pause_for(t, pick(t, 50) ? period : 120000000);
        cyclic_frame(t, i);
        assert_same(t);
    }
}

/* Anything: registers, mailboxes, faults, cables. */
static void chapter(struct twins *t)
{
    uint8_t bytes[CHAPTER_BYTES];
    size_t length = 8 + pick(t, CHAPTER_BYTES - 8);

    for (size_t i = 0; i < length; i++)
        bytes[i] = (uint8_t)(next_random(&t->random) >> 16);
    field_run(&t->planned, bytes, length);
    field_run(&t->general, bytes, length);
    assert_same(t);
}

static void both_ways_end_in_the_same_state_whatever_comes(void **state)
{
    static struct twins t;
    uint64_t planned = 0;

    (void)state;
    twins_init(&t);
    for (uint64_t life = 1; life <= LIVES; life++) {
        twins_reset(&t, life * 0x9e3779b97f4a7c15u);
        bring_up(&t);
        for (unsigned n = 0; n < CHAPTERS; n++) {
            cycles(&t, CYCLES);
            chapter(&t);
        }
        planned += t.planned.segment.plans.served;
        assert_int_equal(t.general.segment.plans.served, 0);
    }
    /* Or nothing would have been compared. */
    assert_true(planned > (uint64_t)LIVES * CYCLES);
    twins_fini(&t);
}

static uint64_t served(const struct twins *t)
{
    return t->planned.segment.plans.served;
}

static void cycle_one(struct twins *t)
{
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 };
    unsigned all = (unsigned)t->planned.count * WINDOW;

    put_header(frame);
    frame[FIELD_HEADER] = LRW;
    put_u16(frame + FIELD_HEADER + 6, all);
    put_u16(frame + 14, (12 + all) | 1u << 12);
    pause_for(t, 250000);
    twins_send(t, frame, FIELD_HEADER + 12 + all);
    assert_same(t);
}

static void plain_cycles_go_by_the_plan_and_what_voids_it_is_noticed(void **state)
{
    static struct twins t;
    static const uint8_t fmmu_off[1] = { 0 }, mask[2] = { 0x10, 0 };
    struct field *both[] = { &t.planned, &t.general };

    (void)state;
    twins_init(&t);
    twins_reset(&t, 1);
    bring_up(&t);
    for (unsigned i = 0; i < 10; i++)
        cycle_one(&t);
    assert_int_equal(served(&t), 10 + t.planned.count); /* and those on the way to OP */
    for (size_t i = 0; i < 2; i++)
        field_datagram(both[i], 5, FIELD_STATION, REG_FMMU + 12, fmmu_off, 1);
    cycle_one(&t);
    assert_int_equal(served(&t), 11 + t.planned.count);
    /* An event that is asked for must be looked for at every slave. */
    for (size_t i = 0; i < 2; i++)
        field_datagram(both[i], 5, FIELD_STATION, REG_ECAT_EVENT_MASK, mask, 2);
    cycle_one(&t);
    assert_int_equal(served(&t), 11 + t.planned.count);
    twins_reset(&t, 1);
    bring_up(&t);
    for (size_t i = 0; i < 2; i++)
        segment_power(&both[i]->segment, 1, false, both[i]->now);
    cycle_one(&t);
    assert_int_equal(served(&t), t.planned.count);
    twins_fini(&t);
}

static void a_link_event_that_is_asked_for_keeps_frames_from_the_plan_until_it_is_read(void **state)
{
    static struct twins t;
    static const uint8_t mask[2] = { EVENT_DL_STATUS, 0 };
    struct field *both[] = { &t.planned, &t.general };
    uint64_t before;

    (void)state;
    twins_init(&t);
    twins_reset(&t, 1);
    bring_up(&t);
    for (size_t i = 0; i < 2; i++) {
        field_datagram(both[i], BWR, 0, REG_ECAT_EVENT_MASK, mask, 2);
        field_datagram(both[i], BRD, 0, REG_DL_STATUS, NULL, 2);
    }
    before = served(&t);
    cycle_one(&t);
    assert_int_equal(served(&t), before + 1);
    for (size_t i = 0; i < 2; i++)
        segment_close_ring(&both[i]->segment, true, both[i]->now);
    cycle_one(&t);
    assert_int_equal(served(&t), before + 1);
    for (size_t i = 0; i < 2; i++)
        field_datagram(both[i], BRD, 0, REG_DL_STATUS, NULL, 2);
    cycle_one(&t);
    assert_int_equal(served(&t), before + 2);
    twins_fini(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_ways_end_in_the_same_state_whatever_comes),
        cmocka_unit_test(plain_cycles_go_by_the_plan_and_what_voids_it_is_noticed),
        cmocka_unit_test(
            a_link_event_that_is_asked_for_keeps_frames_from_the_plan_until_it_is_read),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
