/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The TGZ: maps, scaling, D-Modes, status, errors, emergency stop, clock. */
#include "bus_rig.h"

#include "bus/tgz.h"

#include <errno.h>

#define MS      1000000u
#define STATION 0x1001

/* Maps as the manual draws them. */
enum { OUT_POSITION = 0, OUT_CONTROL = 8, OUT_CURRENT = 12, OUT_LIMIT = 14, OUT_AXIS = 16 };
enum { IN_POSITION = 0, IN_EXTERNAL = 16, IN_STATUS = 20, IN_ANALOG = 28, IN_IQ = 32 };

/* --- a device on the bench: process data by hand --- */

struct bench {
    const struct device_type *type;
    struct tgz_device *tgz;
    uint64_t now;
    uint8_t out[TGZ_NATIVE_BYTES], in[TGZ_NATIVE_BYTES];
    size_t bytes;
    unsigned emergencies;
    uint16_t code;
    uint8_t error_register;
};

static void note_emergency(void *to, uint16_t code, uint8_t error_register, const uint8_t own[5])
{
    struct bench *b = to;

    (void)own;
    b->emergencies++;
    b->code = code;
    b->error_register = error_register;
}

static void go_op(struct bench *b)
{
    for (unsigned d = PDO_RX; d <= PDO_TX; d++)
        assert_int_equal(pdo_resolve(&tgz_od, b->tgz, (enum pdo_direction)d), 0);
    b->bytes = pdo_image(&tgz_od, b->tgz, PDO_RX)->bits / 8u;
    b->type->state(b->tgz, AL_OP, b->now);
}

static void bench_open(struct bench *b, const char *type)
{
    struct device_setup setup = { .seed = 5, .alias = 7, .emergency = { note_emergency, b } };

    memset(b, 0, sizeof *b);
    b->type = setup.type = device_type_find(type);
    assert_non_null(b->type);
    b->tgz = calloc(1, b->type->size);
    assert_non_null(b->tgz);
    od_reset(&tgz_od, b->tgz);
    b->type->init(b->tgz, &setup);
    go_op(b);
}

static void bench_close(struct bench *b)
{
    free(b->tgz);
}

static void cycle(struct bench *b)
{
    b->now += MS;
    b->type->step(b->tgz, b->now);
    b->type->inputs(b->tgz, b->in, b->bytes);
    b->type->outputs(b->tgz, b->out, b->bytes, b->now);
}

static void run(struct bench *b, unsigned ms)
{
    while (ms--)
        cycle(b);
}

static uint32_t write_object(struct bench *b, uint16_t index, uint8_t subindex, uint32_t value,
                             size_t size)
{
    uint8_t bytes[4];

    put_u32(bytes, value);
    return od_write(&tgz_od, b->tgz, AL_PREOP, index, subindex, bytes, size);
}

static uint32_t read_object(struct bench *b, uint16_t index, uint8_t subindex)
{
    uint8_t bytes[4] = { 0 };
    size_t size = sizeof bytes;

    assert_int_equal(od_read(&tgz_od, b->tgz, AL_OP, index, subindex, bytes, &size), 0);
    return get_u32(bytes);
}

static int64_t position(const struct bench *b, unsigned axis)
{
    return (int64_t)get_u64(b->in + IN_POSITION + 8 * axis);
}

static uint32_t status(const struct bench *b, unsigned axis)
{
    return get_u32(b->in + IN_STATUS + 4 * axis);
}

static void control(struct bench *b, unsigned axis, uint32_t word)
{
    put_u32(b->out + OUT_AXIS * axis + OUT_CONTROL, word);
}

static void set_position(struct bench *b, unsigned axis, int64_t value)
{
    put_u64(b->out + OUT_AXIS * axis + OUT_POSITION, (uint64_t)value);
}

static void power(struct bench *b, unsigned axis)
{
    cycle(b);
    set_position(b, axis, position(b, axis));
    control(b, axis, TGZ_CONTROL_POWER);
    run(b, 2);
    assert_int_equal(status(b, axis) & 0x7f, 0x7f);
}

/* --- native maps --- */

