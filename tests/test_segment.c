/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Bytes on the wire: addressing, working counters, malformed frames. */
#include "bus_rig.h"

static const char *const three_drives[] = { "drive-cia402", "drive-cia402", "drive-cia402" };
static const char *const mixed[] = { "drive-cia402", "dio-8x8", "dio-8x8" };

static int setup_three(void **state)
{
    *state = rig_new(three_drives, 3);
    rig_address(*state);
    return 0;
}

static int setup_mixed(void **state)
{
    *state = rig_new(mixed, 3);
    rig_address(*state);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

static void brd_of_type_ors_all_slaves_and_counts_them_in_wkc_and_adp(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0, 0 };

    assert_int_equal(exchange(rig, BRD, AT(0, 0), data, 2), 3);
    assert_int_equal(data[0], 0x11);
    assert_int_equal(get_u16(rig->frame + 18), 3);
}

static void nop_changes_nothing_but_the_source_address(void **state)
{
    struct rig *rig = *state;
    uint8_t before[SEGMENT_FRAME_MIN], data[4] = { 1, 2, 3, 4 };

    frame_begin(rig);
    frame_add(rig, NOP, AT(0, 0x1000), data, sizeof data);
    memcpy(before, rig->frame, sizeof before);
    assert_true(frame_send(rig));
    before[6] |= 2;
    /* The DL status event reaches irq only where its mask is set. */
    assert_memory_equal(rig->frame, before, sizeof before);
}

static void source_address_gets_its_local_bit(void **state)
{
    struct rig *rig = *state;

    frame_begin(rig);
    frame_add(rig, NOP, 0, NULL, 2);
    assert_int_equal(rig->frame[6], 0x10);
    assert_true(frame_send(rig));
    assert_int_equal(rig->frame[6], 0x12);
}

static void auto_increment_reads_the_slave_at_the_position(void **state)
{
    struct rig *rig = *state;

    for (unsigned i = 0; i < 3; i++) {
        uint8_t data[2] = { 0 };

        assert_int_equal(exchange(rig, APRD, AT(-(int)i, REG_STATION_ADDRESS), data, 2), 1);
        assert_int_equal(get_u16(data), 0x1001 + i);
        assert_int_equal(get_u16(rig->frame + 18), (uint16_t)(3 - i));
    }
}

static void auto_increment_beyond_the_last_slave_reaches_nobody(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0xab, 0xcd };

    assert_int_equal(exchange(rig, APRD, AT(-3, REG_STATION_ADDRESS), data, 2), 0);
    assert_int_equal(data[0], 0xab);
    assert_int_equal(data[1], 0xcd);
}

static void aprw_swaps_memory_and_data_and_counts_three(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x11, 0x22 };

    assert_int_equal(exchange(rig, APWR, AT(0, 0x1800), data, 2), 1);
    data[0] = 0x33, data[1] = 0x44;
    assert_int_equal(exchange(rig, APRW, AT(0, 0x1800), data, 2), 3);
    assert_int_equal(get_u16(data), 0x2211);
    assert_int_equal(read_u16(rig, 0x1001, 0x1800), 0x4433);
}

static void fprw_and_fprd_and_fpwr_reach_only_the_station(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 7, 8 };

    assert_int_equal(exchange(rig, FPWR, AT(0x1002, 0x1800), data, 2), 1);
    assert_int_equal(get_u16(rig->frame + 18), 0x1002);
    assert_int_equal(read_u16(rig, 0x1001, 0x1800), 0);
    assert_int_equal(read_u16(rig, 0x1002, 0x1800), 0x0807);
    data[0] = 9;
    assert_int_equal(exchange(rig, FPRW, AT(0x1002, 0x1800), data, 2), 3);
    assert_int_equal(data[0], 7);
    assert_int_equal(read_u16(rig, 0x1002, 0x1800), 0x0809);
    assert_int_equal(exchange(rig, FPRD, AT(0x1009, 0x1800), data, 2), 0);
}

