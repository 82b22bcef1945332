/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_sleep.c - SleepFt gives the processor away (docs/decisions.md, R17). */
#include "tests/host_rig.h"

#define MS(count) ((count)*10000) /* in 100 ns */

/* tests/host_modules/sleeps.c; row 0 is Program_Ini */
#define CELL(name, offset, bytes)                                                                  \
    static inline void *name(const struct rig *rig, unsigned number)                               \
    {                                                                                              \
        struct catalogue_register reg;                                                             \
        return (char *)rig_at(rig, "DATA.U8[0]", &reg) + (offset) + (size_t)number * (bytes);      \
    }
CELL(units_of, 0, 8)
CELL(times_of, 48, 4)
CELL(begun_of, 72, 4)
CELL(ended_of, 96, 4)
CELL(before_of, 120, 16)
CELL(after_of, 216, 16)

struct seen {
    uint32_t tick, begun_04, begun_02, wrong;
};

static uint32_t word(const void *at)
{
    uint32_t value;

    memcpy(&value, at, sizeof value);
    return value;
}

static struct seen seen(const void *at)
{
    struct seen value;

    memcpy(&value, at, sizeof value);
    return value;
}

#define BEGUN(rig, number) word(begun_of(rig, number))
#define ENDED(rig, number) word(ended_of(rig, number))

static void tell(struct rig *rig, unsigned number, int64_t units, uint32_t times)
{
    memcpy(units_of(rig, number), &units, sizeof units);
    memcpy(times_of(rig, number), &times, sizeof times);
}

/* Nobody sleeps yet. Cycle_Time and periods of the profile. */
static struct rig *open_with(const struct host_config *config)
{
    return rig_open("sleeps", config);
}

static struct rig *open_sleeps(void)
{
    const struct host_config config = { .without_bus = true };
    struct rig *rig = open_with(&config);

    rig_start(rig);
    return rig;
}

static struct rig *open_preempted(enum preempt_mode mode, uint64_t at)
{
    const struct host_config config = { .without_bus = true,
                                        .seed = 7,
                                        .preempt = { .mode = mode, .at = at } };
    struct rig *rig = open_with(&config);

    rig_start(rig);
    return rig;
}

static void five_milliseconds_are_ten_cycles_of_500_us(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, MS(5), 1);
    rig_cycles(rig, 10);
    assert_int_equal(BEGUN(rig, 1), 1);
    assert_int_equal(ENDED(rig, 1), 0);
    rig_cycles(rig, 1);
    assert_int_equal(ENDED(rig, 1), 1);
    const struct seen before = seen(before_of(rig, 1)), after = seen(after_of(rig, 1));
    assert_int_equal(after.tick - before.tick, 10);
    assert_int_equal(after.begun_04 - before.begun_04, 10);
    assert_int_equal(after.wrong, 0);
    assert_int_equal(rig->evidence.calls[ENTRY_01].count, 1);
    assert_int_equal(rig->evidence.calls[ENTRY_04].count, 11);
    assert_int_equal(rig->evidence.audit.functions[ENTRY_01].sleeps, 1);
    rig_close(rig);
}

static void a_sleep_lasts_at_least_as_long_as_wanted_and_ends_in_the_next_slot(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, 1, 1); /* 100 ns */
    rig_cycles(rig, 100);
    assert_int_equal(BEGUN(rig, 1), 5);
    assert_int_equal(ENDED(rig, 1), 5);
    assert_int_equal(seen(after_of(rig, 1)).tick, seen(before_of(rig, 1)).tick);
    rig_close(rig);
}

static void what_is_above_and_below_a_sleeper_runs_on(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, MS(20), 1);
    tell(rig, 3, MS(20), 1);
    rig_cycles(rig, 40);
    assert_int_equal(ENDED(rig, 1), 0);
    assert_int_equal(ENDED(rig, 3), 0);
    assert_in_range(ENDED(rig, 2), 2, 40);
    rig_cycles(rig, 2);
    assert_int_equal(ENDED(rig, 1), 1);
    assert_int_equal(ENDED(rig, 3), 1);
    assert_true(seen(after_of(rig, 1)).begun_02 > seen(before_of(rig, 1)).begun_02);
    assert_true(seen(after_of(rig, 3)).begun_02 > seen(before_of(rig, 3)).begun_02);
    rig_close(rig);
}

static void each_sleeper_wakes_at_its_own_time(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, MS(3), 1);
    tell(rig, 2, MS(9), 1);
    tell(rig, 3, MS(30), 1);
    rig_cycles(rig, 7);
    assert_int_equal(ENDED(rig, 1), 1);
    assert_int_equal(ENDED(rig, 2), 0);
    rig_cycles(rig, 12);
    assert_int_equal(ENDED(rig, 2), 1);
    assert_int_equal(ENDED(rig, 3), 0);
    rig_cycles(rig, 42);
    assert_int_equal(ENDED(rig, 3), 1);
    for (unsigned i = 1; i <= 3; i++)
        assert_int_equal(seen(after_of(rig, i)).wrong, 0);
    assert_int_equal(rig->evidence.calls[ENTRY_04].count, 61);
    assert_int_equal(rig->evidence.incident_count, 0);
    rig_close(rig);
}

