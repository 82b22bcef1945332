/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/product.h"

#include <stdio.h>
#include <string.h>

#define MIB 1048576u

static const uint32_t pc_cycle_times[] = { 250, 500, 1000, 0 };
static const uint32_t controller_cycle_times[] = { 100,  200,  250,  500,  1000, 2000,  3000, 4000,
                                                   5000, 6000, 7000, 8000, 9000, 10000, 0 };

/* What the products of a kind have in common, so that a row says what is its own. */
#define PC(rate)                                                                                   \
    .max_dio = 16, .cycle_times_us = pc_cycle_times, .default_cycle_us = 500,                      \
    .schedule = SCHEDULE_PC,                                                                       \
    .periods = { { 100, 0, 0, false }, { 100, 0, 0, false }, { 100, 0, 0, false } },               \
    .program_period_us = { 10000, 5000, 1000 }, .budget = { 20, 10, 10, rate }, .entries = 6

#define CONTROLLER                                                                                 \
    .max_servo = 64, .max_dio = 16, .max_interpolator = 3,                                         \
    .cycle_times_us = controller_cycle_times, .default_cycle_us = 500,                             \
    .schedule = SCHEDULE_CONTROLLER, .tick_us = 200, .margin_us = 100,                             \
    .periods = { { 0, 0, 0, false }, { 200, 0, 200, true }, { 200, 0, 200, true } },               \
    .program_period_us = { 0, 400, 800 }, .budget = { 0, 50, 0, 300 }, .entries = 5,                    \
    .osc_bytes = 32 * MIB, .osc_least = 32 * MIB, .osc_most = 32 * MIB, .text8 = true

#define LAYOUT_421                                                                                 \
    .generation = 4, .plc_data_size = 192, .version = 421, .compatibility_id = 4033,               \
    .memory_id = 904, .cnc_id = 121
#define LAYOUT_500                                                                                 \
    .generation = 5, .plc_data_size = 168, .version = 500, .compatibility_id = 4034,               \
    .memory_id = 905, .cnc_id = 123
#define LAYOUT_502                                                                                 \
    .generation = 5, .plc_data_size = 168, .version = 502, .compatibility_id = 4034,               \
    .memory_id = 906, .cnc_id = 126

static const struct product products[] = {
    { LAYOUT_421, PC(1000), .name = "pc4", .title = "TG Motion 4.21", .max_servo = 256,
      .max_interpolator = 3, .osc_bytes = MIB, .osc_least = MIB, .osc_most = 32 * MIB,
      .ini_name = "TGMotion4xx.ini" },
    { LAYOUT_500, PC(1000), .name = "pc500", .title = "TG Motion 5.00", .max_servo = 256,
      .max_interpolator = 3, .osc_bytes = 32 * MIB, .osc_least = 32 * MIB, .osc_most = 32 * MIB,
      .ini_name = "TgMotion5xx.ini" },
    { LAYOUT_502, PC(1000), .name = "pc5", .title = "TG Motion 5.02", .max_servo = 256,
      .max_interpolator = 3, .osc_bytes = 32 * MIB, .osc_least = 32 * MIB, .osc_most = 32 * MIB,
      .product_id = 1, .device_name = "PC-realtime", .ini_name = "TgMotion5xx.ini" },
    { LAYOUT_502, PC(300), .name = "tgmmini", .title = "TGMmini", .max_servo = 64, .max_interpolator = 2,
      .osc_bytes = MIB, .osc_least = MIB, .osc_most = 32 * MIB, .text8 = true, .product_id = 2,
      .can_buffer = 55,
      .device_name = "TGMmini", .ini_name = "TgMotion5xx.ini" },
    { LAYOUT_502, CONTROLLER, .name = "tgmcontroller", .title = "TGMcontroller", .product_id = 3,
      .device_name = "TGMcontroller", .ini_name = "TGM.INI" },
    { LAYOUT_502, CONTROLLER, .name = "tgzmotion", .title = "TGZ+Motion", .product_id = 4,
      .device_name = "TGZ+Motion", .ini_name = "TGM.INI" },
};

static const char *const entry_names[ENTRY_COUNT] = { "Program_Ini", "Program_01", "Program_02",
                                                      "Program_03",  "Program_04", "Program_05" };

const struct product *product_at(size_t index)
{
    return index < sizeof products / sizeof *products ? &products[index] : NULL;
}

const struct product *product_find(const char *name)
{
    for (size_t i = 0; i < sizeof products / sizeof *products; i++)
        if (strcmp(products[i].name, name) == 0)
            return &products[i];
    return NULL;
}

bool product_allows_cycle(const struct product *product, uint32_t cycle_us)
{
    for (const uint32_t *allowed = product->cycle_times_us; *allowed != 0; allowed++)
        if (*allowed == cycle_us)
            return true;
    return false;
}

bool product_allows_period(const struct product *product, unsigned which, uint32_t period_us)
{
    const struct period_rule *rule = &product->periods[which];
    if (period_us == 0)
        return rule->may_be_off || rule->least_us == 0;
    return rule->least_us != 0 && period_us >= rule->least_us &&
           (rule->most_us == 0 || period_us <= rule->most_us) &&
           (rule->step_us == 0 || period_us % rule->step_us == 0);
}

void product_cycles_text(const struct product *product, char *out, size_t size)
{
    size_t at = 0;
    out[0] = '\0';
    for (const uint32_t *allowed = product->cycle_times_us; *allowed != 0 && at < size; allowed++)
        at += (size_t)snprintf(out + at, size - at, "%s%u",
                               allowed == product->cycle_times_us ? ""
                               : allowed[1] == 0                  ? " or "
                                                                  : ", ",
                               *allowed);
}

void product_periods_text(const struct product *product, unsigned which, char *out, size_t size)
{
    const struct period_rule *rule = &product->periods[which];
    if (rule->least_us == 0)
        snprintf(out, size, "only 0 (as fast as possible)");
    else if (rule->step_us != 0)
        snprintf(out, size, "%smultiples of %u", rule->may_be_off ? "0 (off) and " : "",
                 rule->step_us);
    else
        snprintf(out, size, "%u or more", rule->least_us);
}

const char *entry_name(enum entry entry)
{
    return entry < ENTRY_COUNT ? entry_names[entry] : "?";
}
