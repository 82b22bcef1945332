/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_rehearse.c - the rest of an interrupted call, tried out as often as wanted. */
#define _GNU_SOURCE 1
#include <signal.h>

#include "machine_fixture.h"

static const struct machine_config interruptible = { .seed = 1,
                                                     .hang_ns = 5 * TEST_HANG_NS,
                                                     .interruptible = true };

struct rehearsal {
    struct fixture *fixture;
    uint64_t *words;
    unsigned points;
    uint64_t halves[8]; /* words[0] before each instruction */
    int64_t values[64];
    struct machine_outcome last;
    bool writes[8]; /* the next instruction, into words[0] */
};

/* Before every instruction: to the end twice, with words[0] put back in between. */
static uint64_t at_each(void *argument, uint64_t pc, uint64_t instructions)
{
    struct rehearsal *r = argument;
    const uint64_t kept = r->words[0];

    (void)pc;
    assert_int_equal(instructions, r->points);
    for (int turn = 0; turn < 2; turn++) {
        machine_rehearse(r->fixture->machine, &r->last);
        assert_int_equal(r->last.kind, MACHINE_RETURNED);
        assert_int_equal(r->last.abi_broken, 0);
        r->values[r->points] = r->last.value;
        if (r->points < 8) {
            assert_int_equal(r->words[0], r->words[1]);
            r->halves[r->points] = kept;
        }
        r->words[0] = kept;
    }
    struct code_operand operands[CODE_OPERANDS];
    const unsigned count = machine_next_operands(r->fixture->machine, operands);
    for (unsigned i = 0; i < count && r->points < 8; i++)
        r->writes[r->points] |=
            operands[i].write && operands[i].address - (uint64_t)r->words < sizeof *r->words;
    r->points++;
    return 1;
}

static void the_rest_of_a_call_can_be_tried_at_every_instruction(void **state)
{
    struct fixture *fixture = &the_fixture;
    struct rehearsal r = { .fixture = fixture };
    static const uint64_t before[] = {
        0, 0, 0x44444444, 0x44444444, 0x3333333344444444, 0x3333333344444444
    };

    (void)state;
    fixture_open(fixture, "interrupt", &interruptible);
    r.words = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    r.words[1] = 0x3333333344444444;
    machine_interrupt_next(fixture->machine, 0, at_each, &r);
    assert_int_equal(call(fixture, "write_halves", r.words).value, 1);
    assert_int_equal(r.points, 6);
    assert_memory_equal(r.halves, before, sizeof before);
    for (int i = 0; i < 6; i++) {
        assert_int_equal(r.values[i], 1);
        assert_int_equal(r.writes[i], i == 1 || i == 3);
    }
    assert_int_equal(r.words[0], r.words[1]);
}

static void every_register_and_the_stack_come_back_for_it(void **state)
{
    struct fixture *fixture = &the_fixture;
    struct rehearsal r = { .fixture = fixture };

    (void)state;
    fixture_open(fixture, "interrupt", &interruptible);
    r.words = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    machine_interrupt_next(fixture->machine, 0, at_each, &r);
    assert_int_equal(call(fixture, "keep_everything", NULL).value, 0);
    assert_in_range(r.points, 50, 60);
    for (unsigned i = 0; i < r.points; i++)
        assert_int_equal(r.values[i], 0);
}

static uint64_t try_once(void *argument, uint64_t pc, uint64_t instructions)
{
    struct rehearsal *r = argument;

    (void)pc;
    (void)instructions;
    machine_rehearse(r->fixture->machine, &r->last);
    r->points++;
    return MACHINE_NEVER;
}

static void a_rehearsal_that_faults_or_hangs_leaves_the_call_standing(void **state)
{
    struct fixture *fixture = &the_fixture;
    struct rehearsal r = { .fixture = fixture };
    uint64_t *words;

    (void)state;
    fixture_open(fixture, "interrupt", &interruptible);
    machine_interrupt_next(fixture->machine, 0, try_once, &r);
    assert_int_equal(call(fixture, "fault_at_once", NULL).fault.signal, SIGILL);
    assert_int_equal(r.last.kind, MACHINE_FAULT);
    assert_int_equal(r.last.fault.signal, SIGILL);
    assert_int_equal(r.last.fault.pc, at(fixture, "fault_at_once"));
    words = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    words[0] = 0;
    machine_interrupt_next(fixture->machine, 1, try_once, &r);
    assert_int_equal(call(fixture, "wait_for_word", words).kind, MACHINE_HANG);
    assert_int_equal(r.last.kind, MACHINE_HANG);
    assert_int_equal(r.points, 2);
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
}

static void the_modules_own_data_is_found(void **state)
{
    struct fixture *fixture = &the_fixture;
    void *at_data;
    size_t size;

    (void)state;
    fixture_open(fixture, "interrupt", &interruptible);
    assert_true(machine_own_data(fixture->machine, 0, &at_data, &size));
    assert_int_equal(size % 4096, 0);
    assert_int_equal(call(fixture, "count_up", NULL).value, 5);
    bool found = false;
    for (size_t i = 0; i + 4 <= size; i += 4)
        found = found || *(uint32_t *)((char *)at_data + i) == 6;
    assert_true(found);
    assert_false(machine_own_data(fixture->machine, 8, &at_data, &size));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(the_rest_of_a_call_can_be_tried_at_every_instruction,
                                  close_fixture),
        cmocka_unit_test_teardown(every_register_and_the_stack_come_back_for_it, close_fixture),
        cmocka_unit_test_teardown(a_rehearsal_that_faults_or_hangs_leaves_the_call_standing,
                                  close_fixture),
        cmocka_unit_test_teardown(the_modules_own_data_is_found, close_fixture),
    };

    return cmocka_run_group_tests_name("machine_rehearse", tests, NULL, NULL);
}
