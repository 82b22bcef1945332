/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Servos that move by themselves: modes, virtual servos, profile generator, commands, capture,
 * drives. */
#include "tests/motion_rig.h"

#include "host/profile_motion.h"

/* --- virtual servos, modes --- */

static void a_written_position_does_not_move_a_virtual_servo(void **state)
{
    struct rig *rig = open_virtuals(0, 500);
    (void)state;
    rig_cycles(rig, 5);
    rig_set(rig, "SERVO[0].Position", 123456);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "SERVO[0].Position") == 0);
    assert_true(rig_get(rig, "SERVO[0].Speed") == 0);
    rig_close(rig);
}

static void a_virtual_servo_is_where_it_was_sent_one_cycle_later(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        assert_true(rig_get(rig, "MAIN.Number_Servos") == SERVOS);
        assert_true(get(rig, 3, "Number") == 3 && get(rig, 3, "Type") == 0);
        assert_true(get(rig, 0, "EtherCATState") == 8 && get(rig, 0, "Status") == 2);
        set(rig, 0, "WritePosition", 5); /* Mode is off */
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "Position") == 0);
        SET(rig, 0, { "Mode", POSITION }, { "WritePosition", 100 });
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "Status") == 3);
        assert_true(get(rig, 0, "Position") == 0);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Position") == 100);
        assert_true(get(rig, 0, "Speed") == 100 / 500e-6);
        SET(rig, 0, { "Offset", 1000 }, { "Correction", 7 });
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "Position") == 1107);
        assert_true(get(rig, 0, "RefPosition") == 107);
        assert_true(get(rig, 0, "PositionError") == 0);
        set(rig, 0, "Control", 2); /* no torque */
        set(rig, 0, "WritePosition", 0);
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "Status") == 2 && get(rig, 0, "Position") == 1107);
        SET(rig, 0, { "Control", 0 }, { "Mode", USER }, { "TransformedPosition", 50 });
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "Position") == 1057 && get(rig, 0, "WritePosition") == 50);
        set(rig, 0, "WritePosition", NAN); /* stays */
        set(rig, 0, "TransformedPosition", NAN);
        rig_cycles(rig, 2);
        assert_true(get(rig, 0, "Position") == 1057);
        rig_close(rig);
    }
}

static void modes_are_configuration(void **state)
{
    const struct servo_modes modes = {
        .off = 7, .position = 5, .pg = 21, .gear = 22, .pg_gear = 23, .interpolator = 24, .user = 3
    };
    const struct host_config config = {
        .plant = &nothing, .servos = virtuals, .servo_count = 1, .modes = &modes
    };
    struct rig *rig = rig_open("idle", &config);

    (void)state;
    set(rig, 0, "Mode", 7);
    rig_start(rig);
    rig_cycles(rig, 2);
    assert_true(get(rig, 0, "Status") == 2);
    SET(rig, 0, { "Mode", 3 }, { "TransformedPosition", 4 });
    rig_cycles(rig, 3);
    assert_true(get(rig, 0, "Position") == 4);
    profile_of(rig, 0, 1e5, 1e6);
    SET(rig, 0, { "Mode", 21 }, { "Pg.DPos", 100 });
    rig_cycles(rig, 100);
    assert_true(get(rig, 0, "Position") == 100);
    rig_close(rig);
}

/* --- profile generator --- */

