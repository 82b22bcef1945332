/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Recordings made short, and what gnuplot is told of them. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "report/picture.h"

struct walk {
    size_t points, holes;
    double least, greatest, first, last, last_time;
};

static void visit(void *argument, double time, double value)
{
    struct walk *w = argument;

    if (isnan(value)) {
        w->holes++;
        return;
    }
    if (w->points == 0)
        w->first = w->least = w->greatest = value;
    else
        assert_true(time > w->last_time);
    w->least = fmin(w->least, value);
    w->greatest = fmax(w->greatest, value);
    w->last = value;
    w->last_time = time;
    w->points++;
}

static struct walk walk(const struct curves *curves, size_t curve)
{
    struct walk w = { 0 };

    curves_walk(curves, curve, visit, &w);
    return w;
}

static void a_short_recording_keeps_every_point(void **state)
{
    struct curves *curves = curves_new(2);
    struct walk w;

    (void)state;
    for (int i = 0; i < 100; i++)
        curves_add(curves, (double[]){ i * 0.5, i, -i * i });
    w = walk(curves, 1);
    assert_int_equal(w.points, 100);
    assert_true(w.first == 0 && w.last == -99 * 99);
    assert_int_equal(curves_rows(curves), 100);
    assert_true(curves_begin(curves) == 0 && curves_end(curves) == 49.5);
    curves_free(curves);
}

static void a_long_one_keeps_peaks_of_a_single_row(void **state)
{
    struct curves *curves = curves_new(1);
    struct walk w;
    double least, greatest;

    (void)state;
    for (int i = 0; i < 1000000; i++)
        curves_add(curves, (double[]){ i, i == 12345 ? 50 : i == 777780 ? -50 : i % 2 });
    w = walk(curves, 0);
    assert_true(w.points <= 4 * CURVES_BUCKETS && w.points > 2 * CURVES_BUCKETS / 2);
    assert_true(w.least == -50 && w.greatest == 50);
    assert_true(w.first == 0 && w.last == 1 && w.last_time == 999999);
    assert_true(curves_range(curves, 0, &least, &greatest));
    assert_true(least == -50 && greatest == 50);
    curves_free(curves);
}

static void what_is_no_number_is_a_hole(void **state)
{
    struct curves *curves = curves_new(2);
    struct walk w;
    double least, greatest;

    (void)state;
    for (int i = 0; i < 10; i++)
        curves_add(curves, (double[]){ i, i == 4 || i == 5 ? (double)NAN : i, (double)INFINITY });
    w = walk(curves, 0);
    assert_int_equal(w.points, 8);
    assert_int_equal(w.holes, 2);
    assert_int_equal(walk(curves, 1).holes, 10);
    assert_false(curves_range(curves, 1, &least, &greatest));
    assert_false(curves_binary(curves, 1));
    curves_free(curves);
}

static void only_0_and_1_are_binary(void **state)
{
    struct curves *curves = curves_new(3);

    (void)state;
    for (int i = 0; i < 5000; i++)
        curves_add(curves, (double[]){ i, i / 7 % 2, i == 2000 ? 2 : 0, 1 });
    assert_true(curves_binary(curves, 0));
    assert_false(curves_binary(curves, 1));
    assert_true(curves_binary(curves, 2));
    curves_free(curves);
}

/* --- the picture ------------------------------------------------------------------------------ */

static const struct picture_curve servo[] = {
    { "SERVO[0].WritePosition", "inc", false },
    { "SERVO[0].Position", "inc", false },
    { "SERVO[1].WritePosition", "inc", false },
    { "SERVO[1].Position", "inc", false },
    { "SERVO[0].Speed", "inc/s", false },
    { "SERVO[0].Mode", "", true },
    { "SERVO[1].Mode", "", true },
    { "DIO[0].In0", "", true },
    { "DIO[0].Out0", "", true },
};

static char *script_of(const struct picture *picture, enum picture_kind kind, const char *path)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);

    assert_non_null(stream);
    picture_script(stream, picture, kind, path);
    assert_int_equal(fclose(stream), 0);
    return text;
}

static size_t count_of(const char *text, const char *what)
{
    size_t count = 0;

    for (; (text = strstr(text, what)) != NULL; text += strlen(what))
        count++;
    return count;
}

static void assert_says(const char *text, const char *what)
{
    if (strstr(text, what) == NULL)
        fail_msg("no '%s' in:\n%s", what, text);
}

static struct curves *servo_data(double begin)
{
    struct curves *curves = curves_new(sizeof servo / sizeof *servo);

    for (int i = 0; i < 1000; i++)
        curves_add(curves, (double[]){ begin + i * 0.001, i * 1000, i * 1000 - 5, 7, 7, 1e6,
                                       i / 500 + 2, 2, i / 100 % 2, i / 50 % 2 });
    return curves;
}

static void registers_of_one_unit_share_a_panel(void **state)
{
    struct curves *curves = servo_data(0);
    const struct picture picture = { "title", servo, sizeof servo / sizeof *servo, curves };
    char *text = script_of(&picture, PICTURE_SVG, "axis.svg");

    (void)state;
    /* Positions, speed, modes, and both digital registers as lanes. */
    assert_int_equal(count_of(text, "\nplot "), 4);
    assert_says(text, "set label 3 'inc' at");
    assert_says(text, "set label 3 'Speed (inc/s)' at");
    assert_says(text, "set label 3 'Mode' at");
    assert_says(text, "set ytics ('DIO[0].In0' 1.5, 'DIO[0].Out0' 0.5)\n");
    assert_says(text, "set xlabel 'time (s)'\n");
    assert_int_equal(count_of(text, "set xlabel"), 1);
    assert_says(text, "set label 2 '0 s to 0.999 s, 1000 samples'");
    assert_says(text, "'1 000 000' 1000000");
    assert_says(text, "set terminal svg ");
    assert_says(text, "set output './axis.svg'\n");
    free(text);
    curves_free(curves);
}

