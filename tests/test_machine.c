/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine.c - faults and guarded memory: each charged to the right place. Not sealed, in this
 * process. */
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/auxv.h>

#include "machine_fixture.h"

/* Faults whose place and address are known without running anything. */
static const struct {
    const char *function, *blamed;
    int signal;
    enum machine_access access;
    uint64_t address;
    bool native; /* the emulated CPU does not look for it */
} simple_faults[] = {
    { "null_read", "null_read_at", SIGSEGV, MACHINE_ACCESS_READ, 16, false },
    { "divide_by_zero", "divide_by_zero_at", SIGFPE, MACHINE_ACCESS_NONE, 0, false },
    { "undefined_instruction", "undefined_instruction_at", SIGILL, MACHINE_ACCESS_NONE, 0, false },
    { "breakpoint", "breakpoint_at", SIGTRAP, MACHINE_ACCESS_NONE, 0, false },
    { "long_breakpoint", "long_breakpoint_at", SIGTRAP, MACHINE_ACCESS_NONE, 0, false },
    { "privileged", "privileged_at", SIGSEGV, MACHINE_ACCESS_NONE, 0, false },
    { "non_canonical", "non_canonical_at", SIGSEGV, MACHINE_ACCESS_NONE, 0, false },
    { "non_canonical_stack", "non_canonical_stack_at", SIGBUS, MACHINE_ACCESS_NONE, 0, false },
    { "null_with_wild_stack", "null_with_wild_stack_at", SIGSEGV, MACHINE_ACCESS_READ, 0, false },
    { "trap_flag", "trap_flag_at", SIGTRAP, MACHINE_ACCESS_NONE, 0, false },
    { "misaligned_access", "misaligned_access_at", SIGBUS, MACHINE_ACCESS_NONE, 0, true },
    { "fault_without_fs", "fault_without_fs_at", SIGSEGV, MACHINE_ACCESS_READ, 0, false },
};

static void fault_with_a_moved_thread_pointer_is_survived(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine_outcome outcome;

    (void)state;
    if (!(getauxval(AT_HWCAP2) & 2)) {
        print_message("  not judged: the processor has no wrfsbase\n");
        skip();
    }
    outcome = call(fixture, "fault_with_moved_fs", NULL);
    assert_int_equal(outcome.kind,
                     fixture_kind == MACHINE_NATIVE ? MACHINE_FAULT : MACHINE_UNSUPPORTED);
    if (fixture_kind != MACHINE_NATIVE)
        return;
    assert_int_equal(outcome.fault.pc, at(fixture, "fault_with_moved_fs_at"));
    errno = 7; /* through the thread pointer */
    assert_int_equal(errno, 7);
}

static void faults_are_attributed_to_the_instruction(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    for (size_t i = 0; i < COUNT(simple_faults); i++) {
        const char *function = simple_faults[i].function;

        if (simple_faults[i].native && fixture_kind != MACHINE_NATIVE)
            continue;
        struct machine_outcome outcome = call(fixture, function, NULL);
        uint64_t blamed = at(fixture, simple_faults[i].blamed);

        print_message("  %s\n", function);
        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_int_equal(outcome.fault.signal, simple_faults[i].signal);
        assert_int_equal(outcome.fault.access, simple_faults[i].access);
        assert_int_equal(outcome.fault.address, simple_faults[i].address);
        assert_true(outcome.fault.in_module);
        assert_true(outcome.fault.has_pc);
        assert_int_equal(outcome.fault.pc, blamed);
        assert_ptr_equal(outcome.fault.ip, machine_address(fixture->machine, blamed));
        assert_string_equal(outcome.fault.region, "");
        assert_null(outcome.fault.service);
        assert_int_equal(call(fixture, "returns_value", NULL).kind, MACHINE_RETURNED);
    }
}

/* Calls to nowhere: the instruction pointer is useless, the return address is not. */
static const struct {
    const char *function, *back;
    uint64_t address;
} nowhere[] = {
    { "call_null", "call_null_back", 0 },
    { "call_null_in_table", "call_null_in_table_back", 0 },
    { "call_null_indexed", "call_null_indexed_back", 0 },
    { "wild_jump_below", "wild_jump_below_back", 0x123456789000 },
    { "wild_jump", NULL, 0x123456789000 },
    { "far_return", NULL, 0x1000 },
};

