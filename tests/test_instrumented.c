/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_instrumented.c - what only an instrumented machine tells: instructions, stack, accesses and
 * coverage of a call, exactly; and how services are reached from it. */
#include <errno.h>
#include <signal.h>
#include <stdlib.h>

#include "machine/arguments.h"
#include "machine_fixture.h"

#define MAX_SEEN 64

static struct {
    size_t count;
    struct trace_access accesses[MAX_SEEN];
} seen;

static void see(void *argument, const struct trace_access *access)
{
    assert_ptr_equal(argument, &seen);
    assert_true(seen.count < MAX_SEEN);
    seen.accesses[seen.count++] = *access;
}

static const struct machine_trace trace = { see, &seen };

static struct fixture *opened_with(const char *module, const struct machine_trace *traced,
                                   uint64_t hang)
{
    const struct machine_config config = { .kind = MACHINE_INSTRUMENTED,
                                           .seed = 1,
                                           .hang_instructions = hang,
                                           .trace = traced,
                                           .interruptible = true };

    seen.count = 0;
    fixture_open(&the_fixture, module, &config);
    return &the_fixture;
}

static const struct {
    const char *function;
    uint64_t argument, instructions, stack;
} counts[] = {
    { "touch", 1, 12, 16 }, { "repeated", 1, 7, 8 }, { "branch", 0, 4, 8 },
    { "branch", 1, 4, 8 },  { "deep", 0, 4, 4104 },  { "general_extension", 0, 4, 8 },
};

static void instructions_and_stack_of_a_call_are_exact(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    uint64_t *words = shared_words(fixture);

    (void)state;
    for (size_t i = 0; i < COUNT(counts); i++) {
        print_message("  %s\n", counts[i].function);
        for (int again = 0; again < 2; again++) {
            struct machine_outcome outcome =
                call(fixture, counts[i].function, counts[i].argument != 0 ? words : NULL);

            assert_int_equal(outcome.kind, MACHINE_RETURNED);
            assert_int_equal(outcome.abi_broken, 0);
            assert_int_equal(outcome.instructions, counts[i].instructions);
            assert_int_equal(outcome.stack_bytes, counts[i].stack);
        }
    }
    assert_int_equal(machine_stack_used(fixture->machine), 4104);
}

static const struct {
    const char *function, *blamed;
    uint64_t instructions;
    enum machine_outcome_kind kind;
    int signal;
} ends[] = {
    { "fault_in_the_middle", "fault_in_the_middle_at", 4, MACHINE_FAULT, SIGSEGV },
    { "divide_in_the_middle", "divide_in_the_middle_at", 4, MACHINE_FAULT, SIGFPE },
    { "call_null_in_the_middle", "call_null_back", 3, MACHINE_FAULT, SIGSEGV },
    { "vector_extension", "vector_extension_at", 1, MACHINE_UNSUPPORTED, SIGILL },
    { "vector_extension_short", "vector_extension_short_at", 0, MACHINE_UNSUPPORTED, SIGILL },
    { "count_bits", "count_bits_at", 0, MACHINE_UNSUPPORTED, SIGILL },
};

static void instructions_count_to_where_a_call_was_left(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    uint64_t *words = shared_words(fixture);

    (void)state;
    for (size_t i = 0; i < COUNT(ends); i++) {
        struct machine_outcome outcome = call(fixture, ends[i].function, words);

        print_message("  %s\n", ends[i].function);
        assert_int_equal(outcome.kind, ends[i].kind);
        assert_int_equal(outcome.fault.signal, ends[i].signal);
        assert_int_equal(outcome.fault.pc, at(fixture, ends[i].blamed));
        assert_int_equal(outcome.instructions, ends[i].instructions);
        assert_int_equal(call(fixture, "branch", NULL).value, 1);
    }
    assert_int_equal(words[1], 1);
    assert_int_equal(words[3], 0); /* behind the fault */
}

static void a_hang_is_so_many_instructions(void **state)
{
    struct fixture *fixture = opened_with("faults", NULL, 12345);
    struct machine_outcome outcome = call(fixture, "loop_for_ever", NULL);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_HANG);
    assert_int_equal(outcome.instructions, 12345);
    assert_int_equal(outcome.fault.pc, at(fixture, "loop_for_ever_at"));
}

