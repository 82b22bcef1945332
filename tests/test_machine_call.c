/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_call.c - calls and their ways back: values, hangs, services, calling convention. */
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/auxv.h>
#include <time.h>

#include "machine_fixture.h"

static void returns_the_raw_64_bit_value(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine_outcome outcome = call(fixture, "returns_value", (void *)0x123456789abcdef0);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, ~0x123456789abcdef0);
    assert_int_equal(outcome.abi_broken, 0);
    assert_int_equal(outcome.elapsed_ns, 0);
}

static void time_is_measured_when_asked(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    machine_timing(fixture->machine, true);
    assert_true(call(fixture, "returns_value", NULL).elapsed_ns > 0);
    machine_timing(fixture->machine, false);
    assert_true(call(fixture, "returns_value", NULL).elapsed_ns == 0);
}

static void endless_loop_is_a_hang(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    machine_timing(fixture->machine, true);
    for (int i = 0; i < 2; i++) {
        struct machine_outcome outcome = call(fixture, "loop_for_ever", NULL);

        assert_int_equal(outcome.kind, MACHINE_HANG);
        assert_int_equal(outcome.fault.signal, SIGALRM);
        assert_true(outcome.fault.in_module);
        assert_int_equal(outcome.fault.pc, at(fixture, "loop_for_ever_at"));
        if (fixture_kind == MACHINE_NATIVE)
            assert_true(outcome.elapsed_ns >= TEST_HANG_NS);
        else
            assert_int_equal(outcome.instructions, TEST_HANG_NS / 50);
        assert_int_equal(call(fixture, "returns_value", NULL).kind, MACHINE_RETURNED);
    }
    machine_timing(fixture->machine, false);
}

/* Host services as host/ writes them. */
static struct machine *service_machine;
static volatile unsigned long service_calls, service_ends;

static long quick_service(void *unused)
{
    (void)unused;
    machine_service_enter(service_machine, "quick", __builtin_return_address(0));
    service_calls++;
    for (volatile int i = 0; i < 20000; i++)
        ;
    service_ends++;
    machine_service_leave(service_machine);
    return 0;
}

static long endless_service(void *unused)
{
    (void)unused;
    machine_service_enter(service_machine, "endless", __builtin_return_address(0));
    do
        service_calls++;
    while (service_calls != 0);
    machine_service_leave(service_machine);
    return 0;
}

static long writing_service(void *where)
{
    machine_service_enter(service_machine, "outer", __builtin_return_address(0));
    machine_service_enter(service_machine, "inner", __builtin_return_address(0));
    machine_service_leave(service_machine);
    *(volatile char *)where = 1;
    machine_service_leave(service_machine);
    return 99;
}

/* One that was forgotten. */
static __attribute__((noinline)) long unbracketed(void *where)
{
    volatile char frame[100];

    frame[0] = 1;
    *(volatile char *)where = frame[0];
    return frame[0];
}

struct host_call {
    long (*function)(void *);
    void *argument;
};

static void hang_around_a_service_ends_when_the_service_leaves(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine_outcome outcome;

    (void)state;
    service_machine = fixture->machine;
    service_calls = 0;
    service_ends = 0;
    outcome = call(fixture, "loop_around_host", (void *)(uintptr_t)quick_service);
    assert_int_equal(outcome.kind, MACHINE_HANG);
    assert_true(service_calls > 10);
    assert_int_equal(service_ends, service_calls); /* none was cut short */
    assert_true(outcome.fault.has_pc);
    if (!outcome.fault.in_module) {
        assert_string_equal(outcome.fault.service, "quick");
        assert_int_equal(outcome.fault.pc, at(fixture, "loop_around_host_back"));
    }
    struct host_call again = { quick_service, NULL };
    assert_int_equal(call(fixture, "call_host", &again).kind, MACHINE_RETURNED);
}

static void service_that_does_not_leave_is_left(void **state)
{
    struct fixture *fixture = opened("faults");
    struct host_call host = { endless_service, NULL };
    struct machine_outcome outcome;

    (void)state;
    service_machine = fixture->machine;
    outcome = call(fixture, "call_host", &host);
    assert_int_equal(outcome.kind, MACHINE_HANG);
    assert_false(outcome.fault.in_module);
    assert_string_equal(outcome.fault.service, "endless");
    assert_int_equal(outcome.fault.pc, at(fixture, "call_host_back"));
}

static void bad_pointer_in_a_service_is_charged_to_the_call(void **state)
{
    struct fixture *fixture = opened("faults");
    struct host_call host = { writing_service, (void *)8 };
    struct machine_outcome outcome;
    char good;

    (void)state;
    service_machine = fixture->machine;
    outcome = call(fixture, "call_host", &host);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.access, MACHINE_ACCESS_WRITE);
    assert_int_equal(outcome.fault.address, 8);
    assert_string_equal(outcome.fault.service, "outer");
    assert_int_equal(outcome.fault.pc, at(fixture, "call_host_back"));
    assert_false(outcome.fault.in_module);

    outcome = call(fixture, "null_read", NULL);
    assert_null(outcome.fault.service);
    host.argument = &good;
    assert_int_equal(call(fixture, "call_host", &host).value, 99);
    assert_int_equal(good, 1);
}

