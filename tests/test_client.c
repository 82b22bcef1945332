/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What SOEM does for the harness beside the process data: jobs, supervision, recovery. The bus is
 * opened as the host does; what happens to slaves is done to the segment behind SOEM's back. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <errno.h>
#include <cmocka.h>

#include "bus/bytes.h"
#include "bus/client.h"
#include "bus/fiber.h"

#define MS UINT64_C(1000000)

static const struct bus_device machine[] = {
    { .type = "drive-cia402" },
    { .type = "dio-8x8" },
    { .type = "drive-cia402" },
    { .type = "drive-cia402" },
};

enum { SLAVES = 4 };

struct plant {
    struct bus *bus;
    uint64_t now;
};

static int exchange(struct plant *p)
{
    int wkc;

    bus_send(p->bus, p->now + MS / 5);
    p->now += MS;
    wkc = bus_receive(p->bus, p->now);
    bus_poll_states(p->bus);
    return wkc;
}

static int states(const struct plant *p, unsigned state)
{
    int n = 0;

    for (size_t i = 0; i < bus_slave_count(p->bus); i++)
        n += bus_slave(p->bus, i)->al_state == state;
    return n;
}

static void open_with(struct plant *p, const struct bus_config *config)
{
    char why[BUS_WHY];
    int error = bus_open(&p->bus, config, why);

    if (error)
        print_error("%s\n", why);
    assert_int_equal(error, 0);
    p->now = bus_now(p->bus);
    bus_supervise(p->bus, true);
    exchange(p);
    bus_request_op(p->bus);
    for (unsigned i = 0; i < 100 && states(p, AL_OP) < (int)bus_slave_count(p->bus); i++)
        exchange(p);
    assert_int_equal(states(p, AL_OP), bus_slave_count(p->bus));
    /* Behind the time in which supervision leaves the first start alone. */
    for (unsigned i = 0; i < 300; i++)
        assert_int_equal(exchange(p), bus_expected_wkc(p->bus));
}

static int setup(void **state)
{
    struct plant *p = calloc(1, sizeof *p);
    const struct bus_config config = {
        .devices = machine, .device_count = SLAVES, .cycle_ns = MS, .seed = 5
    };

    assert_non_null(p);
    open_with(p, &config);
    *state = p;
    return 0;
}

static int teardown(void **state)
{
    struct plant *p = *state;

    bus_close(p->bus);
    free(p);
    return 0;
}

/* Exchanges until all are in OP again; the number of them. */
static unsigned until_op(struct plant *p, unsigned most)
{
    unsigned n = 0;

    while (n < most && states(p, AL_OP) < SLAVES) {
        exchange(p);
        n++;
    }
    return n;
}

static void an_sdo_takes_its_time_beside_the_process_data(void **state)
{
    struct plant *p = *state;
    struct bus_job read = {
        .kind = BUS_SDO_READ, .slave = 2, .index = 0x608f, .subindex = 1, .size = 4
    };
    unsigned cycles = 0;

    bus_job_start(p->bus, &read);
    while (!read.done && cycles++ < 50)
        assert_int_equal(exchange(p), bus_expected_wkc(p->bus));
    assert_true(read.done);
    assert_true(cycles > 0);
    assert_int_equal(read.result, 0);
    assert_int_equal(read.size, 4);
    assert_int_equal(get_u32(read.data), 1048576);
}

static void jobs_end_in_the_order_of_their_start(void **state)
{
    struct plant *p = *state;
    struct bus_job jobs[3] = {
        { .kind = BUS_SDO_READ, .slave = 0, .index = 0x1008, .size = BUS_JOB_DATA },
        { .kind = BUS_REGISTER_READ, .slave = 1, .index = 0x0130, .size = 2 },
        { .kind = BUS_SDO_READ, .slave = 0, .index = 0x5555, .size = 4 },
    };

    for (unsigned i = 0; i < 3; i++)
        bus_job_start(p->bus, &jobs[i]);
    for (unsigned i = 0; i < 60 && !jobs[2].done; i++) {
        assert_true(!jobs[1].done || jobs[0].done);
        assert_true(!jobs[2].done || jobs[1].done);
        exchange(p);
    }
    assert_int_equal(jobs[0].result, 0);
    assert_memory_equal(jobs[0].data, "Simulated servo drive CiA 402", jobs[0].size);
    assert_int_equal(jobs[1].result, 0);
    assert_int_equal(get_u16(jobs[1].data), AL_OP);
    assert_int_equal(jobs[2].result, -EPROTO);
    assert_int_equal(jobs[2].abort, 0x06020000);
}

