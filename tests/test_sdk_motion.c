/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Edges, timers, ramps, the positioning profile and I/O bits of the SDK. */
#define TGM_HOST
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <tgm_plc.h>

#include <tgm/motion.h>

/* ---- edges, ticks, debouncing, timers: one character a call ------------------------------------------ */

static void edges(void **state)
{
    struct tgm_edge e;
    (void)state;
    tgm_edge_init(&e, 0);
    assert_int_equal(tgm_edge_step(&e, 1), TGM_EDGE_RISING);
    assert_int_equal(tgm_edge_step(&e, 4), TGM_EDGE_NONE); /* every level but 0 is on */
    assert_int_equal(tgm_edge_step(&e, 0), TGM_EDGE_FALLING);
    assert_int_equal(tgm_edge_step(&e, 0), TGM_EDGE_NONE);
    tgm_edge_init(&e, 8);
    assert_int_equal(tgm_edge_step(&e, 1), TGM_EDGE_NONE);
}

static void ticks_pass_the_wrap(void **state)
{
    struct tgm_tick t;
    (void)state;
    tgm_tick_init(&t, UINT32_MAX - 1);
    assert_int_equal(tgm_tick_elapsed(&t, UINT32_MAX - 1), 0);
    assert_int_equal(tgm_tick_elapsed(&t, 3), 5);
    assert_int_equal(tgm_tick_elapsed(&t, 2), UINT32_MAX);
}

enum block { TON, TOF, TP, DEBOUNCE };

static const struct {
    enum block block;
    unsigned preset; /* calls; the debouncer begins off */
    const char *in, *out;
} sequences[] = {
    { TON, 3, "0111111011110", "0000111000010" },
    { TON, 3, "0110110111", "0000000000" },
    { TON, 1, "01100101", "00100000" },
    { TON, 0, "0101100", "0101100" },
    { TON, 3, "1111", "0001" },
    { TOF, 3, "0110000010000", "0111110011110" },
    { TOF, 3, "010010010000", "011111111110" },
    { TOF, 1, "0100010", "0110011" },
    { TOF, 0, "0101100", "0101100" },
    { TOF, 3, "0000", "0000" },
    { TP, 3, "01000000", "01110000" },
    { TP, 3, "01111111", "01110000" },
    { TP, 3, "01010111", "01110111" },
    { TP, 3, "01011111", "01110000" }, /* an edge during the pulse is lost */
    { TP, 3, "010010111", "011100111" },
    { TP, 3, "010001000", "011101110" },
    { TP, 2, "0101100101", "0110000110" }, /* also in the call that ends it */
    { TP, 0, "010110", "000000" },
    { DEBOUNCE, 2, "0101101110", "0000000011" },
    { DEBOUNCE, 2, "0111000", "0001110" },
    { DEBOUNCE, 1, "0100110", "0000011" },
    { DEBOUNCE, 0, "0110", "0110" },
};

static void timers_follow_the_table(void **state)
{
    static const uint32_t cycles[] = { 1, 250, 1000, UINT32_MAX };
    (void)state;
    for (size_t c = 0; c < sizeof cycles / sizeof cycles[0]; c++)
        for (size_t i = 0; i < sizeof sequences / sizeof sequences[0]; i++) {
            const uint64_t preset = (uint64_t)sequences[i].preset * cycles[c];
            struct tgm_ton ton;
            struct tgm_tof tof;
            struct tgm_tp tp;
            struct tgm_debounce debounce;
            char out[32] = { 0 };
            tgm_ton_init(&ton, preset);
            tgm_tof_init(&tof, preset);
            tgm_tp_init(&tp, preset);
            tgm_debounce_init(&debounce, 0, preset);
            for (size_t k = 0; sequences[i].in[k] != 0; k++) {
                const int in = sequences[i].in[k] - '0';
                int q = 0;
                switch (sequences[i].block) {
                case TON: q = tgm_ton_step(&ton, in * 8, cycles[c]); break;
                case TOF: q = tgm_tof_step(&tof, in * 8, cycles[c]); break;
                case TP: q = tgm_tp_step(&tp, in * 8, cycles[c]); break;
                case DEBOUNCE: q = tgm_debounce_step(&debounce, in * 8, cycles[c]); break;
                }
                out[k] = (char)('0' + q);
            }
            assert_string_equal(out, sequences[i].out);
        }
}