static void every_profile_drives_write_position(void **state)
{
    static const uint32_t cycles[] = { 250, 500, 1000 };

    (void)state;
    EACH_LAYOUT(p)
    for (size_t c = 0; c < COUNT(cycles); c++)
        for (uint32_t type = 0; type <= 5; type++) {
            struct rig *rig = open_virtuals(p, cycles[c]);
            struct profile_wanted wanted = { .positioning = true,
                                             .destination = -30000,
                                             .speed = 1e5,
                                             .acceleration = 1e6,
                                             .deceleration = 6e5,
                                             .type = type };
            struct profile expected;
            double sent = 0, last = 0; /* it leaves in the next cycle */
            bool braked = false;

            if (p == 1) {
                wanted.percent = 40;
                set(rig, 0, "Pg.Jerklimitation", 40);
            }
            SET(rig, 0, { "Pg.Mode", 1 }, { "Pg.Type", type }, { "Pg.PosSpeed", 1e5 },
                { "Pg.Acc", 1e6 }, { "Pg.Dec", 6e5 }, { "Mode", PG });
            rig_cycles(rig, 2);
            assert_true(get(rig, 0, "Pg.Rdy") == 1);
            set(rig, 0, "Pg.DPos", -30000);
            profile_set(&expected, 0, 0);
            do {
                rig_cycles(rig, 1);
                profile_step(&expected, &wanted, cycles[c] * 1e-6);
                assert_true(get(rig, 0, "Pg.APos") == expected.position);
                assert_true(get(rig, 0, "Pg.ASpeed") == expected.speed);
                assert_true(get(rig, 0, "WritePosition") == expected.position);
                assert_true(get(rig, 0, "Position") == sent);
                assert_true(get(rig, 0, "Pg.Rdy") == expected.ready);
                assert_true(get(rig, 0, "Pg.Mode") == (expected.braking ? 2 : 1));
                braked = braked || expected.braking;
                sent = last;
                last = expected.position;
            } while (!expected.ready);
            assert_true(braked && get(rig, 0, "Pg.APos") == -30000);
            rig_close(rig);
        }
}

static void a_generator_takes_over_without_a_jump(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double before, speed;

        SET(rig, 0, { "Mode", POSITION }, { "Offset", 300 });
        for (unsigned i = 1; i <= 100; i++) { /* 2000 inc/s, by the PLC */
            set(rig, 0, "WritePosition", i);
            rig_cycles(rig, 1);
        }
        SET(rig, 0, { "WritePosition", 101 }, { "Mode", PG }, { "Pg.Mode", 0 }, { "Pg.Speed", 0 },
            { "Pg.Type", 3 }, { "Pg.Acc", 1e4 }, { "Pg.Dec", 1e4 });
        rig_cycles(rig, 1);
        before = get(rig, 0, "WritePosition");
        assert_near(before, 101 + 2000 * 5e-4L - 1e4L * 5e-4L * 5e-4L / 2);
        assert_near(get(rig, 0, "Pg.ASpeed"), 2000 - 5);
        rig_cycles(rig, 500);
        assert_true(get(rig, 0, "Pg.ASpeed") == 0 && get(rig, 0, "Pg.Rdy") == 1);
        assert_near(get(rig, 0, "WritePosition"), 101 + 2000.0L * 2000 / 2e4L);

        /* Off: it stays where the servo is, and says that it is not ready. */
        set(rig, 0, "Mode", OFF);
        rig_cycles(rig, 3);
        assert_true(get(rig, 0, "Pg.Rdy") == 0);
        assert_near(get(rig, 0, "Pg.APos"), get(rig, 0, "Position") - 300);
        set(rig, 0, "Offset", 100); /* moves nothing either, while it is off */
        set(rig, 0, "Pg.Mode", 0);
        set(rig, 0, "Mode", PG);
        before = get(rig, 0, "Position");
        for (unsigned i = 0; i < 10; i++) {
            rig_cycles(rig, 1);
            speed = get(rig, 0, "Speed");
            assert_true(fabs(speed) < 1e-6 && fabs(get(rig, 0, "Position") - before) < 1e-9);
        }
        rig_close(rig);
    }
}

static void a_set_point_that_is_no_number_does_not_reach_the_generator(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        SET(rig, 0, { "Mode", POSITION }, { "WritePosition", 500 });
        rig_cycles(rig, 5);
        profile_of(rig, 0, 1e5, 1e6);
        SET(rig, 0, { "WritePosition", NAN }, { "Pg.DPos", 700 }, { "Mode", PG });
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Pg.APos") > 500 && get(rig, 0, "Pg.APos") < 501);
        rig_until(rig, "SERVO[0].Pg.Rdy", 1, 200);
        assert_true(get(rig, 0, "WritePosition") == 700);
        rig_close(rig);
    }
}

