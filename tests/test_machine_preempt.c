/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_preempt.c - calls that are stopped between two instructions, calls inside them, and
 * the module loaded once more. */
#define _GNU_SOURCE 1
#include <signal.h>
#include <time.h>

#include "machine_fixture.h"

static const struct machine_config interruptible = { .seed = 1,
                                                     .hang_ns = 5 * TEST_HANG_NS,
                                                     .interruptible = true };

static struct fixture *opened_interruptible(void)
{
    struct machine_config config = interruptible;

    config.kind = fixture_kind;
    fixture_open(&the_fixture, "interrupt", &config);
    return &the_fixture;
}

/* What a hook is to do, and what it saw. */
struct watcher {
    struct fixture *fixture;
    const char *function; /* called by the hook, NULL: none */
    void *argument;
    uint64_t again; /* what the hook returns */
    unsigned count; /* how often it came */
    uint64_t pc, instructions;
    struct machine_outcome outcome;
    struct watcher *inner; /* interrupts the function that the hook calls */
    uint64_t inner_after;
};

static uint64_t hook(void *argument, uint64_t pc, uint64_t instructions)
{
    struct watcher *watcher = argument;

    watcher->count++;
    watcher->pc = pc;
    watcher->instructions = instructions;
    if (watcher->inner != NULL)
        machine_interrupt_next(watcher->fixture->machine, watcher->inner_after, hook,
                               watcher->inner);
    if (watcher->function != NULL)
        watcher->outcome = call(watcher->fixture, watcher->function, watcher->argument);
    return watcher->again;
}

static struct machine_outcome call_interrupted(struct watcher *watcher, uint64_t after,
                                               const char *function, void *argument)
{
    machine_interrupt_next(watcher->fixture->machine, after, hook, watcher);
    return call(watcher->fixture, function, argument);
}

static void a_word_written_in_halves_is_torn_between_them_and_nowhere_else(void **state)
{
    struct fixture *fixture = opened_interruptible();
    uint64_t *words = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    const uint64_t old = 0x1111111122222222, new = 0x3333333344444444;

    (void)state;
    for (uint64_t after = 0; after < 6; after++) {
        struct watcher watcher = {
            .fixture = fixture, .function = "read_whole", .argument = words, .again = MACHINE_NEVER
        };
        const uint64_t seen = after < 2 ? old : after < 4 ? 0x1111111144444444 : new;

        words[0] = old;
        words[1] = new;
        assert_int_equal(call_interrupted(&watcher, after, "write_halves", words).value, 1);
        assert_int_equal(watcher.count, 1);
        assert_int_equal(watcher.instructions, after);
        assert_int_equal((uint64_t)watcher.outcome.value, seen);
        assert_int_equal(words[0], new);
        if (after == 2)
            assert_int_equal(watcher.pc, at(fixture, "between_halves"));
    }
}

static void a_call_that_ends_before_is_not_interrupted(void **state)
{
    struct fixture *fixture = opened_interruptible();
    uint64_t *words = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    struct watcher watcher = { .fixture = fixture, .again = MACHINE_NEVER };

    (void)state;
    assert_int_equal(call_interrupted(&watcher, 6, "write_halves", words).value, 1);
    assert_int_equal(watcher.count, 0);
    assert_int_equal(machine_instructions(fixture->machine), 6);
    /* The plan was for that call only. */
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.count, 0);
}

