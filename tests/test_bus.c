/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The whole path: SOEM scans, configures and runs the simulated segment. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bus/bus.h"

#define MS 1000000u

static const struct bus_stimulus stimuli[] = {
    { .bit = 0, .period_ns = 20 * MS },
    { .bit = 5, .period_ns = 8 * MS, .phase_ns = 100 * MS },
};
static const struct bus_device machine[] = {
    { .type = "drive-cia402" },
    { .type = "dio-8x8", .stimuli = stimuli, .stimulus_count = 2 },
    { .type = "drive-cia402" },
    { .type = "dio-8x8" },
};

struct plant {
    struct bus *bus;
    uint64_t now;
};

static void plant_open(struct plant *p, const struct bus_device *devices, size_t count,
                       uint64_t seed)
{
    struct bus_config config = {
        .devices = devices, .device_count = count, .cycle_ns = MS, .seed = seed
    };
    char why[BUS_WHY];
    int error = bus_open(&p->bus, &config, why);

    if (error)
        print_error("%s\n", why);
    assert_int_equal(error, 0);
    p->now = bus_now(p->bus);
}

/* As the schedule of TG Motion does it: receive, think, send a fifth of the cycle later. */
static int cycle(struct plant *p)
{
    int wkc = bus_receive(p->bus, p->now);

    p->now += MS / 5;
    bus_send(p->bus, p->now);
    p->now += MS - MS / 5;
    return wkc;
}

static void reach_op(struct plant *p)
{
    size_t n = bus_slave_count(p->bus);
    unsigned in_op = 0;

    cycle(p);
    bus_request_op(p->bus);
    for (unsigned i = 0; i < 200 && in_op < n; i++) {
        cycle(p);
        in_op = 0;
        bus_poll_states(p->bus);
        for (size_t s = 0; s < n; s++)
            in_op += bus_slave(p->bus, s)->al_state == 8;
    }
    assert_int_equal(in_op, n);
}

static int setup(void **state)
{
    struct plant *p = calloc(1, sizeof *p);

    assert_non_null(p);
    plant_open(p, machine, 4, 11);
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

static uint64_t get(struct plant *p, size_t slave, uint16_t index)
{
    struct bus_entry entry = bus_find(p->bus, slave, BUS_INPUT, index, 0);

    assert_int_not_equal(entry.bits, 0);
    return bus_entry_get(entry);
}

static int64_t get_signed(struct plant *p, size_t slave, uint16_t index)
{
    return bus_entry_sign(bus_find(p->bus, slave, BUS_INPUT, index, 0));
}

static void set(struct plant *p, size_t slave, uint16_t index, uint64_t value)
{
    struct bus_entry entry = bus_find(p->bus, slave, BUS_OUTPUT, index, 0);

    assert_int_not_equal(entry.bits, 0);
    bus_entry_set(entry, value);
}

static void enable_drive(struct plant *p, size_t slave)
{
    static const uint16_t words[] = { 6, 7, 15 };

    set(p, slave, 0x6060, 8);
    for (unsigned i = 0; i < 3; i++) {
        set(p, slave, 0x6040, words[i]);
        set(p, slave, 0x607a, (uint64_t)get_signed(p, slave, 0x6064));
        cycle(p);
        cycle(p);
        cycle(p);
    }
    assert_int_equal(get(p, slave, 0x6041) & 0x6f, 0x27);
}

static void open_finds_and_describes_every_slave_in_safeop(void **state)
{
    struct plant *p = *state;

    assert_int_equal(bus_slave_count(p->bus), 4);
    for (size_t i = 0; i < 4; i++) {
        const struct bus_slave *s = bus_slave(p->bus, i);

        assert_int_equal(s->al_state, 4);
        assert_int_equal(s->al_code, 0);
        assert_int_equal(s->axes, i % 2 ? 0 : 1);
        assert_int_equal(s->output_bits, i % 2 ? 8 : 64);
        assert_int_equal(s->input_bits, i % 2 ? 8 : 160);
        assert_string_equal(s->name,
                            i % 2 ? "Simulated DIO 8 in 8 out" : "Simulated servo drive CiA 402");
    }
    assert_null(bus_slave(p->bus, 4));
    assert_int_equal(bus_expected_wkc(p->bus), 4 * 3);
    assert_true(bus_now(p->bus) > 0);
}

static void every_mapped_object_is_found_with_its_length(void **state)
{
    static const struct {
        enum bus_direction direction;
        uint16_t index;
        uint8_t bits;
        size_t offset;
    } rows[] = {
        { BUS_OUTPUT, 0x6040, 16, 0 }, { BUS_OUTPUT, 0x6060, 8, 2 },  { BUS_OUTPUT, 0x607a, 32, 4 },
        { BUS_INPUT, 0x6041, 16, 0 },  { BUS_INPUT, 0x6061, 8, 2 },   { BUS_INPUT, 0x6064, 32, 4 },
        { BUS_INPUT, 0x606c, 32, 8 },  { BUS_INPUT, 0x60f4, 32, 12 }, { BUS_INPUT, 0x60fd, 32, 16 },
    };
    struct plant *p = *state;

    for (size_t s = 0; s < 4; s += 2) {
        for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
            struct bus_entry e = bus_find(p->bus, s, rows[i].direction, rows[i].index, 0);
            struct bus_entry all = bus_bits(p->bus, s, rows[i].direction, 0, 8);

            assert_int_equal(e.bits, rows[i].bits);
            assert_int_equal(e.byte - all.byte, rows[i].offset);
        }
        assert_int_equal(bus_find(p->bus, s, BUS_OUTPUT, 0x6041, 0).bits, 0);
        assert_int_equal(bus_find(p->bus, s, BUS_OUTPUT, 0x6040, 1).bits, 0);
    }
    assert_int_equal(bus_find(p->bus, 9, BUS_OUTPUT, 0x6040, 0).bits, 0);
}

