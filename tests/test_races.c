/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_races.c - interrupts tried out at every instruction: what is found of a race, and that the
 * run does not notice. */
#include "tests/host_rig.h"

static struct rig *open_tried(const char *module, uint32_t calls)
{
    const struct host_config config = { .without_bus = true,
                                        .preempt = { .mode = PREEMPT_TRIED, .calls = calls } };
    struct rig *rig = rig_open(module, &config);

    rig_start(rig);
    return rig;
}

/* Program_04 sees one half of what Program_01 writes: it counts what it counts in neither order. */
static void a_torn_word_is_found_with_both_places_in_the_code(void **state)
{
    struct rig *rig = open_tried("race", 0);
    struct image_place place;
    const struct evidence_race *race = &rig->evidence.races[0];

    (void)state;
    rig_cycles(rig, 100);
    assert_int_equal(rig->evidence.race_count, 1);
    assert_int_equal(race->kind, RACE_NEITHER);
    assert_int_equal(race->entry, ENTRY_01);
    assert_int_equal(race->by, ENTRY_04);
    assert_int_equal(race->words[0].offset, 8);
    assert_int_equal(race->words[0].bit, 0);
    assert_true(catalogue_memory(rig->catalogue, (size_t)race->words[0].memory) ==
                catalogue_memory_named(rig->catalogue, "TGM_Data"));
    assert_int_equal((uint32_t)race->words[0].first, 0);
    assert_int_equal((uint32_t)race->words[0].second, 0);
    assert_int_equal((uint32_t)race->words[0].found, 1);
    assert_true(race->count >= 8);
    image_where(rig->image, race->pc, &place);
    assert_string_equal(place.function, "Program_01");
    assert_true(race->has_by_pc && race->by_writes);
    image_where(rig->image, race->by_pc, &place);
    assert_string_equal(place.function, "Program_04");
    assert_int_equal(race->shared.offset, 8);
    rig_close(rig);
}

/* Memories, evidence and what is called afterwards are those of a run without. */
static void the_run_does_not_notice(void **state)
{
    static char memory[2][524288];
    static struct evidence evidence[2];

    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        const struct host_config config = {
            .preempt.mode = turn == 0 ? PREEMPT_NONE : PREEMPT_TRIED,
        };
        struct rig *rig = rig_open("talks", &config);
        struct catalogue_register reg;

        rig_start(rig);
        rig_cycles(rig, 300);
        memcpy(memory[turn], rig_at(rig, "DATA.U32[0]", &reg), sizeof memory[turn]);
        evidence[turn] = rig->evidence;
        rig_close(rig);
    }
    assert_true(evidence[1].tried_points > 100);
    evidence[1].tried_calls = evidence[1].tried_points = 0;
    assert_int_equal(evidence[1].race_count, 0);
    assert_memory_equal(&evidence[0], &evidence[1], sizeof evidence[0]);
    assert_memory_equal(memory[0], memory[1], sizeof memory[0]);
}

static void the_same_seed_tries_the_same(void **state)
{
    static struct evidence first;

    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        struct rig *rig = open_tried("race", 20);

        rig_cycles(rig, 300);
        if (turn == 0)
            first = rig->evidence;
        else
            assert_memory_equal(&first, &rig->evidence, sizeof first);
        rig_close(rig);
    }
}

/* More than a thousand points, all told. */
static void a_module_in_order_is_found_in_order(void **state)
{
    struct rig *rig = open_tried("correct", 0);

    (void)state;
    rig_cycles(rig, 200);
    assert_true(rig->evidence.tried_calls >= 100);
    assert_true(rig->evidence.tried_points >= 1000);
    assert_int_equal(rig->evidence.race_total, 0);
    assert_int_equal(rig->evidence.race_count, 0);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_torn_word_is_found_with_both_places_in_the_code),
        cmocka_unit_test(the_run_does_not_notice),
        cmocka_unit_test(the_same_seed_tries_the_same),
        cmocka_unit_test(a_module_in_order_is_found_in_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
