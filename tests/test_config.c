/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Configuration files: what is taken from good ones, what is said of damaged ones, and that
 * docs/configuration.md has every key. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "host/config.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

static struct config config;
static struct config_store store;

static const struct config *parse(const char *product, const char *text)
{
    assert_non_null(product_find(product));
    config_parse(&config, product_find(product), text, strlen(text));
    return &config;
}

/* All problems, as the command line says them. */
static const char *problems_of(const char *product, const char *text)
{
    static char out[16384];
    size_t at = 0;
    parse(product, text);
    out[0] = '\0';
    for (size_t i = 0; i < config.problem_count; i++)
        at += (size_t)snprintf(out + at, sizeof out - at, "%u: %s%s\n", config.problems[i].line,
                               config.problems[i].warning ? "warning: " : "",
                               config.problems[i].text);
    return out;
}

static struct host_config applied(const char *product, const char *text)
{
    struct host_config host = { 0 };
    assert_string_equal(problems_of(product, text), "");
    config_apply(&config, &store, &host);
    return host;
}

/* --- good files --- */

static void an_empty_file_has_the_defaults(void **state)
{
    (void)state;
    for (size_t i = 0; product_at(i) != NULL; i++) {
        const struct product *product = product_at(i);
        const struct host_config host = applied(product->name, "");
        assert_int_equal(host.cycle_us, product->default_cycle_us);
        for (int k = 0; k < 3; k++)
            assert_int_equal(host.program_period_us[k], product->program_period_us[k]);
        assert_int_equal(host.data_bytes, 524288);
        assert_int_equal(host.osc_bytes, product->osc_bytes);
        assert_int_equal(host.eeprom_bytes, 2752);
        assert_int_equal(host.can_kbit, 500);
        assert_int_equal(host.clock, CLOCK_DEFAULT);
        assert_null(host.servos);
        assert_memory_equal(host.modes, &servo_modes_default, sizeof servo_modes_default);
        assert_int_equal(host.interpolator_items[2], product->max_interpolator > 2 ? 2000 : 0);
        assert_int_equal(config.ip, 0xC0A801BC);
    }
}

static void a_file_says_what_the_host_is(void **state)
{
    (void)state;
    const struct host_config host =
        applied("tgmcontroller", "; a machine\n"
                                 "# with comments\n"
                                 "[System]\r\n"
                                 "Cycle_Time = 2000 ; us\r\n"
                                 "Log=0x100\n"
                                 "[PLC_Configuration]\n"
                                 "Cycle_Time_Program_01=0\n"
                                 "Cycle_Time_Program_02=0\n"
                                 "  Cycle_Time_Program_03=1000\n"
                                 "Autostart_PLC=1\n"
                                 "[Servo_Configuration]\n"
                                 "Servo[00].Type=92\n"
                                 "Servo[00].FeedbackType=2\n"
                                 "Servo[1].Type=9\n"
                                 "Servo[1].Node=5\n"
                                 "Servo[1].Axis=2\n"
                                 "Servo[1].Resolution=20\n"
                                 "Servo[02].Type=0\n"
                                 "Servo[02].Resolution=1000\n"
                                 "[Servo_Modes]\nPG=11\nUser=-9\n"
                                 "[EtherCAT]\nDistributed_Clock=1\n"
                                 "[Memory]\nData_Bytes=65536\nEEPROM_Bytes=512\n"
                                 "[CAN]\nBaudRate=1000\n"
                                 "[Interpolator_Configuration]\n"
                                 "Interpolator[2].Buffer_Size=500\n"
                                 "[DHCP]\nEnable=0\nIPAddress=10.0.0.2\n"
                                 "Gateway=10.0.0.1\n"
                                 "MacAddress=00.0A.35.00.01.02\n"
                                 "[Modbus]\nOffset=16384\nMultiplier=4\n");
    assert_int_equal(host.cycle_us, 2000);
    assert_int_equal(host.log_ctrl, 0x100);
    assert_int_equal(host.program_period_us[0], 0);
    assert_int_equal(host.program_period_us[1], PERIOD_OFF);
    assert_int_equal(host.program_period_us[2], 1000);
    assert_int_equal(host.servo_count, 3);
    static const struct host_servo wanted[] = {
        { .type = 92, .node = 1, .axis = 1, .feedback = 2, .resolution = 0 },
        { .type = 9, .node = 5, .axis = 2, .feedback = 1, .resolution = 1048576 },
        { .type = 0, .node = 3, .axis = 1, .feedback = 1, .resolution = 1000 },
    };
    assert_memory_equal(host.servos, wanted, sizeof wanted);
    assert_int_equal(host.modes->pg, 11);
    assert_int_equal(host.modes->user, -9);
    assert_int_equal(host.clock, CLOCK_ON);
    assert_int_equal(host.data_bytes, 65536);
    assert_int_equal(host.eeprom_bytes, 512);
    assert_int_equal(host.can_kbit, 1000);
    assert_int_equal(host.interpolator_items[0], 2000);
    assert_int_equal(host.interpolator_items[2], 500);
    assert_int_equal(config.autostart, 1);
    assert_int_equal(config.modbus_offset, 16384);
}

