/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The built-in terminals: in frames, and under SOEM. */
#include "bus_rig.h"

#include "bus/bus.h"
#include "bus/library_open.h"
#include "bus/stimulus.h"

#define MS 1000000u

#define T(f) cmocka_unit_test(f)

static struct rig *rig_of(const char *type)
{
    struct rig *rig = rig_new(&type, 1);

    rig_address(rig);
    return rig;
}

static void every_built_in_terminal_can_be_listed_and_written(void **state)
{
    static const char *const names[] = { "dio-8x8", "ek1100", "di-8", "di-16",   "do-8",
                                         "do-16",   "ai-2",   "ao-2", "strain-1" };

    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char why[LIBRARY_WHY], *text = NULL;
        size_t length;
        FILE *stream = open_memstream(&text, &length);

        assert_non_null(device_type_find(names[i]));
        assert_int_equal(device_type_find(names[i])->sii->vendor, 0x5447534d);
        assert_int_equal(library_convert(names[i], stream, why), 0);
        fclose(stream);
        assert_non_null(strstr(text, names[i]));
        free(text);
    }
}

/* Sizes of the SII content follow from the PDOs alone: what a master without CoE sees. */
static void digital_terminals_have_their_sync_managers_and_pdos(void **state)
{
    static const struct {
        const char *type;
        uint16_t start;
        uint8_t control, kind, pdos, fmmu;
    } rows[] = {
        { "di-8", 0x1000, 0x00, SII_SM_INPUTS, 8, 2 },
        { "di-16", 0x1000, 0x00, SII_SM_INPUTS, 16, 2 },
        { "do-8", 0x0f00, 0x44, SII_SM_OUTPUTS, 8, 1 },
        { "do-16", 0x0f00, 0x44, SII_SM_OUTPUTS, 16, 1 },
    };

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct sii_info *sii = device_type_find(rows[i].type)->sii;
        const struct sii_pdo *pdo = rows[i].kind == SII_SM_INPUTS ? sii->tx : sii->rx;

        assert_int_equal(sii->sm_count, 1);
        assert_int_equal(sii->sm[0].start, rows[i].start);
        assert_int_equal(sii->sm[0].control, rows[i].control);
        assert_int_equal(sii->sm[0].type, rows[i].kind);
        assert_int_equal(sii->fmmu[0], rows[i].fmmu);
        assert_int_equal(sii->tx_count + sii->rx_count, rows[i].pdos);
        assert_int_equal(pdo[7].index, rows[i].kind == SII_SM_INPUTS ? 0x1a07 : 0x1607);
        assert_int_equal(pdo[7].entries[0].index, rows[i].kind == SII_SM_INPUTS ? 0x6070 : 0x7070);
        assert_int_equal(pdo[7].entries[0].bits, 1);
        assert_int_equal(sii->pdi_control, 0x0104);
    }
}

static void a_coupler_has_three_ports_and_a_whole_clock(void **state)
{
    struct rig *rig = rig_of("ek1100");
    uint8_t bytes[8] = { 0 };

    (void)state;
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_PORTS), bytes, 1), 1);
    assert_int_equal(bytes[0], 0x3b);
    assert_int_equal(read_u16(rig, 0x1001, REG_PDI_CONTROL), 0x0d00);
    assert_int_equal(read_u16(rig, 0x1001, REG_FEATURES) & FEATURE_DC, FEATURE_DC);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_DC_SYSTEM_TIME), bytes, 8), 1);
    assert_int_equal(al_request(rig, 0x1001, AL_OP), AL_OP);
    rig_free(rig);
}

static void a_terminal_measures_delays_and_has_no_system_time(void **state)
{
    struct rig *rig = rig_of("di-8");
    uint8_t bytes[8] = { 0 };

    (void)state;
    assert_int_equal(read_u16(rig, 0x1001, REG_FEATURES) & FEATURE_DC, FEATURE_DC);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_DC_PORT_TIME), bytes, 4), 1);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_DC_PORT_TIME), bytes, 4), 1);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_DC_SYSTEM_TIME), bytes, 8), 0);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_DC_RECEIVE_TIME), bytes, 8), 0);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, REG_DC_DELAY), bytes, 4), 0);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, REG_PORTS), bytes, 1), 1);
    assert_int_equal(bytes[0], 0x0a);
    rig_free(rig);
}

