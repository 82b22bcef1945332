/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The schedules of all products, when Program_01..03 are due, and what may be configured. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "host/schedule.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const struct product *product(const char *name)
{
    const struct product *found = product_find(name);

    assert_non_null(found);
    return found;
}

/* The manual's text: slots are equal, each action has its place, Program_05 everywhere. */
static void a_pc_has_the_slots_of_the_manual(void **state)
{
    (void)state;
    static const struct {
        uint32_t cycle, step;
        size_t slots;
    } wanted[] = { { 250, 50, 5 }, { 500, 100, 5 }, { 1000, 100, 10 } };
    for (size_t i = 0; i < COUNT(wanted); i++) {
        const struct schedule *s = schedule_find(SCHEDULE_PC, wanted[i].cycle);
        assert_non_null(s);
        assert_int_equal(s->slot_count, wanted[i].slots);
        assert_int_equal(s->interpolator_us, wanted[i].step);
        for (size_t k = 0; k < s->slot_count; k++) {
            assert_int_equal(s->slots[k].at_us, k * wanted[i].step);
            assert_true(s->slots[k].actions & SLOT_PROGRAM_05);
            assert_int_equal((s->slots[k].actions & SLOT_RECEIVE) != 0, k == 0);
            assert_int_equal((s->slots[k].actions & SLOT_SEND) != 0, k == 1);
            assert_int_equal((s->slots[k].actions & SLOT_PROFILE) != 0, k == 2);
            assert_int_equal((s->slots[k].actions & SLOT_PROGRAM_04) != 0, k == 3);
            assert_int_equal((s->slots[k].actions & SLOT_OSCILLOSCOPE) != 0, k == 3);
        }
    }
    assert_null(schedule_find(SCHEDULE_PC, 750));
    assert_null(schedule_find(SCHEDULE_PC, 100));
}

static void a_controller_works_first_and_sends_at_half_of_the_cycle(void **state)
{
    (void)state;
    for (const uint32_t *us = product("tgmcontroller")->cycle_times_us; *us != 0; us++) {
        const struct schedule *s = schedule_find(SCHEDULE_CONTROLLER, *us);
        assert_non_null(s);
        assert_int_equal(s->cycle_us, *us);
        assert_int_equal(s->interpolator_us, *us);
        assert_int_equal(s->slot_count, 2);
        assert_int_equal(s->slots[0].at_us, 0);
        assert_int_equal(s->slots[0].actions, SLOT_RECEIVE | SLOT_PROFILE | SLOT_PROGRAM_05 |
                                                  SLOT_PROGRAM_04 | SLOT_OSCILLOSCOPE);
        assert_int_equal(s->slots[1].at_us, *us / 2);
        assert_int_equal(s->slots[1].actions, SLOT_SEND);
    }
    assert_null(schedule_find(SCHEDULE_CONTROLLER, 1500));
}

static void every_product_has_a_schedule_for_each_of_its_cycle_times(void **state)
{
    (void)state;
    for (size_t i = 0; product_at(i) != NULL; i++) {
        const struct product *p = product_at(i);
        bool usual = false;
        for (const uint32_t *us = p->cycle_times_us; *us != 0; us++) {
            assert_non_null(schedule_find(p->schedule, *us));
            usual = usual || *us == p->default_cycle_us;
        }
        assert_true(usual);
        for (unsigned which = 0; which < 3; which++)
            assert_true(product_allows_period(p, which, p->program_period_us[which]));
    }
}

static void the_products_are_those_of_the_manuals(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int generation;
        uint32_t compatibility, memory, cnc, id;
        unsigned servos, interpolators, entries;
        bool text8;
        const char *device, *ini;
        size_t cycles;
    } wanted[] = {
        { "pc4", 4, 4033, 904, 121, 0, 256, 3, 6, false, NULL, "TGMotion4xx.ini", 3 },
        { "pc500", 5, 4034, 905, 123, 0, 256, 3, 6, false, NULL, "TgMotion5xx.ini", 3 },
        { "pc5", 5, 4034, 906, 126, 1, 256, 3, 6, false, "PC-realtime", "TgMotion5xx.ini", 3 },
        { "tgmmini", 5, 4034, 906, 126, 2, 64, 2, 6, true, "TGMmini", "TgMotion5xx.ini", 3 },
        { "tgmcontroller", 5, 4034, 906, 126, 3, 64, 3, 5, true, "TGMcontroller", "TGM.INI", 14 },
        { "tgzmotion", 5, 4034, 906, 126, 4, 64, 3, 5, true, "TGZ+Motion", "TGM.INI", 14 },
    };
    assert_null(product_at(COUNT(wanted)));
    for (size_t i = 0; i < COUNT(wanted); i++) {
        const struct product *p = product(wanted[i].name);
        size_t cycles = 0;
        assert_int_equal(p->generation, wanted[i].generation);
        assert_int_equal(p->compatibility_id, wanted[i].compatibility);
        assert_int_equal(p->memory_id, wanted[i].memory);
        assert_int_equal(p->cnc_id, wanted[i].cnc);
        assert_int_equal(p->product_id, wanted[i].id);
        assert_int_equal(p->max_servo, wanted[i].servos);
        assert_int_equal(p->max_dio, 16);
        assert_int_equal(p->max_interpolator, wanted[i].interpolators);
        assert_int_equal(p->entries, wanted[i].entries);
        assert_int_equal(p->text8, wanted[i].text8);
        assert_string_equal(p->ini_name, wanted[i].ini);
        if (wanted[i].device != NULL)
            assert_string_equal(p->device_name, wanted[i].device);
        while (p->cycle_times_us[cycles] != 0)
            cycles++;
        assert_int_equal(cycles, wanted[i].cycles);
    }
}

