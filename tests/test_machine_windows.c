/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_machine_windows.c - PE modules: loaded, called as Windows calls, and their ways back. */
#define _GNU_SOURCE 1
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/auxv.h>
#include <sys/syscall.h>

#include "machine/worker.h"
#include "machine_fixture.h"

#define HAS_FSGSBASE (getauxval(AT_HWCAP2) & 2)

static void argument_and_value_travel_as_on_windows(void **state)
{
    struct fixture *fixture = opened("windows.dll");
    struct machine_outcome outcome = call(fixture, "returns_value", (void *)0x123456789abcdef0);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, ~0x123456789abcdef0);
    assert_int_equal(outcome.abi_broken, 0);
}

static void registers_on_entry_are_known(void **state)
{
    struct fixture *fixture = opened("windows.dll");
    uint64_t *words = shared_words(fixture), again[64];
    struct machine_outcome outcome = call(fixture, "store_registers", words);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, 0); /* the home space is the function's */
    assert_ptr_equal(words[0], place(fixture, "store_registers"));
    for (int i = 1; i < 6; i++)
        assert_int_equal(words[i], 0);
    for (int i = 6; i < 14; i++)
        assert_int_equal(words[i] >> 56, 0x5e);
    assert_int_equal((words[14] + 8) % 16, 0);
    assert_int_equal(words[15] & 0xffffffc0, 0x1f80);
    assert_int_equal(words[16], 0x27f);
    for (int i = 18; i < 22; i++)
        assert_int_equal(words[i], 0); /* xmm0, xmm5 */
    for (int i = 22; i < 42; i++)
        assert_int_not_equal(words[i], 0);
    memcpy(again, words, sizeof again);
    fixture_close(fixture);
    fixture = opened("windows.dll");
    words = shared_words(fixture);
    call(fixture, "store_registers", words);
    words[15] = again[15] = 0; /* sticky flags are the host's */
    assert_memory_equal(words, again, sizeof again);
}

