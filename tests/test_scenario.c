/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The language of scenarios: what is read, what its expressions are worth, and what is said about
 * what is not read. */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include <cmocka.h>

#include "host/scenario_play.h"

static const struct catalogue *layout(void)
{
    return catalogue_find(4, 0);
}

static struct scenario *read(const char *text)
{
    struct scenario *scenario;
    char why[SCENARIO_WHY];
    if (scenario_read(&scenario, text, strlen(text), "t", layout(), why) != 0)
        fail_msg("%s: %s", text, why);
    assert_string_equal(why, "");
    return scenario;
}

static void refuses(const char *text, const char *expected)
{
    struct scenario *scenario;
    char why[SCENARIO_WHY];
    assert_int_equal(scenario_read(&scenario, text, strlen(text), "t", layout(), why), -EINVAL);
    assert_null(scenario);
    if (strncmp(why, expected, strlen(expected)) != 0)
        fail_msg("%s\n  says   %s\n  not    %s", text, why, expected);
}

/* --- what is read --- */

static void every_statement_is_read(void **state)
{
    static const char text[] = "# a comment\n"
                               "\n"
                               "at 10ms set SERVO[0].Mode = 1 # behind\r\n"
                               "after 5us input DIO[1] channel 3 = 1\n"
                               "input SERVO[2] bit 16 = DATA.U8[0]\n"
                               "at 1.5s fault unplug after 2 for 20ms # cable\n"
                               "expect SERVO[0].Status == 3 within 20ms \"enabled # not\"\n"
                               "every 1ms from 2s to 3s expect 1\n"
                               "wait until MAIN.Servo_Tick > 7 within 250ns\n"
                               "at 0s repeat 3\n"
                               "  log \"round\" MAIN.Servo_Tick\n"
                               "end\n"
                               "log \"over\"\n"
                               "at 1s stop\nrun\nafter 1s pause\nreload\n"
                               "end after 0.1s";
    static const struct {
        enum scenario_kind kind;
        enum scenario_when when;
        unsigned line, column;
        uint64_t when_ns;
    } wanted[] = {
        { SCENARIO_SET, SCENARIO_AT, 3, 9, 10000000 },
        { SCENARIO_INPUT, SCENARIO_AFTER, 4, 11, 5000 },
        { SCENARIO_INPUT, SCENARIO_NOW, 5, 1, 0 },
        { SCENARIO_FAULT, SCENARIO_AT, 6, 9, 1500000000 },
        { SCENARIO_EXPECT, SCENARIO_NOW, 7, 1, 0 },
        { SCENARIO_EVERY, SCENARIO_NOW, 8, 1, 0 },
        { SCENARIO_WAIT, SCENARIO_NOW, 9, 1, 0 },
        { SCENARIO_REPEAT, SCENARIO_AT, 10, 7, 0 },
        { SCENARIO_LOG, SCENARIO_NOW, 11, 3, 0 },
        { SCENARIO_END, SCENARIO_NOW, 12, 1, 0 },
        { SCENARIO_LOG, SCENARIO_NOW, 13, 1, 0 },
        { SCENARIO_PLC, SCENARIO_AT, 14, 7, 1000000000 },
        { SCENARIO_PLC, SCENARIO_NOW, 15, 1, 0 },
        { SCENARIO_PLC, SCENARIO_AFTER, 16, 10, 1000000000 },
        { SCENARIO_PLC, SCENARIO_NOW, 17, 1, 0 },
        { SCENARIO_STOP, SCENARIO_AFTER, 18, 1, 100000000 },
    };
    struct scenario *scenario = read(text);
    const struct scenario_statement *st = scenario->statements;
    (void)state;
    assert_int_equal(scenario->statement_count, sizeof wanted / sizeof *wanted);
    for (size_t i = 0; i < scenario->statement_count; i++) {
        assert_int_equal(st[i].kind, wanted[i].kind);
        assert_int_equal(st[i].when, wanted[i].when);
        assert_int_equal(st[i].line, wanted[i].line);
        assert_int_equal(st[i].column, wanted[i].column);
        assert_int_equal(st[i].when_ns, wanted[i].when_ns);
    }
    assert_string_equal(scenario->registers[st[0].reg].name, "SERVO[0].Mode");
    assert_false(st[1].servo);
    assert_int_equal(st[1].number, 1);
    assert_int_equal(st[1].channel, 3);
    assert_true(st[2].servo);
    assert_int_equal(st[2].channel, 16);
    assert_string_equal(st[2].target, "SERVO[2] bit 16");
    assert_string_equal(st[3].text, "unplug after 2 for 20ms");
    assert_string_equal(st[3].padded, "              unplug after 2 for 20ms");
    assert_string_equal(st[4].text, "enabled # not");
    assert_string_equal(st[4].expression.text, "SERVO[0].Status == 3");
    assert_int_equal(st[4].expression.column, 8);
    assert_int_equal(st[4].within_ns, 20000000);
    assert_int_equal(st[5].every_ns, 1000000);
    assert_int_equal(st[5].from_ns, 2000000000);
    assert_int_equal(st[5].to_ns, 3000000000);
    assert_int_equal(st[6].within_ns, 250);
    assert_int_equal(st[7].rounds, 3);
    assert_int_equal(st[7].partner, 9);
    assert_int_equal(st[9].partner, 7);
    assert_string_equal(st[8].text, "round");
    assert_int_equal(st[10].expression.count, 0);
    assert_int_equal(st[11].control, CONTROL_STOP);
    assert_int_equal(st[12].control, CONTROL_RUN);
    assert_int_equal(st[13].control, CONTROL_PAUSE);
    assert_int_equal(st[14].control, CONTROL_RELOAD);
    scenario_close(scenario);
}

