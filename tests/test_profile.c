/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The profile generator against closed forms. The reference is written from the other side: the
 * textbook formula of every ramp in long double with the C library's sine, the brake counted back
 * from the destination.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <math.h>

#include "host/profile_motion.h"

#define PIL      3.14159265358979323846264338327950288L
#define RELATIVE 1e-9L

static const uint32_t cycles_us[] = { 250, 500, 1000 };

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* --- the reference --- */

struct ramp {
    uint32_t type;
    long double jerk; /* 0..1 */
    long double speed, limit, time;
};

/* A ramp from 0 to `speed` whose largest acceleration is `limit`. */
static struct ramp ramp_of(uint32_t type, double percent, long double speed, long double limit)
{
    struct ramp r = { type, percent / 100.0L, speed, limit, 0 };

    switch (type) {
    case 3:
        r.time = speed / limit;
        break;
    case 4:
        r.time = speed / (limit * (1 - r.jerk + 2 * r.jerk / PIL));
        break;
    case 5:
        r.time = 2 * speed / limit;
        break;
    default:
        r.time = PIL * speed / (2 * limit);
    }
    return r;
}

static long double jerk_limited(const struct ramp *r, long double t, long double *speed)
{
    const long double corner = r->jerk * r->time / 2, w = PIL / (2 * corner), a = r->limit;

    if (t < corner) {
        *speed = a / w * (1 - cosl(w * t));
        return a / w * (t - sinl(w * t) / w);
    }
    *speed = a / w + a * (t - corner);
    return a / w * (corner - 1 / w) + a / w * (t - corner) + a * (t - corner) * (t - corner) / 2;
}

/* Way, and speed, at a time of the ramp. */
static long double ramp_way(const struct ramp *r, long double t, long double *speed)
{
    const long double v = r->speed, T = r->time, a = r->limit;
    long double s;

    switch (r->type) {
    case 3:
        *speed = a * t;
        return a * t * t / 2;
    case 4:
        if (r->jerk == 0) {
            *speed = a * t;
            return a * t * t / 2;
        }
        if (t <= T / 2)
            return jerk_limited(r, t, speed);
        /* The second half is the first one seen from the end. */
        s = jerk_limited(r, T - t, speed);
        *speed = v - *speed;
        return v * T / 2 - (v * (T - t) - s);
    case 5:
        *speed = a / 2 * (t - T / (2 * PIL) * sinl(2 * PIL * t / T));
        s = T / (2 * PIL);
        return a / 2 * (t * t / 2 - 2 * s * s * powl(sinl(PIL * t / T), 2));
    default:
        *speed = v * powl(sinl(PIL * t / (2 * T)), 2);
        /* t - sin t loses its digits in the first cycles of a long ramp. */
        s = PIL * t / T;
        return v / 2 * T / PIL *
               (s < 0.01L ? s * s * s / 6 * (1 - s * s / 20 * (1 - s * s / 42)) : s - sinl(s));
    }
}

struct move {
    struct ramp up, down;
    long double way, speed, total;
    bool whole; /* type 2 */
};

static struct move move_of(const struct profile_wanted *w)
{
    struct move m = { .way = fabsl((long double)w->destination), .whole = w->type == 2 };
    const long double a = w->acceleration, d = w->type == 1 ? a : w->deceleration;
    const long double least = a < d ? a : d;
    long double shape = ramp_of(w->type, w->percent, 1, 1).time;

    if (m.whole) {
        m.total = fmaxl(2 * m.way / w->speed, sqrtl(2 * PIL * m.way / least));
        return m;
    }
    m.speed = fminl(w->speed, sqrtl(2 * m.way / (shape * (1 / a + 1 / d))));
    m.up = ramp_of(w->type, w->percent, m.speed, a);
    m.down = ramp_of(w->type, w->percent, m.speed, d);
    m.total = m.way / m.speed + (m.up.time + m.down.time) / 2;
    return m;
}

static long double move_at(const struct move *m, long double t, long double *speed)
{
    const long double left = m->total - t;

    *speed = 0;
    if (left <= 0)
        return m->way;
    if (m->whole) {
        const long double x = 2 * PIL * t / m->total;

        *speed = m->way / m->total * (1 - cosl(x));
        return m->way / (2 * PIL) *
               (x < 0.01L ? x * x * x / 6 * (1 - x * x / 20 * (1 - x * x / 42)) : x - sinl(x));
    }
    if (t < m->up.time)
        return ramp_way(&m->up, t, speed);
    if (left < m->down.time)
        return m->way - ramp_way(&m->down, left, speed);
    *speed = m->speed;
    return m->up.speed * m->up.time / 2 + m->speed * (t - m->up.time);
}

