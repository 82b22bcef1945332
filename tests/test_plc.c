/* SPDX-License-Identifier: GPL-2.0-or-later */
/* test_plc.c - load, run, stop, pause and reset of the PLC (docs/decisions.md, R1). */
#include "tests/host_rig.h"

#define LOAD  1
#define RESET 2
#define PAUSE 4
#define ERROR 8

#define CALLS(number) "DATA.U32[" #number "]"
#define CALLS_04      CALLS(16)
#define CALLS_05      CALLS(20)
#define FOUND         CALLS(24)
#define STARTS        "CAM.U32[0]"

static struct rig *open_control(const char *product)
{
    const struct host_config config = { .product = product_find(product), .resettable = true };
    struct rig *rig = rig_open("control", &config);

    rig_start(rig);
    rig_until(rig, "SERVO[0].Status", 3, 1000);
    return rig;
}

static const char *output(const struct rig *rig)
{
    return catalogue_find(4, 0) == rig->catalogue ? "DIO[0].Out0" : "DIO[0].Out[0]";
}

static void until_running(struct rig *rig)
{
    for (unsigned i = 0; i < 2000; i++) {
        if (host_plc(rig->host) == HOST_PLC_RUNNING)
            return;
        rig_cycles(rig, 1);
    }
    fail_msg("the PLC does not run: state %d", (int)host_plc(rig->host));
}

static void a_start_is_a_run(void **state)
{
    struct rig *rig = open_control("pc4");

    (void)state;
    assert_int_equal(host_plc(rig->host), HOST_PLC_RUNNING);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == 0);
    assert_true(rig_get(rig, "MAIN.PLC_Name[0]") == 'c');
    assert_true(rig_get(rig, "MAIN.PLC_Name[7]") == '_');
    assert_true(rig_get(rig, "MAIN.PLC_Name[20]") == 0);
    rig_close(rig);
}

static void run_sequence(const char *product)
{
    struct rig *rig = open_control(product);
    const double found = rig_get(rig, FOUND);

    assert_true(rig_get(rig, output(rig)) == 0x5A);
    assert_true(found != 0); /* poison */
    rig_set(rig, "DATA.U32[1000]", 17);
    rig_set(rig, "CAM.U32[100]", 18);
    host_run(rig->host);
    rig_cycles(rig, 1);

    /* Steps 1 to 4: nothing is called, and the loop runs with what was cleared. */
    double tick = rig_get(rig, "MAIN.Servo_Tick");
    assert_int_equal(host_plc(rig->host), HOST_PLC_CHANGING);
    assert_true(rig_get(rig, CALLS_04) == 0);
    assert_true(rig_get(rig, CALLS_05) == 0);
    assert_true(rig_get(rig, "DATA.U32[1000]") == 0);
    assert_true(rig_get(rig, output(rig)) == 0);
    assert_true(rig_get(rig, "SERVO[0].Mode") == 0);
    rig_cycles(rig, 15);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == tick + 15);
    assert_true(rig_get(rig, "SERVO[0].Status") == 2); /* and the drive heard of it */
    rig_cycles(rig, 10);

    /* Step 5: the loop stands. */
    tick = rig_get(rig, "MAIN.Servo_Tick");
    rig_cycles(rig, 100);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == tick);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == LOAD);

    /* Steps 6 to 8. */
    until_running(rig);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == 0);
    assert_true(rig_get(rig, STARTS) == 2);
    assert_true(rig_get(rig, "CAM.U32[100]") == 18); /* not cleared */
    assert_true(rig_get(rig, FOUND) == found);       /* the same poison */
    assert_true(rig_get(rig, CALLS_04) == 1);
    assert_int_equal(host_run_time(rig->host), 500000);
    assert_int_equal((host_time(rig->host) - 500000) % 10000000, 0);
    rig_until(rig, "SERVO[0].Status", 3, 2000);
    assert_true(rig_get(rig, "SERVO[0].EtherCATState") == 8);
    rig_close(rig);
}

