/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_preempt.c - lower functions interrupted by higher ones: races show, and the same ones every
 * time. */
#include "tests/host_rig.h"

#define TORN "DATA.U32[8]"

static struct rig *open_race(enum preempt_mode mode, uint64_t at, uint64_t seed)
{
    const struct host_config config = { .seed = seed,
                                        .without_bus = true,
                                        .preempt = { .mode = mode, .at = at } };
    struct rig *rig = rig_open("race", &config);

    rig_start(rig);
    return rig;
}

/* Instructions of Program_01, found by interrupting it further and further on. */
static unsigned torn_places(unsigned *length)
{
    unsigned torn = 0;

    for (*length = 0; *length < 100; (*length)++) {
        struct rig *rig = open_race(PREEMPT_AT, *length, 1);

        rig_cycles(rig, 3);
        const bool reached = rig->evidence.interrupt_count > 0;
        for (uint64_t i = 0; i < rig->evidence.interrupt_count; i++)
            if (rig->evidence.interrupts[i].entry == ENTRY_01)
                assert_int_equal(rig->evidence.interrupts[i].instructions, *length);
        torn += rig_get(rig, TORN) > 0;
        rig_close(rig);
        if (!reached)
            break;
    }
    return torn;
}

static void a_race_is_there_at_some_instructions_and_not_at_others(void **state)
{
    unsigned length;
    const unsigned torn = torn_places(&length);

    (void)state;
    assert_in_range(length, 4, 40);
    assert_in_range(torn, 1, length - 2);
}

static void run_to_completion_never_shows_it(void **state)
{
    struct rig *rig = open_race(PREEMPT_NONE, 0, 1);

    (void)state;
    rig_cycles(rig, 2000);
    assert_true(rig_get(rig, "DATA.U32[12]") == 2000);
    assert_true(rig_get(rig, TORN) == 0);
    assert_int_equal(rig->evidence.interrupt_count, 0);
    rig_close(rig);
}

static void seeded_interrupts_find_it_and_are_the_same_every_time(void **state)
{
    struct evidence_interrupt first[EVIDENCE_INTERRUPTS];
    double torn = 0;

    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        struct rig *rig = open_race(PREEMPT_SEEDED, 0, 77);

        rig_cycles(rig, 2000);
        assert_true(rig_get(rig, TORN) > 0);
        assert_true(rig->evidence.interrupt_count >= EVIDENCE_INTERRUPTS);
        if (turn == 0) {
            torn = rig_get(rig, TORN);
            memcpy(first, rig->evidence.interrupts, sizeof first);
        } else {
            assert_true(rig_get(rig, TORN) == torn);
            assert_memory_equal(first, rig->evidence.interrupts, sizeof first);
        }
        rig_close(rig);
    }
}

static void another_seed_interrupts_elsewhere(void **state)
{
    struct rig *one = open_race(PREEMPT_SEEDED, 0, 77), *other;
    struct evidence_interrupt first[EVIDENCE_INTERRUPTS];

    (void)state;
    rig_cycles(one, 500);
    memcpy(first, one->evidence.interrupts, sizeof first);
    rig_close(one);
    other = open_race(PREEMPT_SEEDED, 0, 78);
    rig_cycles(other, 500);
    assert_memory_not_equal(first, other->evidence.interrupts, sizeof first);
    rig_close(other);
}

/* The evidence says who, where and by whom; only what is above interrupts. */
static void only_higher_functions_interrupt(void **state)
{
    struct rig *rig = open_race(PREEMPT_SEEDED, 0, 5);
    bool seen[ENTRY_COUNT] = { false };

    (void)state;
    rig_cycles(rig, 400);
    for (unsigned i = 0; i < EVIDENCE_INTERRUPTS; i++) {
        const struct evidence_interrupt *interrupt = &rig->evidence.interrupts[i];
        struct image_place place;

        assert_in_range(interrupt->entry, ENTRY_01, ENTRY_03);
        assert_int_equal(interrupt->by & ((1u << (interrupt->entry + 1)) - 1), 0);
        assert_true(interrupt->by & 1u << ENTRY_05);
        image_where(rig->image, interrupt->pc, &place);
        assert_string_equal(place.function, entry_name(interrupt->entry));
        seen[interrupt->entry] = true;
    }
    assert_true(seen[ENTRY_01] && seen[ENTRY_02] && seen[ENTRY_03]);
    rig_close(rig);
}

/* What interrupts is as often as ever; what is interrupted for longer than its period misses some
 * (R6). */
static void interrupts_take_no_call_from_what_is_above(void **state)
{
    uint64_t counts[2][ENTRY_COUNT];

    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        struct rig *rig = open_race(turn == 0 ? PREEMPT_NONE : PREEMPT_SEEDED, 0, 5);

        while (host_cycles(rig->host) < 4000)
            rig_cycles(rig, 1);
        for (int entry = 0; entry < ENTRY_COUNT; entry++)
            counts[turn][entry] = rig->evidence.calls[entry].count;
        rig_close(rig);
    }
    for (int entry = ENTRY_04; entry < ENTRY_COUNT; entry++)
        assert_in_range(counts[1][entry] + 10, counts[0][entry] + 5, counts[0][entry] + 15);
    for (int entry = ENTRY_01; entry < ENTRY_04; entry++)
        assert_in_range(counts[1][entry], counts[0][entry] * 9 / 10, counts[0][entry] + 1);
}

/* On a controller there is one slot a Cycle_Time: what is in the background is interrupted by the
 * next. */
static void a_controllers_background_is_interrupted_by_the_next_cycle(void **state)
{
    const struct host_config config = { .product = product_find("tgmcontroller"),
                                        .without_bus = true,
                                        .preempt = { .mode = PREEMPT_SEEDED } };
    struct rig *rig = rig_open("race", &config);

    (void)state;
    rig_start(rig);
    while (host_cycles(rig->host) < 2000)
        rig_cycles(rig, 1);
    assert_true(rig_get(rig, TORN) > 0);
    assert_true(rig->evidence.interrupt_count > EVIDENCE_INTERRUPTS);
    assert_true(rig->evidence.interrupts[0].by & 1u << ENTRY_04);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_race_is_there_at_some_instructions_and_not_at_others),
        cmocka_unit_test(run_to_completion_never_shows_it),
        cmocka_unit_test(seeded_interrupts_find_it_and_are_the_same_every_time),
        cmocka_unit_test(another_seed_interrupts_elsewhere),
        cmocka_unit_test(only_higher_functions_interrupt),
        cmocka_unit_test(interrupts_take_no_call_from_what_is_above),
        cmocka_unit_test(a_controllers_background_is_interrupted_by_the_next_cycle),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
