/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Cables, power, loops, the second port, damaged frames. */
#include "bus_rig.h"

#define N 5

static const enum segment_port A = SEGMENT_PORT_A, B = SEGMENT_PORT_B;

static const char *const line[N] = { "drive-cia402", "drive-cia402", "drive-cia402", "drive-cia402",
                                     "drive-cia402" };

static int setup(void **state)
{
    *state = rig_new(line, N);
    rig_address(*state);
    return 0;
}

static int setup_ring(void **state)
{
    struct rig *rig = rig_new(line, N);

    *state = rig;
    rig_address(rig);
    segment_close_ring(&rig->segment, true, rig->now);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

/* A BRD of the station addresses sent in at `from`: who answered, and where it came out. */
struct answer {
    bool back;
    enum segment_port at;
    unsigned wkc, adp;
    bool circulating;
};

static struct answer ask(struct rig *rig, enum segment_port from)
{
    struct answer answer = { .at = from };

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    answer.back = frame_send_at(rig, &answer.at);
    answer.wkc = frame_wkc(rig, 16);
    answer.adp = get_u16(rig->frame + 18);
    answer.circulating = get_u16(rig->frame + 22) & 0x4000;
    return answer;
}

static void check(struct rig *rig, enum segment_port from, enum segment_port at, unsigned slaves)
{
    struct answer answer = ask(rig, from);

    assert_true(answer.back);
    assert_int_equal(answer.at, at);
    assert_int_equal(answer.wkc, slaves);
    assert_int_equal(answer.adp, slaves);
    /* What came from behind and was processed has turned round at a dead port 0. */
    assert_int_equal(answer.circulating, from == SEGMENT_PORT_B && slaves > 0);
}

static unsigned dl_status(const struct rig *rig, size_t slave)
{
    return get_u16(rig->slaves[slave].memory + REG_DL_STATUS);
}

static unsigned counter(const struct rig *rig, size_t slave, unsigned reg)
{
    return rig->slaves[slave].memory[reg];
}

static void nothing_comes_back_at_port_b_of_a_line(void **state)
{
    struct rig *rig = *state;

    check(rig, A, A, N);
    assert_false(ask(rig, B).back);
    assert_int_equal(dl_status(rig, N - 1), 0x5613);
}

static void a_ring_passes_frames_through_processed_one_way_only(void **state)
{
    struct rig *rig = *state;

    check(rig, A, B, N);
    check(rig, B, A, 0);
    assert_int_equal(rig->frame[6], 0x10); /* no processing unit saw it */
    for (size_t i = 0; i < N; i++)
        assert_int_equal(dl_status(rig, i), 0x5a33);
}

static void a_line_broken_anywhere_ends_there(void **state)
{
    struct rig *rig = *state;

    for (size_t k = 1; k < N; k++) {
        segment_cable(&rig->segment, k, false, rig->now);
        check(rig, A, A, (unsigned)k);
        assert_int_equal(dl_status(rig, k - 1), 0x5613);
        segment_cable(&rig->segment, k, true, rig->now);
        check(rig, A, A, N);
        assert_int_equal(dl_status(rig, k - 1), 0x5a33);
    }
}

static void a_ring_broken_anywhere_gives_each_port_its_side(void **state)
{
    struct rig *rig = *state;

    for (size_t k = 0; k <= N; k++) {
        segment_cable(&rig->segment, k, false, rig->now);
        if (k)
            check(rig, A, A, (unsigned)k);
        else
            assert_false(ask(rig, A).back);
        if (k < N)
            check(rig, B, B, (unsigned)(N - k));
        else
            assert_false(ask(rig, B).back);
        segment_cable(&rig->segment, k, true, rig->now);
    }
    check(rig, A, B, N);
}

static void behind_a_break_slaves_process_in_wiring_order(void **state)
{
    struct rig *rig = *state;
    enum segment_port port = SEGMENT_PORT_B;

    segment_cable(&rig->segment, 2, false, rig->now);
    frame_begin(rig);
    frame_add(rig, APRD, AT(0, REG_STATION_ADDRESS), NULL, 2);
    frame_add(rig, APRD, AT(-2, REG_STATION_ADDRESS), NULL, 2);
    assert_true(frame_send_at(rig, &port));
    assert_int_equal(get_u16(frame_data(rig, 16)), 0x1003);
    assert_int_equal(get_u16(frame_data(rig, 30)), 0x1005);
}

static void two_breaks_leave_the_middle_alone(void **state)
{
    struct rig *rig = *state;

    segment_cable(&rig->segment, 1, false, rig->now);
    segment_cable(&rig->segment, 3, false, rig->now);
    check(rig, A, A, 1);
    check(rig, B, B, 2);
}

static void a_lost_link_is_counted_shown_and_signalled_at_both_ends(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 0x04, 0x00 };

    for (uint16_t station = 0x1001; station <= 0x1005; station++)
        read_u16(rig, station, REG_DL_STATUS);
    assert_int_equal(exchange(rig, BWR, AT(0, REG_ECAT_EVENT_MASK), data, 2), N);
    exchange(rig, BRD, AT(0, 0), data, 2);
    assert_int_equal(get_u16(rig->frame + 24), 0);
    segment_cable(&rig->segment, 2, false, rig->now);
    exchange(rig, BRD, AT(0, 0), data, 2);
    assert_int_equal(get_u16(rig->frame + 24), EVENT_DL_STATUS);
    assert_int_equal(read_u16(rig, 0x1002, REG_DL_STATUS), 0x5613);
    exchange(rig, BRD, AT(0, 0), data, 2);
    assert_int_equal(get_u16(rig->frame + 24), 0);
    segment_cable(&rig->segment, 2, true, rig->now);
    assert_int_equal(exchange(rig, FPRD, AT(0x1002, REG_LOST_LINK), data, 4), 1);
    assert_int_equal(get_u32(data), 0x00000100);
    assert_int_equal(exchange(rig, FPRD, AT(0x1003, REG_LOST_LINK), data, 4), 1);
    assert_int_equal(get_u32(data), 0x00000001);
    assert_int_equal(exchange(rig, FPRD, AT(0x1004, REG_LOST_LINK), data, 4), 1);
    assert_int_equal(get_u32(data), 0);
    /* Writing any of them clears them all. */
    assert_int_equal(write_u8(rig, 0x1002, REG_LOST_LINK + 3, 0), 1);
    assert_int_equal(counter(rig, 1, REG_LOST_LINK + 1), 0);
}

