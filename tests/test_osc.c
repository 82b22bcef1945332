/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The recorder of the oscilloscope, without a controller around it. Numbers are those of the manual
 * where it has some. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "host/osc.h"

static int32_t count;
static double position;
static float ratio;
static int64_t wide;
static uint64_t memory[1024];

static struct osc_setup setup_of(uint32_t channels)
{
    const struct osc_setup setup = {
        .channels = { { &count, OSC_I32 }, { &position, OSC_F64 } },
        .channel_count = channels,
        .every = 1,
        .memory = (uint8_t *)memory,
        .bytes = sizeof memory,
    };

    memset(memory, 0xee, sizeof memory);
    count = 0;
    position = 0;
    return setup;
}

static int32_t stored_count(const struct osc *osc, uint32_t index)
{
    int32_t value;

    memcpy(&value, (uint8_t *)memory + osc->offset[0] + index * sizeof value, sizeof value);
    return value;
}

static void two_channels_share_the_memory_by_their_widths(void **state)
{
    struct osc_setup setup = setup_of(2);
    struct osc osc;

    (void)state;
    /* int32 and double: 1 to 2. */
    setup.bytes = 1048576 / 128;
    assert_true(osc_start(&osc, &setup));
    assert_int_equal(osc.samples, 8192 / 12);
    assert_int_equal(osc.offset[0], 0);
    assert_true(osc.offset[1] >= osc.samples * 4u && osc.offset[1] < osc.samples * 4u + 8);
    assert_true(osc.offset[1] + osc.samples * 8u <= setup.bytes);
    assert_int_equal(osc.offset[1] % 8, 0);
}

static void one_channel_has_all_of_it(void **state)
{
    struct osc_setup setup = setup_of(1);
    struct osc osc;

    (void)state;
    assert_true(osc_start(&osc, &setup));
    assert_int_equal(osc.samples, sizeof memory / 4);
}

static void the_first_cycle_is_sampled_and_then_every_third(void **state)
{
    struct osc_setup setup = setup_of(1);
    struct osc osc;

    (void)state;
    setup.every = 3;
    assert_true(osc_start(&osc, &setup));
    for (count = 100; count < 110; count++)
        assert_true(osc_cycle(&osc));
    assert_int_equal(osc.recorded, 4);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(stored_count(&osc, i), 100 + 3 * (int32_t)i);
}

static void it_stops_by_itself_when_the_memory_is_full(void **state)
{
    struct osc_setup setup = setup_of(1);
    struct osc osc;

    (void)state;
    setup.bytes = 40;
    assert_true(osc_start(&osc, &setup));
    for (count = 1; count < 10; count++)
        assert_true(osc_cycle(&osc));
    assert_false(osc_cycle(&osc));
    assert_int_equal(osc.state, OSC_IDLE);
    assert_int_equal(osc.recorded, 10);
    assert_int_equal(stored_count(&osc, 9), 10);
    assert_false(osc_cycle(&osc));
    assert_int_equal(memory[5], 0xeeeeeeeeeeeeeeee);
}

static struct osc_setup triggered(uint32_t edge, double level)
{
    struct osc_setup setup = setup_of(1);

    setup.trigger_count = 1;
    setup.triggers[0] = (struct osc_trigger){ { &count, OSC_I32 }, edge, level };
    return setup;
}

/* One cycle with the register at a value; is it recording? */
static bool with(struct osc *osc, int32_t value)
{
    count = value;
    osc_cycle(osc);
    return osc->state == OSC_RECORDING;
}

static void seventeen_then_twentytwo_crosses_twenty(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;

    (void)state;
    assert_true(osc_start(&osc, &setup));
    assert_int_equal(osc.state, OSC_WAITING);
    assert_false(with(&osc, 15));
    assert_false(with(&osc, 17));
    assert_int_equal(osc.recorded, 0);
    assert_true(with(&osc, 22));
    /* The cycle that triggers is the first sample. */
    assert_int_equal(osc.recorded, 1);
    assert_int_equal(stored_count(&osc, 0), 22);
}

static void reaching_the_level_exactly_is_crossing_it_and_leaving_it_is_not(void **state)
{
    struct osc_setup rising = triggered(OSC_RISING, 20), falling = triggered(OSC_FALLING, 20);
    struct osc osc;

    (void)state;
    assert_true(osc_start(&osc, &rising));
    assert_false(with(&osc, 19));
    assert_true(with(&osc, 20));
    assert_true(osc_start(&osc, &rising));
    assert_false(with(&osc, 20));
    assert_false(with(&osc, 21));
    assert_true(osc_start(&osc, &falling));
    assert_false(with(&osc, 30));
    assert_false(with(&osc, 21));
    assert_true(with(&osc, 20));
}