static void instructions_are_counted_exactly(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher watcher = { .fixture = fixture, .again = MACHINE_NEVER };

    (void)state;
    assert_int_equal(call_interrupted(&watcher, UINT64_MAX - 1, "loop_1000", NULL).value, 7);
    assert_int_equal(machine_instructions(fixture->machine), 2003);
    watcher.again = 100;
    assert_int_equal(call_interrupted(&watcher, 3, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.count, 20); /* 3, 103, ... 1903; 2003 is past the end */
    assert_int_equal(watcher.instructions, 1903);
}

static void nothing_of_the_interrupted_call_is_lost(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher none = { .fixture = fixture, .again = MACHINE_NEVER };
    uint64_t length;

    (void)state;
    assert_int_equal(call_interrupted(&none, UINT64_MAX - 1, "keep_everything", NULL).value, 0);
    length = machine_instructions(fixture->machine);
    assert_in_range(length, 50, 60);
    for (uint64_t after = 0; after < length; after++) {
        struct watcher watcher = { .fixture = fixture,
                                   .function = "keep_everything",
                                   .again = MACHINE_NEVER };
        struct machine_outcome outcome = call_interrupted(&watcher, after, "keep_everything", NULL);

        assert_int_equal(outcome.kind, MACHINE_RETURNED);
        assert_int_equal(outcome.abi_broken, 0);
        assert_int_equal(outcome.value, 0);
        assert_int_equal(watcher.count, 1);
        assert_int_equal(watcher.outcome.value, 0);
        assert_int_equal(watcher.outcome.abi_broken, 0);
    }
}

static void interrupts_nest_to_the_last_level(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher deepest = { .fixture = fixture, .again = MACHINE_NEVER };
    struct watcher third = { .fixture = fixture,
                             .function = "loop_1000",
                             .again = MACHINE_NEVER,
                             .inner = &deepest,
                             .inner_after = 1 };
    struct watcher second = { .fixture = fixture,
                              .function = "loop_1000",
                              .again = MACHINE_NEVER,
                              .inner = &third,
                              .inner_after = 2 };
    struct watcher first = { .fixture = fixture,
                             .function = "loop_1000",
                             .again = MACHINE_NEVER,
                             .inner = &second,
                             .inner_after = 3 };

    (void)state;
    assert_int_equal(call_interrupted(&first, 4, "loop_1000", NULL).value, 7);
    assert_int_equal(first.instructions, 4);
    assert_int_equal(second.instructions, 3);
    assert_int_equal(third.instructions, 2);
    assert_int_equal(deepest.count, 0); /* nothing is above the fourth */
    assert_int_equal(third.outcome.value, 7);
}

static void a_fault_inside_an_interrupt_stays_there(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher watcher = { .fixture = fixture,
                               .function = "fault_at_once",
                               .again = MACHINE_NEVER };

    (void)state;
    assert_int_equal(call_interrupted(&watcher, 50, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.outcome.kind, MACHINE_FAULT);
    assert_int_equal(watcher.outcome.fault.signal, SIGILL);
    assert_int_equal(watcher.outcome.fault.pc, at(fixture, "fault_at_once"));
}

static void a_hang_inside_an_interrupt_stays_there(void **state)
{
    struct fixture *fixture = opened_interruptible();
    uint32_t *word = map(fixture, "word", 16, MACHINE_REGION_READ_WRITE, NULL);
    struct watcher watcher = {
        .fixture = fixture, .function = "wait_for_word", .argument = word, .again = MACHINE_NEVER
    };

    (void)state;
    assert_int_equal(call_interrupted(&watcher, 50, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.outcome.kind, MACHINE_HANG);
}

static void a_fault_after_an_interrupt_is_the_modules(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher watcher = { .fixture = fixture,
                               .function = "read_whole",
                               .again = MACHINE_NEVER };
    struct machine_outcome outcome;

    (void)state;
    watcher.argument = map(fixture, "words", 16, MACHINE_REGION_READ_WRITE, NULL);
    outcome = call_interrupted(&watcher, 0, "fault_at_once", NULL);
    assert_int_equal(watcher.count, 1);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.pc, at(fixture, "fault_at_once"));
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
}

static void the_modules_own_trap_flag_is_still_a_fault(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct machine_outcome outcome = call(fixture, "trap_itself", NULL);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.signal, SIGTRAP);
}

/* Services for the module. */
static struct machine *serving;
static volatile unsigned served;
static volatile uint64_t busy_ns;

static uint64_t monotonic(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

static void service(void)
{
    machine_service_enter(serving, "service", __builtin_return_address(0));
    const uint64_t end = busy_ns > 0 ? monotonic() + busy_ns : 0;
    while (end > 0 && monotonic() < end)
        ;
    served++;
    machine_service_leave(serving);
}

static void services_are_not_interrupted_and_not_counted(void **state)
{
    struct fixture *fixture = opened_interruptible();
    void (**pointer)(void) = map(fixture, "pointer", 16, MACHINE_REGION_READ_WRITE, NULL);
    struct watcher watcher = { .fixture = fixture, .again = MACHINE_NEVER };

    (void)state;
    serving = fixture->machine;
    served = 0;
    busy_ns = 0;
    *pointer = service;
    assert_int_equal(call_interrupted(&watcher, 3, "call_service", pointer).value, 5);
    assert_int_equal(served, 2);
    assert_int_equal(watcher.count, 1);
    assert_int_equal(watcher.pc, at(fixture, "after_service"));
    assert_int_equal(call_interrupted(&watcher, UINT64_MAX - 1, "call_service", pointer).value, 5);
    assert_int_equal(machine_instructions(fixture->machine), 7);
}

/* The alarm's hook: lets the waiting function go on at the third time. */
static uint64_t ring(void *argument, uint64_t pc, uint64_t instructions)
{
    struct watcher *watcher = argument;

    (void)instructions;
    watcher->pc = pc;
    if (++watcher->count == 3)
        *(uint32_t *)watcher->argument = 9;
    else
        machine_alarm_at(watcher->fixture->machine, monotonic() + 100000);
    return MACHINE_NEVER;
}

static void the_alarm_interrupts_by_the_wall_clock(void **state)
{
    struct fixture *fixture = opened_interruptible();
    uint32_t *word = map(fixture, "word", 16, MACHINE_REGION_READ_WRITE, NULL);
    struct watcher watcher = { .fixture = fixture, .argument = word };
    char why[MACHINE_WHY];

    (void)state;
    assert_int_equal(machine_alarm_open(fixture->machine, why), 0);
    machine_interrupt_next(fixture->machine, MACHINE_NEVER, ring, &watcher);
    machine_alarm_at(fixture->machine, monotonic() + 100000);
    assert_int_equal(call(fixture, "wait_for_word", word).value, 9);
    assert_int_equal(watcher.count, 3);
    assert_true(watcher.pc >= at(fixture, "wait_for_word"));
    assert_true(watcher.pc < at(fixture, "call_service"));
    /* Nobody to be told: the alarm is lost. */
    machine_alarm_at(fixture->machine, 1);
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.count, 3);
}

/* Wherever it comes, on the way in, inside or on the way out: nothing breaks. */
static uint64_t again_soon(void *argument, uint64_t pc, uint64_t instructions)
{
    struct watcher *watcher = argument;

    (void)pc, (void)instructions;
    if (++watcher->count % 2 == 0)
        machine_alarm_at(watcher->fixture->machine, 1);
    return MACHINE_NEVER;
}

static void alarms_may_come_anywhere(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher watcher = { .fixture = fixture };
    char why[MACHINE_WHY];

    (void)state;
    assert_int_equal(machine_alarm_open(fixture->machine, why), 0);
    for (unsigned i = 0; i < 100000; i++) {
        machine_interrupt_next(fixture->machine, MACHINE_NEVER, again_soon, &watcher);
        machine_alarm_at(fixture->machine, monotonic() + i % 4000);
        assert_int_equal(call(fixture, "keep_everything", NULL).value, 0);
    }
    assert_true(watcher.count > 0);
}

static void an_alarm_before_the_call_interrupts_its_first_instruction(void **state)
{
    struct fixture *fixture = opened_interruptible();
    struct watcher watcher = { .fixture = fixture, .again = MACHINE_NEVER };
    char why[MACHINE_WHY];

    (void)state;
    assert_int_equal(machine_alarm_open(fixture->machine, why), 0);
    machine_interrupt_next(fixture->machine, MACHINE_NEVER, hook, &watcher);
    machine_alarm_at(fixture->machine, 1); /* long ago: it comes at once */
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
    assert_int_equal(watcher.count, 1);
    assert_int_equal(watcher.pc, at(fixture, "loop_1000"));
}

static void an_alarm_in_a_service_waits_for_its_end(void **state)
{
    struct fixture *fixture = opened_interruptible();
    void (**pointer)(void) = map(fixture, "pointer", 16, MACHINE_REGION_READ_WRITE, NULL);
    struct watcher watcher = { .fixture = fixture, .again = MACHINE_NEVER };
    char why[MACHINE_WHY];

    (void)state;
    serving = fixture->machine;
    served = 0;
    busy_ns = 3000000;
    *pointer = service;
    assert_int_equal(machine_alarm_open(fixture->machine, why), 0);
    machine_interrupt_next(fixture->machine, MACHINE_NEVER, hook, &watcher);
    machine_alarm_at(fixture->machine, monotonic() + 1000000);
    assert_int_equal(call(fixture, "call_service", pointer).value, 5);
    assert_int_equal(watcher.count, 1);
    assert_true(watcher.pc >= at(fixture, "call_service")); /* in the module, not in the service */
}

static void a_reload_brings_back_data_and_stack(void **state)
{
    struct fixture *fixture = opened_interruptible();
    char why[MACHINE_WHY];
    size_t used;

    (void)state;
    assert_int_equal(call(fixture, "count_up", NULL).value, 5);
    assert_int_equal(call(fixture, "count_up", NULL).value, 6);
    assert_int_equal(call(fixture, "keep_everything", NULL).value, 0);
    used = machine_stack_used(fixture->machine);
    assert_true(used > 0);
    assert_int_equal(machine_reload(fixture->machine, why), 0);
    assert_int_equal(call(fixture, "count_up", NULL).value, 5);
    assert_int_equal(machine_stack_used(fixture->machine), used);
}

static void a_reload_brings_back_the_poison(void **state)
{
    const struct machine_config poisoned = {
        .kind = fixture_kind, .seed = 3, .poison = MACHINE_POISON_SEEDED, .hang_ns = TEST_HANG_NS
    };
    char why[MACHINE_WHY];
    int64_t first;

    (void)state;
    fixture_open(&the_fixture, "interrupt", &poisoned);
    first = call(&the_fixture, "count_up", NULL).value;
    assert_true(first != 5);
    assert_int_equal((uint32_t)call(&the_fixture, "count_up", NULL).value, (uint32_t)first + 1);
    assert_int_equal(machine_reload(the_fixture.machine, why), 0);
    assert_int_equal(call(&the_fixture, "count_up", NULL).value, first);
}

static uint64_t reload_inside(void *argument, uint64_t pc, uint64_t instructions)
{
    char why[MACHINE_WHY];

    (void)pc, (void)instructions;
    *(int *)argument = machine_reload(the_fixture.machine, why);
    return MACHINE_NEVER;
}

static void no_reload_under_a_call(void **state)
{
    struct fixture *fixture = opened_interruptible();
    int result = 0;

    (void)state;
    machine_interrupt_next(fixture->machine, 10, reload_inside, &result);
    assert_int_equal(call(fixture, "loop_1000", NULL).value, 7);
    assert_int_equal(result, -16 /* EBUSY */);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_teardown(name, close_fixture)
    const struct CMUnitTest both[] = {
        TEST(a_word_written_in_halves_is_torn_between_them_and_nowhere_else),
        TEST(a_call_that_ends_before_is_not_interrupted),
        TEST(instructions_are_counted_exactly),
        TEST(nothing_of_the_interrupted_call_is_lost),
        TEST(interrupts_nest_to_the_last_level),
        TEST(a_fault_inside_an_interrupt_stays_there),
        TEST(a_hang_inside_an_interrupt_stays_there),
        TEST(a_fault_after_an_interrupt_is_the_modules),
        TEST(the_modules_own_trap_flag_is_still_a_fault),
        TEST(a_reload_brings_back_data_and_stack),
        TEST(a_reload_brings_back_the_poison),
        TEST(no_reload_under_a_call),
    };
    const struct CMUnitTest native[] = {
        TEST(services_are_not_interrupted_and_not_counted),
        TEST(the_alarm_interrupts_by_the_wall_clock),
        TEST(alarms_may_come_anywhere),
        TEST(an_alarm_before_the_call_interrupts_its_first_instruction),
        TEST(an_alarm_in_a_service_waits_for_its_end),
    };
#undef TEST
    int failed = cmocka_run_group_tests_name("interrupts, native", both, NULL, NULL) +
                 cmocka_run_group_tests_name("services and alarms", native, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("interrupts, instrumented", both, NULL, NULL);
}
