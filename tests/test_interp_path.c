/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The way of an interpolator against closed forms, in long double with the C library's functions:
 * geometry, ramps, look-ahead, waiting and stopping, filters, and the text a path is read from.
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

#include "host/angle.h"
#include "host/interp_file.h"
#include "host/interp_filter.h"
#include "host/interp_run.h"

#define PIL      3.14159265358979323846264338327950288L
#define RELATIVE 1e-9L
#define PARTS    600

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const double steps[] = { 50e-6, 100e-6, 500e-6 };

static void near_by(long double value, long double reference, long double scale)
{
    if (!(fabsl(value - reference) <= RELATIVE * scale))
        fail_msg("%.17Lg instead of %.17Lg", value, reference);
}

static void near(long double value, long double reference)
{
    near_by(value, reference, fabsl(reference));
}

/* --- the bench --- */

struct bench {
    struct interp_part parts[PARTS];
    struct interp_path path;
    struct interp_run run;
    struct interp_inputs inputs;
    int32_t signals[64];
    unsigned signal_count;
};

static struct bench bench;

static void heard(void *argument, const struct interp_part *part)
{
    struct bench *b = argument;

    assert_true(b->signal_count < COUNT(b->signals));
    b->signals[b->signal_count++] = part->code;
}

static struct bench *bench_open(const char *text, double step)
{
    char why[INTERP_FILE_WHY];

    memset(&bench, 0, sizeof bench);
    interp_path_init(&bench.path, bench.parts, PARTS);
    if (interp_file_read(&bench.path, text, strlen(text), "test", why) != 0)
        fail_msg("%s", why);
    interp_run_init(&bench.run, &bench.path, heard, &bench);
    assert_true(interp_run_load(&bench.run));
    bench.inputs = (struct interp_inputs){ .step = step, .override = 1, .acceleration = INFINITY };
    return &bench;
}

static void step(struct bench *b)
{
    interp_run_step(&b->run, &b->inputs);
}

static unsigned run_out(struct bench *b, enum interp_state state)
{
    unsigned count = 0;

    while (b->run.state != state) {
        step(b);
        assert_true(++count < 10000000);
    }
    return count;
}

static long double way_of(const struct bench *b)
{
    return b->run.passed + b->run.way;
}

/* --- angles --- */

static void angles_are_those_of_the_c_library(void **state)
{
    (void)state;
    for (int i = -4000; i <= 4000; i++) {
        const double h = i / 997.0;

        assert_true(fabsl(angle_sine(h) - sinl(PIL * h)) < 5e-16L);
        assert_true(fabsl(angle_cosine(h) - cosl(PIL * h)) < 5e-16L);
    }
    for (int i = 0; i < 4000; i++) {
        const double x = cos(i * 0.0123) * (1 + i % 7), y = sin(i * 0.0123) * (1 + i % 7);

        assert_true(fabsl(angle_of(x, y) - atan2l(y, x) / PIL) < 4e-16L);
        near(angle_of(1, x * 1e-9), atan2l(x * 1e-9, 1) / PIL);
    }
    assert_true(angle_of(1, 0) == 0 && angle_of(-1, 0) == 1 && angle_of(0, 1) == 0.5);
    assert_true(angle_of(0, -2) == -0.5 && angle_of(0, 0) == 0 && angle_of(1, 1) == 0.25);
}

/* --- geometry --- */

static void a_line_goes_straight_in_all_axes(void **state)
{
    double position[INTERP_AXES], tangent[INTERP_AXES];
    struct bench *b = bench_open("from X 1 Y 2\n"
                                 "line X 4 Y -2 Z 12 C 7 B 1 U 2 V 3 W 4 A 5 O 6 F 60\n",
                                 1e-4);
    const struct interp_part *part = &b->parts[0];
    long double sum = 0;

    (void)state;
    for (unsigned i = 0; i < INTERP_AXES; i++)
        sum += ((long double)part->end[i] - part->start[i]) *
               ((long double)part->end[i] - part->start[i]);
    near(part->length, sqrtl(sum));
    assert_true(part->start[0] == 1 && part->end[3] == 7 && part->end[9] == 6 && part->feed == 1);
    for (unsigned n = 0; n <= 100; n++) {
        const double way = part->length * n / 100;

        interp_part_position(part, way, position);
        for (unsigned i = 0; i < INTERP_AXES; i++)
            near_by(position[i],
                    part->start[i] + ((long double)part->end[i] - part->start[i]) * n / 100, 12);
    }
    assert_memory_equal(position, part->end, sizeof position);
    interp_part_tangent(part, 3, tangent);
    near(tangent[1], -4 / sqrtl(sum));
}

