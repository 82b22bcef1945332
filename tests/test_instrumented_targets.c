/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_instrumented_targets.c - modules of 32-bit processors: i386 (PE), Arm (ELF, flat image). */
#include <math.h>
#include <signal.h>

#include "machine/arguments.h"
#include "machine_fixture.h"

static const struct machine_config emulated = {
    .kind = MACHINE_INSTRUMENTED, .seed = 1, .hang_instructions = 100000, .interruptible = true
};

static struct fixture *opened_emulated(const char *module)
{
    fixture_open(&the_fixture, module, &emulated);
    return &the_fixture;
}

/* --- both processors --- */

struct fault {
    const char *function, *blamed;
    enum machine_outcome_kind kind;
    int signal;
    enum machine_access access;
    uint64_t address;
    const char *region;
};

static void expect_faults(struct fixture *fixture, const struct fault *faults, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        struct machine_outcome outcome = call(fixture, faults[i].function, shared_words(fixture));

        print_message("  %s\n", faults[i].function);
        assert_int_equal(outcome.kind, faults[i].kind);
        assert_int_equal(outcome.fault.signal, faults[i].signal);
        assert_int_equal(outcome.fault.access, faults[i].access);
        if (faults[i].address != UINT64_MAX)
            assert_int_equal(outcome.fault.address, faults[i].address);
        assert_int_equal(outcome.fault.has_pc, faults[i].blamed != NULL);
        if (faults[i].blamed != NULL)
            assert_int_equal(outcome.fault.pc, at(fixture, faults[i].blamed));
        assert_string_equal(outcome.fault.region, faults[i].region);
        assert_int_equal((uint32_t)call(fixture, "returns_value", (void *)5).value, ~5u);
    }
}

struct convention {
    const char *function;
    unsigned broken;
};

static void expect_conventions(struct fixture *fixture, const struct convention *conventions,
                               size_t count)
{
    for (size_t i = 0; i < count; i++) {
        struct machine_outcome outcome = call(fixture, conventions[i].function, NULL);

        print_message("  %s\n", conventions[i].function);
        assert_int_equal(outcome.kind, MACHINE_RETURNED);
        assert_int_equal(outcome.abi_broken, conventions[i].broken);
        assert_int_equal(call(fixture, "returns_value", NULL).abi_broken, 0);
    }
}

static void expect_basics(struct fixture *fixture)
{
    struct machine_outcome outcome = call(fixture, "returns_value", (void *)0x12345678);

    assert_int_equal(machine_pointer_size(fixture->machine), 4);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0);
    assert_int_equal(outcome.value, (int64_t)(0xffffffff00000000 | ~0x12345678u));
    outcome = call(fixture, "loop_1000", NULL);
    assert_int_equal(outcome.value & 0xffffffff, 7);
    assert_int_equal(outcome.instructions, 2003);
    assert_true((uint64_t)shared_words(fixture) < 1ull << 31);
    assert_true((uint64_t)place(fixture, "returns_value") < 1ull << 31);
}

/* Data, relocated and reloaded. */
static void expect_data(struct fixture *fixture)
{
    char why[MACHINE_WHY];
    uint32_t pointer;

    memcpy(&pointer, place(fixture, "pointer"), sizeof pointer);
    assert_ptr_equal(pointer, place(fixture, "counter"));
    assert_int_equal((uint32_t)call(fixture, "count_up", NULL).value, 5);
    assert_int_equal((uint32_t)call(fixture, "count_up", NULL).value, 6);
    assert_int_equal(machine_reload(fixture->machine, why), 0);
    assert_int_equal((uint32_t)call(fixture, "count_up", NULL).value, 5);
}

static void expect_poison(const char *module)
{
    struct machine_config config = emulated;

    config.poison = MACHINE_POISON_SEEDED;
    fixture_open(&the_fixture, module, &config);
    assert_int_not_equal((uint32_t)call(&the_fixture, "count_up", NULL).value, 5);
}

struct served {
    unsigned calls;
    int64_t first, second, last;
    double real;
};

static int64_t serve(void *context, struct arguments *arguments)
{
    struct served *served = context;

    served->calls++;
    served->first = (int32_t)arguments_u32(arguments);
    served->second = (int64_t)arguments_u64(arguments);
    served->real = arguments_f64(arguments);
    served->last = (int32_t)arguments_u32(arguments);
    return 0x123456789abcdef0;
}