static void a_job_for_nobody_or_for_too_much_is_refused(void **state)
{
    struct plant *p = *state;
    struct bus_job nobody = { .kind = BUS_SDO_READ, .slave = 9, .index = 0x1000, .size = 4 };
    struct bus_job terminal = { .kind = BUS_SDO_READ, .slave = 1, .index = 0x1000, .size = 4 };
    struct bus_job large = { .kind = BUS_REGISTER_READ, .slave = 0, .size = BUS_JOB_DATA + 1 };

    bus_job_start(p->bus, &nobody);
    bus_job_start(p->bus, &terminal);
    bus_job_start(p->bus, &large);
    exchange(p);
    assert_true(nobody.done && terminal.done && large.done);
    assert_int_equal(nobody.result, -EINVAL);
    assert_int_equal(terminal.result, -EOPNOTSUPP);
    assert_int_equal(large.result, -EINVAL);
}

static void a_register_is_written_and_read_back(void **state)
{
    struct plant *p = *state;
    struct bus_job write = {
        .kind = BUS_REGISTER_WRITE, .slave = 3, .index = 0x0934, .size = 1, .data = { 0x07 }
    };
    struct bus_job read = { .kind = BUS_REGISTER_READ, .slave = 3, .index = 0x0934, .size = 1 };

    bus_job_start(p->bus, &write);
    bus_job_start(p->bus, &read);
    for (unsigned i = 0; i < 10; i++)
        exchange(p);
    assert_int_equal(write.result, 0);
    assert_int_equal(read.result, 0);
    assert_int_equal(read.data[0], 0x07);
}

static void a_blocking_sdo_waits_for_the_jobs_before_it(void **state)
{
    struct plant *p = *state;
    struct bus_job first = {
        .kind = BUS_SDO_READ, .slave = 0, .index = 0x1018, .subindex = 4, .size = 4
    };
    uint8_t value[4];
    size_t size = sizeof value;

    bus_job_start(p->bus, &first);
    assert_int_equal(bus_sdo_read(p->bus, 0, 0x1018, 1, value, &size, NULL), 0);
    assert_true(first.done);
    assert_int_equal(first.result, 0);
    assert_int_equal(get_u32(value), bus_slave(p->bus, 0)->vendor);
}

static void a_slave_that_was_switched_off_comes_back_and_the_others_go_on(void **state)
{
    struct plant *p = *state;
    unsigned lost = 0;

    segment_power(&p->bus->rack.segment, 3, false, p->now);
    for (unsigned i = 0; i < 100; i++) {
        /* The last drive is missing: one output, one input. */
        assert_int_equal(exchange(p), bus_expected_wkc(p->bus) - 3);
        lost += bus_slave(p->bus, 3)->lost;
    }
    assert_true(lost > 90);
    assert_int_equal(states(p, AL_OP), SLAVES - 1);
    segment_power(&p->bus->rack.segment, 3, true, p->now);
    assert_int_equal(get_u16(p->bus->rack.slaves[3].memory + REG_STATION_ADDRESS), 0);
    assert_true(until_op(p, 400) < 400);
    assert_int_equal(get_u16(p->bus->rack.slaves[3].memory + REG_STATION_ADDRESS), 0x1004);
    for (unsigned i = 0; i < 20; i++)
        assert_int_equal(exchange(p), bus_expected_wkc(p->bus));
    assert_int_equal(bus_slave(p->bus, 3)->losses, 1);
    assert_int_equal(bus_slave(p->bus, 3)->recoveries, 1);
    assert_int_equal(bus_slave(p->bus, 0)->losses, 0);
    assert_false(bus_slave(p->bus, 3)->lost);
}

