/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * host_rig.h - the emulated TG Motion on the bench: a host around a module that does nothing (or
 * another one of tests/host_modules), cycles by hand, registers by their names in the catalogue.
 */
#ifndef TESTS_HOST_RIG_H
#define TESTS_HOST_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "host/catalogue.h"
#include "host/host.h"
#include "image/image.h"
#include "machine/machine.h"

#if defined(__SANITIZE_ADDRESS__)
#define RIG_UNDER_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define RIG_UNDER_ADDRESS_SANITIZER 1
#endif
#endif

#ifdef RIG_UNDER_ADDRESS_SANITIZER
const char *__asan_default_options(void);
/* The machine takes these signals itself. */
const char *__asan_default_options(void)
{
    return "handle_segv=0:handle_sigbus=0:handle_sigfpe=0:handle_sigill=0:use_sigaltstack=0";
}
#endif

struct rig {
    struct image *image;
    struct machine *machine;
    struct host *host;
    const struct catalogue *catalogue;
    struct evidence evidence;
};

/* A process holds one machine: what a failed test left open is closed by the next. */
static struct rig *rig_left;

static enum machine_kind rig_kind; /* of the machines that are opened */

static inline void rig_close(struct rig *rig)
{
    rig_left = NULL;
    if (rig->host)
        host_close(rig->host);
    if (rig->machine)
        machine_unload(rig->machine);
    if (rig->image)
        image_close(rig->image);
    free(rig);
}

/* The module in a file. `wanted` may leave product, cycle, seed and plant open: pc4, 500 us, 1,
 * plant_default. */
static inline struct rig *rig_open_file(const char *path, const struct host_config *wanted)
{
    struct rig *rig;
    struct host_config config = *wanted;
    char why[HOST_WHY];
    const struct machine_config machine = { .kind = rig_kind,
                                            .seed = 1,
                                            .poison = true,
                                            .hang_ns = 2000000000,
                                            .interruptible = wanted->preempt.mode != PREEMPT_NONE,
                                            .asides = true };

    if (rig_left)
        rig_close(rig_left);
    rig_left = rig = calloc(1, sizeof *rig);
    assert_non_null(rig);
    if (config.product == NULL)
        config.product = product_find("pc4");
    if (config.cycle_us == 0)
        config.cycle_us = 500;
    if (config.seed == 0)
        config.seed = 1;
    if (config.plant == NULL)
        config.plant = &plant_default;
    rig->catalogue = catalogue_find(config.product->generation, (int)config.product->memory_id);
    if (image_open(&rig->image, path, why) != 0)
        fail_msg("%s: %s", path, why);
    if (machine_load(&rig->machine, rig->image, &machine, why) != 0)
        fail_msg("%s: %s", path, why);
    if (host_open(&rig->host, &config, rig->machine, rig->image, &rig->evidence, why) != 0)
        fail_msg("%s", why);
    return rig;
}

/* The module tests/host_modules/<name>.c, built for the product's generation. */
static inline struct rig *rig_open(const char *module, const struct host_config *wanted)
{
    const struct product *product = wanted->product != NULL ? wanted->product : product_find("pc4");
    char path[512];

    snprintf(path, sizeof path, "%s/%s_%d%s.tgm", TEST_HOST_MODULES_DIR, module,
             product->generation == 4 ? 4 : (int)product->memory_id,
             product->text8 ? "_text8" : "");
    return rig_open_file(path, wanted);
}

static inline void rig_start(struct rig *rig)
{
    assert_true(host_start(rig->host));
}

static inline void rig_cycles(struct rig *rig, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        assert_true(host_cycle(rig->host));
}

/* Where the register lies, and what it is. */
static inline void *rig_at(const struct rig *rig, const char *name, struct catalogue_register *reg)
{
    char why[CATALOGUE_WHY];
    const void *at;

    if (catalogue_resolve(rig->catalogue, name, reg, why) != 0)
        fail_msg("%s", why);
    at = host_register(rig->host, reg);
    assert_non_null(at);
    return (void *)(uintptr_t)at;
}

static inline double rig_get(const struct rig *rig, const char *name)
{
    struct catalogue_register reg;
    const void *at = rig_at(rig, name, &reg);

    return scalar_get(reg.type, at);
}

static inline void rig_set(const struct rig *rig, const char *name, double value)
{
    struct catalogue_register reg;
    void *at = rig_at(rig, name, &reg);

    if (reg.type == F64) {
        memcpy(at, &value, sizeof value);
    } else if (reg.type == F32) {
        const float single = (float)value;

        memcpy(at, &single, sizeof single);
    } else {
        const int64_t whole = (int64_t)value;

        memcpy(at, &whole, scalar_size(reg.type));
    }
}

/* Cycles until the register has the value; fails after `most` cycles. */
static inline void rig_until(struct rig *rig, const char *name, double value, unsigned most)
{
    for (unsigned i = 0; i < most; i++) {
        if (rig_get(rig, name) == value)
            return;
        rig_cycles(rig, 1);
    }
    fail_msg("%s is %g, not %g, after %u cycles", name, rig_get(rig, name), value, most);
}

#endif