static void letter_case_does_not_matter(void **state)
{
    (void)state;
    const struct host_config host = applied("pc4", "[SYSTEM]\ncycle_TIME=250\n"
                                                   "[servo_configuration]\nSERVO[00].type=0\n"
                                                   "[simulation]\nbus=Machine.BUS\n");
    assert_int_equal(host.cycle_us, 250);
    assert_int_equal(host.servo_count, 1);
    assert_string_equal(config.bus, "Machine.BUS"); /* of values it does */
}

static void the_list_of_servos_makes_the_bus(void **state)
{
    (void)state;
    const struct host_config host =
        applied("tgzmotion", "[Servo_Configuration]\n"
                             "Servo[0].Type=3\nServo[0].Node=7\nServo[1].Type=91\n"
                             "Servo[2].Type=91\nServo[2].Axis=2\nServo[3].Type=0\n"
                             "Servo[4].Type=99\nServo[4].Node=9\nServo[5].Type=3\n"
                             "Servo[5].Node=7\nServo[5].Axis=2\n"
                             "[EtherCAT]\nRedundancy=1\n");
    const struct plant *plant = config_plant(&config, &store);
    static const struct {
        const char *type;
        uint16_t alias;
    } wanted[] = { { "tgz-2", 0 }, { "drive-cia402x2", 7 }, { "tgz-1", 9 }, { "dio-8x8", 0 } };
    assert_int_equal(host.servo_count, 6);
    assert_int_equal(plant->device_count, COUNT(wanted));
    for (size_t i = 0; i < COUNT(wanted); i++) {
        assert_string_equal(plant->devices[i].type, wanted[i].type);
        assert_int_equal(plant->devices[i].alias, wanted[i].alias);
    }
    assert_int_equal(plant->servos, 6);
    assert_true(plant->redundant);
    assert_int_equal(plant->devices[3].stimulus_count, 1);

    applied("pc4", "");
    plant = config_plant(&config, &store);
    assert_int_equal(plant->device_count, 2);
    assert_string_equal(plant->devices[0].type, "drive-cia402");
    assert_false(plant->redundant);
}

/* --- damaged files --- */

