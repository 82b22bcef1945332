/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The servo drive: CiA 402 states, set points, faults, mechanics. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bus/drive_device.h"
#include "bus/registers.h"

#define MS 1000000u

struct bench {
    struct drive_device device;
    struct drive *drive;
    uint64_t now;
};

static void new_drive(struct bench *b, uint64_t seed)
{
    const struct device_type *type = device_type_find("drive-cia402");
    struct device_setup setup = { .type = type, .seed = seed };

    memset(b, 0, sizeof *b);
    b->drive = &b->device.axis[0];
    od_reset(type->od, &b->device);
    type->init(&b->device, &setup);
    drive_al_state(b->drive, AL_OP);
    drive_publish(b->drive);
}

/* One exchange: time passes, then the outputs arrive. */
static void exchange(struct bench *b, uint32_t ns)
{
    b->now += ns;
    drive_step(b->drive, b->now);
    drive_command(b->drive, b->now);
    drive_publish(b->drive);
}

static void command(struct bench *b, uint16_t controlword)
{
    b->drive->o.controlword = controlword;
    exchange(b, MS);
}

static void enable(struct bench *b, int8_t mode)
{
    b->drive->o.mode = mode;
    command(b, 6);
    command(b, 7);
    b->drive->o.target_position = b->drive->o.position_actual;
    command(b, 15);
    assert_int_equal(b->drive->machine.state, CIA402_OPERATION_ENABLED);
}

static int32_t position(const struct bench *b)
{
    return b->drive->o.position_actual;
}

/* --- state machine --- */

static void every_transition_follows_the_table(void **state)
{
    enum {
        SOD = CIA402_SWITCH_ON_DISABLED,
        RTSO = CIA402_READY_TO_SWITCH_ON,
        SO = CIA402_SWITCHED_ON,
        OE = CIA402_OPERATION_ENABLED,
        QSA = CIA402_QUICK_STOP_ACTIVE,
        FRA = CIA402_FAULT_REACTION,
        F = CIA402_FAULT
    };
    /* Next state by controlword; quick stop option 5 and no ramps, so that all is immediate. The
     * reset bit is part of every command's pattern: with it set, nothing else is commanded. */
    static const struct {
        int from;
        int disable_voltage, shutdown, switch_on, enable, quick_stop, reset;
    } rows[] = {
        { SOD, SOD, RTSO, SOD, SOD, SOD, SOD },
        { RTSO, SOD, RTSO, SO, OE, SOD, RTSO },
        { SO, SOD, RTSO, SO, OE, SOD, SO },
        { OE, SOD, RTSO, SO, OE, QSA, OE },
        { QSA, SOD, QSA, QSA, OE, QSA, QSA },
        { FRA, FRA, FRA, FRA, FRA, FRA, FRA },
        { F, F, F, F, F, F, SOD },
    };
    static const uint16_t words[] = { 0x00, 0x06, 0x07, 0x0f, 0x02, 0x80 };
    static const struct cia402_options options = { .quick_stop = 5 };

    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        for (size_t w = 0; w < 6; w++) {
            struct cia402 machine = { .state = (enum cia402_state)rows[r].from };

            cia402_command(&machine, words[w], &options, true);
            assert_int_equal(machine.state, (&rows[r].disable_voltage)[w]);
        }
    }
}

static void statuswords_have_the_bits_of_their_state(void **state)
{
    static const struct {
        enum cia402_state state;
        uint16_t mask, value;
    } rows[] = {
        { CIA402_NOT_READY, 0x4f, 0x00 },          { CIA402_SWITCH_ON_DISABLED, 0x4f, 0x40 },
        { CIA402_READY_TO_SWITCH_ON, 0x6f, 0x21 }, { CIA402_SWITCHED_ON, 0x6f, 0x23 },
        { CIA402_OPERATION_ENABLED, 0x6f, 0x27 },  { CIA402_QUICK_STOP_ACTIVE, 0x6f, 0x07 },
        { CIA402_FAULT_REACTION, 0x4f, 0x0f },     { CIA402_FAULT, 0x4f, 0x08 },
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct cia402 machine = { .state = rows[i].state };

        assert_int_equal(cia402_status(&machine) & rows[i].mask, rows[i].value);
    }
}

