/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The emulated TG Motion as a module finds it, on every product. */
#include "tests/host_rig.h"

static const char *const products[] = { "pc4", "pc5" };

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(header_and_main_say_which_product_it_is),
        cmocka_unit_test(ticks_and_timers_count_by_themselves),
        cmocka_unit_test(a_servo_is_enabled_and_goes_where_it_is_told),
        cmocka_unit_test(inputs_arrive_in_the_words_of_the_generation),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
