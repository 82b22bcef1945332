/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The INTERPOLATOR registers, from the side of the PLC and from the CNC side, and the way from an
 * interpolator to a servo. */
#include "tests/motion_rig.h"

#include "host/interp_file.h"
#include "host/interp_filter.h"
#include "host/interp_run.h"

#define PARTS 64

/* --- nothing is allocated while cycles run (the linker leads the allocator here) --- */

static unsigned allocations;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_realloc(void *old, size_t size);

void *__wrap_malloc(size_t size)
{
    allocations++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    allocations++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    allocations++;
    return __real_realloc(old, size);
}

/* --- the bench --- */

static struct interp_part parts[PARTS];

static struct interp_path path_of(const char *text)
{
    struct interp_path path;
    char why[INTERP_FILE_WHY];

    interp_path_init(&path, parts, PARTS);
    if (interp_file_read(&path, text, strlen(text), "test", why) != 0)
        fail_msg("%s", why);
    return path;
}

static double of(const struct rig *rig, const char *member)
{
    char name[80];

    snprintf(name, sizeof name, "INTERPOLATOR[0].%s", member);
    return rig_get(rig, name);
}

static void put(const struct rig *rig, const char *member, double value)
{
    char name[80];

    snprintf(name, sizeof name, "INTERPOLATOR[0].%s", member);
    rig_set(rig, name, value);
}

static void load(struct rig *rig, const char *text)
{
    const struct interp_path path = path_of(text);
    char why[HOST_WHY];

    if (host_interpolator_load(rig->host, 0, &path, false, why) != 0)
        fail_msg("%s", why);
}

static void load_and_start(struct rig *rig, const char *text)
{
    load(rig, text);
    assert_true(host_interpolator_start(rig->host, 0));
}

static unsigned until(struct rig *rig, const char *member, double value, unsigned most)
{
    for (unsigned i = 0; i < most; i++) {
        if (of(rig, member) == value)
            return i;
        rig_cycles(rig, 1);
    }
    fail_msg("%s is %g, not %g, after %u cycles", member, of(rig, member), value, most);
    return 0;
}

/* Parameters, then Command; Command_Status once it is over. */
static double order(struct rig *rig, int command, const double *par, unsigned count)
{
    char name[32];

    for (unsigned i = 0; i < count; i++) {
        snprintf(name, sizeof name, "Command_Parametr[%u]", i);
        put(rig, name, par[i]);
    }
    put(rig, "Command", command);
    rig_cycles(rig, 1);
    until(rig, "Command", 0, 10000);
    return of(rig, "Command_Status");
}

#define ORDER(rig, command, ...)                                                                   \
    order(rig, command, (const double[]){ __VA_ARGS__ }, COUNT(((const double[]){ __VA_ARGS__ })))

static double phase(const struct rig *rig)
{
    return floor(of(rig, "Run_Flag") / 65536);
}

static double doing(const struct rig *rig)
{
    return of(rig, "Run_Flag") - 65536 * phase(rig);
}

static void map(const struct rig *rig, unsigned servo, unsigned interpolator, unsigned axis)
{
    SET(rig, servo, { "Cnc.IntNumber", interpolator }, { "Cnc.AxisIndex", axis },
        { "Mode", INTERPOLATOR });
}

/* --- registers --- */

static void registers_after_the_run_sequence(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        const struct host_config config = { .product = product_of(p),
                                            .plant = &nothing,
                                            .servos = virtuals,
                                            .interpolators = 2,
                                            .interpolator_items = { 1, 1000000 } };
        struct rig *rig = rig_open("idle", &config);

        assert_true(rig_get(rig, "MAIN.Number_Interpolators") == 2);
        assert_true(rig_get(rig, "INTERPOLATOR[1].Number") == 1);
        assert_true(of(rig, "Number_Axes") == 10 && of(rig, "Ratio[9]") == 1);
        assert_true(of(rig, "Buffer_Size") == (p == 0 ? 1000 : 500)); /* M11 */
        assert_true(rig_get(rig, "INTERPOLATOR[1].Buffer_Size") == (p == 0 ? 100000 : 50000));
        assert_true(of(rig, "Rel_Speed") == 1 && of(rig, "Status") == 0);
        rig_start(rig);
        rig_cycles(rig, 2);
        assert_true(of(rig, "Status") == 0 && of(rig, "Run_Flag") == 0x10000);
        assert_true(rig_get(rig, "INTERPOLATOR[2].Rel_Speed") == 0); /* there is none */
        rig_close(rig);
    }
}

static void no_signal(void *argument, const struct interp_part *part)
{
    (void)argument;
    (void)part;
}

static const char track[] = "line X 20 F 6000\n"
                            "tool 4\ncorrection right\n"
                            "arc XY centre 20 10 to 30 10 ccw\n"
                            "line Y 5 Z -7 F 3000\n"
                            "rapid X 0 Y 0 Z 0\n";