static void a_scenario_knows_how_long_it_may_take(void **state)
{
    static const struct {
        const char *text;
        uint64_t ns;
    } rows[] = {
        { "set DATA.U8[0] = 1", 0 },
        { "at 10ms set DATA.U8[0] = 1", 10000000 },
        { "at 10ms expect 1 within 5ms\nat 12ms expect 1", 15000000 },
        { "wait until 1 within 1s\nat 10ms expect 1\nend after 1ms", 1011000000 },
        { "every 1ms expect 1\nend at 2s", 2000000000 },
        { "every 1ms from 5ms to 3s expect 1\nend at 2s", 3000000000 },
        { "at 1s repeat 4\nat 10ms expect 1 within 5ms\nend\nat 1ms expect 1", 1061000000 },
        { "repeat 3\nreload\nend\nat 1s run\nat 2s expect 1", 3000000000 },
        { "repeat 2\nrepeat 3\nat 1ms expect 1\nend\nat 4ms expect 1\nend", 14000000 },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct scenario *scenario = read(rows[i].text);
        assert_int_equal(scenario_most(scenario, 0), rows[i].ns);
        assert_true(scenario_cycles(scenario, 500) * 500000 > rows[i].ns);
        scenario_close(scenario);
    }
}

/* --- what is not --- */

