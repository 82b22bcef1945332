/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Drives as rows: every row's dictionary, two axes, limits, faults, inputs. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "bus/bus.h"
#include "bus/bytes.h"
#include "bus/drive_device.h"
#include "bus/registers.h"

#define MS 1000000u

static const char *const rows[] = {
    "drive-cia402", "drive-cia402x2", "drive-heavy",  "drive-rotary", "drive-ideal",
    "tgz-1",        "tgz-2",          "tgz-1-native", "tgz-2-native",
};

struct bench {
    const struct device_type *type;
    struct drive_device *device;
    struct drive *drive; /* axis 1 */
    uint64_t now;
    unsigned emergencies;
    uint16_t codes[8];
    uint8_t registers[8];
};

static void note_emergency(void *to, uint16_t code, uint8_t error_register, const uint8_t own[5])
{
    struct bench *b = to;

    (void)own;
    b->codes[b->emergencies % 8] = code;
    b->registers[b->emergencies++ % 8] = error_register;
}

static void bench_open(struct bench *b, const char *type, uint64_t seed)
{
    struct device_setup setup = {
        .seed = seed, .serial = 4711, .identity = { 1, 2, 3 }, .emergency = { note_emergency, b }
    };

    memset(b, 0, sizeof *b);
    b->type = setup.type = device_type_find(type);
    assert_non_null(b->type);
    b->device = calloc(1, b->type->size);
    assert_non_null(b->device);
    b->drive = b->device->axis;
    od_reset(b->type->od, b->device);
    b->type->init(b->device, &setup);
    for (unsigned d = PDO_RX; d <= PDO_TX; d++)
        assert_int_equal(pdo_resolve(b->type->od, b->device, (enum pdo_direction)d), 0);
    b->type->state(b->device, AL_OP, 0);
}

static void bench_close(struct bench *b)
{
    free(b->device);
}

/* The objects' set points are commanded as process data would. */
static void exchange(struct bench *b)
{
    b->now += MS;
    b->type->step(b->device, b->now);
    for (unsigned i = 0; i < b->device->kind->axes; i++)
        drive_command(&b->device->axis[i], b->now);
    drive_device_report(b->device);
    b->type->od->refresh(b->device);
}

static void run(struct bench *b, unsigned ms)
{
    while (ms--)
        exchange(b);
}

static void command(struct bench *b, unsigned axis, uint16_t word)
{
    b->device->axis[axis].o.controlword = word;
    exchange(b);
}

static void enable(struct bench *b, unsigned axis, int8_t mode)
{
    struct drive *drive = &b->device->axis[axis];

    drive->o.mode = mode;
    command(b, axis, 6);
    command(b, axis, 7);
    drive->o.target_position = drive->o.position_actual;
    command(b, axis, 15);
    assert_int_equal(drive->machine.state, CIA402_OPERATION_ENABLED);
}

static uint32_t write_u32(struct bench *b, uint16_t index, uint8_t subindex, uint32_t value,
                          size_t size)
{
    uint8_t bytes[4];

    put_u32(bytes, value);
    return od_write(b->type->od, b->device, AL_PREOP, index, subindex, bytes, size);
}

static uint32_t read_u32(struct bench *b, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[4] = { 0 };
    size_t size = sizeof bytes;

    assert_int_equal(od_read(b->type->od, b->device, AL_OP, index, subindex, bytes, &size), 0);
    return get_u32(bytes);
}

/* --- rows --- */

static void every_dictionary_is_sorted_and_inside_its_device(void **state)
{
    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        const struct device_type *type = device_type_find(rows[r]);

        assert_non_null(type);
        for (size_t i = 0; i < type->od->count; i++) {
            const struct od_object *object = &type->od->objects[i];

            if (i)
                assert_true(object->index > type->od->objects[i - 1].index);
            for (unsigned k = 0; k < object->count; k++) {
                const struct od_entry *e = &object->entries[k];
                size_t bytes = (e->last - e->first + 1u) * (od_type_bits(e->type) / 8u);

                if (e->type != OD_STRING && e->offset != OD_CONST)
                    assert_true(e->offset + bytes <= type->size);
            }
        }
    }
}