static void terminals_are_found_through_their_sii(void **state)
{
    struct plant *p = *state;
    struct bus_entry third = bus_find(p->bus, 1, BUS_INPUT, 0x6030, 1);
    struct bus_entry bits = bus_bits(p->bus, 1, BUS_INPUT, 3, 1);

    assert_int_equal(third.bits, 1);
    assert_ptr_equal(third.byte, bits.byte);
    assert_int_equal(third.bit, bits.bit);
    assert_int_equal(bus_bits(p->bus, 1, BUS_INPUT, 0, 9).bits, 0);
    assert_int_equal(bus_bits(p->bus, 1, BUS_INPUT, 8, 1).bits, 0);
    assert_int_equal(bus_bits(p->bus, 1, BUS_OUTPUT, 7, 1).bits, 1);
}

static void all_slaves_reach_op_while_process_data_flows(void **state)
{
    struct plant *p = *state;

    reach_op(p);
    for (unsigned i = 0; i < 1000; i++)
        assert_int_equal(cycle(p), bus_expected_wkc(p->bus));
}

static void receive_without_send_says_no_frame(void **state)
{
    struct plant *p = *state;

    assert_int_equal(bus_receive(p->bus, p->now), -1);
}

static void receive_at_the_time_of_the_send_waits_for_the_wire(void **state)
{
    struct plant *p = *state;

    bus_send(p->bus, p->now);
    assert_int_equal(bus_receive(p->bus, p->now), bus_expected_wkc(p->bus));
    assert_in_range(bus_now(p->bus) - p->now, 5000, 30000);
}

static void outputs_written_while_a_frame_is_under_way_go_out_with_the_next(void **state)
{
    struct plant *p = *state;

    reach_op(p);
    set(p, 0, 0x6040, 0);
    cycle(p);
    set(p, 0, 0x6040, 6);
    bus_receive(p->bus, p->now);
    bus_send(p->bus, p->now += MS);
    bus_receive(p->bus, p->now += MS);
    bus_send(p->bus, p->now += MS);
    bus_receive(p->bus, p->now += MS);
    assert_int_equal(get(p, 0, 0x6041) & 0x6f, 0x21);
}

static void a_frame_not_received_before_the_next_send_is_dropped(void **state)
{
    struct plant *p = *state;

    for (unsigned i = 0; i < 40; i++)
        bus_send(p->bus, p->now += MS);
    assert_int_equal(bus_receive(p->bus, p->now += MS), bus_expected_wkc(p->bus));
    assert_int_equal(bus_receive(p->bus, p->now), -1);
}