static const struct {
    const char *function;
    unsigned broken;
} conventions[] = {
    { "break_rdi", MACHINE_ABI_RDI },
    { "break_rsi", MACHINE_ABI_RSI },
    { "break_rbx", MACHINE_ABI_RBX },
    { "break_rbp", MACHINE_ABI_RBP },
    { "break_r12", MACHINE_ABI_R12 },
    { "break_r13", MACHINE_ABI_R13 },
    { "break_r14", MACHINE_ABI_R14 },
    { "break_r15", MACHINE_ABI_R15 },
#define VECTOR(number)                                                                             \
    { "break_xmm" #number, MACHINE_ABI_XMM }, { "break_high_xmm" #number, MACHINE_ABI_XMM },
    VECTOR(6) VECTOR(7) VECTOR(8) VECTOR(9) VECTOR(10) VECTOR(11) VECTOR(12) VECTOR(13) VECTOR(14)
        VECTOR(15){ "swap_vectors", MACHINE_ABI_XMM },
    { "break_stack", MACHINE_ABI_STACK },
    { "break_direction", MACHINE_ABI_DIRECTION },
    { "break_mxcsr", MACHINE_ABI_MXCSR },
    { "linux_x87_control", MACHINE_ABI_X87_CONTROL },
    { "unmask_x87", MACHINE_ABI_X87_CONTROL },
    { "leave_x87_value", MACHINE_ABI_X87_STACK },
    { "break_gs", MACHINE_ABI_GS },
    { "null_gs", MACHINE_ABI_GS },
    { "break_much", MACHINE_ABI_RDI | MACHINE_ABI_RSI | MACHINE_ABI_RBX | MACHINE_ABI_XMM |
                        MACHINE_ABI_DIRECTION },
};

static void host_is_unharmed(void)
{
    uint64_t flags;
    uint32_t mxcsr;
    uint16_t x87, status;

    __asm__ volatile("stmxcsr %0" : "=m"(mxcsr));
    __asm__ volatile("fnstcw %0" : "=m"(x87));
    __asm__ volatile("fnstsw %0" : "=m"(status));
    __asm__ volatile("pushfq\n\tpop %0" : "=r"(flags));
    assert_int_equal(mxcsr & 0xffc0, 0x1f80);
    assert_int_equal(x87, 0x37f);
    assert_int_equal(status & 0x3800, 0);
    assert_int_equal(flags & 0x44500, 0);
}

/* The block is at gs, and speaks of this stack. */
static void thread_block_is_right(struct fixture *fixture)
{
    uint64_t *words = shared_words(fixture);
    struct machine_outcome outcome = call(fixture, "read_thread_block", words);

    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal((uint64_t)outcome.value, words[2]);
    assert_int_equal(words[1] % 4096, 0);
    assert_int_equal(words[0] - words[1], 256 << 10);
    assert_in_range(words[3], words[1], words[0]);
}

static void broken_convention_is_reported_and_repaired(void **state)
{
    struct fixture *fixture = opened("windows.dll");

    (void)state;
    host_is_unharmed();
    for (size_t i = 0; i < COUNT(conventions); i++) {
        print_message("  %s\n", conventions[i].function);
        if (conventions[i].broken == MACHINE_ABI_GS &&
            (!HAS_FSGSBASE || fixture_kind != MACHINE_NATIVE)) {
            print_message("  not judged: the processor has no wrgsbase\n");
            continue;
        }
        struct machine_outcome outcome = call(fixture, conventions[i].function, NULL);

        assert_int_equal(outcome.kind, MACHINE_RETURNED);
        assert_int_equal(outcome.value, 7);
        assert_int_equal(outcome.abi_broken, conventions[i].broken);
        host_is_unharmed();
        thread_block_is_right(fixture);
        outcome = call(fixture, "keeps_all", NULL);
        assert_int_equal(outcome.abi_broken, 0);
        assert_int_equal(outcome.value, 3);
        host_is_unharmed();
    }
}

/* What is at gs after a fault is put right as after a return. */
static void faults_are_attributed(void **state)
{
    static const struct {
        const char *function, *blamed, *region;
        enum machine_access access;
    } faults[] = {
        { "write_null", "write_null_at", "", MACHINE_ACCESS_WRITE },
        { "write_code", "write_code_at", "module", MACHINE_ACCESS_WRITE },
        { "write_constant", "write_constant_at", "module", MACHINE_ACCESS_WRITE },
        { "run_data", "run_data_after", "module", MACHINE_ACCESS_EXECUTE },
        { "write_thread_block", "write_thread_block_at", "thread block", MACHINE_ACCESS_WRITE },
        { "libraries", "libraries_at", "", MACHINE_ACCESS_READ },
    };
    struct fixture *fixture = opened("windows.dll");

    (void)state;
    for (size_t i = 0; i < COUNT(faults); i++) {
        print_message("  %s\n", faults[i].function);
        struct machine_outcome outcome = call(fixture, faults[i].function, NULL);

        assert_int_equal(outcome.kind, MACHINE_FAULT);
        assert_int_equal(outcome.fault.signal, SIGSEGV);
        assert_int_equal(outcome.fault.access, faults[i].access);
        assert_true(outcome.fault.has_pc);
        assert_int_equal(outcome.fault.pc, at(fixture, faults[i].blamed));
        assert_string_equal(outcome.fault.region, faults[i].region);
        host_is_unharmed();
        thread_block_is_right(fixture);
    }
    struct machine_outcome outcome = call(fixture, "loop_for_ever", NULL);
    assert_int_equal(outcome.kind, MACHINE_HANG);
    assert_int_equal(outcome.fault.pc, at(fixture, "loop_for_ever_at"));
}

static void frames_of_many_pages_find_the_stack_and_its_end(void **state)
{
    struct fixture *fixture = opened("windows_frames.dll");
    struct machine_outcome outcome = call(fixture, "frame_of_100k", NULL);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.value, 99);
    assert_int_equal(outcome.abi_broken, 0);
    assert_in_range(machine_stack_used(fixture->machine), 100000, 110000);
    outcome = call(fixture, "frame_of_1m", NULL);
    assert_int_equal(outcome.kind, MACHINE_FAULT);
    assert_string_equal(outcome.fault.region, "stack");
    assert_true(outcome.fault.region_offset < 0);
    assert_true(outcome.fault.region_offset >= -4096);
    assert_true(outcome.fault.in_module);
}