static void fault_reset_needs_a_rising_edge_and_the_cause_gone(void **state)
{
    static const struct cia402_options options = { 0 };
    struct cia402 m = { .state = CIA402_FAULT, .reset_seen = true };

    (void)state;
    cia402_command(&m, 0x80, &options, true);
    assert_int_equal(m.state, CIA402_FAULT);
    cia402_command(&m, 0x00, &options, true);
    cia402_command(&m, 0x80, &options, false);
    assert_int_equal(m.state, CIA402_FAULT);
    cia402_command(&m, 0x00, &options, true);
    cia402_command(&m, 0x80, &options, true);
    assert_int_equal(m.state, CIA402_SWITCH_ON_DISABLED);
}

static void quick_stop_with_option_2_ends_in_switch_on_disabled(void **state)
{
    static const struct cia402_options options = { .quick_stop = 2 };
    struct cia402 m = { .state = CIA402_OPERATION_ENABLED };

    (void)state;
    cia402_command(&m, 0x02, &options, true);
    assert_int_equal(m.state, CIA402_QUICK_STOP_ACTIVE);
    cia402_command(&m, 0x0f, &options, true);
    assert_int_equal(m.state, CIA402_QUICK_STOP_ACTIVE);
    cia402_standstill(&m, &options);
    assert_int_equal(m.state, CIA402_SWITCH_ON_DISABLED);
}

static void a_fault_without_power_needs_no_reaction(void **state)
{
    struct cia402 m = { .state = CIA402_READY_TO_SWITCH_ON };

    (void)state;
    assert_true(cia402_fail(&m));
    assert_int_equal(m.state, CIA402_FAULT);
    assert_false(cia402_fail(&m));
}

static void enabling_takes_the_known_statuswords(void **state)
{
    static const uint16_t words[] = { 0, 6, 7, 15 };
    static const uint16_t status[] = { 0x0250, 0x0231, 0x0233, 0x1637 };
    struct bench b;

    (void)state;
    new_drive(&b, 7);
    b.drive->o.target_position = position(&b);
    for (size_t i = 0; i < 4; i++) {
        command(&b, words[i]);
        assert_int_equal(b.drive->o.statusword, status[i]);
    }
}

/* --- power-on and mechanics --- */

static void power_on_position_comes_from_the_seed_and_lies_in_its_range(void **state)
{
    int32_t first = 0;
    unsigned different = 0;

    (void)state;
    for (uint64_t seed = 1; seed <= 50; seed++) {
        struct bench b, again;

        new_drive(&b, seed * 7919);
        new_drive(&again, seed * 7919);
        assert_int_equal(position(&b), position(&again));
        assert_in_range(position(&b), 1 << 19, 3 << 19);
        different += seed > 1 && position(&b) != first;
        first = position(&b);
    }
    assert_true(different > 40);
}

static void results_do_not_depend_on_how_time_is_cut(void **state)
{
    struct bench coarse, fine;

    (void)state;
    new_drive(&coarse, 3);
    new_drive(&fine, 3);
    enable(&coarse, DRIVE_CSP);
    enable(&fine, DRIVE_CSP);
    for (unsigned i = 0; i < 500; i++) {
        coarse.drive->o.target_position += 3000;
        fine.drive->o.target_position += 3000;
        exchange(&coarse, MS);
        for (unsigned k = 1; k < 37; k++)
            drive_step(fine.drive, fine.now + k * MS / 37);
        exchange(&fine, MS);
        assert_memory_equal(&coarse.drive->o, &fine.drive->o, sizeof coarse.drive->o);
        assert_true(coarse.drive->axis.position == fine.drive->axis.position);
    }
}

/* --- cyclic modes --- */