static void an_arc_is_one_in_every_plane_and_direction(void **state)
{
    static const struct {
        const char *plane;
        unsigned axes[2];
    } planes[] = { { "XY", { 0, 1 } }, { "XZ", { 0, 2 } }, { "YZ", { 1, 2 } } };

    (void)state;
    for (size_t p = 0; p < COUNT(planes); p++)
        for (int clockwise = 0; clockwise < 2; clockwise++)
            for (int degrees = 7; degrees <= 360; degrees += 31)
                for (int helix = 0; helix < 2; helix++) {
                    const long double sweep = degrees * PIL / 180 * (clockwise ? -1 : 1);
                    const long double from = 0.7L, radius = 13;
                    const double centre[2] = { 3, -4 };
                    double position[INTERP_AXES], tangent[INTERP_AXES], end[2];
                    const unsigned *axes = planes[p].axes, third = 3 - axes[0] - axes[1];
                    const struct interp_part *part;
                    char text[300];

                    for (int i = 0; i < 2; i++)
                        end[i] = (double)(centre[i] + radius * (i == 0 ? cosl(from + sweep)
                                                                       : sinl(from + sweep)));
                    snprintf(
                        text, sizeof text,
                        "from %c %.17g %c %.17g\narc %s centre 3 -4 to %.17g %.17g %s %s F 600",
                        "XYZ"[axes[0]], (double)(centre[0] + radius * cosl(from)), "XYZ"[axes[1]],
                        (double)(centre[1] + radius * sinl(from)), planes[p].plane, end[0], end[1],
                        clockwise ? "cw" : "ccw",
                        helix ? third == 0   ? "X 5"
                                : third == 1 ? "Y 5"
                                             : "Z 5"
                              : "");
                    /* Rounding must not turn the full circle into nothing. */
                    if (degrees == 360)
                        continue;
                    part = &bench_open(text, 1e-4)->parts[0];
                    near(part->length, hypotl(radius * fabsl(sweep), helix ? 5 : 0));
                    for (int n = 0; n <= 64; n++) {
                        const long double angle = from + sweep * n / 64;

                        interp_part_position(part, part->length * n / 64, position);
                        near_by(position[axes[0]], centre[0] + radius * cosl(angle), radius);
                        near_by(position[axes[1]], centre[1] + radius * sinl(angle), radius);
                        near_by(position[third], helix ? 5.0L * n / 64 : 0, 5);
                        interp_part_tangent(part, part->length * n / 64, tangent);
                        near_by(tangent[axes[0]],
                                -sinl(angle) * sweep * radius / (long double)part->length, 1);
                        near_by(tangent[third], helix ? 5 / (long double)part->length : 0, 1);
                    }
                    assert_memory_equal(position, part->end, sizeof position);
                }
}

static void an_arc_may_be_a_circle_or_have_a_radius(void **state)
{
    struct bench *b = bench_open("arc XY centre 5 0 to 0 0 cw F 600\n" /* a circle */
                                 "arc XY radius 5 to 10 0 cw\n"        /* half of one */
                                 "arc XY radius 10 to 20 10 ccw\n"     /* a quarter */
                                 "arc XY radius -10 to 10 0 cw\n"      /* three quarters */
                                 "line X 10 Y 0\n",
                                 1e-4);

    (void)state;
    near(b->parts[0].length, 10 * PIL);
    near(b->parts[1].length, 5 * PIL);
    near_by(b->parts[1].centre[0], 5, 1);
    near_by(b->parts[1].centre[1], 0, 1);
    near(b->parts[2].length, 5 * PIL);
    near_by(b->parts[2].centre[0], 10, 1);
    near_by(b->parts[2].centre[1], 10, 1);
    near(b->parts[3].length, 15 * PIL);
    assert_true(b->parts[4].length == 0);
}