static void alias_addresses_only_while_dl_control_allows_it(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0 };

    put_u16(rig->slaves[1].memory + REG_STATION_ALIAS, 0x0777);
    assert_int_equal(exchange(rig, FPRD, AT(0x0777, 0), data, 2), 0);
    assert_int_equal(write_u8(rig, 0x1002, REG_DL_CONTROL + 3, 1), 1);
    assert_int_equal(exchange(rig, FPRD, AT(0x0777, 0), data, 2), 1);
}

static void bwr_writes_all_and_brw_returns_the_or_of_old_contents(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0x01 };

    assert_int_equal(exchange(rig, BWR, AT(0, 0x1800), data, 1), 3);
    data[0] = 0x10;
    assert_int_equal(exchange(rig, FPWR, AT(0x1003, 0x1800), data, 1), 1);
    data[0] = 0x80;
    assert_int_equal(exchange(rig, BRW, AT(0, 0x1800), data, 1), 9);
    assert_int_equal(data[0], 0x91);
    /* Each slave stored what arrived at it. */
    assert_int_equal(rig->slaves[0].memory[0x1800], 0x80);
    assert_int_equal(rig->slaves[1].memory[0x1800], 0x81);
    assert_int_equal(rig->slaves[2].memory[0x1800], 0x81);
}

static void armw_reads_the_positioned_slave_and_writes_the_others(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0x55 };

    rig->slaves[1].memory[0x1800] = 0xaa;
    assert_int_equal(exchange(rig, ARMW, AT(-1, 0x1800), data, 1), 3);
    assert_int_equal(data[0], 0xaa);
    assert_int_equal(rig->slaves[0].memory[0x1800], 0x55); /* in front: stale data */
    assert_int_equal(rig->slaves[2].memory[0x1800], 0xaa);
}

static void frmw_reads_the_station_and_writes_the_others(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0 };

    rig->slaves[0].memory[0x1800] = 0x77;
    assert_int_equal(exchange(rig, FRMW, AT(0x1001, 0x1800), data, 1), 3);
    assert_int_equal(data[0], 0x77);
    assert_int_equal(rig->slaves[1].memory[0x1800], 0x77);
    assert_int_equal(rig->slaves[2].memory[0x1800], 0x77);
}

static void unknown_command_passes_untouched(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0x42 };

    assert_int_equal(exchange(rig, 15, AT(0, 0), data, 1), 0);
    assert_int_equal(exchange(rig, 0xff, AT(0, 0), data, 1), 0);
    assert_int_equal(data[0], 0x42);
}

static void addresses_without_a_register_give_no_working_counter(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 1, 2, 3, 4 };

    assert_int_equal(exchange(rig, FPRD, AT(0x1001, 0x0f80), data, 4), 0);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, 0x0700), data, 4), 0);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, 0xfff0), data, 4), 0);
    assert_int_equal(data[0], 1);
}

static void a_read_only_register_counts_reads_and_not_writes(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0xee };

    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_TYPE), data, 1), 0);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_TYPE), data, 1), 1);
    assert_int_equal(data[0], 0x11);
}

static void a_slave_without_distributed_clock_is_absent_from_its_counters(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 0 };

    assert_int_equal(exchange(rig, BWR, AT(0, REG_DC_PORT_TIME), data, 4), 1);
    assert_int_equal(exchange(rig, BRD, AT(0, REG_FEATURES), data, 2), 3);
    assert_int_equal(data[0], FEATURE_DC | FEATURE_DC_64);
}

static void later_datagrams_of_a_frame_see_the_effect_of_earlier_ones(void **state)
{
    struct rig *rig = *state;
    uint8_t value = 0x99;
    size_t second;

    frame_begin(rig);
    frame_add(rig, FPWR, AT(0x1001, 0x1800), &value, 1);
    second = frame_add(rig, FPRD, AT(0x1001, 0x1800), NULL, 1);
    assert_true(frame_send(rig));
    assert_int_equal(frame_data(rig, second)[0], 0x99);
    assert_int_equal(frame_wkc(rig, second), 1);
}