static void nothing_or_less_is_over_at_once(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, 0, 3);
    tell(rig, 2, -MS(5), 3);
    rig_cycles(rig, 1);
    assert_int_equal(ENDED(rig, 1), 1);
    assert_int_equal(ENDED(rig, 2), 1);
    rig_close(rig);
}

static void program_04_and_05_and_ini_do_not_wait(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 4, MS(5), 1);
    tell(rig, 5, MS(5), 1);
    rig_cycles(rig, 10);
    assert_int_equal(ENDED(rig, 4), 10);
    assert_int_equal(ENDED(rig, 5), 50);
    assert_int_equal(rig->evidence.audit.functions[ENTRY_04].sleeps, 10);
    assert_int_equal(rig->evidence.audit.functions[ENTRY_05].sleeps, 50);
    rig_close(rig);

    const struct host_config config = { .without_bus = true };
    rig = open_with(&config);
    tell(rig, 0, MS(5), 1);
    rig_start(rig);
    assert_int_equal(ENDED(rig, 0), 1);
    assert_int_equal(seen(after_of(rig, 0)).tick, 0);
    rig_close(rig);
}

/* One sleep of a second is allowed, in pieces, too. */
static void more_than_a_second_in_a_call_is_a_hang(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, MS(1000), 1);
    tell(rig, 2, MS(250), 4);
    tell(rig, 3, MS(1), UINT32_MAX);
    rig_cycles(rig, 2000);
    assert_int_equal(ENDED(rig, 1), 0);
    rig_cycles(rig, 2);
    assert_int_equal(ENDED(rig, 1), 1);
    assert_int_equal(ENDED(rig, 2), 1);
    rig_cycles(rig, 500);
    assert_int_equal(ENDED(rig, 3), 0);
    assert_int_equal(rig->evidence.incident_count, 1);
    const struct evidence_incident *incident = &rig->evidence.incidents[0];
    assert_int_equal(incident->entry, ENTRY_03);
    assert_int_equal(incident->kind, MACHINE_HANG);
    assert_string_equal(incident->service, "pSleepFt");
    assert_true(incident->fault.has_pc);
    assert_in_range(incident->cycle, 2000, 2003);
    assert_true(rig->evidence.calls[ENTRY_03].disabled);
    rig_close(rig);
}

static void the_longest_interval_there_is_is_one_as_well(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, INT64_MAX, 1);
    rig_cycles(rig, 2003);
    assert_int_equal(rig->evidence.incident_count, 1);
    assert_int_equal(rig->evidence.incidents[0].entry, ENTRY_01);
    rig_close(rig);
}

static void a_stop_waits_for_who_is_asleep(void **state)
{
    struct rig *rig = open_sleeps();

    (void)state;
    tell(rig, 1, MS(20), 1);
    rig_cycles(rig, 1);
    host_stop(rig->host);
    rig_cycles(rig, 38);
    assert_int_equal(BEGUN(rig, 4), 1);
    assert_int_equal(host_plc(rig->host), HOST_PLC_CHANGING);
    assert_int_equal(rig->evidence.calls[ENTRY_01].count, 0);
    rig_cycles(rig, 3); /* TGM_Data is cleared then */
    assert_int_equal(rig->evidence.calls[ENTRY_01].count, 1);
    assert_int_equal(BEGUN(rig, 1), 0);
    rig_cycles(rig, 25);
    assert_int_equal(host_plc(rig->host), HOST_PLC_STOPPED);
    host_run(rig->host);
    rig_cycles(rig, 1000);
    assert_int_equal(host_plc(rig->host), HOST_PLC_RUNNING);
    assert_true(ENDED(rig, 1) > 0);
    rig_close(rig);
}

static void a_reset_of_tg_motion_forgets_who_is_asleep(void **state)
{
    const struct host_config config = { .without_bus = true, .resettable = true };
    struct rig *rig = open_with(&config);

    (void)state;
    rig_start(rig);
    for (unsigned i = 1; i <= 3; i++)
        tell(rig, i, MS(500), 1);
    rig_cycles(rig, 5);
    host_reset(rig->host);
    rig_cycles(rig, 2);
    assert_int_equal(BEGUN(rig, 1), ENDED(rig, 1));
    rig_cycles(rig, 2000);
    assert_int_equal(rig->evidence.incident_count, 0);
    assert_true(ENDED(rig, 1) > 100);
    rig_close(rig);
}

/* What every cycle leaves, folded. */
static uint64_t course(unsigned cycles)
{
    const struct host_config config = { 0 };
    struct rig *rig = open_with(&config);
    struct catalogue_register reg;
    uint64_t hash = 0xcbf29ce484222325u;

    rig_start(rig);
    tell(rig, 1, 31234, 2);
    tell(rig, 2, MS(2), 1);
    tell(rig, 3, 777, 3);
    for (unsigned i = 0; i < cycles; i++) {
        rig_cycles(rig, 1);
        const uint8_t *data = rig_at(rig, "DATA.U8[0]", &reg);
        for (size_t at = 0; at < 312; at++)
            hash = (hash ^ data[at]) * 0x100000001b3u;
    }
    assert_true(ENDED(rig, 1) > 10);
    assert_true(ENDED(rig, 3) > 10);
    rig_close(rig);
    return hash;
}