static void what_is_wrong_is_said_with_line_and_range(void **state)
{
    (void)state;
    static const struct {
        const char *product, *text, *said;
    } rows[] = {
        { "tgmcontroller", "[System]\nCycle_Time=300\n",
          "2: Cycle_Time=300 in [System]: TGMcontroller takes 100, 200, 250, 500, 1000, 2000, "
          "3000, 4000, 5000, 6000, 7000, 8000, 9000 or 10000\n" },
        { "pc4", "[System]\nCycle_Time=0\n",
          "2: Cycle_Time=0 in [System]: TG Motion 4.21 takes 250, 500 or 1000\n" },
        { "pc4", "[System]\nCycle_Time=5OO\n",
          "2: Cycle_Time=5OO in [System]: TG Motion 4.21 takes 250, 500 or 1000\n" },
        { "pc4", "[System]\nCycle_Time=\n",
          "2: Cycle_Time= in [System]: TG Motion 4.21 takes 250, 500 or 1000\n" },
        { "pc4", "[System]\nCycle_Time=18446744073709552116\n",
          "2: Cycle_Time=18446744073709552116 in [System]: TG Motion 4.21 takes 250, 500 or "
          "1000\n" },
        { "pc4", "[System]\nCycle_Time=4294967796\n",
          "2: Cycle_Time=4294967796 in [System]: TG Motion 4.21 takes 250, 500 or 1000\n" },
        { "pc4", "[PLC_Configuration]\nCycle_Time_Program_02=99\n",
          "2: Cycle_Time_Program_02=99 in [PLC_Configuration]: TG Motion 4.21 takes 100 or "
          "more\n" },
        { "pc4", "[PLC_Configuration]\nCycle_Time_Program_02=4294967295\n",
          "2: Cycle_Time_Program_02=4294967295 in [PLC_Configuration]: TG Motion 4.21 takes 100 "
          "or more\n" },
        { "tgzmotion", "[PLC_Configuration]\nCycle_Time_Program_01=200\n",
          "2: Cycle_Time_Program_01=200 in [PLC_Configuration]: TGZ+Motion takes only 0 (as fast "
          "as possible)\n" },
        { "tgzmotion", "[PLC_Configuration]\nCycle_Time_Program_03=300\n",
          "2: Cycle_Time_Program_03=300 in [PLC_Configuration]: TGZ+Motion takes 0 (off) and "
          "multiples of 200\n" },
        { "pc4", "[Servo_Configuration]\nServo[00].Type=99\n",
          "2: Servo[00].Type=99 in [Servo_Configuration]: TG Motion 4.21 takes 0, 3, 5 or 9\n" },
        { "tgmcontroller", "[Servo_Configuration]\nServo[00].Type=91\n",
          "2: Servo[00].Type=91 in [Servo_Configuration]: TGMcontroller takes 0, 3, 5, 9, 51, 52, "
          "92, 93, 95 or 99\n" },
        { "pc5", "[Servo_Configuration]\nServo[00].Type=9\nServo[00].Node=65\nServo[00].Axis=3\n",
          "3: Servo[00].Node=65 in [Servo_Configuration]: TG Motion 5.02 takes 1 to 64\n"
          "4: Servo[00].Axis=3 in [Servo_Configuration]: TG Motion 5.02 takes 1 to 2\n" },
        { "pc5", "[Servo_Configuration]\nServo[00].Type=9\nServo[00].Resolution=64\n",
          "3: Servo[00].Resolution=64 in [Servo_Configuration]: TG Motion 5.02 takes 1 to 31 "
          "(bits) or 65 to 4294967295 (inc/rev)\n" },
        { "tgmmini", "[Servo_Configuration]\nServo[64].Type=9\n",
          "2: Servo[64].Type in [Servo_Configuration]: TGMmini has 0 to 63\n" },
        { "tgmmini", "[Interpolator_Configuration]\nInterpolator[2].Buffer_Size=2000\n",
          "2: Interpolator[2].Buffer_Size in [Interpolator_Configuration]: TGMmini has 0 to 1\n" },
        { "pc4", "[Interpolator_Configuration]\nInterpolator[0].Buffer_Size=500\n",
          "2: Interpolator[0].Buffer_Size=500 in [Interpolator_Configuration]: TG Motion 4.21 "
          "takes 1000 to 100000\n" },
        { "pc5", "[Memory]\nOscilloscope_MB=1\nData_Bytes=65537\n",
          "2: Oscilloscope_MB=1 in [Memory]: TG Motion 5.02 takes only 32\n"
          "3: Data_Bytes=65537 in [Memory]: TG Motion 5.02 takes 65536 to 16777216 in steps of "
          "4096\n" },
        { "tgmmini", "[Memory]\nOscilloscope_MB=33\n",
          "2: Oscilloscope_MB=33 in [Memory]: TGMmini takes 1 to 32\n" },
        { "pc4", "[CAN]\nBaudRate=300\n",
          "2: BaudRate=300 in [CAN]: TG Motion 4.21 takes 10, 20, 50, 100, 125, 250, 500, 800 or "
          "1000\n" },
        { "tgzmotion", "[DHCP]\nIPAddress=192.168.1.256\nMask=255.255.255\nEnable=2\n",
          "2: IPAddress=192.168.1.256 in [DHCP]: TGZ+Motion takes an address such as "
          "192.168.1.188\n"
          "3: Mask=255.255.255 in [DHCP]: TGZ+Motion takes an address such as 192.168.1.188\n"
          "4: Enable=2 in [DHCP]: TGZ+Motion takes 0 or 1\n" },
        { "tgmcontroller", "[DHCP]\nMacAddress=02.0A.35.00.01.02\n",
          "2: MacAddress=02.0A.35.00.01.02 in [DHCP]: TGMcontroller takes six or seven hexadecimal "
          "numbers with dots between them, the first 00\n" },
        { "pc4", "[Simulation]\nBus=\n",
          "2: Bus= in [Simulation]: TG Motion 4.21 takes the name of a file\n" },
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_string_equal(problems_of(rows[i].product, rows[i].text), rows[i].said);
}

static void unknown_keys_are_warned_about_with_the_nearest(void **state)
{
    (void)state;
    assert_string_equal(problems_of("pc4", "[System]\nCycle_Tme=500\nWeather=1\n"
                                           "[Sytem]\nCycle_Time=9\n"
                                           "[Unlike anything]\nx=1\n"
                                           "[PLC_Configuration]\nCycle_Time=500\n"
                                           "Autostart_PLC=1\n"
                                           "[LED]\nControl=1\n"
                                           "[Servo_Configuration]\nServo[x].Type=9\n"),
                        "2: warning: Cycle_Tme in [System] is unknown (did you mean Cycle_Time?)\n"
                        "3: warning: Weather in [System] is unknown\n"
                        "4: warning: section [Sytem] is unknown (did you mean [System]?)\n"
                        "6: warning: section [Unlike anything] is unknown; its keys are left out\n"
                        "9: warning: Cycle_Time in [PLC_Configuration] belongs into [System]\n"
                        "10: warning: Autostart_PLC in [PLC_Configuration] is a key of "
                        "TGMcontroller, TGZ+Motion, not of TG Motion 4.21\n"
                        "12: warning: Control in [LED] is a key of TGMmini, not of TG Motion 4.21\n"
                        "14: warning: Servo[x].Type in [Servo_Configuration] is unknown (did you "
                        "mean Servo[n].Type?)\n");
    assert_int_equal(config.errors, 0);
    assert_int_equal(config.warnings, 8);
    assert_int_equal(config.cycle_us, 500);
}

static void a_key_twice_names_both_lines(void **state)
{
    (void)state;
    assert_string_equal(
        problems_of("pc4", "[System]\nCycle_Time=250\n\n[Memory]\n[system]\ncycle_time=250\n"
                           "[Servo_Configuration]\nServo[0].Type=0\nServo[00].Type=0\n"),
        "6: cycle_time in [System] stands in lines 2 and 6\n"
        "9: Servo[00].Type in [Servo_Configuration] stands in lines 8 and 9\n");
}

static void lines_that_are_nothing_are_errors(void **state)
{
    (void)state;
    char text[1024];
    assert_string_equal(problems_of("pc4", "Cycle_Time=500\n[System]\nrubbish\n[open\n"
                                           "Cycle_Time=250\nmore rubbish"),
                        "1: Cycle_Time stands before the first [Section]\n"
                        "3: is neither [Section] nor Key=Value nor a comment\n"
                        "4: [open has no ]\n"
                        "6: is neither [Section] nor Key=Value nor a comment\n");
    snprintf(text, sizeof text, "[System]\nLog=%0300d\nCycle_Time=250\n", 1);
    assert_string_equal(problems_of("pc4", text), "2: is longer than 198 characters\n");
    assert_int_equal(config.cycle_us, 250);
    config_parse(&config, product_find("pc4"), "[System]\nLog=1\0\n", 16);
    assert_int_equal(config.errors, 1);
    assert_string_equal(config.problems[0].text, "has a NUL character: this is no text file");
    assert_string_equal(problems_of("pc4", "[System]\nX\x1B[31m=1\n"),
                        "2: warning: X?[31m in [System] is unknown\n");
}

static void what_does_not_fit_together_is_an_error(void **state)
{
    (void)state;
    static const struct {
        const char *product, *text, *said;
    } rows[] = {
        { "pc5", "[Servo_Configuration]\nServo[00].Type=9\nServo[02].Type=9\n",
          "3: Servo[01] is missing: servos are numbered from 00, without gaps\n" },
        { "pc5", "[Servo_Configuration]\nServo[00].Node=1\n", "2: Servo[00] has no Type\n" },
        { "pc5",
          "[Servo_Configuration]\nServo[0].Type=9\nServo[0].Node=3\nServo[1].Type=9\n"
          "Servo[1].Node=3\nServo[2].Type=0\nServo[2].Node=3\n",
          "4: Servo[00] and Servo[01] are both axis 1 of node 3\n" },
        { "pc5",
          "[Servo_Configuration]\nServo[0].Type=52\nServo[0].Node=3\nServo[1].Type=52\n"
          "Servo[1].Node=3\nServo[1].Axis=2\n",
          "" },
        { "tgmcontroller",
          "[Servo_Configuration]\nServo[0].Type=92\nServo[0].FeedbackType=3\n"
          "Servo[1].Type=92\nServo[1].Axis=2\nServo[1].FeedbackType=2\n"
          "Servo[2].Type=9\nServo[2].FeedbackType=1\n",
          "3: Servo[00].FeedbackType=3: axis 1 takes 1 or 2\n"
          "6: Servo[01].FeedbackType=2: axis 2 takes 1 or 3\n"
          "8: warning: Servo[02].FeedbackType is of type 92 only\n" },
        { "pc4", "[Servo_Modes]\nPG=4\n", "2: PG and PG_Gear in [Servo_Modes] are both 4\n" },
        { "tgzmotion", "[DHCP]\nIPAddress=10.0.0.7\n",
          "2: Gateway in [DHCP] is not in the segment of IPAddress\n" },
        { "tgzmotion", "[Modbus]\nOffset=6\n",
          "2: warning: Offset=6 in [Modbus] should be divisible by 4\n" },
        { "tgzmotion", "[Memory]\nData_Bytes=65536\n[Modbus]\nOffset=65536\n",
          "4: Offset=65536 in [Modbus] is past the end of TGM_Data (65536 bytes)\n" },
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_string_equal(problems_of(rows[i].product, rows[i].text), rows[i].said);
}

static void a_pc_with_256_servos_is_fine_and_problems_are_bounded(void **state)
{
    static char text[65536];
    size_t at = (size_t)snprintf(text, sizeof text, "[Servo_Configuration]\n");
    (void)state;
    for (int i = 0; i < 256; i++)
        at += (size_t)snprintf(text + at, sizeof text - at, "Servo[%d].Type=0\n", i);
    assert_int_equal(applied("pc5", text).servo_count, 256);

    at = (size_t)snprintf(text, sizeof text, "[Servo_Configuration]\n");
    for (int i = 0; i < 256; i++)
        at += (size_t)snprintf(text + at, sizeof text - at, "Servo[%d].Type=9\n", i);
    parse("pc5", text);
    assert_int_equal(config.errors, 256 - 64); /* those above 64 need a Node */
    assert_int_equal(config.problem_count, CONFIG_PROBLEMS);
    assert_string_equal(config.problems[0].text, "Servo[64] has no Node");
}

static void a_file_that_cannot_be_read_is_said(void **state)
{
    char why[CONFIG_WHY];
    (void)state;
    assert_true(config_read(&config, product_find("pc4"), "/nowhere/TGM.INI", why) < 0);
    assert_string_equal(why, "/nowhere/TGM.INI: No such file or directory");
}

/* --- the table --- */

static void default_values_are_allowed_values(void **state)
{
    char value[64];
    (void)state;
    for (size_t p = 0; product_at(p) != NULL; p++)
        for (size_t i = 0; config_key(i) != NULL; i++) {
            const struct config_key *key = config_key(i);
            config_key_default(key, product_at(p), value, sizeof value);
            if (!config_key_is_for(key, product_at(p)) || value[0] < '0' || value[0] > '9')
                continue;
            config_defaults(&config, product_at(p));
            if (!config_key_take(key, &config, 0, value))
                fail_msg("%s: default %s of %s", product_at(p)->name, value, key->name);
        }
}

static char *whole_file(const char *path)
{
    static char text[65536];
    FILE *file = fopen(path, "r");
    if (file == NULL)
        fail_msg("%s", path);
    const size_t size = fread(text, 1, sizeof text - 1, file);
    text[size] = '\0';
    fclose(file);
    return text;
}

/* Each key has a line "| `Key` | range ... |" under its section, and no line is of no key. */
static void the_manual_has_every_key(void **state)
{
    const char *manual = whole_file("docs/configuration.md");
    char line[512], products[128], range[160], fallback[64];
    size_t lines = 0;
    (void)state;
    for (size_t i = 0; config_key(i) != NULL; i++) {
        const struct config_key *key = config_key(i);
        size_t first = 0;
        while (!config_key_is_for(key, product_at(first)))
            first++;
        config_key_products(key, products, sizeof products);
        config_key_range(key, product_at(first), range, sizeof range);
        config_key_default(key, product_at(first), fallback, sizeof fallback);
        if (key->kind == CONFIG_CYCLE || key->kind == CONFIG_PERIOD || key->kind == CONFIG_TYPE ||
            key->kind == CONFIG_OSC)
            snprintf(range, sizeof range, "by product"), snprintf(fallback, sizeof fallback, "-");
        snprintf(line, sizeof line, "| `[%s]` | `%s` | %s | %s | %s | %s | %s |\n", key->section,
                 key->name, range, fallback, products, key->source, key->meaning);
        if (strstr(manual, line) == NULL)
            fail_msg("docs/configuration.md lacks:\n%s", line);
    }
    for (const char *at = manual; (at = strstr(at, "\n| `[")) != NULL; at++)
        lines++;
    size_t keys = 0;
    while (config_key(keys) != NULL)
        keys++;
    assert_int_equal(lines, keys);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_file_has_the_defaults),
        cmocka_unit_test(a_file_says_what_the_host_is),
        cmocka_unit_test(letter_case_does_not_matter),
        cmocka_unit_test(the_list_of_servos_makes_the_bus),
        cmocka_unit_test(what_is_wrong_is_said_with_line_and_range),
        cmocka_unit_test(unknown_keys_are_warned_about_with_the_nearest),
        cmocka_unit_test(a_key_twice_names_both_lines),
        cmocka_unit_test(lines_that_are_nothing_are_errors),
        cmocka_unit_test(what_does_not_fit_together_is_an_error),
        cmocka_unit_test(a_pc_with_256_servos_is_fine_and_problems_are_bounded),
        cmocka_unit_test(a_file_that_cannot_be_read_is_said),
        cmocka_unit_test(default_values_are_allowed_values),
        cmocka_unit_test(the_manual_has_every_key),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