static void impossible_parts_are_refused(void **state)
{
    static const struct interp_part wrong[] = {
        { .kind = INTERP_LINE, .end = { NAN }, .feed = 1 },
        { .kind = INTERP_LINE, .end = { 2e9 }, .feed = 1 },
        { .kind = INTERP_LINE, .end = { 1 }, .feed = 0 },
        { .kind = INTERP_LINE, .end = { 1 }, .feed = NAN },
        { .kind = INTERP_CW, .end = { 1 }, .feed = 1, .plane = INTERP_XY }, /* no radius */
        { .kind = INTERP_CW, .end = { 1 }, .centre = { 2 }, .feed = 1, .plane = INTERP_XY },
        { .kind = INTERP_CW, .end = { 1 }, .centre = { INFINITY }, .feed = 1, .plane = INTERP_XY },
        { .kind = INTERP_DWELL, .dwell = -1 },
        { .kind = INTERP_M, .code = 1000 },
        { .kind = INTERP_M, .code = -5 },
        { .kind = (enum interp_kind)77 },
    };
    struct bench *b = bench_open("", 1e-4);
    const char *what;

    (void)state;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        assert_int_equal(interp_path_add(&b->path, &wrong[i], &what), -22);
        assert_non_null(what);
    }
    assert_true(b->path.count == 0);
    b->path.capacity = 0;
    assert_int_equal(interp_path_add(&b->path, &wrong[0], &what), -28);
}

/* --- ramps --- */

/* Way and speed after t seconds of a single move. */
static long double trapezoid(long double length, long double v, long double a, long double d,
                             long double t, long double *speed)
{
    const long double peak = fminl(v, sqrtl(2 * length * a * d / (a + d)));
    const long double up = peak / a, down = peak / d;
    const long double flat = (length - peak * (up + down) / 2) / peak;

    if (t <= up) {
        *speed = a * t;
        return a * t * t / 2;
    }
    if (t <= up + flat) {
        *speed = peak;
        return peak * up / 2 + peak * (t - up);
    }
    t = up + flat + down - t;
    *speed = t > 0 ? d * t : 0;
    return length - (t > 0 ? d * t * t / 2 : 0);
}

static void follows_a_trapezoid(struct bench *b, long double length, long double v, long double a,
                                long double d)
{
    long double speed, way = 0;

    assert_true(interp_run_start(&b->run));
    for (unsigned n = 1; b->run.state != INTERP_ENDED; n++) {
        step(b);
        way = trapezoid(length, v, a, d, n * (long double)b->inputs.step, &speed);
        near_by(way_of(b), way, length);
        near_by(b->run.speed, speed, v);
    }
    near(way, length);
    assert_true(b->run.phase == INTERP_STANDS);
    assert_memory_equal(b->run.position, interp_path_end(&b->path), sizeof b->run.position);
}

static void speed_along_a_line_is_a_trapezoid(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(steps); s++) {
        follows_a_trapezoid(
            bench_open("acceleration 800\ndeceleration 500\nline X 30 Y 40 F 6000", steps[s]), 50,
            100, 800, 500);
        follows_a_trapezoid(
            bench_open("acceleration 800\ndeceleration 500\nline X 0.3 Y 0.4 F 6000", steps[s]),
            0.5L, 100, 800, 500);
        follows_a_trapezoid(bench_open("rapid-speed 12000\nrapid Z -7", steps[s]), 7, 200, 1000,
                            1000);
    }
}

/* A line, an arc that leaves it in its direction, and a line again: one move. */
static void speed_is_kept_through_tangential_joints(void **state)
{
    static const char text[] = "line X 20 F 6000\n"
                               "arc XY centre 20 10 to 30 10 ccw\n"
                               "m 1\nm 1234\n"    /* neither stops it */
                               "line X 30 Y 10\n" /* to where it is */
                               "line X 30 Y 35\n"
                               "arc XY centre 25 35 to 25 40 ccw\n"
                               "line X 0 Y 40\n";

    (void)state;
    for (size_t s = 0; s < COUNT(steps); s++) {
        struct bench *b = bench_open(text, steps[s]);

        follows_a_trapezoid(b, 20 + 5 * PIL + 25 + 2.5L * PIL + 25, 100, 1000, 1000);
        assert_int_equal(b->signal_count, 1);
        assert_int_equal(b->signals[0], 1234);
    }
}