static void the_first_reading_does_not_trigger(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;

    (void)state;
    assert_true(osc_start(&osc, &setup));
    assert_false(with(&osc, 100));
    assert_false(with(&osc, 101));
    assert_false(with(&osc, 3));
    assert_true(with(&osc, 100));
}

static void a_falling_edge_is_no_rising_one(void **state)
{
    struct osc_setup setup = triggered(OSC_FALLING, 20);
    struct osc osc;

    (void)state;
    assert_true(osc_start(&osc, &setup));
    assert_false(with(&osc, 10));
    assert_false(with(&osc, 30));
    assert_true(with(&osc, 10));
}

static void the_trigger_is_judged_in_cycles_that_are_not_sampled(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;

    (void)state;
    setup.every = 10;
    assert_true(osc_start(&osc, &setup));
    for (int32_t i = 0; i < 4; i++)
        assert_false(with(&osc, 10));
    /* A pulse of one cycle. */
    assert_true(with(&osc, 25));
    for (int32_t i = 0; i < 9; i++)
        with(&osc, 10);
    assert_int_equal(osc.recorded, 1);
    with(&osc, 7);
    assert_int_equal(osc.recorded, 2);
    assert_int_equal(stored_count(&osc, 1), 7);
}

static void samples_from_before_the_trigger_are_kept(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 50);
    struct osc osc;

    (void)state;
    setup.bytes = 10 * 4;
    setup.pretrigger = 3;
    assert_true(osc_start(&osc, &setup));
    for (int32_t i = 26; i < 50; i++)
        assert_false(with(&osc, i));
    for (int32_t i = 50; i < 57; i++)
        with(&osc, i);
    assert_int_equal(osc.state, OSC_IDLE);
    assert_int_equal(osc.recorded, 10);
    for (uint32_t i = 0; i < 10; i++)
        assert_int_equal(stored_count(&osc, (osc.start + i) % 10), 47 + (int32_t)i);
}

static void fewer_are_kept_when_the_trigger_comes_early(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 50);
    struct osc osc;

    (void)state;
    setup.bytes = 10 * 4;
    setup.pretrigger = 5;
    assert_true(osc_start(&osc, &setup));
    with(&osc, 48);
    with(&osc, 49);
    assert_true(with(&osc, 50));
    assert_int_equal(osc.kept, 2);
    assert_int_equal(osc.start, 0);
    assert_int_equal(osc.recorded, 3);
}

static void a_pretrigger_as_large_as_the_memory_leaves_room_for_the_trigger(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 50);
    struct osc osc;

    (void)state;
    setup.bytes = 4 * 4;
    setup.pretrigger = 1000;
    assert_true(osc_start(&osc, &setup));
    for (int32_t i = 40; i < 51; i++)
        with(&osc, i);
    assert_int_equal(osc.state, OSC_IDLE);
    assert_int_equal(osc.recorded, 4);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(stored_count(&osc, (osc.start + i) % 4), 47 + (int32_t)i);
}

static void samples_stay_in_step_across_the_trigger_when_some_are_kept(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;

    (void)state;
    setup.bytes = 10 * 4;
    setup.every = 4;
    setup.pretrigger = 2;
    assert_true(osc_start(&osc, &setup));
    /* Sampled: 1, 5, 9, 13, 17; the trigger comes with 20, between two samples. */
    for (int32_t i = 1; i < 20; i++)
        assert_false(with(&osc, i));
    assert_true(with(&osc, 20));
    assert_int_equal(osc.recorded, 2);
    assert_int_equal(osc.lag, 1);
    for (int32_t i = 21; i < 30; i++)
        with(&osc, i);
    assert_int_equal(osc.recorded, 5);
    for (uint32_t i = 0; i < 5; i++)
        assert_int_equal(stored_count(&osc, (osc.start + i) % 10), 13 + 4 * (int32_t)i);
}

