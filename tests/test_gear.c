/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Linear gear and cam, in the registers of every layout, against closed forms. */
#include "tests/motion_rig.h"

/* --- linear gear --- */

static void a_gear_follows_its_master_in_the_same_cycle(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        link_servos(rig, 0, 1, 3, 7); /* the slaves come before their masters */
        link_servos(rig, 1, 2, -5, 2);
        profile_of(rig, 2, 1e5, 1e6);
        set(rig, 2, "Mode", PG);
        rig_cycles(rig, 2);
        set(rig, 2, "Pg.DPos", 12345);
        for (unsigned i = 0; i < 500; i++) {
            long double master;

            rig_cycles(rig, 1);
            master = get(rig, 2, "WritePosition");
            assert_near(get(rig, 1, "Gear.Position"), master * -5 / 2);
            assert_near(get(rig, 1, "WritePosition"), master * -5 / 2);
            assert_near(get(rig, 0, "WritePosition"), master * -15 / 14);
        }
        assert_true(get(rig, 2, "WritePosition") == 12345);
        rig_close(rig);
    }
}

static void the_ratio_is_ramped_by_inc_in(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        long double sum = 50, in = 0, master;

        SET(rig, 0, { "Mode", POSITION }, { "WritePosition", 60 });
        SET(rig, 1, { "Mode", POSITION });
        rig_cycles(rig, 2);
        SET(rig, 0, { "Gear.Offset", 10 }, { "Gear.IncIn", 0.3 });
        link_servos(rig, 0, 1, 100, 9);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "WritePosition") == 60); /* from where it was */
        in = 0.3L;
        for (unsigned i = 1; i < 1100; i++) {
            if (i == 600)
                set(rig, 0, "Gear.In", -20);
            set(rig, 1, "WritePosition", 2.5 * i);
            rig_cycles(rig, 1);
            master = i < 600 ? 100 : -20;
            in = fabsl(master - in) <= 0.3L ? master : in + (master > in ? 0.3L : -0.3L);
            sum += 2.5L * in / 9;
            assert_near(get(rig, 0, "Gear.Position"), sum);
            assert_near(get(rig, 0, "WritePosition"), sum + 10);
            assert_true(fabs(get(rig, 0, "Gear.ActualIn") - (double)in) <= 0.5 + 1e-9);
        }
        assert_true(get(rig, 0, "Gear.ActualIn") == -20);
        rig_close(rig);
    }
}

static void every_source_moves_the_gear(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double here, tick;

        SET(rig, 1, { "Mode", POSITION });
        rig_cycles(rig, 2);
        link_servos(rig, 0, 1, 2, 1);
        rig_cycles(rig, 2);
        set(rig, 1, "WritePosition", 100);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "WritePosition") == 200);

        set(rig, 0, "Gear.SourcePosition", ACTUAL_POSITION); /* 0 now, 100 in the next cycle */
        rig_cycles(rig, 3);
        set(rig, 1, "WritePosition", 400);
        rig_cycles(rig, 1);
        here = get(rig, 0, "WritePosition");
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "WritePosition") == here + 600);

        set(rig, 0, "Gear.SourcePosition", EXT_POSITION);
        rig_cycles(rig, 1);
        set(rig, 1, "ExtPosition", -50);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "WritePosition") == here + 500);

        set(rig, 0, "Gear.SourcePosition", TICK);
        rig_cycles(rig, 1);
        rig_set(rig, "MAIN.Servo_Tick", 4294967290.0);
        rig_cycles(rig, 1);
        here = get(rig, 0, "WritePosition");
        rig_cycles(rig, 10); /* wraps */
        assert_true(rig_get(rig, "MAIN.Servo_Tick") < 100);
        assert_true(get(rig, 0, "WritePosition") == here + 20);
        tick = get(rig, 0, "WritePosition");
        set(rig, 0, "Gear.SourcePosition", 5); /* no such */
        rig_cycles(rig, 10);
        assert_true(get(rig, 0, "WritePosition") == tick);
        rig_close(rig);
    }
}