static void check_list(struct bench *b, const struct sii_pdo *pdos, unsigned count, uint16_t assign)
{
    unsigned assigned = 0;

    for (unsigned i = 0; i < count; i++) {
        assert_int_equal(read_u32(b, pdos[i].index, 0), pdos[i].entry_count);
        for (unsigned k = 0; k < pdos[i].entry_count; k++) {
            const struct sii_entry *e = &pdos[i].entries[k];

            assert_int_equal(read_u32(b, pdos[i].index, (uint8_t)(k + 1)),
                             (uint32_t)e->index << 16 | (uint32_t)e->subindex << 8 | e->bits);
        }
        if (pdos[i].sm != 0xff)
            assert_int_equal(read_u32(b, assign, (uint8_t)++assigned), pdos[i].index);
    }
    assert_int_equal(read_u32(b, assign, 0), assigned);
}

static void sii_lists_and_default_mapping_are_the_same(void **state)
{
    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        struct bench b;
        const struct sii_info *sii;
        uint8_t image[SII_SIZE];

        bench_open(&b, rows[r], 1);
        sii = b.type->sii;
        assert_true(sii_build(sii, 1, 0, image) > 0);
        check_list(&b, sii->rx, sii->rx_count, 0x1c12);
        check_list(&b, sii->tx, sii->tx_count, 0x1c13);
        assert_int_equal(pdo_image(b.type->od, b.device, PDO_RX)->bits, sii->sm[2].length * 8);
        assert_int_equal(pdo_image(b.type->od, b.device, PDO_TX)->bits, sii->sm[3].length * 8);
        bench_close(&b);
    }
}

static void the_identity_object_says_what_the_sii_says(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402x2", 1);
    assert_int_equal(read_u32(&b, 0x1018, 1), 1);
    assert_int_equal(read_u32(&b, 0x1018, 2), 2);
    assert_int_equal(read_u32(&b, 0x1018, 3), 3);
    assert_int_equal(read_u32(&b, 0x1018, 4), 4711);
    bench_close(&b);
}

static void every_axis_object_stands_0x800_behind_its_twin(void **state)
{
    const struct od *od = &drive_od_x2;
    unsigned twins = 0;

    (void)state;
    for (size_t i = 0; i < od->count; i++) {
        const struct od_object *one = &od->objects[i];
        const struct od_object *two = od_find(od, (uint16_t)(one->index + 0x800));

        if (one->index < 0x2000 || drive_object_axis(one->index))
            continue;
        assert_non_null(two);
        assert_string_equal(two->name, one->name);
        assert_int_equal(two->type, one->type);
        for (unsigned k = 0; k < one->count; k++) {
            if (one->entries[k].offset != OD_CONST)
                assert_int_equal(two->entries[k].offset - one->entries[k].offset,
                                 sizeof(struct drive));
        }
        twins++;
    }
    assert_true(twins > 40);
}

/* --- machines --- */

static void a_heavy_axis_takes_longer_to_turn(void **state)
{
    static const struct {
        const char *type;
        double gain; /* rev/s in 100 ms at 50 % of rated torque: less the friction */
    } axes[] = { { "drive-cia402", 30.0 }, { "drive-heavy", 0.675 } };

    (void)state;
    for (size_t i = 0; i < 2; i++) {
        struct bench b;

        bench_open(&b, axes[i].type, 5);
        enable(&b, 0, DRIVE_CST);
        b.drive->o.target_torque = 500;
        exchange(&b);
        b.drive->axis.velocity = 0.0;
        run(&b, 100);
        assert_true(b.drive->axis.velocity > 0.95 * axes[i].gain);
        assert_true(b.drive->axis.velocity < 1.01 * axes[i].gain);
        bench_close(&b);
    }
}