static void the_lost_link_counter_stops_at_255(void **state)
{
    struct rig *rig = *state;

    for (unsigned i = 0; i < 300; i++) {
        segment_cable(&rig->segment, 2, false, rig->now);
        segment_cable(&rig->segment, 2, true, rig->now);
    }
    assert_int_equal(counter(rig, 1, REG_LOST_LINK + 1), 0xff);
}

static void a_cut_off_slave_keeps_its_address_and_a_switched_off_one_does_not(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2];

    segment_cable(&rig->segment, 1, false, rig->now);
    rig_wait(rig, 1000000);
    assert_int_equal(exchange(rig, FPRD, AT(0x1002, 0), data, 2), 0);
    segment_cable(&rig->segment, 1, true, rig->now);
    assert_int_equal(exchange(rig, FPRD, AT(0x1002, 0), data, 2), 1);
    segment_power(&rig->segment, 1, false, rig->now);
    assert_int_equal(dl_status(rig, 0), 0x5613);
    check(rig, A, A, 1);
    segment_power(&rig->segment, 1, true, rig->now);
    check(rig, A, A, N);
    assert_int_equal(exchange(rig, FPRD, AT(0x1002, 0), data, 2), 0);
    assert_int_equal(exchange(rig, APRD, AT(-1, REG_STATION_ADDRESS), data, 2), 1);
    assert_int_equal(get_u16(data), 0);
    assert_int_equal(counter(rig, 0, REG_LOST_LINK + 1), 2);
    assert_int_equal(counter(rig, 1, REG_LOST_LINK), 0);
    assert_int_equal(counter(rig, 2, REG_LOST_LINK), 1);
}

static void a_switched_off_slave_parts_a_ring(void **state)
{
    struct rig *rig = *state;

    segment_power(&rig->segment, 2, false, rig->now);
    check(rig, A, A, 2);
    check(rig, B, B, 2);
}

static void a_frame_that_turned_round_once_is_destroyed_at_a_dead_port_0(void **state)
{
    struct rig *rig = *state;
    enum segment_port port = SEGMENT_PORT_B;

    segment_cable(&rig->segment, 2, false, rig->now);
    frame_begin(rig);
    frame_add(rig, BWR, AT(0, 0x1f00), "\x77", 1);
    frame_add(rig, NOP, 0, NULL, 2);
    put_u16(rig->frame + rig->last + 6, 0x4002);
    assert_false(frame_send_at(rig, &port));
    assert_int_equal(rig->slaves[2].memory[0x1f00], 0);
    /* In front of the break nothing turns round at a port 0. */
    frame_begin(rig);
    frame_add(rig, BWR, AT(0, 0x1f00), "\x77", 1);
    put_u16(rig->frame + rig->last + 6, 0x4001);
    assert_true(frame_send(rig));
    assert_int_equal(rig->slaves[1].memory[0x1f00], 0x77);
}