/* --- commands --- */

static void commands_position_and_finish(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        SET(rig, 0, { "Pg.Type", 3 }, { "Command.Par[0]", 10000 }, { "Command.Par[1]", 1e5 },
            { "Command.Par[2]", 1e6 }, { "Command.Par[3]", 5e5 });
        set(rig, 0, "Command.Control", 2);
        rig_cycles(rig, 50);
        assert_true(get(rig, 0, "Command.Control") == 2);
        assert_true(get(rig, 0, "Mode") == PG && get(rig, 0, "Pg.Dec") == 5e5);
        rig_until(rig, "SERVO[0].Command.Control", 0, 1000);
        assert_true(get(rig, 0, "WritePosition") == 10000 && get(rig, 0, "Pg.Rdy") == 1);

        SET(rig, 0, { "Command.Par[0]", -2500 }, { "Command.Par[1]", 0 });
        command(rig, 0, 3, 1000);
        assert_true(get(rig, 0, "WritePosition") == 7500 && get(rig, 0, "Pg.PosSpeed") == 1e5);

        SET(rig, 0, { "Command.Par[0]", -5e4 }, { "Command.Par[2]", 0 });
        command(rig, 0, 1, 1000);
        assert_true(get(rig, 0, "Pg.ASpeed") == -5e4 && get(rig, 0, "Pg.Mode") == 0);
        rig_cycles(rig, 10);

        set(rig, 0, "Command.Par[0]", 1e6);
        command(rig, 0, 5, 1000);
        assert_true(get(rig, 0, "Pg.ASpeed") == 0 && get(rig, 0, "Pg.Dec") == 1e6);
        rig_close(rig);
    }
}

static void setting_the_reference_moves_nothing(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double before, destination;

        profile_of(rig, 0, 1e5, 1e6);
        SET(rig, 0, { "Mode", PG }, { "Pg.DPos", 20000 }, { "Correction", 5 });
        rig_cycles(rig, 300); /* in motion */
        before = get(rig, 0, "Position");
        set(rig, 0, "Command.Par[0]", -1000);
        set(rig, 0, "Command.Control", 4);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Command.Control") == 0);
        assert_near(get(rig, 0, "Speed"), 1e5);
        assert_near(get(rig, 0, "Position"), before + 50);
        assert_near(get(rig, 0, "RefPosition"), -1000);
        for (unsigned i = 2; i < 12; i++) {
            rig_cycles(rig, 1);
            assert_near(get(rig, 0, "Position"), before + 50 * i);
        }
        destination = get(rig, 0, "Pg.DPos");
        rig_until(rig, "SERVO[0].Pg.Rdy", 1, 1000);
        rig_cycles(rig, 2);
        assert_near(get(rig, 0, "Position"), 20005);
        assert_true(get(rig, 0, "WritePosition") == destination);
        rig_close(rig);
    }
}