static void a_rotary_axis_has_no_ends_and_finds_its_cam(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-rotary", 5);
    enable(&b, 0, DRIVE_PV);
    b.drive->o.target_velocity = 8 << 20;
    b.drive->o.acceleration = b.drive->o.deceleration = 20 << 20;
    run(&b, 20000);
    assert_true(b.drive->axis.position > 150.0);
    assert_int_equal(b.drive->o.digital_inputs & 3, 0);
    b.drive->o.target_velocity = 0;
    run(&b, 2000);
    b.drive->o.homing_acceleration = 20 << 20;
    b.drive->o.mode = DRIVE_HM;
    exchange(&b);
    command(&b, 0, 0x1f);
    run(&b, 20000);
    assert_int_equal(b.drive->o.statusword & 0x3400, 0x1400);
    /* The cam lets go at whole revolutions, and is reached half a revolution before. */
    assert_in_range((uint64_t)(b.drive->zero + 64) % (1 << 20), 0, 128);
    b.drive->axis.position = 7.499;
    axis_look(&b.drive->axis);
    assert_int_equal(b.drive->axis.switches, 0);
    b.drive->axis.position = -7.499;
    axis_look(&b.drive->axis);
    assert_int_equal(b.drive->axis.switches, AXIS_SWITCH_HOME);
    bench_close(&b);
}

static void an_ideal_axis_is_at_its_set_point_one_cycle_later(void **state)
{
    struct bench b;
    int32_t before;
    uint32_t random = 1;

    (void)state;
    bench_open(&b, "drive-ideal", 77);
    enable(&b, 0, DRIVE_CSP);
    exchange(&b);
    before = b.drive->o.target_position;
    for (unsigned i = 0; i < 2000; i++) {
        random = random * 1664525u + 1013904223u;
        b.drive->o.target_position = before + (int32_t)(random >> 12) - (1 << 19);
        exchange(&b); /* sent; the axis is where the one before was */
        assert_int_equal(b.drive->o.position_actual, before);
        assert_int_equal(b.drive->o.following_error, 0);
        before = b.drive->o.target_position;
    }
    assert_int_equal(b.drive->o.torque_actual, 0);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    bench_close(&b);
}

static void index_homing_goes_on_to_the_next_whole_revolution(void **state)
{
    static const struct {
        int8_t method;
        double place;
    } methods[] = { { 1, -2.0 }, { 2, 39.0 }, { 5, 1.0 } };

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct bench b;
        int64_t wanted;

        bench_open(&b, "drive-cia402", 3);
        b.drive->o.homing_method = methods[i].method;
        b.drive->o.home_offset = 500;
        enable(&b, 0, DRIVE_HM);
        command(&b, 0, 0x1f);
        for (unsigned k = 0; k < 120 && !(b.drive->o.statusword & SW_MODE_12); k++)
            run(&b, 1000);
        run(&b, 500);
        assert_int_equal(b.drive->o.statusword & 0x3400, 0x1400);
        wanted = (int64_t)(methods[i].place * 1048576.0) - 500;
        assert_int_equal(b.drive->zero, wanted);
        bench_close(&b);
    }
}

/* --- two axes --- */

static void axes_are_enabled_moved_and_stopped_apart(void **state)
{
    struct bench b;
    struct drive *one, *two;
    int32_t there;

    (void)state;
    bench_open(&b, "drive-cia402x2", 9);
    one = &b.device->axis[0];
    two = &b.device->axis[1];
    exchange(&b);
    assert_int_not_equal(one->o.position_actual, two->o.position_actual);
    enable(&b, 1, DRIVE_CSP);
    assert_int_equal(one->machine.state, CIA402_SWITCH_ON_DISABLED);
    there = one->o.position_actual;
    for (unsigned i = 0; i < 500; i++) {
        two->o.target_position += 2000;
        exchange(&b);
    }
    run(&b, 200);
    assert_int_equal(one->o.position_actual, there);
    assert_in_range(two->o.position_actual - two->o.target_position + 20, 0, 40);
    enable(&b, 0, DRIVE_PV);
    one->o.target_velocity = 1 << 20;
    run(&b, 300);
    command(&b, 1, 0);
    assert_int_equal(two->machine.state, CIA402_SWITCH_ON_DISABLED);
    assert_int_equal(one->machine.state, CIA402_OPERATION_ENABLED);
    assert_in_range(one->o.velocity_actual, 1000000, 1100000);
    bench_close(&b);
}

