/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_rules_cycle.c - what the findings of the cycle rules say, from evidence made up here. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "case_rig.h"

enum { PC = 0x1a4, SERVO_MEMORY = 4, POSITION = 472, WRITE_POSITION = 464, MODE = 32 };

static const struct image image = { .format = IMAGE_FORMAT_ELF64, .target = IMAGE_TARGET_X86_64 };
static struct case_run *runs;
static struct case_file file;
static struct findings findings;

/* Every run is complete, counted, and nothing is wrong with it. */
static int begin(void **state)
{
    (void)state;
    runs = complete_runs();
    if (runs == NULL)
        return -1;
    memset(&findings, 0, sizeof findings);
    file = (struct case_file){ .image = &image,
                               .profile = profile_find("pc4"),
                               .name = "gantry.tgm",
                               .runs = runs,
                               .cannot_run = "" };
    runs[EXPERIMENT_TRACED_250].plan.experiment.host.cycle_us = 250;
    for (int id = 0; id < EXPERIMENT_COUNT; id++) {
        runs[id].result.evidence.time_ns = UINT64_C(1000000000);
        runs[id].result.evidence.audit.traced = true;
    }
    return 0;
}

static int end(void **state)
{
    (void)state;
    free(runs);
    return 0;
}

static struct audit_record *record_of(enum experiment_id id)
{
    return &runs[id].result.evidence.audit;
}

static struct audit_access *access_in(enum experiment_id id, uint32_t offset, unsigned classes)
{
    struct audit_record *record = record_of(id);
    struct audit_access *row = &record->accesses[record->access_count++];
    *row = (struct audit_access){ .pc = PC,
                                  .count = 3,
                                  .first_cycle = 20,
                                  .offset = offset,
                                  .entry = ENTRY_04,
                                  .memory = SERVO_MEMORY,
                                  .size = 8,
                                  .classes = (uint8_t)classes,
                                  .write = true };
    return row;
}

static const struct finding *only_one(const char *what)
{
    assert_int_equal(findings.count, 1);
    assert_string_equal(findings.list[0].what, what);
    assert_string_equal(findings.reason, "");
    return &findings.list[0];
}

static void starts_with(const char *text, const char *begin_of_it)
{
    if (strncmp(text, begin_of_it, strlen(begin_of_it)) != 0)
        fail_msg("'%s' does not begin with '%s'", text, begin_of_it);
}

static void a_write_names_register_value_cycle_and_place(void **state)
{
    const double five = 5.0;
    struct audit_access *row =
        access_in(EXPERIMENT_TRACED_250, 2048 + POSITION, AUDIT_READ_ONLY | AUDIT_INPUT);
    (void)state;
    memcpy(&row->first_value, &five, sizeof five);
    access_in(EXPERIMENT_TRACED_250, WRITE_POSITION, AUDIT_OUTPUT);             /* may be written */
    access_in(EXPERIMENT_TRACED_500, POSITION, AUDIT_READ_ONLY)->write = false; /* is read */
    check_write_read_only(&file, &findings);
    const struct finding *finding = only_one("Program_04 wrote SERVO[1].Position (read-only)");
    assert_string_equal(finding->when, "in cycle 20 at Cycle_Time 250 us");
    assert_string_equal(finding->function, "Program_04");
    assert_int_equal(finding->count, 3);
    starts_with(finding->place, "gantry.tgm+0x1a4");
    assert_non_null(strstr(finding->place, "F64 5"));
}

static void no_number_names_the_odd_one(void **state)
{
    struct audit_access *row = access_in(EXPERIMENT_TRACED_500, WRITE_POSITION, AUDIT_OUTPUT);
    (void)state;
    access_in(EXPERIMENT_TRACED_500, WRITE_POSITION, AUDIT_OUTPUT);
    row->odd_count = 2;
    row->odd_cycle = 31;
    row->odd_offset = 2 * 2048 + WRITE_POSITION;
    check_finite_outputs(&file, &findings);
    const struct finding *finding =
        only_one("Program_04 wrote no number to SERVO[2].WritePosition");
    assert_int_equal(finding->cycle, 31);
    assert_int_equal(finding->count, 2);
    starts_with(finding->place, "gantry.tgm+0x1a4");
}

