/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Distributed clocks: port times and delays, offsets, drift, SYNC pulses. */
#include "bus_rig.h"

#define N 5

static const char *const line[N] = { "drive-cia402", "drive-cia402", "drive-cia402", "drive-cia402",
                                     "drive-cia402" };

static int setup(void **state)
{
    static const int64_t ppb[N] = { 3000, -18000, 20000, 0, -500 };
    struct rig *rig = rig_new(line, N);

    *state = rig;
    for (unsigned i = 0; i < N; i++)
        rig->slaves[i].dc.drift_ppb = ppb[i];
    rig_address(rig);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

static uint16_t station(unsigned i)
{
    return (uint16_t)(0x1001 + i);
}

static void latch(struct rig *rig)
{
    uint8_t data[4] = { 0 };

    exchange(rig, BWR, AT(0, REG_DC_PORT_TIME), data, 4);
}

static uint64_t read_u64(struct rig *rig, unsigned i, uint16_t ado)
{
    uint8_t bytes[8] = { 0 };

    assert_int_equal(exchange(rig, FPRD, AT(station(i), ado), bytes, 8), 1);
    return get_u64(bytes);
}

static void write_u64(struct rig *rig, unsigned i, uint16_t ado, uint64_t value)
{
    uint8_t bytes[8];

    put_u64(bytes, value);
    assert_int_equal(exchange(rig, FPWR, AT(station(i), ado), bytes, 8), 1);
}

static void write_u32(struct rig *rig, unsigned i, uint16_t ado, uint32_t value)
{
    uint8_t bytes[4];

    put_u32(bytes, value);
    assert_int_equal(exchange(rig, FPWR, AT(station(i), ado), bytes, 4), 1);
}

static uint32_t port_time(struct rig *rig, unsigned i, unsigned port)
{
    return read_u32(rig, station(i), (uint16_t)(REG_DC_PORT_TIME + 4 * port));
}

/* As masters do it: all slaves behind a slave and back, less those behind the next and back. */
static void delays_of_a_line_of_five_are_its_hops(void **state)
{
    struct rig *rig = *state;
    uint32_t there_and_back[N], delay = 0;

    latch(rig);
    for (unsigned i = 0; i < N; i++) {
        uint32_t t0 = port_time(rig, i, 0), t1 = port_time(rig, i, 1);

        there_and_back[i] = i + 1 < N ? t1 - t0 : 0;
        assert_int_equal(read_u64(rig, i, REG_DC_RECEIVE_TIME) & UINT32_MAX, t0);
    }
    for (unsigned i = 1; i < N; i++) {
        delay += (there_and_back[i - 1] - there_and_back[i]) / 2;
        assert_int_equal(delay, i * HOP);
    }
}

static void a_port_that_hears_nothing_keeps_its_time(void **state)
{
    struct rig *rig = *state;
    uint32_t before;

    latch(rig);
    assert_int_equal(port_time(rig, N - 1, 1), 0);
    before = port_time(rig, 1, 1);
    segment_cable(&rig->segment, 2, false, rig->now);
    latch(rig);
    assert_int_equal(port_time(rig, 1, 1), before);
    assert_int_not_equal(port_time(rig, 1, 0), 0);
    assert_int_equal(port_time(rig, 0, 1) - port_time(rig, 0, 0), 2 * HOP);
}

/* From behind: port 1 hears the frame first, port 0 on the way back from the break. */
static void port_times_behind_a_break_show_where_frames_come_from(void **state)
{
    struct rig *rig = *state;
    enum segment_port port = SEGMENT_PORT_B;
    uint32_t t[N][2];

    segment_close_ring(&rig->segment, true, rig->now);
    segment_cable(&rig->segment, 2, false, rig->now);
    frame_begin(rig);
    frame_add(rig, BWR, AT(0, REG_DC_PORT_TIME), NULL, 4);
    assert_true(frame_send_at(rig, &port));
    for (unsigned i = 0; i < N; i++) {
        t[i][0] = get_u32(rig->slaves[i].memory + REG_DC_PORT_TIME);
        t[i][1] = get_u32(rig->slaves[i].memory + REG_DC_PORT_TIME + 4);
    }
    assert_int_equal(t[1][0], 0);
    assert_int_equal(t[2][0], 0); /* its port 0 is dead */
    assert_int_not_equal(t[2][1], 0);
    assert_int_equal(t[3][0] - t[3][1], 2 * HOP);
    assert_int_equal(t[4][0] - t[4][1], 4 * HOP);
}

/* Every clock is set to show the first slave's time, with the delays of the line. */
static void set_clocks(struct rig *rig)
{
    uint8_t bytes[4];

    latch(rig);
    for (unsigned i = 0; i < N; i++) {
        uint64_t received = get_u64(rig->slaves[i].memory + REG_DC_RECEIVE_TIME);

        write_u64(rig, i, REG_DC_OFFSET, i * HOP - received);
        write_u32(rig, i, REG_DC_DELAY, i * HOP);
    }
    put_u16(bytes, 0x1000);
    exchange(rig, BWR, AT(0, REG_DC_SPEED_START), bytes, 2);
}

static void drift(struct rig *rig, unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        uint8_t bytes[8] = { 0 };

        rig_wait(rig, 990000);
        assert_int_equal(exchange(rig, FRMW, AT(station(0), REG_DC_SYSTEM_TIME), bytes, 8), N);
    }
}

