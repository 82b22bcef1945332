/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_audit.c - what becomes of the accesses of a module, from accesses made up here. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "host/audit.h"
#include "host/evidence.h"

enum { PC = 0x1000 };

static struct audit audit;
static struct audit_record record;
static const struct catalogue *catalogue;

static int begin(void **state)
{
    (void)state;
    memset(&record, 0, sizeof record);
    catalogue = catalogue_find(4, 0);
    return audit_open(&audit, catalogue, &record);
}

static int end(void **state)
{
    (void)state;
    audit_close(&audit);
    return 0;
}

static size_t index_of(const struct catalogue_memory *memory)
{
    size_t index = 0;
    while (catalogue_memory(catalogue, index) != memory)
        index++;
    return index;
}

static void touch(const char *name, uint64_t pc, bool write, uint64_t value)
{
    struct catalogue_register reg;
    char why[CATALOGUE_WHY];
    if (catalogue_resolve(catalogue, name, &reg, why) != 0)
        fail_msg("%s", why);
    const struct trace_access access = { .pc = pc,
                                         .region = (uint32_t)index_of(reg.memory),
                                         .offset = (int64_t)reg.offset,
                                         .size = (unsigned)scalar_size(reg.type),
                                         .write = write,
                                         .value = value };
    audit_access(&audit, &access);
}

static uint64_t bits(double value)
{
    uint64_t result;
    memcpy(&result, &value, sizeof result);
    return result;
}

static const char *name_of(const struct audit_access *row)
{
    static char name[AUDIT_NAME];
    audit_name(catalogue, row->memory, row->offset, name);
    return name;
}

static void an_instruction_has_one_row_for_each_register_and_direction(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_04, 7, true);
    touch("SERVO[1].WritePosition", PC, true, bits(2.5));
    touch("SERVO[2].WritePosition", PC, true, bits(9.0)); /* the same register of another servo */
    touch("SERVO[1].WritePosition", PC, false, 0);
    touch("SERVO[1].Offset", PC, true, 0);
    touch("SERVO[1].WritePosition", PC + 4, true, 0);
    audit_end(&audit, true, 0, 0);
    assert_false(record.traced); /* nothing was counted */
    assert_int_equal(record.access_count, 4);
    assert_int_equal(record.accesses[0].count, 2);
    assert_int_equal(record.accesses[0].first_cycle, 7);
    assert_int_equal(record.accesses[0].first_value, bits(2.5));
    assert_int_equal(record.accesses[0].entry, ENTRY_04);
    assert_true(record.accesses[0].write);
    assert_false(record.accesses[0].before_op);
    assert_string_equal(name_of(&record.accesses[0]), "SERVO[1].WritePosition");
    assert_string_equal(name_of(&record.accesses[2]), "SERVO[1].Offset");
}

static void functions_do_not_share_rows(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_INI, EVIDENCE_NO_CYCLE, false);
    touch("DATA.U32[16]", PC, true, 1);
    audit_end(&audit, true, 0, 0);
    audit_begin(&audit, ENTRY_05, 3, false);
    touch("DATA.U32[16]", PC, true, 1);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.access_count, 2);
    assert_int_equal(record.accesses[1].first_cycle, 3);
    assert_true(record.accesses[1].before_op);
}

static void a_memory_without_registers_is_one_register(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_04, 0, true);
    for (unsigned i = 0; i < 3 * AUDIT_ACCESSES; i++) {
        char name[32];
        snprintf(name, sizeof name, "DATA.U32[%u]", 4 * i);
        touch(name, PC, true, i);
    }
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.access_count, 1);
    assert_int_equal(record.accesses[0].count, 3 * AUDIT_ACCESSES);
    assert_string_equal(name_of(&record.accesses[0]), "byte 0 of TGM_Data");
}

static void what_finds_no_row_is_counted(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_04, 0, true);
    for (unsigned i = 0; i < AUDIT_ACCESSES + 5; i++)
        touch("DATA.U32[0]", PC + i, true, 0);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.access_count, AUDIT_ACCESSES);
    assert_int_equal(record.access_dropped, 5);
}