static void timers_show_elapsed_time_and_stop_at_the_preset(void **state)
{
    struct tgm_ton ton;
    struct tgm_tp tp;
    (void)state;
    tgm_ton_init(&ton, 1000);
    tgm_ton_step(&ton, 1, 250);
    assert_int_equal(ton.elapsed_us, 0);
    tgm_ton_step(&ton, 1, 250);
    assert_int_equal(ton.elapsed_us, 250);
    for (int i = 0; i < 10; i++)
        tgm_ton_step(&ton, 1, 400);
    assert_int_equal(ton.elapsed_us, 1000);
    tgm_ton_step(&ton, 0, 250);
    assert_int_equal(ton.elapsed_us, 0);

    tgm_ton_init(&ton, UINT64_MAX); /* no wrap at the very end either */
    tgm_ton_step(&ton, 1, 1);
    ton.elapsed_us = UINT64_MAX - 5;
    assert_false(tgm_ton_step(&ton, 1, 4));
    assert_true(tgm_ton_step(&ton, 1, UINT32_MAX));
    assert_true(tgm_ton_step(&ton, 1, UINT32_MAX));

    tgm_tp_init(&tp, 500);
    tgm_tp_step(&tp, 1, 250);
    tgm_tp_step(&tp, 1, 250);
    tgm_tp_step(&tp, 1, 250);
    tgm_tp_step(&tp, 1, 250);
    assert_int_equal(tp.elapsed_us, 500); /* until the input is off */
    tgm_tp_step(&tp, 0, 250);
    assert_int_equal(tp.elapsed_us, 0);
}

static void a_new_preset_counts_from_the_next_call(void **state)
{
    struct tgm_ton ton;
    (void)state;
    tgm_ton_init(&ton, 1000);
    tgm_ton_step(&ton, 1, 250);
    tgm_ton_step(&ton, 1, 250);
    ton.preset_us = 500;
    assert_true(tgm_ton_step(&ton, 1, 250));
    ton.preset_us = 5000;
    assert_false(tgm_ton_step(&ton, 1, 250));
    assert_int_equal(ton.elapsed_us, 750);
}

/* ---- ramp -------------------------------------------------------------------------------------------- */

static void ramp_reaches_exactly_and_never_passes(void **state)
{
    struct tgm_ramp r;
    (void)state;
    tgm_ramp_init(&r, 0, 10, 40);
    double before = 0;
    for (int i = 0; i < 99; i++) {
        const double value = tgm_ramp_step(&r, 1.0, 1000);
        assert_true(value > before && value < 1.0 && value - before < 0.0100001);
        before = value;
    }
    tgm_ramp_step(&r, 1.0, 1000);
    assert_true(tgm_ramp_step(&r, 1.0, 1000) == 1.0);
    assert_true(fabs(tgm_ramp_step(&r, -5, 1000) - 0.96) < 1e-12);
    assert_true(tgm_ramp_step(&r, 0.95, 1000) == 0.95);
}

static void ramp_refuses_nonsense(void **state)
{
    struct tgm_ramp r;
    (void)state;
    tgm_ramp_init(&r, 1, 0, -1);
    assert_true(tgm_ramp_step(&r, 9, 1000) == 1);
    assert_true(tgm_ramp_step(&r, -9, 1000) == 1);
    r.up = r.down = NAN;
    assert_true(tgm_ramp_step(&r, 9, 1000) == 1);
    assert_true(tgm_ramp_step(&r, -9, 1000) == 1);
    r.up = r.down = INFINITY;
    assert_true(tgm_ramp_step(&r, NAN, 1000) == 1);
    assert_true(tgm_ramp_step(&r, 9, 1000) == 9);
    assert_true(tgm_ramp_step(&r, -9, 0) == -9);
}

/* ---- positioning ------------------------------------------------------------------------------------- */

static uint64_t random_bits(void)
{
    static uint64_t x = UINT64_C(88172645463325252);
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    return x;
}

