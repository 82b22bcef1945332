/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Scenarios played around a module (tests/host_modules/echo.c), on every product: what acts when,
 * what is judged when, and what is told of it. */
#include "tests/host_rig.h"

#include "host/scenario.h"

static const struct bus_device devices[] = { { .type = "drive-cia402" }, { .type = "dio-8x8" } };
static const struct plant quiet = { .devices = devices, .device_count = 2, .servos = 1, .dios = 1 };

static const char *const products[] = { "pc4", "pc5" };

struct stage {
    struct rig *rig;
    struct scenario *scenario;
};

static struct scenario *read_for(const struct product *product, const char *text)
{
    struct scenario *scenario;
    char why[SCENARIO_WHY];
    const struct catalogue *catalogue =
        catalogue_find(product->generation, (int)product->memory_id);
    if (scenario_read(&scenario, text, strlen(text), "t", catalogue, why) != 0)
        fail_msg("%s", why);
    return scenario;
}

static struct stage open_on(const char *name, const char *text)
{
    const struct product *product = product_find(name);
    struct stage stage = { .scenario = read_for(product, text) };
    const struct host_config config = { .product = product,
                                        .plant = &quiet,
                                        .scenario = stage.scenario };
    stage.rig = rig_open("echo", &config);
    rig_start(stage.rig);
    return stage;
}

static void close_stage(struct stage *stage)
{
    rig_close(stage->rig);
    scenario_close(stage->scenario);
}

/* To its end, in no more cycles than it says. Returns how many they were. */
static uint64_t play_out(struct stage *stage)
{
    const uint64_t most = scenario_cycles(stage->scenario, 500);
    uint64_t cycles = 0;
    while (!host_played(stage->rig->host)) {
        assert_true(cycles < most);
        rig_cycles(stage->rig, 1);
        cycles++;
    }
    return cycles;
}

/* Plays it on pc4 and holds what is told against the lines, each with its cycle and count. */
static void tells(const char *text, enum evidence_play play, const char *const *lines)
{
    struct stage stage = open_on("pc4", text);
    const struct evidence *evidence = &stage.rig->evidence;
    unsigned i = 0;
    play_out(&stage);
    for (; i < evidence->failure_count && lines[i] != NULL; i++) {
        char told[SCENARIO_TEXT], line[SCENARIO_TEXT + 64];
        scenario_tell(stage.scenario, &evidence->failures[i], told);
        snprintf(line, sizeof line, "%s (cycle %llu, %llu)", told,
                 (unsigned long long)evidence->failures[i].cycle,
                 (unsigned long long)evidence->failures[i].count);
        assert_string_equal(line, lines[i]);
    }
    assert_int_equal(i, evidence->failure_count);
    assert_null(lines[i]);
    assert_int_equal(evidence->play, play);
    close_stage(&stage);
}

static void passes(const char *product, const char *text, uint64_t checked)
{
    struct stage stage = open_on(product, text);
    const struct evidence *evidence = &stage.rig->evidence;
    char told[SCENARIO_TEXT] = "";
    play_out(&stage);
    if (evidence->failure_count > 0)
        scenario_tell(stage.scenario, &evidence->failures[0], told);
    assert_string_equal(told, "");
    assert_int_equal(evidence->play, PLAY_DONE);
    assert_int_equal(evidence->failed, 0);
    assert_int_equal(evidence->checked, checked);
    close_stage(&stage);
}

#define READY "wait until DIO[0].Status == 1 within 200ms\n"

/* --- what acts --- */

static void an_input_is_seen_one_cycle_later(void **state)
{
    struct stage stage = open_on("pc4", READY "at 1ms input DIO[0] channel 0 = 1\nend at 3ms");
    (void)state;
    rig_until(stage.rig, "DIO[0].Status", 1, 400);
    const double ready = rig_get(stage.rig, "MAIN.Servo_Tick");
    play_out(&stage);
    /* The wait was over in cycle `ready`, times count from the next one: 1 ms is two cycles, and
     * the frame with the input comes back one later. Cycles from there to 3 ms: 4. */
    assert_true(rig_get(stage.rig, "MAIN.Servo_Tick") - ready == 7);
    assert_true(rig_get(stage.rig, "DATA.U32[0]") == 4);
    close_stage(&stage);
}