static void a_fault_of_axis_two_leaves_axis_one_and_shows_in_the_register(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402x2", 9);
    enable(&b, 0, DRIVE_CSP);
    enable(&b, 1, DRIVE_CSP);
    assert_int_equal(b.type->fault(b.device, 1, 0x2310, b.now), 0);
    run(&b, 500);
    assert_int_equal(b.device->axis[1].machine.state, CIA402_FAULT);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    assert_int_equal(read_u32(&b, 0x683f, 0), 0x2310);
    assert_int_equal(read_u32(&b, 0x603f, 0), 0);
    assert_int_equal(read_u32(&b, 0x1001, 0), 0x83);
    assert_int_equal(read_u32(&b, 0x1003, 1), 0x00012310);
    assert_int_equal(b.type->fault(b.device, 2, 0x2310, b.now), -EINVAL);
    assert_int_equal(b.type->fault(b.device, 1, 0, b.now), -EINVAL);
    command(&b, 1, 0);
    command(&b, 1, 0x80);
    assert_int_equal(b.device->axis[1].machine.state, CIA402_SWITCH_ON_DISABLED);
    assert_int_equal(read_u32(&b, 0x1001, 0), 0);
    assert_int_equal(b.emergencies, 2);
    assert_int_equal(b.codes[0], 0x2310);
    assert_int_equal(b.registers[0], 0x83);
    assert_int_equal(b.codes[1], 0);
    assert_int_equal(b.registers[1], 0);
    bench_close(&b);
}

static void two_axes_report_in_the_order_of_time_however_it_is_cut(void **state)
{
    uint32_t history[2][2];

    (void)state;
    for (unsigned cut = 0; cut < 2; cut++) {
        struct bench b;

        bench_open(&b, "drive-cia402x2", 9);
        enable(&b, 0, DRIVE_CSP);
        enable(&b, 1, DRIVE_CSP);
        b.device->axis[0].o.following_time = 30;
        for (unsigned i = 0; i < 2; i++)
            b.device->axis[i].o.target_position += 5 << 20;
        exchange(&b);
        for (unsigned k = 1; k <= 100 && cut; k++)
            b.type->step(b.device, b.now + k * MS);
        b.type->step(b.device, b.now + 100 * MS);
        history[cut][0] = read_u32(&b, 0x1003, 1);
        history[cut][1] = read_u32(&b, 0x1003, 2);
        assert_int_equal(read_u32(&b, 0x1003, 0), 2);
        bench_close(&b);
    }
    assert_int_equal(history[0][0], 0x00008611);
    assert_int_equal(history[0][1], 0x00018611);
    assert_memory_equal(history[0], history[1], sizeof history[0]);
}

/* --- faults --- */

static void a_fault_reacts_as_its_option_says(void **state)
{
    /* From 10 rev/s: coasting; 50 rev/s^2; 400 rev/s^2. */
    static const struct {
        int16_t option;
        unsigned least, most; /* ms until fault reaction is over */
    } cases[] = { { 0, 0, 1 }, { 1, 200, 260 }, { 2, 25, 90 } };

    (void)state;
    for (size_t i = 0; i < 3; i++) {
        struct bench b;
        unsigned ms = 0;

        bench_open(&b, "drive-cia402", 5);
        assert_int_equal(write_u32(&b, 0x605e, 0, (uint32_t)cases[i].option, 2), 0);
        enable(&b, 0, DRIVE_CSV);
        b.drive->o.target_velocity = 10 << 20;
        run(&b, 300);
        assert_int_equal(b.type->fault(b.device, 0, 0x3210, b.now), 0);
        assert_int_equal(b.drive->o.error_code, 0x3210);
        while (b.drive->machine.state != CIA402_FAULT && ms++ < 1000)
            exchange(&b);
        assert_in_range(ms, cases[i].least, cases[i].most);
        assert_int_equal(read_u32(&b, 0x1001, 0), 0x05);
        assert_int_equal(b.drive->o.statusword & 0x4f, 0x08);
        bench_close(&b);
    }
}