/* --- loop control --- */

static void a_port_closed_by_order_ends_the_line(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x0c), 1);
    /* Linked and communicating, but closed. */
    assert_int_equal(dl_status(rig, 1), 0x5e33);
    check(rig, A, A, 2);
    assert_int_equal(dl_status(rig, 2), 0x5a33);
    assert_int_equal(write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x00), 1);
    check(rig, A, A, N);
}

static void what_arrives_at_a_port_closed_by_order_is_lost(void **state)
{
    struct rig *rig = *state;

    write_u8(rig, 0x1003, REG_DL_CONTROL + 1, 0x03);
    assert_false(ask(rig, A).back);
    assert_int_equal(dl_status(rig, 2), 0x5b33);
}

static void a_port_opened_by_order_loses_frames_without_a_cable(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x08), 1);
    check(rig, A, A, N);
    segment_cable(&rig->segment, 2, false, rig->now);
    assert_int_equal(dl_status(rig, 1), 0x5213);
    assert_false(ask(rig, A).back);
}

static void temporary_loop_settings_go_back_after_a_second(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x03, 0x0c };

    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_DL_CONTROL), data, 2), 1);
    check(rig, A, A, 1);
    rig_wait(rig, 900000000);
    check(rig, A, A, 1);
    rig_wait(rig, 100000000);
    check(rig, A, A, N);
    assert_int_equal(read_u16(rig, 0x1001, REG_DL_CONTROL), 0x0001);
}

/* Even when the slave shut itself off from the master. */
static void temporarily_closed_port_0_comes_back(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x03, 0x03 };

    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_DL_CONTROL), data, 2), 1);
    assert_false(ask(rig, A).back);
    rig_wait(rig, 1000000000);
    check(rig, A, A, N);
}

static void an_auto_close_port_waits_to_be_told_or_for_a_frame(void **state)
{
    struct rig *rig = *state;

    write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x04);
    check(rig, A, B, N);
    segment_cable(&rig->segment, 2, false, rig->now);
    segment_cable(&rig->segment, 2, true, rig->now);
    assert_int_equal(dl_status(rig, 1), 0x5e33);
    check(rig, A, A, 2);
    write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x04);
    check(rig, A, B, N);
    segment_cable(&rig->segment, 2, false, rig->now);
    segment_cable(&rig->segment, 2, true, rig->now);
    /* A frame from behind is lost at the closed port and opens it. */
    assert_false(ask(rig, B).back);
    check(rig, A, B, N);
}

static void temporary_settings_that_change_nothing_end_as_well(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x03, 0x00 };

    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_DL_CONTROL), data, 2), 1);
    assert_int_equal(read_u16(rig, 0x1001, REG_DL_CONTROL), 0x0003);
    rig_wait(rig, 1000000000);
    assert_int_equal(read_u16(rig, 0x1001, REG_DL_CONTROL), 0x0001);
}

static void a_reset_opens_what_was_closed_by_order(void **state)
{
    struct rig *rig = *state;

    write_u8(rig, 0x1002, REG_DL_CONTROL + 1, 0x0c);
    check(rig, A, A, 2);
    for (const char *letter = "RES"; *letter; letter++)
        assert_int_equal(write_u8(rig, 0x1002, REG_ECAT_RESET, (uint8_t)*letter), 1);
    check(rig, A, A, N);
}

/* --- damage --- */

static void damage_is_counted_where_it_happened_and_further_on(void **state)
{
    static const struct {
        uint8_t rx0, forwarded0, forwarded1, unit;
    } want[N] = { { 0, 0, 1, 0 }, { 0, 0, 1, 0 }, { 1, 0, 1, 1 }, { 0, 1, 1, 1 }, { 0, 1, 0, 1 } };
    struct rig *rig = *state;

    segment_damage_next(&rig->segment, 2);
    frame_begin(rig);
    frame_add(rig, BWR, AT(0, 0x1f00), "\x77", 1);
    assert_false(frame_send(rig));
    for (size_t i = 0; i < N; i++) {
        assert_int_equal(rig->slaves[i].memory[0x1f00], i < 2 ? 0x77 : 0);
        assert_int_equal(counter(rig, i, REG_RX_ERRORS), want[i].rx0);
        assert_int_equal(counter(rig, i, REG_FORWARDED_ERRORS), want[i].forwarded0);
        assert_int_equal(counter(rig, i, REG_FORWARDED_ERRORS + 1), want[i].forwarded1);
        assert_int_equal(counter(rig, i, REG_PU_ERRORS), want[i].unit);
    }
    check(rig, A, A, N); /* one frame only */
}

