/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "conformance/chronicle.h"

/* --- sketches --------------------------------------------------------------------------------- */

static void feed(struct sketch *sketch, unsigned curve, unsigned cycles, double (*value)(unsigned))
{
    for (unsigned i = 0; i < cycles; i++) {
        sketch_note(sketch, curve, value(i));
        sketch_cycle(sketch);
    }
}

static double identity(unsigned cycle)
{
    return cycle;
}

static double one_peak(unsigned cycle)
{
    return cycle == 54321 ? 7 : 1;
}

static void a_short_run_keeps_every_cycle(void **state)
{
    struct sketch sketch = { 0 };
    (void)state;
    feed(&sketch, 2, SKETCH_BUCKETS, identity);
    assert_int_equal(sketch.per_bucket, 1);
    assert_int_equal(sketch.used, SKETCH_BUCKETS);
    for (unsigned i = 0; i < SKETCH_BUCKETS; i++) {
        assert_true(sketch.least[2][i] == (float)i);
        assert_true(sketch.greatest[2][i] == (float)i);
    }
}

static void a_long_run_loses_no_peak(void **state)
{
    struct sketch sketch = { 0 };
    unsigned peaks = 0;
    (void)state;
    feed(&sketch, 0, 100000, one_peak);
    assert_int_equal(sketch.per_bucket, 512);
    assert_int_equal(sketch.used, (100000 + 511) / 512);
    assert_int_equal(sketch.cycles, 100000);
    for (unsigned i = 0; i < sketch.used; i++) {
        assert_true(sketch.least[0][i] == 1);
        peaks += sketch.greatest[0][i] == 7;
    }
    assert_int_equal(peaks, 1);
    assert_true(sketch.greatest[0][54321 / 512] == 7);
}

static void a_cycle_without_a_value_is_a_hole(void **state)
{
    struct sketch sketch = { 0 };
    (void)state;
    sketch_note(&sketch, 0, 3);
    sketch_cycle(&sketch);
    sketch_cycle(&sketch);
    sketch_note(&sketch, 0, NAN);
    sketch_cycle(&sketch);
    sketch_note(&sketch, 0, 1e300); /* too large to draw */
    sketch_cycle(&sketch);
    assert_true(sketch.least[0][0] == 3);
    for (unsigned i = 1; i < 4; i++)
        assert_true(isnan(sketch.least[0][i]) && isnan(sketch.greatest[0][i]));
    assert_true(isnan(sketch.least[1][0]));
}

static void what_a_worker_wrote_is_made_safe(void **state)
{
    struct sketch sketch;
    (void)state;
    memset(&sketch, 0xFF, sizeof sketch);
    sketch_clean(&sketch);
    assert_int_equal(sketch.used, SKETCH_BUCKETS);
    sketch.per_bucket = 0;
    sketch_clean(&sketch);
    assert_int_equal(sketch.used, 0);
}

/* --- plots ------------------------------------------------------------------------------------ */

static struct experiment half_millisecond(void)
{
    return (struct experiment){ .name = "cycle-500", .host.cycle_us = 500, .cycles = 1000 };
}

static double still(unsigned cycle)
{
    (void)cycle;
    return 42;
}

static void curves_that_never_move_are_left_out(void **state)
{
    static struct sketch sketch;
    const struct experiment experiment = half_millisecond();
    struct plot_report plot;
    (void)state;
    memset(&sketch, 0, sizeof sketch);
    feed(&sketch, sketch_of_axis(0, SKETCH_POSITION), 100, still);
    assert_int_equal(chronicle_plot(&plot, "run", &experiment, &sketch), 0);
    assert_int_equal(plot.curve_count, 0);
    assert_null(plot.curves);
    feed(&sketch, sketch_of_axis(1, SKETCH_WRITE_POSITION), 100, identity);
    assert_int_equal(chronicle_plot(&plot, "run", &experiment, &sketch), 0);
    assert_int_equal(plot.curve_count, 1);
    assert_string_equal(plot.title, "run, Cycle_Time 500 us");
    assert_string_equal(plot.curves[0].name, "SERVO[1].WritePosition");
    assert_string_equal(plot.curves[0].unit, "inc");
    assert_int_equal(plot.buckets, 200);
    assert_true(fabs(plot.end - 0.1) < 1e-9);
    assert_true(isnan(plot.curves[0].least[99]) && plot.curves[0].least[199] == 99);
    chronicle_plot_free(&plot);
}

/* --- coverage --------------------------------------------------------------------------------- */

static void coverage_of_runs_adds_up(void **state)
{
    static struct coverage one, two, all;
    const uint8_t first[] = { 0x0F, 0x00 }, second[] = { 0xF0, 0x01 };
    (void)state;
    memset(&all, 0, sizeof all);
    coverage_take(&one, first, 0x1000, 0x1010);
    coverage_take(&two, second, 0x1000, 0x1010);
    coverage_add(&all, &one);
    assert_int_equal(coverage_count(&all, 0x1000, 16), 4);
    assert_int_equal(coverage_gap(&all, 0x1000, 16), 0x1004);
    coverage_add(&all, &two);
    assert_int_equal(coverage_count(&all, 0x1000, 16), 9);
    assert_int_equal(coverage_gap(&all, 0x1000, 8), 0x1008);
    assert_int_equal(coverage_gap(&all, 0x1000, 16), 0x1009);
    assert_int_equal(coverage_count(&all, 0xFF0, 0x100), 9); /* nothing beyond its ends */
    two.begin = 0x2000;
    memset(two.bits, 0xFF, 2);
    coverage_add(&all, &two); /* of another module */
    assert_int_equal(coverage_count(&all, 0x1000, 16), 9);
}

