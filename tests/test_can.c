/* SPDX-License-Identifier: GPL-2.0-or-later */
/* CAN of a PLC: the script of the other end, the buses, the memory that a module sees. */
#include "tests/host_rig.h"

#include <errno.h>

#include "host/can.h"

#define MS UINT64_C(1000000)

static struct can can;
static char why[CAN_WHY];

static void open_script(const char *script, unsigned buffer)
{
    if (can_open(&can, script, "peer", buffer, why) != 0)
        fail_msg("%s", why);
}

static void assert_refused(const char *script, const char *expected)
{
    assert_int_equal(can_open(&can, script, "peer", 1, why), -EINVAL);
    assert_string_equal(why, expected);
}

/* The next telegram at that time: "2:123 0102", channel, identifier, data. */
static const char *received(uint64_t now_ns)
{
    static char text[64];
    struct can_frame frame;
    unsigned channel;
    if (!can_receive(&can, now_ns, &channel, &frame))
        return "";
    int at = snprintf(text, sizeof text, "%u:%03x ", channel + 1, (unsigned)frame.id);
    for (unsigned i = 0; i < frame.length; i++)
        at += snprintf(text + at, sizeof text - (size_t)at, "%02x", frame.data[i]);
    return text;
}

static void telegrams_come_at_their_times(void **state)
{
    (void)state;
    open_script("# two of them\n at 10ms send 0x123 01 02 03\n\nevery 4ms from 1ms send 0x7FF\n",
                1);
    assert_string_equal(received(1 * MS), ""); /* still on the bus: 47 bits are 94 us */
    assert_string_equal(received(1 * MS + 93999), "");
    assert_string_equal(received(1 * MS + 94000), "1:7ff ");
    assert_string_equal(received(9 * MS), "1:7ff ");
    assert_string_equal(received(9 * MS), "");
    assert_string_equal(received(20 * MS), "1:7ff ");
    assert_string_equal(received(20 * MS), "1:123 010203");
    assert_string_equal(received(20 * MS), "1:7ff ");
    assert_string_equal(received(20 * MS), "1:7ff ");
    assert_string_equal(received(20 * MS), "");
}

static void a_telegram_takes_its_bits_at_the_speed(void **state)
{
    const struct can_frame frame = { .id = 1, .length = 8 };
    (void)state;
    open_script("baud 125\nloopback\n", 1);
    assert_true(can_transmit(&can, 0, &frame, 0));
    assert_string_equal(received(887999), ""); /* 111 bits */
    assert_string_equal(received(888000), "1:001 0000000000000000");
}

static void the_buffer_is_full_until_a_telegram_is_gone(void **state)
{
    const struct can_frame frame = { .id = 1, .length = 8 };
    (void)state;
    open_script("", 2);
    assert_true(can_transmit(&can, 0, &frame, 0));
    assert_true(can_transmit(&can, 0, &frame, 0));
    assert_false(can_transmit(&can, 0, &frame, 0));
    assert_true(can_transmit(&can, 1, &frame, 0)); /* the other bus is another one */
    assert_int_equal(can_waiting(&can, 0, 221999), 2);
    assert_int_equal(can_waiting(&can, 0, 222000), 1); /* 111 bits at 500 kbit/s */
    assert_true(can_transmit(&can, 0, &frame, 222000));
    assert_int_equal(can_waiting(&can, 0, 444000), 1);
    assert_int_equal(can_waiting(&can, 0, 666000), 0);
}

static void what_is_no_telegram_is_not_sent(void **state)
{
    const struct can_frame far = { .id = 0x800 }, lng = { .length = 9 }, good = { 0 };
    (void)state;
    open_script("", 1);
    assert_false(can_transmit(&can, 0, &far, 0));
    assert_false(can_transmit(&can, 0, &lng, 0));
    assert_false(can_transmit(&can, CAN_CHANNELS, &good, 0));
    assert_true(can_transmit(&can, 0, &good, 0));
}

static void the_other_end_replies(void **state)
{
    const struct can_frame data = { .id = 0x200, .length = 1 },
                           remote = { .id = 0x200, .remote = true };
    (void)state;
    open_script("on 0x200 reply 0x201 aa\non 0x200 remote after 2ms reply 514 BB\n", 1);
    assert_true(can_transmit(&can, 0, &data, 0));
    assert_string_equal(received(219999), ""); /* two telegrams of 55 bits */
    assert_string_equal(received(220000), "1:201 aa");
    assert_true(can_transmit(&can, 0, &remote, MS));
    assert_string_equal(received(3 * MS), "");
    assert_string_equal(received(4 * MS), "1:202 bb");
    assert_string_equal(received(9 * MS), "");
}

static void channels_are_apart(void **state)
{
    const struct can_frame frame = { .id = 5 };
    (void)state;
    open_script("loopback\nchannel 2\nat 0ms send 0x9\non 5 reply 6\n", 1);
    assert_true(can_transmit(&can, 1, &frame, 0));
    assert_string_equal(received(MS), "2:009 ");
    assert_string_equal(received(MS), "2:006 ");
    assert_true(can_transmit(&can, 0, &frame, MS));
    assert_string_equal(received(2 * MS), "1:005 ");
    assert_string_equal(received(2 * MS), "");
}