static void damage_on_the_masters_own_cable_keeps_the_frame_from_everybody(void **state)
{
    struct rig *rig = *state;

    segment_damage_next(&rig->segment, 0);
    frame_begin(rig);
    frame_add(rig, BWR, AT(0, 0x1f00), "\x77", 1);
    assert_false(frame_send(rig));
    assert_int_equal(rig->slaves[0].memory[0x1f00], 0);
    assert_int_equal(counter(rig, 0, REG_RX_ERRORS), 1);
    assert_int_equal(counter(rig, 1, REG_RX_ERRORS), 0);
    assert_int_equal(counter(rig, 1, REG_FORWARDED_ERRORS), 1);
}

static void damage_waits_for_a_frame_that_comes_by(void **state)
{
    struct rig *rig = *state;

    segment_cable(&rig->segment, 2, false, rig->now);
    segment_damage_next(&rig->segment, 4);
    check(rig, A, A, 2);
    assert_false(ask(rig, B).back);
    assert_int_equal(counter(rig, 3, REG_RX_ERRORS + 2), 1); /* from behind: at its port 1 */
    assert_int_equal(counter(rig, 2, REG_FORWARDED_ERRORS + 1), 1);
    check(rig, B, B, 3);
}

/* --- time --- */

static void the_way_back_takes_as_long_as_the_way_is(void **state)
{
    struct rig *rig = *state;
    enum segment_port port = SEGMENT_PORT_A;
    uint64_t back, wire = (SEGMENT_FRAME_MIN + 24) * 80;

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    segment_transfer(&rig->segment, &port, rig->frame, 60, 1000000, &back);
    assert_int_equal(back, 1000000 + wire + (N + 1) * HOP);
    segment_cable(&rig->segment, 2, false, 1000000);
    port = SEGMENT_PORT_A;
    segment_transfer(&rig->segment, &port, rig->frame, 60, 1000000, &back);
    assert_int_equal(back, 1000000 + wire + 2 * 2 * HOP);
    port = SEGMENT_PORT_B;
    put_u16(rig->frame + 22, 2);
    segment_transfer(&rig->segment, &port, rig->frame, 60, 1000000, &back);
    assert_int_equal(back, 1000000 + wire + 2 * 3 * HOP);
}

static void two_hundred_slaves_answer(void **state)
{
    struct slave *slaves = calloc(SEGMENT_SLAVES, sizeof *slaves);
    const struct device_type *type = device_type_find("dio-8x8");
    uint8_t *devices = calloc(SEGMENT_SLAVES, type->size);
    struct rig *rig = *state;

    assert_non_null(slaves);
    assert_non_null(devices);
    for (size_t i = 0; i < SEGMENT_SLAVES; i++) {
        struct slave_setup one = { .type = type, .device = devices + i * type->size, .seed = i };

        assert_int_equal(slave_init(&slaves[i], &one), 0);
    }
    segment_init(&rig->segment, slaves, SEGMENT_SLAVES);
    check(rig, A, A, SEGMENT_SLAVES);
    segment_cable(&rig->segment, 150, false, rig->now);
    check(rig, A, A, 150);
    free(slaves);
    free(devices);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
#define R(test) cmocka_unit_test_setup_teardown(test, setup_ring, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(nothing_comes_back_at_port_b_of_a_line),
        R(a_ring_passes_frames_through_processed_one_way_only),
        T(a_line_broken_anywhere_ends_there),
        R(a_ring_broken_anywhere_gives_each_port_its_side),
        R(behind_a_break_slaves_process_in_wiring_order),
        R(two_breaks_leave_the_middle_alone),
        T(a_lost_link_is_counted_shown_and_signalled_at_both_ends),
        T(the_lost_link_counter_stops_at_255),
        T(a_cut_off_slave_keeps_its_address_and_a_switched_off_one_does_not),
        R(a_switched_off_slave_parts_a_ring),
        R(a_frame_that_turned_round_once_is_destroyed_at_a_dead_port_0),
        T(a_port_closed_by_order_ends_the_line),
        T(what_arrives_at_a_port_closed_by_order_is_lost),
        T(a_port_opened_by_order_loses_frames_without_a_cable),
        T(temporary_loop_settings_go_back_after_a_second),
        T(temporarily_closed_port_0_comes_back),
        R(an_auto_close_port_waits_to_be_told_or_for_a_frame),
        T(temporary_settings_that_change_nothing_end_as_well),
        T(a_reset_opens_what_was_closed_by_order),
        T(damage_is_counted_where_it_happened_and_further_on),
        T(damage_on_the_masters_own_cable_keeps_the_frame_from_everybody),
        R(damage_waits_for_a_frame_that_comes_by),
        R(the_way_back_takes_as_long_as_the_way_is),
        T(two_hundred_slaves_answer),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