static double uniform(double from, double to)
{
    return from + (to - from) * ((double)(random_bits() >> 11) * 0x1p-53);
}

static double spread(double from, double to) /* even in the logarithm */
{
    return exp(uniform(log(from), log(to)));
}

/* One step, checked against the limits; speeds and ways may be off by rounding only. */
static void checked_step(struct tgm_move *m)
{
    const struct tgm_move before = *m;
    const double returned = tgm_move_step(m);
    const double ulp = 0x1p-46 * (fabs(before.position) + fabs(before.target) + fabs(m->position)) + 1e-288;
    const double v = before.speed, w = m->speed;
    const double tiny = 1e-9 * before.deceleration * before.cycle + 4 * ulp / before.cycle;

    assert_true(returned == m->position);
    assert_true(fabs(m->position - before.position - 0.5 * (v + w) * before.cycle) <= 4 * ulp);
    const int slower = fabs(w) < fabs(v) || v * w < 0;
    const double change = (slower ? before.deceleration : before.acceleration) * before.cycle;
    assert_true(fabs(w - v) <= change * (1 + 1e-9) + tiny);
    assert_true(v * w >= 0); /* stands before it turns round */
    if (fabs(v) <= before.speed_limit)
        assert_true(fabs(w) <= before.speed_limit * (1 + 1e-12));
}

static double way_to_brake(const struct tgm_move *m)
{
    const double v = fabs(m->speed);
    return 0.5 * v * v / m->deceleration + 0.5 * m->deceleration * m->cycle * m->cycle;
}

/* Goes on until done. When the target can still be reached without passing it, it must not be passed. */
static long run_to_target(struct tgm_move *m)
{
    const double distance = m->target - m->position;
    const int feasible = m->speed * distance >= 0 && fabs(distance) >= way_to_brake(m) * 1.000001;
    long n = 0;

    while (!tgm_move_done(m)) {
        checked_step(m);
        if (feasible)
            assert_true((m->target - m->position) * distance >= 0);
        assert_true(++n < 50 * 1000 * 1000);
    }
    assert_true(m->position == m->target && m->speed == 0);
    const struct tgm_move rest = *m;
    for (int i = 0; i < 3; i++)
        tgm_move_step(m);
    assert_memory_equal(m, &rest, sizeof rest);
    return n;
}

/* Cycles that a profile without cycles would need. */
static double ideal_cycles(double distance, double speed, double acceleration, double deceleration,
                           double cycle)
{
    const double ramps = 0.5 * speed * speed * (1 / acceleration + 1 / deceleration);
    if (distance >= ramps)
        return ((distance - ramps) / speed + speed / acceleration + speed / deceleration) / cycle;
    const double peak = sqrt(2 * distance / (1 / acceleration + 1 / deceleration));
    return (peak / acceleration + peak / deceleration) / cycle;
}

static void random_limits(struct tgm_move *m, double scale)
{
    assert_true(tgm_move_limits(m, scale * spread(0.03, 30), scale * spread(1, 1e4), scale * spread(1, 1e4)));
}

/* Such that no change between two of them takes minutes of machine time. */
static void similar_limits(struct tgm_move *m, double scale)
{
    assert_true(tgm_move_limits(m, scale * spread(0.3, 3), scale * spread(1, 30), scale * spread(1, 30)));
}

static void moves_end_on_the_target_in_the_shortest_time(void **state)
{
    static const uint32_t cycles[] = { 100, 250, 500, 1000, 10000 };
    (void)state;
    for (int i = 0; i < 2000; i++) {
        struct tgm_move m;
        const double scale = spread(1e-3, 1e6);
        const double from = random_bits() % 4 == 0 ? 0 : scale * uniform(-1000, 1000);
        tgm_move_init(&m, from, cycles[random_bits() % 5]);
        random_limits(&m, scale);
        const double seconds = spread(1e-4, 2); /* roughly how long at full speed */
        assert_true(tgm_move_to(&m, from + (random_bits() % 2 ? 1 : -1) * m.speed_limit * seconds));
        const double ideal = ideal_cycles(fabs(m.target - from), m.speed_limit, m.acceleration,
                                          m.deceleration, m.cycle);
        const long n = run_to_target(&m);
        assert_true((double)n <= ideal * 1.00001 + 4);
        assert_true((double)n >= floor(ideal * 0.99999) - 1);
    }
}