/* System time there now, less that of the first slave at the same moment. */
static int64_t apart(struct rig *rig, unsigned i)
{
    slave_advance(&rig->slaves[0], rig->now + 10000);
    slave_advance(&rig->slaves[i], rig->now + 10000);
    return (int64_t)(dc_system_time(&rig->slaves[i]) - dc_system_time(&rig->slaves[0]));
}

static void clocks_run_apart_without_compensation_and_together_with_it(void **state)
{
    struct rig *rig = *state;

    set_clocks(rig);
    rig_wait(rig, 1000000000);
    for (unsigned i = 1; i < N; i++) {
        int64_t ppb = rig->slaves[i].dc.drift_ppb - rig->slaves[0].dc.drift_ppb;

        assert_in_range(apart(rig, i) - ppb + 2000, 0, 4000);
        assert_true(ppb > 100 || ppb < -100);
    }
    drift(rig, 3000);
    for (unsigned i = 1; i < N; i++) {
        assert_in_range(apart(rig, i) + 20, 0, 40);
        assert_in_range(read_u32(rig, station(i), REG_DC_DIFFERENCE) & 0x7fffffff, 0, 20);
    }
}

/* Beckhoff's formula gives the deviation back, to the unit. */
static void the_speed_counter_tells_the_trim(void **state)
{
    struct rig *rig = *state;

    set_clocks(rig);
    drift(rig, 2000);
    for (unsigned i = 1; i < N; i++) {
        int64_t diff = (int16_t)read_u16(rig, station(i), REG_DC_SPEED_DIFF);
        int64_t ppb = diff * 1000000000 / (5ll * 4098 * 4098);

        assert_in_range(ppb - rig->slaves[i].dc.trim_ppb + 12, 0, 24);
    }
}

static void a_write_of_the_speed_counter_start_forgets_the_difference(void **state)
{
    struct rig *rig = *state;

    set_clocks(rig);
    drift(rig, 100);
    write_u16(rig, station(2), REG_DC_SPEED_START, 0x1000);
    assert_int_equal(read_u32(rig, station(2), REG_DC_DIFFERENCE), 0);
    assert_int_equal(rig->slaves[2].dc.trim_ppb, 0);
}

static void an_offset_moves_system_time_at_once(void **state)
{
    struct rig *rig = *state;
    uint64_t before = read_u64(rig, 0, REG_DC_SYSTEM_TIME);

    write_u64(rig, 0, REG_DC_OFFSET, UINT64_C(788918400000000000));
    assert_in_range(read_u64(rig, 0, REG_DC_SYSTEM_TIME) - before - UINT64_C(788918400000000000),
                    19999, 20001);
}

static void power_on_starts_the_clock_anew(void **state)
{
    struct rig *rig = *state;

    set_clocks(rig);
    rig_wait(rig, 2000000000);
    segment_power(&rig->segment, 4, false, rig->now);
    segment_power(&rig->segment, 4, true, rig->now);
    rig_address(rig);
    assert_in_range(read_u64(rig, 4, REG_DC_SYSTEM_TIME), 0, 600000000);
    assert_int_equal(read_u64(rig, 4, REG_DC_OFFSET), 0);
}