static void a_returning_slave_has_its_clock_back(void **state)
{
    struct plant *p = *state;
    struct bus_job times[2];

    segment_power(&p->bus->rack.segment, 3, false, p->now);
    for (unsigned i = 0; i < 20; i++)
        exchange(p);
    segment_power(&p->bus->rack.segment, 3, true, p->now);
    assert_true(until_op(p, 400) < 400);
    for (unsigned i = 0; i < 200; i++)
        exchange(p);
    for (unsigned i = 0; i < 2; i++) {
        times[i] = (struct bus_job){
            .kind = BUS_REGISTER_READ, .slave = i ? 3 : 0, .index = REG_DC_SYSTEM_TIME, .size = 8
        };
        bus_job_start(p->bus, &times[i]);
    }
    for (unsigned i = 0; i < 5; i++)
        exchange(p);
    /* One frame lies between the two readings. */
    assert_true(get_u64(times[1].data) > get_u64(times[0].data));
    assert_true(get_u64(times[1].data) - get_u64(times[0].data) < 2 * MS);
    assert_true((get_u32(p->bus->rack.slaves[3].memory + REG_DC_DELAY)) > 0);
}

static void another_device_in_its_place_is_not_taken(void **state)
{
    struct plant *p = *state;

    segment_power(&p->bus->rack.segment, 3, false, p->now);
    for (unsigned i = 0; i < 20; i++)
        exchange(p);
    /* Another product code in its SII: words 0x0A and 0x0B. */
    p->bus->rack.slaves[3].image[0x14] ^= 0x01;
    segment_power(&p->bus->rack.segment, 3, true, p->now);
    for (unsigned i = 0; i < 300; i++)
        assert_int_equal(exchange(p), bus_expected_wkc(p->bus) - 3);
    assert_true(bus_slave(p->bus, 3)->lost);
    assert_int_equal(get_u16(p->bus->rack.slaves[3].memory + REG_STATION_ADDRESS), 0);
    assert_int_equal(states(p, AL_OP), SLAVES - 1);
}

static void a_pulled_cable_takes_everybody_behind_it_until_it_is_plugged(void **state)
{
    struct plant *p = *state;

    segment_cable(&p->bus->rack.segment, 2, false, p->now);
    for (unsigned i = 0; i < 50; i++)
        exchange(p);
    assert_int_equal(exchange(p), bus_expected_wkc(p->bus) - 2 * 3);
    assert_int_equal(bus_slave(p->bus, 2)->lost + bus_slave(p->bus, 3)->lost, 2);
    segment_cable(&p->bus->rack.segment, 2, true, p->now);
    assert_true(until_op(p, 400) < 400);
    assert_int_equal(exchange(p), bus_expected_wkc(p->bus));
    assert_int_equal(bus_slave(p->bus, 2)->losses, 1);
    assert_int_equal(bus_slave(p->bus, 1)->losses, 0);
}

static void an_error_is_acknowledged_and_the_drive_sent_to_op_again(void **state)
{
    struct plant *p = *state;
    unsigned seen = 0;

    /* Longer without outputs than the drives' watchdogs allow. */
    p->now += 150 * MS;
    for (unsigned i = 0; i < 100; i++) {
        exchange(p);
        seen |= bus_slave(p->bus, 0)->al_state == (AL_SAFEOP | AL_ERROR) &&
                bus_slave(p->bus, 0)->al_code == 0x001b;
    }
    assert_true(seen);
    assert_int_equal(states(p, AL_OP), SLAVES);
    assert_int_equal(bus_slave(p->bus, 0)->recoveries, 1);
    assert_int_equal(bus_slave(p->bus, 0)->losses, 0);
}

static void a_slave_reset_to_init_is_configured_again(void **state)
{
    struct plant *p = *state;
    struct bus_job reset = { .kind = BUS_REGISTER_WRITE,
                             .slave = 2,
                             .index = REG_AL_CONTROL,
                             .size = 2,
                             .data = { AL_INIT, 0 } };

    bus_job_start(p->bus, &reset);
    for (unsigned i = 0; i < 5; i++)
        exchange(p);
    assert_int_equal(reset.result, 0);
    assert_true(until_op(p, 400) < 400);
    assert_int_equal(exchange(p), bus_expected_wkc(p->bus));
}

static void without_supervision_a_fallen_slave_stays_where_it_is(void **state)
{
    struct plant *p = *state;

    bus_supervise(p->bus, false);
    p->now += 150 * MS;
    for (unsigned i = 0; i < 100; i++)
        exchange(p);
    assert_int_equal(bus_slave(p->bus, 0)->al_state, AL_SAFEOP | AL_ERROR);
}