static void the_ring_before_the_trigger_wraps_in_an_endless_recording_too(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 50);
    struct osc osc;

    (void)state;
    setup.bytes = 8 * 4;
    setup.pretrigger = 3;
    setup.endless = true;
    assert_true(osc_start(&osc, &setup));
    for (int32_t i = 20; i < 61; i++)
        with(&osc, i);
    assert_int_equal(osc.state, OSC_RECORDING);
    assert_int_equal(osc.recorded, 3 + 11);
    for (uint32_t i = 0; i < 8; i++)
        assert_int_equal(stored_count(&osc, (osc.start + i) % 8), 53 + (int32_t)i);
}

static void its_own_memory_may_be_recorded(void **state)
{
    struct osc_setup setup = setup_of(2);
    struct osc osc;

    (void)state;
    /* Channel 1 reads the very place that it is stored to, and then that place again. */
    setup.bytes = 4 * 12;
    setup.channels[1] = (struct osc_source){ (uint8_t *)memory + 16, OSC_F64 };
    memory[2] = 0x1122334455667788;
    assert_true(osc_start(&osc, &setup));
    assert_int_equal(osc.offset[1], 16);
    for (int i = 0; i < 4; i++)
        osc_cycle(&osc);
    for (size_t i = 2; i < 6; i++)
        assert_int_equal(memory[i], 0x1122334455667788);
}

static void a_value_that_is_no_number_never_triggers(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;
    const double readings[] = { 10, __builtin_nan(""), 30, 31, 10 };

    (void)state;
    setup.triggers[0].source = (struct osc_source){ &position, OSC_F64 };
    assert_true(osc_start(&osc, &setup));
    for (size_t i = 0; i < sizeof readings / sizeof *readings; i++) {
        position = readings[i];
        osc_cycle(&osc);
        assert_int_equal(osc.state, OSC_WAITING);
    }
    position = 20;
    osc_cycle(&osc);
    assert_int_equal(osc.state, OSC_RECORDING);
}

static void endless_recording_keeps_the_newest(void **state)
{
    struct osc_setup setup = setup_of(1);
    struct osc osc;

    (void)state;
    setup.bytes = 8 * 4;
    setup.endless = true;
    assert_true(osc_start(&osc, &setup));
    for (count = 0; count < 9; count++)
        assert_true(osc_cycle(&osc));
    assert_int_equal(osc.start, 1);
    for (; count < 21; count++)
        assert_true(osc_cycle(&osc));
    assert_int_equal(osc.recorded, 21);
    for (uint32_t i = 0; i < 8; i++)
        assert_int_equal(stored_count(&osc, (osc.start + i) % 8), 13 + (int32_t)i);
}

static void packed_samples_lie_behind_one_another(void **state)
{
    struct osc_setup setup = setup_of(2);
    struct osc osc;
    double value;

    (void)state;
    setup.packed = true;
    setup.bytes = 100;
    assert_true(osc_start(&osc, &setup));
    assert_int_equal(osc.samples, 100 / 12);
    for (count = 1; count <= 3; count++) {
        position = count * 1.5;
        osc_cycle(&osc);
    }
    for (int32_t i = 0; i < 3; i++) {
        int32_t number;

        memcpy(&number, (uint8_t *)memory + 12 * i, sizeof number);
        memcpy(&value, (uint8_t *)memory + 12 * i + 4, sizeof value);
        assert_int_equal(number, i + 1);
        assert_true(value == (i + 1) * 1.5);
    }
}

static void any_or_all_of_several_triggers(void **state)
{
    struct osc_setup setup = triggered(OSC_RISING, 20);
    struct osc osc;

    (void)state;
    setup.trigger_count = 2;
    setup.triggers[1] = (struct osc_trigger){ { &position, OSC_F64 }, OSC_FALLING, -1.0 };
    for (int all = 0; all <= 1; all++) {
        setup.all = all != 0;
        position = 0;
        assert_true(osc_start(&osc, &setup));
        assert_false(with(&osc, 10));
        /* An edge counts from when it was armed, not only in its own cycle. */
        assert_int_equal(with(&osc, 30), !all);
        assert_int_equal(with(&osc, 10), !all);
        position = -2.0;
        assert_true(with(&osc, 10));
    }
}