static void the_run_sequence_clears_stops_loads_and_starts(void **state)
{
    (void)state;
    run_sequence("pc4");
    run_sequence("pc5");
}

static void stopped_the_loop_goes_on(void **state)
{
    struct rig *rig = open_control("pc4");

    (void)state;
    rig_set(rig, "MAIN.PLC_Ctrl", RESET); /* as another program would */
    rig_cycles(rig, 1);
    assert_int_equal(host_plc(rig->host), HOST_PLC_CHANGING);
    rig_cycles(rig, 30);
    assert_int_equal(host_plc(rig->host), HOST_PLC_STOPPED);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == 0);
    const double tick = rig_get(rig, "MAIN.Servo_Tick");
    rig_cycles(rig, 500);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == tick + 500);
    assert_true(rig_get(rig, "SERVO[0].EtherCATState") == 8);
    assert_true(rig_get(rig, CALLS_04) == 0);
    rig_set(rig, "MAIN.PLC_Ctrl", LOAD);
    rig_cycles(rig, 1);
    until_running(rig);
    assert_true(rig_get(rig, STARTS) == 2);
    rig_close(rig);
}

static void a_pause_keeps_everything(void **state)
{
    struct rig *rig = open_control("pc4");
    const double calls = rig_get(rig, CALLS_04), tick = rig_get(rig, "MAIN.Servo_Tick");

    (void)state;
    host_pause(rig->host, true);
    rig_cycles(rig, 400);
    assert_int_equal(host_plc(rig->host), HOST_PLC_PAUSED);
    assert_true(rig_get(rig, CALLS_04) == calls);
    assert_true(rig_get(rig, "MAIN.Servo_Tick") == tick + 400);
    assert_true(rig_get(rig, output(rig)) == 0x5A);
    assert_true(rig_get(rig, "SERVO[0].Status") == 3); /* the axis stays enabled */
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == PAUSE);
    host_pause(rig->host, false);
    rig_cycles(rig, 10);
    assert_int_equal(host_plc(rig->host), HOST_PLC_RUNNING);
    assert_true(rig_get(rig, CALLS_04) == calls + 10);
    assert_true(rig_get(rig, STARTS) == 1);
    rig_close(rig);
}

static void a_load_that_fails_says_so_and_can_be_repeated(void **state)
{
    struct rig *rig = open_control("pc4");

    (void)state;
    rig_set(rig, "MAIN.PLC_Name[0]", 'x');
    host_run(rig->host);
    rig_cycles(rig, 1000);
    assert_int_equal(host_plc(rig->host), HOST_PLC_ERROR);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == ERROR);
    assert_true(rig_get(rig, STARTS) == 1);

    rig_set(rig, "MAIN.PLC_Name[0]", 0); /* no name: the one there is */
    rig_set(rig, "CAM.U32[4]", 1);       /* Program_Ini refuses */
    host_run(rig->host);
    rig_cycles(rig, 1000);
    assert_int_equal(host_plc(rig->host), HOST_PLC_ERROR);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == ERROR);
    assert_true(rig_get(rig, STARTS) == 2);
    assert_true(rig_get(rig, CALLS_04) == 0);

    rig_set(rig, "CAM.U32[4]", 0);
    host_run(rig->host);
    rig_cycles(rig, 1);
    until_running(rig);
    assert_true(rig_get(rig, "MAIN.PLC_Ctrl") == 0);
    rig_close(rig);
}

static void a_function_that_failed_is_called_again_after_a_load(void **state)
{
    struct rig *rig = open_control("pc4");

    (void)state;
    rig_set(rig, "CAM.U32[8]", 1);
    rig_cycles(rig, 10);
    assert_true(rig->evidence.calls[ENTRY_04].disabled);
    assert_int_equal(rig->evidence.incident_count, 1);
    rig_set(rig, "CAM.U32[8]", 0);
    host_run(rig->host);
    rig_cycles(rig, 1);
    until_running(rig);
    rig_cycles(rig, 9);
    assert_true(rig_get(rig, CALLS_04) == 10);
    rig_close(rig);
}