static void twice_is_the_same_and_on_the_instrumented_machine_as_well(void **state)
{
    const uint64_t first = course(400);

    (void)state;
    assert_true(course(400) == first);
    rig_kind = MACHINE_INSTRUMENTED;
    const uint64_t instrumented = course(400);
    rig_kind = MACHINE_NATIVE;
    assert_true(instrumented == first);
}

static void instructions_are_those_of_the_whole_call(void **state)
{
    struct rig *rig;
    uint64_t without, with;

    (void)state;
    rig_kind = MACHINE_INSTRUMENTED;
    for (int i = 0; i < 2; i++) {
        const struct host_config config = { .without_bus = true };
        struct audit audit;
        struct host_config audited = config;
        struct evidence *evidence = calloc(1, sizeof *evidence);
        assert_int_equal(audit_open(&audit, catalogue_find(4, 0), &evidence->audit), 0);
        audited.audit = &audit;
        rig = open_with(&audited);
        rig_start(rig);
        tell(rig, 1, i == 0 ? 0 : MS(3), 1);
        rig_cycles(rig, 8);
        *(i == 0 ? &without : &with) = evidence->audit.functions[ENTRY_01].worst_instructions;
        assert_true(evidence->audit.functions[ENTRY_01].stack_bytes > 256);
        rig_close(rig);
        audit_close(&audit);
        free(evidence);
    }
    rig_kind = MACHINE_NATIVE;
    assert_true(with == without);
    assert_true(with > 100);
}

static void who_is_interrupted_may_find_the_interrupter_asleep(void **state)
{
    struct rig *rig = open_preempted(PREEMPT_SEEDED, 0);

    (void)state;
    tell(rig, 1, MS(1), 2);
    tell(rig, 2, MS(2), 2);
    tell(rig, 3, MS(3), 2);
    rig_cycles(rig, 400);
    assert_int_equal(rig->evidence.incident_count, 0);
    assert_true(rig->evidence.interrupt_count > 20);
    for (unsigned i = 1; i <= 3; i++) {
        assert_true(ENDED(rig, i) > 5);
        assert_int_equal(seen(after_of(rig, i)).wrong, 0);
    }
    rig_close(rig);
}

static void an_interrupt_is_counted_over_the_sleep(void **state)
{
    struct rig *rig = open_preempted(PREEMPT_AT, 400);

    (void)state;
    tell(rig, 1, MS(1), 1); /* some 64 * 6 instructions before it, as many behind */
    tell(rig, 2, MS(1), 1);
    rig_cycles(rig, 200);
    assert_true(rig->evidence.interrupt_count > 0);
    for (unsigned i = 0; i < rig->evidence.interrupt_count && i < EVIDENCE_INTERRUPTS; i++)
        assert_int_equal(rig->evidence.interrupts[i].instructions, 400);
    assert_true(ENDED(rig, 1) > 2);
    rig_close(rig);
}

static void calls_that_are_tried_out_do_not_sleep(void **state)
{
    struct rig *rig = open_preempted(PREEMPT_TRIED, 0);

    (void)state;
    tell(rig, 1, MS(1), 1);
    tell(rig, 2, MS(1), 1);
    rig_cycles(rig, 120);
    assert_true(rig->evidence.tried_points > 0);
    assert_int_equal(rig->evidence.incident_count, 0);
    assert_true(ENDED(rig, 1) > 2);
    const struct seen before = seen(before_of(rig, 1)), after = seen(after_of(rig, 1));
    assert_int_equal(after.tick - before.tick, 2);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(five_milliseconds_are_ten_cycles_of_500_us),
        cmocka_unit_test(a_sleep_lasts_at_least_as_long_as_wanted_and_ends_in_the_next_slot),
        cmocka_unit_test(what_is_above_and_below_a_sleeper_runs_on),
        cmocka_unit_test(each_sleeper_wakes_at_its_own_time),
        cmocka_unit_test(nothing_or_less_is_over_at_once),
        cmocka_unit_test(program_04_and_05_and_ini_do_not_wait),
        cmocka_unit_test(more_than_a_second_in_a_call_is_a_hang),
        cmocka_unit_test(the_longest_interval_there_is_is_one_as_well),
        cmocka_unit_test(a_stop_waits_for_who_is_asleep),
        cmocka_unit_test(a_reset_of_tg_motion_forgets_who_is_asleep),
        cmocka_unit_test(twice_is_the_same_and_on_the_instrumented_machine_as_well),
        cmocka_unit_test(instructions_are_those_of_the_whole_call),
        cmocka_unit_test(who_is_interrupted_may_find_the_interrupter_asleep),
        cmocka_unit_test(an_interrupt_is_counted_over_the_sleep),
        cmocka_unit_test(calls_that_are_tried_out_do_not_sleep),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