static void motion_stops_in_a_corner_beyond_the_limit(void **state)
{
    (void)state;
    for (size_t s = 0; s < COUNT(steps); s++) {
        struct bench *b = bench_open("line X 10 F 3000\nline X 10 Y 10", steps[s]);
        const long double one = 50.0L / 1000 + 10.0L / 50; /* seconds for each line */
        long double speed;

        interp_run_start(&b->run);
        for (unsigned n = 1; b->run.state != INTERP_ENDED; n++) {
            const long double t = n * (long double)steps[s];

            step(b);
            near_by(way_of(b),
                    t < one ? trapezoid(10, 50, 1000, 1000, t, &speed)
                            : 10 + trapezoid(10, 50, 1000, 1000, t - one, &speed),
                    20);
            near_by(b->run.speed, speed, 50);
        }
    }
    /* 90 degrees are allowed: one move. */
    follows_a_trapezoid(bench_open("corner 90\nline X 10 F 3000\nline X 10 Y 10", 1e-4), 20, 50,
                        1000, 1000);
}

static void a_slower_part_is_entered_at_its_own_speed(void **state)
{
    struct bench *b = bench_open("line X 20 F 6000\nline X 30 F 600\nline X 50 F 6000", 1e-4);
    bool flagged = false;

    (void)state;
    interp_run_start(&b->run);
    while (b->run.state != INTERP_ENDED) {
        const double before = b->run.speed;

        step(b);
        assert_true(fabs(b->run.speed - before) <= 1000 * 1e-4 * (1 + 1e-9));
        if (b->run.part == 1) {
            near(b->run.speed, 10);
            flagged = flagged || b->run.phase == INTERP_NEXT_SPEED;
        }
        /* Where the step ends with the part before, nothing is known of this one yet. */
        assert_true(b->run.part != 1 || b->run.way == 0 || b->run.phase == INTERP_NEXT_SPEED ||
                    b->run.phase == INTERP_AT_SPEED);
    }
    assert_true(flagged);
}

/* Many short lines of any direction, length and feed, without a corner limit: speed is continuous,
 * and no part is faster than it may be. */
static void look_ahead_meets_every_speed(void **state)
{
    static char text[PARTS * 64];
    uint32_t random = 12345;
    size_t at = 0;
    struct bench *b;
    double x = 0;

    (void)state;
    at += (size_t)snprintf(text + at, sizeof text - at, "corner 180\nacceleration 300\n");
    for (int i = 0; i < 500; i++) {
        random = random * 1664525 + 1013904223;
        x += ((int)(random >> 16) % 1000 - 500) * 0.001;
        at += (size_t)snprintf(text + at, sizeof text - at, "line X %.3f Y %.3f F %u\n", x,
                               (random >> 8) % 100 * 0.01, 60 + (random >> 24) * 40);
    }
    b = bench_open(text, 1e-4);
    interp_run_start(&b->run);
    for (double before = 0; b->run.state != INTERP_ENDED; before = b->run.speed) {
        step(b);
        assert_true(fabs(b->run.speed - before) <= 300 * 1e-4 * (1 + 1e-6));
        if (b->run.part < b->path.count)
            assert_true(b->run.speed <= b->parts[b->run.part].feed * (1 + 1e-9));
    }
    assert_true(b->run.speed == 0);
}

/* --- overrides and stops --- */

static void override_scales_the_speed_and_ramps_to_it(void **state)
{
    struct bench *b = bench_open("line X 100 F 6000", 1e-4);

    (void)state;
    interp_run_start(&b->run);
    for (int i = 0; i < 3000; i++)
        step(b);
    near(b->run.speed, 100);
    b->inputs.override = 0.25;
    for (int i = 1; i <= 750; i++) {
        step(b);
        near_by(b->run.speed, 100 - i * 0.1L, 100);
    }
    step(b);
    near(b->run.speed, 25);
    assert_true(b->run.phase == INTERP_AT_SPEED);
    b->inputs.override = 2;
    step(b);
    near(b->run.speed, 25.1L);
    assert_true(b->run.phase == INTERP_ACCELERATES);
    run_out(b, INTERP_ENDED);
    near(way_of(b), 100);
}