static void the_history_keeps_the_newest_eight_and_can_be_cleared(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402", 5);
    for (unsigned i = 1; i <= 10; i++) {
        b.type->fault(b.device, 0, (uint16_t)(0x4200 + i), b.now);
        command(&b, 0, 0);
        command(&b, 0, 0x80);
    }
    assert_int_equal(read_u32(&b, 0x1003, 0), 8);
    assert_int_equal(read_u32(&b, 0x1003, 1), 0x420a);
    assert_int_equal(read_u32(&b, 0x1003, 8), 0x4203);
    assert_int_equal(write_u32(&b, 0x1003, 0, 1, 1), SDO_RANGE);
    assert_int_equal(write_u32(&b, 0x1003, 1, 0, 4), SDO_READ_ONLY);
    assert_int_equal(write_u32(&b, 0x1003, 0, 0, 1), 0);
    assert_int_equal(read_u32(&b, 0x1003, 0), 0);
    bench_close(&b);
}

/* --- limits --- */

static void csp_set_points_end_at_the_software_limits(void **state)
{
    struct bench b;
    int32_t start;

    (void)state;
    bench_open(&b, "drive-cia402", 5);
    exchange(&b);
    start = b.drive->o.position_actual;
    assert_int_equal(write_u32(&b, 0x607d, 2, (uint32_t)(start + 500000), 4), 0);
    enable(&b, 0, DRIVE_CSP);
    assert_int_equal(b.drive->o.statusword & SW_INTERNAL_LIMIT, 0);
    for (unsigned i = 0; i < 400; i++) {
        b.drive->o.target_position += 2000;
        exchange(&b);
    }
    run(&b, 300);
    assert_in_range(b.drive->o.position_actual - start - 500000 + 20, 0, 40);
    assert_int_equal(b.drive->o.statusword & (SW_INTERNAL_LIMIT | SW_TARGET_REACHED),
                     SW_INTERNAL_LIMIT);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    /* And back in. */
    for (unsigned i = 0; i < 400; i++) {
        b.drive->o.target_position -= 2000;
        exchange(&b);
    }
    run(&b, 300);
    assert_in_range(b.drive->o.position_actual - start + 20, 0, 40);
    bench_close(&b);
}

static void profile_moves_and_velocities_respect_the_software_limits(void **state)
{
    struct bench b;
    int32_t start;

    (void)state;
    bench_open(&b, "drive-cia402", 5);
    exchange(&b);
    start = b.drive->o.position_actual;
    write_u32(&b, 0x607d, 1, (uint32_t)(start - (1 << 20)), 4);
    write_u32(&b, 0x607d, 2, (uint32_t)(start + (1 << 20)), 4);
    enable(&b, 0, DRIVE_PP);
    b.drive->o.target_position = start + (4 << 20);
    command(&b, 0, 0x1f);
    run(&b, 2000);
    assert_in_range(b.drive->o.position_actual - start - (1 << 20) + 512, 0, 1024);
    command(&b, 0, 0x0f);
    b.drive->o.mode = DRIVE_CSV;
    b.drive->o.target_velocity = -(2 << 20);
    run(&b, 3000);
    assert_in_range(b.drive->o.position_actual - start + (1 << 20) + 20000, 0, 20000);
    assert_in_range(b.drive->o.velocity_actual + 1000, 0, 2000);
    b.drive->o.target_velocity = 1 << 20;
    run(&b, 500);
    assert_in_range(b.drive->o.velocity_actual, 1000000, 1100000);
    bench_close(&b);
}