static void a_sum_that_is_no_number_is_told_when_no_store_was(void **state)
{
    (void)state;
    record_of(EXPERIMENT_CYCLE_500)->motion[AUDIT_NO_NUMBER] =
        (struct audit_motion){ .count = 4, .cycle = 9, .axis = 1 };
    check_finite_outputs(&file, &findings);
    const struct finding *finding = only_one("the set-point of SERVO[1] is no number");
    assert_int_equal(finding->cycle, 9);
    assert_int_equal(finding->count, 4);
}

static void order_names_both_registers(void **state)
{
    (void)state;
    record_of(EXPERIMENT_TRACED_500)->functions[ENTRY_03].order =
        (struct audit_order){ .count = 7,
                              .cycle = 2,
                              .output_pc = PC,
                              .input_pc = PC + 16,
                              .output_offset = WRITE_POSITION,
                              .input_offset = POSITION,
                              .output_memory = SERVO_MEMORY,
                              .input_memory = SERVO_MEMORY };
    check_inputs_first(&file, &findings);
    const struct finding *finding =
        only_one("Program_03 wrote SERVO[0].WritePosition and read SERVO[0].Position after it");
    assert_int_equal(finding->count, 7);
    assert_int_equal(finding->cycle, 2);
    starts_with(finding->place, "gantry.tgm+0x1b4");
}

static void budgets_are_told_with_their_figures(void **state)
{
    (void)state;
    record_of(EXPERIMENT_TRACED_250)->functions[ENTRY_04] =
        (struct audit_function){ .calls = 5, .worst_instructions = 25000, .worst_cycle = 3 };
    check_budget_04(&file, &findings);
    assert_int_equal(findings.count, 0);
    record_of(EXPERIMENT_TRACED_250)->functions[ENTRY_04].worst_instructions = 25100;
    check_budget_05(&file, &findings);
    check_budget_background(&file, &findings);
    assert_int_equal(findings.count, 0);
    check_budget_04(&file, &findings);
    const struct finding *finding = only_one("Program_04 takes longer than it may");
    assert_int_equal(finding->cycle, 3);
    assert_non_null(
        strstr(finding->place, "25.1 us of 25.0 us (25100 instructions, 1000 in a us)"));
}

static void each_function_of_the_background_has_its_budget(void **state)
{
    (void)state;
    record_of(EXPERIMENT_TRACED_500)->functions[ENTRY_02].worst_instructions = 1000001;
    check_budget_background(&file, &findings);
    only_one("Program_02 takes longer than it may");
}

static void a_deep_stack_is_told_in_bytes(void **state)
{
    (void)state;
    record_of(EXPERIMENT_TRACED_500)->functions[ENTRY_INI].stack_bytes = 65536;
    check_stack_limit(&file, &findings);
    assert_int_equal(findings.count, 0);
    record_of(EXPERIMENT_TRACED_500)->functions[ENTRY_INI].stack_bytes = 65544;
    check_stack_limit(&file, &findings);
    const struct finding *finding = only_one("Program_Ini needs more than 65536 bytes of stack");
    assert_non_null(strstr(finding->place, "65544 bytes"));
}

static void what_was_not_counted_is_not_judged(void **state)
{
    (void)state;
    record_of(EXPERIMENT_TRACED_500)->traced = false;
    check_budget_04(&file, &findings);
    assert_int_equal(findings.count, 0);
    assert_string_equal(findings.reason, "experiment made up: no instruction was seen");
}

static void a_broken_convention_names_its_parts(void **state)
{
    (void)state;
    struct audit_function *function = &record_of(EXPERIMENT_CYCLE_500)->functions[ENTRY_05];
    function->abi_broken = MACHINE_ABI_R12 | MACHINE_ABI_DIRECTION;
    function->abi_cycle = 12;
    check_calling_convention(&file, &findings);
    const struct finding *finding =
        only_one("Program_05 returned and had not put back: r12, the direction flag");
    assert_int_equal(finding->cycle, 12);
}

