/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The short ways through cruising and resting drives against the general one: the same outputs,
 * cycle by cycle, into drives that may take it and into drives that may not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bus/bytes.h"
#include "bus/drive_device.h"
#include "bus/registers.h"
#include "bus/slave.h"

enum { DRIVES = 4, OUT = 8, IN = 20, LIVES = 40, CYCLES = 1500 };

struct fleet {
    struct slave *slave[DRIVES];
    struct drive_device *drive[DRIVES];
    uint8_t in[DRIVES][IN];
};

static struct fleet quick, general;
static uint64_t now, noise;

static uint32_t random_below(uint32_t limit)
{
    noise ^= noise << 13;
    noise ^= noise >> 7;
    noise ^= noise << 17;
    return (uint32_t)(noise >> 24) % limit;
}

static void fleet_init(struct fleet *f, bool may_cruise)
{
    static const char *const types[DRIVES] = { "drive-cia402", "drive-cia402", "drive-heavy",
                                               "drive-rotary" };

    memset(f->in, 0, sizeof f->in);
    for (unsigned i = 0; i < DRIVES; i++) {
        struct slave_setup setup = { .type = device_type_find(types[i]),
                                     .seed = 99 + 1000 * i,
                                     .serial = i + 1 };
        const struct device_type *type = setup.type;

        assert_non_null(type);
        setup.device = f->drive[i] = calloc(1, type->size);
        f->slave[i] = calloc(1, sizeof *f->slave[i]);
        assert_true(f->drive[i] && f->slave[i]);
        assert_int_equal(slave_init(f->slave[i], &setup), 0);
        assert_int_equal(pdo_resolve(type->od, f->drive[i], PDO_RX), 0);
        assert_int_equal(pdo_resolve(type->od, f->drive[i], PDO_TX), 0);
        type->state(f->drive[i], AL_OP, 0);
        assert_true(f->drive[i]->cruises);
        f->drive[i]->cruises = may_cruise;
        f->drive[i]->rest.allowed &= may_cruise;
    }
}

static void fleet_fini(struct fleet *f)
{
    for (unsigned i = 0; i < DRIVES; i++) {
        free(f->slave[i]);
        free(f->drive[i]);
    }
}

static void fleet_cycle(struct fleet *f, uint8_t out[DRIVES][OUT])
{
    void *devices[DRIVES];
    uint64_t at[DRIVES];

    for (unsigned i = 0; i < DRIVES; i++) {
        devices[i] = f->drive[i];
        at[i] = now + 700 * (i + 1);
    }
    drive_device_step_four(devices, at);
    for (unsigned i = 0; i < DRIVES; i++) {
        drive_device_step(f->drive[i], at[i]);
        drive_device_inputs(f->drive[i], f->in[i], IN);
        drive_device_outputs(f->drive[i], out[i], OUT, at[i]);
    }
}

#define SAME(member) assert_memory_equal(&a->member, &b->member, sizeof a->member)

static void assert_same_objects(void)
{
    for (unsigned i = 0; i < DRIVES; i++) {
        const struct drive *a = &quick.drive[i]->axis[0], *b = &general.drive[i]->axis[0];

        drive_device_refresh(quick.drive[i]);
        drive_device_refresh(general.drive[i]);
        SAME(o);
        SAME(axis);
        SAME(next_ns);
        SAME(demand);
        SAME(demand_velocity);
        SAME(target);
        SAME(steps_left);
        SAME(outside_steps);
        SAME(positioned);
        SAME(machine.state);
        SAME(machine.leaving);
        SAME(machine.reset_seen);
    }
}

/* What a master does, and now and then what it should not: jumps, stops, other modes. */
static void command(uint8_t out[OUT], const uint8_t in[IN], unsigned cycle)
{
    static const uint16_t words[] = { 0x86, 6, 7, 15 };
    uint32_t there = get_u32(in + 4);

    put_u16(out, cycle % 500 < 40 ? words[cycle % 500 / 10] : 15);
    out[2] = DRIVE_CSP;
    out[3] = (uint8_t)random_below(256);
    put_u32(out + 4, there + random_below(4000));
    switch (random_below(400)) {
    case 0:
        put_u32(out + 4, there + random_below(2000000));
        break;
    case 1:
        put_u16(out, random_below(0x10000) | (random_below(2) ? 0x0fu : 0));
        break;
    case 2:
        out[2] = (uint8_t)random_below(12);
        break;
    case 3:
        out[2] = 0;
        break;
    default:
        break;
    }
}