/* Every step of the interpolator is a slot. */
static void a_path_runs_as_it_is_calculated(void **state)
{
    static const struct {
        uint32_t cycle_us, slot_us;
    } cycles[] = { { 250, 50 }, { 500, 100 }, { 1000, 100 } };

    (void)state;
    EACH_LAYOUT(p)
    for (size_t c = 0; c < COUNT(cycles); c++) {
        struct rig *rig = open_virtuals(p, cycles[c].cycle_us);
        struct interp_path path = path_of(track);
        struct interp_run run;
        const struct interp_inputs inputs = { .step = cycles[c].slot_us * 1e-6,
                                              .override = 1,
                                              .acceleration = INFINITY };
        double position[3] = { 0 }, last = 0;

        assert_true(rig_get(rig, "MAIN.Interpolator_SetCycleTime") == cycles[c].slot_us);
        put(rig, "Ratio[0]", 1000);
        put(rig, "Ratio[1]", -250);
        load(rig, track);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == 4 && of(rig, "Act_Speed") == 0);
        host_interpolator_start(rig->host, 0);
        interp_run_init(&run, &path, no_signal, NULL);
        interp_run_load(&run);
        interp_run_start(&run);
        while (run.state != INTERP_ENDED) {
            rig_cycles(rig, 1);
            for (uint32_t t = 0; t < cycles[c].cycle_us; t += cycles[c].slot_us) {
                last = run.position[0];
                interp_run_step(&run, &inputs);
            }
            for (unsigned i = 0; i < 3; i++) {
                static const char *const names[] = { "Position[0]", "Position[1]", "Position[2]" };
                position[i] = of(rig, names[i]);
                assert_true(position[i] == run.position[i]);
            }
            assert_true(of(rig, "Orig_Position[0]") == run.position[0]);
            assert_true(of(rig, "PositionInc[0]") == run.position[0] * 1000);
            assert_true(of(rig, "PositionInc[1]") == run.position[1] * -250);
            assert_true(of(rig, "Speed[0]") ==
                        (run.position[0] - last) / (cycles[c].slot_us * 1e-6));
            assert_true(of(rig, "Act_Speed") == run.speed * 60);
            assert_true(of(rig, "Move_Distance") == run.passed + run.way);
            assert_true(phase(rig) == (int)run.phase);
            if (run.state != INTERP_RUNNING)
                continue;
            assert_true(of(rig, "Status") == 1 && doing(rig) == 1);
            assert_true(of(rig, "Act_Part") == (double)run.part);
            assert_true(of(rig, "Act_GFunc") == (double)parts[run.part].kind);
            assert_true(of(rig, "editorLine") == parts[run.part].line);
            assert_true(of(rig, "Tool_Number") == (run.part > 0 ? 4 : 0));
            assert_true(of(rig, "correction") == (run.part > 0 ? 42 : 0));
            if (run.part < 3)
                assert_near(of(rig, "Set_Speed"), run.part < 2 ? 6000 : 3000);
            if (p == 1)
                assert_true(of(rig, "Run_State") == phase(rig));
        }
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == 3 && of(rig, "Run_Flag") == 0x10000);
        assert_false(host_interpolator_start(rig->host, 0));
        rig_close(rig);
    }
}

/* Without slots of their own they are calculated once a Cycle_Time. */
static void on_a_controller_a_step_is_a_cycle(void **state)
{
    const struct host_config config = { .product = product_find("tgmcontroller"),
                                        .cycle_us = 500,
                                        .plant = &nothing,
                                        .servos = virtuals,
                                        .servo_count = SERVOS };
    struct rig *rig = rig_open("idle", &config);
    struct interp_path path = path_of(track);
    struct interp_run run;
    const struct interp_inputs inputs = { .step = 500e-6, .override = 1, .acceleration = INFINITY };

    (void)state;
    rig_start(rig);
    map(rig, 0, 0, 0);
    rig_cycles(rig, 2);
    assert_true(rig_get(rig, "MAIN.Interpolator_SetCycleTime") == 500);
    load_and_start(rig, track);
    interp_run_init(&run, &path, no_signal, NULL);
    interp_run_load(&run);
    interp_run_start(&run);
    while (run.state != INTERP_ENDED) {
        rig_cycles(rig, 1);
        interp_run_step(&run, &inputs);
        assert_true(of(rig, "Position[0]") == run.position[0]);
        assert_true(get(rig, 0, "WritePosition") == run.position[0]); /* leaves in this cycle */
    }
    rig_close(rig);
}