static void sixteen_outputs_reach_the_pins_and_drop_with_the_watchdog(void **state)
{
    struct rig *rig = rig_of("do-16");
    uint8_t out[2] = { 0x01, 0xa5 };

    (void)state;
    write_sm(rig, 0x1001, 0, 0x0f00, 2, 0x44, 1);
    assert_int_equal(al_request(rig, 0x1001, AL_OP), AL_OP);
    assert_int_equal(exchange(rig, FPWR, AT(0x1001, 0x0f00), out, 2), 1);
    assert_int_equal(read_u32(rig, 0x1001, REG_GPO), 0xa501);
    rig_wait(rig, 101 * MS);
    assert_int_equal(read_u32(rig, 0x1001, REG_GPO), 0);
    assert_int_equal(read_u16(rig, 0x1001, REG_AL_STATUS), AL_OP);
    rig_free(rig);
}

static void outputs_are_safe_outside_of_op(void **state)
{
    struct rig *rig = rig_of("do-8");
    uint8_t out = 0x5a;

    (void)state;
    write_sm(rig, 0x1001, 0, 0x0f00, 1, 0x44, 1);
    al_request(rig, 0x1001, AL_OP);
    exchange(rig, FPWR, AT(0x1001, 0x0f00), &out, 1);
    assert_int_equal(read_u32(rig, 0x1001, REG_GPO), 0x5a);
    assert_int_equal(al_request(rig, 0x1001, AL_SAFEOP), AL_SAFEOP);
    assert_int_equal(read_u32(rig, 0x1001, REG_GPO), 0);
    rig_free(rig);
}

static void several_signals_of_a_digital_input_are_or(void **state)
{
    static const struct bus_stimulus stimuli[] = {
        { .bit = 2, .kind = BUS_CONSTANT, .offset = 1 },
        { .bit = 2, .kind = BUS_CONSTANT, .offset = 1 },
        { .bit = 7, .kind = BUS_CONSTANT, .offset = 1, .phase_ns = 1000 * MS },
    };
    const struct device_type *type = device_type_find("di-8");
    struct device_setup setup = { .type = type, .stimuli = stimuli, .stimulus_count = 3 };
    void *device = calloc(1, type->size);
    uint8_t in = 0;

    (void)state;
    type->init(device, &setup);
    type->step(device, 0);
    type->inputs(device, &in, 1);
    assert_int_equal(in, 0x04);
    type->step(device, 1000 * MS);
    type->inputs(device, &in, 1);
    assert_int_equal(in, 0x84);
    free(device);
}

static void an_input_that_is_let_go_follows_its_signals_again(void **state)
{
    static const struct bus_stimulus stimulus = { .kind = BUS_CONSTANT, .offset = 50000 };
    const struct device_type *type = device_type_find("ai-2");
    struct device_setup setup = { .type = type, .stimuli = &stimulus, .stimulus_count = 1 };
    void *device = calloc(1, type->size);
    int64_t value;

    (void)state;
    type->init(device, &setup);
    type->step(device, 0);
    assert_int_equal(type->get_input(device, 0, &value), 0);
    assert_int_equal(value, 32767);
    type->set_input(device, 0, -5);
    type->set_input(device, 1, 6);
    type->step(device, 1);
    type->get_input(device, 0, &value);
    assert_int_equal(value, -5);
    type->free_input(device, 0);
    type->free_input(device, 1);
    type->step(device, 2);
    type->get_input(device, 0, &value);
    assert_int_equal(value, 32767);
    type->get_input(device, 1, &value);
    assert_int_equal(value, 0);
    assert_int_equal(type->get_input(device, 2, &value), -22);
    free(device);
}

static void inputs_hold_what_the_outside_world_sets(void **state)
{
    struct rig *rig = rig_of("di-16");
    const struct device_type *type = rig->slaves[0].type;
    uint8_t in[2] = { 0xff, 0xff };

    (void)state;
    write_sm(rig, 0x1001, 0, 0x1000, 2, 0x00, 1);
    assert_int_equal(type->set_input(rig->devices[0], 0, 1), 0);
    assert_int_equal(type->set_input(rig->devices[0], 9, 1), 0);
    assert_int_equal(type->set_input(rig->devices[0], 9, 2), -22);
    assert_int_equal(type->set_input(rig->devices[0], 16, 1), -22);
    assert_int_equal(exchange(rig, FPRD, AT(0x1001, 0x1000), in, 2), 1);
    assert_int_equal(get_u16(in), 0x0201);
    type->set_input(rig->devices[0], 0, 0);
    exchange(rig, FPRD, AT(0x1001, 0x1000), in, 2);
    assert_int_equal(get_u16(in), 0x0200);
    rig_free(rig);
}