static void velocities_end_at_their_limits(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402", 5);
    assert_int_equal(write_u32(&b, 0x607f, 0, 2 << 20, 4), 0);
    enable(&b, 0, DRIVE_PV);
    b.drive->o.target_velocity = 8 << 20;
    run(&b, 400);
    assert_in_range(b.drive->o.velocity_demand, (2 << 20) - 1, (2 << 20) + 1);
    b.drive->o.mode = DRIVE_PP;
    exchange(&b);
    b.drive->o.target_position = b.drive->o.position_actual + (4 << 20);
    command(&b, 0, 0x1f);
    run(&b, 500);
    assert_in_range(b.drive->o.velocity_demand, (2 << 20) - 1, (2 << 20) + 1);
    run(&b, 3000);
    command(&b, 0, 0x0f);
    b.drive->o.mode = DRIVE_CSV; /* the limit of profiles does not concern it, the motor's does */
    assert_int_equal(write_u32(&b, 0x6080, 0, 240, 4), 0);
    run(&b, 400);
    assert_in_range(b.drive->o.velocity_actual, 4100000, 4 << 20);
    assert_int_equal(b.drive->o.statusword & SW_INTERNAL_LIMIT, SW_INTERNAL_LIMIT);
    bench_close(&b);
}

static void torque_is_limited_in_each_direction(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402", 5);
    enable(&b, 0, DRIVE_CST);
    assert_int_equal(write_u32(&b, 0x60e0, 0, 200, 2), 0);
    assert_int_equal(write_u32(&b, 0x60e1, 0, 300, 2), 0);
    assert_int_equal(write_u32(&b, 0x60e1, 0, 3001, 2), SDO_RANGE);
    b.drive->o.target_torque = 1000;
    run(&b, 10);
    assert_int_equal(b.drive->o.torque_actual, 200);
    b.drive->o.target_torque = -1000;
    run(&b, 10);
    assert_int_equal(b.drive->o.torque_actual, -300);
    b.drive->o.max_torque = 100;
    run(&b, 10);
    assert_int_equal(b.drive->o.torque_actual, -100);
    assert_int_equal(b.drive->o.statusword & SW_INTERNAL_LIMIT, SW_INTERNAL_LIMIT);
    bench_close(&b);
}

static void running_into_a_limit_switch_is_a_quick_stop(void **state)
{
    struct bench b;
    unsigned ms = 0;
    double met;

    (void)state;
    bench_open(&b, "drive-cia402x2", 5);
    enable(&b, 0, DRIVE_CSV);
    b.drive->o.target_velocity = -(8 << 20);
    while (b.drive->machine.state == CIA402_OPERATION_ENABLED && ms++ < 3000)
        exchange(&b);
    assert_int_equal(b.drive->machine.state, CIA402_QUICK_STOP_ACTIVE);
    met = b.drive->axis.position;
    assert_true(met <= -3.0 && met > -3.02);
    for (ms = 0; b.drive->machine.state == CIA402_QUICK_STOP_ACTIVE && ms < 1000; ms++)
        exchange(&b);
    /* 8 rev/s at 400 rev/s^2: 20 ms, 0.08 rev, and the settling of the loops. */
    assert_in_range(ms, 20, 90);
    assert_true(b.drive->axis.position < -3.06 && b.drive->axis.position > -3.2);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
    /* Further out: again; back in: allowed. */
    b.drive->o.target_velocity = 0;
    enable(&b, 0, DRIVE_CSV);
    b.drive->o.target_velocity = -(1 << 20);
    run(&b, 100);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
    b.drive->o.target_velocity = 0;
    enable(&b, 0, DRIVE_CSV);
    b.drive->o.target_velocity = 1 << 20;
    run(&b, 500);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    assert_true(b.drive->axis.position > -3.0);
    bench_close(&b);
}

static void a_standing_enable_does_not_restart_an_axis_at_its_limit(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-cia402x2", 5);
    assert_int_equal(write_u32(&b, 0x605a, 0, 6, 2), 0); /* stays in quick stop active */
    enable(&b, 0, DRIVE_CSV);
    b.drive->o.target_velocity = -(8 << 20);
    run(&b, 3000);
    assert_int_equal(b.drive->machine.state, CIA402_QUICK_STOP_ACTIVE);
    assert_in_range(b.drive->o.velocity_actual + 1000, 0, 2000);
    b.drive->o.target_velocity = 1 << 20;
    run(&b, 10);
    assert_int_equal(b.drive->machine.state, CIA402_QUICK_STOP_ACTIVE);
    command(&b, 0, 0x0b);
    command(&b, 0, 0x0f);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    bench_close(&b);
}