static void only_the_cnc_side_starts_it(void **state)
{
    struct rig *rig = open_virtuals(1, 500);
    const struct interp_path good = path_of("line X 1 F 60");
    struct interp_path bad = good;
    char why[HOST_WHY];

    (void)state;
    assert_false(host_interpolator_start(rig->host, 0));
    assert_int_equal(host_interpolator_load(rig->host, 3, &good, false, why), -22);
    assert_int_equal(host_interpolator_load(rig->host, 0, &good, true, why), -22); /* no more */
    bad.limits.deceleration = 0;
    assert_int_equal(host_interpolator_load(rig->host, 0, &bad, false, why), -22);
    load_and_start(rig, "line X 1 F 60");
    assert_int_equal(host_interpolator_load(rig->host, 0, &good, false, why), -16);
    rig_cycles(rig, 100);
    host_interpolator_stop(rig->host, 0, false, false);
    until(rig, "Status", 4, 100);
    assert_true(host_interpolator_start(rig->host, 0));
    host_interpolator_stop(rig->host, 0, true, true);
    until(rig, "Status", 7, 100);
    assert_false(host_interpolator_start(rig->host, 0));
    rig_close(rig);
}

static void a_buffer_that_runs_dry_says_so(void **state)
{
    struct rig *rig = open_virtuals(0, 500);
    struct interp_path path = path_of("line X 1 F 6000");
    char why[HOST_WHY];

    (void)state;
    path.more = true;
    assert_int_equal(host_interpolator_load(rig->host, 0, &path, false, why), 0);
    host_interpolator_start(rig->host, 0);
    until(rig, "Status", 8, 1000);
    path = path_of("line X 2 F 6000");
    assert_int_equal(host_interpolator_load(rig->host, 0, &path, true, why), 0);
    host_interpolator_start(rig->host, 0);
    until(rig, "Status", 3, 1000);
    assert_true(of(rig, "Position[0]") == 2 && of(rig, "Move_Distance") == 2);
    rig_close(rig);
}

/* --- M functions --- */

static void motion_waits_until_the_plc_has_zeroed_m_func(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        load_and_start(rig, "line X 1 F 6000\nm 7 S 1500 Z -2\nline X 2\nm 999");
        until(rig, "M_Func", 7, 1000);
        assert_true(of(rig, "Act_MFunc") == 7 && of(rig, "Status") == 1);
        assert_true(of(rig, "M_Function_Parameter[18]") == 1500);
        assert_true(of(rig, "M_Function_Parameter[25]") == -2);
        rig_cycles(rig, 50);
        assert_true(of(rig, "Position[0]") == 1 && doing(rig) == 5 && phase(rig) == 1);
        put(rig, "M_Func", 8); /* it is zero that ends it */
        rig_cycles(rig, 50);
        assert_true(of(rig, "Position[0]") == 1);
        put(rig, "M_Func", 0);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Position[0]") > 1 && of(rig, "Act_MFunc") == 0 && doing(rig) == 1);
        until(rig, "M_Func", 999, 1000);
        assert_true(of(rig, "Position[0]") == 2 && of(rig, "Status") == 1);
        put(rig, "M_Func", 0);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == 3);
        rig_close(rig);
    }
}

static void continuous_m_functions_stop_nothing_and_leave_a_history(void **state)
{
    static const char text[] =
        "m 1001\nline X 1 F 6000\nm 1002\nline X 2\nm 1003\nm 1004\nline X 3\n"
        "m 1005\nline X 4\nm 1006\nline X 5\nm 1007\nline X 6\nm 1008\n"
        "line X 7\nm 1009\nline X 100\n";

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double last = 0;

        load_and_start(rig, text);
        rig_cycles(rig, 1);
        assert_true(of(rig, "M_Func") == 1001 && of(rig, "Position[0]") > 0);
        assert_true(of(rig, "Cont_MFunc_History.lastValidEntry") == 1);
        while (of(rig, "Position[0]") < 8) {
            put(rig, "Cont_MFunc_History.mFuncs[5]", 0); /* a PLC may zero what it has seen */
            rig_cycles(rig, 1);
            assert_true(of(rig, "Position[0]") > last);
            last = of(rig, "Position[0]");
        }
        assert_true(of(rig, "Last_ContMFunc") == 1009 && of(rig, "M_Func") == 1009);
        assert_true(of(rig, "Cont_MFunc_History.lastValidEntry") == 1);
        assert_true(of(rig, "Cont_MFunc_History.mFuncs[1]") == 1009);
        assert_true(of(rig, "Cont_MFunc_History.mFuncs[0]") == 1008);
        assert_true(of(rig, "Cont_MFunc_History.mFuncs[2]") == 1002);
        assert_true(of(rig, "Cont_MFunc_History.mFuncs[5]") == 0);
        assert_true(of(rig, "Act_MFunc") == 0);
        rig_close(rig);
    }
}

/* --- commands --- */

