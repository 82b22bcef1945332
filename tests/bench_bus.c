/* SPDX-License-Identifier: GPL-2.0-or-later */
/* bench_bus - nanoseconds of one bus cycle as the host drives it: SOEM sends process data (LRW with
 * the FRMW of the distributed clocks), segment, slave controllers and axis models work on it, SOEM
 * takes it back. All drives are enabled in CSP and move. Beside it, in turns, the same cycle of
 * SOEM with an empty port: frames come back at once with what they held before.
 *
 * The machine is shared and noisy: many short rounds, the best and the median of them. */
#define _POSIX_C_SOURCE 200809L
#include "bus/bus.h"
#include "bus/bytes.h"

#include "oshw.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { ROUNDS = 101, ROUND_NS = 1500000, WARM_UP = 60 };

static bool empty_port;

/* The linker puts these between SOEM and the port (--wrap). */
int __real_ecx_outframe_red(ecx_portt *port, uint8 idx);
int __wrap_ecx_outframe_red(ecx_portt *port, uint8 idx);
int __real_ecx_waitinframe(ecx_portt *port, uint8 idx, int timeout);
int __wrap_ecx_waitinframe(ecx_portt *port, uint8 idx, int timeout);

int __wrap_ecx_outframe_red(ecx_portt *port, uint8 idx)
{
    return empty_port ? port->txbuflength[idx] : __real_ecx_outframe_red(port, idx);
}

int __wrap_ecx_waitinframe(ecx_portt *port, uint8 idx, int timeout)
{
    const uint8 *frame = port->rxbuf[idx];

    if (!empty_port)
        return __real_ecx_waitinframe(port, idx, timeout);
    return get_u16(frame + (get_u16(frame) & 0x07ff));
}

static double wall_ns(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

struct bench {
    struct bus *bus;
    size_t drives;
    uint32_t cycle_ns;
    uint64_t now;
    int wkc;
    uint32_t moved, there[BUS_MAX_SLAVES]; /* increments */
    uint8_t *target[BUS_MAX_SLAVES];
};

/* There and back again, slowly: a turn each way. */
static void set_points(struct bench *b)
{
    uint32_t way = (b->moved += 64) & 0x1fffff;

    for (size_t i = 0; i < b->drives; i++)
        put_u32(b->target[i], b->there[i] + (way < 0x100000 ? way : 0x200000 - way));
}

static void cycle(struct bench *b)
{
    b->wkc = bus_receive(b->bus, b->now);
    set_points(b);
    b->now += b->cycle_ns / 5;
    bus_send(b->bus, b->now);
    b->now += b->cycle_ns - b->cycle_ns / 5;
}

/* The simulated machine's time stands still meanwhile. */
static void cycle_empty(struct bench *b)
{
    bus_send(b->bus, b->now);
    bus_receive(b->bus, b->now);
}

static void enable(struct bench *b)
{
    bus_request_op(b->bus);
    b->now = bus_now(b->bus);
    for (unsigned i = 0; i < WARM_UP; i++) {
        for (size_t s = 0; s < b->drives; s++) {
            bus_entry_set(bus_find(b->bus, s, BUS_OUTPUT, 0x6040, 0), i < 20 ? 6 : i < 30 ? 7 : 15);
            b->target[s] = bus_find(b->bus, s, BUS_OUTPUT, 0x607a, 0).byte;
            if (i < 40)
                b->there[s] = (uint32_t)bus_entry_get(bus_find(b->bus, s, BUS_INPUT, 0x6064, 0));
        }
        b->moved = 0;
        cycle(b);
    }
}

static double round_of(struct bench *b, void (*one)(struct bench *), unsigned cycles)
{
    double start = wall_ns();

    for (unsigned i = 0; i < cycles; i++)
        one(b);
    return (wall_ns() - start) / cycles;
}

static unsigned cycles_for(struct bench *b, void (*one)(struct bench *))
{
    return 1 + (unsigned)(ROUND_NS / round_of(b, one, 20));
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static void check(struct bench *b)
{
    for (size_t s = 0; s < b->drives; s++) {
        uint64_t word = bus_entry_get(bus_find(b->bus, s, BUS_INPUT, 0x6041, 0));

        if ((word & 0x6f) == 0x27)
            continue;
        fprintf(stderr, "drive %zu is not enabled: statusword 0x%04" PRIx64 "\n", s + 1, word);
        exit(1);
    }
}

static void measure(size_t drives, uint32_t cycle_ns)
{
    struct bus_device devices[BUS_MAX_SLAVES];
    struct bus_config config = {
        .devices = devices, .device_count = drives, .cycle_ns = cycle_ns, .seed = 1
    };
    struct bench b = { .drives = drives, .cycle_ns = cycle_ns };
    double full[ROUNDS], empty[ROUNDS];
    unsigned full_cycles, empty_cycles;
    char why[BUS_WHY];

    for (size_t i = 0; i < drives; i++)
        devices[i] = (struct bus_device){ .type = "drive-cia402" };
    if (bus_open(&b.bus, &config, why)) {
        fprintf(stderr, "%zu drives: %s\n", drives, why);
        exit(1);
    }
    enable(&b);
    if (b.wkc != bus_expected_wkc(b.bus)) {
        printf("%6zu  %5" PRIu32 "  the frames need more than a cycle on a 100 Mbit/s cable\n",
               drives, cycle_ns / 1000);
        bus_close(b.bus);
        return;
    }
    full_cycles = cycles_for(&b, cycle);
    empty_port = true;
    empty_cycles = cycles_for(&b, cycle_empty);
    for (unsigned r = 0; r < ROUNDS; r++) {
        empty_port = false;
        full[r] = round_of(&b, cycle, full_cycles);
        empty_port = true;
        empty[r] = round_of(&b, cycle_empty, empty_cycles);
    }
    empty_port = false;
    cycle(&b);
    cycle(&b);
    check(&b);
    bus_close(b.bus);
    qsort(full, ROUNDS, sizeof *full, rising);
    qsort(empty, ROUNDS, sizeof *empty, rising);
    printf("%6zu  %5" PRIu32 "  %7.0f  %7.0f  %7.1f  %7.0f  %7.0f  %6.1f\n", drives,
           cycle_ns / 1000, full[0], full[ROUNDS / 2], full[0] / (double)drives, empty[0],
           empty[ROUNDS / 2], full[0] / empty[0]);
}

/* bench_bus [DRIVES US]: one row instead of all. */
int main(int argc, char **argv)
{
    static const size_t drives[] = { 1, 4, 8, 16, 32, 64, 128, 200 };
    static const uint32_t cycles[] = { 250000, 1000000 };

    printf("Bus cycle in nanoseconds: drives in CSP, all moving; best and median of %d rounds\n"
           "                 whole cycle     of each     empty port\n"
           "drives     us     best   median    drive     best   median   ratio\n",
           ROUNDS);
    if (argc == 3) {
        measure(strtoul(argv[1], NULL, 10), (uint32_t)strtoul(argv[2], NULL, 10) * 1000);
        return 0;
    }
    for (size_t c = 0; c < sizeof cycles / sizeof *cycles; c++) {
        for (size_t i = 0; i < sizeof drives / sizeof *drives; i++)
            measure(drives[i], cycles[c]);
    }
    return 0;
}
