/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * bench MODULE - what the harness costs, on this machine, in this run.
 *
 * Times are the best of several rounds: the machine is shared and only the best is repeatable.
 * Ratios of one run can be compared between machines, nanoseconds cannot.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "conformance/check.h"

enum { ROUNDS = 5, SIMULATED_S = 20 };

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Wall seconds of an experiment of the module: best of the rounds. */
static double run_once(const struct image *image, uint32_t cycle_us, uint64_t cycles,
                       bool without_bus)
{
    const struct experiment experiment = {
        .name = "bench",
        .host = { .product = product_find("pc4"),
                  .cycle_us = cycle_us,
                  .seed = 1,
                  .plant = &plant_default,
                  .without_bus = without_bus },
        .cycles = cycles,
    };
    static struct experiment_result result;
    double best = 1e9;
    for (int i = 0; i < ROUNDS; i++) {
        const double begin = seconds();
        const int r = experiment_run(&experiment, image, NULL, NULL, NULL, &result);
        const double took = seconds() - begin;
        if (r != 0 || result.evidence.cycles_done != cycles ||
            result.evidence.incident_count != 0) {
            fprintf(stderr, "bench: the module did not run through: %s\n", result.evidence.trouble);
            exit(2);
        }
        best = took < best ? took : best;
    }
    return best;
}

static void bench_machine(const struct image *image)
{
    static const uint32_t cycles_us[] = { 250, 500, 1000 };
    printf("machine of the template, %d s of machine time\n", SIMULATED_S);
    printf("  %-10s %22s %16s %16s\n", "Cycle_Time", "simulated s / wall s", "whole cycle",
           "of it the bus");
    for (size_t i = 0; i < 3; i++) {
        const uint64_t cycles = SIMULATED_S * UINT64_C(1000000) / cycles_us[i];
        const double start = run_once(image, cycles_us[i], 1, false);
        const double whole = run_once(image, cycles_us[i], cycles, false);
        const double bare = run_once(image, cycles_us[i], cycles, true);
        printf("  %6u us  %22.0f %13.0f ns %13.0f ns\n", cycles_us[i], SIMULATED_S / whole,
               (whole - start) / (double)cycles * 1e9, (whole - bare) / (double)cycles * 1e9);
    }
    printf("  worker, load, bus from power-up to SAFEOP: %.1f ms\n",
           run_once(image, 500, 1, false) * 1e3);
}

/* Most memory that a worker had so far, MiB. */
static double worker_memory(void)
{
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return (double)used.ru_maxrss / 1024;
}

/* A machine of some size for an hour: whether long runs are fit for every day, and whether memory
 * stays what it was after a minute. */
static void bench_hour(const struct image *image)
{
    static const struct bus_device devices[] = {
        { .type = "drive-cia402" }, { .type = "drive-cia402" }, { .type = "drive-cia402" },
        { .type = "drive-cia402" }, { .type = "drive-cia402" }, { .type = "drive-cia402" },
        { .type = "drive-cia402" }, { .type = "drive-cia402" }, { .type = "dio-8x8" },
        { .type = "dio-8x8" },      { .type = "dio-8x8" },      { .type = "dio-8x8" },
    };
    static const struct plant plant = { .devices = devices, .device_count = 12, .as_found = true };
    static const unsigned minutes[] = { 1, 60 };
    static struct experiment_result result;
    printf("8 drives, 4 terminals, 500 us, the template\n");
    for (size_t i = 0; i < sizeof minutes / sizeof minutes[0]; i++) {
        const struct experiment experiment = {
            .name = "hour",
            .host = { .product = product_find("pc4"), .cycle_us = 500, .seed = 1, .plant = &plant },
            .cycles = minutes[i] * UINT64_C(60) * 2000,
        };
        const double begin = seconds();
        const int r = experiment_run(&experiment, image, NULL, NULL, NULL, &result);
        const double took = seconds() - begin;
        if (r != 0 || result.evidence.cycles_done != experiment.cycles ||
            result.evidence.incident_count != 0 || !result.evidence.all_op) {
            fprintf(stderr, "bench: the hour was not run through: %s\n", result.evidence.trouble);
            exit(2);
        }
        printf("  %2u min of machine time: %6.2f s, %.1f MiB\n", minutes[i], took, worker_memory());
    }
}

/* The static phase on the module as it is, and padded to 1 MiB. */
static void bench_static(const char *path)
{
    char why[IMAGE_WHY];
    struct image *image;
    if (image_open(&image, path, why) != 0) {
        fprintf(stderr, "bench: %s\n", why);
        exit(2);
    }
    const size_t size = 1 << 20;
    uint8_t *bytes = calloc(1, size);
    memcpy(bytes, image->bytes, image->size < size ? image->size : size);
    image_close(image);
    double best = 1e9;
    for (int i = 0; i < ROUNDS * 4; i++) {
        const double begin = seconds();
        if (image_open_memory(&image, path, bytes, size, why) != 0 || image->defect[0] != '\0') {
            fprintf(stderr, "bench: %s\n", image->defect);
            exit(2);
        }
        const double took = seconds() - begin;
        best = took < best ? took : best;
        image_close(image);
    }
    free(bytes);
    printf("static phase of a 1 MiB module: %.2f ms\n", best * 1e3);
}

static void bench_check(const char *path)
{
    char why[CHECK_WHY];
    struct check *check;
    const struct check_options options = {
        .path = path, .tool = "bench", .profile = profile_find("pc4"), .seed = 1
    };
    const double begin = seconds();
    if (check_run(&check, &options, why) != 0) {
        fprintf(stderr, "bench: %s\n", why);
        exit(2);
    }
    printf("whole check: %.2f s (%u rules)\n", seconds() - begin, check_report(check)->passed);
    check_free(check);
}

int main(int argc, char **argv)
{
    char why[IMAGE_WHY];
    struct image *image;
    if (argc != 2 || image_open(&image, argv[1], why) != 0) {
        fprintf(stderr, "usage: bench MODULE.tgm\n");
        return 2;
    }
    bench_machine(image);
    bench_hour(image);
    image_close(image);
    bench_static(argv[1]);
    bench_check(argv[1]);
    return 0;
}
