/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The oscilloscope as a PLC or Observer sees it: registers in, TGM_Oscilloscope out. */
#include "tests/host_rig.h"

static const char *const products[] = { "pc4", "pc500", "pc5", "tgmmini", "tgmcontroller" };

#define PRODUCTS (sizeof products / sizeof *products)

static struct rig *open_product(const char *name)
{
    const struct host_config config = { .product = product_find(name) };
    struct rig *rig = rig_open("idle", &config);

    rig_start(rig);
    return rig;
}

static void channel(const struct rig *rig, unsigned n, const char *name, unsigned type)
{
    struct catalogue_register reg;
    char text[64];

    rig_at(rig, name, &reg);
    snprintf(text, sizeof text, "OSC.Channel[%u].Memory_Type_Value", n);
    rig_set(rig, text, reg.memory->number);
    snprintf(text, sizeof text, "OSC.Channel[%u].Offset_Value", n);
    rig_set(rig, text, (double)reg.offset);
    snprintf(text, sizeof text, "OSC.Channel[%u].Type_Value", n);
    rig_set(rig, text, type);
}

static uint32_t word(const struct rig *rig, size_t offset)
{
    struct catalogue_register reg;
    const uint8_t *at = rig_at(rig, "OSCDATA.U32[0]", &reg);
    uint32_t value;

    memcpy(&value, at + offset, sizeof value);
    return value;
}

/* The word at an offset in a memory. */
static uint32_t *at_offset(const struct rig *rig, const char *memory, size_t offset)
{
    const struct catalogue_register reg = {
        .memory = catalogue_memory_named(rig->catalogue, memory), .offset = offset, .type = U32
    };

    assert_non_null(reg.memory);
    return (uint32_t *)(uintptr_t)host_register(rig->host, &reg);
}

static void servo_ticks_are_recorded_every_third_cycle(void **state)
{
    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++) {
        struct rig *rig = open_product(products[p]);
        double first;

        channel(rig, 0, "MAIN.Servo_Tick", 3);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Number_Periods", 3);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 1);
        first = rig_get(rig, "MAIN.Servo_Tick");
        assert_true(rig_get(rig, "OSC.Status") == 1);
        assert_true(rig_get(rig, "OSC.Sample_Time") == 1500);
        assert_true(rig_get(rig, "OSC.Number_Samples") == rig_get(rig, "HEADER.Mem_Size_Osc") / 4);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 1);
        rig_cycles(rig, 30);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 11);
        for (unsigned i = 0; i < 11; i++)
            assert_true(word(rig, (size_t)rig_get(rig, "OSC.Channel[0].Offset") + i * 4) ==
                        first + 3 * i);
        rig_set(rig, "OSC.Control", 0);
        rig_cycles(rig, 5);
        assert_true(rig_get(rig, "OSC.Status") == 0);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 11);
        rig_close(rig);
    }
}

static void a_full_memory_clears_control_and_status(void **state)
{
    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++) {
        struct rig *rig = open_product(products[p]);
        unsigned cycles = 0;

        /* Thirty-two doubles: the memory is full soonest. */
        for (unsigned i = 0; i < 32; i++)
            channel(rig, i, "SERVO[0].Position", 8);
        rig_set(rig, "OSC.Number_Chanels", 32);
        rig_set(rig, "OSC.Number_Periods", 0);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 1);
        while (rig_get(rig, "OSC.Control") != 0 && cycles++ < 200000)
            rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Status") == 0);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == rig_get(rig, "OSC.Number_Samples"));
        assert_true(cycles + 1 == rig_get(rig, "OSC.Number_Samples"));
        rig_close(rig);
    }
}

static void a_trigger_waits_with_status_2(void **state)
{
    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++) {
        struct rig *rig = open_product(products[p]);
        struct catalogue_register reg;

        channel(rig, 0, "DATA.I32[5]", 0);
        rig_at(rig, "DATA.I32[4]", &reg);
        rig_set(rig, "OSC.Memory_Type_Trigger", reg.memory->number);
        rig_set(rig, "OSC.Offset_Trigger", (double)reg.offset);
        rig_set(rig, "OSC.Type_Trigger", 0);
        rig_set(rig, "OSC.Mode_Trigger", 1);
        rig_set(rig, "OSC.Level_Trigger", 20);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Number_Periods", 1);
        rig_set(rig, "DATA.I32[4]", 17);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 10);
        assert_true(rig_get(rig, "OSC.Status") == 2);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 0);
        rig_set(rig, "DATA.I32[4]", 22);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Status") == 1);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 1);
        rig_close(rig);
    }
}

