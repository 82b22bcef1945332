/* SPDX-License-Identifier: GPL-2.0-or-later */
/* machine_fixture.h - what the tests of machine/ have in common: a loaded test module. */
#ifndef TESTS_MACHINE_FIXTURE_H
#define TESTS_MACHINE_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "image/image.h"
#include "machine/machine.h"

#if defined(__SANITIZE_ADDRESS__)
#define UNDER_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define UNDER_ADDRESS_SANITIZER 1
#endif
#endif
#ifndef UNDER_ADDRESS_SANITIZER
#define UNDER_ADDRESS_SANITIZER 0
#endif

#if UNDER_ADDRESS_SANITIZER
const char *__asan_default_options(void);
/* The machine takes these signals itself. */
const char *__asan_default_options(void)
{
    return "handle_segv=0:handle_sigbus=0:handle_sigfpe=0:handle_sigill=0:use_sigaltstack=0";
}
#endif

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define TEST_HANG_NS 40000000u

struct fixture {
    struct image *image;
    struct machine *machine;
    uint64_t *words; /* shared_words() */
};

/* tests/machine_modules/NAME, built; a name without an ending is that of a shared object */
static inline struct image *fixture_image(const char *name)
{
    char path[4096], why[IMAGE_WHY] = "";
    struct image *image = NULL;

    snprintf(path, sizeof path, "%s/%s%s", TEST_MACHINE_MODULES_DIR, name,
             strchr(name, '.') == NULL ? ".so" : "");
    if (image_open(&image, path, why) != 0)
        fail_msg("%s: %s", path, why);
    assert_string_equal(image->defect, "");
    return image;
}

static inline void fixture_open(struct fixture *fixture, const char *name,
                                const struct machine_config *config)
{
    char why[MACHINE_WHY] = "";

    fixture->image = fixture_image(name);
    if (machine_load(&fixture->machine, fixture->image, config, why) != 0)
        fail_msg("machine_load: %s", why);
}

static inline void fixture_close(struct fixture *fixture)
{
    machine_unload(fixture->machine);
    image_close(fixture->image);
    fixture->words = NULL;
}

/* Module address of an exported symbol or label. */
static inline uint64_t at(const struct fixture *fixture, const char *name)
{
    const struct image_symbol *symbol = image_export(fixture->image, name);

    if (symbol == NULL)
        fail_msg("test module has no %s", name);
    return symbol->vaddr;
}

/* Where it runs. */
static inline void *place(const struct fixture *fixture, const char *name)
{
    return machine_address(fixture->machine, at(fixture, name));
}

static inline struct machine_outcome call(const struct fixture *fixture, const char *function,
                                          void *argument)
{
    const uint64_t vaddr = at(fixture, function);
    const bool thumb = image_export(fixture->image, function)->thumb;
    struct machine_outcome outcome;

    memset(&outcome, 0xee, sizeof outcome);
    machine_call(fixture->machine, vaddr | thumb, argument, &outcome);
    return outcome;
}

static inline void *map(const struct fixture *fixture, const char *name, size_t size,
                        enum machine_region_access access, void **host)
{
    void *module = NULL, *unused;
    char why[MACHINE_WHY] = "";

    if (machine_map(fixture->machine, name, size, access, host != NULL ? host : &unused, &module,
                    why) != 0)
        fail_msg("machine_map: %s", why);
    return module;
}

/* A page that the module can reach, the same until the fixture is closed. */
static inline uint64_t *shared_words(struct fixture *fixture)
{
    if (fixture->words == NULL)
        fixture->words = map(fixture, "words", 4096, MACHINE_REGION_READ_WRITE, NULL);
    return fixture->words;
}

static const struct machine_config plain_config = { .seed = 1, .hang_ns = TEST_HANG_NS };

static struct fixture the_fixture;
static enum machine_kind fixture_kind; /* of the machines that opened() makes */

/* Called by the test itself, not by its set-up: cmocka puts its own signal handlers in between. */
static inline struct fixture *opened(const char *module)
{
    struct machine_config config = plain_config;

    config.kind = fixture_kind;
    fixture_open(&the_fixture, module, &config);
    return &the_fixture;
}

static inline int close_fixture(void **state)
{
    (void)state;
    fixture_close(&the_fixture);
    memset(&the_fixture, 0, sizeof the_fixture);
    return 0;
}

#endif
