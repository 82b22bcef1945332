/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The emulated TG Motion as a module finds it, on every product. */
#include <errno.h>

#include "tests/host_rig.h"

static const char *const products[] = { "pc4",     "pc500",         "pc5",
                                        "tgmmini", "tgmcontroller", "tgzmotion" };

#define EACH_PRODUCT(p) for (size_t p = 0; p < sizeof products / sizeof *products; p++)

static struct rig *open_product(const char *name)
{
    const struct host_config config = { .product = product_find(name) };

    assert_non_null(config.product);
    return rig_open("idle", &config);
}

static void header_and_main_say_which_product_it_is(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        const struct product *product = product_find(products[p]);

        assert_true(rig_get(rig, "HEADER.Compatibility_Id") == product->compatibility_id);
        assert_true(rig_get(rig, "HEADER.CompatibilityMem_Id") == product->memory_id);
        assert_true(rig_get(rig, "HEADER.CompatibilityCnc_Id") == product->cnc_id);
        assert_true(rig_get(rig, "HEADER.Mem_Size_System") == 8192);
        assert_true(rig_get(rig, "MAIN.TGMotion_Version") == product->version);
        assert_true(rig_get(rig, "MAIN.Servo_SetCycleTime") == 500);
        assert_true(rig_get(rig, "MAIN.Number_Servos") == 1);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Data") == 524288);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Osc") == product->osc_bytes);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Servo") == product->max_servo * 2048);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Dio") == 32768);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Interpolator") ==
                    product->max_interpolator * 16384);
        assert_true(rig_get(rig, "MAIN.Interpolator_SetCycleTime") ==
                    (product->schedule == SCHEDULE_PC ? 100 : 500));
        assert_true(rig_get(rig, "MAIN.PLC_SetCycleTime_Prg2") == product->program_period_us[1]);
        if (product->memory_id == 906)
            assert_true(rig_get(rig, "HEADER.Product_Id") == product->product_id);
        rig_close(rig);
    }
}

static void ticks_and_timers_count_by_themselves(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);

        rig_start(rig);
        rig_set(rig, "TIMERS.Timer_Down[3]", 7);
        rig_cycles(rig, 2001);
        assert_true(rig_get(rig, "MAIN.Servo_Tick") == 2001);
        assert_true(rig_get(rig, "TIMERS.Timer_Up[0]") == 1000);
        assert_true(rig_get(rig, "TIMERS.Timer_Down[3]") == 0);
        rig_close(rig);
    }
}

static void a_servo_is_enabled_and_goes_where_it_is_told(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        double target;

        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_cycles(rig, 10);
        target = rig_get(rig, "SERVO[0].Position");
        rig_set(rig, "SERVO[0].WritePosition", target);
        rig_set(rig, "SERVO[0].Mode", 1);
        rig_until(rig, "SERVO[0].Status", 3, 100);
        for (unsigned i = 0; i < 1000; i++) {
            rig_set(rig, "SERVO[0].WritePosition", target += 500);
            rig_cycles(rig, 1);
        }
        rig_cycles(rig, 200);
        assert_true(rig_get(rig, "SERVO[0].Position") > target - 50);
        assert_true(rig_get(rig, "SERVO[0].Position") < target + 50);
        rig_close(rig);
    }
}

/* Input 0 of the default machine goes on and off; generation 4 has eight bits to a word, 5 has 32.
 */
static void inputs_arrive_in_the_words_of_the_generation(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        const char *in = p == 0 ? "DIO[0].In0" : "DIO[0].In[0]";
        const char *out = p == 0 ? "DIO[0].Out0" : "DIO[0].Out[0]";
        bool seen[2] = { false, false };

        rig_start(rig);
        rig_until(rig, "DIO[0].Status", 1, 1000);
        rig_set(rig, out, 0xA5);
        for (unsigned i = 0; i < 1000; i++) {
            const double value = rig_get(rig, in);

            assert_true(value == 0 || value == 1);
            seen[(int)value] = true;
            rig_cycles(rig, 1);
        }
        assert_true(seen[0] && seen[1]);
        rig_close(rig);
    }
}

/* Calls of Program_01..05 in so many cycles. */
static void calls_are(const char *product, uint32_t cycle_us, uint32_t period_02, unsigned cycles,
                      const uint64_t wanted[5])
{
    const struct host_config config = { .product = product_find(product),
                                        .cycle_us = cycle_us,
                                        .program_period_us = { 0, period_02, 0 } };
    struct rig *rig = rig_open("idle", &config);

    rig_start(rig);
    rig_cycles(rig, cycles);
    for (int i = 0; i < 5; i++)
        assert_int_equal(rig->evidence.calls[ENTRY_01 + i].count, wanted[i]);
    rig_close(rig);
}

