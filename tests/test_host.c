/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The emulated TG Motion as a module finds it, on every product. */
#include <errno.h>
#include <math.h>

#include "host/scenario.h"
#include "host/servo_wire.h"
#include "tests/host_rig.h"

static const char *const products[] = { "pc4",     "pc500",         "pc5",
                                        "tgmmini", "tgmcontroller", "tgzmotion" };

#define EACH_PRODUCT(p) for (size_t p = 0; p < sizeof products / sizeof *products; p++)

static struct rig *open_product(const char *name)
{
    const struct host_config config = { .product = product_find(name) };

    assert_non_null(config.product);
    return rig_open("idle", &config);
}

static void header_and_main_say_which_product_it_is(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        const struct product *product = product_find(products[p]);

        assert_true(rig_get(rig, "HEADER.Compatibility_Id") == product->compatibility_id);
        assert_true(rig_get(rig, "HEADER.CompatibilityMem_Id") == product->memory_id);
        assert_true(rig_get(rig, "HEADER.CompatibilityCnc_Id") == product->cnc_id);
        assert_true(rig_get(rig, "HEADER.Mem_Size_System") == 8192);
        assert_true(rig_get(rig, "MAIN.TGMotion_Version") == product->version);
        assert_true(rig_get(rig, "MAIN.Servo_SetCycleTime") == 500);
        assert_true(rig_get(rig, "MAIN.Number_Servos") == 1);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Data") == 524288);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Osc") == product->osc_bytes);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Servo") == product->max_servo * 2048);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Dio") == 32768);
        assert_true(rig_get(rig, "HEADER.Mem_Size_Interpolator") ==
                    product->max_interpolator * 16384);
        assert_true(rig_get(rig, "MAIN.Interpolator_SetCycleTime") ==
                    (product->schedule == SCHEDULE_PC ? 100 : 500));
        assert_true(rig_get(rig, "MAIN.PLC_SetCycleTime_Prg2") == product->program_period_us[1]);
        if (product->memory_id == 906)
            assert_true(rig_get(rig, "HEADER.Product_Id") == product->product_id);
        rig_close(rig);
    }
}

static void ticks_and_timers_count_by_themselves(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);

        rig_start(rig);
        rig_set(rig, "TIMERS.Timer_Down[3]", 7);
        rig_cycles(rig, 2001);
        assert_true(rig_get(rig, "MAIN.Servo_Tick") == 2001);
        assert_true(rig_get(rig, "TIMERS.Timer_Up[0]") == 1000);
        assert_true(rig_get(rig, "TIMERS.Timer_Down[3]") == 0);
        rig_close(rig);
    }
}

static void a_servo_is_enabled_and_goes_where_it_is_told(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        double target;

        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_cycles(rig, 10);
        target = rig_get(rig, "SERVO[0].Position");
        rig_set(rig, "SERVO[0].WritePosition", target);
        rig_set(rig, "SERVO[0].Mode", 1);
        rig_until(rig, "SERVO[0].Status", 3, 100);
        for (unsigned i = 0; i < 1000; i++) {
            rig_set(rig, "SERVO[0].WritePosition", target += 500);
            rig_cycles(rig, 1);
        }
        rig_cycles(rig, 200);
        assert_true(rig_get(rig, "SERVO[0].Position") > target - 50);
        assert_true(rig_get(rig, "SERVO[0].Position") < target + 50);
        rig_close(rig);
    }
}

/* Input 0 of the default machine goes on and off; generation 4 has eight bits to a word, 5 has 32.
 */
static void inputs_arrive_in_the_words_of_the_generation(void **state)
{
    (void)state;
    EACH_PRODUCT(p)
    {
        struct rig *rig = open_product(products[p]);
        const char *in = p == 0 ? "DIO[0].In0" : "DIO[0].In[0]";
        const char *out = p == 0 ? "DIO[0].Out0" : "DIO[0].Out[0]";
        bool seen[2] = { false, false };

        rig_start(rig);
        rig_until(rig, "DIO[0].Status", 1, 1000);
        rig_set(rig, out, 0xA5);
        for (unsigned i = 0; i < 1000; i++) {
            const double value = rig_get(rig, in);

            assert_true(value == 0 || value == 1);
            seen[(int)value] = true;
            rig_cycles(rig, 1);
        }
        assert_true(seen[0] && seen[1]);
        rig_close(rig);
    }
}