static void commands_set_ratio_and_position(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        assert_true(ORDER(rig, 1024, 2, 10000, 4) == 0);
        assert_true(of(rig, "Ratio[2]") == 2500);
        assert_true(ORDER(rig, 1024, 10, 1, 1) == -1);
        assert_true(ORDER(rig, 1024, -1, 1, 1) == -1);
        assert_true(ORDER(rig, 1024, 2, 1, 0) == -1);
        assert_true(of(rig, "Ratio[2]") == 2500);
        assert_true(ORDER(rig, 77, 0) == -1);
        assert_true(ORDER(rig, 2048, 5, 6, 10000, 0, 0, 0, 0, 0, 0, -3) == 0);
        assert_true(of(rig, "Position[2]") == 4 && of(rig, "PositionInc[2]") == 10000);
        assert_true(of(rig, "Orig_Position[9]") == -3 && of(rig, "Speed[2]") == 0);
        put(rig, "Ratio[1]", 0); /* no place there */
        assert_true(ORDER(rig, 2048, 1, 1, 1) == -1);
        put(rig, "Ratio[1]", 1);
        put(rig, "Number_Axes", 3);
        assert_true(ORDER(rig, 2048, 1, 2, 2500, 9) == 0);
        assert_true(of(rig, "Position[3]") == 0 && of(rig, "Position[9]") == -3);

        /* Off the trajectory: nothing is left of it. */
        load(rig, "line X 10 F 600");
        assert_true(ORDER(rig, 2048, 0, 0, 0) == 0 && of(rig, "Status") == 4);
        assert_true(of(rig, "LookAheadBuffer[0].buf.movementType") == 1);
        assert_true(ORDER(rig, 2049, 7, 0, 0) == 0 && of(rig, "Status") == 0);
        assert_true(of(rig, "LookAheadBuffer[0].buf.movementType") == 0);
        assert_true(of(rig, "Position[0]") == 7);
        assert_false(host_interpolator_start(rig->host, 0));
        if (p == 1) {
            put(rig, "Command_Parameter_Double[0]", 0.5);
            assert_true(ORDER(rig, 2050, 0) == 0 && of(rig, "Position[0]") == 0.5);
            put(rig, "Command_Parameter_Double[0]", NAN);
            assert_true(ORDER(rig, 2051, 0) == -1 && of(rig, "Position[0]") == 0.5);
        } else {
            assert_true(ORDER(rig, 2050, 0) == -1);
        }

        /* On the trajectory: back to it, and along it. */
        load_and_start(rig, "line X 100 F 6000");
        rig_cycles(rig, 200);
        assert_true(ORDER(rig, 2048, 0) == -1); /* not while it moves */
        assert_true(ORDER(rig, 8, 0) == 0);
        assert_true(ORDER(rig, 2048, 0, 8) == 0);
        host_interpolator_start(rig->host, 0);
        rig_cycles(rig, 1);
        assert_true(of(rig, "fileIdx") == -1);
        until(rig, "Status", 3, 10000);
        assert_true(of(rig, "Position[0]") == 100 && of(rig, "Position[1]") == 0);
        rig_close(rig);
    }
}

static void stops_keep_or_drop_the_trajectory(void **state)
{
    static const struct {
        int command, ramp, while_moving, status;
        bool keeps;
    } stops[] = {
        { 4, 5000, 6, 7, true },
        { 5, 5000, 6, 7, false },
        { 8, 1000, 1, 4, true },
        { 9, 1000, 1, 0, false },
    };

    (void)state;
    EACH_LAYOUT(p)
    for (size_t s = 0; s < COUNT(stops); s++) {
        struct rig *rig = open_virtuals(p, 500);
        double begin;

        load_and_start(rig, "line X 100 F 6000");
        rig_cycles(rig, 400);
        assert_near(of(rig, "Act_Speed"), 6000);
        begin = of(rig, "Position[0]");
        put(rig, "Command", stops[s].command);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == stops[s].while_moving);
        assert_true(of(rig, "Command_Status") == 1);
        assert_true(of(rig, "Command") == (p != 1                 ? stops[s].command
                                           : stops[s].command < 8 ? -4
                                                                  : -8));
        assert_true(phase(rig) == (stops[s].ramp == 5000 ? 7 : 6));
        assert_near(of(rig, "Act_Speed") / 60, 100 - stops[s].ramp * 5e-4L);
        until(rig, "Command", 0, 1000);
        assert_true(of(rig, "Command_Status") == 0 && of(rig, "Status") == stops[s].status);
        assert_near(of(rig, "Position[0]"), begin + 100 * 100 / (2.0L * stops[s].ramp));
        assert_true(host_interpolator_start(rig->host, 0) == stops[s].keeps);
        if (stops[s].keeps) {
            until(rig, "Status", 3, 10000);
            assert_true(of(rig, "Position[0]") == 100);
        }
        rig_close(rig);
    }
}