static void input_words_lead_to_the_terminal_in_every_generation(void **state)
{
    static const char *const texts[] = {
        READY "set DIO[0].In0 = 0xA5\nexpect DIO[0].In0 == 0xA5 && DIO[0].Out0 == 0xA5 within 2ms\n"
              "after 5ms set DIO[0].In0 = 0x5A\nexpect DIO[0].Out0 == 0x5A within 2ms",
        READY
        "set DIO[0].In[0] = 0xA5\nexpect DIO[0].In[0] == 0xA5 && DIO[0].Out[0] == 0xA5 within 2ms\n"
        "after 5ms set DIO[0].In[0] = 0x5A\nexpect DIO[0].Out[0] == 0x5A within 2ms",
    };
    (void)state;
    for (size_t i = 0; i < 2; i++)
        passes(products[i], texts[i], 3);
}

static void a_drives_inputs_are_inputs(void **state)
{
    (void)state;
    for (size_t i = 0; i < 2; i++)
        passes(products[i],
               READY "input SERVO[0] bit 16 = 1\nexpect SERVO[0].DigitalIn.bit(16) within 2ms\n"
                     "after 5ms input SERVO[0] channel 16 = 0\n"
                     "expect !SERVO[0].DigitalIn.bit(16) within 2ms",
               3);
}

static void the_inputs_of_a_second_axis_are_its_own(void **state)
{
    static const struct bus_device twins[] = { { .type = "drive-cia402x2" },
                                               { .type = "dio-8x8" } };
    static const struct plant plant = {
        .devices = twins, .device_count = 2, .servos = 2, .dios = 1
    };
    struct scenario *scenario =
        read_for(product_find("pc4"), READY "input SERVO[1] channel 16 = 1\n"
                                            "after 5ms expect SERVO[1].DigitalIn.bit(16)\n"
                                            "expect !SERVO[0].DigitalIn.bit(16)");
    const struct host_config config = { .plant = &plant, .scenario = scenario };
    struct rig *rig = rig_open("echo", &config);
    (void)state;
    rig_start(rig);
    while (!host_played(rig->host))
        rig_cycles(rig, 1);
    assert_int_equal(rig->evidence.checked, 3);
    assert_int_equal(rig->evidence.failed, 0);
    rig_close(rig);
    scenario_close(scenario);
}

static void a_register_that_is_set_has_its_value_in_the_same_cycle(void **state)
{
    (void)state;
    passes("pc4",
           "at 1ms set DATA.U32[16] = 7\nexpect DATA.U32[16] == 7\n"
           "at 2ms set DATA.F64[24] = DATA.U32[16] / 2.0\nexpect DATA.F64[24] == 3.5\n"
           "at 3ms set DATA.U32[16] = DATA.U32[16] + 1\nexpect DATA.U32[16] == 8\n"
           "set TIMERS.Timer_Down[0] = 5\nexpect TIMERS.Timer_Down[0] == 5",
           4);
}

static void a_fault_happens_on_the_bus(void **state)
{
    static const char text[] = READY "at 0s fault unplug after 1 for 20ms\n"
                                     "expect DIO[0].Status == 0 within 20ms\n"
                                     "at 30ms wait until DIO[0].Status == 1 within 1s";
    struct stage stage = open_on("pc4", text);
    (void)state;
    play_out(&stage);
    assert_int_equal(stage.rig->evidence.failed, 0);
    assert_int_equal(stage.rig->evidence.fault_count, 2);
    assert_string_equal(stage.rig->evidence.faults[0].text, "unplug after 1 for 20ms");
    close_stage(&stage);
}

static void a_log_has_its_time_and_value(void **state)
{
    struct stage stage = open_on("pc5", "at 2ms log \"a\" MAIN.Servo_SetCycleTime\nlog \"b\"");
    const struct evidence *evidence = &stage.rig->evidence;
    char text[SCENARIO_TEXT];
    (void)state;
    play_out(&stage);
    assert_int_equal(evidence->line_count, 2);
    scenario_tell_line(stage.scenario, &evidence->lines[0], text);
    assert_string_equal(text, "a 500");
    assert_int_equal(evidence->lines[0].time_ns, 2000000);
    scenario_tell_line(stage.scenario, &evidence->lines[1], text);
    assert_string_equal(text, "b");
    close_stage(&stage);
}