static void words_are_relocated_and_data_is_the_modules_own(void **state)
{
    struct fixture *fixture = opened("windows.dll");
    const uint64_t *table = place(fixture, "table");
    char why[MACHINE_WHY];

    (void)state;
    assert_ptr_equal(table[0], place(fixture, "returns_value"));
    assert_ptr_equal(table[1], place(fixture, "plain"));
    assert_ptr_equal(table[2], place(fixture, "constant"));
    assert_int_equal(call(fixture, "read_plain", NULL).value, 0x11223344);
    assert_int_equal(call(fixture, "read_zeroed", NULL).value, 0);
    assert_int_equal(call(fixture, "write_plain", NULL).value, 5);
    assert_int_equal(call(fixture, "read_plain", NULL).value, 5);
    assert_int_equal(machine_reload(fixture->machine, why), 0);
    assert_int_equal(call(fixture, "read_plain", NULL).value, 0x11223344);
}

static void data_is_poisoned_but_for_what_the_loader_patches(void **state)
{
    struct machine_config config = plain_config;
    struct machine_outcome first;

    (void)state;
    config.kind = fixture_kind;
    config.poison = true;
    fixture_open(&the_fixture, "windows.dll", &config);
    first = call(&the_fixture, "read_plain", NULL); /* through a pointer in the data */
    assert_int_equal(first.kind, MACHINE_RETURNED);
    assert_int_not_equal(first.value, 0x11223344);
    assert_int_not_equal(call(&the_fixture, "read_zeroed", NULL).value, 0);
    fixture_close(&the_fixture);
    config.seed = 2;
    fixture_open(&the_fixture, "windows.dll", &config);
    assert_int_not_equal(call(&the_fixture, "read_plain", NULL).value, first.value);
}

static void module_without_relocations_runs_at_its_base(void **state)
{
    struct fixture *fixture = opened("windows_fixed.dll");

    (void)state;
    assert_true(fixture->image->fixed);
    assert_int_equal((uint64_t)machine_address(fixture->machine, 0), 0x1a0000000);
    assert_int_equal(call(fixture, "read_plain", NULL).value, 0x11223344);
}

/* A service as a PE module calls it. */
struct call_back {
    int64_t (*function)(void *, int, int, int, ...) __attribute__((ms_abi));
    int64_t seen[7];
    double real;
};

static __attribute__((ms_abi)) int64_t service(void *argument, int second, int third, int fourth,
                                               ...)
{
    struct call_back *back = argument;
    __builtin_ms_va_list more;

    __builtin_ms_va_start(more, fourth);
    back->seen[1] = second;
    back->seen[2] = third;
    back->seen[3] = fourth;
    back->seen[4] = __builtin_va_arg(more, int);
    back->real = __builtin_va_arg(more, double);
    back->seen[6] = __builtin_va_arg(more, int);
    __builtin_ms_va_end(more);
    __asm__ volatile("" ::: "xmm6", "xmm7", "rsi", "rdi");
    return 12345678901;
}

static void services_are_called_as_on_windows(void **state)
{
    struct fixture *fixture = opened("windows.dll");
    struct call_back back = { .function = service };
    struct machine_outcome outcome = call(fixture, "call_back", &back);

    (void)state;
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    assert_int_equal(outcome.abi_broken, MACHINE_ABI_XMM); /* it spoils xmm6 itself */
    assert_int_equal(outcome.value, 12345678901);
    assert_int_equal(back.seen[1], 2);
    assert_int_equal(back.seen[2], 3);
    assert_int_equal(back.seen[3], 4);
    assert_int_equal(back.seen[4], 5);
    assert_true(back.real == 6.0);
    assert_int_equal(back.seen[6], 7);
}

/* What an interrupt does in the middle of a call: the same function on the next level. */
struct inner {
    struct fixture *fixture;
    uint64_t words[64];
    struct machine_outcome outcome;
    unsigned count;
};

static uint64_t hook(void *argument, uint64_t pc, uint64_t instructions)
{
    struct inner *inner = argument;

    (void)pc;
    (void)instructions;
    inner->count++;
    inner->outcome = call(inner->fixture, "read_thread_block", shared_words(inner->fixture) + 100);
    memcpy(inner->words, shared_words(inner->fixture) + 100, sizeof inner->words);
    return MACHINE_NEVER;
}