static void calls_to_nowhere_are_attributed_to_the_caller(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    for (size_t i = 0; i < COUNT(nowhere); i++) {
        struct machine_outcome outcome;

        /* The emulated CPU has no 32-bit code segment to switch to. */
        if (fixture_kind != MACHINE_NATIVE && strcmp(nowhere[i].function, "far_return") == 0)
            continue;
        outcome = call(fixture, nowhere[i].function, NULL);
        print_message("  %s\n", nowhere[i].function);
        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_int_equal(outcome.fault.signal, SIGSEGV);
        assert_int_equal(outcome.fault.access, MACHINE_ACCESS_EXECUTE);
        assert_int_equal(outcome.fault.address, nowhere[i].address);
        assert_int_equal(outcome.fault.ip, nowhere[i].address);
        assert_false(outcome.fault.in_module);
        assert_int_equal(outcome.fault.has_pc, nowhere[i].back != NULL);
        if (nowhere[i].back != NULL)
            assert_int_equal(outcome.fault.pc, at(fixture, nowhere[i].back));
    }
}

static void function_that_is_no_code_faults(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine_outcome outcome;

    (void)state;
    machine_call(fixture->machine, 0x40000000, NULL, &outcome);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.access, MACHINE_ACCESS_EXECUTE);
    assert_false(outcome.fault.has_pc);
}

static void expect_region(const struct machine_outcome *outcome, enum machine_access access,
                          const char *region, int64_t offset, uint64_t size)
{
    assert_int_equal(outcome->kind, MACHINE_FAULT);
    assert_int_equal(outcome->fault.signal, SIGSEGV);
    assert_int_equal(outcome->fault.access, access);
    assert_string_equal(outcome->fault.region, region);
    assert_int_equal(outcome->fault.region_offset, offset);
    assert_int_equal(outcome->fault.region_size, size);
}

static void overruns_name_the_region_and_the_distance(void **state)
{
    struct fixture *fixture = opened("faults");
    uint8_t *host,
        *servo = map(fixture, "TGM_Servo", 4080, MACHINE_REGION_READ_WRITE, (void **)&host);
    struct machine_outcome outcome = call(fixture, "write_past_end", servo + 4080);

    (void)state;
    expect_region(&outcome, MACHINE_ACCESS_WRITE, "TGM_Servo", 4096, 4080);
    assert_ptr_equal(outcome.fault.address, servo + 4096);
    assert_int_equal(outcome.fault.pc, at(fixture, "write_past_end_at"));
    outcome = call(fixture, "read_first_past_end", servo + 4080);
    expect_region(&outcome, MACHINE_ACCESS_READ, "TGM_Servo", 4080, 4080);
    outcome = call(fixture, "read_before", servo - 16);
    expect_region(&outcome, MACHINE_ACCESS_READ, "TGM_Servo", -17, 4080);
    outcome = call(fixture, "read_before", servo); /* slack of the same page */
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, 0xcd);
    outcome = call(fixture, "write_here", servo + 4080 + (1 << 20) - 1);
    expect_region(&outcome, MACHINE_ACCESS_WRITE, "TGM_Servo", 4080 + (1 << 20) - 1, 4080);
    outcome = call(fixture, "write_here", servo - 16 - (1 << 20));
    expect_region(&outcome, MACHINE_ACCESS_WRITE, "TGM_Servo", -16 - (1 << 20), 4080);
    outcome = call(fixture, "write_here", servo);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(servo[0], 1);
    assert_ptr_equal(host, servo);
}

static void odd_sizes_are_aligned_and_padded(void **state)
{
    struct fixture *fixture = opened("faults");
    uint8_t *odd = map(fixture, "odd", 5, MACHINE_REGION_READ_WRITE, NULL);
    static const uint8_t zero[5];

    (void)state;
    assert_int_equal((uintptr_t)odd % 16, 0);
    assert_int_equal(((uintptr_t)odd + 16) % 4096, 0);
    assert_memory_equal(odd, zero, 5);
    assert_int_equal(odd[-1], 0xcd);
    for (int i = 5; i < 16; i++)
        assert_int_equal(odd[i], 0xcd);
}

static void module_cannot_write_what_it_may_only_read(void **state)
{
    struct fixture *fixture = opened("faults");
    uint8_t *host, *module = map(fixture, "TGM_System", 256, MACHINE_REGION_READ, (void **)&host);
    struct machine_outcome outcome;

    (void)state;
    assert_ptr_not_equal(host, module);
    host[0] = 0x5a;
    outcome = call(fixture, "read_here", module);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, 0x5a);
    outcome = call(fixture, "write_here", module);
    expect_region(&outcome, MACHINE_ACCESS_WRITE, "TGM_System", 0, 256);
    assert_int_equal(host[0], 0x5a);
    outcome = call(fixture, "write_code", NULL);
    expect_region(&outcome, MACHINE_ACCESS_WRITE, "module", (int64_t)at(fixture, "write_code"),
                  fixture->image->span_end);
    assert_int_equal(outcome.fault.pc, at(fixture, "write_code_at"));
}