/* Calls of Program_01..05 in so many cycles. */
static void calls_are(const char *product, uint32_t cycle_us, uint32_t period_02, unsigned cycles,
                      const uint64_t wanted[5])
{
    const struct host_config config = { .product = product_find(product),
                                        .cycle_us = cycle_us,
                                        .program_period_us = { 0, period_02, 0 } };
    struct rig *rig = rig_open("idle", &config);

    rig_start(rig);
    rig_cycles(rig, cycles);
    for (int i = 0; i < 5; i++)
        assert_int_equal(rig->evidence.calls[ENTRY_01 + i].count, wanted[i]);
    rig_close(rig);
}

static void controllers_call_the_background_at_ticks(void **state)
{
    (void)state;
    /* 60 ms each: 300 ticks, of which every second is Program_02's, every fourth Program_03's */
    calls_are("tgmcontroller", 100, 0, 600, (const uint64_t[]){ 300, 150, 75, 600, 600 });
    calls_are("tgmcontroller", 250, 0, 240, (const uint64_t[]){ 300, 150, 75, 240, 240 });
    calls_are("tgmcontroller", 3000, 0, 20, (const uint64_t[]){ 300, 150, 75, 20, 20 });
    calls_are("tgzmotion", 10000, 0, 6, (const uint64_t[]){ 300, 150, 75, 6, 6 });
    calls_are("tgzmotion", 500, 200, 120, (const uint64_t[]){ 300, 300, 75, 120, 120 });
    calls_are("tgzmotion", 500, PERIOD_OFF, 120, (const uint64_t[]){ 300, 0, 75, 120, 120 });
}

static void a_pc_calls_the_background_in_its_slots(void **state)
{
    (void)state;
    calls_are("pc4", 500, 0, 120, (const uint64_t[]){ 6, 12, 60, 120, 600 });
    calls_are("pc500", 1000, 100, 60, (const uint64_t[]){ 6, 600, 60, 60, 600 });
    calls_are("tgmmini", 250, 0, 240, (const uint64_t[]){ 6, 12, 60, 240, 1200 });
}

static void controllers_do_without_program_05_and_read_text_of_8_bits(void **state)
{
    static const char *const both[] = { "tgmcontroller", "tgzmotion" };
    (void)state;
    for (int i = 0; i < 2; i++) {
        const struct host_config config = { .product = product_find(both[i]) };
        struct rig *rig = rig_open("five", &config);

        rig_start(rig);
        rig_cycles(rig, 10);
        assert_int_equal(rig->evidence.calls[ENTRY_04].count, 10);
        assert_int_equal(rig->evidence.calls[ENTRY_05].count, 0);
        assert_int_equal(rig->evidence.message_count, 1);
        assert_string_equal(rig->evidence.messages[0].text, "hello, \xC5\x99\x65\xC5\xA5");
        rig_close(rig);
    }
}

static void a_pc_wants_program_05(void **state)
{
    const struct machine_config machine = { .seed = 1, .hang_ns = 2000000000 };
    struct host_config config = { .product = product_find("pc5"),
                                  .cycle_us = 500,
                                  .plant = &plant_default };
    struct rig rig;
    char why[HOST_WHY];
    (void)state;
    assert_int_equal(image_open(&rig.image, TEST_HOST_MODULES_DIR "/five_906.tgm", why), 0);
    assert_int_equal(machine_load(&rig.machine, rig.image, &machine, why), 0);
    assert_int_equal(host_open(&rig.host, &config, rig.machine, rig.image, &rig.evidence, why),
                     -ENOENT);
    assert_string_equal(why, "the module does not export the function Program_05");
    machine_unload(rig.machine);
    image_close(rig.image);
}

