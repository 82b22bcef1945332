/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_machine_stack.c - what image_routine() says a call takes against what the call took.
 */
#include "machine_fixture.h"

#include <stdlib.h>

#include "host/host_parts.h"

struct service_data {
    void *unused;
    void (*service)(void);
};

/* Takes nothing but its return address. */
__attribute__((naked)) static void quiet_service(void)
{
    __asm__("xorl %eax, %eax\n\tret");
}

static int64_t quiet_answer(void *context, struct arguments *arguments)
{
    (void)context, (void)arguments;
    return 0;
}

static size_t measured(const char *name)
{
    const struct machine_config config = { .kind = fixture_kind, .seed = 1 };
    struct fixture fixture;
    struct machine_outcome outcome;
    char why[MACHINE_WHY];
    void *host, *module;
    fixture_open(&fixture, "stack", &config);
    if (machine_map(fixture.machine, "data", sizeof(struct service_data), MACHINE_REGION_READ,
                    &host, &module, why) != 0)
        fail_msg("%s", why);
    void *service = (void *)(uintptr_t)quiet_service;
    if (fixture_kind == MACHINE_INSTRUMENTED &&
        machine_service(fixture.machine, "quiet", quiet_answer, NULL, &service, why) != 0)
        fail_msg("%s", why);
    *(struct service_data *)host =
        (struct service_data){ NULL, (void (*)(void))(uintptr_t)service };
    machine_call(fixture.machine, at(&fixture, name), module, &outcome);
    assert_int_equal(outcome.kind, MACHINE_RETURNED);
    const size_t used = machine_stack_used(fixture.machine);
    assert_int_equal(outcome.stack_bytes, fixture_kind == MACHINE_INSTRUMENTED ? used : 0);
    fixture_close(&fixture);
    return used;
}

static uint64_t bound(const struct image *image, const char *name)
{
    const struct image_routine *routine = image_routine(image, image_export(image, name)->vaddr);
    assert_int_equal(routine->limit, IMAGE_STACK_BOUNDED);
    return routine->stack;
}

static void a_call_takes_what_its_code_says(void **state)
{
    static const char *const exact[] = { "straight", "leaf",       "nested",        "deeper_way",
                                         "entered",  "tail",       "balanced_loop", "probed",
                                         "service",  "get_place",  "pointer",       "tail_loop",
                                         "far_jump", "byte_below", "segment",       "half_word" };
    (void)state;
    struct image *image = fixture_image("stack");
    for (size_t i = 0; i < COUNT(exact); i++) {
        const size_t used = measured(exact[i]);
        if (used != bound(image, exact[i]))
            fail_msg("%s took %zu bytes, its code says %llu", exact[i], used,
                     (unsigned long long)bound(image, exact[i]));
    }
    image_close(image);
}

static void a_call_takes_no_more_than_its_code_says(void **state)
{
    static const char *const at_most[] = { "framed", "table" };
    (void)state;
    struct image *image = fixture_image("stack");
    for (size_t i = 0; i < COUNT(at_most); i++)
        assert_in_range(measured(at_most[i]), 8, bound(image, at_most[i]));
    image_close(image);
}

/* ---- a real module ---- */

struct run {
    struct image *image;
    struct machine *machine;
    struct host *host;
    struct evidence *evidence;
};

static void start(struct run *run, enum mutation_kind mutation)
{
    const struct product *product = product_find("pc4");
    const struct machine_config machine = { .seed = 1, .poison = true };
    const struct host_config config = { .product = product,
                                        .cycle_us = product->default_cycle_us,
                                        .seed = 1,
                                        .plant = &plant_default,
                                        .mutation = { mutation, 1 } };
    char why[HOST_WHY] = "";
    run->evidence = calloc(1, sizeof *run->evidence);
    if (image_open(&run->image, TEST_TEMPLATE, why) != 0 ||
        machine_load(&run->machine, run->image, &machine, why) != 0 ||
        host_open(&run->host, &config, run->machine, run->image, run->evidence, why) != 0)
        fail_msg("%s", why);
    /* What the services take is not the module's. */
    for (int i = 0; i < ENTRY_COUNT; i++) {
        void (**services)(void) = (void *)(run->host->plc_data[i] + offsetof(PLC_DATA, functions));
        for (size_t k = 0; k < sizeof(PLC_IMPORT_FUNCTIONS) / sizeof(void *); k++)
            services[k] = quiet_service;
    }
}

static void end(struct run *run)
{
    host_close(run->host);
    machine_unload(run->machine);
    image_close(run->image);
    free(run->evidence);
}

static void the_template_takes_no_more_than_its_code_says(void **state)
{
    struct run run;
    uint64_t most = 0;
    (void)state;
    start(&run, MUTATION_NONE);
    assert_true(host_start(run.host));
    for (int i = 0; i < 4000; i++)
        assert_true(host_cycle(run.host));
    for (int i = 0; i < ENTRY_COUNT; i++) {
        const uint64_t one = bound(run.image, entry_name((enum entry)i));
        most = one > most ? one : most;
    }
    const size_t used = machine_stack_used(run.machine);
    print_message("template, 4000 cycles: %zu of at most %llu bytes\n", used,
                  (unsigned long long)most);
    assert_in_range(used, 100, most);
    end(&run);
}

/* The deepest way of the template: it reports why it does not start. */
static void the_template_that_refuses_to_start_comes_near_its_bound(void **state)
{
    struct run run;
    (void)state;
    start(&run, MUTATION_COMPATIBILITY);
    assert_false(host_start(run.host));
    const uint64_t most = bound(run.image, "Program_Ini");
    const size_t used = machine_stack_used(run.machine);
    print_message("template, wrong id: %zu of at most %llu bytes\n", used,
                  (unsigned long long)most);
    assert_in_range(used, most / 2, most);
    end(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_call_takes_what_its_code_says),
        cmocka_unit_test(a_call_takes_no_more_than_its_code_says),
        cmocka_unit_test(the_template_takes_no_more_than_its_code_says),
        cmocka_unit_test(the_template_that_refuses_to_start_comes_near_its_bound),
    };
    const struct CMUnitTest emulated[] = {
        cmocka_unit_test(a_call_takes_what_its_code_says),
        cmocka_unit_test(a_call_takes_no_more_than_its_code_says),
    };
    const int failed = cmocka_run_group_tests_name("stack, native", tests, NULL, NULL);
    fixture_kind = MACHINE_INSTRUMENTED;
    return failed + cmocka_run_group_tests_name("stack, instrumented", emulated, NULL, NULL);
}