static void time_never_goes_back(void **state)
{
    struct plant *p = *state;
    uint64_t before = bus_now(p->bus);

    bus_send(p->bus, before - 1000);
    bus_receive(p->bus, before - 500);
    assert_true(bus_now(p->bus) >= before);
}

static void polling_states_leaves_process_data_in_flight_alone(void **state)
{
    struct plant *p = *state;

    reach_op(p);
    for (unsigned i = 0; i < 100; i++) {
        bus_receive(p->bus, p->now);
        bus_send(p->bus, p->now += MS / 5);
        bus_poll_states(p->bus);
        assert_int_equal(bus_slave(p->bus, i % 4)->al_state, 8);
        p->now += MS - MS / 5;
        assert_int_equal(bus_receive(p->bus, p->now), bus_expected_wkc(p->bus));
    }
}

static void two_drives_follow_their_own_set_points(void **state)
{
    struct plant *p = *state;
    int64_t start[2], at[2];

    reach_op(p);
    enable_drive(p, 0);
    enable_drive(p, 2);
    for (unsigned d = 0; d < 2; d++)
        start[d] = at[d] = get_signed(p, d * 2, 0x6064);
    for (unsigned i = 0; i < 2000; i++) {
        for (unsigned d = 0; d < 2; d++) {
            at[d] += d ? -400 : 2000;
            set(p, d * 2, 0x607a, (uint64_t)at[d]);
        }
        assert_int_equal(cycle(p), bus_expected_wkc(p->bus));
        assert_true(llabs(get_signed(p, 0, 0x60f4)) < 5000);
    }
    for (unsigned i = 0; i < 200; i++)
        cycle(p);
    assert_true(llabs(get_signed(p, 0, 0x6064) - (start[0] + 4000000)) < 20);
    assert_true(llabs(get_signed(p, 2, 0x6064) - (start[1] - 800000)) < 20);
}

static void stimuli_drive_the_inputs_in_bus_time(void **state)
{
    struct plant *p = *state;
    struct bus_entry in0 = bus_bits(p->bus, 1, BUS_INPUT, 0, 1);
    struct bus_entry in5 = bus_bits(p->bus, 1, BUS_INPUT, 5, 1);
    unsigned early5 = 0;

    for (unsigned i = 0; i < 300; i++) {
        uint64_t sent = p->now;

        bus_send(p->bus, sent);
        assert_int_equal(bus_receive(p->bus, sent + MS / 2), bus_expected_wkc(p->bus));
        p->now += MS;
        /* The frame passes the second slave 1.4 us after it was sent. */
        sent += 1400;
        assert_int_equal(bus_entry_get(in0), sent % (20 * MS) < 10 * MS);
        if (sent < 100 * MS)
            early5 += (unsigned)bus_entry_get(in5);
        else
            assert_int_equal(bus_entry_get(in5), (sent - 100 * MS) % (8 * MS) < 4 * MS);
        assert_int_equal(bus_entry_get(bus_bits(p->bus, 3, BUS_INPUT, 0, 8)), 0);
    }
    assert_int_equal(early5, 0);
}

static void a_silent_master_loses_its_drives_and_gets_them_back(void **state)
{
    struct plant *p = *state;

    reach_op(p);
    enable_drive(p, 0);
    p->now += 150 * MS;
    cycle(p);
    bus_poll_states(p->bus);
    cycle(p);
    cycle(p);
    assert_int_equal(bus_slave(p->bus, 0)->al_state, 0x14);
    assert_int_equal(bus_slave(p->bus, 0)->al_code, 0x001b);
    assert_int_equal(bus_slave(p->bus, 1)->al_state, 8);
    assert_int_equal(get(p, 0, 0x6041) & 0x4f, 0x08);
    set(p, 0, 0x6040, 0);
    bus_request_op(p->bus);
    for (unsigned i = 0; i < 10; i++)
        cycle(p);
    bus_poll_states(p->bus);
    cycle(p);
    cycle(p);
    for (size_t s = 0; s < 4; s++)
        assert_int_equal(bus_slave(p->bus, s)->al_state, 8);
    set(p, 0, 0x6040, 0x80);
    cycle(p);
    cycle(p);
    cycle(p);
    enable_drive(p, 0);
}