static void a_clock_for_delays_only_shows_port_times_and_nothing_else(void **state)
{
    static struct device_type type;
    struct rig *rig = *state;
    struct slave_setup one = { .device = rig->devices[0], .seed = 7 };
    uint8_t data[8] = { 0 };

    type = *rig->slaves[0].type;
    type.dc_delay_only = true;
    one.type = &type;
    assert_int_equal(slave_init(&rig->slaves[0], &one), 0);
    segment_init(&rig->segment, rig->slaves, 1);
    assert_int_equal(exchange(rig, BWR, AT(0, REG_DC_PORT_TIME), data, 4), 1);
    assert_int_equal(exchange(rig, BRD, AT(0, REG_FEATURES), data, 2), 1);
    assert_int_equal(data[0] & FEATURE_DC, FEATURE_DC);
    for (uint16_t ado = REG_DC_SYSTEM_TIME; ado < 0x09d0; ado++)
        assert_int_equal(exchange(rig, BRD, AT(0, ado), data, 1), 0);
}

/* --- SYNC --- */

static struct {
    uint64_t at[2][64];
    unsigned count[2];
} pulses;

static void note(void *device, unsigned signal, uint64_t now_ns)
{
    (void)device;
    if (pulses.count[signal] < 64)
        pulses.at[signal][pulses.count[signal]] = now_ns;
    pulses.count[signal]++;
}

/* Slave 0 with a device that notes its pulses; its clock shows virtual time without drift. */
static void listen(struct rig *rig)
{
    static struct device_type type;

    type = *rig->slaves[0].type;
    type.sync = note;
    rig->slaves[0].type = &type;
    rig->slaves[0].dc.drift_ppb = 0;
    rig->slaves[0].dc.anchor_local = (int64_t)rig->now;
    rig->slaves[0].dc.anchor_ns = rig->slaves[0].now_ns = rig->now;
    memset(&pulses, 0, sizeof pulses);
}

static void start(struct rig *rig, uint64_t at, uint32_t cycle0, uint32_t cycle1, uint8_t how)
{
    write_u8(rig, station(0), REG_DC_ACTIVATION, 0);
    write_u8(rig, station(0), REG_DC_CUC, 0);
    write_u64(rig, 0, REG_DC_START, at);
    write_u32(rig, 0, REG_DC_CYCLE0, cycle0);
    write_u32(rig, 0, REG_DC_CYCLE1, cycle1);
    write_u8(rig, station(0), REG_DC_ACTIVATION, how);
}

static void let_pass(struct rig *rig, uint64_t until)
{
    rig->now = until;
    slave_advance(&rig->slaves[0], until);
}

static void sync0_comes_at_its_start_time_and_every_cycle(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 100000000, 1000000, 0, 3);
    assert_int_equal(rig->slaves[0].memory[REG_DC_ACTIVATION], 3);
    assert_int_equal(read_u64(rig, 0, REG_DC_START), 100000000);
    assert_int_equal(read_u16(rig, station(0), REG_DC_ACTIVATION_STATUS) & 7, 1);
    let_pass(rig, 99999999);
    assert_int_equal(pulses.count[0], 0);
    let_pass(rig, 110000000);
    assert_int_equal(pulses.count[0], 11);
    for (unsigned i = 0; i < 11; i++)
        assert_int_equal(pulses.at[0][i], 100000000 + i * 1000000);
    assert_int_equal(pulses.count[1], 0);
    assert_int_equal(read_u64(rig, 0, REG_DC_START), 111000000);
    assert_int_equal(read_u16(rig, station(0), REG_DC_ACTIVATION_STATUS) & 7, 0);
    write_u8(rig, station(0), REG_DC_ACTIVATION, 0);
    let_pass(rig, 200000000);
    assert_int_equal(pulses.count[0], 11);
}

/* However the time is cut, pulses come at the same moments. */
static void pulses_do_not_depend_on_frames_in_between(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 10000000, 250000, 125000, 7);
    for (uint64_t t = rig->now; t < 20000000; t += 7919)
        let_pass(rig, t);
    assert_int_equal(pulses.count[0], 40);
    assert_int_equal(pulses.count[1], 40);
    for (unsigned i = 0; i < 40; i++) {
        assert_int_equal(pulses.at[0][i], 10000000 + i * 250000);
        assert_int_equal(pulses.at[1][i], 10125000 + i * 250000);
    }
}