/* Inputs of slave 2 to bits 0..3 and of slave 3 to bits 4..7 of one logical byte. */
static void lrw_with_two_fmmus_on_one_byte_keeps_the_other_bits(void **state)
{
    struct rig *rig = *state;
    uint8_t data[3] = { 0xff, 0xff, 0xff };

    rig->slaves[1].memory[0x1800] = 0xf5;
    rig->slaves[2].memory[0x1800] = 0x3a;
    write_fmmu(rig, 0x1002, 0, 0x00010001, 1, 0, 3, 0x1800, 0, 1);
    write_fmmu(rig, 0x1003, 0, 0x00010001, 1, 4, 6, 0x1800, 1, 1);
    assert_int_equal(exchange(rig, LRW, 0x00010000, data, 3), 2);
    /* Bits 0-3 = 5; bits 4-6 = (0x3a >> 1) & 7 = 5; bit 7 as it was. */
    assert_int_equal(data[1], 0xd5);
    assert_int_equal(data[0], 0xff);
    assert_int_equal(data[2], 0xff);
}

static void bitwise_write_keeps_the_physical_bits_outside_the_mapping(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0x0f };

    rig->slaves[1].memory[0x1800] = 0xa0;
    write_fmmu(rig, 0x1002, 0, 0, 1, 2, 3, 0x1800, 4, 2);
    assert_int_equal(exchange(rig, LRW, 0, data, 1), 2);
    /* Logical bits 2-3 (both set) land in physical bits 4-5. */
    assert_int_equal(rig->slaves[1].memory[0x1800], 0xb0);
    assert_int_equal(data[0], 0x0f);
}

static void a_bit_mapping_may_straddle_bytes(void **state)
{
    struct rig *rig = *state;
    uint8_t data[3] = { 0, 0, 0 };

    put_u16(rig->slaves[0].memory + 0x1800, 0xffff);
    write_fmmu(rig, 0x1001, 0, 0x100, 3, 6, 1, 0x1800, 3, 1);
    assert_int_equal(exchange(rig, LRD, 0x100, data, 3), 1);
    assert_int_equal(data[0], 0xc0);
    assert_int_equal(data[1], 0xff);
    assert_int_equal(data[2], 0x03);
}

static void logical_commands_count_read_one_write_one_or_two_once_per_slave(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 1, 2, 3, 4 };

    /* Two write mappings and two read mappings in one slave. */
    write_fmmu(rig, 0x1001, 0, 0, 1, 0, 7, 0x1800, 0, 2);
    write_fmmu(rig, 0x1001, 1, 1, 1, 0, 7, 0x1900, 0, 2);
    write_fmmu(rig, 0x1001, 2, 2, 1, 0, 7, 0x1a00, 0, 1);
    write_fmmu(rig, 0x1001, 3, 3, 1, 0, 7, 0x1b00, 0, 1);
    assert_int_equal(exchange(rig, LRD, 0, data, 4), 1);
    assert_int_equal(exchange(rig, LWR, 0, data, 4), 1);
    assert_int_equal(exchange(rig, LRW, 0, data, 4), 3);
    assert_int_equal(exchange(rig, LRW, 0, data, 2), 2);
    assert_int_equal(exchange(rig, LRW, 2, data, 2), 1);
    assert_int_equal(exchange(rig, LRW, 4, data, 4), 0);
    assert_int_equal(exchange(rig, LRW, 0xfffffffe, data, 2), 0);
}

static void lrw_with_overlapping_areas_writes_what_came_and_returns_what_was_there(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1] = { 0x12 };

    rig->slaves[0].memory[0x1800] = 0x34;
    write_fmmu(rig, 0x1001, 0, 0, 1, 0, 7, 0x1800, 0, 3);
    assert_int_equal(exchange(rig, LRW, 0, data, 1), 3);
    assert_int_equal(data[0], 0x34);
    assert_int_equal(rig->slaves[0].memory[0x1800], 0x12);
}