static void a_stop_brakes_on_its_ramp_and_goes_on_from_there(void **state)
{
    (void)state;
    for (int emergency = 0; emergency < 2; emergency++) {
        const long double ramp = emergency ? 5000 : 1000;
        struct bench *b =
            bench_open("arc XY centre 50 0 to 100 0 cw F 6000\nline X 100 Y -10", 1e-4);
        long double begin;

        interp_run_start(&b->run);
        for (int i = 0; i < 5000; i++)
            step(b);
        begin = way_of(b);
        interp_run_stop(&b->run, emergency, false);
        for (int i = 1; b->run.state != (emergency ? INTERP_EMERGENCY : INTERP_READY); i++) {
            const long double t = fminl(i * 1e-4L, 100 / ramp);

            step(b);
            near_by(way_of(b), begin + 100 * t - ramp * t * t / 2, begin);
            near_by(b->run.speed, 100 - ramp * t, 100);
            assert_true(b->run.speed == 0 ||
                        b->run.phase == (emergency ? INTERP_EMERGENCY_RAMP : INTERP_DECELERATES));
        }
        near(way_of(b), begin + 100 * 100 / (2 * ramp));
        near(hypotl(b->run.position[0] - 50, b->run.position[1]), 50); /* still on the arc */
        assert_true(interp_run_start(&b->run));
        assert_false(b->run.connecting);
        run_out(b, INTERP_ENDED);
        near(way_of(b), 50 * PIL + 10);
    }
}

static void a_stop_goes_through_joints_and_can_drop_the_path(void **state)
{
    struct bench *b =
        bench_open("line X 1 F 6000\nline X 2\nline X 3\nm 1500\nline X 4\nline X 90", 1e-4);
    double position[INTERP_AXES] = { 0 };

    (void)state;
    interp_run_start(&b->run);
    while (way_of(b) < 0.9L)
        step(b);
    position[0] = b->run.position[0] + b->run.speed * b->run.speed / 2000;
    interp_run_stop(&b->run, false, true);
    run_out(b, INTERP_EMPTY);
    near(b->run.position[0], position[0]);
    assert_false(interp_run_start(&b->run));
    assert_true(b->path.count == 0);
}

static void from_elsewhere_it_connects_in_a_straight_line(void **state)
{
    const double elsewhere[INTERP_AXES] = { 3, 4, -12 };
    struct bench *b = bench_open("line X 10 F 6000\nline X 20", 1e-4);

    (void)state;
    interp_run_place(&b->run, elsewhere);
    assert_true(interp_run_start(&b->run));
    assert_true(b->run.connecting);
    near(interp_run_part(&b->run)->length, 13);
    while (b->run.connecting) {
        step(b);
        if (b->run.connecting)
            near_by(b->run.position[0] * 4, b->run.position[1] * 3, 12);
    }
    interp_run_stop(&b->run, true, false);
    run_out(b, INTERP_EMERGENCY);
    interp_run_place(&b->run, elsewhere); /* in the middle of the first line */
    assert_true(interp_run_start(&b->run));
    near(b->run.connection.end[0], b->run.resume);
    run_out(b, INTERP_ENDED);
    assert_true(b->run.position[0] == 20 && b->run.position[2] == 0);
    near(way_of(b), 20);
    assert_false(interp_run_start(&b->run)); /* at the end there is nothing to run */
}

/* --- waiting --- */

static void motion_waits_for_an_m_function(void **state)
{
    (void)state;
    for (unsigned delay = 0; delay <= 50; delay += 50) {
        struct bench *b = bench_open("line X 1 F 6000\nm 7\nline X 2", 1e-4);
        unsigned waited = 0;

        b->inputs.m_delay = delay;
        interp_run_start(&b->run);
        while (b->run.speed > 0 || b->run.position[0] < 1) {
            step(b);
            assert_int_equal(b->signal_count, delay == 0 && b->run.part == 1);
        }
        for (; b->signal_count == 0; waited++)
            step(b);
        assert_int_equal(waited, delay);
        assert_true(b->run.wait == INTERP_M_SIGNALLED && b->signals[0] == 7);
        for (int i = 0; i < 100; i++) {
            step(b);
            assert_true(b->run.wait == INTERP_M_END && b->run.position[0] == 1);
            assert_true(b->run.phase == INTERP_STANDS);
        }
        b->inputs.m_done = true;
        step(b);
        near(b->run.position[0], 1 + 1000 * 1e-4L * 1e-4L / 2);
        assert_true(b->run.wait == INTERP_NO_WAIT);
        run_out(b, INTERP_ENDED);
        assert_int_equal(b->signal_count, 1);
    }
}

static void a_stop_while_waiting_keeps_the_m_function(void **state)
{
    struct bench *b = bench_open("m 7\nline X 2 F 6000", 1e-4);

    (void)state;
    interp_run_start(&b->run);
    step(b);
    step(b);
    interp_run_stop(&b->run, false, false);
    step(b);
    assert_true(b->run.state == INTERP_READY);
    interp_run_start(&b->run);
    step(b);
    assert_true(b->run.wait == INTERP_M_END && b->signal_count == 1);
    b->inputs.m_done = true;
    run_out(b, INTERP_ENDED);
}