static void tiny_distances(void **state)
{
    (void)state;
    for (int i = 0; i < 3000; i++) {
        struct tgm_move m;
        const double from = i % 3 == 0 ? 0 : uniform(-1e9, 1e9);
        double to = from;
        for (uint64_t n = random_bits() % 20 + 1; n > 0; n--)
            to = nextafter(to, i % 2 == 0 ? 1e300 : -1e300);
        tgm_move_init(&m, from, 250);
        random_limits(&m, spread(1e-3, 1e6));
        tgm_move_to(&m, to);
        assert_true(run_to_target(&m) <= 4);
        tgm_move_to(&m, to + 1e-7 * m.speed_limit);
        run_to_target(&m);
    }
}

static void retargets_and_new_limits_in_motion(void **state)
{
    (void)state;
    for (int i = 0; i < 3000; i++) {
        struct tgm_move m;
        const double scale = spread(1e-2, 1e5);
        tgm_move_init(&m, scale * uniform(-10, 10), 1000);
        similar_limits(&m, scale);
        for (int k = 0; k < 6; k++) {
            if (random_bits() % 2)
                similar_limits(&m, scale);
            assert_true(tgm_move_to(&m, m.position + m.speed_limit * uniform(-1, 1)));
            for (uint64_t n = random_bits() % 300; n > 0; n--)
                checked_step(&m);
        }
        run_to_target(&m);
    }
}

static void stops_in_motion(void **state)
{
    (void)state;
    for (int i = 0; i < 3000; i++) {
        struct tgm_move m;
        tgm_move_init(&m, uniform(-10, 10), 500);
        random_limits(&m, 1);
        tgm_move_to(&m, uniform(-500, 500));
        for (uint64_t n = random_bits() % 2000; n > 0; n--)
            checked_step(&m);
        const double way = 0.5 * m.speed * m.speed / m.deceleration + fabs(m.speed) * m.cycle;
        const double from = m.position;
        tgm_move_stop(&m);
        const double cycles = fabs(m.speed) / (m.deceleration * m.cycle);
        long n = 0;
        for (; !tgm_move_done(&m); n++)
            checked_step(&m);
        assert_true((double)n <= cycles + 1 && fabs(m.position - from) <= way * (1 + 1e-9));
        checked_step(&m);
        assert_true(m.target == m.position && tgm_move_done(&m));
        tgm_move_to(&m, 3);
        run_to_target(&m);
        assert_true(m.position == 3);
    }
}

static void a_target_within_the_way_to_brake_is_passed_once(void **state)
{
    struct tgm_move m;
    int turns = 0;
    double last = 1;
    (void)state;
    tgm_move_init(&m, 0, 1000);
    tgm_move_limits(&m, 10, 100, 100);
    tgm_move_to(&m, 100);
    for (int i = 0; i < 500; i++)
        checked_step(&m);
    tgm_move_to(&m, m.position + 0.1); /* needs 0.5 to brake from 10 */
    const double target = m.target;
    while (!tgm_move_done(&m)) {
        checked_step(&m);
        turns += m.speed * last < 0;
        last = m.speed != 0 ? m.speed : last;
        assert_true(m.position < target + 0.41);
    }
    assert_int_equal(turns, 1);
}