static void registers_have_the_access_of_the_layout(void **state)
{
    static const struct {
        const char *name;
        unsigned classes;
    } wanted[] = {
        { "SERVO[0].Position", AUDIT_READ_ONLY | AUDIT_INPUT },
        { "SERVO[255].Status", AUDIT_READ_ONLY | AUDIT_INPUT },
        { "SERVO[0].Resolution", AUDIT_READ_ONLY },
        { "SERVO[0].Mode", AUDIT_OUTPUT },
        { "SERVO[3].WritePosition", AUDIT_OUTPUT | AUDIT_DOUBLE },
        { "SERVO[3].Pg.Acc", AUDIT_OUTPUT | AUDIT_DOUBLE },
        { "SERVO[3].Sdo.Control", 0 },
        { "DIO[0].In0", AUDIT_READ_ONLY | AUDIT_INPUT },
        { "DIO[15].Out0", AUDIT_OUTPUT },
        { "HEADER.Compatibility_Id", AUDIT_READ_ONLY },
        { "MAIN.Servo_Tick", AUDIT_READ_ONLY },
        { "TIMERS.Timer_Up[5]", 0 },
        { "DATA.F64[8]", 0 },
    };
    (void)state;
    audit_begin(&audit, ENTRY_04, 0, true);
    for (unsigned i = 0; i < sizeof wanted / sizeof *wanted; i++)
        touch(wanted[i].name, PC + i, false, 0);
    audit_end(&audit, true, 0, 0);
    for (unsigned i = 0; i < sizeof wanted / sizeof *wanted; i++)
        if (record.accesses[i].classes != wanted[i].classes)
            fail_msg("%s is 0x%x", wanted[i].name, record.accesses[i].classes);
}

static void names_have_every_index(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_04, 0, true);
    touch("TIMERS.Timer_Up[5]", PC, false, 0);
    audit_end(&audit, true, 0, 0);
    assert_string_equal(name_of(&record.accesses[0]), "SYSTEM.Timers.Timer_Up[5]");
}

static void an_input_after_an_output_is_told_once_a_call(void **state)
{
    const struct audit_order *order = &record.functions[ENTRY_04].order;
    char name[AUDIT_NAME];
    (void)state;
    audit_begin(&audit, ENTRY_04, 1, true);
    touch("DIO[0].In0", PC, false, 0);
    touch("DIO[0].Out0", PC + 1, true, 0);
    touch("DIO[0].Out0", PC + 2, false, 0); /* reading an output back is no input */
    touch("SERVO[0].Resolution", PC + 3, false, 0);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(order->count, 0);
    for (unsigned cycle = 2; cycle < 4; cycle++) {
        audit_begin(&audit, ENTRY_04, cycle, true);
        touch("DIO[0].Out0", PC + 1, true, 0);
        touch("SERVO[1].Position", PC + 5, false, 0);
        touch("SERVO[1].Speed", PC + 6, false, 0);
        audit_end(&audit, true, 0, 0);
    }
    assert_int_equal(order->count, 2);
    assert_int_equal(order->cycle, 2);
    assert_int_equal(order->output_pc, PC + 1);
    assert_int_equal(order->input_pc, PC + 5);
    audit_name(catalogue, order->input_memory, order->input_offset, name);
    assert_string_equal(name, "SERVO[1].Position");
    audit_name(catalogue, order->output_memory, order->output_offset, name);
    assert_string_equal(name, "DIO[0].Out0");
}

static void the_order_of_a_call_is_its_own(void **state)
{
    (void)state;
    audit_begin(&audit, ENTRY_01, 1, true);
    touch("DIO[0].Out0", PC, true, 0);
    audit_begin(&audit, ENTRY_04, 1, true); /* interrupts it */
    touch("DIO[0].In0", PC + 1, false, 0);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.functions[ENTRY_04].order.count, 0);
    touch("DIO[0].In0", PC + 2, false, 0);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.functions[ENTRY_01].order.count, 1);
    audit_begin(&audit, ENTRY_INI, EVIDENCE_NO_CYCLE, true);
    touch("DIO[0].Out0", PC, true, 0);
    touch("DIO[0].In0", PC + 2, false, 0);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.functions[ENTRY_INI].order.count, 0); /* no inputs before the cycles */
}

static void no_number_is_counted_only_where_it_acts(void **state)
{
    const uint64_t nan = UINT64_C(0x7FF8000000000000), infinity = UINT64_C(0xFFF0000000000000);
    (void)state;
    audit_begin(&audit, ENTRY_04, 11, true);
    touch("SERVO[0].WritePosition", PC, true, bits(1e308));
    touch("SERVO[2].WritePosition", PC, true, nan);
    touch("SERVO[3].WritePosition", PC, true, infinity);
    touch("SERVO[0].WritePosition", PC + 1, false, nan); /* read */
    touch("DATA.F64[0]", PC + 2, true, nan);
    touch("SERVO[0].Mode", PC + 3, true, 0x7FF00000);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.accesses[0].odd_count, 2);
    assert_int_equal(record.accesses[0].odd_cycle, 11);
    assert_int_equal(record.accesses[0].odd_offset, 2 * 2048 + 464);
    for (unsigned i = 1; i < record.access_count; i++)
        assert_int_equal(record.accesses[i].odd_count, 0);
}