static void an_emergency_stop_overtakes_a_normal_one(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        load_and_start(rig, "line X 100 F 6000");
        rig_cycles(rig, 400);
        put(rig, "Command", 8);
        rig_cycles(rig, 20);
        put(rig, "Command", 4);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == 6);
        until(rig, "Command", 0, 100);
        assert_true(of(rig, "Status") == 7);
        rig_close(rig);
    }
}

static void rel_speed_is_limited_and_must_be_a_number(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        static const double wanted[] = { 0.5, NAN, 1e300, 0, 1 },
                            speeds[] = { 50, 50, 200, 1, 100 };
        struct rig *rig = open_virtuals(p, 500);

        load_and_start(rig, "line X 1000 F 6000");
        for (size_t i = 0; i < COUNT(wanted); i++) {
            put(rig, "Rel_Speed", wanted[i]);
            rig_cycles(rig, 500);
            assert_near(of(rig, "Act_Speed") / 60, speeds[i]);
            assert_near(of(rig, "Set_Speed"), 6000);
            if (p == 1)
                assert_near(of(rig, "Act_Rel_Speed"), speeds[i] / 100);
        }
        rig_close(rig);
    }
}

/* --- filters --- */

static void the_spline_delays_positions_and_m_functions(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        unsigned arrived = 0, cycle = 0;

        assert_true(ORDER(rig, -2, 49, 1000000) == -1);
        assert_true(ORDER(rig, -2, 501, 1000000) == -1);
        assert_true(ORDER(rig, -2, 200, -1) == -1);
        assert_true(ORDER(rig, -2, 200, 1000000) == 0);
        load_and_start(rig, "line X 1 F 6000\nm 3\n");
        for (; of(rig, "M_Func") == 0; cycle++) {
            rig_cycles(rig, 1);
            if (of(rig, "Orig_Position[0]") == 1 && arrived == 0)
                arrived = cycle;
        }
        assert_int_equal(cycle - 1 - arrived, 40); /* 200 points of 100 us */
        assert_true(of(rig, "Position[0]") == 1);
        put(rig, "M_Func", 0);
        rig_cycles(rig, 1);

        /* What stops nothing is signalled as late. */
        load_and_start(rig, "line X 2 F 600\nm 1005\nline X 3");
        arrived = 0;
        for (cycle = 0; of(rig, "Last_ContMFunc") == 0; cycle++) {
            rig_cycles(rig, 1);
            if (of(rig, "Orig_Position[0]") >= 2 && arrived == 0)
                arrived = cycle;
        }
        assert_int_equal(cycle - 1 - arrived, 40);
        until(rig, "Status", 3, 10000);
        rig_cycles(rig, 40);

        /* The jerk limit makes ramps that the average smooths down to it: 1e4 mm/s3 * 20 ms. */
        assert_true(ORDER(rig, -2, 200, 10000) == 0);
        load_and_start(rig, "line X 30 F 6000");
        rig_cycles(rig, 100);
        assert_near(of(rig, "Act_Speed") / 60, 10000 * 200e-4L * 0.05L);
        until(rig, "Status", 3, 10000);
        rig_cycles(rig, 100);
        assert_true(of(rig, "Position[0]") == 30);

        /* A command waits for what is still under way behind the filters. */
        load_and_start(rig, "line X 31 F 6000");
        rig_cycles(rig, 1);
        until(rig, "Status", 3, 10000);
        put(rig, "Command_Parametr[0]", 0);
        put(rig, "Command", -2);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Command_Status") == 1 && of(rig, "Command") == -2);
        until(rig, "Command", 0, 100);
        assert_true(of(rig, "Command_Status") == 0);
        load_and_start(rig, "line X 32 F 6000");
        rig_cycles(rig, 20);
        assert_true(of(rig, "Position[0]") == of(rig, "Orig_Position[0]"));
        rig_close(rig);
    }
}

static void the_low_pass_acts_on_the_axes_of_its_mask(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        struct interp_iir iir = { 0 };
        const double zero[INTERP_AXES] = { 0 };
        struct interp_path path = path_of("line X 10 Y 10 F 6000");
        struct interp_run run;
        const struct interp_inputs inputs = { .step = 1e-4,
                                              .override = 1,
                                              .acceleration = INFINITY };

        assert_true(ORDER(rig, -1, 0, 1000000, 1000000, 1) == -1);
        assert_true(ORDER(rig, -1, 2000000, 1000000, 10000, 1) == 0);
        assert_true(interp_iir_set(&iir, 2, 1, 0.01, 1, 1e-4, zero));
        interp_run_init(&run, &path, no_signal, NULL);
        interp_run_load(&run);
        interp_run_start(&run);
        load_and_start(rig, "line X 10 Y 10 F 6000");
        for (unsigned cycle = 0; cycle < 1500; cycle++) {
            double position[INTERP_AXES];

            rig_cycles(rig, 1);
            for (unsigned i = 0; i < 5; i++) {
                interp_run_step(&run, &inputs);
                memcpy(position, run.position, sizeof position);
                interp_iir_step(&iir, position);
            }
            assert_near(of(rig, "Position[0]"), position[0]);
            assert_true(of(rig, "Position[1]") == of(rig, "Orig_Position[1]"));
        }
        assert_true(of(rig, "Position[0]") == 10);
        assert_true(ORDER(rig, -1, 0, 0, 0, 0) == 0); /* off */
        rig_close(rig);
    }
}