static void the_native_image_has_the_manuals_layout(void **state)
{
    struct bench b;
    double revolutions;

    (void)state;
    bench_open(&b, "tgz-2-native");
    assert_int_equal(b.bytes, 44);
    assert_int_equal(pdo_image(&tgz_od, b.tgz, PDO_TX)->bits, 352);
    for (unsigned axis = 0; axis < 2; axis++) {
        cycle(&b);
        revolutions = b.tgz->drive.axis[axis].axis.position;
        assert_int_equal(position(&b, axis), (int64_t)(revolutions * 4294967296.0));
        assert_int_equal(status(&b, axis), TGZ_STATUS_HARDWARE | TGZ_STATUS_NO_ERROR |
                                               TGZ_STATUS_INITIALISED | TGZ_STATUS_FIELDBUS);
    }
    b.type->set_input(b.tgz, 64, 1000);
    b.type->set_input(b.tgz, 65, 32767);
    assert_int_equal(b.type->set_input(b.tgz, 65, 32768), -EINVAL);
    assert_int_equal(b.type->set_input(b.tgz, 66, 0), -EINVAL);
    put_u16(b.out + OUT_CURRENT, 0x8001);
    put_u16(b.out + OUT_AXIS + OUT_LIMIT, 0x1234);
    set_position(&b, 1, 0x1122334455667788);
    run(&b, 2);
    assert_int_equal(get_u16(b.in + IN_ANALOG), 1000);
    assert_int_equal(get_u16(b.in + IN_ANALOG + 2), 32767);
    assert_int_equal((int32_t)read_object(&b, 0x332e, 0), -32767);
    assert_int_equal(read_object(&b, 0x342f, 0), 0x1234);
    assert_int_equal(read_object(&b, 0x342b, 0), 0x55667788);
    assert_int_equal(read_object(&b, 0x342c, 0), 0x11223344);
    assert_int_equal(read_object(&b, 0x3311, 0), get_u32(b.in + 4));
    bench_close(&b);
}

static void native_position_counts_2_to_the_32_per_revolution(void **state)
{
    static const int64_t way = 0x0000000180000000; /* one and a half */
    struct bench b;
    int64_t start[2];
    double from;

    (void)state;
    bench_open(&b, "tgz-2-native");
    power(&b, 0);
    power(&b, 1);
    start[0] = position(&b, 0);
    start[1] = position(&b, 1);
    from = b.tgz->drive.axis[0].axis.position;
    for (int i = 1; i <= 500; i++) {
        set_position(&b, 0, start[0] + way * i / 500);
        set_position(&b, 1, start[1] - way * i / 1000);
        cycle(&b);
    }
    run(&b, 300);
    assert_true(b.tgz->drive.axis[0].axis.position - from > 1.4999);
    assert_true(b.tgz->drive.axis[0].axis.position - from < 1.5001);
    assert_in_range(position(&b, 0) - start[0] - way + 100000, 0, 200000);
    assert_in_range(position(&b, 1) - start[1] + way / 2 + 100000, 0, 200000);
    /* Finer than an increment of 607A. */
    assert_true(b.tgz->drive.axis[0].demand == (double)(start[0] + way) / 4294967296.0);
    bench_close(&b);
}

static void native_speed_counts_2_to_the_32_per_rpm(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1-native");
    assert_int_equal(write_object(&b, 0x2303, 0, TGZ_MODE_SPEED, 4), 0);
    power(&b, 0);
    set_position(&b, 0, 0x000001F400000000); /* 500 rpm */
    run(&b, 500);
    assert_in_range((int32_t)read_object(&b, 0x3312, 0), 498, 500);
    assert_in_range(b.tgz->drive.axis[0].o.velocity_demand, 8738132, 8738134);
    bench_close(&b);
}