static void signals_have_their_shapes(void **state)
{
    static const struct {
        enum bus_stimulus_kind kind;
        uint64_t at_ms;
        int64_t value;
    } rows[] = {
        { BUS_SQUARE, 0, 1100 },    { BUS_SQUARE, 499, 1100 },   { BUS_SQUARE, 500, -900 },
        { BUS_TRIANGLE, 0, 100 },   { BUS_TRIANGLE, 125, 600 },  { BUS_TRIANGLE, 250, 1100 },
        { BUS_TRIANGLE, 500, 100 }, { BUS_TRIANGLE, 750, -900 }, { BUS_RAMP, 0, -900 },
        { BUS_RAMP, 500, 100 },     { BUS_RAMP, 1000, -900 },    { BUS_SINE, 0, 100 },
        { BUS_SINE, 250, 1099 },    { BUS_SINE, 500, 100 },      { BUS_SINE, 750, -900 },
        { BUS_SINE, 1250, 1099 },   { BUS_CONSTANT, 0, 100 },    { BUS_CONSTANT, 77, 100 },
    };
    const uint64_t phase = 10 * MS;

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct bus_stimulus s = { .kind = rows[i].kind,
                                  .period_ns = 1000 * (uint64_t)MS,
                                  .phase_ns = phase,
                                  .amplitude = 1000,
                                  .offset = 100 };

        assert_int_equal(stimulus_value(&s, 1, phase + rows[i].at_ms * MS), rows[i].value);
        assert_int_equal(stimulus_value(&s, 1, phase - 1), s.kind == BUS_CONSTANT ? 0 : 100);
    }
}

static void a_sine_is_one_to_the_fifth_digit(void **state)
{
    static const int64_t thousandths[] = {
        0, 309017, 587785, 809017, 951057, 1000000
    }; /* sin(k 18 degrees) * 10^6 */
    struct bus_stimulus s = { .kind = BUS_SINE, .period_ns = 20 * MS, .amplitude = 1000000 };

    (void)state;
    for (unsigned k = 0; k < 6; k++) {
        assert_in_range(stimulus_value(&s, 0, k * MS) + 2, (uint64_t)thousandths[k],
                        (uint64_t)thousandths[k] + 4);
        assert_in_range(-stimulus_value(&s, 0, (10 + k) * MS) + 2, (uint64_t)thousandths[k],
                        (uint64_t)thousandths[k] + 4);
    }
}

static void noise_follows_the_seed_and_stays_within_its_amplitude(void **state)
{
    struct bus_stimulus s = {
        .kind = BUS_NOISE, .period_ns = MS, .amplitude = 500, .offset = 1000
    };
    int64_t least = INT64_MAX, most = INT64_MIN;
    unsigned same = 0;

    (void)state;
    for (unsigned i = 0; i < 1000; i++) {
        int64_t value = stimulus_value(&s, 1, i * (uint64_t)MS);

        assert_int_equal(value, stimulus_value(&s, 1, i * (uint64_t)MS + MS - 1));
        same += value == stimulus_value(&s, 2, i * (uint64_t)MS);
        least = value < least ? value : least;
        most = value > most ? value : most;
    }
    assert_in_range(least, 500, 520);
    assert_in_range(most, 1480, 1500);
    assert_true(same < 20);
}

static void the_next_change_is_never_missed(void **state)
{
    static const enum bus_stimulus_kind kinds[] = { BUS_SQUARE, BUS_NOISE, BUS_CONSTANT };

    (void)state;
    for (size_t k = 0; k < 3; k++) {
        struct bus_stimulus s = {
            .kind = kinds[k], .period_ns = 7, .phase_ns = 20, .amplitude = 5, .offset = 9
        };

        for (uint64_t now = 0; now < 100; now++) {
            uint64_t next = stimulus_next(&s, now);

            assert_true(next > now);
            for (uint64_t t = now; t < next && t < 100; t++)
                assert_int_equal(stimulus_value(&s, 3, t), stimulus_value(&s, 3, now));
        }
    }
}