/* --- inputs --- */

static void inputs_can_be_held_and_let_go(void **state)
{
    struct bench b;
    int64_t value;

    (void)state;
    bench_open(&b, "drive-cia402x2", 5);
    exchange(&b);
    assert_int_equal(b.drive->o.digital_inputs, 0);
    assert_int_equal(b.type->set_input(b.device, 2, 1), 0);
    assert_int_equal(b.type->set_input(b.device, 16, 1), 0);
    assert_int_equal(b.type->set_input(b.device, 32 + 31, 1), 0);
    exchange(&b);
    assert_int_equal(b.drive->o.digital_inputs, 0x00010004);
    assert_int_equal(b.device->axis[1].o.digital_inputs, 0x80000000);
    assert_int_equal(b.type->get_input(b.device, 2, &value), 0);
    assert_int_equal(value, 1);
    assert_int_equal(b.type->get_input(b.device, 0, &value), 0);
    assert_int_equal(value, 0);
    b.type->free_input(b.device, 2);
    exchange(&b);
    assert_int_equal(b.drive->o.digital_inputs, 0x00010000);
    assert_int_equal(b.type->set_input(b.device, 3, 1), -EINVAL);
    assert_int_equal(b.type->set_input(b.device, 15, 1), -EINVAL);
    assert_int_equal(b.type->set_input(b.device, 64, 1), -EINVAL);
    assert_int_equal(b.type->set_input(b.device, 0, 2), -EINVAL);
    assert_int_equal(b.type->get_input(b.device, 64, &value), -EINVAL);
    bench_close(&b);
}

static void a_held_limit_switch_stops_the_axis(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "drive-heavy", 5);
    enable(&b, 0, DRIVE_CSV);
    b.drive->o.target_velocity = 1 << 20;
    run(&b, 500);
    assert_int_equal(b.drive->machine.state, CIA402_OPERATION_ENABLED);
    b.type->set_input(b.device, 1, 1);
    exchange(&b);
    assert_int_equal(b.drive->machine.state, CIA402_QUICK_STOP_ACTIVE);
    bench_close(&b);
}

/* --- power --- */

static void switching_on_again_keeps_the_place_and_nothing_else(void **state)
{
    struct bench b;
    double place;

    (void)state;
    bench_open(&b, "drive-cia402x2", 5);
    write_u32(&b, 0x1c12, 0, 0, 1);
    write_u32(&b, 0x605a, 0, 6, 2);
    b.type->fault(b.device, 0, 0x2310, b.now);
    place = b.drive->axis.position;
    od_reset(b.type->od, b.device);
    b.type->power_on(b.device, b.now);
    assert_true(b.drive->axis.position == place);
    assert_int_equal(b.drive->machine.state, CIA402_SWITCH_ON_DISABLED);
    assert_int_equal(read_u32(&b, 0x1c12, 0), 2);
    assert_int_equal(read_u32(&b, 0x1600, 0), 4);
    assert_int_equal(read_u32(&b, 0x605a, 0), 2);
    assert_int_equal(read_u32(&b, 0x603f, 0), 0);
    assert_int_equal(read_u32(&b, 0x1001, 0), 0);
    assert_int_equal(read_u32(&b, 0x1003, 0), 0);
    assert_int_equal(read_u32(&b, 0x1018, 4), 4711);
    bench_close(&b);
}

/* --- on the bus --- */

static void cycle(struct bus *bus, uint64_t *now)
{
    bus_receive(bus, *now);
    *now += MS / 5;
    bus_send(bus, *now);
    *now += MS - MS / 5;
}

static uint64_t get(struct bus *bus, uint16_t index)
{
    struct bus_entry e = bus_find(bus, 0, BUS_INPUT, index, 0);

    assert_int_not_equal(e.bits, 0);
    return bus_entry_get(e);
}

static void put(struct bus *bus, uint16_t index, uint64_t value)
{
    struct bus_entry e = bus_find(bus, 0, BUS_OUTPUT, index, 0);

    assert_int_not_equal(e.bits, 0);
    bus_entry_set(e, value);
}