static void part_of_a_mapping_can_be_read(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0 };

    for (unsigned i = 0; i < 8; i++)
        rig->slaves[0].memory[0x1800 + i] = (uint8_t)(0x10 + i);
    write_fmmu(rig, 0x1001, 0, 0x1000, 8, 0, 7, 0x1800, 0, 1);
    assert_int_equal(exchange(rig, LRD, 0x1003, data, 2), 1);
    assert_int_equal(data[0], 0x13);
    assert_int_equal(data[1], 0x14);
}

static void a_mute_slave_leaves_logical_commands_alone_and_answers_others(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x12, 0x34 };

    write_fmmu(rig, 0x1001, 0, 0, 1, 0, 7, 0x1800, 0, 3);
    write_fmmu(rig, 0x1002, 0, 1, 1, 0, 7, 0x1800, 0, 3);
    rig->slaves[0].mute = true;
    assert_int_equal(exchange(rig, LRW, 0, data, 2), 3);
    assert_int_equal(data[0], 0x12);
    assert_int_equal(data[1], 0);
    assert_int_equal(rig->slaves[0].memory[0x1800], 0);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, 0x1800), data, 2), 1);
    rig->slaves[0].mute = false;
    assert_int_equal(exchange(rig, LRW, 0, data, 2), 6);
}

/* EK1100 and EL1004 as captured: types ORed, two counted, ADP moved on by two. */
static void brd_of_register_0_comes_back_as_captured(void **state)
{
    static const uint8_t sent[] = { 0x07, 0x5a, 0x00, 0x00, 0x00, 0x00, 0x02,
                                    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00 };
    static const uint8_t back[] = { 0x07, 0x5a, 0x02, 0x00, 0x00, 0x00, 0x02,
                                    0x00, 0x00, 0x00, 0x13, 0x01, 0x02, 0x00 };
    struct rig *rig = *state;

    rig->segment.slaves[1].memory[0] = 0x12;
    rig->segment.slaves[1].memory[1] = 0x01;
    segment_power(&rig->segment, 2, false, rig->now);
    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    assert_memory_equal(rig->frame + 16, sent, sizeof sent);
    assert_true(frame_send(rig));
    assert_memory_equal(rig->frame + 16, back, sizeof back);
}

/* The input mapping of an EL1004 and the output mapping of an AKD, byte for byte. */
static void captured_mappings_map_what_they_say(void **state)
{
    static const uint8_t el1004[16] = { 0, 0, 0, 0, 1, 0, 0, 3, 0x00, 0x10, 0, 1, 1 };
    static const uint8_t akd[16] = { 0, 0, 0, 0, 0x11, 0, 0, 7, 0x00, 0x11, 0, 2, 1 };
    struct rig *rig = *state;
    uint8_t data[0x11];

    memcpy(data, el1004, 16);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_FMMU), data, 16), 1);
    rig->slaves[0].memory[0x1000] = 0xf6;
    data[0] = 0xa0;
    assert_int_equal(exchange(rig, LRW, 0, data, 1), 1);
    assert_int_equal(data[0], 0xa6);
    memset(data, 0, 16);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_FMMU), data, 16), 1);
    memcpy(data, akd, 16);
    assert_int_equal(exchange(rig, FPWR, AT(0x1002, REG_FMMU), data, 16), 1);
    for (unsigned i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)(0x40 + i);
    assert_int_equal(exchange(rig, LWR, 0, data, sizeof data), 1);
    assert_memory_equal(rig->slaves[1].memory + 0x1100, data, sizeof data);
    assert_int_equal(rig->slaves[1].memory[0x1111], 0);
}

static void irq_carries_the_masked_events_of_all_slaves(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x04, 0x00 };

    assert_int_equal(exchange(rig, FPWR, AT(0x1002, REG_ECAT_EVENT_MASK), data, 2), 1);
    exchange(rig, BRD, AT(0, 0), data, 2);
    assert_int_equal(get_u16(rig->frame + 24), EVENT_DL_STATUS);
    read_u16(rig, 0x1002, REG_DL_STATUS);
    exchange(rig, BRD, AT(0, 0), data, 2);
    assert_int_equal(get_u16(rig->frame + 24), 0);
}