static void data_is_never_executed(void **state)
{
    struct fixture *fixture = opened("faults");
    uint8_t *region = map(fixture, "code", 64, MACHINE_REGION_READ_WRITE, NULL);
    struct machine_outcome outcome = call(fixture, "execute_data", NULL);

    (void)state;
    expect_region(&outcome, MACHINE_ACCESS_EXECUTE, "module", (int64_t)at(fixture, "some_data"),
                  fixture->image->span_end);
    assert_true(outcome.fault.in_module);
    assert_int_equal(outcome.fault.pc, at(fixture, "some_data"));
    region[0] = 0xc3;
    outcome = call(fixture, "call_here", region);
    expect_region(&outcome, MACHINE_ACCESS_EXECUTE, "code", 0, 64);
    assert_false(outcome.fault.in_module);
    assert_int_equal(outcome.fault.pc, at(fixture, "call_here_back"));
}

static void stack_overflow_is_caught_every_time(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    for (int i = 0; i < 3; i++) {
        struct machine_outcome outcome = call(fixture, "recurse", NULL);

        expect_region(&outcome, MACHINE_ACCESS_WRITE, "stack", -8, 256 << 10);
        assert_int_equal(outcome.fault.pc, at(fixture, "recurse_at"));
        assert_int_equal(call(fixture, "returns_value", NULL).kind, MACHINE_RETURNED);
    }
    struct machine_outcome outcome = call(fixture, "huge_frame", NULL);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_string_equal(outcome.fault.region, "stack");
    assert_true(outcome.fault.region_offset < -(7 << 20));
}

static void stack_use_is_the_deepest_so_far(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    assert_int_equal(machine_stack_used(fixture->machine), 0);
    call(fixture, "returns_value", NULL);
    assert_int_equal(machine_stack_used(fixture->machine), 8);
    call(fixture, "wild_jump_below", NULL);
    assert_int_equal(machine_stack_used(fixture->machine), 16);
    call(fixture, "returns_value", NULL);
    assert_int_equal(machine_stack_used(fixture->machine), 16);
    call(fixture, "recurse", NULL);
    assert_true(machine_stack_used(fixture->machine) > (256 << 10) - 100);
}

static void single_stepping_out_of_the_module_is_caught(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine_outcome outcome = call(fixture, "trap_flag_at_return", NULL);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.signal, SIGTRAP);
    assert_false(outcome.fault.in_module);
}

static void bad_regions_are_refused_with_a_reason(void **state)
{
    struct fixture *fixture = opened("faults");
    void *host, *module;
    char why[MACHINE_WHY];

    (void)state;
    assert_int_equal(
        machine_map(fixture->machine, "empty", 0, MACHINE_REGION_READ, &host, &module, why),
        -EINVAL);
    assert_string_not_equal(why, "");
    assert_int_equal(machine_map(fixture->machine, "a name of more than thirty-one characters", 16,
                                 MACHINE_REGION_READ, &host, &module, why),
                     -EINVAL);
    /* The thread block takes one. */
    for (int i = fixture_kind == MACHINE_NATIVE ? 2 : 3; i < 64; i++)
        map(fixture, "many", 16, MACHINE_REGION_READ_WRITE, NULL);
    assert_int_equal(
        machine_map(fixture->machine, "one more", 16, MACHINE_REGION_READ, &host, &module, why),
        -EINVAL);
}

#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADED(fault_with_a_moved_thread_pointer_is_survived),
        LOADED(faults_are_attributed_to_the_instruction),
        LOADED(calls_to_nowhere_are_attributed_to_the_caller),
        LOADED(function_that_is_no_code_faults),
        LOADED(overruns_name_the_region_and_the_distance),
        LOADED(odd_sizes_are_aligned_and_padded),
        LOADED(module_cannot_write_what_it_may_only_read),
        LOADED(data_is_never_executed),
        LOADED(stack_overflow_is_caught_every_time),
        LOADED(stack_use_is_the_deepest_so_far),
        LOADED(single_stepping_out_of_the_module_is_caught),
        LOADED(bad_regions_are_refused_with_a_reason),
    };

    int failed = cmocka_run_group_tests_name("native machine", tests, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("instrumented machine", tests, NULL, NULL);
}