/* Through the service channel: windows, limits, what the machine does at a switch. */
static void write_some(void)
{
    static const struct {
        uint16_t index;
        uint8_t size;
        uint32_t value[3];
    } rows[] = {
        { 0x6065, 4, { 3000, 200000, UINT32_MAX } },
        { 0x6066, 2, { 0, 2, 50 } },
        { 0x6067, 4, { 1, 1000, 100000 } },
        { 0x6072, 2, { 300, 1000, 3000 } },
        { 0x60e0, 2, { 100, 1000, 3000 } },
        { 0x60e1, 2, { 100, 1000, 3000 } },
        { 0x2001, 1, { 0, 0, 1 } },
        { 0x605e, 2, { 0, 1, 2 } },
    };
    unsigned row = random_below(sizeof rows / sizeof *rows), i = random_below(DRIVES);
    uint8_t data[4];
    struct fleet *both[] = { &quick, &general };

    put_u32(data, rows[row].value[random_below(3)]);
    for (unsigned k = 0; k < 2; k++)
        od_write(both[k]->slave[i]->type->od, both[k]->drive[i], AL_OP, rows[row].index, 0, data,
                 rows[row].size);
}

static void cruising_drives_do_what_all_drives_do(void **state)
{
    static const uint32_t periods[] = { 250000, 1000000, 125000, 500000 };
    unsigned enabled = 0;

    (void)state;
    for (unsigned life = 0; life < LIVES; life++) {
        uint32_t period = periods[life % 4];

        noise = 0x9e3779b97f4a7c15u * (life + 1);
        now = 0;
        fleet_init(&quick, true);
        fleet_init(&general, false);
        for (unsigned cycle = 0; cycle < CYCLES; cycle++) {
            uint8_t out[DRIVES][OUT];

            now += random_below(300) ? period : 30 * period;
            for (unsigned i = 0; i < DRIVES; i++)
                command(out[i], general.in[i], cycle);
            if (random_below(50) == 0)
                write_some();
            fleet_cycle(&quick, out);
            fleet_cycle(&general, out);
            assert_memory_equal(quick.in, general.in, sizeof quick.in);
            if (random_below(8) == 0)
                assert_same_objects();
            enabled += (get_u16(general.in[0]) & 0x6f) == 0x27;
        }
        fleet_fini(&quick);
        fleet_fini(&general);
    }
    /* Or nothing would have cruised. */
    assert_true(enabled > LIVES * CYCLES / 4);
}

/* Drives that stop, fault and stand for a while, in one go and in the smallest steps there are. */
static void a_long_wait_is_as_many_short_ones(void **state)
{
    (void)state;
    noise = 0x2545f4914f6cdd1du;
    now = 0;
    fleet_init(&quick, true);
    fleet_init(&general, true);
    for (unsigned cycle = 0; cycle < 2000; cycle++) {
        uint64_t wait = random_below(4) ? 1000000 : 30000000;

        for (uint64_t passed = 0; passed < wait; passed += AXIS_STEP_NS) {
            for (unsigned i = 0; i < DRIVES; i++)
                drive_device_step(general.drive[i], now + passed);
        }
        now += wait;
        for (unsigned i = 0; i < DRIVES; i++) {
            uint8_t out[OUT];

            drive_device_step(quick.drive[i], now);
            drive_device_step(general.drive[i], now);
            drive_device_inputs(quick.drive[i], quick.in[i], IN);
            drive_device_inputs(general.drive[i], general.in[i], IN);
            command(out, general.in[i], cycle);
            /* To a stand, away from where the axis would like to be, and off. */
            if (cycle / 10 % 2)
                put_u32(out + 4, get_u32(general.in[i] + 4) + 20);
            if (random_below(20) == 0)
                put_u16(out, random_below(16));
            drive_device_outputs(quick.drive[i], out, OUT, now);
            drive_device_outputs(general.drive[i], out, OUT, now);
        }
        if (random_below(20) == 0)
            write_some();
        assert_memory_equal(quick.in, general.in, sizeof quick.in);
        assert_same_objects();
    }
    fleet_fini(&quick);
    fleet_fini(&general);
}