static void native_current_and_its_limit_count_in_peaks(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1-native");
    assert_int_equal(write_object(&b, 0x2303, 0, TGZ_MODE_CURRENT, 4), 0);
    power(&b, 0);
    put_u16(b.out + OUT_CURRENT, 3277); /* a tenth of 15 A */
    run(&b, 5);
    assert_int_equal(get_u16(b.in + IN_IQ), 3277);
    assert_in_range(read_object(&b, 0x3306, 0), 1499, 1501);
    assert_int_equal((int16_t)read_object(&b, 0x6077, 0), 300); /* of M-Inull */
    put_u16(b.out + OUT_CURRENT, (uint16_t)-32767);
    put_u16(b.out + OUT_LIMIT, 32767 - 3277);
    run(&b, 5);
    assert_in_range((int16_t)get_u16(b.in + IN_IQ) + 3277, 0, 12); /* limits come in 0.1 % */
    put_u16(b.out + OUT_LIMIT, 32767);
    run(&b, 5);
    assert_int_equal(get_u16(b.in + IN_IQ), 0);
    bench_close(&b);
}

static void native_status_follows_power_and_inputs(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-2-native");
    power(&b, 1);
    assert_int_equal(status(&b, 0) & TGZ_STATUS_POWER, 0);
    for (unsigned i = 0; i < 8; i++)
        assert_int_equal(b.type->set_input(b.tgz, 16 + i, 0x8d >> i & 1), 0); /* 1, 3, 4, 8 */
    cycle(&b);
    assert_int_equal(status(&b, 0) >> 28, 0x3);
    assert_int_equal(status(&b, 1) >> 28, 0xa);
    assert_int_equal(read_object(&b, 0x4000, 0), 0x8d);
    assert_int_equal(read_object(&b, 0x60fd, 0), 0x008d0000);
    assert_int_equal(read_object(&b, 0x68fd, 0) >> 16, 0x8d);
    control(&b, 0, 5u << 28);                     /* outputs 1, 5 */
    control(&b, 1, TGZ_CONTROL_POWER | 2u << 28); /* output 4 */
    cycle(&b);
    assert_int_equal(read_object(&b, 0x4001, 0), 0x19);
    control(&b, 1, 0);
    run(&b, 2);
    assert_int_equal(status(&b, 1) & (TGZ_STATUS_POWER | TGZ_STATUS_SOFTWARE | TGZ_STATUS_BRAKE),
                     0);
    bench_close(&b);
}

static void the_second_axis_of_a_one_axis_drive_is_dead(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1-native");
    control(&b, 1, TGZ_CONTROL_POWER);
    run(&b, 5);
    assert_int_equal(status(&b, 1), TGZ_STATUS_INITIALISED);
    assert_int_equal(read_object(&b, 0x6841, 0) & 0x4f, 0x08);
    assert_int_equal(write_object(&b, 0x6840, 0, 6, 2), 0);
    assert_int_equal(read_object(&b, 0x6841, 0) & 0x4f, 0x08);
    assert_int_equal(b.type->fault(b.tgz, 1, 0x8400, b.now), -EINVAL);
    assert_int_equal(b.type->set_input(b.tgz, 32, 1), -EINVAL);
    bench_close(&b);
}

/* --- CiA 402 maps --- */

static void enable_csp(struct bench *b)
{
    static const uint16_t words[] = { 6, 7, 15 };

    cycle(b);
    for (unsigned w = 0; w < 3; w++) {
        put_u32(b->out, get_u32(b->in));
        put_u16(b->out + 12, words[w]);
        cycle(b);
    }
    cycle(b);
    assert_int_equal(get_u16(b->in + 12) & 0x6f, 0x27);
}

static void the_coe_image_has_the_manuals_layout(void **state)
{
    struct bench b;
    int32_t start;

    (void)state;
    bench_open(&b, "tgz-2");
    assert_int_equal(b.bytes, 40);
    enable_csp(&b);
    start = (int32_t)get_u32(b.in);
    put_u32(b.out + 8, 0x00150000); /* outputs 1, 3, 5 */
    for (int i = 1; i <= 500; i++) {
        put_u32(b.out, (uint32_t)(start + 2000 * i));
        cycle(&b);
    }
    assert_in_range((int32_t)get_u32(b.in + 4), 1990000, 2010000); /* 606C */
    run(&b, 300);
    assert_in_range((int32_t)get_u32(b.in) - start - 1000000 + 20, 0, 40);
    assert_int_equal(read_object(&b, 0x4001, 0), 0x15);
    b.type->set_input(b.tgz, 17, 1);
    b.type->set_input(b.tgz, 65, 77);
    cycle(&b);
    assert_int_equal(get_u32(b.in + 8), 0x00020000); /* 60FD */
    assert_int_equal(get_u16(b.in + 36), 77);        /* 4002:2 */
    assert_int_equal(get_u16(b.in + 18), read_object(&b, 0x3325, 0) & 0xffff);
    assert_int_equal(get_u16(b.in + 32) & 0x4f, 0x40); /* 6841 */
    bench_close(&b);
}