/* --- the moves --- */

static const struct {
    double way, speed, acceleration, deceleration;
} moves[] = {
    { 1e6, 2e5, 1e6, 1e6 },
    { 1e6, 2e5, 3e6, 5e5 },
    { 1048576, 1e6, 2e6, 7e6 },
    { 5000, 2e5, 1e6, 4e5 },
    { 1, 1e5, 1e6, 1e6 },
    { 1e-3, 1e5, 1e6, 1e6 },
    { 123456.789, 98765.4, 3.3e5, 1.7e5 },
    { 2e5, 1e4, 5e3, 4e3 },
};

static const struct {
    uint32_t type;
    double percent;
} shapes[] = { { 0, 0 }, { 1, 0 },  { 2, 0 },   { 3, 0 }, { 4, 0 },
               { 4, 1 }, { 4, 35 }, { 4, 100 }, { 5, 0 } };

static struct profile_wanted wanted_of(size_t shape, size_t move)
{
    return (struct profile_wanted){ .positioning = true,
                                    .destination = moves[move].way,
                                    .speed = moves[move].speed,
                                    .acceleration = moves[move].acceleration,
                                    .deceleration = moves[move].deceleration,
                                    .type = shapes[shape].type,
                                    .percent = shapes[shape].percent };
}

static void assert_near(long double value, long double reference, long double scale)
{
    if (!(fabsl(value - reference) <= RELATIVE * fabsl(scale)))
        fail_msg("%.17Lg instead of %.17Lg", value, reference);
}

static void follow_move(const struct profile_wanted *w, double cycle)
{
    const struct move m = move_of(w);
    const long double top = m.whole ? 2 * m.way / m.total : m.speed;
    const double sign = w->destination < 0 ? -1 : 1;
    struct profile p;

    profile_set(&p, 0, 0);
    for (unsigned n = 1; n * cycle < m.total + 3 * cycle; n++) {
        long double speed, position = move_at(&m, n * (long double)cycle, &speed);

        profile_step(&p, w, cycle);
        assert_near(sign * p.position, position, position);
        assert_near(sign * p.speed, speed, top);
        if (fabsl(n * (long double)cycle - m.total) > 1e-9L * m.total)
            assert_true(p.ready == (n * (long double)cycle >= m.total));
        if (p.ready)
            assert_true(p.position == w->destination && p.speed == 0);
    }
    assert_true(p.ready);
}

static void every_type_moves_as_its_closed_form(void **state)
{
    (void)state;
    for (size_t shape = 0; shape < COUNT(shapes); shape++)
        for (size_t move = 0; move < COUNT(moves); move++)
            for (size_t c = 0; c < COUNT(cycles_us); c++) {
                struct profile_wanted w = wanted_of(shape, move);

                follow_move(&w, cycles_us[c] * 1e-6);
                w.destination = -w.destination;
                follow_move(&w, cycles_us[c] * 1e-6);
            }
}

static void every_type_reaches_a_speed_as_its_closed_form(void **state)
{
    (void)state;
    for (size_t shape = 0; shape < COUNT(shapes); shape++)
        for (size_t c = 0; c < COUNT(cycles_us); c++)
            for (double target = -3e5; target < 4e5; target += 6e5) {
                const double cycle = cycles_us[c] * 1e-6;
                const struct profile_wanted w = { .speed = target,
                                                  .acceleration = 4e5,
                                                  .deceleration = 4e5,
                                                  .type = shapes[shape].type,
                                                  .percent = shapes[shape].percent };
                const struct ramp r = ramp_of(w.type, w.percent, fabsl((long double)target), 4e5L);
                const double sign = target < 0 ? -1 : 1;
                struct profile p;

                profile_set(&p, 0, 0);
                for (unsigned n = 1; n * cycle < 2 * r.time; n++) {
                    const long double t = n * (long double)cycle;
                    long double speed = r.speed;
                    long double way =
                        t < r.time ? ramp_way(&r, t, &speed) : r.speed * (t - r.time / 2);

                    profile_step(&p, &w, cycle);
                    assert_near(sign * p.position, way, way);
                    assert_near(sign * p.speed, speed, r.speed);
                    assert_true(p.ready == (t >= r.time));
                }
                assert_true(p.speed == target);
            }
}