static void an_sdo_does_not_wait_for_a_slave_that_is_gone(void **state)
{
    struct plant *p = *state;
    struct bus_job read = {
        .kind = BUS_SDO_READ, .slave = 0, .index = 0x608f, .subindex = 1, .size = 4
    };
    unsigned cycles = 0;

    segment_power(&p->bus->rack.segment, 3, false, p->now);
    for (unsigned i = 0; i < 100; i++)
        exchange(p);
    bus_job_start(p->bus, &read);
    while (!read.done && cycles++ < 300)
        exchange(p);
    assert_int_equal(read.result, 0);
    assert_true(cycles < 50);
}

static void with_redundancy_any_one_cable_may_be_pulled(void **state)
{
    const struct bus_config config = {
        .devices = machine, .device_count = SLAVES, .cycle_ns = MS, .seed = 5, .redundant = true
    };
    struct plant p;

    (void)state;
    open_with(&p, &config);
    for (size_t cable = 0; cable <= SLAVES; cable++) {
        uint64_t before = p.bus->port.one_sided;

        segment_cable(&p.bus->rack.segment, cable, false, p.now);
        for (unsigned i = 0; i < 30; i++) {
            /* Both ways together reach everybody. */
            assert_int_equal(exchange(&p), bus_expected_wkc(p.bus));
            assert_int_equal(states(&p, AL_OP), SLAVES);
        }
        assert_true(p.bus->port.one_sided >= before + 30);
        segment_cable(&p.bus->rack.segment, cable, true, p.now);
        for (unsigned i = 0; i < 5; i++)
            assert_int_equal(exchange(&p), bus_expected_wkc(p.bus));
        before = p.bus->port.one_sided;
        for (unsigned i = 0; i < 5; i++)
            assert_int_equal(exchange(&p), bus_expected_wkc(p.bus));
        assert_int_equal(p.bus->port.one_sided, before);
    }
    for (size_t i = 0; i < SLAVES; i++)
        assert_int_equal(bus_slave(p.bus, i)->losses, 0);
    bus_close(p.bus);
}

static void without_redundancy_a_cable_is_missed(void **state)
{
    struct plant *p = *state;

    segment_cable(&p->bus->rack.segment, 1, false, p->now);
    exchange(p);
    assert_int_equal(exchange(p), bus_expected_wkc(p->bus) - 3 * 3);
}

static void drives_get_a_pulse_every_cycle_and_again_after_a_power_failure(void **state)
{
    const struct bus_config config = {
        .devices = machine, .device_count = SLAVES, .cycle_ns = MS, .seed = 5, .dc_sync = true
    };
    struct plant p;

    (void)state;
    open_with(&p, &config);
    for (unsigned round = 0; round < 2; round++) {
        for (size_t i = 0; i < SLAVES; i++) {
            const uint8_t *memory = p.bus->rack.slaves[i].memory;

            /* The terminal has no clock. */
            assert_int_equal(memory[REG_DC_ACTIVATION], i == 1 ? 0 : 3);
            assert_int_equal(get_u32(memory + REG_DC_CYCLE0), i == 1 ? 0 : MS);
        }
        segment_power(&p.bus->rack.segment, 3, false, p.now);
        for (unsigned i = 0; i < 20; i++)
            exchange(&p);
        segment_power(&p.bus->rack.segment, 3, true, p.now);
        assert_true(until_op(&p, 400) < 400);
    }
    bus_close(p.bus);
}

static void startup_values_are_written_before_safeop(void **state)
{
    /* Following error window of the drive, a value that is not its default. */
    static const struct bus_startup startup[] = { { 2, 0x6065, 0, 4, 4711 } };
    const struct bus_config config = { .devices = machine,
                                       .device_count = SLAVES,
                                       .cycle_ns = MS,
                                       .seed = 5,
                                       .startup = startup,
                                       .startup_count = 1 };
    struct plant p;
    uint8_t value[4];
    size_t size = sizeof value;

    (void)state;
    open_with(&p, &config);
    assert_int_equal(bus_sdo_read(p.bus, 2, 0x6065, 0, value, &size, NULL), 0);
    assert_int_equal(get_u32(value), 4711);
    size = sizeof value;
    assert_int_equal(bus_sdo_read(p.bus, 0, 0x6065, 0, value, &size, NULL), 0);
    assert_int_not_equal(get_u32(value), 4711);
    /* And again when it comes back from a power failure. */
    p.now = bus_now(p.bus);
    segment_power(&p.bus->rack.segment, 2, false, p.now);
    for (unsigned i = 0; i < 10; i++)
        exchange(&p);
    segment_power(&p.bus->rack.segment, 2, true, p.now);
    assert_true(until_op(&p, 600) < 600);
    size = sizeof value;
    assert_int_equal(bus_sdo_read(p.bus, 2, 0x6065, 0, value, &size, NULL), 0);
    assert_int_equal(get_u32(value), 4711);
    bus_close(p.bus);
}