static void moves_refuse_nonsense(void **state)
{
    struct tgm_move m;
    (void)state;
    tgm_move_init(&m, NAN, 1000);
    assert_true(m.position == 0 && tgm_move_done(&m));
    const struct tgm_move before = m;
    assert_false(tgm_move_to(&m, NAN));
    assert_false(tgm_move_to(&m, INFINITY));
    assert_false(tgm_move_to(&m, -1.1e300));
    assert_false(tgm_move_set(&m, NAN));
    assert_false(tgm_move_limits(&m, 0, 1, 1));
    assert_false(tgm_move_limits(&m, 1, -1, 1));
    assert_false(tgm_move_limits(&m, 1, 1, NAN));
    assert_false(tgm_move_limits(&m, 1, INFINITY, 1));
    assert_memory_equal(&m, &before, sizeof m);
    tgm_move_init(&m, 5, 0);
    tgm_move_to(&m, 9);
    assert_true(tgm_move_step(&m) == 5);

    /* Usable, though no machine has them: nothing becomes a NaN or jumps. */
    static const double odd[] = { 5e-324, 1e-300, 1e-30, 1, 1e30, 1e300 };
    for (int i = 0; i < 6 * 6 * 6 * 6; i++) {
        tgm_move_init(&m, i % 2 ? 0 : -odd[i / 216], 1 + (uint32_t)i * 3000000u);
        assert_true(tgm_move_limits(&m, odd[i % 6], odd[i / 6 % 6], odd[i / 36 % 6]));
        tgm_move_to(&m, odd[i / 216]);
        for (int k = 0; k < 100; k++) {
            const double position = tgm_move_step(&m);
            assert_true(position >= -1.01 * odd[i / 216] && position <= odd[i / 216]);
            assert_true(m.speed == m.speed);
        }
    }
}

/* ---- bits -------------------------------------------------------------------------------------------- */

static void bits_of_generation_4(void **state)
{
    DIO dio;
    (void)state;
    memset(&dio, 0, sizeof dio);
    dio.In1 = 0x02;
    dio.Ext_In7 = 0x80;
    for (uint32_t bit = 0; bit < 200; bit++)
        assert_int_equal(tgm_dio4_get(TGM_DIO4_IN(&dio), bit), bit == 9 || bit == 127);
    dio.Out0 = 0x0F00;
    tgm_dio4_set(TGM_DIO4_OUT(&dio), 0, 1);
    tgm_dio4_set(TGM_DIO4_OUT(&dio), 7, 5);
    tgm_dio4_set(TGM_DIO4_OUT(&dio), 64, 1);
    assert_int_equal(dio.Out0, 0x0F81);
    assert_int_equal(dio.Ext_Out0, 1);
    tgm_dio4_set(TGM_DIO4_OUT(&dio), 7, 0);
    assert_int_equal(dio.Out0, 0x0F01);
    const DIO before = dio;
    tgm_dio4_set(TGM_DIO4_OUT(&dio), 128, 1);
    tgm_dio4_set(TGM_DIO4_OUT(&dio), UINT32_MAX, 1);
    assert_memory_equal(&dio, &before, sizeof dio);
}

static void bits_of_generation_5(void **state)
{
    uint32_t words[17] = { 0 };
    (void)state;
    words[1] = 2;
    words[15] = 0x80000000u;
    words[16] = ~0u; /* not part of it */
    for (uint32_t bit = 0; bit < 600; bit++)
        assert_int_equal(tgm_dio5_get(words, bit), bit == 33 || bit == 511);
    tgm_dio5_set(words, 31, 1);
    tgm_dio5_set(words, 511, 0);
    tgm_dio5_set(words, 512, 0);
    tgm_dio5_set(words, UINT32_MAX, 0);
    assert_int_equal(words[0], 0x80000000u);
    assert_int_equal(words[15], 0);
    assert_int_equal(words[16], ~0u);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges),
        cmocka_unit_test(ticks_pass_the_wrap),
        cmocka_unit_test(timers_follow_the_table),
        cmocka_unit_test(timers_show_elapsed_time_and_stop_at_the_preset),
        cmocka_unit_test(a_new_preset_counts_from_the_next_call),
        cmocka_unit_test(ramp_reaches_exactly_and_never_passes),
        cmocka_unit_test(ramp_refuses_nonsense),
        cmocka_unit_test(moves_end_on_the_target_in_the_shortest_time),
        cmocka_unit_test(tiny_distances),
        cmocka_unit_test(retargets_and_new_limits_in_motion),
        cmocka_unit_test(stops_in_motion),
        cmocka_unit_test(a_target_within_the_way_to_brake_is_passed_once),
        cmocka_unit_test(moves_refuse_nonsense),
        cmocka_unit_test(bits_of_generation_4),
        cmocka_unit_test(bits_of_generation_5),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