static int64_t write_nowhere(void *context, struct arguments *arguments)
{
    volatile uintptr_t nowhere = 16;

    (void)context, (void)arguments;
    *(volatile char *)nowhere = 1;
    return 0;
}

static uint32_t service(struct fixture *fixture, const char *name, machine_function *function,
                        void *context)
{
    char why[MACHINE_WHY] = "";
    void *pointer = NULL;

    if (machine_service(fixture->machine, name, function, context, &pointer, why) != 0)
        fail_msg("%s", why);
    assert_true((uint64_t)pointer < 1ull << 31);
    return (uint32_t)(uint64_t)pointer;
}

static void expect_services(struct fixture *fixture)
{
    uint32_t *words = (uint32_t *)shared_words(fixture);
    struct served served = { 0 };
    struct machine_outcome outcome;

    words[0] = service(fixture, "serve", serve, &served);
    outcome = call(fixture, "call_service", words);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0);
    assert_int_equal(outcome.value, 0x123456789abcdef0);
    assert_int_equal(served.first, 2);
    assert_int_equal(served.second, -4);
    assert_true(served.real == 1.5);
    assert_int_equal(served.last, 5);
    words[0] = service(fixture, "write", write_nowhere, NULL);
    outcome = call(fixture, "call_service", words);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_int_equal(outcome.fault.address, 16);
    assert_string_equal(outcome.fault.service, "write");
    assert_int_equal(outcome.fault.pc, at(fixture, "call_service_back"));
    assert_int_equal(call(fixture, "loop_1000", NULL).instructions, 2003);
}

/* Interrupted before each instruction, by a call of the same function. */
struct inner {
    struct fixture *fixture;
    const char *function;
    uint64_t count, last;
};

static uint64_t call_again(void *argument, uint64_t pc, uint64_t instructions)
{
    struct inner *inner = argument;
    struct machine_outcome outcome = call(inner->fixture, inner->function, NULL);

    (void)pc;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0);
    inner->count++;
    inner->last = instructions;
    return 1;
}

static void expect_interrupts(struct fixture *fixture, const char *function, uint32_t value,
                              uint64_t instructions, uint64_t interrupts)
{
    struct inner inner = { fixture, function, 0, 0 };
    struct machine_outcome outcome;

    machine_interrupt_next(fixture->machine, 0, call_again, &inner);
    outcome = call(fixture, function, NULL);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0);
    assert_int_equal((uint32_t)outcome.value, value);
    assert_int_equal(outcome.instructions, instructions);
    assert_int_equal(inner.count, interrupts);
    assert_int_equal(inner.last, instructions - 1);
}

static void expect_division(struct fixture *fixture, double *numbers)
{
    numbers[0] = 1.0;
    numbers[1] = 3.0;
    assert_int_equal(call(fixture, "divides", numbers).abi_broken, 0);
    assert_true(numbers[2] == 1.0 / 3.0);
}

/* --- i386 --- */

static void i386_calls_as_cdecl(void **state)
{
    (void)state;
    expect_basics(opened_emulated("i386.dll"));
    assert_int_equal(call(&the_fixture, "loop_1000", NULL).stack_bytes, 4);
}