static void sdo_read_and_write_work_in_every_state(void **state)
{
    struct plant *p = *state;
    uint32_t value = 0, abort = 1;
    size_t size = sizeof value;
    uint32_t window = 0x1234;

    for (unsigned round = 0; round < 2; round++) {
        size = sizeof value;
        assert_int_equal(bus_sdo_read(p->bus, 0, 0x608f, 1, &value, &size, &abort), 0);
        assert_int_equal(value, 1048576);
        assert_int_equal(abort, 0);
        window += round;
        assert_int_equal(bus_sdo_write(p->bus, 2, 0x6065, 0, &window, 4, &abort), 0);
        size = sizeof value;
        assert_int_equal(bus_sdo_read(p->bus, 2, 0x6065, 0, &value, &size, &abort), 0);
        assert_int_equal(value, window);
        assert_int_equal(size, 4);
        p->now = bus_now(p->bus);
        if (round == 0)
            reach_op(p);
    }
    assert_int_equal(cycle(p), bus_expected_wkc(p->bus));
}

static void sdo_errors_are_told_apart(void **state)
{
    struct plant *p = *state;
    uint8_t data[64];
    uint32_t abort = 0;
    size_t size = sizeof data;

    assert_int_equal(bus_sdo_read(p->bus, 0, 0x5000, 0, data, &size, &abort), -EPROTO);
    assert_int_equal(abort, 0x06020000);
    assert_int_equal(bus_sdo_write(p->bus, 0, 0x6041, 0, data, 2, &abort), -EPROTO);
    assert_int_equal(abort, 0x06010002);
    size = 4;
    assert_int_equal(bus_sdo_read(p->bus, 0, 0x1008, 0, data, &size, &abort), -ENOSPC);
    assert_int_equal(bus_sdo_read(p->bus, 1, 0x1000, 0, data, &size, NULL), -EOPNOTSUPP);
    assert_int_equal(bus_sdo_read(p->bus, 9, 0x1000, 0, data, &size, NULL), -EINVAL);
    size = sizeof data;
    assert_int_equal(bus_sdo_read(p->bus, 0, 0x1008, 0, data, &size, NULL), 0);
    assert_memory_equal(data, "Simulated servo drive CiA 402", size);
}

/* A run of two seconds as one number. */
static uint64_t fingerprint(uint64_t seed)
{
    struct plant p;
    uint64_t hash = 0xcbf29ce484222325u;

    plant_open(&p, machine, 4, seed);
    reach_op(&p);
    enable_drive(&p, 0);
    for (unsigned i = 0; i < 2000; i++) {
        struct bus_entry in = bus_bits(p.bus, 0, BUS_INPUT, 0, 8);

        set(&p, 0, 0x607a, (uint64_t)(get_signed(&p, 0, 0x6064) + 1000));
        hash = (hash ^ (uint64_t)cycle(&p)) * 0x100000001b3u;
        for (size_t k = 0; k < 42; k++)
            hash = (hash ^ in.byte[k]) * 0x100000001b3u;
    }
    hash = (hash ^ bus_now(p.bus)) * 0x100000001b3u;
    bus_close(p.bus);
    return hash;
}

static void runs_with_the_same_seed_are_identical_and_others_are_not(void **state)
{
    uint64_t first;

    (void)state;
    first = fingerprint(1);
    assert_true(fingerprint(1) == first);
    assert_true(fingerprint(2) != first);
}

static void two_buses_live_side_by_side(void **state)
{
    struct plant *a = *state, b;

    plant_open(&b, machine, 1, 5);
    reach_op(a);
    reach_op(&b);
    for (unsigned i = 0; i < 100; i++) {
        assert_int_equal(cycle(a), 12);
        assert_int_equal(cycle(&b), 3);
    }
    bus_close(b.bus);
    assert_int_equal(cycle(a), 12);
}

static void a_full_bus_of_200_slaves_needs_more_than_one_frame_and_works(void **state)
{
    struct bus_device devices[BUS_MAX_SLAVES];
    struct plant p;

    (void)state;
    for (size_t i = 0; i < BUS_MAX_SLAVES; i++)
        devices[i] = machine[0];
    plant_open(&p, devices, BUS_MAX_SLAVES, 3);
    assert_true(bus_expected_wkc(p.bus) >= 3 * BUS_MAX_SLAVES);
    reach_op(&p);
    for (unsigned i = 0; i < 50; i++)
        assert_int_equal(cycle(&p), bus_expected_wkc(p.bus));
    assert_int_equal(get(&p, BUS_MAX_SLAVES - 1, 0x6041) & 0x4f, 0x40);
    bus_close(p.bus);
}