static void coverage_of_a_large_module_is_cut_and_stays_in_its_place(void **state)
{
    static uint8_t bits[COVERAGE_MOST / 8 + 4096];
    static struct coverage coverage;
    (void)state;
    memset(bits, 0xFF, sizeof bits);
    coverage_take(&coverage, bits, 0, sizeof bits * 8);
    assert_int_equal(coverage.size, COVERAGE_MOST);
    assert_int_equal(coverage_count(&coverage, 0, COVERAGE_MOST), COVERAGE_MOST);
    assert_int_equal(coverage_count(&coverage, COVERAGE_MOST, 64), 0);
    coverage.size = UINT64_MAX;
    coverage_clean(&coverage);
    assert_int_equal(coverage.size, COVERAGE_MOST);
}

/* --- timelines -------------------------------------------------------------------------------- */

static struct experiment_result *result_of(uint64_t cycles)
{
    struct experiment_result *result = calloc(1, sizeof *result);
    result->worker.end = WORKER_DONE;
    result->evidence.cycles_done = cycles;
    result->evidence.time_ns = cycles * 500000;
    result->evidence.slaves = 2;
    result->evidence.op_cycle = 7;
    return result;
}

static void message(struct experiment_result *result, uint64_t cycle, const char *text)
{
    struct evidence_message *m = &result->evidence.messages[result->evidence.message_count++];
    m->entry = ENTRY_04;
    m->cycle = cycle;
    snprintf(m->text, sizeof m->text, "%s", text);
}

static void events_stand_in_the_order_of_time(void **state)
{
    const struct experiment experiment = half_millisecond();
    struct experiment_result *result = result_of(1000);
    struct timeline_report timeline;
    (void)state;
    message(result, EVIDENCE_NO_CYCLE, "hello");
    message(result, 900, "late");
    result->evidence.fault_count = 1;
    result->evidence.faults[0].time_ns = 100000000;
    strcpy(result->evidence.faults[0].text, "frame lost");
    result->evidence.incident_count = 1;
    result->evidence.incidents[0] = (struct evidence_incident){
        .entry = ENTRY_02, .cycle = 400, .kind = MACHINE_FAULT, .fault.signal = SIGFPE
    };
    assert_int_equal(chronicle_timeline(&timeline, &experiment, result, NULL), 0);
    static const struct {
        enum timeline_kind kind;
        double seconds;
        const char *source, *text;
    } wanted[] = { { TIMELINE_MESSAGE, 0, "Program_04", "hello" },
                   { TIMELINE_STATE, 0.0035, "bus", "every slave is in OP" },
                   { TIMELINE_FAULT, 0.1, "bus", "frame lost" },
                   { TIMELINE_INCIDENT, 0.2, "Program_02", NULL },
                   { TIMELINE_MESSAGE, 0.45, "Program_04", "late" } };
    assert_int_equal(timeline.event_count, 5);
    for (size_t i = 0; i < 5; i++) {
        const struct timeline_event *event = &timeline.events[i];
        assert_int_equal(event->kind, wanted[i].kind);
        assert_true(fabs(event->seconds - wanted[i].seconds) < 1e-9);
        assert_string_equal(event->source, wanted[i].source);
        if (wanted[i].text != NULL)
            assert_string_equal(event->text, wanted[i].text);
    }
    assert_non_null(strstr(timeline.events[3].text, "Program_02 divided by zero"));
    assert_false(timeline.events[0].has_cycle);
    assert_true(timeline.events[3].has_cycle && timeline.events[3].cycle == 400);
    assert_string_equal(timeline.about, "Cycle_Time 500 us, 1000 cycles");
    free(timeline.events);
    free(result);
}

static void the_same_message_again_is_counted(void **state)
{
    const struct experiment experiment = half_millisecond();
    struct experiment_result *result = result_of(1000);
    struct timeline_report timeline;
    (void)state;
    for (unsigned i = 0; i < 20; i++)
        message(result, 10 + i, "again");
    for (unsigned i = 20; i < EVIDENCE_MESSAGES; i++)
        message(result, 10 + i, "other");
    result->evidence.message_count = EVIDENCE_MESSAGES + 5000; /* more than are stored */
    assert_int_equal(chronicle_timeline(&timeline, &experiment, result, NULL), 0);
    assert_string_equal(timeline.events[1].text, "again");
    assert_int_equal(timeline.events[1].count, 20);
    assert_int_equal(timeline.dropped, 5000);
    free(timeline.events);
    free(result);
}

static void a_run_that_was_ended_says_so(void **state)
{
    const struct experiment experiment = half_millisecond();
    struct experiment_result *result = result_of(12);
    struct timeline_report timeline;
    (void)state;
    result->worker.end = WORKER_KILLED;
    result->evidence.op_cycle = EVIDENCE_NO_CYCLE;
    assert_int_equal(chronicle_timeline(&timeline, &experiment, result, NULL), 0);
    assert_int_equal(timeline.event_count, 2);
    assert_string_equal(timeline.events[0].text, "not every slave has reached OP");
    assert_string_equal(timeline.events[1].text, "the process of the run was ended");
    free(timeline.events);
    free(result);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_short_run_keeps_every_cycle),
        cmocka_unit_test(a_long_run_loses_no_peak),
        cmocka_unit_test(a_cycle_without_a_value_is_a_hole),
        cmocka_unit_test(what_a_worker_wrote_is_made_safe),
        cmocka_unit_test(curves_that_never_move_are_left_out),
        cmocka_unit_test(coverage_of_runs_adds_up),
        cmocka_unit_test(coverage_of_a_large_module_is_cut_and_stays_in_its_place),
        cmocka_unit_test(events_stand_in_the_order_of_time),
        cmocka_unit_test(the_same_message_again_is_counted),
        cmocka_unit_test(a_run_that_was_ended_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