static void sync1_with_a_long_time_comes_every_few_sync0(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 10000000, 1000000, 3000000, 7);
    let_pass(rig, 22000000);
    assert_int_equal(pulses.count[0], 13);
    assert_int_equal(pulses.count[1], 3);
    for (unsigned i = 0; i < 3; i++)
        assert_int_equal(pulses.at[1][i], 13000000 + i * 4000000);
    assert_int_equal(read_u64(rig, 0, REG_DC_NEXT1), 25000000);
}

static void sync1_without_a_time_comes_with_every_sync0(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 10000000, 1000000, 0, 7);
    let_pass(rig, 12000000);
    assert_int_equal(pulses.count[0], 3);
    assert_int_equal(pulses.count[1], 3);
    assert_int_equal(pulses.at[1][2], 12000000);
}

static void without_a_cycle_there_is_a_single_shot(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 10000000, 0, 5000, 7);
    let_pass(rig, 1000000000);
    assert_int_equal(pulses.count[0], 1);
    assert_int_equal(pulses.count[1], 1);
    assert_int_equal(pulses.at[1][0], 10005000);
}

static void a_start_time_in_the_past_gives_no_pulse(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    rig_wait(rig, 50000000);
    start(rig, 1000, 1000000, 0, 3);
    let_pass(rig, 2000000000);
    assert_int_equal(pulses.count[0], 0);
    assert_int_equal(read_u16(rig, station(0), REG_DC_ACTIVATION_STATUS) & 7, 5);
    assert_int_equal(read_u64(rig, 0, REG_DC_START), 1000);
}

static void the_plausibility_check_starts_at_once_instead(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    rig_wait(rig, 50000000);
    start(rig, 1000, 1000000, 0, 0x23);
    let_pass(rig, rig->now + 900000);
    assert_int_equal(pulses.count[0], 1);
    assert_int_equal(read_u16(rig, station(0), REG_DC_ACTIVATION_STATUS) & 7, 4);
    /* With the narrow window a start in three seconds is too far. */
    start(rig, rig->now + 3000000000, 1000000, 0, 0x63);
    let_pass(rig, rig->now + 500000);
    assert_int_equal(pulses.count[0], 2);
}

static void a_start_time_of_32_bits_means_the_next_such_moment(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    write_u64(rig, 0, REG_DC_OFFSET, UINT64_C(0x500000000));
    start(rig, 100000000, 1000000, 0, 0x13);
    let_pass(rig, 101000000);
    assert_int_equal(pulses.count[0], 2);
    assert_int_equal(pulses.at[0][0], 100000000);
}

static void writing_the_start_time_can_activate(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 0, 1000000, 0, 0x0a);
    let_pass(rig, 20000000);
    assert_int_equal(pulses.count[0], 0);
    write_u64(rig, 0, REG_DC_START, 30000000);
    assert_int_equal(rig->slaves[0].memory[REG_DC_ACTIVATION], 0x0b);
    let_pass(rig, 30500000);
    assert_int_equal(pulses.count[0], 1);
}

static void a_test_pulse_comes_at_once(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    write_u8(rig, station(0), REG_DC_ACTIVATION, 0x84);
    assert_int_equal(pulses.count[0], 0);
    assert_int_equal(pulses.count[1], 1);
    assert_int_equal(rig->slaves[0].memory[REG_DC_ACTIVATION], 0x04);
}

/* `at` is the first nanosecond at which the slave's clock shows `system_time`, or is past it. */
static void check_moment(struct slave *s, uint64_t at, uint64_t system_time)
{
    uint64_t now = s->frame_ns;

    s->frame_ns = at - 1;
    assert_true(dc_system_time(s) < system_time);
    s->frame_ns = at;
    assert_true(dc_system_time(s) >= system_time);
    s->frame_ns = now;
}

static void a_pulse_comes_in_time_when_the_clock_is_trimmed_meanwhile(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    start(rig, 500000000, 0, 0, 3);
    /* Received far ahead: the loop pulls with all it has. */
    write_u64(rig, 0, REG_DC_SYSTEM_TIME, 100000000);
    assert_true(rig->slaves[0].dc.trim_ppb > 100000);
    let_pass(rig, 500000000);
    assert_int_equal(pulses.count[0], 1);
    check_moment(&rig->slaves[0], pulses.at[0][0], 500000000);
}