static void bad_pointer_in_host_code_finds_the_caller_on_the_stack(void **state)
{
    struct fixture *fixture = opened("faults");
    struct host_call host = { unbracketed, (void *)8 };
    struct machine_outcome outcome = call(fixture, "call_host", &host);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.access, MACHINE_ACCESS_WRITE);
    assert_false(outcome.fault.in_module);
    assert_null(outcome.fault.service);
    assert_int_equal(outcome.fault.pc, at(fixture, "call_host_back"));
}

/* Ticks of the watchdog land everywhere: before, in and after calls and services. */
static void ticks_do_not_disturb_short_calls(void **state)
{
    static const struct machine_config nervous = { .seed = 1, .hang_ns = 1000000 };
    char good;
    struct host_call host = { writing_service, &good };
    struct timespec begin, now;

    (void)state;
    fixture_open(&the_fixture, "faults", &nervous);
    service_machine = the_fixture.machine;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    do {
        for (int64_t i = 0; i < 10000; i++) {
            struct machine_outcome outcome;

            machine_call(the_fixture.machine, at(&the_fixture, "returns_value"), (void *)i,
                         &outcome);
            if (outcome.kind != MACHINE_RETURNED || outcome.value != ~i || outcome.abi_broken != 0)
                fail_msg("call %ld came back wrong: %d", (long)i, (int)outcome.kind);
            machine_call(the_fixture.machine, at(&the_fixture, "call_host"), &host, &outcome);
            if (outcome.kind != MACHINE_RETURNED || outcome.value != 99)
                fail_msg("service call %ld came back wrong: %d", (long)i, (int)outcome.kind);
        }
        clock_gettime(CLOCK_MONOTONIC, &now);
    } while ((now.tv_sec - begin.tv_sec) * 1000 + (now.tv_nsec - begin.tv_nsec) / 1000000 < 300);
}

static void faults_by_the_thousand_leave_nothing_behind(void **state)
{
    struct fixture *fixture = opened("faults");

    (void)state;
    for (int i = 0; i < 5000; i++) {
        assert_int_equal(call(fixture, "null_read", NULL).kind, MACHINE_FAULT);
        assert_int_equal(call(fixture, "recurse", NULL).kind, MACHINE_FAULT);
        assert_int_equal(call(fixture, "divide_by_zero", NULL).kind, MACHINE_FAULT);
    }
    assert_int_equal(call(fixture, "returns_value", NULL).kind, MACHINE_RETURNED);
}

static const struct {
    const char *function;
    unsigned broken;
} conventions[] = {
    { "keeps_all", 0 },
    { "break_rbx", MACHINE_ABI_RBX },
    { "break_rbp", MACHINE_ABI_RBP },
    { "break_r12", MACHINE_ABI_R12 },
    { "break_r13", MACHINE_ABI_R13 },
    { "break_r14", MACHINE_ABI_R14 },
    { "break_r15", MACHINE_ABI_R15 },
    { "swap_registers", MACHINE_ABI_RBX | MACHINE_ABI_R15 },
    { "break_stack", MACHINE_ABI_STACK },
    { "lose_stack", MACHINE_ABI_STACK },
    { "break_direction", MACHINE_ABI_DIRECTION },
    { "break_alignment_check", MACHINE_ABI_FLAGS },
    { "break_mxcsr", MACHINE_ABI_MXCSR },
    { "inexact_mxcsr", 0 },
    { "break_x87_control", MACHINE_ABI_X87_CONTROL },
    { "change_x87_control", MACHINE_ABI_X87_CONTROL },
    { "leave_x87_value", MACHINE_ABI_X87_STACK },
    { "leave_mmx", MACHINE_ABI_X87_STACK },
    { "break_everything",
      (MACHINE_ABI_RDI - 1) & ~(unsigned)(MACHINE_ABI_X87_STACK | MACHINE_ABI_FS) },
    { "break_fs", MACHINE_ABI_FS },
};

/* What the host relies on after a call. */
static void host_is_unharmed(void)
{
    uint32_t mxcsr;
    uint16_t x87, status;
    uint64_t flags;
    volatile long double three = 3.0L;

    __asm__ volatile("stmxcsr %0" : "=m"(mxcsr));
    __asm__ volatile("fnstcw %0" : "=m"(x87));
    __asm__ volatile("fnstsw %0" : "=m"(status));
    __asm__ volatile("pushfq\n\tpop %0" : "=r"(flags));
    assert_int_equal(mxcsr & 0xffc0, 0x1f80);
    assert_int_equal(x87, 0x37f);
    assert_int_equal(status & 0x3800, 0);
    assert_int_equal(flags & 0x44500, 0);
    assert_true(three * three == 9.0L);
    errno = 5; /* through the thread pointer */
    assert_int_equal(errno, 5);
}