static void a_damaged_line_is_told_with_its_place_and_what_was_expected(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        { "", "t:1:1: there is no statement; expected at least one" },
        { "epect 1", "t:1:1: unknown word 'epect' (did you mean 'expect'?)" },
        { "at 1ms evry 2ms expect 1",
          "t:1:8: unexpected 'evry'; expected set, input, fault, expect, wait, repeat, log, run, "
          "stop, pause or reload" },
        { "\n  7", "t:2:3: unexpected '7'; expected set, input, fault, expect, every, wait, "
                   "repeat, end, log, run, stop, pause, reload, at or after" },
        { "at expect 1", "t:1:4: unexpected 'expect'; expected a time such as 250ms" },
        { "at 5 expect 1", "t:1:4: unexpected '5'; expected a time such as 250ms" },
        { "at 5parsec expect 1", "t:1:4: unexpected '5parsec'; expected a time such as 250ms" },
        { "at 1.5ns expect 1", "t:1:4: unexpected '1.5ns'; expected a time" },
        { "at 86401s expect 1", "t:1:4: unexpected '86401s'; expected a time" },
        { "at 20ms expect 1\nat 5ms expect 1",
          "t:2:4: 5ms is before the 20ms of line 1; expected statements in order of time" },
        { "at 20ms expect 1\nend at 5ms", "t:2:8: this is before line 1; expected a later time" },
        { "set", "t:1:4: the line ends here; expected a register such as SERVO[0].Mode" },
        { "set SERVO[0].Mode", "t:1:18: the line ends here; expected '='" },
        { "set SERVO[0].mode = 1", "t:1:5: SERVO has no register 'mode'; did you mean Mode?" },
        { "set Servo[0].Mode = 1", "t:1:5: 'Servo' is no memory of generation 4; allowed: SYSTEM" },
        { "set SERVO[900].Mode = 1", "t:1:5: use SERVO[0] to SERVO[255]" },
        { "set MAIN.Reserve0 = 1", "t:1:5: this register is reserved; expected one that is not" },
        { "set DATA.U8[0] = ", "t:1:18: the line ends here; expected a register, a number or '('" },
        { "set DATA.U8[0] = 1 2",
          "t:1:20: unexpected '2'; expected an operator or the end of the line" },
        { "input DIO[0]", "t:1:13: the line ends here; expected 'channel'" },
        { "input DIO channel 1 = 1", "t:1:7: unexpected 'DIO'; expected DIO[n] or SERVO[n]" },
        { "input DIO[0] channel x = 1",
          "t:1:22: unexpected 'x'; expected the number of a channel, from 0" },
        { "fault # no", "t:1:7: the line ends here; expected a fault such as unplug after 1" },
        { "log hello", "t:1:5: unexpected 'hello'; expected a text in quotes" },
        { "log \"hello", "t:1:5: unexpected '\"hello'; expected a text in quotes" },
        { "expect 1 within", "t:1:16: the line ends here; expected a time such as 250ms" },
        { "expect 1 withn 2ms",
          "t:1:10: unexpected 'withn'; expected an operator, 'within', a message in quotes or the "
          "end of the line" },
        { "expect 1 \"a\" \"b\"", "t:1:14: unexpected '\"b\"'; expected the end of the line" },
        { "wait 1", "t:1:6: unexpected '1'; expected 'until'" },
        { "wait until 1",
          "t:1:13: the line ends here; expected an operator or 'within' and a time" },
        { "every 0ms expect 1", "t:1:7: a time of 0 never passes; expected a longer one" },
        { "every 1ms set", "t:1:11: unexpected 'set'; expected 'from' or 'expect'" },
        { "every 1ms from 1ms set", "t:1:20: unexpected 'set'; expected 'to' or 'expect'" },
        { "every 1ms from 5ms to 5ms expect 1",
          "t:1:20: the end is not behind the begin; expected a later time" },
        { "every 1ms expect 1",
          "t:1:1: nothing says how long this lasts; expected 'end at TIME' in the last line" },
        { "repeat 2\nevery 1ms expect 1\nend",
          "t:2:1: a round of 'repeat' would never be over; expected from TIME to TIME" },
        { "repeat 0", "t:1:8: unexpected '0'; expected how often, 1 to 1000000" },
        { "log \"a\"\n repeat 2\nexpect 1", "t:2:2: this repeat has no 'end'" },
        { "end", "t:1:4: the line ends here; expected 'at' or 'after' and a time: no repeat is "
                 "open here" },
        { "repeat 2\nend at 1s",
          "t:2:5: unexpected 'at'; expected the end of the line: a repeat is open here" },
        { "end at 1s\nlog \"x\"",
          "t:2:1: unexpected 'log'; expected nothing more behind the end of the scenario" },
        { "repeat 1000000\nat 1s expect 1\nend",
          "t:3:1: the scenario may last longer than a day; expected less" },
        { "expect \x01", "t:1:8: a character that cannot be printed (0x01); expected text" },
        { "log \"\xC5\x99\" \xC5", "t:1:10: unexpected '?'; expected a register" },
        { "repeat 1\nrepeat 1\nrepeat 1\nrepeat 1\nrepeat 1\nrepeat 1\nrepeat 1\nrepeat 1\nrepeat "
          "1",
          "t:9:1: more than 8 repeats in one another" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        refuses(rows[i].text, rows[i].why);
}

static void a_damaged_expression_is_told_with_its_place_and_what_was_expected(void **state)
{
    static const struct {
        const char *text, *why;
    } rows[] = {
        { "expect SERVO[0].Status = 3", "t:1:24: unexpected '='; expected '==', which compares" },
        { "expect (1", "t:1:10: the line ends here; expected an operator or ')'" },
        { "expect 1)",
          "t:1:9: unexpected ')'; expected an operator, 'within', a message in quotes" },
        { "expect 1 +", "t:1:11: the line ends here; expected a register, a number or '('" },
        { "expect * 1", "t:1:8: unexpected '*'; expected a register, a number or '('" },
        { "expect ()", "t:1:9: unexpected ')'; expected a register, a number or '('" },
        { "expect abs(1, 2)", "t:1:13: unexpected ','; expected ')'" },
        { "expect min(1)", "t:1:13: unexpected ')'; expected ',' and another argument" },
        { "expect (1, 2)", "t:1:10: unexpected ','; expected ')'" },
        { "expect sin(1)", "t:1:8: there is no function 'sin'; expected abs, min or max" },
        { "expect 1 < 2 < 3", "t:1:14: a comparison of a comparison; expected && between two" },
        { "expect 1.5 % 2", "t:1:12: '%' of a floating-point number; expected whole numbers" },
        { "expect SERVO[0].Position & 1",
          "t:1:26: '&' of a floating-point number; expected whole numbers" },
        { "expect ~1.0", "t:1:8: '~' of a floating-point number; expected whole numbers" },
        { "expect SERVO[0].Position.bit(1)", "t:1:30: a floating-point register has no bits" },
        { "expect DATA.U8[0].bit(8)", "t:1:23: there is no such bit; expected 0 to 7" },
        { "expect DATA.U8[0].bit(x)", "t:1:23: unexpected 'x'; expected the number of a bit" },
        { "expect SERVO_READY_ENABEL",
          "t:1:8: unknown name 'SERVO_READY_ENABEL' (did you mean SERVO_READY_ENABLE?)" },
        { "expect qqqqqqqqqqqqqqqqqqq", "t:1:8: unknown name 'qqqqqqqqqqqqqqqqqqq'; expected a "
                                        "register such as SERVO[0].Status" },
        { "expect SERVO[0].Pg", "t:1:8: SERVO.Pg is a group of registers" },
        { "expect SERVO[x].Status", "t:1:8: 'SERVO' needs an index such as SERVO[0]" },
        { "expect 0x", "t:1:8: unexpected '0x'; expected a register" },
        { "expect 99999999999999999999999999", "t:1:8: unexpected '9999" },
        { "expect 5ms", "t:1:8: unexpected '5ms'; expected a register" },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        refuses(rows[i].text, rows[i].why);
}

static void depth_and_length_have_limits(void **state)
{
    char text[4096] = "expect ";
    size_t at = strlen(text);
    (void)state;
    memset(text + at, '(', 900);
    refuses(text, "t:1:72: the expression is too deep; expected at most 64 open brackets");
    memset(text + at, '-', 900);
    refuses(text, "t:1:72: the expression is too deep");
    at = (size_t)sprintf(text, "expect ");
    for (int i = 0; i < 70; i++)
        at += (size_t)sprintf(text + at, "min(1, ");
    refuses(text, "t:1:456: the expression is too deep");
    memset(text, '#', 1001);
    text[1001] = '\0';
    refuses(text, "t:1:1001: the line is too long; expected at most 1000 characters");
    at = 0;
    char *many = malloc(40 * 1001);
    assert_non_null(many);
    for (int i = 0; i < 1001; i++)
        at += (size_t)sprintf(many + at, "set DATA.U8[%d] = 1\n", i % 250);
    refuses(many, "t:1001:1: more than 1000 statements");
    at = 0;
    for (int i = 0; i < 257; i++)
        at += (size_t)sprintf(many + at, "set DATA.U8[%d] = 1\n", i);
    refuses(many, "t:257:5: more than 256 different registers");
    free(many);
}

/* --- what expressions are worth --- */

#define MEMORY 65536

static void expressions_are_computed(void **state)
{
    static const struct {
        const char *expression, *value;
    } rows[] = {
        { "7 / 2", "3" },
        { "-7 / 2", "-3" },
        { "7 / 2.0", "3.5" },
        { "7 % 3", "1" },
        { "-7 % 3", "-1" },
        { "1 + 2 * 3", "7" },
        { "(1 + 2) * 3", "9" },
        { "10 - 3 - 2", "5" },
        { "64 / 4 / 2", "8" },
        { "-2 * -3", "6" },
        { "- - 2", "2" },
        { "0x10 + 1", "17" },
        { "2e3", "2000" },
        { "2e-3", "0.002" },
        { "1E+2", "100" },
        { "6 & 2 == 2", "1" },
        { "1 | 6 ^ 4", "3" },
        { "~0", "-1" },
        { "!0 + !5", "1" },
        { "1 < 2 && 2 < 3", "1" },
        { "1 || 0 && 0", "1" },
        { "1 == 2 || 3 != 4", "1" },
        { "(1 < 2) == (3 >= 3)", "1" },
        { "1 <= 1.0", "1" },
        { "abs(-5)", "5" },
        { "abs(-2.5)", "2.5" },
        { "min(3, max(1, 2))", "2" },
        { "max(1, 2.5)", "2.5" },
        { "abs(min(-1, 1)) * 2", "2" },
        { "9223372036854775807", "9223372036854775807" },
        { "9223372036854775807 + 1", "9.223372036854776e+18" },
        { "9223372036854775807 * 2", "1.8446744073709552e+19" },
        { "(-9223372036854775807 - 1) / -1", "9.223372036854776e+18" },
        { "(-9223372036854775807 - 1) % -1", "0" },
        { "abs(-9223372036854775807 - 1)", "9.223372036854776e+18" },
        { "1 / 0 == 1 / 0", "0" },
        { "1 / 0 != 1 / 0", "1" },
        { "1 / 0 < 1 || 1 / 0 >= 1", "0" },
        { "!(1 % 0)", "1" },
        { "1 / 0.0", "inf" },
        { "0.1 + 0.2", "0.30000000000000004" },
        { "SERVO_READY_ENABLE", "3" },
        { "DATA.U8[0]", "200" },
        { "DATA.I8[0]", "-56" },
        { "DATA.U16[0]", "456" },
        { "DATA.U8[0].bit(7) + DATA.U8[0].bit(0)", "1" },
        { "DATA.I8[0].bit(7)", "1" },
        { "DATA.U64[8]", "1.8446744073709552e+19" },
        { "DATA.I64[8]", "-1" },
        { "DATA.F64[16]", "-2.25" },
        { "DATA.F32[24]", "0.5" },
        { "abs(DATA.F64[16]) < 3", "1" },
        { "DATA.U8[1] == 1 && DATA.U8[1] == DATA.U8[1]", "1" },
    };
    const double f64 = -2.25;
    const float f32 = 0.5f;
    char *memory = calloc(1, MEMORY);
    (void)state;
    assert_non_null(memory);
    memcpy(memory, "\xC8\x01", 2);
    memset(memory + 8, 0xFF, 8);
    memcpy(memory + 16, &f64, 8);
    memcpy(memory + 24, &f32, 4);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct play *play = calloc(1, sizeof *play);
        char text[256], told[SCENARIO_TEXT];
        snprintf(text, sizeof text, "log \"\" %s # behind", rows[i].expression);
        struct scenario *scenario = read(text);
        assert_non_null(play);
        play->scenario = scenario;
        for (size_t k = 0; k < scenario->register_count; k++)
            play->at[k] = memory + scenario->registers[k].reg.offset;
        const struct evidence_line line = { .value = play_value(
                                                play, &scenario->statements[0].expression) };
        scenario_tell_line(scenario, &line, told);
        if (strcmp(told + 1, rows[i].value) != 0)
            fail_msg("%s is %s, not %s", rows[i].expression, told + 1, rows[i].value);
        assert_string_equal(scenario->statements[0].expression.text, rows[i].expression);
        scenario_close(scenario);
        free(play);
    }
    free(memory);
}

static void a_register_takes_what_it_can_hold(void **state)
{
    static const struct {
        enum scalar type;
        bool is_double;
        double value;
        bool fits;
    } rows[] = {
        { U8, false, 255, true },
        { U8, false, 256, false },
        { U8, false, -1, false },
        { I8, false, -128, true },
        { I8, false, 128, false },
        { U16, false, 65535, true },
        { I32, true, -2147483648.0, true },
        { I32, true, 0.5, false },
        { U32, true, 4294967296.0, false },
        { I64, true, 0x1p63, false },
        { U64, true, 0x1p63, true },
        { U64, true, 0x1p64, false },
        { U64, false, -1, false },
        { F32, true, 0.1, true },
        { F64, false, 3, true },
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct scenario_value value = { .is_double = rows[i].is_double };
        char cell[9] = "12345678";
        if (value.is_double)
            value.d = rows[i].value;
        else
            value.i = (int64_t)rows[i].value;
        assert_int_equal(scenario_store(rows[i].type, cell, value), rows[i].fits);
        if (!rows[i].fits)
            assert_string_equal(cell, "12345678");
        else if (rows[i].type != F32)
            assert_true(scalar_get(rows[i].type, cell) == rows[i].value);
        assert_memory_equal(cell + scalar_size(rows[i].type),
                            &"12345678"[scalar_size(rows[i].type)], 8 - scalar_size(rows[i].type));
    }
}

/* --- what people read --- */

static char *manual(void)
{
    char *text = calloc(1, 65536);
    FILE *file = fopen("docs/scenarios.md", "r");
    assert_non_null(file);
    assert_non_null(text);
    const size_t size = fread(text, 1, 65535, file);
    fclose(file);
    assert_in_range(size, 1000, 65534);
    return text;
}

static void the_manual_has_every_statement(void **state)
{
    char *text = manual(), form[160];
    (void)state;
    for (size_t i = 0; scenario_grammar(i) != NULL; i++) {
        snprintf(form, sizeof form, "| `%s` |", scenario_grammar(i));
        if (strstr(text, form) == NULL)
            fail_msg("docs/scenarios.md has no %s", form);
    }
    free(text);
}

static void the_example_of_the_manual_reads(void **state)
{
    char *text = manual();
    char *begin = strstr(text, "```scenario\n"), *end;
    (void)state;
    assert_non_null(begin);
    begin += strlen("```scenario\n");
    end = strstr(begin, "```");
    assert_non_null(end);
    *end = '\0';
    scenario_close(read(begin));
    free(text);
}

/* The byte behind the text is on a page that nobody may read. */
static void a_text_cut_anywhere_is_read_to_its_end_and_no_further(void **state)
{
    static const char text[] =
        "at 1ms input DIO[01] channel 0 = 0x1F\n"
        "after 1.5ms set SERVO[12].Mode = DATA.U8[0].bit(3) + 2e-3 * max(1, 2)\n"
        "every 1ms from 1ms to 2ms expect 1 <= 2 && !0 \"message\"\n"
        "wait until SERVO_READY_ENABLE != 0 within 1s\n"
        "repeat 2\nfault unplug after 1 for 20ms\nlog \"x\" 1\nend\nend at 86400s";
    const size_t room = 65536; /* whole pages */
    char why[SCENARIO_WHY];
    struct scenario *scenario;
    (void)state;
    char *page = mmap(NULL, 2 * room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_ptr_not_equal(page, MAP_FAILED);
    assert_int_equal(mprotect(page + room, room, PROT_NONE), 0);
    for (size_t length = 1; length < sizeof text; length++) {
        memcpy(page + room - length, text, length);
        const int r = scenario_read(&scenario, page + room - length, length, "t", layout(), why);
        assert_int_equal(r == 0, why[0] == '\0');
        scenario_close(scenario);
    }
    munmap(page, 2 * room);
}

/* The worker's numbers are looked at before they lead anywhere. */
static void evidence_that_points_nowhere_is_told_harmlessly(void **state)
{
    struct scenario *scenario = read("log \"x\"\nset DATA.U8[0] = 1\nfault mend\nexpect 1");
    char text[SCENARIO_TEXT];
    (void)state;
    for (uint32_t statement = 0; statement < 6; statement++)
        for (unsigned kind = 0; kind <= FAILURE_REFUSED; kind++) {
            const struct evidence_failure failure = { .statement = statement,
                                                      .kind = (enum evidence_failure_kind)kind,
                                                      .value_count = EVIDENCE_VALUES };
            const struct evidence_line line = { .statement = statement };
            scenario_tell(scenario, &failure, text);
            assert_memory_equal(text, "t:", 2);
            scenario_tell_line(scenario, &line, text);
        }
    scenario_close(scenario);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_statement_is_read),
        cmocka_unit_test(a_scenario_knows_how_long_it_may_take),
        cmocka_unit_test(a_damaged_line_is_told_with_its_place_and_what_was_expected),
        cmocka_unit_test(a_damaged_expression_is_told_with_its_place_and_what_was_expected),
        cmocka_unit_test(depth_and_length_have_limits),
        cmocka_unit_test(expressions_are_computed),
        cmocka_unit_test(a_register_takes_what_it_can_hold),
        cmocka_unit_test(the_manual_has_every_statement),
        cmocka_unit_test(the_example_of_the_manual_reads),
        cmocka_unit_test(a_text_cut_anywhere_is_read_to_its_end_and_no_further),
        cmocka_unit_test(evidence_that_points_nowhere_is_told_harmlessly),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