/* Brakes with the deceleration to 0, then accelerates: no ramp straight through 0. */
static void a_reversal_goes_by_way_of_standstill(void **state)
{
    (void)state;
    for (size_t shape = 0; shape < COUNT(shapes); shape++) {
        const double dec = shapes[shape].type == 1 || shapes[shape].type == 2 ? 2e5 : 8e5;
        struct profile_wanted w = { .speed = 1e5,
                                    .acceleration = 2e5,
                                    .deceleration = 8e5,
                                    .type = shapes[shape].type,
                                    .percent = shapes[shape].percent };
        const struct ramp down = ramp_of(w.type, w.percent, 1e5L, dec);
        const struct ramp up = ramp_of(w.type, w.percent, 1e5L, 2e5L);
        struct profile p;
        double start;

        profile_set(&p, 0, 0);
        while (!p.ready)
            profile_step(&p, &w, 5e-4);
        start = p.position;
        w.speed = -1e5;
        for (unsigned n = 1; n * 5e-4L < down.time + up.time; n++) {
            const long double t = n * 5e-4L;
            long double speed, way;

            profile_step(&p, &w, 5e-4);
            if (t < down.time) {
                way = down.speed * down.time / 2 - ramp_way(&down, down.time - t, &speed);
            } else {
                way = down.speed * down.time / 2 - ramp_way(&up, t - down.time, &speed);
                speed = -speed;
            }
            assert_near(p.position, start + way, start);
            assert_near(p.speed, speed, 1e5L);
        }
    }
}

/* Largest growth of the acceleration in a second. */
static double jerk_of(const struct profile_wanted *w, const struct move *m)
{
    const double a = fmax(w->acceleration, w->deceleration);
    const double t = (double)fminl(m->up.time, m->down.time);

    if (m->whole)
        return (double)(4 * PIL * PIL * m->way / powl(m->total, 3));
    return a * 3.1416 / (w->type == 4 ? w->percent / 100 * t : t);
}

static void acceleration_is_continuous_where_the_type_has_corners(void **state)
{
    (void)state;
    for (size_t shape = 0; shape < COUNT(shapes); shape++)
        for (size_t move = 0; move < 4; move++) {
            const struct profile_wanted w = wanted_of(shape, move);
            const struct move m = move_of(&w);
            const double cycle = 1e-5;
            double before = 0, last = 0;
            struct profile p;

            profile_set(&p, 0, 0);
            for (unsigned n = 0; n == 0 || !p.ready; n++) {
                profile_step(&p, &w, cycle);
                assert_true(fabs(p.speed - before) <=
                            fmax(w.acceleration, w.deceleration) * cycle * (1 + 1e-9) + 1e-9);
                if (w.type != 3 && (w.type != 4 || w.percent >= 35))
                    assert_true(fabs(p.acceleration - last) <= jerk_of(&w, &m) * cycle * 1.001);
                before = p.speed;
                last = p.acceleration;
            }
        }
}

/* --- changes in motion --- */

static const struct profile_wanted plain = {
    .positioning = true, .destination = 1e6, .speed = 1e5, .acceleration = 2e5, .deceleration = 4e5
};

static void step(struct profile *p, const struct profile_wanted *w, unsigned count)
{
    while (count-- > 0)
        profile_step(p, w, 5e-4);
}

static void a_new_destination_on_the_way_keeps_speed_and_acceleration(void **state)
{
    (void)state;
    for (uint32_t type = 0; type <= 5; type++) {
        struct profile_wanted w = plain;
        struct profile p;
        double speed, acceleration, begin;

        w.type = type;
        w.percent = 50;
        profile_set(&p, 0, 0);
        step(&p, &w, 600);
        begin = p.speed;
        for (unsigned i = 0; i < 200; i++) { /* every cycle another one */
            speed = p.speed;
            acceleration = p.acceleration;
            w.destination += 1000;
            step(&p, &w, 1);
            assert_false(p.ready);
            assert_true(fabs(p.speed - speed) <= 4e5 * 5e-4);
            if (type != 3 && type != 2)
                assert_true(fabs(p.acceleration - acceleration) < 2e5 * 0.05);
        }
        assert_true(type == 2 || p.speed - begin > 1.4e4); /* of 2e4 at most */
        while (!p.ready)
            step(&p, &w, 1);
        assert_true(p.position == w.destination);
    }
}

