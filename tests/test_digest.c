/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_digest.c - runs under other conditions, and what two runs are compared by. */
#include "tests/host_rig.h"

#include "host/digest.h"
#include "host/experiment.h"

enum { CYCLES = 200 };

static const char *const layouts[] = { "pc4", "pc500", "pc5" };

static const char *module_of(const char *product)
{
    return strcmp(product, "pc4") == 0     ? TEST_HOST_MODULES_DIR "/varies_4.tgm"
           : strcmp(product, "pc500") == 0 ? TEST_HOST_MODULES_DIR "/varies_905.tgm"
                                           : TEST_HOST_MODULES_DIR "/varies_906.tgm";
}

static struct experiment usual(const char *product)
{
    return (struct experiment){ .name = "test",
                                .host = { .product = product_find(product),
                                          .plant = &plant_default,
                                          .cycle_us = 500,
                                          .seed = 5,
                                          .digest_cycles = CYCLES },
                                .cycles = CYCLES };
}

static struct evidence *run(const struct experiment *experiment)
{
    static struct experiment_result results[2];
    static int turn;
    struct experiment_result *result = &results[turn++ % 2];
    struct image *image;
    char why[IMAGE_WHY];
    assert_int_equal(image_open(&image, module_of(experiment->host.product->name), why), 0);
    assert_int_equal(experiment_run(experiment, image, NULL, NULL, NULL, result), 0);
    image_close(image);
    assert_string_equal(result->evidence.trouble, "");
    assert_int_equal(result->worker.end, WORKER_DONE);
    assert_int_equal(result->evidence.digest.state_count, CYCLES);
    return &result->evidence;
}

static bool differ(const struct experiment *a, const struct experiment *b,
                   struct digest_difference *difference)
{
    const struct product *product = a->host.product;
    const struct evidence *first = run(a), *second = run(b);
    return digest_differ(catalogue_find(product->generation, (int)product->memory_id),
                         &first->digest, &second->digest, difference);
}

static void the_same_run_has_the_same_digest(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        const struct experiment a = usual(layouts[i]);
        struct digest_difference difference;
        assert_false(differ(&a, &a, &difference));
    }
}

static void other_globals_name_the_register_and_the_cycle(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        const struct experiment a = usual(layouts[i]);
        struct experiment b = a;
        struct digest_difference difference;
        b.poison = MACHINE_POISON_ZERO;
        assert_true(differ(&a, &b, &difference));
        assert_true(difference.early);
        /* Program_Ini leaves behind what the other global was. */
        assert_true(difference.cycle == EVIDENCE_NO_CYCLE);
        assert_true(difference.exact);
        assert_string_equal(difference.name, "byte 0 of TGM_Data");
        assert_int_equal(difference.line_count, 2);
    }
}

static void other_places_name_the_byte_and_the_cycle(void **state)
{
    (void)state;
    const struct experiment a = usual("pc4");
    struct experiment b = a;
    struct digest_difference difference;
    b.places = 1;
    assert_true(differ(&a, &b, &difference));
    assert_true(difference.cycle == 60);
    assert_true(difference.exact);
    assert_string_equal(difference.name, "byte 8 of TGM_Data");
    assert_string_equal(difference.memory, "TGM_Data");
}

/* The last word that a module may write. */
static uint32_t last_global(enum machine_poison poison)
{
    const struct machine_config config = { .seed = 1, .poison = poison };
    struct machine *machine;
    struct image *image;
    uint64_t end = 0;
    uint32_t word;
    char why[MACHINE_WHY];
    assert_int_equal(image_open(&image, module_of("pc4"), why), 0);
    assert_int_equal(machine_load(&machine, image, &config, why), 0);
    for (size_t i = 0; i < image->segment_count; i++)
        if (image->segments[i].perm & IMAGE_WRITE)
            end = image->segments[i].vaddr + image->segments[i].mem_size;
    memcpy(&word, machine_address(machine, end - sizeof word), sizeof word);
    machine_unload(machine);
    image_close(image);
    return word;
}

static void globals_are_seeded_inverted_or_zero(void **state)
{
    const uint32_t seeded = last_global(MACHINE_POISON_SEEDED);
    (void)state;
    assert_int_not_equal(seeded, 0);
    assert_int_equal(last_global(MACHINE_POISON_INVERTED), ~seeded);
    assert_int_equal(last_global(MACHINE_POISON_ZERO), 0);
}

static void differences_are_made_and_found(void **state)
{
    static struct digest a, b;
    const struct catalogue *catalogue = catalogue_find(4, 0);
    struct catalogue_register reg;
    struct digest_difference difference;
    char why[CATALOGUE_WHY];
    size_t memory = 0;
    (void)state;
    assert_int_equal(catalogue_resolve(catalogue, "SERVO[17].Pg.Acc", &reg, why), 0);
    while (catalogue_memory(catalogue, memory) != reg.memory)
        memory++;
    a.state_count = b.state_count = 3;
    assert_false(digest_differ(catalogue, &a, &b, &difference));
    digest_change(&b, &b.states[1], 7, digest_unit(memory, reg.offset), 1, 2);
    assert_true(digest_differ(catalogue, &a, &b, &difference));
    assert_true(difference.exact);
    assert_true(difference.cycle == 0);
    assert_string_equal(difference.name, "SERVO[17].Pg.Acc");
    /* Two at once: no unit is known, but the line of the trail is. */
    digest_change(&b, &b.states[1], 7, digest_unit(memory, reg.offset + 8), 1, 2);
    assert_true(digest_differ(catalogue, &a, &b, &difference));
    assert_false(difference.exact);
    assert_int_equal(difference.line_count, 1);
    assert_string_not_equal(difference.name, "");
}

static void a_run_again_keeps_the_globals_of_a_module_that_is_not_loaded_again(void **state)
{
    (void)state;
    for (int kept = 0; kept < 2; kept++) {
        const struct host_config config = { .without_bus = true, .kept_module = kept != 0 };
        struct rig *rig = rig_open("varies", &config);
        rig_start(rig);
        rig_cycles(rig, 2);
        const uint32_t before = (uint32_t)rig_get(rig, "DATA.U32[0]");
        host_run(rig->host);
        rig_cycles(rig, 4000);
        assert_int_equal(rig->evidence.loads, 1);
        assert_int_equal((uint32_t)rig_get(rig, "DATA.U32[0]"), before + (uint32_t)kept);
        rig_close(rig);
    }
}

static void counters_begin_where_they_are_told_to_and_wrap(void **state)
{
    const struct host_config config = { .without_bus = true, .counters = UINT32_MAX - 4 };
    struct rig *rig = rig_open("varies", &config);
    (void)state;
    rig_start(rig);
    rig_cycles(rig, 2);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == UINT32_MAX - 2);
    rig_cycles(rig, 10);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == 7);
    assert_true(rig_get(rig, "HEADER.Life_Tick") == 7);
    assert_true(rig_get(rig, "TIMERS.Timer_Up[63]") == 0);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_run_has_the_same_digest),
        cmocka_unit_test(other_globals_name_the_register_and_the_cycle),
        cmocka_unit_test(other_places_name_the_byte_and_the_cycle),
        cmocka_unit_test(globals_are_seeded_inverted_or_zero),
        cmocka_unit_test(differences_are_made_and_found),
        cmocka_unit_test(a_run_again_keeps_the_globals_of_a_module_that_is_not_loaded_again),
        cmocka_unit_test(counters_begin_where_they_are_told_to_and_wrap),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