/* Calls of all functions in each of the first cycles of a run. */
static void trace(struct rig *rig, uint32_t calls[100][6])
{
    for (unsigned i = 0; i < 100; i++) {
        for (unsigned k = 0; k < 6; k++) {
            char name[32];

            snprintf(name, sizeof name, "DATA.U32[%u]", 4 * k);
            calls[i][k] = (uint32_t)rig_get(rig, name);
        }
        rig_cycles(rig, 1);
    }
}

static void calls_fall_into_the_same_cycles_of_every_run(void **state)
{
    const struct host_config config = { .product = product_find("pc4") };
    struct rig *rig = rig_open("control", &config);
    static uint32_t fresh[100][6], again[100][6];

    (void)state;
    rig_start(rig);
    rig_cycles(rig, 1);
    trace(rig, fresh);
    rig_cycles(rig, 137);
    host_run(rig->host);
    rig_cycles(rig, 1);
    until_running(rig);
    trace(rig, again);
    assert_memory_equal(fresh, again, sizeof fresh);
    rig_close(rig);
}

/* --- TG Motion itself --------------------------------------------------------------------------
 */

static const char *const watched[] = { "TGM_System", "TGM_Data", "TGM_Servo", "TGM_Dio" };

/* Of whole words: memories are pages, and there are thousands of cycles of them. */
static uint64_t fingerprint(const struct rig *rig)
{
    uint64_t hash = 14695981039346656037u, word;

    for (size_t i = 0; i < sizeof watched / sizeof *watched; i++) {
        const struct catalogue_memory *memory = catalogue_memory_named(rig->catalogue, watched[i]);
        const struct catalogue_register reg = { .memory = memory };
        const unsigned char *bytes = host_register(rig->host, &reg);

        assert_int_equal(memory->size % sizeof word, 0);
        for (size_t k = 0; k < memory->size; k += sizeof word) {
            memcpy(&word, bytes + k, sizeof word);
            hash = (hash ^ word) * 1099511628211u;
            hash ^= hash >> 32;
        }
    }
    return hash;
}

#define RECORDED 3000

static void record(struct rig *rig, uint64_t *into)
{
    for (unsigned i = 0; i < RECORDED; i++) {
        rig_cycles(rig, 1);
        into[i] = fingerprint(rig);
    }
}

/* The template's module: every register of every cycle, homing and strokes and console included,
 * under a scenario. */
static void after_a_reset_everything_is_as_after_a_fresh_start(void **state)
{
    static const char script[] =
        "at 20ms unplug after 1 for 5ms\nfrom 900ms to 1s lose 10% frames seed 7\n";
    static const char played[] = "at 300ms input DIO[0] channel 3 = 1\n"
                                 "at 400ms set DATA.U32[60000] = 7\n"
                                 "after 10ms fault unplug after 1 for 20ms\n"
                                 "wait until SERVO[0].Status == 3 within 500ms\n"
                                 "repeat 3\nafter 50ms input DIO[0] channel 0 = 1\n"
                                 "after 50ms input DIO[0] channel 0 = 0\nend\n";
    struct scenario *scenario;
    char why[SCENARIO_WHY];
    assert_int_equal(
        scenario_read(&scenario, played, sizeof played - 1, "played", catalogue_find(4, 0), why),
        0);
    const struct host_config config = {
        .resettable = true, .faults = script, .faults_name = "script", .scenario = scenario
    };
    struct rig *rig = rig_open_file(TEST_TEMPLATE, &config);
    static uint64_t fresh[RECORDED], again[RECORDED];
    uint64_t faults;

    (void)state;
    rig_start(rig);
    record(rig, fresh);
    faults = rig->evidence.fault_count;
    assert_true(rig_get(rig, "DATA.U32[4]") >= 2); /* it has got somewhere */
    for (int turn = 0; turn < 2; turn++) {
        host_reset(rig->host);
        rig_cycles(rig, 2); /* it is seen when a cycle begins, and carried out before the next */
        assert_int_equal(host_cycles(rig->host), 1);
        again[0] = fingerprint(rig);
        for (unsigned i = 1; i < RECORDED; i++) {
            rig_cycles(rig, 1);
            again[i] = fingerprint(rig);
        }
        assert_memory_equal(fresh, again, sizeof fresh);
        assert_int_equal(rig->evidence.fault_count, faults * (2 + (unsigned)turn));
        assert_int_equal(rig->evidence.loads, 1 + turn);
        assert_true(host_played(rig->host));
    }
    assert_int_equal(rig->evidence.failed, 0);
    rig_close(rig);
    scenario_close(scenario);
}