static void a_startup_value_that_is_refused_is_said(void **state)
{
    static const struct bus_startup startup[] = { { 0, 0x6041, 0, 2, 1 } };
    const struct bus_config config = { .devices = machine,
                                       .device_count = SLAVES,
                                       .cycle_ns = MS,
                                       .startup = startup,
                                       .startup_count = 1 };
    char why[BUS_WHY];
    struct bus *bus;

    (void)state;
    assert_int_equal(bus_open(&bus, &config, why), -EPROTO);
    assert_string_equal(why, "slave 1 (Simulated servo drive CiA 402): the startup value 0x6041:00 "
                             "= 0x1 is not taken: abort 0x06010002");
    assert_null(bus);
}

static void equal_histories_give_equal_inputs(void **state)
{
    static uint8_t trace[2][400][64];

    (void)state;
    for (unsigned run = 0; run < 2; run++) {
        const struct bus_config config = {
            .devices = machine, .device_count = SLAVES, .cycle_ns = MS, .seed = 5
        };
        struct plant p;

        open_with(&p, &config);
        for (unsigned i = 0; i < 400; i++) {
            if (i == 30 || i == 60)
                segment_power(&p.bus->rack.segment, 2, i == 60, p.now);
            exchange(&p);
            memcpy(trace[run][i], p.bus->image, sizeof trace[run][i]);
        }
        bus_close(p.bus);
    }
    assert_memory_equal(trace[0], trace[1], sizeof trace[0]);
}

static unsigned steps_done;

static void count_steps(void *argument)
{
    struct fiber **fiber = argument;
    volatile double kept = 1.5;

    for (;;) {
        steps_done++;
        kept *= 2.0;
        fiber_yield(*fiber);
        assert_true(kept > 0.0);
    }
}

static void a_fiber_goes_on_where_it_yielded(void **state)
{
    struct fiber *fiber;

    (void)state;
    steps_done = 0;
    assert_int_equal(fiber_open(&fiber, count_steps, &fiber), 0);
    assert_int_equal(steps_done, 0);
    for (unsigned i = 1; i <= 1000; i++) {
        fiber_resume(fiber);
        assert_int_equal(steps_done, i);
        assert_false(fiber_inside(fiber));
    }
    fiber_close(fiber);
}

#define TEST(f) cmocka_unit_test_setup_teardown(f, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(an_sdo_takes_its_time_beside_the_process_data),
        TEST(jobs_end_in_the_order_of_their_start),
        TEST(a_job_for_nobody_or_for_too_much_is_refused),
        TEST(a_register_is_written_and_read_back),
        TEST(a_blocking_sdo_waits_for_the_jobs_before_it),
        TEST(a_slave_that_was_switched_off_comes_back_and_the_others_go_on),
        TEST(a_returning_slave_has_its_clock_back),
        TEST(another_device_in_its_place_is_not_taken),
        TEST(a_pulled_cable_takes_everybody_behind_it_until_it_is_plugged),
        TEST(an_error_is_acknowledged_and_the_drive_sent_to_op_again),
        TEST(a_slave_reset_to_init_is_configured_again),
        TEST(without_supervision_a_fallen_slave_stays_where_it_is),
        TEST(an_sdo_does_not_wait_for_a_slave_that_is_gone),
        cmocka_unit_test(with_redundancy_any_one_cable_may_be_pulled),
        TEST(without_redundancy_a_cable_is_missed),
        cmocka_unit_test(drives_get_a_pulse_every_cycle_and_again_after_a_power_failure),
        cmocka_unit_test(startup_values_are_written_before_safeop),
        cmocka_unit_test(a_startup_value_that_is_refused_is_said),
        cmocka_unit_test(equal_histories_give_equal_inputs),
        cmocka_unit_test(a_fiber_goes_on_where_it_yielded),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