static void commands_couple_and_uncouple_the_gear(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double here;

        SET(rig, 1, { "Mode", PG }, { "Pg.Type", 3 }, { "Pg.Acc", 1e9 }, { "Pg.Dec", 1e9 },
            { "Pg.Speed", 2000 });
        rig_cycles(rig, 10);
        SET(rig, 0, { "Command.Par[0]", LINEAR }, { "Command.Par[1]", 1 },
            { "Command.Par[2]", WRITE_POSITION }, { "Command.Par[3]", 50 },
            { "Command.Par[4]", 10 }, { "Command.Par[5]", 0.5 });
        set(rig, 0, "Command.Control", 6);
        rig_cycles(rig, 50);
        assert_true(get(rig, 0, "Command.Control") == 6 && get(rig, 0, "Mode") == GEAR);
        rig_until(rig, "SERVO[0].Command.Control", 0, 53);
        assert_true(get(rig, 0, "Gear.ActualIn") == 50);
        here = get(rig, 0, "WritePosition");
        rig_cycles(rig, 10);
        assert_near(get(rig, 0, "WritePosition") - here, 50);

        set(rig, 0, "Command.Par[0]", 2.5);
        command(rig, 0, 7, 21);
        assert_true(get(rig, 0, "Gear.ActualIn") == 0 && get(rig, 0, "Gear.Mode") == 0);
        here = get(rig, 0, "WritePosition");
        rig_cycles(rig, 10);
        assert_true(get(rig, 0, "WritePosition") == here);

        set_table(rig, "CAM", 80, POINTS, slope);
        SET(rig, 0, { "Command.Par[0]", CAM }, { "Command.Par[5]", 0 }, { "Command.Par[7]", 80 },
            { "Command.Par[8]", POINTS }, { "Command.Par[11]", 1 }, { "Command.Par[13]", 6 },
            { "Command.Par[14]", 0.5 }, { "Command.Par[3]", 0 });
        set(rig, 0, "Command.Control", 6);
        rig_cycles(rig, 11);
        assert_true(get(rig, 0, "Command.Control") == 6);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Command.Control") == 0);
        assert_true(get(rig, 0, "WritePosition") == 106);
        command(rig, 0, 7, 2);
        assert_true(get(rig, 0, "Gear.Mode") == 0);
        rig_close(rig);
    }
}

static void a_command_takes_a_moving_gear_over_and_stops_it(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);
        double before, now;

        SET(rig, 1, { "Mode", PG }, { "Pg.Type", 3 }, { "Pg.Acc", 1e6 }, { "Pg.Dec", 1e6 },
            { "Pg.Speed", 2000 });
        link_servos(rig, 0, 1, 3, 1);
        SET(rig, 0, { "Pg.Type", 3 }, { "Command.Par[0]", 6e4 });
        rig_cycles(rig, 100);
        set(rig, 0, "Command.Control", 5);
        for (before = get(rig, 0, "WritePosition"); get(rig, 0, "Command.Control") == 5;
             before = now) {
            rig_cycles(rig, 1);
            now = get(rig, 0, "WritePosition");
            assert_true(now >= before && now - before <= 3);
        }
        assert_true(get(rig, 0, "Pg.ASpeed") == 0 && get(rig, 0, "Mode") == PG);
        rig_close(rig);
    }
}

static void commands_that_cannot_be_are_refused(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        for (int number = 1; number < 10; number++) {
            /* No acceleration; no speed; neither linear nor cam; no such command. */
            if (number == 4 || number == 5 || number == 7)
                continue;
            set(rig, 0, "Command.Control", number);
            rig_cycles(rig, 1);
            assert_true(get(rig, 0, "Command.Control") == -1);
            assert_true(get(rig, 0, "Mode") == OFF);
        }
        SET(rig, 0, { "Pg.Acc", 1e6 }, { "Command.Control", 2 }); /* still no speed */
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Command.Control") == -1);
        set(rig, 0, "Command.Control", 2147483647);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Command.Control") == -1);
        for (int number = 1; number < 8; number++) {
            SET(rig, 0, { "Command.Par[0]", NAN }, { "Command.Control", number });
            rig_cycles(rig, 1);
            assert_true(get(rig, 0, "Command.Control") == -1);
        }

        /* And one that loses its servo. */
        SET(rig, 0, { "Command.Par[0]", 1e6 }, { "Command.Par[1]", 1e4 }, { "Command.Par[2]", 1e6 },
            { "Command.Control", 2 });
        rig_cycles(rig, 100);
        assert_true(get(rig, 0, "Command.Control") == 2);
        set(rig, 0, "Control", 2);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Command.Control") == -1);
        rig_close(rig);
    }
}

/* --- capture --- */