static void pauses_last_as_long_as_they_say(void **state)
{
    struct bench *b =
        bench_open("dwell 10ms\nline X 1 F 6000\nm 0\nwait external -5\ndwell 1s", 1e-4);

    (void)state;
    interp_run_start(&b->run);
    for (int i = 0; i < 40; i++)
        step(b);
    interp_run_stop(&b->run, false, false);
    step(b);
    assert_true(b->run.state == INTERP_READY);
    interp_run_start(&b->run);
    for (int i = 0; i < 59; i++)
        step(b);
    assert_true(b->run.part == 0 && b->run.position[0] == 0);
    step(b);
    step(b);
    assert_true(b->run.position[0] > 0);
    run_out(b, INTERP_READY); /* M0: to be started again, and not told to the PLC */
    assert_int_equal(b->signal_count, 0);
    b->inputs.external = -6;
    interp_run_start(&b->run);
    for (int i = 0; i < 10; i++)
        step(b);
    assert_true(b->run.wait == INTERP_PULSE && b->run.part == 3);
    b->inputs.external = -5;
    assert_int_equal(run_out(b, INTERP_ENDED), 10001);
}

static void a_path_that_is_being_filled_starves_and_goes_on(void **state)
{
    struct bench *b = bench_open("line X 1 F 6000", 1e-4);
    const struct interp_part more = { .kind = INTERP_LINE, .end = { 5 }, .feed = 100 };
    const char *what;

    (void)state;
    b->path.more = true;
    interp_run_start(&b->run);
    run_out(b, INTERP_STARVED);
    assert_false(interp_run_start(&b->run));
    assert_int_equal(interp_path_add(&b->path, &more, &what), 0);
    interp_run_appended(&b->run);
    b->path.more = false;
    assert_true(interp_run_start(&b->run));
    run_out(b, INTERP_ENDED);
    assert_true(b->run.position[0] == 5);
}

/* --- filters --- */

static void the_spline_is_a_moving_average(void **state)
{
    static struct interp_spline spline;
    const double start[INTERP_AXES] = { 1000, -3 };
    const unsigned points = 200;

    (void)state;
    interp_spline_set(&spline, points, start);
    for (unsigned n = 1; n <= 1000000; n++) { /* a ramp */
        double position[INTERP_AXES] = { 1000 + n * 0.125, -3 };
        const long double inside = n < points ? n : points;

        interp_spline_step(&spline, position);
        /* The last `inside` of its points are on the ramp. */
        near(position[0], 1000 + 0.125L * (inside * n - inside * (inside - 1) / 2) / points);
        assert_true(position[1] == -3);
    }
    for (unsigned n = 1; n <= 2 * points; n++) {
        double position[INTERP_AXES] = { 0.1, -3 };

        interp_spline_step(&spline, position);
        assert_true((position[0] == 0.1) == (n >= points)); /* not before, then exactly */
    }
}

/* The response to a step of 1 after t. */
static long double response(long double p, long double q, long double t)
{
    const long double d = p * p / 4 - q, half = p / 2;

    if (fabsl(d) < 1e-15L)
        return 1 - expl(-half * t) * (1 + half * t);
    if (d < 0) {
        const long double w = sqrtl(-d);

        return 1 - expl(-half * t) * (cosl(w * t) + half / w * sinl(w * t));
    }
    const long double r = sqrtl(d);
    return 1 - expl(-half * t) * (coshl(r * t) + half / r * sinhl(r * t));
}