static void a_destination_too_near_is_passed_and_come_back_to(void **state)
{
    struct profile_wanted w = plain;
    struct profile p;
    double most = 0, start;

    (void)state;
    w.type = 3;
    profile_set(&p, 0, 0);
    step(&p, &w, 2000); /* constant speed since 0.5 s */
    assert_true(p.speed == 1e5);
    start = p.position;
    w.destination = start + 1000; /* the brake needs 1e10 / 8e5 = 12500 */
    while (!p.ready) {
        step(&p, &w, 1);
        most = fmax(most, p.position);
        assert_true(p.speed >= 0 || p.position > w.destination);
    }
    assert_true(fabs(most - start - 12500) < 0.5);
    assert_true(p.position == start + 1000);
}

static void a_lower_speed_on_the_way_is_reached_with_the_deceleration(void **state)
{
    struct profile_wanted w = plain;
    struct profile p;

    (void)state;
    w.type = 3;
    profile_set(&p, 0, 0);
    step(&p, &w, 2000);
    w.speed = 2e4;
    step(&p, &w, 399);
    assert_true(p.braking);
    assert_near(p.speed, 1e5L - 4e5L * 399 * 5e-4L, 1e5L);
    step(&p, &w, 2);
    assert_false(p.braking);
    assert_true(p.speed == 2e4);
    w.speed = 0; /* stands, and is not ready */
    step(&p, &w, 2000);
    assert_true(p.speed == 0 && !p.ready);
}

static void braking_is_told_from_the_brake_point_to_the_destination(void **state)
{
    struct profile_wanted w = plain;
    struct profile p;

    (void)state;
    w.type = 3; /* 0.5 s up, 25000; 0.25 s down, 12500; 9.625 s between */
    profile_set(&p, 0, 0);
    step(&p, &w, 20249);
    assert_false(p.braking);
    step(&p, &w, 2);
    assert_true(p.braking);
    step(&p, &w, 498);
    assert_true(p.braking && !p.ready);
    step(&p, &w, 2);
    assert_true(p.ready && !p.braking);
}

static void unusable_values_leave_the_plan_in_force(void **state)
{
    static const double bad[] = { 0, -1, NAN, INFINITY, -INFINITY, 1e300, 1e-300 };

    (void)state;
    for (size_t i = 0; i < COUNT(bad); i++) {
        struct profile_wanted w = plain;
        struct profile p, q;

        profile_set(&p, 5, 0);
        w.acceleration = bad[i];
        step(&p, &w, 10);
        assert_true(p.position == 5 && p.speed == 0 && !p.ready);

        profile_set(&p, 0, 0);
        step(&p, &plain, 500);
        q = p;
        w.destination = 7;
        step(&p, &w, 500);
        step(&q, &plain, 500);
        assert_true(p.position == q.position && p.speed == q.speed);

        w = plain;
        w.deceleration = bad[i]; /* brakes with the acceleration */
        w.destination = 1000;
        profile_set(&p, 0, 0);
        while (!p.ready)
            step(&p, &w, 1);
        assert_true(p.position == 1000);
        assert_true(p.wanted.deceleration == w.acceleration);
        if (fabs(bad[i]) <= 1)
            continue;
        w = plain;
        w.destination = bad[i];
        profile_set(&p, 5, 0);
        step(&p, &w, 10);
        assert_true(p.position == 5);
    }
}

static void a_move_of_nothing_is_ready_at_once(void **state)
{
    struct profile_wanted w = plain;
    struct profile p;

    (void)state;
    w.destination = 5;
    profile_set(&p, 5, 0);
    step(&p, &w, 1);
    assert_true(p.ready && p.position == 5 && p.speed == 0);
    w.destination = 5 + 1e-9; /* less than a cycle's worth */
    step(&p, &w, 1);
    assert_true(p.ready && p.position == 5 + 1e-9);
}

static void a_shift_is_no_motion(void **state)
{
    struct profile_wanted w = plain;
    struct profile p, q;

    (void)state;
    profile_set(&p, 0, 0);
    step(&p, &w, 700);
    q = p;
    profile_shift(&q, 4096);
    for (unsigned i = 0; i < 30000; i++) {
        step(&p, &w, 1);
        w.destination += 4096;
        step(&q, &w, 1);
        w.destination -= 4096;
        assert_near(q.position - 4096, p.position, 1e6L);
        assert_true(q.speed == p.speed);
    }
    assert_true(p.ready && q.ready);
}

static uint32_t random_state;