static void circulating_bit_and_index_come_back_untouched(void **state)
{
    struct rig *rig = *state;

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    put_u16(rig->frame + 22, get_u16(rig->frame + 22) | 0x4000u);
    assert_true(frame_send(rig));
    assert_int_equal(get_u16(rig->frame + 22) & 0x4000, 0x4000);
    assert_int_equal(rig->frame[17], 0x5a);
    assert_int_equal(frame_wkc(rig, 16), 3);
}

static void ports_show_a_line(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(read_u16(rig, 0x1001, REG_DL_STATUS), 0x5a33);
    assert_int_equal(read_u16(rig, 0x1002, REG_DL_STATUS), 0x5a33);
    assert_int_equal(read_u16(rig, 0x1003, REG_DL_STATUS), 0x5613);
}

static void port_times_differ_by_the_way_to_the_end_and_back(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 0 };

    exchange(rig, BWR, AT(0, REG_DC_PORT_TIME), data, 4);
    for (uint16_t i = 0; i < 2; i++) {
        uint16_t station = (uint16_t)(0x1001 + i);
        uint32_t t0 = read_u32(rig, station, REG_DC_PORT_TIME);
        uint32_t t1 = read_u32(rig, station, REG_DC_PORT_TIME + 4);

        assert_int_equal(t1 - t0, 2 * (2 - i) * SEGMENT_HOP_NS);
    }
    assert_int_equal(read_u32(rig, 0x1003, REG_DC_PORT_TIME + 4), 0);
}

static void frames_of_other_protocols_are_destroyed_unless_dl_control_forwards_them(void **state)
{
    struct rig *rig = *state;
    uint8_t off[1] = { 0 };

    frame_begin(rig);
    rig->frame[12] = 0x08;
    rig->frame[13] = 0x00;
    assert_false(frame_send(rig));
    assert_int_equal(exchange(rig, BWR, AT(0, REG_DL_CONTROL), off, 1), 3);
    frame_begin(rig);
    rig->frame[12] = 0x08;
    rig->frame[13] = 0x00;
    assert_true(frame_send(rig));
    assert_int_equal(rig->frame[6], 0x10);
}

static void frames_of_other_ethercat_types_pass_unprocessed(void **state)
{
    struct rig *rig = *state;

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    rig->frame[15] = (uint8_t)((rig->frame[15] & 0x0f) | 5 << 4);
    assert_true(frame_send(rig));
    assert_int_equal(frame_wkc(rig, 16), 0);
}

static void a_datagram_longer_than_the_frame_is_dropped_and_counted(void **state)
{
    struct rig *rig = *state;
    uint8_t data[1];

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    put_u16(rig->frame + 22, 0x07ff);
    assert_false(frame_send(rig));
    exchange(rig, FPRD, AT(0x1001, REG_PU_ERRORS), data, 1);
    assert_int_equal(data[0], 1);
}

static void more_follows_without_anything_following_is_dropped(void **state)
{
    struct rig *rig = *state;

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    put_u16(rig->frame + 22, 0x8002);
    assert_false(frame_send(rig));
}

static void a_header_that_claims_more_than_the_frame_is_dropped(void **state)
{
    struct rig *rig = *state;

    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    put_u16(rig->frame + 14, 0x17ff);
    assert_false(frame_send(rig));
}

static void short_and_oversized_frames_are_dropped(void **state)
{
    struct rig *rig = *state;
    enum segment_port port = SEGMENT_PORT_A;
    static uint8_t large[2000];

    for (size_t length = 0; length < SEGMENT_FRAME_MIN; length++)
        assert_false(segment_transfer(&rig->segment, &port, large, length, rig->now, NULL));
    assert_false(
        segment_transfer(&rig->segment, &port, large, SEGMENT_FRAME_MAX + 1, rig->now, NULL));
}

static uint64_t random_state = 88172645463325252u;

static uint32_t random_u32(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (uint32_t)(random_state >> 16);
}