static void the_low_pass_answers_a_step_in_closed_form(void **state)
{
    static const double settings[][3] = {
        { 1.414213, 2, 0.01 }, { 3, 3, 0.02 }, { 2, 1, 0.005 }, { 5, 4, 0.01 }, { 0.1, 9, 0.1 },
    };
    const double start[INTERP_AXES] = { 0 };

    (void)state;
    for (size_t i = 0; i < COUNT(settings); i++)
        for (size_t s = 0; s < COUNT(steps); s++) {
            static struct interp_iir iir;
            const double *set = settings[i];
            double position[INTERP_AXES];

            assert_true(interp_iir_set(&iir, set[0], set[1], set[2], 1, steps[s], start));
            for (unsigned n = 1; n <= 4000; n++) {
                memcpy(position, (double[INTERP_AXES]){ 1, 1 }, sizeof position);
                interp_iir_step(&iir, position);
                near_by(position[0], response(set[0], set[1], n * (long double)steps[s] / set[2]),
                        1);
                assert_true(position[1] == 1); /* not of its axes */
            }
            for (double t = 0; t < 100 * set[2] / fmin(set[0], 1); t += steps[s]) {
                position[0] = 1;
                interp_iir_step(&iir, position);
            }
            assert_true(position[0] == 1);
        }
    struct interp_iir iir = { .axes = 5 };
    assert_false(interp_iir_set(&iir, 0, 1, 1, 1, 1e-4, start));
    assert_false(interp_iir_set(&iir, 1, -1, 1, 1, 1e-4, start));
    assert_false(interp_iir_set(&iir, 1, 1, 0, 1, 1e-4, start));
    assert_true(iir.axes == 5);
    assert_true(interp_iir_set(&iir, 0, 0, 0, 0, 1e-4, start) && iir.axes == 0);
    /* The most unlike numbers that registers can hold. */
    assert_true(interp_iir_set(&iir, 2147, 2147, 1e-6, 1023, 1e-2, start));
    for (int n = 0; n < 1000; n++) {
        double position[INTERP_AXES] = { 1e9, -1e9 };

        interp_iir_step(&iir, position);
        assert_true(fabs(position[0]) < 4e9);
    }
}

/* --- text --- */

static void a_text_says_everything(void **state)
{
    static const char text[] = "# a path\n"
                               "from X 5\n"
                               "acceleration 2000\ndeceleration 1500\nemergency 9000\n"
                               "rapid-speed 12000\r\ncorner 10\nbacklash 0.5 X 20 Z -3\n"
                               "\n"
                               "tool 3\n"
                               "correction left   # of the path\n"
                               "\tline X 10 Y 20 F 600\n"
                               "m 3 S 1000 X -0.5\n"
                               "correction off\n"
                               "arc XZ radius 5 to 20 0 cw\n"
                               "dwell 1.5ms\n"
                               "wait external -12\n"
                               "rapid O +1.25\n";
    struct bench *b = bench_open(text, 1e-4);
    const struct interp_limits *limits = &b->path.limits;

    (void)state;
    assert_int_equal(b->path.count, 6);
    assert_true(interp_file_parts(text, sizeof text - 1) >= 6);
    assert_true(b->path.start[0] == 5 && limits->acceleration == 2000);
    assert_true(limits->deceleration == 1500 && limits->emergency == 9000);
    near(limits->rapid, 200);
    near(limits->corner, 10 / 180.0L);
    assert_true(limits->backlash[0] == 20 && limits->backlash[2] == -3);
    assert_true(limits->backlash_step == 0.5);
    assert_true(b->parts[0].kind == INTERP_LINE && b->parts[0].tool == 3);
    assert_true(b->parts[0].correction == 41 && b->parts[0].line == 12);
    assert_true(b->parts[0].letters['X' - 'A'] == 10 && b->parts[0].letters['F' - 'A'] == 600);
    assert_true(b->parts[1].kind == INTERP_M && b->parts[1].code == 3);
    assert_true(b->parts[1].letters['S' - 'A'] == 1000 && b->parts[1].letters['X' - 'A'] == -0.5);
    assert_true(b->parts[2].kind == INTERP_CW && b->parts[2].plane == INTERP_XZ);
    assert_true(b->parts[2].correction == 0);
    near(b->parts[2].feed, 10);
    assert_true(b->parts[3].kind == INTERP_DWELL);
    near(b->parts[3].dwell, 0.0015L);
    assert_true(b->parts[4].external == -12 && b->parts[5].end[9] == 1.25);
    near(b->parts[5].feed, 200);
}