/* --- look-ahead --- */

static double ahead(const struct rig *rig, unsigned entry, const char *member)
{
    char name[80];

    snprintf(name, sizeof name, "LookAheadBuffer[%u].buf.%s", entry, member);
    return of(rig, name);
}

static void look_ahead_shifts_in_generation_4_and_is_a_ring_in_5(void **state)
{
    static const char text[] =
        "line X 1 F 600\ntool 2\nm 5 S 3\ntool 0\nline X 2\nline X 3\nline X 4\n"
        "arc XZ centre 4 5 to 9 5 cw\nline X 9 Z 6\nline X 9 Z 7\nline X 9 Z 8\n"
        "line X 9 Z 9\n";

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        unsigned first;

        rig_cycles(rig, 1);
        assert_true(ahead(rig, 0, "movementType") == 0);
        load(rig, text);
        rig_cycles(rig, 1);
        assert_true(of(rig, "LookAheadBufferValidStart") == 0);
        assert_true(of(rig, "LookAheadBufferValidEnd") == 7);
        assert_true(ahead(rig, 0, "movementType") == 1 && ahead(rig, 0, "movementCode") == 1);
        assert_true(ahead(rig, 0, "endPos[0]") == 1 && ahead(rig, 0, "partLength") == 1);
        assert_true(ahead(rig, 0, "tangens") == 0 && ahead(rig, 0, "startAngle") > 1e38);
        assert_true(ahead(rig, 0, "allParams[5]") == 600 && ahead(rig, 0, "radius") == 0);
        assert_true(ahead(rig, 1, "movementType") == 2 && ahead(rig, 1, "movementCode") == 5);
        assert_true(ahead(rig, 1, "tangens") > 1e38 && ahead(rig, 1, "allParams[18]") == 3);
        assert_true(ahead(rig, 1, "tool") == 2 && ahead(rig, 2, "tool") == 0);
        assert_true(ahead(rig, 5, "movementCode") == 2 && ahead(rig, 5, "plane") == 18);
        assert_near(ahead(rig, 5, "startAngle"), 270);
        assert_near(ahead(rig, 5, "endAngle") + 360, 360);
        assert_near(ahead(rig, 5, "radius"), 5);
        assert_near(ahead(rig, 5, "partLength"), 15 * 3.14159265358979323846L / 2);
        assert_near(ahead(rig, 5, "tangens"), 3.14159265358979323846L);
        host_interpolator_start(rig->host, 0);
        until(rig, "M_Func", 5, 10000);
        put(rig, "M_Func", 0);
        until(rig, "Act_Part", 3, 10000);
        first = p == 0 ? 0 : 3;
        assert_true(of(rig, "LookAheadBufferValidStart") == first);
        assert_true(of(rig, "LookAheadBufferValidEnd") == (first + 6) % 8); /* part 9 is the last */
        assert_true(ahead(rig, first, "endPos[0]") == 3);
        assert_true(ahead(rig, (first + 2) % 8, "movementCode") == 2);
        assert_true(ahead(rig, (first + 7) % 8, "movementType") == 0);
        assert_true(ORDER(rig, 9, 0) == 0);
        assert_true(ahead(rig, first, "movementType") == 0); /* dropped */
        rig_close(rig);
    }
}

static void a_wait_reads_the_external_position(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        put(rig, "Adrress_External_Position", 24);
        load_and_start(rig, "wait external 1000\nline X 1 F 600");
        rig_cycles(rig, 20);
        assert_true(doing(rig) == 3 && of(rig, "Status") == 1);
        rig_set(rig, "DATA.I32[24]", 999);
        rig_cycles(rig, 20);
        assert_true(of(rig, "Position[0]") == 0);
        put(rig, "Adrress_External_Position", 4294967295.0); /* lies nowhere: 0 */
        rig_set(rig, "DATA.I32[24]", 1000);
        rig_cycles(rig, 1);
        assert_true(doing(rig) == 3);
        put(rig, "Adrress_External_Position", 24);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Position[0]") > 0 && doing(rig) == 1);
        rig_close(rig);
    }
}

/* --- the way to a servo --- */