/* Whatever the registers hold: the controller goes on, and says that nothing is recorded. */
static void wrong_set_ups_end_at_once(void **state)
{
    static const struct {
        const char *name;
        double value;
    } rows[] = {
        { "OSC.Number_Chanels", 0 },
        { "OSC.Number_Chanels", 33 },
        { "OSC.Channel[0].Memory_Type_Value", 99 },
        { "OSC.Channel[0].Offset_Value", 4294967295.0 },
        { "OSC.Channel[0].Offset_Value", 524288 - 4 },
        { "OSC.Channel[0].Type_Value", 10 },
        { "OSC.Channel[0].Type_Value", 77 },
        { "OSC.Mode_Trigger", 3 },
    };

    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
            struct rig *rig = open_product(products[p]);

            channel(rig, 0, "DATA.F64[0]", 8);
            rig_set(rig, "OSC.Number_Chanels", 1);
            rig_set(rig, "OSC.Number_Periods", 1);
            rig_set(rig, rows[i].name, rows[i].value);
            rig_set(rig, "OSC.Control", 1);
            rig_cycles(rig, 2);
            assert_true(rig_get(rig, "OSC.Control") == 0);
            assert_true(rig_get(rig, "OSC.Status") == 0);
            assert_true(rig_get(rig, "OSC.Number_Samples") == 0);
            assert_true(rig_get(rig, "OSC.Actual_Samples") == 0);
            rig_close(rig);
        }
}

static void only_5_02_has_the_extensions(void **state)
{
    struct rig *rig = open_product("pc5");

    (void)state;
    assert_true(rig_get(rig, "MAIN.Implemented_Features") == 1);
    channel(rig, 0, "MAIN.Servo_Tick", 3);
    rig_set(rig, "OSC.Number_Chanels", 1);
    rig_set(rig, "OSC.Number_Periods", 1);
    /* Without the start bit nothing happens, whatever else is set. */
    rig_set(rig, "OSC.Control", 0x18);
    rig_cycles(rig, 3);
    assert_true(rig_get(rig, "OSC.Status") == 0);
    rig_set(rig, "OSC.Control", 0x19);
    rig_cycles(rig, 4);
    assert_true(rig_get(rig, "OSC.Status") == 0x19);
    assert_true(rig_get(rig, "OSC.Actual_Samples") == 4);
    rig_set(rig, "OSC.Control", 0x1d);
    rig_cycles(rig, 4);
    assert_true(rig_get(rig, "OSC.Status") == 0x1c);
    assert_true(rig_get(rig, "OSC.Actual_Samples") == 4);
    rig_set(rig, "OSC.Control", 0x19);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "OSC.Actual_Samples") == 5);
    rig_close(rig);
    for (size_t p = 0; p < 2; p++) { /* 4.21 and 5.00: every Control above 0 is a start */
        rig = open_product(products[p]);
        channel(rig, 0, "MAIN.Servo_Tick", 3);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Number_Periods", 1);
        rig_set(rig, "OSC.Control", 0x51c);
        rig_cycles(rig, 4);
        assert_true(rig_get(rig, "OSC.Status") == 1);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 4);
        rig_set(rig, "OSC.Control", -1);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Status") == 0);
        if (p == 1) /* reserved there */
            assert_int_equal(*at_offset(rig, "TGM_System", 1204), 0);
        rig_close(rig);
    }
}

/* The chapter of generation 4 and the header of generation 5, not the catalogue. */
static void memories_have_the_numbers_of_their_generation(void **state)
{
    static const struct {
        const char *product;
        unsigned number;
        const char *memory;
    } rows[] = {
        { "pc4", 0, "TGM_System" },
        { "pc4", 1, "TGM_Data" },
        { "pc4", 2, "TGM_Cam_Profile" },
        { "pc4", 3, "TGM_Oscilloscope" },
        { "pc4", 4, "TGM_Servo" },
        { "pc4", 5, "TGM_Dio" },
        { "pc4", 6, "TGM_Interpolator" },
        { "pc4", 9, "TGM_ODS" },
        { "pc4", 10, "TGM_CNCEX" },
        { "pc4", 11, "TGM_GCODE" },
        { "pc4", 12, NULL },
        { "pc5", 4, "TGM_Servo" },
        { "pc5", 6, "TGM_General" },
        { "pc5", 7, "TGM_Interpolator" },
        { "pc5", 8, "InterpolatorWriteMemory" },
        { "pc5", 10, "TGM_ODS" },
        { "pc5", 11, "TGM_CNCODS" },
        { "pc5", 12, "TGM_CNCEX" },
        { "pc5", 13, NULL },
        { "pc500", 6, "TGM_General" },
        { "pc500", 12, "TGM_CNCEX" },
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct rig *rig = open_product(rows[i].product);
        const uint32_t mark = 0x5ee00000u + (uint32_t)i;

        if (rows[i].memory != NULL)
            *at_offset(rig, rows[i].memory, 5000) = mark;
        rig_set(rig, "OSC.Channel[0].Memory_Type_Value", rows[i].number);
        rig_set(rig, "OSC.Channel[0].Offset_Value", 5000);
        rig_set(rig, "OSC.Channel[0].Type_Value", 3);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Status") == (rows[i].memory != NULL));
        if (rows[i].memory != NULL && rows[i].number != 3)
            assert_int_equal(word(rig, 0), mark);
        rig_close(rig);
    }
}