static void every_type_is_read_as_what_it_is(void **state)
{
    const int32_t i32 = -5;
    const uint32_t u32 = 4000000000u;
    const int64_t i64 = -6000000000;
    const uint64_t u64 = 1u;
    const struct {
        struct osc_source source;
        double value;
        uint32_t width;
    } rows[] = {
        { { &i32, OSC_I32 }, -5, 4 },        { { &i32, OSC_I32_HEX }, -5, 4 },
        { { &i32, OSC_I32_BIN }, -5, 4 },    { { &i32, OSC_I32_BITS }, -5, 4 },
        { { &u32, OSC_U32 }, 4e9, 4 },       { { &i64, OSC_I64 }, -6e9, 8 },
        { { &i64, OSC_I64_HEX }, -6e9, 8 },  { { &i64, OSC_I64_BIN }, -6e9, 8 },
        { { &i64, OSC_I64_BITS }, -6e9, 8 }, { { &u64, OSC_U64 }, 1, 8 },
        { { &position, OSC_F64 }, 2.5, 8 },  { { &ratio, OSC_F32 }, 0.5, 4 },
    };

    (void)state;
    position = 2.5;
    ratio = 0.5f;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        assert_true(osc_value(&rows[i].source) == rows[i].value);
        assert_int_equal(osc_width(rows[i].source.type), rows[i].width);
    }
    assert_int_equal(osc_width(OSC_STRING8), 0);
    assert_int_equal(osc_width(OSC_STRING16), 0);
    assert_int_equal(osc_width(14), 0);
    assert_int_equal(osc_width(UINT32_MAX), 0);
}

static void what_cannot_be_recorded_is_not_started(void **state)
{
    struct osc_setup setup = setup_of(2);
    struct osc osc;

    (void)state;
    setup.channels[1].type = OSC_STRING8;
    assert_false(osc_start(&osc, &setup));
    assert_int_equal(osc.state, OSC_IDLE);
    setup = setup_of(2);
    setup.bytes = 11;
    assert_false(osc_start(&osc, &setup));
    setup = setup_of(0);
    assert_false(osc_start(&osc, &setup));
    setup = triggered(OSC_RISING, 1);
    setup.triggers[0].source.type = OSC_STRING16;
    assert_false(osc_start(&osc, &setup));
}

static void thirty_two_channels_fit(void **state)
{
    struct osc_setup setup = setup_of(OSC_CHANNELS);
    struct osc osc;

    (void)state;
    for (uint32_t i = 0; i < OSC_CHANNELS; i++)
        setup.channels[i] = (struct osc_source){ i % 2 ? (void *)&wide : (void *)&count,
                                                 i % 2 ? OSC_I64 : OSC_I32 };
    assert_true(osc_start(&osc, &setup));
    for (uint32_t i = 1; i < OSC_CHANNELS; i++)
        assert_true(osc.offset[i] >= osc.offset[i - 1] + osc.samples * osc.width[i - 1]);
    assert_true(osc.offset[31] + osc.samples * 8u <= sizeof memory);
    while (osc_cycle(&osc))
        count++;
    assert_int_equal(osc.recorded, osc.samples);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_channels_share_the_memory_by_their_widths),
        cmocka_unit_test(one_channel_has_all_of_it),
        cmocka_unit_test(the_first_cycle_is_sampled_and_then_every_third),
        cmocka_unit_test(it_stops_by_itself_when_the_memory_is_full),
        cmocka_unit_test(seventeen_then_twentytwo_crosses_twenty),
        cmocka_unit_test(reaching_the_level_exactly_is_crossing_it_and_leaving_it_is_not),
        cmocka_unit_test(the_first_reading_does_not_trigger),
        cmocka_unit_test(a_falling_edge_is_no_rising_one),
        cmocka_unit_test(the_trigger_is_judged_in_cycles_that_are_not_sampled),
        cmocka_unit_test(samples_from_before_the_trigger_are_kept),
        cmocka_unit_test(fewer_are_kept_when_the_trigger_comes_early),
        cmocka_unit_test(a_pretrigger_as_large_as_the_memory_leaves_room_for_the_trigger),
        cmocka_unit_test(samples_stay_in_step_across_the_trigger_when_some_are_kept),
        cmocka_unit_test(the_ring_before_the_trigger_wraps_in_an_endless_recording_too),
        cmocka_unit_test(its_own_memory_may_be_recorded),
        cmocka_unit_test(a_value_that_is_no_number_never_triggers),
        cmocka_unit_test(endless_recording_keeps_the_newest),
        cmocka_unit_test(packed_samples_lie_behind_one_another),
        cmocka_unit_test(any_or_all_of_several_triggers),
        cmocka_unit_test(every_type_is_read_as_what_it_is),
        cmocka_unit_test(what_cannot_be_recorded_is_not_started),
        cmocka_unit_test(thirty_two_channels_fit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
