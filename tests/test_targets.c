/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * test_targets.c - one source, built for every target, does the same: each register that a module
 * may write, cycle by cycle, each byte of every memory at the end, and each message are those of
 * the ELF64 module, which runs natively.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include <math.h>

#include "host/experiment.h"

enum { CYCLES = 2000 };

/* Of reals that an x87 computes with the precision of a double: its exponents have more room. */
#define X87_TOLERANCE 1e-12

struct target {
    const char *name, *product, *layout, *suffix;
    bool native;
};

static const struct target targets[] = {
    { "pe64", "pc4", "4", "", true },
    { "pe64", "pc500", "905", "", true },
    { "pe64", "pc5", "906", "", true },
    { "pe32", "pc4", "4", "", false },
    { "pe32", "pc500", "905", "", false },
    { "pe32", "pc5", "906", "", false },
    { "tgmmini", "tgmmini", "906_text8", "", false },
    { "tgmcontroller", "tgmcontroller", "906_text8", ".bin", false },
    { "tgmcontroller", "tgzmotion", "906_text8", ".bin", false },
};

/* Of tests/host_modules, and where Program_05 matters: it is not in the table that GetProcAddress
 * of a flat image returns, and only the controllers do without. */
static const struct {
    const char *name;
    enum { EVERYWHERE, WHERE_05_IS_CALLED, WHERE_05_MAY_LACK } where;
} modules[] = {
    { "asks", EVERYWHERE },        { "control", WHERE_05_IS_CALLED },
    { "correct", EVERYWHERE },     { "echo", EVERYWHERE },
    { "idle", EVERYWHERE },        { "race", EVERYWHERE },
    { "talks", EVERYWHERE },       { "tells", EVERYWHERE },
    { "five", WHERE_05_MAY_LACK },
};

static bool fits(size_t module, const struct target *target)
{
    const bool calls_05 = product_find(target->product)->entries == ENTRY_COUNT;
    return modules[module].where == EVERYWHERE ||
           (modules[module].where == WHERE_05_IS_CALLED) == calls_05;
}

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static struct experiment_result reference, result;

static void run(const char *path, const struct target *target, bool instrumented,
                struct experiment_result *to)
{
    char why[IMAGE_WHY];
    struct image *image;
    const struct product *product = product_find(target->product);
    const struct experiment experiment = {
        .name = "targets",
        .host = { .product = product,
                  .cycle_us = product->default_cycle_us,
                  .seed = 1,
                  .plant = &plant_default,
                  .digest_cycles = CYCLES },
        .cycles = CYCLES,
        .poison = MACHINE_POISON_ZERO, /* what globals hold lies elsewhere */
        .instrumented = instrumented
    };
    if (image_open(&image, path, why) != 0)
        fail_msg("%s: %s", path, why);
    assert_string_equal(image->defect, "");
    /* The name is in MAIN.PLC_Name. */
    image->path[strlen(image->path) - strlen(target->suffix)] = '\0';
    assert_int_equal(experiment_run(&experiment, image, NULL, NULL, NULL, to), 0);
    if (to->evidence.trouble[0] != '\0' || to->worker.end != WORKER_DONE)
        fail_msg("%s: %s%s (%d %lld) in cycle %llu", path, to->evidence.trouble, to->worker.reason,
                 (int)to->worker.end, (long long)to->worker.value,
                 (unsigned long long)to->evidence.cycle);
    for (unsigned i = 0; i < to->evidence.incident_count; i++)
        fail_msg("%s: %s: signal %d at 0x%llx, %s+%lld", path,
                 entry_name(to->evidence.incidents[i].entry),
                 to->evidence.incidents[i].fault.signal,
                 (unsigned long long)to->evidence.incidents[i].fault.pc,
                 to->evidence.incidents[i].fault.region,
                 (long long)to->evidence.incidents[i].fault.region_offset);
    image_close(image);
}

static void path_of(char path[512], const char *module, const struct target *target)
{
    snprintf(path, 512, "%s/%s/%s_%s.tgm%s", TEST_TARGETS_DIR, target->name, module, target->layout,
             target->suffix);
}

static void reference_path(char path[512], const char *module, const struct target *target)
{
    snprintf(path, 512, "%s/%s_%s.tgm", TEST_HOST_MODULES_DIR, module, target->layout);
}

static void assert_same_messages(const char *path)
{
    const struct evidence *a = &reference.evidence, *b = &result.evidence;
    assert_int_equal(a->message_count, b->message_count);
    for (uint64_t i = 0; i < a->message_count && i < EVIDENCE_MESSAGES; i++) {
        if (strcmp(a->messages[i].text, b->messages[i].text) != 0)
            fail_msg("%s says '%s', not '%s'", path, b->messages[i].text, a->messages[i].text);
        assert_int_equal(a->messages[i].cycle, b->messages[i].cycle);
        assert_int_equal(a->messages[i].severity, b->messages[i].severity);
        assert_int_equal(a->messages[i].entry, b->messages[i].entry);
    }
}