static void int32_and_double_share_the_memory_one_to_two(void **state)
{
    struct rig *rig = open_product("pc4");

    (void)state;
    channel(rig, 0, "DATA.I32[0]", 0);
    channel(rig, 1, "DATA.F64[8]", 8);
    rig_set(rig, "OSC.Number_Chanels", 2);
    rig_set(rig, "OSC.Control", 1);
    rig_cycles(rig, 1);
    /* floor(1048576 / 12); 87381 * 4 rounded up to a multiple of 8. */
    assert_true(rig_get(rig, "OSC.Number_Samples") == 87381);
    assert_true(rig_get(rig, "OSC.Channel[0].Offset") == 0);
    assert_true(rig_get(rig, "OSC.Channel[1].Offset") == 349528);
    rig_close(rig);
}

static void the_set_up_counts_when_it_starts(void **state)
{
    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++) {
        struct rig *rig = open_product(products[p]);

        rig_set(rig, "DATA.I32[8]", 55);
        rig_set(rig, "DATA.I32[16]", 66);
        channel(rig, 0, "DATA.I32[8]", 0);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Number_Periods", 1);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 2);
        channel(rig, 0, "DATA.I32[16]", 0);
        rig_set(rig, "OSC.Number_Chanels", 40);
        rig_set(rig, "OSC.Number_Periods", 7);
        rig_set(rig, "OSC.Channel[0].Offset", 4294967295.0);
        rig_cycles(rig, 2);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 4);
        assert_int_equal(word(rig, 12), 55);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_set(rig, "OSC.Control", 0);
        rig_cycles(rig, 1);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 7);
        assert_true(rig_get(rig, "OSC.Actual_Samples") == 1);
        assert_true(rig_get(rig, "OSC.Sample_Time") == 7 * 500);
        assert_int_equal(word(rig, 0), 66);
        rig_close(rig);
    }
}

static void options_are_mirrored_as_the_recording_has_them(void **state)
{
    struct rig *rig = open_product("pc5");

    (void)state;
    channel(rig, 0, "DATA.I32[0]", 0);
    channel(rig, 1, "DATA.F64[8]", 8);
    rig_set(rig, "DATA.I32[0]", 7);
    rig_set(rig, "OSC.Number_Chanels", 2);
    /* Samples before a trigger that there is not; later another layout, and no end. */
    rig_set(rig, "OSC.Control", 0x511);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "OSC.Status") == 0x11);
    assert_true(rig_get(rig, "OSC.Channel[1].Offset") == 4);
    assert_true(rig_get(rig, "OSC.Number_Samples") == 33554432 / 12);
    rig_set(rig, "OSC.Control", 0x909);
    rig_cycles(rig, 2);
    assert_true(rig_get(rig, "OSC.Status") == 0x11);
    assert_int_equal(word(rig, 0), 7);
    assert_int_equal(word(rig, 12), 7);
    assert_int_equal(word(rig, 24), 7);
    rig_close(rig);
}

/* AND waits for an edge of each; one that cannot be read makes the set-up a wrong one. */
static void triggers_of_both_structures_together(void **state)
{
    (void)state;
    for (int function = 0; function < 2; function++) {
        struct rig *rig = open_product("pc5");
        struct catalogue_register reg;

        channel(rig, 0, "MAIN.Servo_Tick", 3);
        rig_set(rig, "OSC.Number_Chanels", 1);
        rig_at(rig, "DATA.I32[4]", &reg);
        rig_set(rig, "OSC.Memory_Type_Trigger", reg.memory->number);
        rig_set(rig, "OSC.Offset_Trigger", (double)reg.offset);
        rig_set(rig, "OSC.Mode_Trigger", 1);
        rig_set(rig, "OSC.Level_Trigger", 20);
        rig_at(rig, "DATA.F64[16]", &reg);
        rig_set(rig, "OSC_EX.Trigger[2].Memory_Type", reg.memory->number);
        rig_set(rig, "OSC_EX.Trigger[2].Offset", (double)reg.offset);
        rig_set(rig, "OSC_EX.Trigger[2].Type", 8);
        rig_set(rig, "OSC_EX.Trigger[2].Mode", 1);
        rig_set(rig, "OSC_EX.Trigger[2].Level", 0.5);
        rig_set(rig, "OSC_EX.Function", function);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 3);
        assert_true(rig_get(rig, "OSC.Status") == 2);
        rig_set(rig, "DATA.I32[4]", 22);
        rig_cycles(rig, 2);
        assert_true(rig_get(rig, "OSC.Status") == (function ? 2 : 1));
        rig_set(rig, "DATA.F64[16]", 1);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Status") == 1);
        rig_set(rig, "OSC.Control", 0);
        rig_cycles(rig, 1);
        rig_set(rig, "OSC_EX.Trigger[2].Memory_Type", 1000);
        rig_set(rig, "OSC.Control", 1);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "OSC.Control") == 0);
        assert_true(rig_get(rig, "OSC.Status") == 0);
        assert_true(rig_get(rig, "OSC.Number_Samples") == 0);
        rig_close(rig);
    }
}