/* What `touch` does to the memories, in its order. */
static const struct {
    const char *label;
    int64_t offset;
    unsigned size;
    bool write;
    uint64_t instruction, value;
} touched[] = {
    { "touch_read_8", 0, 8, false, 0, 0x0807060504030201 },
    { "touch_write_4", 8, 4, true, 1, 0x11223344 },
    { "touch_add_2", 16, 2, false, 6, 0xffff },
    { "touch_add_2", 16, 2, true, 6, 0 },
    { "touch_write_1", 21, 1, true, 7, 1 },
    { NULL, 0, 8, false, 8, 0x0807060504030201 },
    { NULL, 8, 8, false, 8, 0x100f0e0d11223344 },
    { "touch_write_16", 32, 8, true, 9, 0x0807060504030201 },
    { "touch_write_16", 40, 8, true, 9, 0x100f0e0d11223344 },
    { "touch_unaligned", 51, 4, false, 10, 0x37363534 },
};

static void every_access_to_a_memory_is_told_in_order(void **state)
{
    struct fixture *fixture = opened_with("traced", &trace, 0);
    uint8_t *first = map(fixture, "first", 128, MACHINE_REGION_READ_WRITE, NULL);
    uint8_t *second = map(fixture, "second", 128, MACHINE_REGION_READ_WRITE, NULL);

    (void)state;
    for (unsigned region = 0; region < 2; region++) {
        uint8_t *memory = region == 0 ? first : second;

        seen.count = 0;
        for (int i = 0; i < 128; i++)
            memory[i] = (uint8_t)(i + 1);
        memory[16] = memory[17] = 0xff;
        assert_int_equal(call(fixture, "touch", memory).instructions, 12);
        assert_int_equal(seen.count, COUNT(touched));
        for (size_t i = 0; i < COUNT(touched); i++) {
            const struct trace_access *access = &seen.accesses[i];

            if (touched[i].label != NULL)
                assert_int_equal(access->pc, at(fixture, touched[i].label));
            assert_int_equal(access->instruction, touched[i].instruction);
            assert_int_equal(access->region, region);
            assert_int_equal(access->offset, touched[i].offset);
            assert_ptr_equal(access->address, memory + touched[i].offset);
            assert_int_equal(access->size, touched[i].size);
            assert_int_equal(access->write, touched[i].write);
            assert_int_equal(access->value, touched[i].value);
        }
    }
}

static void a_repeated_instruction_counts_and_tells_each_time(void **state)
{
    struct fixture *fixture = opened_with("traced", &trace, 0);
    uint64_t *words = shared_words(fixture);

    (void)state;
    assert_int_equal(call(fixture, "repeated", words).instructions, 7);
    assert_int_equal(seen.count, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(seen.accesses[i].pc, at(fixture, "repeated_at"));
        assert_int_equal(seen.accesses[i].offset, 64 + 8 * i);
        assert_int_equal(seen.accesses[i].instruction, 3 + i);
        assert_int_equal(seen.accesses[i].value, UINT64_MAX);
    }
}

static void an_access_that_faults_is_not_told(void **state)
{
    struct fixture *fixture = opened_with("traced", &trace, 0);
    uint8_t *host;
    uint8_t *module = map(fixture, "constant", 32, MACHINE_REGION_READ, (void **)&host);
    struct machine_outcome outcome = call(fixture, "fault_in_the_middle", module);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.instructions, 2);
    assert_string_equal(outcome.fault.region, "constant");
    assert_int_equal(outcome.fault.region_offset, 8);
    assert_int_equal(seen.count, 1);
    assert_false(seen.accesses[0].write);
}

static void slack_of_a_memory_has_offsets_outside_of_it(void **state)
{
    struct fixture *fixture = opened_with("faults", &trace, 0);
    uint8_t *odd = map(fixture, "odd", 5, MACHINE_REGION_READ_WRITE, NULL);

    (void)state;
    assert_int_equal(call(fixture, "read_here", odd + 5).value, 0xcd);
    assert_int_equal(call(fixture, "read_before", odd).value, 0xcd);
    assert_int_equal(seen.count, 2);
    assert_int_equal(seen.accesses[0].offset, 5);
    assert_int_equal(seen.accesses[1].offset, -1);
}

static void a_write_to_code_that_ran_is_told_and_takes_effect(void **state)
{
    struct fixture *fixture = opened_with("traced_open", &trace, 0);
    char why[MACHINE_WHY];

    (void)state;
    for (int again = 0; again < 2; again++) {
        seen.count = 0;
        assert_int_equal(call(fixture, "patch_code", NULL).value, 9);
        assert_int_equal(seen.count, 1);
        assert_int_equal(seen.accesses[0].region, TRACE_CODE);
        assert_true(seen.accesses[0].write);
        assert_int_equal(seen.accesses[0].pc, at(fixture, "patch_code_at"));
        assert_int_equal(seen.accesses[0].offset, at(fixture, "patched") + 1);
        assert_int_equal(call(fixture, "patched", NULL).value, 9);
        assert_int_equal(machine_reload(fixture->machine, why), 0);
        assert_int_equal(call(fixture, "patched", NULL).value, 8);
    }
}