static double draw(double low, double high)
{
    random_state = random_state * 1664525u + 1013904223u;
    return low + (high - low) * (random_state >> 8) / 16777216.0;
}

/* Whatever changes, and whenever. */
static void no_change_makes_a_jump_or_loses_the_destination(void **state)
{
    (void)state;
    for (unsigned run = 0; run < 2000; run++) {
        struct profile_wanted w = plain;
        struct profile p;

        random_state = run;
        w.type = (uint32_t)draw(0, 6);
        w.percent = draw(-10, 110);
        profile_set(&p, draw(-1e4, 1e4), draw(-1e5, 1e5));
        for (unsigned n = 0, next = 0; n < 60000 && !(n > 3000 && p.ready); n++) {
            const double position = p.position, speed = p.speed;
            double limit, way;

            if (n == next && n < 3000) {
                w.positioning = draw(0, 1) < 0.8 || n > 2500;
                w.destination = draw(-3e4, 3e4);
                w.speed = draw(-2e5, 2e5);
                if (draw(0, 1) < 0.5)
                    w.acceleration = draw(5e4, 2e6);
                w.deceleration = draw(5e4, 2e6);
                next += (unsigned)draw(1, draw(0, 1) < 0.5 ? 10 : 500);
            }
            if (n == 3000) {
                w.positioning = true;
                w.speed = 1e5;
            }
            step(&p, &w, 1);
            limit = fmax(w.acceleration, w.deceleration) * 5e-4;
            if (fabs(p.speed - speed) > limit * (1 + 1e-6) + 1e-6)
                fail_msg("run %u, cycle %u, type %u: speed %g after %g", run, n, w.type, p.speed,
                         speed);
            way = p.position - position;
            if (fabs(way - (p.speed + speed) / 2 * 5e-4) > limit * 5e-4 / 2 + 1e-4)
                fail_msg("run %u, cycle %u, type %u: way %g at speed %g to %g", run, n, w.type, way,
                         speed, p.speed);
        }
        if (!p.ready || p.position != w.destination)
            fail_msg("run %u, type %u: %g instead of %g", run, w.type, p.position, w.destination);
    }
}

static void the_sine_is_ours_and_exact(void **state)
{
    (void)state;
    for (unsigned i = 0; i <= 100000; i++) {
        const double h = i / 100000.0;
        const long double exact = sinl(PIL * h);

        assert_true(fabsl(profile_sine(h) - exact) <= 2.5e-16L);
        if (h < 0.5)
            assert_true(fabsl(profile_sine(h) - exact) <= 3e-16L * exact);
    }
}

/* One number over all positions of all types: another compiler, or a processor that fuses
 * multiplication and addition, gives the same. */
static void positions_are_the_same_to_the_last_bit_everywhere(void **state)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);

    (void)state;
    for (size_t shape = 0; shape < COUNT(shapes); shape++) {
        const struct profile_wanted w = wanted_of(shape, 6);
        struct profile p;

        profile_set(&p, 0, 0);
        for (unsigned n = 0; n < 6000; n++) {
            uint64_t bits;

            step(&p, &w, 1);
            memcpy(&bits, &p.position, sizeof bits);
            hash = (hash ^ bits) * UINT64_C(0x100000001b3);
        }
    }
    assert_true(hash == UINT64_C(0x736fb0c994b64c61));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_moves_as_its_closed_form),
        cmocka_unit_test(every_type_reaches_a_speed_as_its_closed_form),
        cmocka_unit_test(a_reversal_goes_by_way_of_standstill),
        cmocka_unit_test(acceleration_is_continuous_where_the_type_has_corners),
        cmocka_unit_test(a_new_destination_on_the_way_keeps_speed_and_acceleration),
        cmocka_unit_test(a_destination_too_near_is_passed_and_come_back_to),
        cmocka_unit_test(a_lower_speed_on_the_way_is_reached_with_the_deceleration),
        cmocka_unit_test(braking_is_told_from_the_brake_point_to_the_destination),
        cmocka_unit_test(unusable_values_leave_the_plan_in_force),
        cmocka_unit_test(a_move_of_nothing_is_ready_at_once),
        cmocka_unit_test(a_shift_is_no_motion),
        cmocka_unit_test(no_change_makes_a_jump_or_loses_the_destination),
        cmocka_unit_test(the_sine_is_ours_and_exact),
        cmocka_unit_test(positions_are_the_same_to_the_last_bit_everywhere),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