static void a_gear_without_a_master_holds(void **state)
{
    static const double numbers[] = { SERVOS, 255, 256, 100000, 2147483647.0, -1, -2147483648.0 };

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        SET(rig, 1, { "Mode", POSITION });
        rig_cycles(rig, 2);
        link_servos(rig, 0, 1, 1, 1);
        rig_cycles(rig, 2);
        set(rig, 1, "WritePosition", 77);
        rig_cycles(rig, 1);
        for (size_t i = 0; i < COUNT(numbers); i++)
            for (int source = 0; source < 6; source++) {
                if (source == TICK)
                    continue;
                SET(rig, 0, { "Gear.SourceNumber", numbers[i] }, { "Gear.SourcePosition", source });
                rig_cycles(rig, 2);
                assert_true(get(rig, 0, "WritePosition") == 77);
            }
        link_servos(rig, 0, 1, 1, 0);
        set(rig, 1, "WritePosition", 100);
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "WritePosition") == 77);
        set(rig, 0, "Gear.Out", 1);
        set(rig, 1, "WritePosition", NAN);
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "WritePosition") == 77);
        set(rig, 1, "WritePosition", 1e308);
        rig_cycles(rig, 2);
        set(rig, 1, "WritePosition", -1e308);
        rig_cycles(rig, 2);
        assert_true(isfinite(get(rig, 0, "WritePosition")));
        rig_close(rig);
    }
}

/* The first of them sees the last one as of the cycle before. */
static void masters_in_a_circle_do_not_hang(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        link_servos(rig, 0, 1, 1, 1);
        link_servos(rig, 1, 2, 1, 1);
        link_servos(rig, 2, 0, 1, 1);
        link_servos(rig, 3, 3, 1, 1);
        rig_cycles(rig, 100);
        for (unsigned i = 0; i < SERVOS; i++)
            assert_true(get(rig, i, "WritePosition") == 0);
        rig_close(rig);
    }
}

static void pg_and_gear_add_up(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double before;

        SET(rig, 0, { "Mode", POSITION }, { "WritePosition", 1000 });
        SET(rig, 1, { "Mode", POSITION }, { "WritePosition", 5555 });
        rig_cycles(rig, 2);
        profile_of(rig, 0, 1e4, 1e6);
        SET(rig, 0, { "Pg.DPos", 1000 }, { "Gear.Offset", 3 });
        link_servos(rig, 0, 1, 1, 2);
        set(rig, 0, "Mode", PG_GEAR);
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "WritePosition") == 1000);
        set(rig, 0, "Pg.DPos", 4000);
        for (unsigned i = 0; i < 1000; i++) {
            set(rig, 1, "WritePosition", 5555 + i);
            rig_cycles(rig, 1);
            assert_near(get(rig, 0, "WritePosition"), get(rig, 0, "Pg.APos") + i / 2.0L);
        }
        assert_true(get(rig, 0, "Pg.APos") == 4000);
        before = get(rig, 0, "WritePosition");
        set(rig, 0, "Gear.Mode", 0);
        rig_cycles(rig, 5);
        assert_true(get(rig, 0, "WritePosition") == before);
        set(rig, 0, "Mode", GEAR);
        rig_cycles(rig, 5);
        assert_true(get(rig, 0, "WritePosition") == before);
        SET(rig, 0, { "Mode", PG }, { "Pg.DPos", before });
        rig_cycles(rig, 5);
        assert_true(get(rig, 0, "WritePosition") == before);
        rig_close(rig);
    }
}

/* --- cam --- */

static double stroke(unsigned index)
{
    return 1000 * sin(6.283185307179586 * index / POINTS);
}

static double feed(unsigned index)
{
    return 10.0 * index + 3 * sin(6.283185307179586 * index / POINTS);
}

/* Value of a table at a pointer that goes on over turns, each of them `increment` higher. */
static long double interpolated(double (*value)(unsigned index), long double pointer,
                                long double increment)
{
    const long double turn = floorl(pointer / POINTS), place = pointer - turn * POINTS;
    const unsigned left = (unsigned)place;
    const long double right =
        left + 1 == POINTS ? value(0) + increment : (long double)value(left + 1);

    return value(left) * (1 - (place - left)) + right * (place - left) + turn * increment;
}

static void cam_of(const struct rig *rig, unsigned servo, unsigned tab, unsigned line)
{
    SET(rig, servo, { "Gear.SourceNumber", 1 }, { "Gear.SourcePosition", WRITE_POSITION },
        { "Gear.In", 3 }, { "Gear.Out", 1000 }, { "Gear.CamTab", tab }, { "Gear.CamLine", line },
        { "Gear.CamLen", POINTS }, { "Gear.CamScale", 1 }, { "Gear.Mode", CAM }, { "Mode", GEAR });
    set(rig, 1, "Mode", POSITION);
}