static void d_mode_and_mode_must_match(void **state)
{
    static const struct {
        uint32_t d_mode;
        int8_t works[3], ignored[3];
    } cases[] = {
        { 3, { 8, 7 }, { 1, 9, 10 } },    { 6, { 3 }, { 1, 6, 8 } },
        { 7, { 1, 3, 6 }, { 8, 9, 10 } }, { 9, { 4, 10 }, { 8, 9, 1 } },
        { 10, { 9 }, { 8, 10, 3 } },
    };

    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct bench b;

        bench_open(&b, "tgz-2");
        assert_int_equal(write_object(&b, 0x2403, 0, cases[i].d_mode, 4), 0);
        for (unsigned k = 0; k < 3; k++) {
            if (cases[i].works[k]) {
                assert_int_equal(write_object(&b, 0x6860, 0, (uint8_t)cases[i].works[k], 1), 0);
                assert_int_equal(read_object(&b, 0x6861, 0), cases[i].works[k]);
            }
            assert_int_equal(write_object(&b, 0x6860, 0, (uint8_t)cases[i].ignored[k], 1), 0);
            assert_int_not_equal(read_object(&b, 0x6861, 0), cases[i].ignored[k]);
        }
        assert_int_equal(read_object(&b, 0x6061, 0), 8); /* the other axis */
        assert_int_equal(write_object(&b, 0x2403, 0, 4, 4), SDO_RANGE);
        assert_int_equal(read_object(&b, 0x6502, 0), 0x3ed);
        bench_close(&b);
    }
}

static void the_resolution_of_607a_follows_608f(void **state)
{
    struct bench b;
    double at;

    (void)state;
    bench_open(&b, "tgz-1");
    at = b.tgz->drive.axis[0].axis.position;
    assert_int_equal(read_object(&b, 0x608f, 1), 4096);
    assert_int_equal((int32_t)read_object(&b, 0x6064, 0), (int32_t)(at * 1048576.0));
    assert_int_equal(write_object(&b, 0x608f, 1, 65536, 4), 0);
    assert_int_equal((int32_t)read_object(&b, 0x6064, 0), (int32_t)(at * 65536.0));
    assert_int_equal(write_object(&b, 0x608f, 2, 65537, 4), SDO_RANGE);
    assert_int_equal(write_object(&b, 0x608f, 2, 0, 4), SDO_RANGE);
    enable_csp(&b);
    assert_int_equal(write_object(&b, 0x608f, 1, 4096, 4), SDO_DEVICE_STATE);
    bench_close(&b);
}

static void objects_the_manual_does_not_list_are_not_there(void **state)
{
    static const uint16_t absent[] = { 0x603f, 0x605a, 0x605e, 0x6072, 0x6091, 0x60b0 };
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1");
    for (size_t i = 0; i < sizeof absent / sizeof *absent; i++)
        assert_null(od_find(&tgz_od, absent[i]));
    assert_int_equal(write_object(&b, 0x1701, 0, 0, 1), SDO_READ_ONLY);
    assert_int_equal(read_object(&b, 0x200d, 0), 7);
    bench_close(&b);
}

/* --- errors --- */