static void both_axes_run_over_frames(void **state)
{
    static const struct bus_device devices[] = { { .type = "drive-cia402x2" } };
    static const struct bus_config config = {
        .devices = devices, .device_count = 1, .cycle_ns = MS, .seed = 4
    };
    static const uint16_t words[] = { 6, 7, 15 };
    char why[BUS_WHY];
    int32_t at[2];
    struct bus *bus;
    uint64_t now;

    (void)state;
    assert_int_equal(bus_open(&bus, &config, why), 0);
    now = bus_now(bus);
    assert_int_equal(bus_slave(bus, 0)->axes, 2);
    assert_int_equal(bus_slave(bus, 0)->output_bits, 128);
    assert_int_equal(bus_slave(bus, 0)->input_bits, 320);
    cycle(bus, &now);
    bus_request_op(bus);
    for (unsigned i = 0; i < 50; i++)
        cycle(bus, &now);
    for (unsigned w = 0; w < 3; w++) {
        for (uint16_t a = 0; a < 2; a++) {
            uint16_t base = (uint16_t)(0x6000 + 0x800 * a);

            put(bus, base + 0x60, DRIVE_CSP);
            put(bus, base + 0x40, words[w]);
            at[a] = (int32_t)get(bus, base + 0x64);
            put(bus, base + 0x7a, (uint32_t)at[a]);
        }
        for (unsigned i = 0; i < 3; i++)
            cycle(bus, &now);
    }
    for (int32_t i = 1; i <= 500; i++) {
        put(bus, 0x607a, (uint32_t)(at[0] + 3000 * i));
        put(bus, 0x687a, (uint32_t)(at[1] - 1000 * i));
        cycle(bus, &now);
    }
    for (unsigned i = 0; i < 200; i++)
        cycle(bus, &now);
    assert_in_range((int32_t)get(bus, 0x6064) - at[0] - 1500000 + 20, 0, 40);
    assert_in_range((int32_t)get(bus, 0x6864) - at[1] + 500000 + 20, 0, 40);
    assert_int_equal(get(bus, 0x6041) & 0x6f, 0x27);
    assert_int_equal(get(bus, 0x6841) & 0x6f, 0x27);
    bus_close(bus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_dictionary_is_sorted_and_inside_its_device),
        cmocka_unit_test(sii_lists_and_default_mapping_are_the_same),
        cmocka_unit_test(the_identity_object_says_what_the_sii_says),
        cmocka_unit_test(every_axis_object_stands_0x800_behind_its_twin),
        cmocka_unit_test(a_heavy_axis_takes_longer_to_turn),
        cmocka_unit_test(a_rotary_axis_has_no_ends_and_finds_its_cam),
        cmocka_unit_test(an_ideal_axis_is_at_its_set_point_one_cycle_later),
        cmocka_unit_test(index_homing_goes_on_to_the_next_whole_revolution),
        cmocka_unit_test(axes_are_enabled_moved_and_stopped_apart),
        cmocka_unit_test(a_fault_of_axis_two_leaves_axis_one_and_shows_in_the_register),
        cmocka_unit_test(two_axes_report_in_the_order_of_time_however_it_is_cut),
        cmocka_unit_test(a_fault_reacts_as_its_option_says),
        cmocka_unit_test(the_history_keeps_the_newest_eight_and_can_be_cleared),
        cmocka_unit_test(csp_set_points_end_at_the_software_limits),
        cmocka_unit_test(profile_moves_and_velocities_respect_the_software_limits),
        cmocka_unit_test(velocities_end_at_their_limits),
        cmocka_unit_test(torque_is_limited_in_each_direction),
        cmocka_unit_test(running_into_a_limit_switch_is_a_quick_stop),
        cmocka_unit_test(a_standing_enable_does_not_restart_an_axis_at_its_limit),
        cmocka_unit_test(inputs_can_be_held_and_let_go),
        cmocka_unit_test(a_held_limit_switch_stops_the_axis),
        cmocka_unit_test(switching_on_again_keeps_the_place_and_nothing_else),
        cmocka_unit_test(both_axes_run_over_frames),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