static void broken_calling_convention_is_reported_and_repaired(void **state)
{
    struct fixture *fixture = opened("abi");

    (void)state;
    for (size_t i = 0; i < COUNT(conventions); i++) {
        bool uses_fs = conventions[i].broken == MACHINE_ABI_FS;

        print_message("  %s\n", conventions[i].function);
        if (uses_fs && (!(getauxval(AT_HWCAP2) & 2) || fixture_kind != MACHINE_NATIVE)) {
            print_message("  not judged: the processor has no wrfsbase\n");
            continue;
        }
        struct machine_outcome outcome = call(fixture, conventions[i].function, NULL);

        assert_int_equal(outcome.kind, MACHINE_RETURNED);
        assert_int_equal(outcome.abi_broken, conventions[i].broken);
        host_is_unharmed();
        outcome = call(fixture, "keeps_all", NULL);
        assert_int_equal(outcome.abi_broken, 0);
        assert_int_equal(outcome.value, 3);
    }
}

static void registers_on_entry_are_known(void **state)
{
    struct fixture *fixture = opened("faults");
    uint64_t *words = map(fixture, "words", 256, MACHINE_REGION_READ_WRITE, NULL), first[32];
    uint64_t function = at(fixture, "store_registers");
    struct machine_outcome outcome;

    (void)state;

    __asm__ volatile("mov $-1, %%r8\n\tmov $-1, %%r9\n\tmov $-1, %%r10\n\tmov $-1, %%r11" ::
                         : "r8", "r9", "r10", "r11");
    machine_call(fixture->machine, function, words, &outcome);
    assert_ptr_equal(words[0], place(fixture, "store_registers"));
    for (int i = 1; i < 8; i++)
        assert_int_equal(words[i], 0);
    for (int i = 8; i < 14; i++)
        assert_int_equal(words[i] >> 56, 0x5e);
    assert_int_equal((words[14] + 8) % 16, 0);
    for (int i = 16; i < 22; i++)
        assert_int_equal(words[i], 0);
    assert_int_equal(words[22] & 0xffffffc0, 0x1f80);
    assert_int_equal(words[23], 0x37f);
    memcpy(first, words, sizeof first);
    fixture_close(fixture);
    fixture = opened("faults");
    words = map(fixture, "words", 256, MACHINE_REGION_READ_WRITE, NULL);
    call(fixture, "store_registers", words);
    words[22] = first[22] = 0; /* sticky flags are the host's */
    assert_memory_equal(words, first, sizeof first);
}

static void one_machine_at_a_time(void **state)
{
    struct fixture *fixture = opened("faults");
    struct machine *second = (void *)1;
    char why[MACHINE_WHY] = "";

    (void)state;
    const struct machine_config same = { .kind = fixture_kind };

    assert_int_equal(machine_load(&second, fixture->image, &same, why), -EBUSY);
    assert_null(second);
    assert_string_not_equal(why, "");
    assert_int_equal(call(fixture, "returns_value", NULL).kind, MACHINE_RETURNED);
}

static void unloading_gives_signals_back(void **state)
{
    struct sigaction before, during, after;
    stack_t stack_before, stack_after;
    struct fixture fixture;

    (void)state;
    sigaction(SIGSEGV, NULL, &before);
    sigaltstack(NULL, &stack_before);
    fixture_open(&fixture, "faults", &plain_config);
    sigaction(SIGSEGV, NULL, &during);
    fixture_close(&fixture);
    sigaction(SIGSEGV, NULL, &after);
    sigaltstack(NULL, &stack_after);
    assert_true(during.sa_sigaction != before.sa_sigaction);
    assert_true(after.sa_sigaction == before.sa_sigaction);
    assert_int_equal(stack_after.ss_flags, stack_before.ss_flags);
}

#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest both[] = {
        LOADED(returns_the_raw_64_bit_value),
        LOADED(time_is_measured_when_asked),
        LOADED(endless_loop_is_a_hang),
        LOADED(broken_calling_convention_is_reported_and_repaired),
        LOADED(faults_by_the_thousand_leave_nothing_behind),
        LOADED(registers_on_entry_are_known),
        LOADED(one_machine_at_a_time),
    };
    const struct CMUnitTest native[] = {
        LOADED(hang_around_a_service_ends_when_the_service_leaves),
        LOADED(service_that_does_not_leave_is_left),
        LOADED(bad_pointer_in_a_service_is_charged_to_the_call),
        LOADED(bad_pointer_in_host_code_finds_the_caller_on_the_stack),
        LOADED(ticks_do_not_disturb_short_calls),
        cmocka_unit_test(unloading_gives_signals_back),
    };
    int failed = cmocka_run_group_tests_name("calls, native", both, NULL, NULL) +
                 cmocka_run_group_tests_name("services and signals", native, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("calls, instrumented", both, NULL, NULL);
}