static void more_than_there_is_room_for_waits_or_is_lost(void **state)
{
    (void)state;
    open_script("every 1us send 1 00\n", 1);
    unsigned count = 0;
    while (received(10 * MS)[0] != '\0')
        count++;
    assert_true(count > CAN_PENDING);
    assert_int_equal(can.lost, 0);
}

static void scripts_are_refused_with_line_and_word(void **state)
{
    (void)state;
    assert_refused("loopback\nsend 1", "peer:2: at, every, on, baud, loopback or channel expected, "
                                       "not 'send'");
    assert_refused("at 10 send 1", "peer:1: a time, as in 10ms expected, not '10'");
    assert_refused("at", "peer:1: a time, as in 10ms expected at the end of the line");
    assert_refused("at 1ms send 0x800", "peer:1: an identifier up to 0x7FF expected, not '0x800'");
    assert_refused("at 1ms send 1 100", "peer:1: a byte in hexadecimal expected, not '100'");
    assert_refused("at 1ms send 1 1 2 3 4 5 6 7 8 9",
                   "peer:1: no more than eight bytes expected, not '9'");
    assert_refused("every 0ms send 1", "peer:1: a period above 0 expected, not '0ms'");
    assert_refused("baud 0", "peer:1: a speed of 1 to 1000 kbit/s expected, not '0'");
    assert_refused("channel 3", "peer:1: channel 1 or 2 expected, not '3'");
    assert_refused("loopback now", "peer:1: nothing more expected, not 'now'");
    assert_refused("on 1 send 2", "peer:1: reply expected, not 'send'");
    char many[CAN_RULES * 20] = "";
    for (int i = 0; i <= CAN_RULES; i++)
        strcat(many, "at 1ms send 1\n");
    assert_refused(many, "peer:65: more than 64 statements");
}

static void a_module_sends_and_receives(void **state)
{
    static const char *const products[] = { "pc4", "pc5" };
    (void)state;
    for (size_t p = 0; p < 2; p++) {
        const struct host_config config = { .product = product_find(products[p]),
                                            .can = "on 0x200 reply 0x201 07 08\n" };
        struct rig *rig = rig_open("talks", &config);
        assert_true(rig_get(rig, "MAIN.PLC_CAN_BaudRate") == 500);
        rig_start(rig);
        rig_cycles(rig, 1);
        assert_true(rig_get(rig, "DATA.I32[0]") == 1);
        assert_true(rig_get(rig, "DATA.I32[4]") == 0); /* a PC has room for one */
        assert_true(rig_get(rig, "DATA.I32[20]") == 0);
        assert_true(rig_get(rig, "DATA.I32[8]") == 0);
        assert_true(rig_get(rig, "MAIN.CAN_Transmit_Buffer_Fullness") == 1);
        rig_cycles(rig, 2);
        assert_true(rig_get(rig, "MAIN.CAN_Transmit_Buffer_Fullness") == 0);
        assert_true(rig_get(rig, "DATA.I32[8]") == 1);
        assert_true(rig_get(rig, "DATA.I32[12]") == 2);
        assert_true(rig_get(rig, "DATA.I32[16]") == 7);
        rig_close(rig);
    }
}

static void new_data_counts_telegrams(void **state)
{
    const struct host_config config = { .product = product_find("pc5"),
                                        .can = "every 1ms send 0x201 05\n" };
    (void)state;
    struct rig *rig = rig_open("talks", &config);
    rig_start(rig);
    rig_cycles(rig, 12);
    assert_true(rig_get(rig, "DATA.I32[8]") == 5);
    rig_close(rig);
}

static void without_a_script_there_is_no_can(void **state)
{
    const struct host_config config = { .product = product_find("pc4") };
    (void)state;
    struct rig *rig = rig_open("talks", &config);
    rig_start(rig);
    rig_cycles(rig, 4);
    assert_true(rig_get(rig, "DATA.I32[0]") == 0);
    assert_true(rig_get(rig, "DATA.I32[24]") == 4); /* it went on */
    assert_true(rig_get(rig, "DATA.I32[8]") == 0);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(telegrams_come_at_their_times),
        cmocka_unit_test(a_telegram_takes_its_bits_at_the_speed),
        cmocka_unit_test(the_buffer_is_full_until_a_telegram_is_gone),
        cmocka_unit_test(what_is_no_telegram_is_not_sent),
        cmocka_unit_test(the_other_end_replies),
        cmocka_unit_test(channels_are_apart),
        cmocka_unit_test(more_than_there_is_room_for_waits_or_is_lost),
        cmocka_unit_test(scripts_are_refused_with_line_and_word),
        cmocka_unit_test(a_module_sends_and_receives),
        cmocka_unit_test(new_data_counts_telegrams),
        cmocka_unit_test(without_a_script_there_is_no_can),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
