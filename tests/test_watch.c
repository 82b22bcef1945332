/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_watch.c - set-points that no axis can follow are seen when they leave for the bus. */
#include "tests/host_rig.h"

#include <math.h>

#define REVOLUTION 1048576.0 /* inc, of the drive that stands around a module by default */
#define STEP       (AUDIT_AXIS_SPEED * REVOLUTION * 500e-6)

static const char *const layouts[] = { "pc4", "pc500", "pc5" };

static struct rig *opened(const char *product)
{
    const struct host_config config = { .product = product_find(product) };
    struct rig *rig = rig_open("idle", &config);
    rig_start(rig);
    return rig;
}

static uint64_t count(const struct rig *rig, enum audit_motion_kind kind)
{
    return rig->evidence.audit.motion[kind].count;
}

/* Enabled, and where it stands. */
static struct rig *enabled(const char *product)
{
    struct rig *rig = opened(product);
    rig_until(rig, "SERVO[0].EtherCATState", 8, 200);
    rig_set(rig, "SERVO[0].WritePosition", rig_get(rig, "SERVO[0].Position"));
    rig_set(rig, "SERVO[0].Mode", 1);
    rig_until(rig, "SERVO[0].Status", 3, 200);
    rig_cycles(rig, 2);
    for (int kind = 0; kind < AUDIT_MOTION_KINDS; kind++)
        assert_int_equal(count(rig, (enum audit_motion_kind)kind), 0);
    return rig;
}

static void a_step_is_measured_from_the_last_set_point(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct rig *rig = enabled(layouts[i]);
        const double from = rig_get(rig, "SERVO[0].WritePosition");
        rig_set(rig, "SERVO[0].WritePosition", from + 0.99 * STEP);
        rig_cycles(rig, 1);
        rig_set(rig, "SERVO[0].Offset", 0.99 * STEP); /* the sum of both goes out */
        rig_cycles(rig, 1);
        assert_int_equal(count(rig, AUDIT_TOO_FAST), 0);
        rig_set(rig, "SERVO[0].Offset", -0.1 * STEP);
        const uint64_t cycle = host_cycles(rig->host);
        rig_cycles(rig, 3);
        const struct audit_motion *motion = &rig->evidence.audit.motion[AUDIT_TOO_FAST];
        assert_int_equal(motion->count, 1);
        assert_int_equal(motion->cycle, cycle);
        assert_true(fabs(motion->value + 1.09 * STEP) < 1);
        assert_true(fabs(motion->limit - STEP) < 1);
        rig_close(rig);
    }
}

static void an_axis_is_enabled_where_it_stands(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++)
        for (int jump = 0; jump < 2; jump++) {
            struct rig *rig = opened(layouts[i]);
            rig_until(rig, "SERVO[0].EtherCATState", 8, 200);
            rig_set(rig, "SERVO[0].WritePosition",
                    rig_get(rig, "SERVO[0].Position") +
                        (jump ? 1.1 : 0.9) * AUDIT_AXIS_JUMP * REVOLUTION);
            rig_set(rig, "SERVO[0].Mode", 1);
            rig_until(rig, "SERVO[0].Status", 3, 200);
            rig_cycles(rig, 3);
            assert_int_equal(count(rig, AUDIT_JUMP), jump);
            assert_int_equal(count(rig, AUDIT_TOO_FAST), 0);
            rig_close(rig);
        }
}

static void who_does_not_wait_for_the_bus_is_seen_in_each_cycle_until_it_is_there(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct rig *rig = opened(layouts[i]);
        rig_set(rig, "SERVO[0].Mode", 1);
        rig_set(rig, "SERVO[0].Control", 2); /* no torque: nothing is to move */
        rig_cycles(rig, 1);
        assert_int_equal(count(rig, AUDIT_EARLY), 0);
        rig_set(rig, "SERVO[0].Control", 0);
        rig_cycles(rig, 2);
        assert_int_equal(count(rig, AUDIT_EARLY), 2);
        assert_int_equal(rig->evidence.audit.motion[AUDIT_EARLY].cycle, 1);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 200);
        const uint64_t before = count(rig, AUDIT_EARLY);
        rig_cycles(rig, 20);
        assert_int_equal(count(rig, AUDIT_EARLY), before);
        rig_close(rig);
    }
}

static void no_number_is_seen_whatever_the_mode(void **state)
{
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct rig *rig = opened(layouts[i]);
        rig_set(rig, "SERVO[0].Correction", (double)NAN);
        rig_cycles(rig, 1);
        assert_int_equal(count(rig, AUDIT_NO_NUMBER), 1);
        rig_set(rig, "SERVO[0].Correction", 0);
        rig_set(rig, "SERVO[0].WritePosition", (double)INFINITY);
        rig_cycles(rig, 1);
        assert_int_equal(count(rig, AUDIT_NO_NUMBER), 2);
        rig_close(rig);
    }
}

static void nobody_watches_while_the_plc_is_paused(void **state)
{
    (void)state;
    struct rig *rig = opened("pc4");
    host_pause(rig->host, true);
    rig_set(rig, "SERVO[0].Mode", 1);
    rig_cycles(rig, 2);
    assert_int_equal(count(rig, AUDIT_EARLY), 0);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_is_measured_from_the_last_set_point),
        cmocka_unit_test(an_axis_is_enabled_where_it_stands),
        cmocka_unit_test(who_does_not_wait_for_the_bus_is_seen_in_each_cycle_until_it_is_there),
        cmocka_unit_test(no_number_is_seen_whatever_the_mode),
        cmocka_unit_test(nobody_watches_while_the_plc_is_paused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