static void a_double_in_two_halves_is_judged_by_its_high_one(void **state)
{
    struct trace_access half = {
        .pc = PC, .region = 4, .offset = 464, .size = 4, .write = true, .value = 0x7FF00000
    };
    (void)state;
    audit_begin(&audit, ENTRY_04, 0, true);
    audit_access(&audit, &half);
    assert_int_equal(record.accesses[0].odd_count, 0);
    half.offset += 4;
    audit_access(&audit, &half);
    assert_int_equal(record.accesses[0].odd_count, 1);
    audit_end(&audit, true, 0, 0);
}

static void the_worst_call_is_kept_with_its_cycle(void **state)
{
    static const uint64_t taken[] = { 30, 70, 50, 70 };
    (void)state;
    for (unsigned cycle = 0; cycle < 4; cycle++) {
        audit_begin(&audit, ENTRY_05, cycle, true);
        audit_end(&audit, true, taken[cycle], 100 - cycle);
    }
    audit_begin(&audit, ENTRY_05, 4, true);
    audit_end(&audit, false, 1000, 1000); /* a hang */
    const struct audit_function *function = &record.functions[ENTRY_05];
    assert_true(record.traced);
    assert_int_equal(function->calls, 4);
    assert_int_equal(function->instructions, 220);
    assert_int_equal(function->worst_instructions, 70);
    assert_int_equal(function->worst_cycle, 1);
    assert_int_equal(function->stack_bytes, 100);
}

static void accesses_outside_calls_and_memories_are_not_kept(void **state)
{
    const struct trace_access beyond = { .pc = PC, .region = 4, .offset = -1, .size = 1 };
    const struct trace_access data = { .pc = PC, .region = AUDIT_MEMORIES + 2, .size = 4 };
    const struct trace_access code = {
        .pc = PC, .region = TRACE_CODE, .offset = 0x1234, .size = 1, .write = true
    };
    (void)state;
    touch("DIO[0].In0", PC, false, 0);
    audit_begin(&audit, ENTRY_04, 0, true);
    audit_access(&audit, &data); /* PLC_DATA */
    assert_int_equal(record.access_count, 0);
    assert_int_equal(record.functions[ENTRY_04].looked, 1);
    audit_access(&audit, &beyond); /* the byte before a memory: it faults, and that is told */
    audit_access(&audit, &code);
    audit_end(&audit, true, 0, 0);
    assert_int_equal(record.access_count, 2);
    assert_int_equal(record.accesses[0].classes, 0);
    assert_int_equal(record.accesses[1].memory, AUDIT_CODE);
    assert_int_equal(record.accesses[1].offset, 0x1234);
}

static void a_record_from_a_worker_is_made_safe(void **state)
{
    (void)state;
    memset(&record, 0xA5, sizeof record);
    audit_clean(&record);
    assert_true(record.access_count <= AUDIT_ACCESSES);
    for (unsigned i = 0; i < AUDIT_ACCESSES; i++) {
        assert_true(record.accesses[i].entry < ENTRY_COUNT);
        assert_true(record.accesses[i].memory < AUDIT_MEMORIES);
        assert_non_null(name_of(&record.accesses[i]));
    }
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(an_instruction_has_one_row_for_each_register_and_direction),
        TEST(functions_do_not_share_rows),
        TEST(a_memory_without_registers_is_one_register),
        TEST(what_finds_no_row_is_counted),
        TEST(registers_have_the_access_of_the_layout),
        TEST(names_have_every_index),
        TEST(an_input_after_an_output_is_told_once_a_call),
        TEST(the_order_of_a_call_is_its_own),
        TEST(no_number_is_counted_only_where_it_acts),
        TEST(a_double_in_two_halves_is_judged_by_its_high_one),
        TEST(the_worst_call_is_kept_with_its_cycle),
        TEST(accesses_outside_calls_and_memories_are_not_kept),
        TEST(a_record_from_a_worker_is_made_safe),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