static void a_bus_of_terminals_only_works(void **state)
{
    static const struct bus_device terminals[] = { { .type = "dio-8x8" }, { .type = "dio-8x8" } };
    struct plant p;

    (void)state;
    plant_open(&p, terminals, 2, 3);
    reach_op(&p);
    for (unsigned i = 0; i < 50; i++)
        assert_int_equal(cycle(&p), 6);
    bus_close(p.bus);
}

static void nonsense_is_refused_with_a_reason(void **state)
{
    static const struct bus_device unknown[] = { { .type = "toaster" } };
    struct bus_config config = { .devices = unknown, .device_count = 1, .cycle_ns = MS };
    char why[BUS_WHY];
    struct bus *bus;

    (void)state;
    assert_int_equal(bus_open(&bus, &config, why), -EINVAL);
    assert_non_null(strstr(why, "toaster"));
    assert_null(bus);
    config.device_count = 0;
    assert_int_equal(bus_open(&bus, &config, why), -EINVAL);
    config.device_count = BUS_MAX_SLAVES + 1;
    assert_int_equal(bus_open(&bus, &config, why), -EINVAL);
    assert_true(why[0] != '\0');
}

static void entries_read_write_and_extend_any_bits(void **state)
{
    uint8_t bytes[16];

    (void)state;
    for (unsigned bit = 0; bit < 8; bit++) {
        for (unsigned bits = 1; bits <= 64; bits++) {
            struct bus_entry e = { bytes + 2, (uint8_t)bit, (uint8_t)bits };
            uint64_t mask = bits == 64 ? ~0ull : (1ull << bits) - 1;

            memset(bytes, 0xff, sizeof bytes);
            bus_entry_set(e, 0);
            assert_true(bus_entry_get(e) == 0);
            bus_entry_set(e, 0xa5a5a5a5a5a5a5a5u);
            assert_true(bus_entry_get(e) == (0xa5a5a5a5a5a5a5a5u & mask));
            bus_entry_set(e, (uint64_t)-1);
            assert_true(bus_entry_sign(e) == -1);
            for (size_t i = 0; i < sizeof bytes; i++)
                assert_int_equal(bytes[i], 0xff);
        }
    }
    {
        struct bus_entry none = { NULL, 0, 0 };

        bus_entry_set(none, 1);
        assert_true(bus_entry_get(none) == 0);
        assert_true(bus_entry_sign(none) == 0);
    }
}

static void the_device_table_can_be_listed(void **state)
{
    const char *description, *name;
    size_t n = 0;

    (void)state;
    for (; (name = bus_device_type(n, &description)); n++)
        assert_true(name[0] && description[0]);
    assert_true(n >= 2);
    assert_null(description);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(open_finds_and_describes_every_slave_in_safeop),
        T(every_mapped_object_is_found_with_its_length),
        T(terminals_are_found_through_their_sii),
        T(all_slaves_reach_op_while_process_data_flows),
        T(receive_without_send_says_no_frame),
        T(receive_at_the_time_of_the_send_waits_for_the_wire),
        T(outputs_written_while_a_frame_is_under_way_go_out_with_the_next),
        T(a_frame_not_received_before_the_next_send_is_dropped),
        T(time_never_goes_back),
        T(polling_states_leaves_process_data_in_flight_alone),
        T(two_drives_follow_their_own_set_points),
        T(stimuli_drive_the_inputs_in_bus_time),
        T(a_silent_master_loses_its_drives_and_gets_them_back),
        T(sdo_read_and_write_work_in_every_state),
        T(sdo_errors_are_told_apart),
        cmocka_unit_test(runs_with_the_same_seed_are_identical_and_others_are_not),
        T(two_buses_live_side_by_side),
        cmocka_unit_test(a_full_bus_of_200_slaves_needs_more_than_one_frame_and_works),
        cmocka_unit_test(a_bus_of_terminals_only_works),
        cmocka_unit_test(nonsense_is_refused_with_a_reason),
        cmocka_unit_test(entries_read_write_and_extend_any_bits),
        cmocka_unit_test(the_device_table_can_be_listed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