/* Set-points are taken in slot 1: what was calculated in slot 0 of the same cycle. */
static void a_servo_follows_the_axis_it_is_mapped_to(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double x = 0;

        put(rig, "Ratio[0]", 2000);
        put(rig, "Ratio[1]", 10);
        map(rig, 0, 0, 0);
        map(rig, 1, 0, 1);
        map(rig, 2, 7, 0);  /* no such interpolator */
        map(rig, 3, 0, 10); /* no such axis */
        SET(rig, 2, { "WritePosition", 77 });
        SET(rig, 3, { "WritePosition", 78 });
        put(rig, "Offset[1]", 1000);
        rig_cycles(rig, 3); /* enabled */
        load_and_start(rig, "line X 10 Y 20 F 6000");
        for (unsigned cycle = 0; cycle < 2000; cycle++) {
            const double last = of(rig, "Position[0]"), sent = x;

            rig_cycles(rig, 1);
            assert_true(get(rig, 0, "Position") == sent); /* it left in the last cycle */
            x = get(rig, 0, "WritePosition");
            assert_true(x >= last * 2000 && x <= of(rig, "PositionInc[0]"));
            assert_near(get(rig, 1, "WritePosition"), x / 100 + 1000);
        }
        assert_true(x == 20000 && get(rig, 0, "Position") == 20000);
        assert_true(get(rig, 1, "Position") == 1200);
        assert_true(get(rig, 2, "WritePosition") == 77 && get(rig, 3, "WritePosition") == 78);
        put(rig, "Number_Axes", 4e9); /* whatever it says, there are ten */
        rig_cycles(rig, 3);
        assert_true(get(rig, 3, "WritePosition") == 78);
        put(rig, "Number_Axes", 1); /* Y is no axis any more */
        put(rig, "Offset[1]", 0);
        rig_cycles(rig, 3);
        assert_true(get(rig, 1, "Position") == 1200);
        put(rig, "Offset[0]", NAN);
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "Position") == 20000);
        rig_close(rig);
    }
}

static void a_simulated_drive_follows(void **state)
{
    (void)state;
    for (size_t p = 0; p < 2; p++) {
        const struct host_config config = { .product = product_of(p) };
        struct rig *rig = rig_open("idle", &config);
        double start;

        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_cycles(rig, 10);
        start = get(rig, 0, "Position");
        put(rig, "Ratio[2]", 100000);
        assert_true(ORDER(rig, 2048, 0, 0, start) == 0);
        map(rig, 0, 0, 2);
        rig_until(rig, "SERVO[0].Status", 3, 100);
        rig_cycles(rig, 100);
        assert_true(fabs(get(rig, 0, "Position") - start) < 2);
        load_and_start(rig, "line Z 30 F 1200");
        until(rig, "Status", 3, 10000);
        rig_cycles(rig, 200);
        assert_true(fabs(get(rig, 0, "Position") - 3e6) < 50);
        rig_close(rig);
    }
}

static void program_05_modifies_what_reaches_the_servo(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        const struct host_config config = {
            .product = product_of(p), .plant = &nothing, .servos = virtuals, .servo_count = SERVOS
        };
        struct rig *rig = rig_open("correct", &config);
        struct interp_path path = path_of("line Y 10 F 6000");
        struct interp_run run;
        const struct interp_inputs inputs = { .step = 1e-4,
                                              .override = 1,
                                              .acceleration = INFINITY };

        rig_start(rig);
        rig_set(rig, "DATA.F64[0]", 0.25);
        rig_set(rig, "DATA.F64[8]", 300);
        map(rig, 0, 0, 0);
        map(rig, 1, 0, 1);
        rig_cycles(rig, 2);
        interp_run_init(&run, &path, no_signal, NULL);
        interp_run_load(&run);
        interp_run_start(&run);
        load_and_start(rig, "line Y 10 F 6000");
        while (run.state != INTERP_ENDED) {
            rig_cycles(rig, 1);
            interp_run_step(&run, &inputs); /* slot 0, whose Program_05 is before the send */
            assert_near(get(rig, 0, "WritePosition"), 0.25L * run.position[1]);
            assert_near(get(rig, 1, "WritePosition"), 300 + (long double)run.position[1]);
            for (unsigned i = 1; i < 5; i++)
                interp_run_step(&run, &inputs);
        }
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "Position") == 2.5 && get(rig, 1, "Position") == 310);
        rig_close(rig);
    }
}

static void backlash_is_made_up_for_after_a_turn(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        map(rig, 0, 0, 0);
        load_and_start(rig, "backlash 2 X 25\nline X 10 F 6000\nline X 5");
        until(rig, "Act_Part", 1, 1000);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Backlash[0]") <= -2 && of(rig, "Backlash[0]") > -25);
        until(rig, "Status", 3, 10000);
        rig_cycles(rig, 20);
        assert_true(of(rig, "Backlash[0]") == -25 && of(rig, "PositionInc[0]") == 5);
        assert_true(get(rig, 0, "Position") == -20);
        rig_close(rig);
    }
}