static void a_returning_cam_repeats_its_table(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        for (unsigned tab = 0; tab < 2; tab++) {
            struct rig *rig = open_virtuals(p, 500);

            set_table(rig, tab == 0 ? "CAM" : "DATA", 4096, POINTS, stroke);
            cam_of(rig, 0, tab, 4096);
            SET(rig, 0, { "Gear.CamScale", -2.5 }, { "Gear.Offset", 5000 });
            rig_cycles(rig, 2);
            for (int i = -300; i < 300; i++) {
                const double master = 173.0 * i;
                const long double pointer = master * 3.0L / 1000;
                const long double value = 5000 - 2.5L * interpolated(stroke, pointer, 0);

                set(rig, 1, "WritePosition", master);
                rig_cycles(rig, 1);
                assert_near(get(rig, 0, "Gear.CamPosition"), value);
                assert_near(get(rig, 0, "WritePosition"), value);
                assert_true(fabsl(get(rig, 0, "Gear.Position") -
                                  (pointer - floorl(pointer / POINTS) * POINTS)) < 1e-9L);
            }
            rig_close(rig);
        }
    }
}

/* Its way since then, because the generator has brought the servo to where it is. */
static void a_cam_on_a_profile_generator_adds_its_way(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        set_table(rig, "CAM", 0, POINTS, slope);
        cam_of(rig, 0, 0, 0);
        SET(rig, 0, { "Mode", PG_GEAR }, { "Pg.Mode", 0 }, { "Pg.Acc", 1e6 });
        set(rig, 1, "WritePosition", 2000); /* point 6 */
        rig_cycles(rig, 10);
        assert_true(get(rig, 0, "Gear.CamPosition") == 106);
        assert_true(get(rig, 0, "WritePosition") == 0);
        set(rig, 1, "WritePosition", 5000);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Gear.CamPosition") == 115);
        assert_true(get(rig, 0, "WritePosition") == 9);
        rig_close(rig);
    }
}

static void a_forward_cam_goes_on_turn_by_turn(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        set_table(rig, "CAM", 8, POINTS, feed);
        cam_of(rig, 0, 0, 8);
        SET(rig, 0, { "Gear.CamType", 1 }, { "Gear.CamIncPosition", 370 }, { "Gear.CamScale", 2 });
        rig_cycles(rig, 2);
        for (int i = -1000; i < 1000; i++) { /* backwards, too */
            const double master = 173.0 * i;

            set(rig, 1, "WritePosition", master);
            rig_cycles(rig, 1);
            assert_near(get(rig, 0, "WritePosition"),
                        2 * interpolated(feed, master * 3.0L / 1000, 370));
        }
        rig_close(rig);
    }
}

static void the_pointer_is_shifted_in_steps(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        set_table(rig, "CAM", 0, POINTS, slope);
        cam_of(rig, 0, 0, 0);
        SET(rig, 0, { "Gear.IncShift", 0.25 }, { "Gear.Shift", 10.1 });
        for (unsigned i = 1; i < 100; i++) {
            const long double shift = fminl(0.25L * i, 10.1L);

            rig_cycles(rig, 1);
            assert_near(get(rig, 0, "Gear.ActualShift"), shift);
            assert_near(get(rig, 0, "Gear.CamPosition"), 100 + shift);
        }
        SET(rig, 0, { "Gear.IncShift", 0 }, { "Gear.Shift", -1.5 });
        rig_cycles(rig, 1);
        assert_near(get(rig, 0, "Gear.CamPosition"), 100 + POINTS - 1.5L);
        rig_close(rig);
    }
}

static void external_cams_write_into_the_data_memory(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        set_table(rig, "CAM", 0, POINTS, stroke);
        set_table(rig, "CAM", 1000, POINTS, slope);
        set_table(rig, "CAM", 2000, POINTS, feed);
        cam_of(rig, 0, 0, 0);
        SET(rig, 0, { "Gear.CamExpLine1", 1000 }, { "Gear.CamExpLine2", 2000 },
            { "Gear.CamExpAddress1", 800 }, { "Gear.CamExpAddress2", 524280 },
            { "Gear.CamScale", 17 }, { "Gear.Offset", 4 });
        set(rig, 1, "WritePosition", 2100); /* pointer 6.3 */
        rig_cycles(rig, 2);
        assert_true(rig_get(rig, "DATA.F64[800]") == 0);
        set(rig, 0, "Gear.CamExpControl", 1);
        rig_cycles(rig, 1);
        assert_near(rig_get(rig, "DATA.F64[800]"), 106.3L);
        assert_true(rig_get(rig, "DATA.F64[524280]") == 0);
        set(rig, 0, "Gear.CamExpControl", 3);
        rig_cycles(rig, 1);
        assert_near(rig_get(rig, "DATA.F64[524280]"), interpolated(feed, 6.3L, 0));
        SET(rig, 0, { "Gear.CamType", 1 }, { "Gear.CamIncPosition", 5000 }); /* only of the cam */
        set(rig, 1, "WritePosition", 24500);
        rig_cycles(rig, 1);
        assert_near(rig_get(rig, "DATA.F64[800]"), interpolated(slope, 73.5L, 0));
        rig_close(rig);
    }
}

