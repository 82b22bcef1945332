/* SPDX-License-Identifier: GPL-2.0-or-later */
/* bench_bus - nanoseconds of one bus cycle: SOEM, segment, slave controllers and axis models, as
 * the host drives them. Best of several rounds, because the machine is shared. */
#define _POSIX_C_SOURCE 200809L
#include "bus/bus.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { ROUNDS = 9, CYCLES = 20000, WARM_UP = 50 };

static double wall_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static struct bus *bus;
static uint64_t now;

static void cycle(uint32_t cycle_ns)
{
    bus_receive(bus, now);
    now += cycle_ns / 5;
    bus_send(bus, now);
    now += cycle_ns - cycle_ns / 5;
}

/* All drives enabled in CSP and moving slowly, so that nothing is skipped. */
static void enable(size_t slaves, uint32_t cycle_ns)
{
    bus_request_op(bus);
    now = bus_now(bus);
    for (unsigned i = 0; i < WARM_UP; i++) {
        for (size_t s = 0; s < slaves; s++) {
            int64_t at = bus_entry_sign(bus_find(bus, s, BUS_INPUT, 0x6064, 0));

            bus_entry_set(bus_find(bus, s, BUS_OUTPUT, 0x6040, 0), i < 20 ? 6 : i < 30 ? 7 : 15);
            bus_entry_set(bus_find(bus, s, BUS_OUTPUT, 0x607a, 0), (uint64_t)(at + 100));
        }
        cycle(cycle_ns);
    }
}

static void measure(const char *what, const struct bus_device *devices, size_t count,
                    uint32_t cycle_ns)
{
    struct bus_config config = {
        .devices = devices, .device_count = count, .cycle_ns = cycle_ns, .seed = 1
    };
    char why[BUS_WHY];
    double best = 1e18;

    if (bus_open(&bus, &config, why)) {
        fprintf(stderr, "%s: %s\n", what, why);
        exit(1);
    }
    enable(count, cycle_ns);
    for (unsigned r = 0; r < ROUNDS; r++) {
        double start = wall_ns(), took;

        for (unsigned i = 0; i < CYCLES; i++)
            cycle(cycle_ns);
        took = (wall_ns() - start) / CYCLES;
        best = took < best ? took : best;
    }
    printf("%-18s %5" PRIu32 " us  %7.0f ns/cycle\n", what, cycle_ns / 1000, best);
    bus_close(bus);
}

int main(void)
{
    static const struct bus_device drive = { .type = "drive-cia402" };
    static const struct bus_device mixed[] = { { .type = "drive-cia402" }, { .type = "dio-8x8" } };
    struct bus_device drives[32];
    static const uint32_t cycles[] = { 250000, 1000000 };

    for (size_t i = 0; i < 32; i++)
        drives[i] = drive;
    for (size_t i = 0; i < 2; i++) {
        measure("1 drive + 1 dio", mixed, 2, cycles[i]);
        measure("8 drives", drives, 8, cycles[i]);
        measure("32 drives", drives, 32, cycles[i]);
    }
    return 0;
}