static bool is_covered(const struct fixture *fixture, uint64_t vaddr)
{
    uint64_t begin, end;
    const uint8_t *map = machine_coverage(fixture->machine, &begin, &end);

    assert_non_null(map);
    assert_true(vaddr >= begin && vaddr < end);
    return map[(vaddr - begin) / 8] >> (vaddr - begin) % 8 & 1;
}

static void coverage_is_what_was_executed(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    const uint64_t branch = at(fixture, "branch"), zero = at(fixture, "branch_zero");
    const uint64_t other = at(fixture, "branch_other");

    (void)state;
    assert_false(is_covered(fixture, branch));
    call(fixture, "branch", NULL);
    for (uint64_t at = branch; at < other; at++)
        assert_true(is_covered(fixture, at));
    for (uint64_t at = other; at < zero; at++)
        assert_false(is_covered(fixture, at));
    for (uint64_t at = zero; at < zero + 6; at++)
        assert_true(is_covered(fixture, at));
    assert_false(is_covered(fixture, zero + 6));
    assert_false(is_covered(fixture, branch - 1));
    call(fixture, "branch", shared_words(fixture));
    for (uint64_t at = branch; at < zero + 6; at++)
        assert_true(is_covered(fixture, at));
}

static void what_a_native_machine_does_not_tell_is_zero(void **state)
{
    static const struct machine_config config = { .seed = 1 };
    uint64_t begin, end;

    (void)state;
    fixture_open(&the_fixture, "traced", &config);
    assert_int_equal(call(&the_fixture, "branch", NULL).instructions, 0);
    assert_int_equal(call(&the_fixture, "branch", NULL).stack_bytes, 0);
    assert_null(machine_coverage(the_fixture.machine, &begin, &end));
}

/* --- services --- */

struct served {
    struct fixture *fixture;
    unsigned calls;
    const char *format;
    int64_t whole[6];
    double real[2];
    uint64_t last[2];
};

static int64_t serve(void *context, struct arguments *arguments)
{
    struct served *served = context;

    served->calls++;
    served->format = arguments_pointer(arguments);
    served->whole[0] = (int32_t)arguments_u32(arguments);
    served->whole[1] = (int64_t)arguments_u64(arguments);
    served->real[0] = arguments_f64(arguments);
    served->whole[2] = (int32_t)arguments_u32(arguments);
    served->real[1] = arguments_f64(arguments);
    served->whole[3] = (int32_t)arguments_u32(arguments);
    served->whole[4] = (int32_t)arguments_u32(arguments);
    served->last[0] = arguments_u64(arguments);
    served->last[1] = arguments_u32(arguments);
    return 0x123456789abcdef0;
}

static int64_t write_through(void *context, struct arguments *arguments)
{
    (void)context;
    *(volatile char *)arguments_pointer(arguments) = 1;
    return 1;
}

static void *service(struct fixture *fixture, const char *name, machine_function *function,
                     void *context)
{
    char why[MACHINE_WHY] = "";
    void *pointer = NULL;

    if (machine_service(fixture->machine, name, function, context, &pointer, why) != 0)
        fail_msg("%s", why);
    return pointer;
}

static void a_service_gets_what_the_module_passes(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    struct served served = { .fixture = fixture };
    uint64_t *words = shared_words(fixture);
    struct machine_outcome outcome;

    (void)state;
    service(fixture, "other", write_through, NULL);
    words[0] = (uint64_t)service(fixture, "wanted", serve, &served);
    words[1] = (uint64_t)words;
    outcome = call(fixture, "call_service", words);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0);
    assert_int_equal(outcome.value, 0x123456789abcdef0);
    assert_int_equal(served.calls, 1);
    assert_ptr_equal(served.format, words);
    assert_int_equal(served.whole[0], 2);
    assert_int_equal(served.whole[1], -4);
    assert_true(served.real[0] == 1.0);
    assert_int_equal(served.whole[2], 5);
    assert_true(served.real[1] == 3.0);
    assert_int_equal(served.whole[3], 6);
    assert_int_equal(served.whole[4], 7);
    assert_int_equal(served.last[0], 8);
    assert_int_equal(served.last[1], 9);
    assert_int_equal(outcome.instructions, 19);
    assert_int_equal(outcome.stack_bytes, 8 + 8 + 16 + 8); /* nothing of the service's own */
}