static void integers_are_drawn_as_steps_and_set_points_wide_in_the_colour_of_their_servo(
    void **state)
{
    struct curves *curves = servo_data(0);
    const struct picture picture = { "title", servo, sizeof servo / sizeof *servo, curves };
    char *text = script_of(&picture, PICTURE_PNG, "/tmp/axis.png");

    (void)state;
    assert_says(text, "$c0 using 1:2 with lines linewidth 6 dashtype 1 linecolor rgb '#a00072b2' "
                      "title 'SERVO[0].WritePosition'");
    assert_says(text, "$c1 using 1:2 with lines linewidth 1.6 dashtype 1 linecolor rgb '#0072b2' "
                      "title 'SERVO[0].Position'");
    assert_says(text, "'#a0d55e00' title 'SERVO[1].WritePosition'");
    assert_says(text, "'#d55e00' title 'SERVO[1].Position'");
    /* Under what follows them. */
    assert_true(strstr(text, "'SERVO[1].WritePosition'") < strstr(text, "'SERVO[0].Position'"));
    assert_says(text, "$c5 using 1:2 with steps");
    assert_says(text, "$c7 using 1:2 with steps linewidth 1.6 dashtype 1 linecolor rgb '#0072b2' "
                      "notitle");
    assert_says(text, "set terminal pngcairo ");
    assert_says(text, "set output '/tmp/axis.png'\n");
    free(text);
    curves_free(curves);
}

static void a_value_that_stands_still_is_two_points(void **state)
{
    struct curves *curves = servo_data(0);
    const struct picture picture = { "title", servo, sizeof servo / sizeof *servo, curves };
    char *text = script_of(&picture, PICTURE_PNG, "axis.png");

    (void)state;
    assert_says(text, "$c4 << end\n0 1000000\n0.999 1000000\nend\n");
    assert_says(text, "$c5 << end\n0 2\n0.499 2\n0.5 3\n0.999 3\nend\n");
    free(text);
    curves_free(curves);
}

static void samples_before_the_trigger_show_where_it_is(void **state)
{
    struct curves *curves = servo_data(-0.2);
    const struct picture picture = { "title", servo, sizeof servo / sizeof *servo, curves };
    char *text = script_of(&picture, PICTURE_PNG, "axis.png");

    (void)state;
    assert_says(text, "set arrow 1 from first 0, graph 0 to first 0, graph 1 nohead");
    free(text);
    curves_free(curves);
    curves = servo_data(0);
    text = script_of(&(struct picture){ "title", servo, 9, curves }, PICTURE_PNG, "axis.png");
    assert_null(strstr(text, "set arrow"));
    free(text);
    curves_free(curves);
}

/* Names come from files: gnuplot must take them as text, never as commands or programs. */
static void no_name_gets_out_of_its_quotes(void **state)
{
    const struct picture_curve curve = { "a'\nsystem 'true", "u'; system 'x", false };
    struct curves *curves = curves_new(1);
    const struct picture picture = { "it's `x`\n!y", &curve, 1, curves };
    char *text;

    (void)state;
    curves_add(curves, (double[]){ 0, 1 });
    text = script_of(&picture, PICTURE_PNG, "|true.png");
    assert_says(text, "title 'a''?system ''true'");
    assert_says(text, "set label 3 'a''?system ''true (u''; system ''x)'");
    assert_says(text, "set label 1 'it''s `x`?!y' at");
    assert_says(text, "set output './|true.png'");
    free(text);
    curves_free(curves);
}

static void any_range_has_an_axis(void **state)
{
    static const struct {
        double a, b;
        const char *tick;
    } rows[] = {
        { 0, 0, "'0.0' 0" },
        { 5, 5, "'5' 5" },
        { -1e-7, 1e-7, "'0.00000000' 0" },
        { -12345678, 1, "'-10 000 000' -10000000" },
        { -1e308, 1e308, "'0' 0" },
        { NAN, NAN, "'0.0' 0" },
        { 1e15, 1e15 + 1, "1e+15" },
        { 4e-310, 8e-310, "set ytics (" },
    };
    const struct picture_curve curve = { "DATA.F64[0]", "", false };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct curves *curves = curves_new(1);
        char *text;

        curves_add(curves, (double[]){ 0, rows[i].a });
        curves_add(curves, (double[]){ 0.001, rows[i].b });
        text = script_of(&(struct picture){ "t", &curve, 1, curves }, PICTURE_PNG, "x.png");
        assert_says(text, rows[i].tick);
        assert_true(strlen(text) < 4000);
        assert_null(strstr(text, "[nan"));
        assert_null(strstr(text, "inf"));
        free(text);
        curves_free(curves);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_short_recording_keeps_every_point),
        cmocka_unit_test(a_long_one_keeps_peaks_of_a_single_row),
        cmocka_unit_test(what_is_no_number_is_a_hole),
        cmocka_unit_test(only_0_and_1_are_binary),
        cmocka_unit_test(registers_of_one_unit_share_a_panel),
        cmocka_unit_test(
            integers_are_drawn_as_steps_and_set_points_wide_in_the_colour_of_their_servo),
        cmocka_unit_test(a_value_that_stands_still_is_two_points),
        cmocka_unit_test(samples_before_the_trigger_show_where_it_is),
        cmocka_unit_test(no_name_gets_out_of_its_quotes),
        cmocka_unit_test(any_range_has_an_axis),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