static void csp_follows_a_ramp_with_a_small_following_error(void **state)
{
    static const uint32_t cycles[] = { 250000, 500000, 1000000, 2000000 };

    (void)state;
    for (size_t c = 0; c < 4; c++) {
        struct bench b;
        int32_t step = (int32_t)(cycles[c] / 250000) * 1311; /* 5 rev/s */

        new_drive(&b, 9);
        enable(&b, DRIVE_CSP);
        for (int32_t i = 0; i < 4000; i++) {
            /* Half a second of acceleration to 5 rev/s. */
            int32_t ramp = (int32_t)(500000000 / cycles[c]);

            b.drive->o.target_position += i < ramp ? step * i / ramp : step;
            exchange(&b, cycles[c]);
            assert_in_range(b.drive->o.following_error + 100, 0, 3000);
            assert_int_equal(b.drive->o.statusword & 0x206f, 0x27 | 0x0000);
            if (i * (int64_t)cycles[c] > 2000000000)
                break;
        }
        assert_in_range(b.drive->o.following_error, 500, 2500);
        assert_in_range(b.drive->o.velocity_actual, 5243000, 5245000);
        for (unsigned i = 0; i < 1000; i++)
            exchange(&b, cycles[c]);
        assert_in_range(position(&b) - b.drive->o.target_position + 20, 0, 40);
        assert_int_equal(b.drive->o.statusword, 0x1637);
    }
}

static void csp_walks_straight_between_set_points(void **state)
{
    struct bench b;
    double from;

    (void)state;
    new_drive(&b, 9);
    enable(&b, DRIVE_CSP);
    exchange(&b, MS);
    from = b.drive->demand;
    b.drive->o.target_position += 8000;
    exchange(&b, MS);
    for (unsigned i = 1; i <= 8; i++) {
        drive_step(b.drive, b.now + i * 125000);
        assert_int_equal(drive_increments(b.drive, b.drive->demand + 1e-9) -
                             drive_increments(b.drive, from + 1e-9),
                         1000 * i);
    }
}

static void a_jump_of_the_set_point_trips_the_following_error(void **state)
{
    struct bench b;
    unsigned ms = 0;

    (void)state;
    new_drive(&b, 9);
    enable(&b, DRIVE_CSP);
    b.drive->o.target_position += 5 << 20;
    exchange(&b, MS);
    while (b.drive->machine.state == CIA402_OPERATION_ENABLED && ms++ < 100) {
        if (ms > 2 && ms < 10)
            assert_int_equal(b.drive->o.statusword & SW_MODE_13, SW_MODE_13);
        exchange(&b, MS);
    }
    assert_in_range(ms, 10, 14); /* time-out of 10 ms after the window is left */
    assert_int_equal(b.drive->o.error_code, DRIVE_ERROR_FOLLOWING);
    while (b.drive->machine.state == CIA402_FAULT_REACTION && ms++ < 2000)
        exchange(&b, MS);
    assert_int_equal(b.drive->o.statusword & 0x4f, 0x08);
    command(&b, 0);
    command(&b, 0x80);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
    assert_int_equal(b.drive->o.error_code, 0);
}

static void the_following_error_watch_can_be_switched_off(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 9);
    b.drive->o.following_window = UINT32_MAX;
    enable(&b, DRIVE_CSP);
    b.drive->o.target_position += 5 << 20;
    for (unsigned i = 0; i < 3000; i++)
        exchange(&b, MS);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    assert_in_range(position(&b) - b.drive->o.target_position + 20, 0, 40);
}

static void csv_reaches_its_velocity_and_holds_it(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 2);
    enable(&b, DRIVE_CSV);
    b.drive->o.target_velocity = 3 << 20;
    for (unsigned i = 0; i < 500; i++)
        exchange(&b, MS);
    assert_in_range(b.drive->o.velocity_actual, 3130000, 3150000);
    assert_int_equal(b.drive->o.statusword & 0x106f, 0x1027);
    assert_int_equal(b.drive->o.following_error, 0);
}

