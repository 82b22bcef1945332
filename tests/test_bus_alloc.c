/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Nothing on the bus allocates or frees once bus_open() is back. The linker leads every call of the
 * allocator in the program's own objects, SOEM's among them, to the counters here (--wrap). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "bus/bus.h"
#include "bus/bytes.h"

static unsigned calls;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
int __real_posix_memalign(void **out, size_t alignment, size_t size);
int __wrap_posix_memalign(void **out, size_t alignment, size_t size);
char *__real_strdup(const char *text);
char *__wrap_strdup(const char *text);
void __real_free(void *old);
void __wrap_free(void *old);

void *__wrap_malloc(size_t size)
{
    calls++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    calls++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    calls++;
    return __real_realloc(old, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    calls++;
    return __real_aligned_alloc(alignment, size);
}

int __wrap_posix_memalign(void **out, size_t alignment, size_t size)
{
    calls++;
    return __real_posix_memalign(out, alignment, size);
}

char *__wrap_strdup(const char *text)
{
    calls++;
    return __real_strdup(text);
}

void __wrap_free(void *old)
{
    calls++;
    __real_free(old);
}

enum { MS = 1000000, ALL = 60 };

/* One slave of every type, again and again: more than fits one frame. */
static struct bus *open_bus(void)
{
    struct bus_device devices[ALL];
    struct bus_config config = {
        .devices = devices, .device_count = ALL, .cycle_ns = MS, .seed = 1
    };
    size_t types = 0;
    char why[BUS_WHY];
    struct bus *bus;

    while (bus_device_type(types, NULL))
        types++;
    for (size_t i = 0; i < ALL; i++)
        devices[i] = (struct bus_device){ .type = bus_device_type(i % types, NULL) };
    assert_int_equal(bus_open(&bus, &config, why), 0);
    return bus;
}

static void switch_on(struct bus *bus, unsigned cycle)
{
    for (size_t i = 0; i < ALL; i++) {
        struct bus_entry target = bus_find(bus, i, BUS_OUTPUT, 0x607a, 0);
        struct bus_entry actual = bus_find(bus, i, BUS_INPUT, 0x6064, 0);

        bus_entry_set(bus_find(bus, i, BUS_OUTPUT, 0x6040, 0), cycle < 30   ? 6
                                                               : cycle < 40 ? 7
                                                                            : 15);
        bus_entry_set(target, bus_entry_get(actual) + 100);
    }
}

static void nothing_is_allocated_while_the_bus_runs(void **state)
{
    struct bus *bus;
    uint64_t now;

    (void)state;
    calls = 0;
    bus = open_bus();
    assert_int_not_equal(calls, 0); /* it does count */
    calls = 0;
    now = bus_now(bus);
    bus_request_op(bus);
    for (unsigned i = 0; i < 400; i++) {
        bus_receive(bus, now);
        switch_on(bus, i);
        /* Lost cycles, too: watchdogs expire, slaves fall, drives stop. */
        if (i % 200 < 190)
            bus_send(bus, now + MS / 5);
        bus_poll_states(bus);
        now += i % 200 == 190 ? 150 * MS : MS;
        if (i == 199)
            bus_request_op(bus);
    }
    assert_int_equal(calls, 0);
    bus_close(bus);
    assert_int_not_equal(calls, 0);
}

static void nothing_is_allocated_for_sdos_and_inputs(void **state)
{
    struct bus *bus = open_bus();

    (void)state;
    calls = 0;
    for (size_t i = 0; i < ALL; i++) {
        uint8_t data[64];
        size_t size = sizeof data;
        uint32_t abort;

        bus_sdo_read(bus, i, 0x1008, 0, data, &size, &abort);
        put_u32(data, 1000);
        bus_sdo_write(bus, i, 0x6081, 0, data, 4, &abort);
        bus_sdo_read(bus, i, 0x4711, 0, data, &size, &abort);
        bus_set_input(bus, i, 0, 1);
    }
    assert_int_equal(calls, 0);
    bus_close(bus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_allocated_while_the_bus_runs),
        cmocka_unit_test(nothing_is_allocated_for_sdos_and_inputs),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
