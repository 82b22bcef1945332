/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/product.h"

#include <string.h>

static const uint32_t pc4_cycle_times[] = { 250, 500, 1000, 0 };

static const struct product products[] = {
    { .name = "pc4",
      .title = "TG Motion 4.21",
      .generation = 4,
      .plc_data_size = 192,
      .version = 421,
      .compatibility_id = 4033,
      .memory_id = 904,
      .cnc_id = 121,
      .max_servo = 256,
      .max_dio = 16,
      .max_interpolator = 3,
      .cycle_times_us = pc4_cycle_times,
      .default_cycle_us = 500,
      .program_period_us = { 10000, 5000, 1000 } },
    { .name = "pc5",
      .title = "TG Motion 5.02",
      .generation = 5,
      .plc_data_size = 168,
      .version = 502,
      .compatibility_id = 4034,
      .memory_id = 906,
      .cnc_id = 126,
      .max_servo = 256,
      .max_dio = 16,
      .max_interpolator = 3,
      .cycle_times_us = pc4_cycle_times,
      .default_cycle_us = 500,
      .program_period_us = { 10000, 5000, 1000 },
      .product_id = 1,
      .device_name = "PC-realtime" },
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

const char *entry_name(enum entry entry)
{
    return entry < ENTRY_COUNT ? entry_names[entry] : "?";
}