/* --- under SOEM ----------------------------------------------------------------------------------
 */

struct plant {
    struct bus *bus;
    uint64_t now;
};

static int cycle(struct plant *p)
{
    int wkc = bus_receive(p->bus, p->now);

    p->now += MS / 5;
    bus_send(p->bus, p->now);
    p->now += MS - MS / 5;
    return wkc;
}

static void plant_open(struct plant *p, const struct bus_device *devices, size_t count)
{
    struct bus_config config = {
        .devices = devices, .device_count = count, .cycle_ns = MS, .seed = 5
    };
    char why[BUS_WHY];
    unsigned in_op = 0;

    if (bus_open(&p->bus, &config, why))
        fail_msg("%s", why);
    p->now = bus_now(p->bus);
    cycle(p);
    bus_request_op(p->bus);
    for (unsigned i = 0; i < 200 && in_op < count; i++) {
        cycle(p);
        bus_poll_states(p->bus);
        in_op = 0;
        for (size_t s = 0; s < count; s++)
            in_op += bus_slave(p->bus, s)->al_state == AL_OP;
    }
    assert_int_equal(in_op, count);
}

static void settle(struct plant *p)
{
    for (unsigned i = 0; i < 4; i++)
        cycle(p);
}

static void a_coupler_with_every_terminal_reaches_op(void **state)
{
    static const struct bus_device devices[] = {
        { .type = "ek1100" }, { .type = "di-8" },     { .type = "di-16" },
        { .type = "do-8" },   { .type = "do-16" },    { .type = "ai-2" },
        { .type = "ao-2" },   { .type = "strain-1" }, { .type = "dio-8x8" },
    };
    static const unsigned out[] = { 0, 0, 0, 8, 16, 0, 32, 0, 8 };
    static const unsigned in[] = { 0, 8, 16, 0, 0, 48, 0, 48, 8 };
    struct plant p;

    (void)state;
    plant_open(&p, devices, 9);
    for (size_t i = 0; i < 9; i++) {
        assert_int_equal(bus_slave(p.bus, i)->output_bits, out[i]);
        assert_int_equal(bus_slave(p.bus, i)->input_bits, in[i]);
        assert_int_equal(bus_slave(p.bus, i)->axes, 0);
    }
    for (unsigned i = 0; i < 300; i++)
        assert_int_equal(cycle(&p), bus_expected_wkc(p.bus));
    bus_close(p.bus);
}

static void analog_values_go_in_and_out(void **state)
{
    static const struct bus_device devices[] = { { .type = "ek1100" },
                                                 { .type = "ai-2" },
                                                 { .type = "ao-2" } };
    struct plant p;
    struct bus_entry value, status, out;
    uint8_t bytes[2];
    size_t size = sizeof bytes;

    (void)state;
    plant_open(&p, devices, 3);
    value = bus_find(p.bus, 1, BUS_INPUT, 0x3102, 2);
    status = bus_find(p.bus, 1, BUS_INPUT, 0x3102, 1);
    out = bus_find(p.bus, 2, BUS_OUTPUT, 0x3002, 1);
    assert_int_equal(value.bits, 16);
    assert_int_equal(out.bits, 16);
    assert_int_equal(bus_set_input(p.bus, 1, 1, -1234), 0);
    bus_entry_set(out, 0x4321);
    settle(&p);
    assert_int_equal(bus_entry_sign(value), -1234);
    assert_int_equal(bus_entry_get(status), 0);
    assert_int_equal(bus_sdo_read(p.bus, 2, 0x3002, 1, bytes, &size, NULL), 0);
    assert_int_equal(get_u16(bytes), 0x4321);
    p.now = bus_now(p.bus);
    bus_set_input(p.bus, 1, 1, 40000);
    settle(&p);
    assert_int_equal(bus_entry_sign(value), 32767);
    assert_int_equal(bus_entry_get(status), 0x42);
    bus_set_input(p.bus, 1, 1, -40000);
    settle(&p);
    assert_int_equal(bus_entry_sign(value), -32768);
    assert_int_equal(bus_entry_get(status), 0x41);
    assert_int_equal(bus_set_input(p.bus, 1, 2, 0), -22);
    assert_int_equal(bus_set_input(p.bus, 2, 0, 0), -22);
    bus_close(p.bus);
}