static void a_fresh_host_gives_the_same_recording(void **state)
{
    const struct host_config config = { .resettable = true };
    static uint64_t fresh[RECORDED], again[RECORDED];

    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        struct rig *rig = rig_open_file(TEST_TEMPLATE, &config);

        rig_start(rig);
        record(rig, turn == 0 ? fresh : again);
        rig_close(rig);
    }
    assert_memory_equal(fresh, again, sizeof fresh);
}

static void a_command_ends_tg_motion(void **state)
{
    struct rig *rig = open_control("pc5");

    (void)state;
    rig_set(rig, "MAIN.TGM_TgMotionCmd", 0x4C4C494B);
    assert_false(host_cycle(rig->host));
    rig_close(rig);
}

static void a_command_sends_the_bus_through_init(void **state)
{
    struct rig *rig = open_control("pc5");
    bool gone = false;

    (void)state;
    rig_set(rig, "MAIN.TGM_TgMotionCmd", 0x53554252);
    for (unsigned i = 0; i < 200 && !gone; i++) {
        rig_cycles(rig, 1);
        gone = rig_get(rig, "SERVO[0].EtherCATState") < 8;
    }
    assert_true(gone);
    assert_true(rig_get(rig, "MAIN.TGM_TgMotionCmd") == 0);
    rig_until(rig, "SERVO[0].EtherCATState", 8, 4000);
    rig_until(rig, "DIO[0].EtherCATState", 8, 4000);
    assert_true(rig_get(rig, STARTS) == 1);
    rig_close(rig);
}

static void without_autostart_the_plc_waits(void **state)
{
    const struct host_config config = { .no_autostart = true };
    struct rig *rig = rig_open("control", &config);

    (void)state;
    rig_start(rig);
    rig_cycles(rig, 500);
    assert_int_equal(host_plc(rig->host), HOST_PLC_STOPPED);
    assert_true(rig_get(rig, STARTS) == 0);
    assert_true(rig_get(rig, "SERVO[0].EtherCATState") == 8);
    host_run(rig->host);
    rig_cycles(rig, 1);
    until_running(rig);
    assert_true(rig_get(rig, STARTS) == 1);
    rig_close(rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_start_is_a_run),
        cmocka_unit_test(the_run_sequence_clears_stops_loads_and_starts),
        cmocka_unit_test(stopped_the_loop_goes_on),
        cmocka_unit_test(a_pause_keeps_everything),
        cmocka_unit_test(a_load_that_fails_says_so_and_can_be_repeated),
        cmocka_unit_test(a_function_that_failed_is_called_again_after_a_load),
        cmocka_unit_test(calls_fall_into_the_same_cycles_of_every_run),
        cmocka_unit_test(after_a_reset_everything_is_as_after_a_fresh_start),
        cmocka_unit_test(a_fresh_host_gives_the_same_recording),
        cmocka_unit_test(a_command_ends_tg_motion),
        cmocka_unit_test(a_command_sends_the_bus_through_init),
        cmocka_unit_test(without_autostart_the_plc_waits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