static void cst_accelerates_with_torque(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 2);
    enable(&b, DRIVE_CST);
    b.drive->o.target_torque = 100; /* 10 % of 600 rev/s^2 */
    for (unsigned i = 0; i < 100; i++)
        exchange(&b, MS);
    assert_int_equal(b.drive->o.torque_actual, 100);
    assert_in_range(b.drive->o.velocity_actual, 5 << 20, 6 << 20);
}

static void an_unsupported_mode_is_not_taken_over(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 2);
    enable(&b, DRIVE_CSP);
    b.drive->o.mode = 4;
    exchange(&b, MS);
    assert_int_equal(b.drive->o.mode_display, DRIVE_CSP);
    b.drive->o.mode = DRIVE_CSV;
    exchange(&b, MS);
    assert_int_equal(b.drive->o.mode_display, DRIVE_CSV);
}

static void changing_the_mode_in_motion_does_not_jolt(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 2);
    enable(&b, DRIVE_CSV);
    b.drive->o.target_velocity = 3 << 20;
    for (unsigned i = 0; i < 500; i++)
        exchange(&b, MS);
    b.drive->o.mode = DRIVE_PV;
    for (unsigned i = 0; i < 20; i++) {
        exchange(&b, MS);
        assert_in_range(b.drive->o.velocity_actual, 3 * 1000000, 3.2 * 1048576);
    }
}

/* --- stopping --- */

static void run_up(struct bench *b)
{
    new_drive(b, 5);
    enable(b, DRIVE_CSV);
    b->drive->o.target_velocity = 10 << 20;
    for (unsigned i = 0; i < 300; i++)
        exchange(b, MS);
    assert_in_range(b->drive->o.velocity_actual, 9 << 20, 11 << 20);
}

static unsigned stop_time(struct bench *b, uint16_t controlword, enum cia402_state end)
{
    unsigned ms = 0;

    b->drive->o.controlword = controlword;
    do {
        exchange(b, MS);
        ms++;
    } while ((b->drive->machine.state != end || abs(b->drive->o.velocity_actual) > 20000) &&
             ms < 3000);
    return ms;
}

static void quick_stop_takes_its_own_deceleration(void **state)
{
    struct bench b;

    (void)state;
    run_up(&b);
    /* 10 rev/s at 400 rev/s^2: 25 ms and the settling of the loops. */
    assert_in_range(stop_time(&b, 0x02, CIA402_SWITCH_ON_DISABLED), 25, 90);
    run_up(&b);
    b.drive->o.options.quick_stop = 6;
    assert_in_range(stop_time(&b, 0x02, CIA402_QUICK_STOP_ACTIVE), 25, 90);
    assert_int_equal(b.drive->machine.state, CIA402_QUICK_STOP_ACTIVE);
}

static void disable_operation_ramps_down_before_it_changes_the_state(void **state)
{
    struct bench b;

    (void)state;
    run_up(&b);
    command(&b, 7);
    assert_int_equal(b.drive->o.statusword & 0x6f, 0x27);
    assert_in_range(stop_time(&b, 7, CIA402_SWITCHED_ON), 150, 300);
}

static void disable_voltage_lets_the_axis_coast_to_a_stop(void **state)
{
    struct bench b;

    (void)state;
    run_up(&b);
    command(&b, 0);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
    assert_true(b.drive->o.velocity_actual > 8 << 20);
    assert_in_range(stop_time(&b, 0, CIA402_SWITCH_ON_DISABLED), 100, 500);
}

static void losing_op_while_enabled_is_a_communication_fault(void **state)
{
    struct bench b;

    (void)state;
    run_up(&b);
    drive_al_state(b.drive, AL_SAFEOP);
    drive_publish(b.drive);
    assert_int_equal(b.drive->machine.state, CIA402_FAULT_REACTION);
    assert_int_equal(b.drive->o.error_code, DRIVE_ERROR_COMMUNICATION);
    assert_int_equal(b.drive->o.statusword & SW_REMOTE, 0);
    for (unsigned i = 0; i < 200; i++)
        drive_step(b.drive, b.now += MS);
    assert_int_equal(b.drive->machine.state, CIA402_FAULT);
    /* Not to be reset before the bus is back. */
    command(&b, 0);
    command(&b, 0x80);
    assert_int_equal(b.drive->machine.state, CIA402_FAULT);
    drive_al_state(b.drive, AL_OP);
    command(&b, 0);
    command(&b, 0x80);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
}