static void pulses_follow_the_drifting_clock_of_the_slave(void **state)
{
    struct rig *rig = *state;

    listen(rig);
    rig->slaves[0].dc.drift_ppb = -20000; /* 20 us late a second */
    start(rig, 1000000000, 1000000, 0, 3);
    let_pass(rig, 1001500000);
    assert_int_equal(pulses.count[0], 2);
    assert_in_range(pulses.at[0][0], 1000019900, 1000020100);
    check_moment(&rig->slaves[0], pulses.at[0][0], 1000000000);
    check_moment(&rig->slaves[0], pulses.at[0][1], 1001000000);
}

static void pulses_of_locked_slaves_coincide(void **state)
{
    struct rig *rig = *state;
    uint64_t at, first;

    listen(rig);
    rig->slaves[1].type = rig->slaves[0].type;
    rig->slaves[0].dc.drift_ppb = 9000;
    set_clocks(rig);
    drift(rig, 3000);
    at = (read_u64(rig, 0, REG_DC_SYSTEM_TIME) + 100000000) / 1000000 * 1000000;
    for (unsigned i = 0; i < 2; i++) {
        write_u64(rig, i, REG_DC_START, at);
        write_u32(rig, i, REG_DC_CYCLE0, 1000000);
        write_u8(rig, station(i), REG_DC_ACTIVATION, 3);
    }
    drift(rig, 200);
    assert_in_range(pulses.count[0], 180, 220);
    /* Both note in turn: pairs within 40 ns. */
    for (unsigned i = 0; i < 60; i += 2) {
        first = pulses.at[0][i];
        assert_in_range(pulses.at[0][i + 1] - first + 40, 0, 80);
    }
}

static void without_pulse_length_sync_stands_until_acknowledged(void **state)
{
    struct rig *rig = *state;
    struct slave *s = &rig->slaves[1];

    s->dc.drift_ppb = 0;
    write_u64(rig, 1, REG_DC_START, read_u64(rig, 1, REG_DC_SYSTEM_TIME) + 1000000);
    write_u32(rig, 1, REG_DC_CYCLE0, 1000000);
    write_u8(rig, station(1), REG_DC_ACTIVATION, 3);
    assert_int_equal(read_u32(rig, station(1), REG_AL_EVENT) & AL_EVENT_SYNC0, 0);
    rig_wait(rig, 1500000);
    assert_int_equal(read_u32(rig, station(1), REG_AL_EVENT) & AL_EVENT_SYNC0, AL_EVENT_SYNC0);
    assert_int_equal(read_u16(rig, station(1), REG_DC_SYNC_STATUS), 1);
}

static void sync_settings_of_the_pdi_are_not_the_masters(void **state)
{
    struct rig *rig = *state;

    write_u8(rig, station(0), REG_DC_CUC, 1);
    assert_int_equal(write_u8(rig, station(0), REG_DC_ACTIVATION, 3), 0);
    assert_int_equal(write_u16(rig, station(0), REG_DC_CYCLE0, 3), 0);
    assert_int_equal(rig->slaves[0].memory[REG_DC_ACTIVATION], 0);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(delays_of_a_line_of_five_are_its_hops),
        T(a_port_that_hears_nothing_keeps_its_time),
        T(port_times_behind_a_break_show_where_frames_come_from),
        T(clocks_run_apart_without_compensation_and_together_with_it),
        T(the_speed_counter_tells_the_trim),
        T(a_write_of_the_speed_counter_start_forgets_the_difference),
        T(an_offset_moves_system_time_at_once),
        T(power_on_starts_the_clock_anew),
        T(a_clock_for_delays_only_shows_port_times_and_nothing_else),
        T(sync0_comes_at_its_start_time_and_every_cycle),
        T(pulses_do_not_depend_on_frames_in_between),
        T(sync1_with_a_long_time_comes_every_few_sync0),
        T(sync1_without_a_time_comes_with_every_sync0),
        T(without_a_cycle_there_is_a_single_shot),
        T(a_start_time_in_the_past_gives_no_pulse),
        T(the_plausibility_check_starts_at_once_instead),
        T(a_start_time_of_32_bits_means_the_next_such_moment),
        T(writing_the_start_time_can_activate),
        T(a_test_pulse_comes_at_once),
        T(a_pulse_comes_in_time_when_the_clock_is_trimmed_meanwhile),
        T(pulses_follow_the_drifting_clock_of_the_slave),
        T(pulses_of_locked_slaves_coincide),
        T(without_pulse_length_sync_stands_until_acknowledged),
        T(sync_settings_of_the_pdi_are_not_the_masters),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