static void errors_have_bits_codes_and_a_history(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-2-native");
    power(&b, 0);
    power(&b, 1);
    assert_int_equal(b.type->fault(b.tgz, 0, 0x3110, b.now), 0);
    assert_int_equal(b.emergencies, 1);
    assert_int_equal(b.code, 0x3110);
    assert_int_equal(b.error_register, 0x05);
    assert_int_equal(b.type->fault(b.tgz, 0, 0x4210, b.now), 0); /* joins it */
    assert_int_equal(b.type->fault(b.tgz, 1, 0x7303, b.now), 0);
    assert_int_equal(b.type->fault(b.tgz, 1, 0x1234, b.now), -EINVAL);
    cycle(&b);
    assert_int_equal(read_object(&b, 0x3326, 0), 1u << 3 | 1u << 11);
    assert_int_equal(read_object(&b, 0x3426, 0), 1u << 12);
    assert_int_equal(read_object(&b, 0x1001, 0), 0x01 | 0x04 | 0x08 | 0x10 | 0x80);
    assert_int_equal(read_object(&b, 0x1003, 0), 3);
    assert_int_equal(read_object(&b, 0x1003, 1), 0x0c017303);
    assert_int_equal(read_object(&b, 0x1003, 2), 0x0b004210);
    assert_int_equal(read_object(&b, 0x1003, 3), 0x03003110);
    assert_int_equal(status(&b, 0) & TGZ_STATUS_NO_ERROR, 0);
    assert_int_equal(status(&b, 0) & TGZ_STATUS_POWER, 0); /* no reaction without a mask */
    control(&b, 0, TGZ_CONTROL_CLEAR);
    run(&b, 2);
    assert_int_equal(read_object(&b, 0x3326, 0), 0);
    assert_int_equal(status(&b, 0) & TGZ_STATUS_NO_ERROR, TGZ_STATUS_NO_ERROR);
    assert_int_equal(read_object(&b, 0x1001, 0), 0x91);
    assert_int_equal(write_object(&b, 0x1003, 0, 0, 1), 0);
    assert_int_equal(read_object(&b, 0x1003, 0), 0);
    bench_close(&b);
}

static void sto_takes_the_hardware_enable_away(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1-native");
    b.type->fault(b.tgz, 0, 0x5430, b.now);
    cycle(&b);
    assert_int_equal(status(&b, 0) & TGZ_STATUS_HARDWARE, 0);
    bench_close(&b);
}

static void losing_the_host_is_error_17(void **state)
{
    struct bench b;

    (void)state;
    bench_open(&b, "tgz-1-native");
    power(&b, 0);
    b.type->state(b.tgz, AL_SAFEOP, b.now);
    assert_int_equal(read_object(&b, 0x3326, 0), 1u << 17);
    assert_int_equal(read_object(&b, 0x1003, 1), 0x11008100);
    assert_int_equal(read_object(&b, 0x1001, 0), 0x11);
    bench_close(&b);
}

static void a_step_beyond_the_motors_speed_is_a_trajectory_error(void **state)
{
    struct bench b;
    int64_t start;

    (void)state;
    bench_open(&b, "tgz-1-native");
    power(&b, 0);
    start = position(&b, 0);
    /* 6000 rpm are a tenth of a revolution per millisecond. */
    set_position(&b, 0, start + (int64_t)(0.095 * 4294967296.0));
    cycle(&b);
    assert_int_equal(read_object(&b, 0x3326, 0), 0);
    set_position(&b, 0, start + (int64_t)(0.3 * 4294967296.0));
    cycle(&b);
    assert_int_equal(read_object(&b, 0x3326, 0), 1u << 16);
    assert_int_equal(read_object(&b, 0x1003, 1), 0x10008611);
    bench_close(&b);
}

/* --- emergency stop --- */

static void turn(struct bench *b, double speed, unsigned ms)
{
    int64_t at = position(b, 0);

    for (unsigned i = 1; i <= ms; i++) {
        double now = i < 200 ? speed * i / 200 : speed;

        at += (int64_t)(now * 4294967.296);
        set_position(b, 0, at);
        cycle(b);
    }
    assert_int_equal(read_object(b, 0x3326, 0), 0);
}