static void controllers_call_the_background_at_ticks(void **state)
{
    (void)state;
    /* 60 ms each: 300 ticks, of which every second is Program_02's, every fourth Program_03's */
    calls_are("tgmcontroller", 100, 0, 600, (const uint64_t[]){ 300, 150, 75, 600, 600 });
    calls_are("tgmcontroller", 250, 0, 240, (const uint64_t[]){ 300, 150, 75, 240, 240 });
    calls_are("tgmcontroller", 3000, 0, 20, (const uint64_t[]){ 300, 150, 75, 20, 20 });
    calls_are("tgzmotion", 10000, 0, 6, (const uint64_t[]){ 300, 150, 75, 6, 6 });
    calls_are("tgzmotion", 500, 200, 120, (const uint64_t[]){ 300, 300, 75, 120, 120 });
    calls_are("tgzmotion", 500, PERIOD_OFF, 120, (const uint64_t[]){ 300, 0, 75, 120, 120 });
}

static void a_pc_calls_the_background_in_its_slots(void **state)
{
    (void)state;
    calls_are("pc4", 500, 0, 120, (const uint64_t[]){ 6, 12, 60, 120, 600 });
    calls_are("pc500", 1000, 100, 60, (const uint64_t[]){ 6, 600, 60, 60, 600 });
    calls_are("tgmmini", 250, 0, 240, (const uint64_t[]){ 6, 12, 60, 240, 1200 });
}

static void controllers_do_without_program_05_and_read_text_of_8_bits(void **state)
{
    static const char *const both[] = { "tgmcontroller", "tgzmotion" };
    (void)state;
    for (int i = 0; i < 2; i++) {
        const struct host_config config = { .product = product_find(both[i]) };
        struct rig *rig = rig_open("five", &config);

        rig_start(rig);
        rig_cycles(rig, 10);
        assert_int_equal(rig->evidence.calls[ENTRY_04].count, 10);
        assert_int_equal(rig->evidence.calls[ENTRY_05].count, 0);
        assert_int_equal(rig->evidence.message_count, 1);
        assert_string_equal(rig->evidence.messages[0].text, "hello, \xC5\x99\x65\xC5\xA5");
        rig_close(rig);
    }
}

static void a_pc_wants_program_05(void **state)
{
    const struct machine_config machine = { .seed = 1, .hang_ns = 2000000000 };
    struct host_config config = { .product = product_find("pc5"),
                                  .cycle_us = 500,
                                  .plant = &plant_default };
    struct rig rig;
    char why[HOST_WHY];
    (void)state;
    assert_int_equal(image_open(&rig.image, TEST_HOST_MODULES_DIR "/five_906.tgm", why), 0);
    assert_int_equal(machine_load(&rig.machine, rig.image, &machine, why), 0);
    assert_int_equal(host_open(&rig.host, &config, rig.machine, rig.image, &rig.evidence, why),
                     -ENOENT);
    assert_string_equal(why, "the module does not export the function Program_05");
    machine_unload(rig.machine);
    image_close(rig.image);
}

static void memories_have_the_sizes_of_the_configuration(void **state)
{
    const struct host_config config = { .product = product_find("tgmmini"),
                                        .data_bytes = 65536,
                                        .osc_bytes = 2 * 1048576 };
    struct rig *rig = rig_open("idle", &config);
    struct catalogue_register reg;
    char why[CATALOGUE_WHY];
    (void)state;
    assert_true(rig_get(rig, "HEADER.Mem_Size_Data") == 65536);
    assert_true(rig_get(rig, "HEADER.Mem_Size_Osc") == 2 * 1048576);
    rig_set(rig, "DATA.F64[65528]", 1.5);
    assert_true(rig_get(rig, "DATA.F64[65528]") == 1.5);
    assert_int_equal(catalogue_resolve(rig->catalogue, "DATA.F64[65536]", &reg, why), 0);
    assert_null(host_register(rig->host, &reg));
    assert_int_equal(catalogue_resolve(rig->catalogue, "SERVO[63].Position", &reg, why), 0);
    assert_non_null(host_register(rig->host, &reg));
    assert_int_equal(catalogue_resolve(rig->catalogue, "SERVO[64].Position", &reg, why), 0);
    assert_null(host_register(rig->host, &reg));
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(header_and_main_say_which_product_it_is),
        cmocka_unit_test(ticks_and_timers_count_by_themselves),
        cmocka_unit_test(a_servo_is_enabled_and_goes_where_it_is_told),
        cmocka_unit_test(inputs_arrive_in_the_words_of_the_generation),
        cmocka_unit_test(controllers_call_the_background_at_ticks),
        cmocka_unit_test(a_pc_calls_the_background_in_its_slots),
        cmocka_unit_test(controllers_do_without_program_05_and_read_text_of_8_bits),
        cmocka_unit_test(a_pc_wants_program_05),
        cmocka_unit_test(memories_have_the_sizes_of_the_configuration),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