static void limit_switches_and_hard_stop_hold_the_axis(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 5);
    enable(&b, DRIVE_CSV);
    b.drive->o.target_velocity = -(5 << 20);
    for (unsigned i = 0; i < 2000; i++)
        exchange(&b, MS);
    assert_true(b.drive->axis.position >= axis_servo.stop_negative);
    assert_int_equal(b.drive->o.digital_inputs, AXIS_SWITCH_NEGATIVE | AXIS_SWITCH_HOME);
    assert_int_equal(b.drive->o.statusword & SW_INTERNAL_LIMIT, SW_INTERNAL_LIMIT);
    assert_int_equal(position(&b), -7 * (1 << 19));
}

/* --- profile modes --- */

static void pp_handshake_and_target_reached(void **state)
{
    struct bench b;
    int32_t goal;
    unsigned ms = 0;

    (void)state;
    new_drive(&b, 5);
    enable(&b, DRIVE_PP);
    goal = position(&b) + (4 << 20);
    b.drive->o.target_position = goal;
    command(&b, 0x1f);
    assert_int_equal(b.drive->o.statusword & 0x1400, 0x1000);
    command(&b, 0x0f);
    assert_int_equal(b.drive->o.statusword & 0x1000, 0);
    while (!(b.drive->o.statusword & SW_TARGET_REACHED) && ms++ < 5000) {
        exchange(&b, MS);
        assert_in_range(abs(b.drive->o.velocity_demand), 0, (5 << 20) + 1);
    }
    /* 4 rev at 5 rev/s with 50 rev/s^2: 0.8 s + 0.1 s. */
    assert_in_range(ms, 890, 960);
    assert_in_range(position(&b) - goal + 512, 0, 1024);
}

static void pp_buffers_one_set_point_and_takes_another_at_once(void **state)
{
    struct bench b;
    int32_t start;

    (void)state;
    new_drive(&b, 5);
    enable(&b, DRIVE_PP);
    start = position(&b);
    b.drive->o.target_position = start + (1 << 20);
    command(&b, 0x1f);
    command(&b, 0x0f);
    b.drive->o.target_position = start + (2 << 20);
    command(&b, 0x1f);
    command(&b, 0x0f);
    assert_int_equal(b.drive->o.statusword & 0x1000, 0x1000); /* buffer full */
    for (unsigned i = 0; i < 2000; i++)
        exchange(&b, MS);
    assert_in_range(position(&b) - start - (2 << 20) + 512, 0, 1024);
    b.drive->o.target_position = start + (6 << 20);
    command(&b, 0x1f);
    command(&b, 0x0f);
    b.drive->o.target_position = -(1 << 19);
    command(&b, 0x7f); /* relative, at once */
    for (unsigned i = 0; i < 3000; i++)
        exchange(&b, MS);
    assert_in_range(position(&b) - start - (11 << 19) + 512, 0, 1024);
}

static void halt_stops_profile_motion_and_release_resumes_it(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 5);
    enable(&b, DRIVE_PV);
    b.drive->o.target_velocity = 4 << 20;
    for (unsigned i = 0; i < 300; i++)
        exchange(&b, MS);
    assert_int_equal(b.drive->o.statusword & 0x1400, 0x0400);
    b.drive->o.controlword |= CW_HALT;
    for (unsigned i = 0; i < 300; i++)
        exchange(&b, MS);
    assert_int_equal(b.drive->o.statusword & 0x1400, 0x1400);
    b.drive->o.controlword &= (uint16_t)~CW_HALT;
    for (unsigned i = 0; i < 300; i++)
        exchange(&b, MS);
    assert_in_range(b.drive->o.velocity_actual, 4100000, 4250000);
}