static void a_strain_gauge_maps_single_bits_over_coe(void **state)
{
    static const struct bus_device devices[] = { { .type = "strain-1" } };
    struct plant p;
    struct bus_entry value, over, error;

    (void)state;
    plant_open(&p, devices, 1);
    value = bus_find(p.bus, 0, BUS_INPUT, 0x6000, 0x11);
    over = bus_find(p.bus, 0, BUS_INPUT, 0x6000, 2);
    error = bus_find(p.bus, 0, BUS_INPUT, 0x6000, 4);
    assert_int_equal(value.bits, 32);
    assert_int_equal(over.bits, 1);
    assert_int_equal(error.bit - over.bit, 2);
    bus_set_input(p.bus, 0, 0, -100000);
    settle(&p);
    assert_int_equal(bus_entry_sign(value), -100000);
    assert_int_equal(bus_entry_get(over), 0);
    bus_set_input(p.bus, 0, 0, INT64_C(1) << 40);
    settle(&p);
    assert_int_equal(bus_entry_sign(value), INT32_MAX);
    assert_int_equal(bus_entry_get(over), 1);
    assert_int_equal(bus_entry_get(error), 1);
    bus_close(p.bus);
}

static void a_lost_master_makes_analog_outputs_safe_and_leaves_op(void **state)
{
    static const struct bus_device devices[] = { { .type = "ao-2" } };
    struct plant p;
    uint8_t bytes[2];
    size_t size = sizeof bytes;

    (void)state;
    plant_open(&p, devices, 1);
    bus_entry_set(bus_find(p.bus, 0, BUS_OUTPUT, 0x3001, 1), 1000);
    settle(&p);
    p.now += 150 * MS;
    bus_receive(p.bus, p.now);
    bus_poll_states(p.bus);
    cycle(&p);
    cycle(&p);
    assert_int_equal(bus_slave(p.bus, 0)->al_state, AL_SAFEOP | AL_ERROR);
    assert_int_equal(bus_slave(p.bus, 0)->al_code, AL_CODE_WATCHDOG);
    assert_int_equal(bus_sdo_read(p.bus, 0, 0x3001, 1, bytes, &size, NULL), 0);
    assert_int_equal(get_u16(bytes), 0);
    bus_close(p.bus);
}

static void stimuli_drive_analog_inputs_in_bus_time(void **state)
{
    static const struct bus_stimulus stimuli[] = {
        { .bit = 0, .kind = BUS_RAMP, .period_ns = 1000 * MS, .amplitude = 10000 },
        { .bit = 1, .kind = BUS_CONSTANT, .offset = 321 },
        { .bit = 1, .kind = BUS_CONSTANT, .offset = -21 },
    };
    static const struct bus_device devices[] = { {
        .type = "ai-2",
        .stimuli = stimuli,
        .stimulus_count = 3,
    } };
    struct plant p;
    struct bus_entry ramp;
    int64_t before;

    (void)state;
    plant_open(&p, devices, 1);
    ramp = bus_find(p.bus, 0, BUS_INPUT, 0x3101, 2);
    settle(&p);
    assert_int_equal(bus_entry_sign(bus_find(p.bus, 0, BUS_INPUT, 0x3102, 2)), 300);
    before = bus_entry_sign(ramp);
    for (unsigned i = 0; i < 100; i++)
        cycle(&p);
    assert_in_range(bus_entry_sign(ramp) - before, 1999, 2001);
    bus_close(p.bus);
}

static uint32_t write_sdo(struct plant *p, uint16_t index, uint8_t subindex, uint32_t value,
                          size_t size)
{
    uint8_t bytes[4];
    uint32_t abort = 0;

    put_u32(bytes, value);
    bus_sdo_write(p->bus, 0, index, subindex, bytes, size, &abort);
    return abort;
}