/* Nothing is read or written outside the memories; the servo stays. */
static void a_cam_that_does_not_lie_in_its_memory_holds(void **state)
{
    static const struct setting bad[] = {
        { "Gear.CamLen", 0 },
        { "Gear.CamLen", -1 },
        { "Gear.CamLen", 4294967295 },
        { "Gear.CamLen", 131073 },
        { "Gear.CamLine", 1048576 },
        { "Gear.CamLine", 1048576 - 8 * POINTS + 1 },
        { "Gear.CamLine", -8 },
        { "Gear.CamLine", 2147483640 },
        { "Gear.Out", 0 },
        { "Gear.CamScale", NAN },
        { "Gear.Shift", NAN },
        { "Gear.Shift", 1e300 },
        { "Gear.Offset", INFINITY },
        { "Gear.SourceNumber", 4000 },
    };
    static const double addresses[] = { 524281, 524288, 2147483647, -1, -8 };

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        set_table(rig, "CAM", 0, POINTS, slope);
        cam_of(rig, 0, 0, 0);
        set(rig, 1, "WritePosition", 2000);
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "WritePosition") == 106);
        for (size_t i = 0; i < COUNT(bad); i++) {
            const double good = get(rig, 0, bad[i].member);

            set(rig, 0, bad[i].member, bad[i].value);
            set(rig, 1, "WritePosition", 1000);
            rig_cycles(rig, 2);
            assert_true(get(rig, 0, "WritePosition") == 106);
            assert_true(get(rig, 0, "Gear.CamPosition") == 106);
            set(rig, 0, bad[i].member, good);
            set(rig, 1, "WritePosition", 2000);
            rig_cycles(rig, 1);
            assert_true(get(rig, 0, "WritePosition") == 106);
        }
        rig_set(rig, "CAM.F64[48]", NAN); /* a point */
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "WritePosition") == 106);
        rig_set(rig, "CAM.F64[48]", 106);
        set(rig, 0, "Gear.CamExpControl", 3);
        for (size_t i = 0; i < COUNT(addresses); i++) {
            SET(rig, 0, { "Gear.CamExpAddress1", addresses[i] },
                { "Gear.CamExpLine2", addresses[i] * 2 }, { "Gear.CamExpAddress2", 16 });
            rig_cycles(rig, 1);
            assert_true(rig_get(rig, "DATA.F64[524280]") == 0 && rig_get(rig, "DATA.F64[0]") == 0);
        }
        SET(rig, 0, { "Gear.CamLine", 1048576 - 8 * POINTS }, { "Gear.CamExpControl", 0 });
        rig_cycles(rig, 1); /* the last place there is */
        assert_true(get(rig, 0, "Gear.CamPosition") == 0);
        rig_close(rig);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_gear_follows_its_master_in_the_same_cycle),
        cmocka_unit_test(the_ratio_is_ramped_by_inc_in),
        cmocka_unit_test(every_source_moves_the_gear),
        cmocka_unit_test(a_gear_without_a_master_holds),
        cmocka_unit_test(masters_in_a_circle_do_not_hang),
        cmocka_unit_test(pg_and_gear_add_up),
        cmocka_unit_test(a_returning_cam_repeats_its_table),
        cmocka_unit_test(a_cam_on_a_profile_generator_adds_its_way),
        cmocka_unit_test(a_forward_cam_goes_on_turn_by_turn),
        cmocka_unit_test(the_pointer_is_shifted_in_steps),
        cmocka_unit_test(external_cams_write_into_the_data_memory),
        cmocka_unit_test(a_cam_that_does_not_lie_in_its_memory_holds),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