static void assert_same(const char *path, const struct target *target)
{
    const struct product *product = product_find(target->product);
    struct digest_difference difference;
    assert_int_equal(result.evidence.incident_count, 0);
    assert_int_equal(result.evidence.stage, EVIDENCE_FINISHED);
    assert_int_equal(reference.evidence.stage, EVIDENCE_FINISHED);
    assert_int_equal(result.evidence.cycles_done, reference.evidence.cycles_done);
    for (unsigned i = 0; i < product->entries; i++) { /* GetProcAddress hands out no Program_05 */
        assert_int_equal(result.evidence.calls[i].count, reference.evidence.calls[i].count);
        assert_int_equal(result.evidence.calls[i].last_value,
                         reference.evidence.calls[i].last_value);
    }
    assert_int_equal(result.evidence.digest.state_count, CYCLES);
    if (digest_differ(catalogue_find(product->generation, (int)product->memory_id),
                      &reference.evidence.digest, &result.evidence.digest, &difference))
        fail_msg("%s as %s: cycle %llu %s %s, %zu lines", path, target->product,
                 (unsigned long long)difference.cycle, difference.name, difference.memory,
                 difference.line_count);
    assert_same_messages(path);
}

static void every_target_does_what_elf64_does(void **state)
{
    char path[512];
    const struct target *target = *state;
    for (size_t m = 0; m < COUNT(modules); m++) {
        if (!fits(m, target))
            continue;
        struct target elf64 = *target;
        elf64.suffix = "";
        reference_path(path, modules[m].name, target);
        run(path, &elf64, false, &reference);
        assert_false(reference.evidence.instrumented);
        path_of(path, modules[m].name, target);
        run(path, target, false, &result);
        assert_int_equal(result.evidence.instrumented, !target->native);
        assert_same(path, target);
    }
}

static void the_emulated_cpu_does_what_the_real_one_does(void **state)
{
    static const struct target pc4 = { "elf64", "pc4", "4", "", true };
    static const struct target pe64 = { "pe64", "pc4", "4", "", true };
    char path[512];
    (void)state;
    for (size_t m = 0; m < COUNT(modules); m++) {
        if (!fits(m, &pc4))
            continue;
        reference_path(path, modules[m].name, &pc4);
        run(path, &pc4, false, &reference);
        run(path, &pc4, true, &result);
        assert_true(result.evidence.instrumented);
        assert_same(path, &pc4);
        path_of(path, modules[m].name, &pe64);
        run(path, &pe64, true, &result);
        assert_true(result.evidence.instrumented);
        assert_same(path, &pe64);
    }
}

/* --- x87 --- */

enum { REALS = 8 }; /* of tells.c, behind as many whole numbers */

static double rows[2][CYCLES][1 + 2 * REALS];
static size_t row_count[2];

static void keep(void *argument, const struct evidence *evidence, const double *from, size_t count)
{
    const size_t which = *(const size_t *)argument;
    (void)evidence;
    for (size_t i = 0; i < count; i++)
        memcpy(rows[which][row_count[which]++], from + i * (1 + 2 * REALS), sizeof rows[0][0]);
}

static void record(const char *path, size_t which)
{
    const struct target *target = &targets[3];
    struct catalogue_register registers[2 * REALS];
    char name[64], why[IMAGE_WHY];
    struct image *image;
    const struct experiment experiment = { .name = "x87",
                                           .host = { .product = product_find(target->product),
                                                     .cycle_us = 500,
                                                     .seed = 1,
                                                     .plant = &plant_default },
                                           .cycles = CYCLES };
    const struct recording recording = { registers, 2 * REALS, 1, NULL };
    for (unsigned i = 0; i < 2 * REALS; i++) {
        snprintf(name, sizeof name, i < REALS ? "DATA.I32[%u]" : "DATA.F64[%u]", 8 * i);
        assert_int_equal(catalogue_resolve(catalogue_find(4, 904), name, &registers[i], why), 0);
    }
    assert_int_equal(image_open(&image, path, why), 0);
    row_count[which] = 0;
    assert_int_equal(experiment_run(&experiment, image, &recording, keep, &which, &result), 0);
    assert_string_equal(result.evidence.trouble, "");
    assert_int_equal(row_count[which], CYCLES);
    image_close(image);
}

static void an_x87_stays_within_the_stated_tolerance(void **state)
{
    const struct target *target = &targets[3];
    char path[512];
    double most = 0;
    (void)state;
    reference_path(path, "tells", target);
    record(path, 0);
    snprintf(path, sizeof path, "%s/pe32/tells_4_x87.tgm", TEST_TARGETS_DIR);
    record(path, 1);
    for (size_t i = 0; i < CYCLES; i++) {
        assert_memory_equal(rows[0][i], rows[1][i], (1 + REALS) * sizeof(double));
        for (size_t k = 1 + REALS; k < 1 + 2 * REALS; k++) {
            const double error = fabs(rows[1][i][k] - rows[0][i][k]) / fabs(rows[0][i][k]);
            most = error > most ? error : most;
        }
    }
    print_message("x87: largest relative difference %g\n", most);
    assert_true(most <= X87_TOLERANCE);
}

int main(void)
{
    struct CMUnitTest tests[COUNT(targets) + 2];
    char names[COUNT(targets)][128];
    for (size_t i = 0; i < COUNT(targets); i++) {
        snprintf(names[i], sizeof names[i], "every_target_does_what_elf64_does: %s as %s",
                 targets[i].name, targets[i].product);
        tests[i] = (struct CMUnitTest)cmocka_unit_test_prestate(every_target_does_what_elf64_does,
                                                                (void *)(uintptr_t)&targets[i]);
        tests[i].name = names[i];
    }
    tests[COUNT(targets)] =
        (struct CMUnitTest)cmocka_unit_test(the_emulated_cpu_does_what_the_real_one_does);
    tests[COUNT(targets) + 1] =
        (struct CMUnitTest)cmocka_unit_test(an_x87_stays_within_the_stated_tolerance);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