static void the_dictionary_keeps_its_ranges_and_access(void **state)
{
    static const struct bus_device devices[] = {
        { .type = "ai-2", .identity = { 0x1234, 0x5678, 9 } },
    };
    struct plant p;
    uint8_t bytes[4];
    size_t size = 4;

    (void)state;
    plant_open(&p, devices, 1);
    assert_int_equal(write_sdo(&p, 0x8000, 2, 8, 2), 0);
    assert_int_equal(write_sdo(&p, 0x8000, 2, 9, 2), SDO_RANGE);
    assert_int_equal(write_sdo(&p, 0x8000, 1, 2, 1), SDO_RANGE);
    assert_int_equal(write_sdo(&p, 0x3101, 2, 1, 2), SDO_READ_ONLY);
    assert_int_equal(write_sdo(&p, 0x1a00, 1, 1, 4), SDO_READ_ONLY);
    assert_int_equal(write_sdo(&p, 0x1c13, 0, 0, 1), SDO_DEVICE_STATE);
    assert_int_equal(bus_sdo_read(p.bus, 0, 0x1018, 2, bytes, &size, NULL), 0);
    assert_int_equal(get_u32(bytes), 0x5678);
    bus_close(p.bus);
}

static void put(struct rig *rig, uint8_t subindex, uint16_t value, size_t size, uint32_t abort)
{
    uint8_t bytes[2];

    put_u16(bytes, value);
    assert_int_equal(
        od_write(rig->slaves[0].type->od, rig->devices[0], AL_PREOP, 0x1c13, subindex, bytes, size),
        abort);
}

/* The channels without their status: what a master assigns that wants 16 bits a channel. */
static void another_assignment_gives_another_image(void **state)
{
    struct rig *rig = rig_of("ai-2");
    const struct od *od = rig->slaves[0].type->od;
    uint8_t in[4] = { 0 };

    (void)state;
    put(rig, 1, 0x1a10, 2, SDO_SUB0_NOT_ZERO);
    put(rig, 0, 0, 1, SDO_OK);
    put(rig, 1, 0x1a12, 2, SDO_RANGE);
    put(rig, 1, 0x1a11, 2, SDO_OK);
    put(rig, 2, 0x1a10, 2, SDO_OK);
    put(rig, 0, 5, 1, SDO_RANGE);
    put(rig, 0, 2, 1, SDO_OK);
    assert_int_equal(pdo_resolve(od, rig->devices[0], PDO_TX), 0);
    assert_int_equal(pdo_image(od, rig->devices[0], PDO_TX)->bits, 32);
    rig->slaves[0].type->set_input(rig->devices[0], 0, 0x1111);
    rig->slaves[0].type->set_input(rig->devices[0], 1, 0x2222);
    rig->slaves[0].type->inputs(rig->devices[0], in, 4);
    assert_int_equal(get_u32(in), 0x11112222);
    put(rig, 0, 0, 1, SDO_OK);
    put(rig, 2, 0x1a11, 2, SDO_OK);
    put(rig, 3, 0x1a00, 2, SDO_OK);
    put(rig, 4, 0x1a00, 2, SDO_OK);
    put(rig, 0, 4, 1, SDO_OK);
    assert_int_equal(pdo_resolve(od, rig->devices[0], PDO_TX), AL_CODE_INPUT_MAPPING);
    rig_free(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(every_built_in_terminal_can_be_listed_and_written),
        T(digital_terminals_have_their_sync_managers_and_pdos),
        T(a_coupler_has_three_ports_and_a_whole_clock),
        T(a_terminal_measures_delays_and_has_no_system_time),
        T(sixteen_outputs_reach_the_pins_and_drop_with_the_watchdog),
        T(outputs_are_safe_outside_of_op),
        T(several_signals_of_a_digital_input_are_or),
        T(an_input_that_is_let_go_follows_its_signals_again),
        T(inputs_hold_what_the_outside_world_sets),
        T(signals_have_their_shapes),
        T(a_sine_is_one_to_the_fifth_digit),
        T(noise_follows_the_seed_and_stays_within_its_amplitude),
        T(the_next_change_is_never_missed),
        T(a_coupler_with_every_terminal_reaches_op),
        T(analog_values_go_in_and_out),
        T(a_strain_gauge_maps_single_bits_over_coe),
        T(a_lost_master_makes_analog_outputs_safe_and_leaves_op),
        T(stimuli_drive_analog_inputs_in_bus_time),
        T(another_assignment_gives_another_image),
        T(the_dictionary_keeps_its_ranges_and_access),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