/* Heap blocks of exactly the frame's size, so that the sanitizer sees every byte too far. */
static void random_and_mutated_frames_never_reach_beyond_the_frame(void **state)
{
    struct rig *rig = *state;

    for (unsigned round = 0; round < 60000; round++) {
        enum segment_port port = SEGMENT_PORT_A;
        size_t length = SEGMENT_FRAME_MIN + random_u32() % (round % 8 ? 200 : 1455);
        uint8_t *frame = malloc(length);

        assert_non_null(frame);
        for (size_t i = 0; i < length; i++)
            frame[i] = (uint8_t)(round % 3 ? random_u32() : random_u32() & 3);
        frame[12] = 0x88;
        frame[13] = 0xa4;
        if (round % 4)
            put_u16(frame + 14, (random_u32() % (uint32_t)(length - 15)) | 1u << 12);
        frame[16] = (uint8_t)(random_u32() % 16);
        if (round % 2)
            put_u16(frame + 22, random_u32() % 64 | (random_u32() & 0x8000));
        if (round % 5 == 0)
            put_u16(frame + 20, 0x0f00 + random_u32() % 0x400);
        rig->now += 1000;
        segment_transfer(&rig->segment, &port, frame, length, rig->now, NULL);
        free(frame);
    }
    /* And it still answers, once ports that were told to close are opened by a power cycle. */
    for (size_t i = 0; i < rig->count; i++) {
        segment_power(&rig->segment, i, false, rig->now);
        segment_power(&rig->segment, i, true, rig->now);
    }
    frame_begin(rig);
    frame_add(rig, BRD, 0, NULL, 2);
    assert_true(frame_send(rig));
    assert_int_equal(frame_wkc(rig, 16), 3);
}

#define T(test)  cmocka_unit_test_setup_teardown(test, setup_three, teardown)
#define TM(test) cmocka_unit_test_setup_teardown(test, setup_mixed, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(brd_of_type_ors_all_slaves_and_counts_them_in_wkc_and_adp),
        T(nop_changes_nothing_but_the_source_address),
        T(source_address_gets_its_local_bit),
        T(auto_increment_reads_the_slave_at_the_position),
        T(auto_increment_beyond_the_last_slave_reaches_nobody),
        T(aprw_swaps_memory_and_data_and_counts_three),
        T(fprw_and_fprd_and_fpwr_reach_only_the_station),
        T(alias_addresses_only_while_dl_control_allows_it),
        T(bwr_writes_all_and_brw_returns_the_or_of_old_contents),
        T(armw_reads_the_positioned_slave_and_writes_the_others),
        T(frmw_reads_the_station_and_writes_the_others),
        T(unknown_command_passes_untouched),
        T(addresses_without_a_register_give_no_working_counter),
        T(a_read_only_register_counts_reads_and_not_writes),
        TM(a_slave_without_distributed_clock_is_absent_from_its_counters),
        T(later_datagrams_of_a_frame_see_the_effect_of_earlier_ones),
        T(lrw_with_two_fmmus_on_one_byte_keeps_the_other_bits),
        T(bitwise_write_keeps_the_physical_bits_outside_the_mapping),
        T(a_bit_mapping_may_straddle_bytes),
        T(logical_commands_count_read_one_write_one_or_two_once_per_slave),
        T(lrw_with_overlapping_areas_writes_what_came_and_returns_what_was_there),
        T(part_of_a_mapping_can_be_read),
        T(a_mute_slave_leaves_logical_commands_alone_and_answers_others),
        T(brd_of_register_0_comes_back_as_captured),
        T(captured_mappings_map_what_they_say),
        T(irq_carries_the_masked_events_of_all_slaves),
        T(circulating_bit_and_index_come_back_untouched),
        T(ports_show_a_line),
        T(port_times_differ_by_the_way_to_the_end_and_back),
        T(frames_of_other_protocols_are_destroyed_unless_dl_control_forwards_them),
        T(frames_of_other_ethercat_types_pass_unprocessed),
        T(a_datagram_longer_than_the_frame_is_dropped_and_counted),
        T(more_follows_without_anything_following_is_dropped),
        T(a_header_that_claims_more_than_the_frame_is_dropped),
        T(short_and_oversized_frames_are_dropped),
        TM(random_and_mutated_frames_never_reach_beyond_the_frame),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