static void a_further_trigger_and_samples_before_it(void **state)
{
    struct rig *rig = open_product("pc5");
    struct catalogue_register reg;

    (void)state;
    channel(rig, 0, "MAIN.Servo_Tick", 3);
    rig_set(rig, "OSC.Number_Chanels", 1);
    rig_set(rig, "OSC.Number_Periods", 1);
    rig_at(rig, "DATA.F64[7]", &reg);
    rig_set(rig, "OSC_EX.Trigger[1].Memory_Type", reg.memory->number);
    rig_set(rig, "OSC_EX.Trigger[1].Offset", (double)reg.offset);
    rig_set(rig, "OSC_EX.Trigger[1].Type", 8);
    rig_set(rig, "OSC_EX.Trigger[1].Mode", 2);
    rig_set(rig, "OSC_EX.Trigger[1].Level", -1);
    rig_set(rig, "OSC.Control", 0x501);
    rig_cycles(rig, 20);
    assert_true(rig_get(rig, "OSC.Status") == 0x502);
    rig_set(rig, "DATA.F64[7]", -3);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "OSC.Status") == 0x501);
    assert_true(rig_get(rig, "OSC.Actual_Samples") == 6);
    assert_true(rig_get(rig, "OSC.Trigger_Start_Position") == 15);
    assert_true(word(rig, 15 * 4) == rig_get(rig, "MAIN.Servo_Tick") - 5);
    rig_close(rig);
}

static void the_host_arms_it_and_reads_it_back(void **state)
{
    (void)state;
    for (size_t p = 0; p < PRODUCTS; p++) {
        struct rig *rig = open_product(products[p]);
        struct catalogue_register channels[2];
        struct host_osc wanted = { .channels = channels, .count = 2, .every = 2 };
        char why[HOST_WHY];
        double row[3];

        rig_at(rig, "MAIN.Servo_Tick", &channels[0]);
        rig_at(rig, "SERVO[0].Position", &channels[1]);
        assert_int_equal(host_osc_arm(rig->host, &wanted, why), 0);
        rig_cycles(rig, 9);
        assert_int_equal(host_osc_samples(rig->host), 5);
        for (size_t i = 0; i < 5; i++) {
            host_osc_row(rig->host, i, row);
            assert_true(row[0] > (double)i * 0.001 - 1e-12 && row[0] < (double)i * 0.001 + 1e-12);
            assert_true(row[1] == 1 + 2 * (double)i);
        }
        rig_at(rig, "MAIN.Found_Total_Number_Of_ECAT_Devices", &channels[1]);
        wanted.count = 0;
        assert_int_equal(host_osc_arm(rig->host, &wanted, why), -22);
        assert_string_equal(why, "the oscilloscope has 1 to 32 channels, not 0");
        wanted.count = 1;
        wanted.pretrigger = 5;
        assert_int_equal(host_osc_arm(rig->host, &wanted, why), -22);
        assert_string_equal(why, "samples before the trigger need TG Motion 5.02 and a trigger");
        rig_close(rig);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(servo_ticks_are_recorded_every_third_cycle),
        cmocka_unit_test(a_full_memory_clears_control_and_status),
        cmocka_unit_test(a_trigger_waits_with_status_2),
        cmocka_unit_test(wrong_set_ups_end_at_once),
        cmocka_unit_test(only_5_02_has_the_extensions),
        cmocka_unit_test(memories_have_the_numbers_of_their_generation),
        cmocka_unit_test(int32_and_double_share_the_memory_one_to_two),
        cmocka_unit_test(the_set_up_counts_when_it_starts),
        cmocka_unit_test(options_are_mirrored_as_the_recording_has_them),
        cmocka_unit_test(triggers_of_both_structures_together),
        cmocka_unit_test(a_further_trigger_and_samples_before_it),
        cmocka_unit_test(the_host_arms_it_and_reads_it_back),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
