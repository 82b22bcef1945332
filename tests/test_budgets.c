/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_budgets.c - what calls may take, and the report's table of what they took. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conformance/budgets.h"

static struct experiment at(const char *product, uint32_t cycle_us)
{
    return (struct experiment){
        .name = "test", .host = { .product = product_find(product), .cycle_us = cycle_us }
    };
}

static double allowed(const char *product, uint32_t cycle_us, enum entry entry)
{
    const struct experiment experiment = at(product, cycle_us);
    return budget_allowed_us(&experiment, entry);
}

static bool near(double a, double b)
{
    return a - b < 1e-9 && b - a < 1e-9;
}

static void the_manuals_figures_depend_on_product_and_cycle(void **state)
{
    (void)state;
    assert_true(near(allowed("pc4", 250, ENTRY_04), 25));
    assert_true(near(allowed("pc4", 1000, ENTRY_04), 100));
    assert_true(near(allowed("pc4", 1000, ENTRY_05), 10));
    assert_true(near(allowed("pc4", 500, ENTRY_01), 2000)); /* 20 % of 10 ms */
    assert_true(near(allowed("pc5", 500, ENTRY_02), 1000));
    assert_true(near(allowed("pc4", 500, ENTRY_03), 200));
    assert_true(near(allowed("tgmcontroller", 500, ENTRY_04), 250));
    assert_true(near(allowed("tgmcontroller", 500, ENTRY_05), 0)); /* no figure */
    assert_true(near(allowed("tgzmotion", 500, ENTRY_02), 0));
    assert_true(near(allowed("pc4", 500, ENTRY_INI), 0)); /* as long as it likes */
}

static void configured_periods_count(void **state)
{
    struct experiment experiment = at("pc4", 500);
    (void)state;
    experiment.host.program_period_us[0] = 400;
    experiment.host.program_period_us[1] = PERIOD_OFF;
    assert_true(near(budget_allowed_us(&experiment, ENTRY_01), 80));
    assert_true(near(budget_allowed_us(&experiment, ENTRY_02), 0));
    assert_true(near(budget_allowed_us(&experiment, ENTRY_03), 200));
}

static void instructions_are_time_at_the_rate_of_the_product(void **state)
{
    const struct experiment pc = at("pc4", 500), controller = at("tgmcontroller", 500),
                            mini = at("tgmmini", 500);
    (void)state;
    assert_true(near(budget_us(&pc, 2500), 2.5));
    assert_true(near(budget_us(&controller, 2400), 8));
    assert_true(near(budget_us(&mini, 2400), 8));
}

static void the_table_shows_the_tightest_run(void **state)
{
    struct case_run *runs = calloc(EXPERIMENT_COUNT, sizeof *runs);
    struct budget_report table[BUDGETS_MOST];
    const struct case_file file = { .runs = runs, .profile = profile_find("pc4") };
    static const int ids[] = { EXPERIMENT_TRACED_250, EXPERIMENT_TRACED_500 };
    (void)state;
    assert_non_null(runs);
    assert_int_equal(budgets_report(&file, table), 0);
    for (unsigned i = 0; i < 2; i++) {
        struct case_run *run = &runs[ids[i]];
        struct audit_record *record = &run->result.evidence.audit;
        run->plan.experiment = at("pc4", i == 0 ? 250 : 500);
        run->ran = true;
        record->traced = true;
        record->functions[ENTRY_04] =
            (struct audit_function){ .calls = 9,
                                     .worst_instructions = i == 0 ? 5000 : 20000,
                                     .worst_cycle = 3 + i,
                                     .stack_bytes = 800 - i };
        record->functions[ENTRY_05] = (struct audit_function){
            .calls = 9, .worst_instructions = 50, .worst_cycle = 7, .stack_bytes = 100
        };
    }
    assert_int_equal(budgets_report(&file, table), 3);
    assert_string_equal(table[0].name, "Program_04");
    assert_true(near(table[0].worst, 20)); /* 40 % of 50 us, against 20 % of 25 us */
    assert_true(near(table[0].allowed, 50));
    assert_int_equal(table[0].cycle, 4);
    assert_int_equal(table[0].cycle_us, 500);
    assert_int_equal(table[0].instructions, 20000);
    assert_string_equal(table[1].name, "Program_05");
    assert_true(near(table[1].worst, 0.05));
    assert_string_equal(table[2].name, "stack");
    assert_true(near(table[2].worst, 800));
    assert_true(near(table[2].allowed, 65536));
    free(runs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_manuals_figures_depend_on_product_and_cycle),
        cmocka_unit_test(configured_periods_count),
        cmocka_unit_test(instructions_are_time_at_the_rate_of_the_product),
        cmocka_unit_test(the_table_shows_the_tightest_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