static void edges_of_an_input_capture_the_position_once(void **state)
{
    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        SET(rig, 0, { "Mode", PG }, { "Pg.Type", 3 }, { "Pg.Acc", 1e9 }, { "Pg.Dec", 1e9 },
            { "Pg.Speed", 2000 }, { "ExtPosition", 44 }, { "Capture.Typ_ExtCapture", 3 },
            { "Capture.Control", 3 });
        rig_cycles(rig, 50);
        set(rig, 0, "DigitalIn", 7); /* other inputs */
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Capture.Control") == 3);
        set(rig, 0, "DigitalIn", 8);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Capture.Control") == 2);
        assert_true(get(rig, 0, "Capture.PPosition") == get(rig, 0, "Position"));
        assert_true(get(rig, 0, "Capture.PExt_Position") == 44);
        assert_true(get(rig, 0, "Capture.NPosition") == 0);
        rig_cycles(rig, 10);
        set(rig, 0, "DigitalIn", 0);
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Capture.Control") == 0);
        assert_true(get(rig, 0, "Capture.NPosition") == get(rig, 0, "Position"));
        assert_near(get(rig, 0, "Capture.NPosition") - get(rig, 0, "Capture.PPosition"), 11);
        set(rig, 0, "DigitalIn", 8); /* not armed any more */
        rig_cycles(rig, 1);
        assert_near(get(rig, 0, "Capture.NPosition") - get(rig, 0, "Capture.PPosition"), 11);
        SET(rig, 0, { "Capture.Typ_ExtCapture", 32 }, { "Capture.Control", 3 }, { "DigitalIn", 0 });
        rig_cycles(rig, 1);
        assert_true(get(rig, 0, "Capture.Control") == 3);
        rig_close(rig);
    }
}

/* --- anything --- */

static uint32_t random_state;