static void a_wrong_text_is_refused_with_a_place(void **state)
{
    static const struct {
        const char *text, *why;
    } cases[] = {
        { "line X 1", "t:1:9: no feed so far; expected F and a number" },
        { "\nlien X 1", "t:2:1: unexpected 'lien'; expected line, rapid, arc" },
        { "line Q 1", "t:1:6: unexpected 'Q'; expected an axis or F" },
        { "line X", "t:1:7: the line ends here; expected a number" },
        { "line X 1 X 2 F 5", "t:1:10: given twice" },
        { "line X 0x10 F 5", "t:1:8: unexpected '0x10'; expected a number" },
        { "line X nan F 5", "t:1:8: unexpected 'nan'; expected a number" },
        { "line X 1.2.3 F 5", "t:1:8: unexpected '1.2.3'; expected a number" },
        { "line X 99999999999 F 5", "t:1:8: the number is too large" },
        { "line X 1 F 0", "t:1:12: unexpected '0'; expected a number above 0" },
        { "rapid X 1 F 5", "t:1:11: unexpected 'F'; expected an axis" },
        { "arc XX centre 1 1 to 2 2 cw F 1", "t:1:5: unexpected 'XX'; expected XY, XZ or YZ" },
        { "arc XY 1 1", "t:1:8: unexpected '1'; expected 'centre' or 'radius'" },
        { "arc XY centre 5 0 to 11 0 cw F 1", "t:1:1: the end of the arc is not as far" },
        { "arc XY radius 1 to 9 0 cw F 1", "t:1:8: there is no such arc" },
        { "arc XY centre 5 0 to 10 0 X 3", "t:1:27: unexpected 'X'; expected 'cw' or 'ccw'" },
        { "arc XY centre 5 0 to 10 0 cw X 3 F 1", "t:1:30: given twice" },
        { "m 1000", "t:1:1: M functions are 0 to 999 and from 1001 on" },
        { "m 3.5", "t:1:3: unexpected '3.5'; expected a whole number" },
        { "m 3 G 1", "t:1:5: unexpected 'G'; expected a letter but G, M, N, P" },
        { "dwell 100", "t:1:7: unexpected '100'; expected a time such as 100ms" },
        { "dwell 5ms 6", "t:1:11: unexpected '6'; expected the end of the line" },
        { "m 3\nfrom X 1", "t:2:1: this belongs in front of the first part" },
        { "deceleration 10\nemergency 5", "t:2:11: the emergency ramp is slower" },
        { "corner 181", "t:1:8: unexpected '181'; expected 0 to 180 degrees" },
        { "wait 3", "t:1:6: unexpected '3'; expected 'external'" },
        { "correction 41", "t:1:12: unexpected '41'; expected 'left', 'right' or 'off'" },
    };
    static struct interp_part parts[8];

    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        struct interp_path path;
        char why[INTERP_FILE_WHY];

        interp_path_init(&path, parts, COUNT(parts));
        assert_int_equal(interp_file_read(&path, cases[i].text, strlen(cases[i].text), "t", why),
                         -22);
        if (strncmp(why, cases[i].why, strlen(cases[i].why)) != 0)
            fail_msg("%s\n instead of\n%s", why, cases[i].why);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(angles_are_those_of_the_c_library),
        cmocka_unit_test(a_line_goes_straight_in_all_axes),
        cmocka_unit_test(an_arc_is_one_in_every_plane_and_direction),
        cmocka_unit_test(an_arc_may_be_a_circle_or_have_a_radius),
        cmocka_unit_test(impossible_parts_are_refused),
        cmocka_unit_test(speed_along_a_line_is_a_trapezoid),
        cmocka_unit_test(speed_is_kept_through_tangential_joints),
        cmocka_unit_test(motion_stops_in_a_corner_beyond_the_limit),
        cmocka_unit_test(a_slower_part_is_entered_at_its_own_speed),
        cmocka_unit_test(look_ahead_meets_every_speed),
        cmocka_unit_test(override_scales_the_speed_and_ramps_to_it),
        cmocka_unit_test(a_stop_brakes_on_its_ramp_and_goes_on_from_there),
        cmocka_unit_test(a_stop_goes_through_joints_and_can_drop_the_path),
        cmocka_unit_test(from_elsewhere_it_connects_in_a_straight_line),
        cmocka_unit_test(motion_waits_for_an_m_function),
        cmocka_unit_test(a_stop_while_waiting_keeps_the_m_function),
        cmocka_unit_test(pauses_last_as_long_as_they_say),
        cmocka_unit_test(a_path_that_is_being_filled_starves_and_goes_on),
        cmocka_unit_test(the_spline_is_a_moving_average),
        cmocka_unit_test(the_low_pass_answers_a_step_in_closed_form),
        cmocka_unit_test(a_text_says_everything),
        cmocka_unit_test(a_wrong_text_is_refused_with_a_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