/* 10 rev/s on a ramp of 3000 rpm/s = 50 rev/s^2. */
static void expect_emergency_ramp(struct bench *b, uint32_t errors)
{
    unsigned ms = 0;

    cycle(b);
    assert_int_equal(read_object(b, 0x3326, 0), errors);
    while (status(b, 0) & TGZ_STATUS_RAMP && ms++ < 1000) {
        assert_int_equal(status(b, 0) & TGZ_STATUS_POWER, TGZ_STATUS_POWER);
        cycle(b);
    }
    assert_in_range(ms, 195, 260);
    assert_int_equal(status(b, 0) & (TGZ_STATUS_RAMPED | TGZ_STATUS_POWER), TGZ_STATUS_RAMPED);
    control(b, 0, TGZ_CONTROL_CLEAR);
    run(b, 2);
    assert_int_equal(status(b, 0) & (TGZ_STATUS_RAMPED | TGZ_STATUS_NO_ERROR), TGZ_STATUS_NO_ERROR);
}

static void open_turning(struct bench *b)
{
    bench_open(b, "tgz-1-native");
    assert_int_equal(write_object(b, 0x2315, 0, 3000, 4), 0);
    power(b, 0);
    turn(b, 10.0, 500);
}

static void an_input_of_the_mask_stops_on_the_emergency_ramp(void **state)
{
    struct bench b;

    (void)state;
    open_turning(&b);
    assert_int_equal(write_object(&b, 0x2318, 0, 1u << 4, 4), 0);
    b.type->set_input(b.tgz, 16, 1); /* another */
    assert_int_equal(read_object(&b, 0x3326, 0), 0);
    b.type->set_input(b.tgz, 20, 1);
    expect_emergency_ramp(&b, 1u << 20);
    bench_close(&b);
}

static void a_masked_error_takes_the_emergency_ramp(void **state)
{
    struct bench b;

    (void)state;
    open_turning(&b);
    assert_int_equal(write_object(&b, 0x2317, 0, 1u << 9, 4), 0);
    b.type->fault(b.tgz, 0, 0x4310, b.now);
    expect_emergency_ramp(&b, 1u << 9);
    bench_close(&b);
}

static void a_guard_that_is_not_reset_stops_the_axis(void **state)
{
    struct bench b;

    (void)state;
    open_turning(&b);
    assert_int_equal(write_object(&b, 0x2319, 0, 50, 4), 0);
    for (unsigned i = 0; i < 10; i++) {
        b.type->step(b.tgz, b.now += 40 * MS);
        assert_int_equal(write_object(&b, 0x310d, 0, 0xaa55, 4), 0);
    }
    assert_int_equal(write_object(&b, 0x310d, 0, 0x1234, 4), 0);
    b.type->step(b.tgz, b.now + 49 * MS);
    assert_int_equal(b.tgz->reg[0].errors, 0);
    b.type->step(b.tgz, b.now + 51 * MS);
    assert_int_equal(b.tgz->reg[0].errors, 1u << 20);
    assert_int_equal(read_object(&b, 0x1003, 1), 0x1400f001);
    bench_close(&b);
}

static void the_emergency_stop_does_not_depend_on_how_time_is_cut(void **state)
{
    double end[2];

    (void)state;
    for (unsigned cut = 0; cut < 2; cut++) {
        struct bench b;

        open_turning(&b);
        write_object(&b, 0x2319, 0, 20, 4);
        for (unsigned k = 1; cut && k <= 700; k++)
            b.type->step(b.tgz, b.now + k * MS / 7);
        b.type->step(b.tgz, b.now + 100 * MS);
        end[cut] = b.tgz->drive.axis[0].axis.position;
        bench_close(&b);
    }
    assert_true(end[0] == end[1]);
}

/* --- distributed clock --- */

static void sync1_must_come_with_the_process_data(void **state)
{
    static const struct {
        unsigned period_ms;
        uint32_t errors;
    } cases[] = { { 1, 0 }, { 2, 1u << 17 } };

    (void)state;
    for (size_t i = 0; i < 2; i++) {
        struct bench b;

        bench_open(&b, "tgz-1-native");
        for (unsigned k = 0; k < 40; k++) {
            b.type->sync(b.tgz, 0, b.now + MS / 2);
            if (k % cases[i].period_ms == 0)
                b.type->sync(b.tgz, 1, b.now + MS / 2);
            cycle(&b);
        }
        assert_int_equal(read_object(&b, 0x200e, 0), 1000 * cases[i].period_ms);
        assert_int_equal(read_object(&b, 0x3340, 0), 1000);
        assert_int_equal(read_object(&b, 0x3326, 0), cases[i].errors);
        bench_close(&b);
    }
}