static uint32_t draw(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

/* A number of any kind: small, large, none. */
static double anything(void)
{
    static const double odd[] = { 0,    -1,       1e-300, 1e300,        -1e300,     NAN,
                                  1e15, INFINITY, 0.5,    -2147483648., 4294967295. };

    switch (draw() % 3) {
    case 0:
        return odd[draw() % COUNT(odd)];
    case 1:
        return (double)(draw() % 8);
    default:
        return (double)draw() - 8388608.0;
    }
}

/* Found by the sanitizers, or by the host's guard pages. */
static void nothing_in_the_registers_harms_the_host(void **state)
{
    static const char *const doubles[] = {
        "WritePosition",
        "Offset",
        "Correction",
        "TransformedPosition",
        "ExtPosition",
        "Pg.Acc",
        "Pg.Dec",
        "Pg.APos",
        "Pg.DPos",
        "Pg.PosSpeed",
        "Pg.Speed",
        "Gear.Offset",
        "Gear.Shift",
        "Gear.ActualShift",
        "Gear.IncShift",
        "Gear.IncIn",
        "Gear.CamScale",
        "Gear.Position",
        "Gear.CamIncPosition",
        "Command.Par[0]",
        "Command.Par[1]",
        "Command.Par[7]",
        "Command.Par[8]",
    };
    static const char *const words[] = {
        "Mode",
        "Control",
        "Pg.Mode",
        "Pg.Type",
        "Gear.Mode",
        "Gear.In",
        "Gear.Out",
        "Gear.SourceNumber",
        "Gear.CamLine",
        "Gear.CamLen",
        "Gear.CamType",
        "Gear.SourcePosition",
        "Gear.CamTab",
        "Gear.ActualIn",
        "Gear.CamExpControl",
        "Gear.CamExpLine1",
        "DigitalIn",
        "Capture.Control",
        "Gear.CamExpAddress1",
        "Gear.CamExpAddress2",
        "Pg.Rdy",
        "Gear.CamExpLine2",
        "Command.Control",
        "Capture.Typ_ExtCapture",
    };

    (void)state;
    EACH_LAYOUT(p)
    {
        struct rig *rig = open_virtuals(p, 500);

        random_state = (uint32_t)p + 1;
        for (unsigned i = 0; i < 20000; i++) {
            const unsigned servo = draw() % SERVOS;
            const double word = (double)(draw() % 3 != 0 ? draw() % 8 : draw() << 9);

            set(rig, servo, doubles[draw() % COUNT(doubles)], anything());
            set(rig, servo, words[draw() % COUNT(words)], word);
            rig_cycles(rig, 1);
        }
        rig_close(rig);
    }
}

/* --- drives --- */

static void a_drive_positions_with_the_profile_generator(void **state)
{
    (void)state;
    for (size_t p = 0; p < 2; p++) {
        const struct host_config config = { .product = product_of(p) };
        struct rig *rig = rig_open("idle", &config);
        double start, last;

        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_cycles(rig, 10);
        start = get(rig, 0, "Position");
        SET(rig, 0, { "Pg.Type", 1 }, { "Command.Par[0]", 2e6 }, { "Command.Par[1]", 4e6 },
            { "Command.Par[2]", 2e7 });
        set(rig, 0, "Command.Control", 3);
        rig_cycles(rig, 2);
        last = get(rig, 0, "WritePosition");
        for (unsigned i = 0; i < 3000 && get(rig, 0, "Command.Control") == 3; i++) {
            rig_cycles(rig, 1);
            assert_true(fabs(get(rig, 0, "WritePosition") - last) <= 4e6 * 5e-4 + 1);
            last = get(rig, 0, "WritePosition");
        }
        assert_true(get(rig, 0, "Command.Control") == 0 && get(rig, 0, "Status") == 3);
        rig_cycles(rig, 200);
        assert_true(fabs(get(rig, 0, "Position") - start - 2e6) < 50);

        /* Torque off on the way: the generator follows, and goes on from where the drive came to
         * rest. */
        set(rig, 0, "Pg.DPos", start);
        rig_cycles(rig, 300);
        set(rig, 0, "Control", 2);
        rig_cycles(rig, 1000);
        assert_true(get(rig, 0, "Status") == 2);
        assert_true(get(rig, 0, "Pg.APos") == get(rig, 0, "Position"));
        set(rig, 0, "Control", 0);
        rig_until(rig, "SERVO[0].Status", 3, 100);
        for (unsigned i = 0; i < 2000; i++) {
            rig_cycles(rig, 1);
            assert_true(fabs(get(rig, 0, "WriteSpeed")) <= 4e6 * (1 + 1e-6));
        }
        assert_true(fabs(get(rig, 0, "Position") - start) < 50);
        rig_close(rig);
    }
}

/* Its home switch, input 2, is active at and below 0. */
static void a_drive_captures_where_its_switch_is(void **state)
{
    (void)state;
    for (size_t p = 0; p < 2; p++) {
        const struct host_config config = { .product = product_of(p) };
        struct rig *rig = rig_open("idle", &config);

        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_cycles(rig, 10);
        assert_true(get(rig, 0, "Position") > 400000);
        SET(rig, 0, { "Capture.Typ_ExtCapture", 2 }, { "Capture.Control", 3 },
            { "Command.Par[0]", -500000 }, { "Command.Par[1]", 2e6 }, { "Command.Par[2]", 1e7 });
        command(rig, 0, 2, 3000);
        assert_true(get(rig, 0, "Capture.Control") == 2);
        assert_true(fabs(get(rig, 0, "Capture.PPosition")) <= 2e6 * 5e-4 * 1.1);
        set(rig, 0, "Command.Par[0]", 300000);
        command(rig, 0, 2, 3000);
        assert_true(get(rig, 0, "Capture.Control") == 0);
        assert_true(fabs(get(rig, 0, "Capture.NPosition")) <= 2e6 * 5e-4 * 1.1);
        rig_close(rig);
    }
}

static void the_list_says_which_servo_is_which(void **state)
{
    const struct host_servo list[] = { { .type = 0, .resolution = 4096 },
                                       { .type = 5, .node = 1, .axis = 1, .feedback = 2 } };
    struct host_servo wrong[] = { list[1], list[1] };

    (void)state;
    for (size_t p = 0; p < 2; p++) {
        const struct host_config config = { .product = product_of(p),
                                            .servos = list,
                                            .servo_count = 2 };
        struct rig *rig = rig_open("idle", &config);

        rig_start(rig);
        rig_until(rig, "SERVO[1].EtherCATState", 8, 1000);
        assert_true(rig_get(rig, "MAIN.Number_Servos") == 2);
        assert_true(get(rig, 0, "Type") == 0 && get(rig, 0, "Resolution") == 4096);
        assert_true(get(rig, 0, "ResolutionBits") == 12);
        assert_true(get(rig, 1, "Type") == 5 && get(rig, 1, "Node") == 1);
        assert_true(get(rig, 1, "Number") == 1);
        if (p == 1)
            assert_true(get(rig, 1, "FeedbackType") == 2);

        /* The drive follows the virtual master. */
        link_servos(rig, 1, 0, 500, 1);
        rig_until(rig, "SERVO[1].Status", 3, 100);
        profile_of(rig, 0, 1e3, 1e4);
        SET(rig, 0, { "Mode", PG }, { "Pg.DPos", 500 });
        rig_cycles(rig, 5);
        assert_true(get(rig, 1, "Status") == 3);
        const double base = get(rig, 1, "WritePosition") - 500 * get(rig, 0, "WritePosition");
        rig_until(rig, "SERVO[0].Pg.Rdy", 1, 3000);
        rig_cycles(rig, 200);
        assert_near(get(rig, 1, "WritePosition"), base + 250000);
        assert_true(fabs(get(rig, 1, "PositionError")) < 50);
        rig_close(rig);

        struct rig failing = { 0 };
        char path[512], why[HOST_WHY];
        struct host_config bad = { .product = product_of(p),
                                   .cycle_us = 500,
                                   .seed = 1,
                                   .plant = &plant_default,
                                   .servos = wrong,
                                   .servo_count = 1 };
        const struct machine_config machine = { .seed = 1 };

        snprintf(path, sizeof path, "%s/idle_%s.tgm", TEST_HOST_MODULES_DIR, p == 0 ? "4" : "906");
        assert_int_equal(image_open(&failing.image, path, why), 0);
        for (uint32_t node = 0; node < 4; node++) {
            wrong[0].node = node;
            wrong[0].axis = node == 1 ? 2 : 1;
            assert_int_equal(machine_load(&failing.machine, failing.image, &machine, why), 0);
            assert_int_not_equal(host_open(&failing.host, &bad, failing.machine, failing.image,
                                           &failing.evidence, why),
                                 0);
            assert_non_null(strstr(why, "servo 0: node"));
            machine_unload(failing.machine);
        }
        image_close(failing.image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_written_position_does_not_move_a_virtual_servo),
        cmocka_unit_test(a_virtual_servo_is_where_it_was_sent_one_cycle_later),
        cmocka_unit_test(modes_are_configuration),
        cmocka_unit_test(every_profile_drives_write_position),
        cmocka_unit_test(a_generator_takes_over_without_a_jump),
        cmocka_unit_test(a_set_point_that_is_no_number_does_not_reach_the_generator),
        cmocka_unit_test(commands_position_and_finish),
        cmocka_unit_test(setting_the_reference_moves_nothing),
        cmocka_unit_test(commands_couple_and_uncouple_the_gear),
        cmocka_unit_test(a_command_takes_a_moving_gear_over_and_stops_it),
        cmocka_unit_test(commands_that_cannot_be_are_refused),
        cmocka_unit_test(edges_of_an_input_capture_the_position_once),
        cmocka_unit_test(nothing_in_the_registers_harms_the_host),
        cmocka_unit_test(a_drive_positions_with_the_profile_generator),
        cmocka_unit_test(a_drive_captures_where_its_switch_is),
        cmocka_unit_test(the_list_says_which_servo_is_which),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
