/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * product.h - the TG Motion products the host can be: identities, limits, allowed periods, the
 * schedule they keep.
 *
 * One row per product; adding a product is adding a row in product.c. What no document says of a
 * product is decided in docs/decisions.md (R4, R5, R15).
 */
#ifndef HARNESS_HOST_PRODUCT_H
#define HARNESS_HOST_PRODUCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum schedule_kind {
    SCHEDULE_PC,        /* slots of a fifth or a tenth of Cycle_Time */
    SCHEDULE_CONTROLLER /* one working slot a Cycle_Time, and ticks beside it */
};

/* What may be configured as the period of one of Program_01..03. */
struct period_rule {
    uint32_t least_us, most_us; /* most 0: no limit; both 0: only the value 0 */
    uint32_t step_us;           /* a multiple of it; 0: any */
    bool may_be_off;            /* 0 turns the function off; else 0 means as fast as possible */
};

/* What the manual lets the functions take. 0: no figure is given. */
struct product_budget {
    uint32_t background_percent; /* Program_01..03: of their own period */
    uint32_t program_04_percent; /* of Cycle_Time */
    uint32_t program_05_us;
    /* What a call costs is counted in instructions, the same on every machine; so many of them are
     * taken for a microsecond of the product's processor (decision H10). */
    uint32_t instructions_per_us;
};

enum entry { ENTRY_INI, ENTRY_01, ENTRY_02, ENTRY_03, ENTRY_04, ENTRY_05, ENTRY_COUNT };

struct product {
    const char *name;       /* "pc4" */
    const char *title;      /* "TG Motion 4.21" */
    uint32_t plc_data_size; /* structSize of a 64-bit module; of a 32-bit one half */
    int generation;         /* of the PLC interface and of the layouts */
    uint32_t version;       /* MAIN.TGMotion_Version */
    uint32_t compatibility_id, memory_id, cnc_id; /* HEADER; runtime.md section 1 */
    unsigned max_servo, max_dio, max_interpolator;
    const uint32_t *cycle_times_us; /* allowed Cycle_Time, ascending, ends with 0 */
    uint32_t default_cycle_us;
    enum schedule_kind schedule;
    /* Program_01..03 are called at multiples of it; 0: in what is left of any slot. */
    uint32_t tick_us;
    /* With ticks: a call that is due sooner than this after the last one ended moves by a tick. */
    uint32_t margin_us;
    struct period_rule periods[3]; /* of Program_01..03 */
    uint32_t program_period_us[3]; /* unless configured (decision C2) */
    struct product_budget budget;
    unsigned entries; /* functions that a module must export: 6, or 5 without Program_05 */
    /* TGM_Oscilloscope, bytes: unless configured, and from where to where it may be. */
    uint32_t osc_bytes, osc_least, osc_most;
    bool text8;              /* text of the module API: UTF-8, else UTF-16 */
    unsigned can_buffer;     /* CAN telegrams that wait to be sent, at most; 0 is 1 */
    uint32_t product_id;     /* HEADER.Product_Id of 5.02 */
    const char *device_name; /* what pcGetDeviceInfo_v returns; NULL: it has none */
    const char *ini_name;    /* what its configuration file is called */
};

/* TGM_Data, bytes: unless configured, and from where to where it may be (decision C2). */
enum { DATA_BYTES = 524288, DATA_LEAST = 65536, DATA_MOST = 16777216 };

/* Product by name, NULL when there is none; by index, NULL past the end. */
const struct product *product_find(const char *name);
const struct product *product_at(size_t index);
bool product_allows_cycle(const struct product *product, uint32_t cycle_us);
/* Whether Program_01 + which may have the period. */
bool product_allows_period(const struct product *product, unsigned which, uint32_t period_us);
/* The allowed values in words: "250, 500 or 1000", "100 or more", "0, or a multiple of 200". */
void product_cycles_text(const struct product *product, char *out, size_t size);
void product_periods_text(const struct product *product, unsigned which, char *out, size_t size);

/* "Program_Ini", "Program_01" ...: the name a module exports for the entry. */
const char *entry_name(enum entry entry);

#endif