static void sleep_counts_in_the_two_upper_functions_only(void **state)
{
    struct audit_function *functions = record_of(EXPERIMENT_CYCLE_500)->functions;
    (void)state;
    functions[ENTRY_01].sleeps = 5;
    check_no_sleep(&file, &findings);
    assert_int_equal(findings.count, 0);
    functions[ENTRY_05].sleeps = 6;
    functions[ENTRY_05].sleep_cycle = 4;
    functions[ENTRY_05].sleep_pc = PC;
    check_no_sleep(&file, &findings);
    const struct finding *finding = only_one("Program_05 called pSleepFt");
    assert_int_equal(finding->count, 6);
    assert_int_equal(finding->cycle, 4);
    starts_with(finding->place, "gantry.tgm+0x1a3"); /* the call, not what comes after it */
}

static void messages_may_be_thirty_in_the_first_second(void **state)
{
    struct audit_function *functions = record_of(EXPERIMENT_CYCLE_500)->functions;
    (void)state;
    functions[ENTRY_INI].messages = 1000; /* is called once */
    functions[ENTRY_01].messages = 10;
    functions[ENTRY_03].messages = 20;
    check_bounded_console(&file, &findings);
    assert_int_equal(findings.count, 0);
    functions[ENTRY_03].messages = 21;
    check_bounded_console(&file, &findings);
    const struct finding *finding = only_one("Program_03 prints without end");
    assert_string_equal(finding->when, "(31 messages in 1.000 s, 30 at most)");
}

static void set_points_are_told_with_what_the_axis_can(void **state)
{
    (void)state;
    record_of(EXPERIMENT_CYCLE_500)->motion[AUDIT_TOO_FAST] =
        (struct audit_motion){ .count = 2, .cycle = 8, .axis = 3, .value = -70000, .limit = 52429 };
    check_no_jump(&file, &findings);
    check_waits_for_bus(&file, &findings);
    assert_int_equal(findings.count, 0);
    check_set_point_steps(&file, &findings);
    const struct finding *finding =
        only_one("the set-point of SERVO[3] goes further in one cycle than the axis can");
    assert_string_equal(finding->place, "70000 inc; at most 52429");
    assert_int_equal(finding->count, 2);
    assert_int_equal(finding->cycle, 8);
    assert_null(finding->function);
}

static void who_does_not_wait_is_found_by_what_was_traced(void **state)
{
    struct audit_access *late = access_in(EXPERIMENT_TRACED_250, MODE, AUDIT_OUTPUT);
    struct audit_access *off = access_in(EXPERIMENT_TRACED_250, MODE, AUDIT_OUTPUT);
    struct audit_access *early = access_in(EXPERIMENT_TRACED_250, MODE, AUDIT_OUTPUT);
    (void)state;
    late->first_value = 1;
    off->before_op = true;
    early->first_value = 1;
    early->before_op = true;
    early->pc = PC + 32;
    early->entry = ENTRY_INI;
    record_of(EXPERIMENT_CYCLE_500)->motion[AUDIT_EARLY] =
        (struct audit_motion){ .count = 6, .axis = 0, .value = 1 };
    check_waits_for_bus(&file, &findings);
    const struct finding *finding =
        only_one("SERVO[0].Mode is 1 before its drive has ever been in OP");
    starts_with(finding->place, "gantry.tgm+0x1c4");
    assert_string_equal(finding->function, "Program_Ini");
}

static void code_that_can_be_written_is_seen_when_it_is(void **state)
{
    struct audit_access *row = access_in(EXPERIMENT_TRACED_1000, 0x1000, 0);
    (void)state;
    row->memory = AUDIT_CODE;
    check_no_code_write(&file, &findings);
    const struct finding *finding = only_one("Program_04 wrote to the module's own code");
    assert_int_equal(finding->cycle, 20);
    starts_with(finding->place, "gantry.tgm+0x1a4");
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(a_write_names_register_value_cycle_and_place),
        TEST(no_number_names_the_odd_one),
        TEST(a_sum_that_is_no_number_is_told_when_no_store_was),
        TEST(order_names_both_registers),
        TEST(budgets_are_told_with_their_figures),
        TEST(each_function_of_the_background_has_its_budget),
        TEST(a_deep_stack_is_told_in_bytes),
        TEST(what_was_not_counted_is_not_judged),
        TEST(a_broken_convention_names_its_parts),
        TEST(sleep_counts_in_the_two_upper_functions_only),
        TEST(messages_may_be_thirty_in_the_first_second),
        TEST(set_points_are_told_with_what_the_axis_can),
        TEST(who_does_not_wait_is_found_by_what_was_traced),
        TEST(code_that_can_be_written_is_seen_when_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