static void memories_have_the_sizes_of_the_configuration(void **state)
{
    const struct host_config config = { .product = product_find("tgmmini"),
                                        .data_bytes = 65536,
                                        .osc_bytes = 2 * 1048576 };
    struct rig *rig = rig_open("idle", &config);
    struct catalogue_register reg;
    char why[CATALOGUE_WHY];
    (void)state;
    assert_true(rig_get(rig, "HEADER.Mem_Size_Data") == 65536);
    assert_true(rig_get(rig, "HEADER.Mem_Size_Osc") == 2 * 1048576);
    rig_set(rig, "DATA.F64[65528]", 1.5);
    assert_true(rig_get(rig, "DATA.F64[65528]") == 1.5);
    assert_int_equal(catalogue_resolve(rig->catalogue, "DATA.F64[65536]", &reg, why), 0);
    assert_null(host_register(rig->host, &reg));
    assert_int_equal(catalogue_resolve(rig->catalogue, "SERVO[63].Position", &reg, why), 0);
    assert_non_null(host_register(rig->host, &reg));
    assert_int_equal(catalogue_resolve(rig->catalogue, "SERVO[64].Position", &reg, why), 0);
    assert_null(host_register(rig->host, &reg));
    rig_close(rig);
}

/* Enables a servo, moves it by 100000 increments in 200 cycles, and comes back. */
static void servo_goes(struct rig *rig, unsigned number)
{
    char name[64], set[64];
    double begin;
#define REG(member) (snprintf(name, sizeof name, "SERVO[%u]." member, number), name)
    rig_until(rig, REG("EtherCATState"), 8, 1000);
    rig_cycles(rig, 10);
    begin = rig_get(rig, REG("Position"));
    snprintf(set, sizeof set, "SERVO[%u].WritePosition", number);
    rig_set(rig, set, begin);
    rig_set(rig, REG("Mode"), 1);
    rig_until(rig, REG("Status"), 3, 100);
    for (unsigned i = 1; i <= 200; i++) {
        rig_set(rig, set, begin + 500 * i);
        rig_cycles(rig, 1);
    }
    rig_cycles(rig, 400);
    assert_true(fabs(rig_get(rig, REG("Position")) - begin - 100000) < 50);
    assert_int_equal(rig_get(rig, REG("Status")), 3);
    rig_set(rig, REG("Mode"), 0);
    rig_until(rig, REG("Status"), 2, 100);
#undef REG
}

static void every_kind_of_drive_moves(void **state)
{
    static const struct {
        const char *device;
        uint32_t type; /* of the list of servos; 0: no list */
        unsigned axes;
        bool native;
    } rows[] = {
        { "drive-cia402", 0, 1, false },  { "drive-cia402x2", 0, 2, false },
        { "drive-ideal", 9, 1, false },   { "tgz-1", 0, 1, false },
        { "tgz-2", 0, 2, false },         { "tgz-1-native", 0, 1, true },
        { "tgz-2-native", 0, 2, true },   { "tgz-1", 9, 1, true },
        { "tgz-2-native", 99, 2, false }, { "tgz-1-native", 99, 1, false },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct bus_device device = { .type = rows[i].device };
        const struct plant plant = { .devices = &device,
                                     .device_count = 1,
                                     .servos = rows[i].axes };
        const struct host_servo servos[] = { { .type = rows[i].type, .node = 1, .axis = 1 },
                                             { .type = rows[i].type, .node = 1, .axis = 2 } };
        const struct host_config config = { .product = product_find("pc5"),
                                            .plant = &plant,
                                            .servos = rows[i].type != 0 ? servos : NULL,
                                            .servo_count = rows[i].axes };
        struct rig *rig = rig_open("idle", &config);

        rig_start(rig);
        if (strncmp(rows[i].device, "tgz", 3) == 0)
            assert_true(rig_get(rig, "SERVO[0].ResolutionBits") == 20);
        for (unsigned axis = 0; axis < rows[i].axes; axis++)
            servo_goes(rig, axis);
        /* Bit 9 is "remote" in CiA 402, and "ramp done" in the native map. */
        assert_int_equal(((int)rig_get(rig, "SERVO[0].StatusWord") & 0x200) == 0, rows[i].native);
        rig_close(rig);
    }
}

static void a_configured_resolution_is_that_of_the_registers(void **state)
{
    static const struct {
        const char *device;
        uint32_t type, resolution;
    } rows[] = { { "tgz-1", 9, 65536 }, { "tgz-1", 99, 65536 }, { "drive-cia402", 3, 1000000 } };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct bus_device device = { .type = rows[i].device };
        const struct plant plant = { .devices = &device, .device_count = 1, .servos = 1 };
        const struct host_servo servo = {
            .type = rows[i].type, .node = 1, .axis = 1, .resolution = rows[i].resolution
        };
        const struct host_config config = { .plant = &plant, .servos = &servo, .servo_count = 1 };
        struct rig *rig = rig_open("idle", &config);

        rig_start(rig);
        assert_true(rig_get(rig, "SERVO[0].Resolution") == rows[i].resolution);
        assert_true(rig_get(rig, "SERVO[0].Type") == rows[i].type);
        rig_close(rig);
    }
}