static void i386_faults_like_a_native_machine(void **state)
{
    static const struct fault faults[] = {
        { "null_read", "null_read_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_READ, 16, "" },
        { "divide_by_zero", "divide_by_zero_at", MACHINE_FAULT, SIGFPE, MACHINE_ACCESS_NONE, 0,
          "" },
        { "undefined_instruction", "undefined_instruction_at", MACHINE_FAULT, SIGILL,
          MACHINE_ACCESS_NONE, 0, "" },
        { "breakpoint", "breakpoint_at", MACHINE_FAULT, SIGTRAP, MACHINE_ACCESS_NONE, 0, "" },
        { "privileged", "privileged_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_NONE, 0, "" },
        { "make_system_call", "make_system_call_at", MACHINE_SYSCALL, SIGSYS, MACHINE_ACCESS_NONE,
          0, "" },
        { "recurse", "recurse_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_WRITE, UINT64_MAX,
          "stack" },
        { "call_null", "call_null_back", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_EXECUTE, 0, "" },
        { "wild_jump", NULL, MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_EXECUTE, 0x90000000, "" },
        { "write_code", "write_code_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_WRITE, UINT64_MAX,
          "module" },
        { "loop_for_ever", "loop_for_ever_at", MACHINE_HANG, SIGALRM, MACHINE_ACCESS_NONE, 0, "" },
    };

    (void)state;
    expect_faults(opened_emulated("i386.dll"), faults, COUNT(faults));
}

static void i386_conventions_are_checked(void **state)
{
    static const struct convention conventions[] = {
        { "break_ebx", MACHINE_ABI_RBX },
        { "break_ebp", MACHINE_ABI_RBP },
        { "break_esi", MACHINE_ABI_RSI },
        { "break_edi", MACHINE_ABI_RDI },
        { "break_stack", MACHINE_ABI_STACK },
        { "break_direction", MACHINE_ABI_DIRECTION },
        { "break_x87_control", MACHINE_ABI_X87_CONTROL },
        { "leave_x87_value", MACHINE_ABI_X87_STACK },
    };

    (void)state;
    expect_conventions(opened_emulated("i386.dll"), conventions, COUNT(conventions));
}

static void i386_computes_with_doubles(void **state)
{
    struct fixture *fixture = opened_emulated("i386.dll");

    (void)state;
    assert_int_equal((uint32_t)call(fixture, "rounds_to_doubles", NULL).value, 1);
    expect_division(fixture, (double *)shared_words(fixture));
}

static void i386_data_is_relocated_and_poisoned(void **state)
{
    (void)state;
    expect_data(opened_emulated("i386.dll"));
    fixture_close(&the_fixture);
    expect_poison("i386.dll");
}

static void i386_services_read_the_stack(void **state)
{
    (void)state;
    expect_services(opened_emulated("i386.dll"));
}

static void i386_is_interrupted_at_every_instruction(void **state)
{
    (void)state;
    expect_interrupts(opened_emulated("i386.dll"), "loop_1000", 7, 2003, 2003);
}

static void i386_thread_block_tells_the_stack(void **state)
{
    struct fixture *fixture = opened_emulated("i386.dll");
    const uint32_t *words = (uint32_t *)shared_words(fixture);

    (void)state;
    assert_int_equal(call(fixture, "read_thread_block", shared_words(fixture)).kind,
                     MACHINE_RETURNED);
    assert_int_equal(words[0] - words[1], 256 << 10);
    assert_in_range(words[3], words[1], words[0]);
    assert_int_not_equal(words[2], 0);
}

/* --- Arm --- */

static void arm_calls_with_registers(void **state)
{
    (void)state;
    expect_basics(opened_emulated("arm.so"));
    assert_int_equal(call(&the_fixture, "loop_1000", NULL).stack_bytes, 0);
}

static void arm_faults_are_attributed(void **state)
{
    static const struct fault faults[] = {
        { "null_read", "null_read_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_READ, 16, "" },
        { "thumb_null_read", "thumb_null_read_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_READ, 4,
          "" },
        { "unaligned_pair", "unaligned_pair_at", MACHINE_FAULT, SIGBUS, MACHINE_ACCESS_NONE, 0,
          "" },
        { "undefined_instruction", "undefined_instruction_at", MACHINE_FAULT, SIGILL,
          MACHINE_ACCESS_NONE, 0, "" },
        { "kept_condition", "kept_condition_at", MACHINE_FAULT, SIGBUS, MACHINE_ACCESS_NONE, 0,
          "" },
        { "divide_instruction", "divide_instruction_at", MACHINE_FAULT, SIGILL, MACHINE_ACCESS_NONE,
          0, "" },
        { "breakpoint", "breakpoint_at", MACHINE_FAULT, SIGTRAP, MACHINE_ACCESS_NONE, 0, "" },
        { "privileged", "privileged_at", MACHINE_FAULT, SIGILL, MACHINE_ACCESS_NONE, 0, "" },
        { "make_system_call", "make_system_call_at", MACHINE_SYSCALL, SIGSYS, MACHINE_ACCESS_NONE,
          0, "" },
        { "recurse", "recurse_at", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_WRITE, UINT64_MAX,
          "stack" },
        { "call_null", "call_null_back", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_EXECUTE, 0, "" },
        { "thumb_call_null", "thumb_call_null_back", MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_EXECUTE,
          0, "" },
        { "wild_jump", NULL, MACHINE_FAULT, SIGSEGV, MACHINE_ACCESS_EXECUTE, 0x90000000, "" },
        { "loop_for_ever", "loop_for_ever_at", MACHINE_HANG, SIGALRM, MACHINE_ACCESS_NONE, 0, "" },
    };
    struct fixture *fixture = opened_emulated("arm.so");

    (void)state;
    expect_faults(fixture, faults, COUNT(faults));
    const struct machine_fault fault = call(fixture, "make_system_call", NULL).fault;
    char name[MACHINE_CALL_NAME];
    machine_system_call_name(&fault, name);
    assert_int_equal(fault.syscall, 20);
    assert_true(fault.syscall_arm);
    assert_string_equal(name, "getpid");
    assert_int_equal(call(fixture, "unaligned_word", shared_words(fixture)).kind, MACHINE_RETURNED);
}

static void arm_does_nothing_where_a_condition_is_not_met(void **state)
{
    struct fixture *fixture = opened_emulated("arm.so");
    const struct machine_outcome outcome =
        call(fixture, "skipped_instructions", shared_words(fixture));

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal((uint32_t)outcome.value, 7);
}

static void arm_conventions_are_checked(void **state)
{
    static const struct convention conventions[] = {
        { "break_r4", MACHINE_ABI_RBX },
        { "break_r5", MACHINE_ABI_RBP },
        { "break_r6", MACHINE_ABI_R12 },
        { "break_r7", MACHINE_ABI_R13 },
        { "break_r8", MACHINE_ABI_R14 },
        { "break_r9", MACHINE_ABI_R14 },
        { "break_r10", MACHINE_ABI_R15 },
        { "break_r11", MACHINE_ABI_R15 },
        { "break_d8", MACHINE_ABI_XMM },
        { "break_d15", MACHINE_ABI_XMM },
        { "break_stack", MACHINE_ABI_STACK },
        { "break_rounding", MACHINE_ABI_MXCSR },
        { "sticky_flags", 0 },
    };

    (void)state;
    expect_conventions(opened_emulated("arm.so"), conventions, COUNT(conventions));
}

static void arm_computes_with_its_vector_unit(void **state)
{
    struct fixture *fixture = opened_emulated("arm.so");
    double *numbers = (double *)shared_words(fixture);

    (void)state;
    expect_division(fixture, numbers);
    assert_true(numbers[3] == sqrt(1.0 / 3.0));
}

static void arm_data_is_relocated_and_poisoned(void **state)
{
    (void)state;
    expect_data(opened_emulated("arm.so"));
    fixture_close(&the_fixture);
    expect_poison("arm.so");
}

static void arm_services_read_registers_and_stack(void **state)
{
    struct fixture *fixture = opened_emulated("arm.so");
    uint32_t *words = (uint32_t *)shared_words(fixture);
    struct served served = { 0 };
    struct machine_outcome outcome;

    (void)state;
    expect_services(fixture);
    words[0] = service(fixture, "thumb", serve, &served);
    outcome = call(fixture, "thumb_call_service", words);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, 0x123456789abcdef0);
    assert_int_equal(served.first, 9);
    words[0] = service(fixture, "write", write_nowhere, NULL);
    outcome = call(fixture, "thumb_call_service", words);
    assert_string_equal(outcome.fault.service, "write");
    assert_int_equal(outcome.fault.pc, at(fixture, "thumb_call_service_back"));
}

static void arm_conditional_instructions_count_as_executed(void **state)
{
    struct fixture *fixture = opened_emulated("arm.so");
    uint32_t *words = (uint32_t *)shared_words(fixture);

    (void)state;
    assert_int_equal(call(fixture, "conditions", words).instructions, 6);
    words[0] = 1;
    assert_int_equal(call(fixture, "conditions", words).instructions, 6);
    assert_int_equal((uint32_t)call(fixture, "conditions", words).value, 12);
}

/* Not inside of the block that an IT begins: two instructions of five in each turn. */
static void arm_is_interrupted_at_every_instruction(void **state)
{
    struct fixture *fixture = opened_emulated("arm.so");

    (void)state;
    expect_interrupts(fixture, "loop_1000", 7, 2003, 2003);
    expect_interrupts(fixture, "loop_thumb", 199, 504, 304);
}

/* --- a flat image --- */

enum { RETURNS_VALUE, LOOP_1000, COUNT_UP, UNFILLED, LOOP_THUMB, CALL_SERVICE, NULL_READ };

static struct machine_outcome call_flat(struct fixture *fixture, unsigned number, void *argument)
{
    struct machine_outcome outcome;
    uint32_t function;

    machine_call(fixture->machine, fixture->image->entry_point, NULL, &outcome);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_in_range((uint32_t)outcome.value, IMAGE_FLAT_BASE,
                    IMAGE_FLAT_BASE + fixture->image->size);
    memcpy(&function, (const uint32_t *)(uint64_t)(uint32_t)outcome.value + number, 4);
    machine_call(fixture->machine, function, argument, &outcome);
    return outcome;
}

static void flat_image_runs_where_it_was_linked(void **state)
{
    struct fixture *fixture = opened_emulated("flat.bin");
    uint32_t *words = (uint32_t *)shared_words(fixture);
    struct served served = { 0 };

    (void)state;
    assert_ptr_equal(machine_address(fixture->machine, IMAGE_FLAT_BASE), IMAGE_FLAT_BASE);
    assert_int_equal((uint32_t)call_flat(fixture, RETURNS_VALUE, (void *)5).value, ~5u);
    assert_int_equal(call_flat(fixture, LOOP_1000, NULL).instructions, 2003);
    assert_int_equal(call_flat(fixture, LOOP_THUMB, NULL).instructions, 504);
    words[0] = service(fixture, "serve", serve, &served);
    assert_int_equal(call_flat(fixture, CALL_SERVICE, words).value, 0x123456789abcdef0);
    assert_int_equal(served.last, 5);
    assert_int_equal(call_flat(fixture, NULL_READ, NULL).kind, MACHINE_FAULT);
}

static void flat_image_writes_its_own_memory_and_is_reloaded(void **state)
{
    struct fixture *fixture = opened_emulated("flat.bin");
    char why[MACHINE_WHY];

    (void)state;
    assert_int_equal((uint32_t)call_flat(fixture, COUNT_UP, NULL).value, 5);
    assert_int_equal((uint32_t)call_flat(fixture, COUNT_UP, NULL).value, 6);
    assert_int_equal(machine_reload(fixture->machine, why), 0);
    assert_int_equal((uint32_t)call_flat(fixture, COUNT_UP, NULL).value, 5);
}

static void what_no_loader_clears_behind_a_flat_image_is_poisoned(void **state)
{
    struct machine_config config = emulated;
    uint32_t first;

    (void)state;
    config.poison = MACHINE_POISON_SEEDED;
    fixture_open(&the_fixture, "flat.bin", &config);
    first = (uint32_t)call_flat(&the_fixture, UNFILLED, NULL).value;
    assert_int_not_equal(first, 0);
    /* What is in the file cannot be told from code, and stays. */
    assert_int_equal((uint32_t)call_flat(&the_fixture, COUNT_UP, NULL).value, 5);
    fixture_close(&the_fixture);
    config.seed = 2;
    fixture_open(&the_fixture, "flat.bin", &config);
    assert_int_not_equal((uint32_t)call_flat(&the_fixture, UNFILLED, NULL).value, first);
}

static void no_32_bit_module_runs_natively(void **state)
{
    static const char *const modules[] = { "i386.dll", "arm.so", "flat.bin" };

    (void)state;
    for (size_t i = 0; i < COUNT(modules); i++) {
        struct image *image = fixture_image(modules[i]);
        char why[MACHINE_WHY] = "";

        assert_int_not_equal(machine_fits(image, MACHINE_NATIVE, why), 0);
        assert_string_not_equal(why, "");
        assert_int_equal(machine_fits(image, MACHINE_INSTRUMENTED, why), 0);
        image_close(image);
    }
}

#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADED(i386_calls_as_cdecl),
        LOADED(i386_faults_like_a_native_machine),
        LOADED(i386_conventions_are_checked),
        LOADED(i386_computes_with_doubles),
        LOADED(i386_data_is_relocated_and_poisoned),
        LOADED(i386_services_read_the_stack),
        LOADED(i386_is_interrupted_at_every_instruction),
        LOADED(i386_thread_block_tells_the_stack),
        LOADED(arm_calls_with_registers),
        LOADED(arm_faults_are_attributed),
        LOADED(arm_does_nothing_where_a_condition_is_not_met),
        LOADED(arm_conventions_are_checked),
        LOADED(arm_computes_with_its_vector_unit),
        LOADED(arm_data_is_relocated_and_poisoned),
        LOADED(arm_services_read_registers_and_stack),
        LOADED(arm_conditional_instructions_count_as_executed),
        LOADED(arm_is_interrupted_at_every_instruction),
        LOADED(flat_image_runs_where_it_was_linked),
        LOADED(flat_image_writes_its_own_memory_and_is_reloaded),
        LOADED(what_no_loader_clears_behind_a_flat_image_is_poisoned),
        cmocka_unit_test(no_32_bit_module_runs_natively),
    };

    return cmocka_run_group_tests_name("instrumented, 32 bits", tests, NULL, NULL);
}
