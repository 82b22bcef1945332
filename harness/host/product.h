/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * product.h - the TG Motion products the host can be: identities, limits, allowed periods.
 *
 * One row per product; adding a product is adding a row in product.c.
 */
#ifndef HARNESS_HOST_PRODUCT_H
#define HARNESS_HOST_PRODUCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum entry { ENTRY_INI, ENTRY_01, ENTRY_02, ENTRY_03, ENTRY_04, ENTRY_05, ENTRY_COUNT };

struct product {
    const char *name;                             /* "pc4" */
    const char *title;                            /* "TG Motion 4.21" */
    uint32_t plc_data_size;                       /* structSize of a 64-bit module */
    int generation;                               /* of the PLC interface and of the layouts */
    uint32_t version;                             /* MAIN.TGMotion_Version */
    uint32_t compatibility_id, memory_id, cnc_id; /* HEADER; runtime.md section 1 */
    unsigned max_servo, max_dio, max_interpolator;
    const uint32_t *cycle_times_us; /* allowed Cycle_Time, ascending, ends with 0 */
    uint32_t default_cycle_us;
    uint32_t program_period_us[3]; /* Program_01..03 unless configured (decision C2) */
    bool text8;                    /* text of the module API: UTF-8, else UTF-16 */
    unsigned can_buffer;           /* CAN telegrams that wait to be sent, at most; 0 is 1 */
    uint32_t product_id;           /* HEADER.Product_Id of 5.02 */
    const char *device_name;       /* what pcGetDeviceInfo_v returns */
};

/* Product by name, NULL when there is none; by index, NULL past the end. */
const struct product *product_find(const char *name);
const struct product *product_at(size_t index);
bool product_allows_cycle(const struct product *product, uint32_t cycle_us);

/* "Program_Ini", "Program_01" ...: the name a module exports for the entry. */
const char *entry_name(enum entry entry);

#endif