static void a_node_is_an_alias_before_it_is_a_place(void **state)
{
    const struct bus_device devices[] = { { .type = "dio-8x8" },
                                          { .type = "drive-cia402" },
                                          { .type = "drive-ideal", .alias = 2 } };
    const struct plant plant = { .devices = devices, .device_count = 3, .servos = 2, .dios = 1 };
    const struct {
        struct host_servo servo;
        size_t slave;
    } rows[] = {
        { { .type = 9, .node = 1 }, 0 },        { { .type = 9, .node = 2 }, 2 },
        { { .type = 9, .node = 3 }, 2 },        { { .type = 9, .node = 4 }, NO_SLAVE },
        { { .type = 9, .node = 0 }, NO_SLAVE }, { { .type = 91, .node = 7 }, 1 },
        { { .type = 92, .node = 2 }, 1 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        assert_int_equal(wire_slave(&plant, &rows[i].servo), rows[i].slave);
}

/* A raw position is what the drive sends; the register has it in its own increments. */
static void native_outputs_inputs_and_faults_are_in_the_servo_group(void **state)
{
    const struct bus_device device = { .type = "tgz-1-native" };
    const struct plant plant = { .devices = &device, .device_count = 1, .servos = 1 };
    const struct host_config config = {
        .product = product_find("tgzmotion"),
        .plant = &plant,
        .faults = "at 3s drive 1 fault 0x3110\n",
        .faults_name = "test",
    };
    struct rig *rig = rig_open("idle", &config);
    (void)state;
    rig_start(rig);
    servo_goes(rig, 0);
    rig_until(rig, "SERVO[0].Status", 1, 8000);
    assert_true(rig_get(rig, "SERVO[0].Error") == 0x80000000u);
    rig_until(rig, "SERVO[0].Error", 0x8, 100); /* the TGZ has no 0x603F, but its history */
    rig_set(rig, "SERVO[0].Control", 1);
    rig_until(rig, "SERVO[0].Status", 2, 100);
    rig_set(rig, "SERVO[0].DigitalOut", 5);
    rig_cycles(rig, 2);
    assert_int_equal((uint32_t)rig_get(rig, "SERVO[0].ControlWord") >> 28, 5);
    rig_close(rig);
}

static uint32_t read_sdo(struct rig *rig, uint16_t index, uint8_t subindex, uint32_t bytes)
{
    rig_set(rig, "SERVO[0].Sdo.NumberByte", bytes);
    rig_set(rig, "SERVO[0].Sdo.Index", index);
    rig_set(rig, "SERVO[0].Sdo.SubIndex", subindex);
    rig_set(rig, "SERVO[0].Sdo.Control", 2);
    rig_cycles(rig, 1);
    rig_until(rig, "SERVO[0].Sdo.Control", 0, 200);
    assert_true(rig_get(rig, "SERVO[0].Sdo.Status") == 0);
    return (uint32_t)rig_get(rig, "SERVO[0].Sdo.Data");
}

/* Over CoE, since they are not mapped; what was told is told once. */
static void digital_outputs_of_a_cia402_drive_are_in_its_object(void **state)
{
    const struct bus_device devices[] = { { .type = "drive-cia402x2" } };
    const struct plant plant = { .devices = devices, .device_count = 1, .servos = 2 };
    const struct host_config config = { .plant = &plant };
    struct rig *rig = rig_open("idle", &config);
    (void)state;
    rig_start(rig);
    rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
    assert_int_equal(read_sdo(rig, 0x60FE, 1, 4), 0);
    rig_set(rig, "SERVO[0].DigitalOut", 0x00050001);
    rig_set(rig, "SERVO[1].DigitalOut", 0x00080000);
    rig_cycles(rig, 100);
    assert_int_equal(read_sdo(rig, 0x60FE, 1, 4), 0x00050001);
    assert_int_equal(read_sdo(rig, 0x68FE, 1, 4), 0x00080000);
    rig_set(rig, "SERVO[0].DigitalOut", 0);
    rig_cycles(rig, 100);
    assert_int_equal(read_sdo(rig, 0x60FE, 1, 4), 0);
    assert_int_equal(read_sdo(rig, 0x68FE, 1, 4), 0x00080000);
    rig_close(rig);
}

/* A TGZ has six outputs and eight inputs, every other one is axis 1's, whatever its mapping. */
static void a_tgz_has_its_inputs_and_outputs_in_both_maps(void **state)
{
    static const struct {
        const char *device;
        uint32_t type;
    } rows[] = { { "tgz-2", 9 }, { "tgz-2", 99 } };
    static const char inputs[] = "input SERVO[0] bit 16 = 1\ninput SERVO[0] bit 19 = 1\n"
                                 "input SERVO[0] bit 22 = 1\n";
    char why[SCENARIO_WHY];
    struct scenario *scenario;
    assert_int_equal(
        scenario_read(&scenario, inputs, strlen(inputs), "t", catalogue_find(4, 0), why), 0);
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct bus_device device = { .type = rows[i].device };
        const struct plant plant = { .devices = &device, .device_count = 1, .servos = 2 };
        const struct host_servo servos[] = {
            { .type = rows[i].type, .node = 1, .axis = 1 },
            { .type = rows[i].type, .node = 1, .axis = 2 },
        };
        const struct host_config config = {
            .plant = &plant,
            .servos = servos,
            .servo_count = 2,
            .scenario = scenario,
        };
        struct rig *rig = rig_open("idle", &config);
        rig_start(rig);
        rig_until(rig, "SERVO[0].EtherCATState", 8, 1000);
        rig_set(rig, "SERVO[0].DigitalOut", 5); /* outputs 1 and 5 */
        rig_set(rig, "SERVO[1].DigitalOut", 2); /* output 4 */
        rig_cycles(rig, 3);
        assert_int_equal(read_sdo(rig, 0x4001, 0, 1), 0x19);
        assert_int_equal(read_sdo(rig, 0x4000, 0, 1), 0x49);
        assert_true(rig_get(rig, "SERVO[0].DigitalIn") == 0x9); /* 1 and 7 */
        assert_true(rig_get(rig, "SERVO[1].DigitalIn") == 0x2); /* 4 */
        rig_close(rig);
    }
    scenario_close(scenario);
}

/* R: what a module makes of it is gone with the next cycle, and the machine does not hear of it. */
static void a_written_position_moves_nothing(void **state)
{
    struct rig *rig = rig_open("idle", &(struct host_config){ 0 });
    (void)state;
    rig_set(rig, "SERVO[0].Position", 123456);
    rig_start(rig);
    rig_cycles(rig, 1);
    assert_true(rig_get(rig, "SERVO[0].Position") == 0);
    servo_goes(rig, 0);
    const double place = rig_get(rig, "SERVO[0].Position");
    for (int i = 0; i < 100; i++) {
        rig_set(rig, "SERVO[0].Position", 123456);
        rig_cycles(rig, 1);
        assert_true(fabs(rig_get(rig, "SERVO[0].Position") - place) < 50);
    }
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(header_and_main_say_which_product_it_is),
        cmocka_unit_test(ticks_and_timers_count_by_themselves),
        cmocka_unit_test(a_servo_is_enabled_and_goes_where_it_is_told),
        cmocka_unit_test(inputs_arrive_in_the_words_of_the_generation),
        cmocka_unit_test(controllers_call_the_background_at_ticks),
        cmocka_unit_test(a_pc_calls_the_background_in_its_slots),
        cmocka_unit_test(controllers_do_without_program_05_and_read_text_of_8_bits),
        cmocka_unit_test(a_pc_wants_program_05),
        cmocka_unit_test(memories_have_the_sizes_of_the_configuration),
        cmocka_unit_test(every_kind_of_drive_moves),
        cmocka_unit_test(a_configured_resolution_is_that_of_the_registers),
        cmocka_unit_test(a_node_is_an_alias_before_it_is_a_place),
        cmocka_unit_test(native_outputs_inputs_and_faults_are_in_the_servo_group),
        cmocka_unit_test(digital_outputs_of_a_cia402_drive_are_in_its_object),
        cmocka_unit_test(a_tgz_has_its_inputs_and_outputs_in_both_maps),
        cmocka_unit_test(a_written_position_moves_nothing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