/* --- on the wire --- */

static uint32_t sdo_write(struct rig *rig, uint16_t index, uint8_t subindex, uint32_t value,
                          unsigned size)
{
    uint8_t box[32] = { 10, 0, 0, 0, 0, 0x03, 0x00, 0x20 };

    box[8] = (uint8_t)(0x23 | (4 - size) << 2);
    put_u16(box + 9, index);
    box[11] = subindex;
    put_u32(box + 12, value);
    assert_int_equal(exchange(rig, FPWR, AT(STATION, 0x1800), box, 32), 1);
    rig_wait(rig, SLAVE_MAILBOX_NS);
    memset(box, 0, sizeof box);
    assert_int_equal(exchange(rig, FPRD, AT(STATION, 0x1c00), box, 32), 1);
    assert_int_equal(get_u16(box + 9), index);
    return box[8] == 0x80 ? get_u32(box + 12) : 0;
}

static void select_map(struct rig *rig, uint16_t assign, uint16_t map)
{
    assert_int_equal(sdo_write(rig, assign, 0, 0, 1), 0);
    assert_int_equal(sdo_write(rig, assign, 1, map, 2), 0);
    assert_int_equal(sdo_write(rig, assign, 0, 1, 1), 0);
}

static uint16_t safeop(struct rig *rig, uint16_t out, uint16_t in, uint16_t acknowledge)
{
    write_sm(rig, STATION, 2, 0x1000, out, 0x64, 1);
    write_sm(rig, STATION, 3, 0x1400, in, 0x20, 1);
    return al_request(rig, STATION, AL_SAFEOP | acknowledge);
}

static void maps_chosen_in_preop_reshape_the_process_image(void **state)
{
    static const char *const types[] = { "tgz-2" };
    struct rig *rig = rig_new(types, 1);

    (void)state;
    rig_address(rig);
    write_sm(rig, STATION, 0, 0x1800, 32, 0x26, 1);
    write_sm(rig, STATION, 1, 0x1c00, 32, 0x22, 1);
    assert_int_equal(al_request(rig, STATION, AL_PREOP), AL_PREOP);
    assert_int_equal(sdo_write(rig, 0x1c12, 0, 2, 1), SDO_RANGE);
    assert_int_equal(sdo_write(rig, 0x1c12, 1, 0x1721, 2), SDO_SUB0_NOT_ZERO);
    select_map(rig, 0x1c12, TGZ_RX_NATIVE);
    assert_int_equal(safeop(rig, 40, 40, 0), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, STATION), AL_CODE_OUTPUT_CONFIG);
    assert_int_equal(safeop(rig, 44, 44, AL_ERROR), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, STATION), AL_CODE_INPUT_CONFIG);
    assert_int_equal(al_request(rig, STATION, AL_PREOP | AL_ERROR), AL_PREOP);
    select_map(rig, 0x1c13, TGZ_TX_NATIVE);
    assert_int_equal(safeop(rig, 44, 44, 0), AL_SAFEOP);
    /* Not any more. */
    assert_int_equal(sdo_write(rig, 0x1c12, 0, 0, 1), SDO_DEVICE_STATE);
    rig_free(rig);
}

static void boot_is_refused_with_code_0013(void **state)
{
    static const char *const types[] = { "tgz-1" };
    struct rig *rig = rig_new(types, 1);

    (void)state;
    rig_address(rig);
    assert_int_equal(al_request(rig, STATION, AL_BOOT), AL_INIT | AL_ERROR);
    assert_int_equal(al_code(rig, STATION), AL_CODE_NO_BOOT);
    rig_free(rig);
}

static void bus_cycle(struct bus *bus, uint64_t *now)
{
    bus_receive(bus, *now);
    *now += MS / 5;
    bus_send(bus, *now);
    *now += MS - MS / 5;
}