/* What may end a rest, at the same drive of both. */
static void disturb(uint8_t out[DRIVES][OUT])
{
    struct fleet *both[] = { &quick, &general };
    unsigned i = random_below(DRIVES), what = random_below(8);
    uint32_t value = random_below(0x10000);
    uint8_t word[4];

    put_u32(word, value & 0x8f);
    for (unsigned k = 0; k < 2; k++) {
        struct drive_device *d = both[k]->drive[i];
        const struct device_type *type = both[k]->slave[i]->type;

        if (what == 0)
            drive_device_set_input(d, value % 2 ? 17 : 2, value >> 1 & 1);
        else if (what == 1)
            drive_device_free_input(d, 2);
        else if (what == 2)
            drive_device_fault(d, 0, 0x7500, now);
        else if (what == 3)
            type->state(d, value % 2 ? AL_OP : AL_SAFEOP, now);
        else if (what == 4)
            drive_device_power_on(d, now);
        else if (what == 5)
            od_write(type->od, d, AL_OP, 0x6040, 0, word, 2);
    }
    if (what == 6)
        put_u16(out[i], (uint16_t)(value & 0x8f));
    else if (what == 7)
        out[i][random_below(OUT)] ^= 1;
    else if (what == 4)
        for (unsigned k = 0; k < 2; k++)
            both[k]->slave[i]->type->state(both[k]->drive[i], AL_OP, now);
    for (i = 0; i < DRIVES; i++)
        general.drive[i]->cruises = general.drive[i]->rest.allowed = false;
}

static void resting_drives_do_what_all_drives_do(void **state)
{
    unsigned rested = 0, ended = 0, moved = 0;

    (void)state;
    for (unsigned life = 0; life < LIVES; life++) {
        uint8_t out[DRIVES][OUT] = { 0 };

        noise = 0xd1342543de82ef95u * (life + 1);
        now = 0;
        fleet_init(&quick, true);
        fleet_init(&general, false);
        for (unsigned i = 0; i < DRIVES; i++)
            assert_true(quick.drive[i]->rest.allowed);
        for (unsigned cycle = 0; cycle < CYCLES; cycle++) {
            bool rests[DRIVES];

            now += random_below(300) ? 500000 : 15000000;
            for (unsigned i = 0; i < DRIVES; i++)
                rests[i] = quick.drive[i]->rest.on;
            /* A while of motion, then off. */
            for (unsigned i = 0; i < DRIVES && cycle % 500 <= 150; i++) {
                command(out[i], general.in[i], cycle);
                if (cycle % 500 == 150)
                    put_u16(out[i], 0);
            }
            if (random_below(20) == 0)
                disturb(out);
            fleet_cycle(&quick, out);
            fleet_cycle(&general, out);
            assert_memory_equal(quick.in, general.in, sizeof quick.in);
            for (unsigned i = 0; i < DRIVES; i++) {
                assert_false(general.drive[i]->rest.on);
                rested += quick.drive[i]->rest.on;
                ended += rests[i] && !quick.drive[i]->rest.on;
                moved += general.drive[i]->axis[0].axis.velocity != 0.0;
            }
            if (random_below(50) == 0)
                assert_same_objects();
        }
        fleet_fini(&quick);
        fleet_fini(&general);
    }
    assert_true(rested > LIVES * CYCLES && ended > LIVES * 10 && moved > LIVES * 10);
}

static void other_mappings_and_two_axes_do_not_cruise(void **state)
{
    const struct device_type *type = device_type_find("drive-cia402x2");
    struct slave_setup setup = { .type = type, .serial = 1 };
    struct slave *slave = calloc(1, sizeof *slave);
    struct drive_device *d;

    (void)state;
    assert_true(type && slave);
    setup.device = d = calloc(1, type->size);
    assert_int_equal(slave_init(slave, &setup), 0);
    assert_int_equal(pdo_resolve(type->od, d, PDO_RX), 0);
    assert_int_equal(pdo_resolve(type->od, d, PDO_TX), 0);
    type->state(d, AL_OP, 0);
    assert_false(d->cruises);
    free(d);
    setup.type = type = device_type_find("drive-cia402");
    setup.device = d = calloc(1, type->size);
    assert_int_equal(slave_init(slave, &setup), 0);
    d->assign[PDO_TX] = (struct pdo_assign){ 2, { 0x1a00, 0x1a01 } };
    assert_int_equal(pdo_resolve(type->od, d, PDO_RX), 0);
    assert_int_equal(pdo_resolve(type->od, d, PDO_TX), 0);
    type->state(d, AL_OP, 0);
    assert_false(d->cruises);
    free(d);
    free(slave);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cruising_drives_do_what_all_drives_do),
        cmocka_unit_test(a_long_wait_is_as_many_short_ones),
        cmocka_unit_test(resting_drives_do_what_all_drives_do),
        cmocka_unit_test(other_mappings_and_two_axes_do_not_cruise),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