/* Periods in us, times in ns. */
static void a_function_is_due_at_the_next_multiple_of_its_period(void **state)
{
    (void)state;
    static const struct {
        const char *product;
        uint32_t period;
        uint64_t ended, due;
    } rows[] = {
        { "pc5", 1000, 0, 1000000 },
        { "pc5", 1000, 999999, 1000000 },
        { "pc5", 1000, 1000000, 2000000 },
        { "pc5", 1000, 3400000, 4000000 }, /* three periods went by, and are not made up for */
        { "pc5", 100, 350001, 400000 },
        { "pc5", 0, 350001, NEVER_DUE },
        { "tgmcontroller", 400, 0, 400000 },
        { "tgmcontroller", 400, 300000, 400000 }, /* exactly 100 us are left: it keeps its tick */
        { "tgmcontroller", 400, 300001, 600000 }, /* less: the next tick */
        { "tgmcontroller", 400, 399999, 600000 },
        { "tgmcontroller", 400, 400000, 800000 },
        { "tgmcontroller", 400, 650000, 800000 }, /* and back to the multiples afterwards */
        { "tgmcontroller", 200, 100000, 200000 },
        { "tgmcontroller", 200, 150000, 400000 },
        { "tgmcontroller", 1000, 3400000, 4000000 },
        { "tgmcontroller", 0, 0, 200000 }, /* as fast as possible: every tick */
        { "tgmcontroller", 0, 399999, 400000 },
        { "tgzmotion", 0, 400000, 600000 },
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_int_equal(schedule_due(product(rows[i].product), rows[i].period, rows[i].ended),
                         rows[i].due);
}

static void periods_are_allowed_as_the_product_says(void **state)
{
    (void)state;
    static const struct {
        const char *product;
        unsigned which;
        uint32_t us;
        bool allowed;
    } rows[] = {
        { "pc4", 0, 100, true },
        { "pc4", 0, 99, false },
        { "pc4", 0, 0, false },
        { "pc4", 2, 1000000, true },
        { "pc4", 1, 12345, true },
        { "tgmcontroller", 0, 0, true },
        { "tgmcontroller", 0, 200, false },
        { "tgmcontroller", 1, 0, true },
        { "tgmcontroller", 1, 200, true },
        { "tgmcontroller", 1, 300, false },
        { "tgmcontroller", 2, 100, false },
        { "tgzmotion", 2, 800, true },
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_int_equal(product_allows_period(product(rows[i].product), rows[i].which, rows[i].us),
                         rows[i].allowed);
}

static void allowed_values_are_said_in_words(void **state)
{
    (void)state;
    char text[128];
    product_cycles_text(product("pc4"), text, sizeof text);
    assert_string_equal(text, "250, 500 or 1000");
    product_cycles_text(product("tgmcontroller"), text, sizeof text);
    assert_string_equal(text, "100, 200, 250, 500, 1000, 2000, 3000, 4000, 5000, 6000, 7000, 8000, "
                              "9000 or 10000");
    product_cycles_text(product("tgmcontroller"), text, 8);
    assert_int_equal(strlen(text), 7);
    product_periods_text(product("pc4"), 1, text, sizeof text);
    assert_string_equal(text, "100 or more");
    product_periods_text(product("tgmcontroller"), 0, text, sizeof text);
    assert_string_equal(text, "only 0 (as fast as possible)");
    product_periods_text(product("tgmcontroller"), 1, text, sizeof text);
    assert_string_equal(text, "0 (off) and multiples of 200");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pc_has_the_slots_of_the_manual),
        cmocka_unit_test(a_controller_works_first_and_sends_at_half_of_the_cycle),
        cmocka_unit_test(every_product_has_a_schedule_for_each_of_its_cycle_times),
        cmocka_unit_test(the_products_are_those_of_the_manuals),
        cmocka_unit_test(a_function_is_due_at_the_next_multiple_of_its_period),
        cmocka_unit_test(periods_are_allowed_as_the_product_says),
        cmocka_unit_test(allowed_values_are_said_in_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