/* echo.c adds 1 to DATA.U32[0] in every cycle in which input 0 is on. */
static void plc_control_is_carried_out(void **state)
{
    static const char ready[] =
        READY "set DIO[0].In0 = 1\nwait until DATA.U32[0] == 1 within 10ms\n";
    static const struct {
        const char *text;
        uint64_t checked;
    } rows[] = {
        { "pause\nset DATA.U32[8] = DATA.U32[0]\n"
          "every 1ms from 0s to 19ms expect DATA.U32[0] == DATA.U32[8]\n"
          "at 20ms run\nexpect DATA.U32[0] == DATA.U32[8] + 1",
          21 },
        { "at 1ms stop\nat 3ms expect DATA.U32[0] == 0\nat 50ms expect DATA.U32[0] == 0\n"
          "at 60ms run\nwait until DATA.U32[0] == 5 within 500ms",
          3 },
        { "set DATA.U32[0] = 1000\nat 1ms reload\n"
          "wait until DATA.U32[0] == 1 within 500ms \"TGM_Data begins with 0\"",
          1 },
        { "repeat 2\nreload\nafter 1ms wait until DATA.U32[0] == 0 within 500ms\n"
          "wait until DATA.U32[0] == 5 within 500ms\nend",
          4 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[512];
        snprintf(text, sizeof text, "%s%s", ready, rows[i].text);
        passes("pc4", text, 2 + rows[i].checked);
    }
}

/* --- the order of things --- */

#define TICK "MAIN.Servo_Tick" /* cycle + 1 when it is looked at */

static void times_mean_the_next_cycle(void **state)
{
    static const struct {
        const char *text;
        uint64_t cycles;
    } rows[] = {
        { "expect " TICK " == 1", 1 },
        { "at 1ms expect " TICK " == 3", 3 },
        { "at 1.1ms expect " TICK " == 4", 4 },
        { "at 1.5ms expect " TICK " == 4\nafter 0.6ms expect " TICK " == 6", 6 },
        { "expect " TICK " == 11 within 5ms", 11 },
        { "at 1ms wait until " TICK " == 5 within 5ms\nexpect " TICK " == 6\n"
          "at 1ms expect " TICK " == 8\nend at 2ms",
          10 },
        { "expect " TICK " == 20 within 10ms\nat 1ms expect " TICK " == 3", 20 },
        { "after 1ms wait until " TICK " == 8 within 4ms\nexpect " TICK " == 9", 9 },
        { "every 3ms from 0s to 10ms expect 1", 21 },
        { "at 1ms repeat 2\nat 1ms log \"\"\nend\nexpect " TICK " == 7", 7 },
        { "end at 10ms", 21 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct stage stage = open_on("pc4", rows[i].text);
        assert_int_equal(play_out(&stage), rows[i].cycles);
        if (stage.rig->evidence.failed != 0)
            fail_msg("%s failed", rows[i].text);
        close_stage(&stage);
    }
}

static void every_is_judged_as_often_as_it_says(void **state)
{
    static const struct {
        const char *text;
        uint64_t checked;
    } rows[] = {
        { "every 1ms expect " TICK " % 2 == 1\nend at 10ms", 10 },
        { "every 1ms from 0s to 10ms expect " TICK " % 2 == 1", 11 },
        { "every 1us from 5ms to 10ms expect " TICK " >= 11 && " TICK " <= 21", 11 },
        { "every 3ms from 5ms expect " TICK " == 11 || " TICK " == 17\nend at 10ms", 2 },
        { "wait until " TICK " == 11 within 1s\nevery 1ms from 1ms to 2ms expect " TICK
          " == 14 || " TICK " == 16",
          3 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        passes("pc4", rows[i].text, rows[i].checked);
}

static void a_block_is_repeated(void **state)
{
    (void)state;
    passes("pc4",
           "repeat 3\nset DATA.U32[8] = DATA.U32[8] + 1\nat 2ms log \"\"\nend\n"
           "expect DATA.U32[8] == 3 && " TICK " == 13",
           1);
    /* A round lasts one cycle at least, and as long as what it expects. */
    passes("pc4", "repeat 3\nset DATA.U32[8] = DATA.U32[8] + 1\nend\nexpect " TICK " == 4", 1);
    passes("pc4",
           "repeat 2\nset DATA.U32[8] = " TICK "\nexpect " TICK
           " == DATA.U32[8] + 5 within 10ms\nend\nexpect " TICK " == 13",
           3);
    passes("pc4",
           "at 1ms repeat 2\nrepeat 3\nset DATA.U32[8] = DATA.U32[8] + 1\nend\n"
           "set DATA.U32[12] = DATA.U32[12] + 1\nend\n"
           "expect DATA.U32[8] == 6 && DATA.U32[12] == 2",
           1);
    passes("pc4", "repeat 2\nevery 1ms from 1ms to 2ms expect 1\nend\nexpect " TICK " == 11", 5);
    passes("pc4", "repeat 4\nwait until " TICK " % 5 == 0 within 10ms\nend\nexpect " TICK " == 21",
           5);
}

/* --- what is told --- */

static void failures_are_told_with_place_values_and_cycle(void **state)
{
    (void)state;
    tells(
        "at 1ms expect MAIN.Servo_Tick == 7", PLAY_DONE,
        (const char *[]){ "t:1:15: MAIN.Servo_Tick == 7 is not so: it was 3 (cycle 2, 1)", NULL });
    tells("expect MAIN.Servo_Tick == 99 within 5ms \"late\"", PLAY_DONE,
          (const char *[]){
              "t:1:8: late: MAIN.Servo_Tick == 99 not within 5ms: it was 11 (cycle 10, 1)", NULL });
    tells("wait until MAIN.Servo_Tick > 3 && SERVO[0].Pg.Acc == 5 within 2ms\nexpect 0",
          PLAY_GIVEN_UP,
          (const char *[]){ "t:1:12: MAIN.Servo_Tick > 3 && SERVO[0].Pg.Acc == 5 not within 2ms: "
                            "MAIN.Servo_Tick was 5, SERVO[0].Pg.Acc was 0 (cycle 4, 1)",
                            NULL });
    tells("every 1ms expect MAIN.Servo_Tick < 10\nend at 10ms", PLAY_DONE,
          (const char *[]){ "t:1:18: MAIN.Servo_Tick < 10 is not so: it was 11 (cycle 10, 6)",
                            NULL });
    tells("repeat 3\nexpect 1 > 2\nend", PLAY_DONE,
          (const char *[]){ "t:2:8: 1 > 2 is not so (cycle 0, 3)", NULL });
}

static void what_cannot_be_done_is_told(void **state)
{
    (void)state;
    tells("at 1ms set DATA.U8[100] = MAIN.Servo_Tick + 300\nat 2ms set DATA.I32[100] = 1.5",
          PLAY_DONE,
          (const char *[]){ "t:1:12: 303 does not fit DATA.U8[100] (U8) (cycle 2, 1)",
                            "t:2:12: 1.5 does not fit DATA.I32[100] (I32) (cycle 4, 1)", NULL });
    tells("\nat 50ms set SERVO[0].Status = 7\nset MAIN.Log_Ctrl = 5", PLAY_DONE,
          (const char *[]){ "t:2:13: SERVO[0].Status does not stay as it is set: TG Motion writes "
                            "it every cycle (cycle 100, 1)",
                            NULL });
    tells("input DIO[0] channel 0 = 2\nset DIO[0].In0 = 256\ninput DIO[0] channel 1 = 0.5",
          PLAY_DONE,
          (const char *[]){ "t:1:7: DIO[0] channel 0 cannot be 2 (cycle 0, 1)",
                            "t:2:5: 256 does not fit DIO[0].In0 (I32) (cycle 0, 1)",
                            "t:3:7: 0.5 is no value of DIO[0] channel 1 (cycle 0, 1)", NULL });
}

/* More than the evidence has room for: all are counted, the first are kept. */
static void no_failure_is_lost_from_the_count(void **state)
{
    char text[2048];
    size_t at = 0;
    (void)state;
    for (int i = 0; i < 40; i++)
        at += (size_t)snprintf(text + at, sizeof text - at, "expect 0\n");
    struct stage stage = open_on("pc4", text);
    play_out(&stage);
    assert_int_equal(stage.rig->evidence.checked, 40);
    assert_int_equal(stage.rig->evidence.failed, 40);
    assert_int_equal(stage.rig->evidence.failure_count, EVIDENCE_FAILURES);
    close_stage(&stage);
}

/* --- what the machine does not have --- */

static void refuses(const char *product, const struct plant *plant, const char *text,
                    const char *expected)
{
    struct scenario *scenario = read_for(product_find(product), text);
    const struct host_config config = { .product = product_find(product),
                                        .cycle_us = 500,
                                        .seed = 1,
                                        .plant = plant,
                                        .scenario = scenario };
    const struct machine_config around = { .seed = 1, .hang_ns = 2000000000 };
    struct evidence *evidence = calloc(1, sizeof *evidence);
    struct image *image;
    struct machine *machine;
    struct host *host = NULL;
    char why[HOST_WHY] = "";
    assert_non_null(evidence);
    assert_int_equal(image_open(&image, TEST_HOST_MODULES_DIR "/echo_4.tgm", why), 0);
    assert_int_equal(machine_load(&machine, image, &around, why), 0);
    assert_int_not_equal(host_open(&host, &config, machine, image, evidence, why), 0);
    if (strncmp(why, expected, strlen(expected)) != 0)
        fail_msg("%s: %s", text, why);
    assert_int_equal(evidence->play, PLAY_NONE);
    machine_unload(machine);
    image_close(image);
    free(evidence);
    scenario_close(scenario);
}

static void what_the_machine_does_not_have_is_refused_with_its_place(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        { "log \"x\"\n at 1ms input DIO[1] channel 0 = 1",
          "t:2:15: there is no such I/O unit; expected 0 to 0" },
        { "input DIO[0] channel 8 = 1", "t:1:7: slave 2 (" },
        { "input SERVO[0] channel 3 = 1", "t:1:7: slave 1 (" },
        { "input SERVO[0] channel 48 = 1", "t:1:7: slave 1 (" },
        { "input SERVO[7] channel 0 = 1", "t:1:7: there is no such servo; expected 0 to 0" },
        { "set DIO[0].In5 = 1", "t:1:5: the unit has no inputs there" },
        { "at 10ms fault unplug after 9",
          "t:1:28: there is no slave 9; expected a slave from 0 to 1" },
        { "\n  fault unplgu after 1", "t:2:9: unknown fault 'unplgu' (did you mean 'unplug'?)" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        refuses("pc4", &quiet, rows[i].text, rows[i].why);
}

static void analog_inputs_are_channels(void **state)
{
    static const struct bus_device analog[] = { { .type = "drive-cia402" }, { .type = "ai-2" } };
    static const struct plant plant = {
        .devices = analog, .device_count = 2, .servos = 1, .dios = 1
    };
    struct scenario *scenario = read_for(
        product_find("pc4"), READY "input DIO[0] channel 0 = -2\nset DIO[0].AI[1] = 77\n"
                                   "expect DIO[0].AI[0] == -2 && DIO[0].AI[1] == 77 within 5ms");
    const struct host_config config = { .plant = &plant, .scenario = scenario };
    struct rig *rig = rig_open("echo", &config);
    (void)state;
    rig_start(rig);
    while (!host_played(rig->host))
        rig_cycles(rig, 1);
    assert_int_equal(rig->evidence.play, PLAY_DONE);
    assert_int_equal(rig->evidence.failed, 0);
    rig_close(rig);
    scenario_close(scenario);
    refuses("pc4", &plant, "set DIO[0].In0 = 1", "t:1:5: the unit has no inputs there");
    refuses("pc4", &plant, "set DIO[0].AI[2] = 1", "t:1:5: the unit has no input there");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_input_is_seen_one_cycle_later),
        cmocka_unit_test(input_words_lead_to_the_terminal_in_every_generation),
        cmocka_unit_test(a_drives_inputs_are_inputs),
        cmocka_unit_test(the_inputs_of_a_second_axis_are_its_own),
        cmocka_unit_test(a_register_that_is_set_has_its_value_in_the_same_cycle),
        cmocka_unit_test(a_fault_happens_on_the_bus),
        cmocka_unit_test(a_log_has_its_time_and_value),
        cmocka_unit_test(plc_control_is_carried_out),
        cmocka_unit_test(times_mean_the_next_cycle),
        cmocka_unit_test(every_is_judged_as_often_as_it_says),
        cmocka_unit_test(a_block_is_repeated),
        cmocka_unit_test(failures_are_told_with_place_values_and_cycle),
        cmocka_unit_test(what_cannot_be_done_is_told),
        cmocka_unit_test(no_failure_is_lost_from_the_count),
        cmocka_unit_test(what_the_machine_does_not_have_is_refused_with_its_place),
        cmocka_unit_test(analog_inputs_are_channels),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