static void native_axes_run_over_frames_with_a_given_identity(void **state)
{
    static const struct bus_device devices[] = {
        { .type = "tgz-2-native", .identity = { 0x11, 0x22, 0x33 } },
        { .type = "tgz-2" },
    };
    static const struct bus_config config = {
        .devices = devices, .device_count = 2, .cycle_ns = MS, .seed = 4
    };
    struct bus_entry set, actual, word, shown;
    char why[BUS_WHY];
    uint32_t product = 0;
    size_t size = sizeof product;
    struct bus *bus;
    uint64_t now;
    int64_t start;

    (void)state;
    assert_int_equal(bus_open(&bus, &config, why), 0);
    assert_int_equal(bus_slave(bus, 0)->product, 0x22);
    assert_int_equal(bus_sdo_read(bus, 0, 0x1018, 2, &product, &size, NULL), 0);
    assert_int_equal(product, 0x22);
    assert_int_equal(bus_slave(bus, 0)->output_bits, 352);
    assert_int_equal(bus_slave(bus, 0)->axes, 0);
    assert_int_equal(bus_slave(bus, 1)->output_bits, 320);
    assert_int_equal(bus_slave(bus, 1)->axes, 2);
    /* Axis 2 of the native map, by its registers and by its place. */
    set = bus_bits(bus, 0, BUS_OUTPUT, OUT_AXIS * 8, 64);
    actual = bus_bits(bus, 0, BUS_INPUT, 64, 64);
    word = bus_find(bus, 0, BUS_OUTPUT, 0x342d, 0);
    shown = bus_find(bus, 0, BUS_INPUT, 0x3425, 0);
    assert_int_equal(bus_find(bus, 0, BUS_INPUT, 0x3410, 0).byte - actual.byte, 0);
    now = bus_now(bus);
    bus_cycle(bus, &now);
    bus_request_op(bus);
    for (unsigned i = 0; i < 50; i++)
        bus_cycle(bus, &now);
    start = bus_entry_sign(actual);
    bus_entry_set(set, (uint64_t)start);
    bus_entry_set(word, TGZ_CONTROL_POWER);
    for (unsigned i = 0; i < 5; i++)
        bus_cycle(bus, &now);
    assert_int_equal(bus_entry_get(shown) & 0x7f, 0x7f);
    for (int64_t i = 1; i <= 400; i++) {
        bus_entry_set(set, (uint64_t)(start + i * 10000000));
        bus_cycle(bus, &now);
    }
    for (unsigned i = 0; i < 200; i++)
        bus_cycle(bus, &now);
    assert_in_range(bus_entry_sign(actual) - start - 4000000000 + 100000, 0, 200000);
    bus_close(bus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_native_image_has_the_manuals_layout),
        cmocka_unit_test(native_position_counts_2_to_the_32_per_revolution),
        cmocka_unit_test(native_speed_counts_2_to_the_32_per_rpm),
        cmocka_unit_test(native_current_and_its_limit_count_in_peaks),
        cmocka_unit_test(native_status_follows_power_and_inputs),
        cmocka_unit_test(the_second_axis_of_a_one_axis_drive_is_dead),
        cmocka_unit_test(the_coe_image_has_the_manuals_layout),
        cmocka_unit_test(d_mode_and_mode_must_match),
        cmocka_unit_test(the_resolution_of_607a_follows_608f),
        cmocka_unit_test(objects_the_manual_does_not_list_are_not_there),
        cmocka_unit_test(errors_have_bits_codes_and_a_history),
        cmocka_unit_test(sto_takes_the_hardware_enable_away),
        cmocka_unit_test(losing_the_host_is_error_17),
        cmocka_unit_test(a_step_beyond_the_motors_speed_is_a_trajectory_error),
        cmocka_unit_test(an_input_of_the_mask_stops_on_the_emergency_ramp),
        cmocka_unit_test(a_masked_error_takes_the_emergency_ramp),
        cmocka_unit_test(a_guard_that_is_not_reset_stops_the_axis),
        cmocka_unit_test(the_emergency_stop_does_not_depend_on_how_time_is_cut),
        cmocka_unit_test(sync1_must_come_with_the_process_data),
        cmocka_unit_test(maps_chosen_in_preop_reshape_the_process_image),
        cmocka_unit_test(boot_is_refused_with_code_0013),
        cmocka_unit_test(native_axes_run_over_frames_with_a_given_identity),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