static void a_configured_path_starts_at_its_time(void **state)
{
    const struct interp_path path = path_of("line X 10 F 6000");

    (void)state;
    EACH_LAYOUT(p)
    {
        const struct host_config config = { .product = product_of(p),
                                            .plant = &nothing,
                                            .servos = virtuals,
                                            .path = &path,
                                            .path_start_ns = 100000000 };
        struct rig *rig = rig_open("idle", &config);

        rig_start(rig);
        rig_cycles(rig, 10);
        assert_true(of(rig, "Status") == 4);
        assert_true(ORDER(rig, 2049, 5) == 0 && of(rig, "Status") == 0);
        assert_int_equal(host_cycles(rig->host), 11);
        rig_cycles(rig, 189);
        assert_true(of(rig, "Status") == 0);
        rig_cycles(rig, 1);
        assert_true(of(rig, "Status") == 1 && of(rig, "Position[0]") < 5);
        until(rig, "Status", 3, 10000);
        assert_true(of(rig, "Position[0]") == 10);
        rig_close(rig);
    }
}

/* --- anything in the registers --- */

static uint32_t seed = 1;

static uint32_t dice(void)
{
    seed = seed * 1664525 + 1013904223;
    return seed >> 8;
}

static void anything_in_the_registers_does_no_harm(void **state)
{
    static const int commands[] = { 1024, 2048, 2049, 2050, 2051, 4, 5, 8, 9, -1, -2, -4, -8, 0 };
    static const double odd[] = { NAN, INFINITY, -INFINITY, 1e308, -1e308, 0, 1e-308, 1, -1 };

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 250);
        const unsigned before = allocations;

        for (unsigned servo = 0; servo < SERVOS; servo++)
            map(rig, servo, 0, servo);
        for (unsigned turn = 0; turn < 3000; turn++) {
            struct catalogue_register reg;
            uint8_t *at = rig_at(rig, "INTERPOLATOR[0].Number", &reg);
            const uint32_t where = dice() % (turn % 3 == 0 ? 2048 : 16384);

            if (dice() % 4 == 0)
                at[where] = (uint8_t)dice();
            else if (dice() % 2 == 0)
                memcpy(at + where / 8 * 8, &odd[dice() % COUNT(odd)], 8);
            if (dice() % 5 == 0)
                put(rig, "Command", commands[dice() % COUNT(commands)]);
            if (dice() % 7 == 0)
                put(rig, "M_Func", 0);
            if (dice() % 40 == 0) {
                const struct interp_path path = path_of(track);
                char why[HOST_WHY];

                host_interpolator_load(rig->host, 0, &path, false, why);
            }
            if (dice() % 10 == 0)
                host_interpolator_start(rig->host, 0);
            set(rig, dice() % SERVOS, dice() % 2 == 0 ? "Cnc.IntNumber" : "Cnc.AxisIndex",
                dice() % 3 == 0 ? 4294967295.0 : dice() % 4);
            rig_cycles(rig, 1);
            for (unsigned servo = 0; servo < SERVOS; servo++)
                assert_true(isfinite(get(rig, servo, "Position")));
        }
        assert_int_equal(allocations, before);
        rig_close(rig);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(registers_after_the_run_sequence),
        cmocka_unit_test(a_path_runs_as_it_is_calculated),
        cmocka_unit_test(on_a_controller_a_step_is_a_cycle),
        cmocka_unit_test(only_the_cnc_side_starts_it),
        cmocka_unit_test(a_buffer_that_runs_dry_says_so),
        cmocka_unit_test(motion_waits_until_the_plc_has_zeroed_m_func),
        cmocka_unit_test(continuous_m_functions_stop_nothing_and_leave_a_history),
        cmocka_unit_test(commands_set_ratio_and_position),
        cmocka_unit_test(stops_keep_or_drop_the_trajectory),
        cmocka_unit_test(an_emergency_stop_overtakes_a_normal_one),
        cmocka_unit_test(rel_speed_is_limited_and_must_be_a_number),
        cmocka_unit_test(the_spline_delays_positions_and_m_functions),
        cmocka_unit_test(the_low_pass_acts_on_the_axes_of_its_mask),
        cmocka_unit_test(look_ahead_shifts_in_generation_4_and_is_a_ring_in_5),
        cmocka_unit_test(a_wait_reads_the_external_position),
        cmocka_unit_test(a_servo_follows_the_axis_it_is_mapped_to),
        cmocka_unit_test(a_simulated_drive_follows),
        cmocka_unit_test(program_05_modifies_what_reaches_the_servo),
        cmocka_unit_test(backlash_is_made_up_for_after_a_turn),
        cmocka_unit_test(a_configured_path_starts_at_its_time),
        cmocka_unit_test(anything_in_the_registers_does_no_harm),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