static void calls_inside_one_another_have_each_their_stack(void **state)
{
    const struct machine_config config = {
        .kind = fixture_kind, .seed = 1, .hang_ns = 5 * TEST_HANG_NS, .interruptible = true
    };

    (void)state;
    fixture_open(&the_fixture, "windows.dll", &config);
    for (uint64_t after = 0; after < 9; after++) {
        struct inner inner = { .fixture = &the_fixture };
        uint64_t *outer = shared_words(&the_fixture);

        machine_interrupt_next(the_fixture.machine, after, hook, &inner);
        struct machine_outcome outcome = call(&the_fixture, "read_thread_block", outer);
        assert_int_equal(outcome.kind, MACHINE_RETURNED);
        assert_int_equal(outcome.abi_broken, 0);
        assert_int_equal(inner.count, 1);
        assert_int_equal(inner.outcome.abi_broken, 0);
        assert_in_range(outer[3], outer[1], outer[0]);
        assert_in_range(inner.words[3], inner.words[1], inner.words[0]);
        assert_int_not_equal(inner.words[0], outer[0]);
        assert_int_equal(inner.words[2], outer[2]);
    }
}

static void instructions_are_counted_exactly(void **state)
{
    const struct machine_config config = {
        .kind = fixture_kind, .seed = 1, .hang_ns = 5 * TEST_HANG_NS, .interruptible = true
    };
    struct inner inner = { .fixture = &the_fixture };

    (void)state;
    fixture_open(&the_fixture, "windows.dll", &config);
    machine_interrupt_next(the_fixture.machine, UINT64_MAX - 2, hook, &inner);
    assert_int_equal(call(&the_fixture, "loop_1000", NULL).value, 7);
    assert_int_equal(inner.count, 0);
    assert_int_equal(machine_instructions(the_fixture.machine), 2003);
}

/* In a worker, which can be sealed. */
struct sealed {
    struct machine_outcome outcomes[3];
    uint64_t words[4];
};

static int run_sealed(void *argument, void *shared, int pipe_fd)
{
    struct sealed *sealed = shared;
    const struct image *image = argument;
    static const char *const functions[] = { "make_system_call", "null_gs", "read_thread_block" };
    struct machine *machine;
    char why[MACHINE_WHY];

    if (machine_load(&machine, image, &plain_config, why) != 0 ||
        machine_seal(machine, pipe_fd, why) != 0)
        return 1;
    for (size_t i = 0; i < COUNT(functions); i++)
        machine_call(machine, image_export(image, functions[i])->vaddr, sealed->words,
                     &sealed->outcomes[i]);
    return 0;
}

static void sealed_module_makes_no_system_call(void **state)
{
    struct image *image = fixture_image("windows.dll");
    struct sealed *sealed = worker_block(sizeof *sealed);
    const struct worker_limits limits = { .wall_ns = 20000000000 };
    struct worker_result result;

    (void)state;
    assert_non_null(sealed);
    assert_int_equal(worker_run(run_sealed, image, sealed, &limits, NULL, NULL, false, &result), 0);
    assert_int_equal(result.end, WORKER_DONE);
    assert_int_equal(result.value, 0);
    assert_int_equal(sealed->outcomes[0].kind, MACHINE_SYSCALL);
    assert_int_equal(sealed->outcomes[0].fault.syscall, SYS_getpid);
    assert_int_equal(sealed->outcomes[0].fault.pc,
                     image_export(image, "make_system_call_at")->vaddr);
    assert_int_equal(sealed->outcomes[1].kind, MACHINE_RETURNED);
    assert_int_equal(sealed->outcomes[2].kind, MACHINE_RETURNED);
    assert_int_equal((uint64_t)sealed->outcomes[2].value, sealed->words[2]);
    worker_block_free(sealed, sizeof *sealed);
    image_close(image);
}

#define LOADED(test) cmocka_unit_test_teardown(test, close_fixture)

int main(void)
{
    const struct CMUnitTest both[] = {
        LOADED(argument_and_value_travel_as_on_windows),
        LOADED(registers_on_entry_are_known),
        LOADED(broken_convention_is_reported_and_repaired),
        LOADED(faults_are_attributed),
        LOADED(frames_of_many_pages_find_the_stack_and_its_end),
        LOADED(words_are_relocated_and_data_is_the_modules_own),
        LOADED(data_is_poisoned_but_for_what_the_loader_patches),
        LOADED(module_without_relocations_runs_at_its_base),
        LOADED(calls_inside_one_another_have_each_their_stack),
        LOADED(instructions_are_counted_exactly),
    };
    const struct CMUnitTest native[] = {
        LOADED(services_are_called_as_on_windows),
        cmocka_unit_test(sealed_module_makes_no_system_call),
    };
    int failed = cmocka_run_group_tests_name("Windows, native", both, NULL, NULL) +
                 cmocka_run_group_tests_name("Windows, services and seal", native, NULL, NULL);

    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("Windows, instrumented", both, NULL, NULL);
}