static void homing_finds_the_edge_of_its_switch(void **state)
{
    static const struct {
        int8_t method;
        double edge;
    } rows[] = { { 17, -3.0 }, { 18, 40.0 }, { 21, 0.0 } };

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct bench b;
        unsigned ms = 0;
        double shift;

        new_drive(&b, 5);
        b.drive->o.homing_method = rows[i].method;
        b.drive->o.home_offset = 1000;
        enable(&b, DRIVE_HM);
        command(&b, 0x1f);
        assert_int_equal(b.drive->o.statusword & 0x3400, 0);
        while (!(b.drive->o.statusword & SW_MODE_12) && ms++ < 60000)
            exchange(&b, MS);
        for (unsigned k = 0; k < 500; k++)
            exchange(&b, MS);
        assert_int_equal(b.drive->o.statusword & 0x3400, 0x1400);
        /* What the drive now calls 1000 stands within the edge's search resolution of it. */
        shift = (double)(b.drive->zero + 1000) * b.drive->per_increment - rows[i].edge;
        assert_true(shift > -1e-4 && shift < 1e-4);
    }
}

static void homing_on_the_spot_and_its_failure(void **state)
{
    struct bench b;

    (void)state;
    new_drive(&b, 5);
    b.drive->o.homing_method = 37;
    enable(&b, DRIVE_HM);
    command(&b, 0x1f);
    exchange(&b, MS);
    assert_int_equal(b.drive->o.statusword & 0x3400, 0x1400);
    assert_in_range(position(&b) + 5, 0, 10);
    new_drive(&b, 5);
    b.drive->o.homing_method = 99;
    enable(&b, DRIVE_HM);
    command(&b, 0x1f);
    assert_int_equal(b.drive->o.statusword & 0x3000, 0x2000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_transition_follows_the_table),
        cmocka_unit_test(statuswords_have_the_bits_of_their_state),
        cmocka_unit_test(fault_reset_needs_a_rising_edge_and_the_cause_gone),
        cmocka_unit_test(quick_stop_with_option_2_ends_in_switch_on_disabled),
        cmocka_unit_test(a_fault_without_power_needs_no_reaction),
        cmocka_unit_test(enabling_takes_the_known_statuswords),
        cmocka_unit_test(power_on_position_comes_from_the_seed_and_lies_in_its_range),
        cmocka_unit_test(results_do_not_depend_on_how_time_is_cut),
        cmocka_unit_test(csp_follows_a_ramp_with_a_small_following_error),
        cmocka_unit_test(csp_walks_straight_between_set_points),
        cmocka_unit_test(a_jump_of_the_set_point_trips_the_following_error),
        cmocka_unit_test(the_following_error_watch_can_be_switched_off),
        cmocka_unit_test(csv_reaches_its_velocity_and_holds_it),
        cmocka_unit_test(cst_accelerates_with_torque),
        cmocka_unit_test(an_unsupported_mode_is_not_taken_over),
        cmocka_unit_test(changing_the_mode_in_motion_does_not_jolt),
        cmocka_unit_test(quick_stop_takes_its_own_deceleration),
        cmocka_unit_test(disable_operation_ramps_down_before_it_changes_the_state),
        cmocka_unit_test(disable_voltage_lets_the_axis_coast_to_a_stop),
        cmocka_unit_test(losing_op_while_enabled_is_a_communication_fault),
        cmocka_unit_test(limit_switches_and_hard_stop_hold_the_axis),
        cmocka_unit_test(pp_handshake_and_target_reached),
        cmocka_unit_test(pp_buffers_one_set_point_and_takes_another_at_once),
        cmocka_unit_test(halt_stops_profile_motion_and_release_resumes_it),
        cmocka_unit_test(homing_finds_the_edge_of_its_switch),
        cmocka_unit_test(homing_on_the_spot_and_its_failure),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