static void a_bad_pointer_in_a_service_is_charged_to_the_call(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    uint64_t *words = shared_words(fixture);

    (void)state;
    words[0] = (uint64_t)service(fixture, "writes", write_through, NULL);
    for (int again = 0; again < 3; again++) {
        words[1] = 24;
        struct machine_outcome outcome = call(fixture, "call_service", words);

        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_int_equal(outcome.fault.signal, SIGSEGV);
        assert_int_equal(outcome.fault.access, MACHINE_ACCESS_WRITE);
        assert_int_equal(outcome.fault.address, 24);
        assert_false(outcome.fault.in_module);
        assert_string_equal(outcome.fault.service, "writes");
        assert_true(outcome.fault.has_pc);
        assert_int_equal(outcome.fault.pc, at(fixture, "call_service_back"));
        words[1] = (uint64_t)(words + 10);
        assert_int_equal(call(fixture, "call_service", words).value, 1);
    }
}

static void calling_services_for_ever_is_a_hang(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 1000);
    struct served served = { .fixture = fixture };
    struct machine_outcome outcome =
        call(fixture, "call_for_ever", service(fixture, "serve", serve, &served));

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_HANG);
    assert_int_equal(outcome.instructions, 1000);
    assert_int_equal(served.calls, 499);
}

static void a_made_up_service_is_a_jump_to_nowhere(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 1000);
    struct served served = { .fixture = fixture };
    uint64_t *words = shared_words(fixture);
    const uint64_t real = (uint64_t)service(fixture, "serve", serve, &served);
    const uint64_t wrong[] = { real + 1, real + 16, real + 4096, real - 16 - 4096 };

    (void)state;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        words[0] = wrong[i];
        struct machine_outcome outcome = call(fixture, "call_service", words);

        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_int_equal(outcome.fault.access, MACHINE_ACCESS_EXECUTE);
        assert_int_equal(outcome.fault.address, wrong[i]);
        assert_int_equal(outcome.fault.pc, at(fixture, "call_service_back"));
    }
    assert_int_equal(served.calls, 0);
}

static uint64_t count_interrupts(void *argument, uint64_t pc, uint64_t instructions)
{
    uint64_t *count = argument;

    (void)pc;
    assert_int_equal(instructions, *count);
    ++*count;
    return 1;
}

static void every_instruction_around_a_service_can_be_interrupted(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    struct served served = { .fixture = fixture };
    uint64_t *words = shared_words(fixture), count = 0;

    (void)state;
    words[0] = (uint64_t)service(fixture, "serve", serve, &served);
    machine_interrupt_next(fixture->machine, 0, count_interrupts, &count);
    assert_int_equal(call(fixture, "call_service", words).instructions, 19);
    assert_int_equal(count, 19);
    assert_int_equal(served.calls, 1);
}

static void too_many_services_are_refused(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    char why[MACHINE_WHY] = "";
    void *pointer;

    (void)state;
    for (int i = 0; i < MACHINE_SERVICES; i++)
        service(fixture, "one", serve, NULL);
    assert_int_equal(machine_service(fixture->machine, "one more", serve, NULL, &pointer, why),
                     -ENOSPC);
    assert_string_not_equal(why, "");
}

static void an_alarm_is_refused_with_a_reason(void **state)
{
    struct fixture *fixture = opened_with("traced", NULL, 0);
    char why[MACHINE_WHY] = "";

    (void)state;
    assert_int_equal(machine_alarm_open(fixture->machine, why), -ENOTSUP);
    assert_string_not_equal(why, "");
}

#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADED(instructions_and_stack_of_a_call_are_exact),
        LOADED(instructions_count_to_where_a_call_was_left),
        LOADED(a_hang_is_so_many_instructions),
        LOADED(every_access_to_a_memory_is_told_in_order),
        LOADED(a_repeated_instruction_counts_and_tells_each_time),
        LOADED(an_access_that_faults_is_not_told),
        LOADED(slack_of_a_memory_has_offsets_outside_of_it),
        LOADED(a_write_to_code_that_ran_is_told_and_takes_effect),
        LOADED(coverage_is_what_was_executed),
        LOADED(what_a_native_machine_does_not_tell_is_zero),
        LOADED(a_service_gets_what_the_module_passes),
        LOADED(a_bad_pointer_in_a_service_is_charged_to_the_call),
        LOADED(calling_services_for_ever_is_a_hang),
        LOADED(a_made_up_service_is_a_jump_to_nowhere),
        LOADED(every_instruction_around_a_service_can_be_interrupted),
        LOADED(too_many_services_are_refused),
        LOADED(an_alarm_is_refused_with_a_reason),
    };

    return cmocka_run_group_tests_name("instrumented", tests, NULL, NULL);
}
