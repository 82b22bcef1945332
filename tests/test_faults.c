/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The language of fault scripts: what is read, and what is said about what is not. The segment is a
 * drive, a terminal, a drive, a terminal. */
#include "bus_rig.h"

#include <errno.h>
#include <stdio.h>

#include "bus/fault_parts.h"

static const char *const types[] = { "drive-cia402", "dio-8x8", "drive-cia402", "dio-8x8" };

static int setup(void **state)
{
    *state = rig_new(types, 4);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

static struct fault_statement statement(struct rig *rig, const char *text)
{
    struct fault_statement rows[4];
    char why[FAULTS_WHY];
    size_t count;
    int error = fault_script_read(text, strlen(text), "t", &rig->segment, rows, &count, why);

    if (error)
        print_error("%s: %s\n", text, why);
    assert_int_equal(error, 0);
    assert_string_equal(why, "");
    assert_int_equal(count, 1);
    return rows[0];
}

static void times_are_exact_in_every_unit(void **state)
{
    static const struct {
        const char *text;
        uint64_t ns;
    } rows[] = {
        { "at 0s mend", 0 },          { "at 10ns mend", 10 },
        { "at 500us mend", 500000 },  { "at 250ms mend", 250000000 },
        { "at 1s mend", 1000000000 }, { "at 1.5s mend", 1500000000 },
        { "at 0.001us mend", 1 },     { "at 0.100000001s mend", 100000001 },
        { "at 1.0ns mend", 1 },       { "at 1000000s mend", 1000000000000000 },
    };

    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct fault_statement st = statement(*state, rows[i].text);

        assert_int_equal(st.when.at_ns, rows[i].ns);
        assert_true(st.when.to_ns == FAULT_NEVER);
        assert_false(st.when.from_start);
    }
}

static void a_statement_happens_when_it_says(void **state)
{
    struct fault_statement st = statement(*state, "from 1s to 2s lose 1% frames");

    assert_int_equal(st.when.at_ns, 1000000000);
    assert_int_equal(st.when.to_ns, 2000000000);
    st = statement(*state, "from start to 100ms mailbox 1 silent");
    assert_true(st.when.from_start);
    assert_int_equal(st.when.to_ns, 100000000);
    st = statement(*state, "at start eeprom 4 busy");
    assert_true(st.when.from_start);
    st = statement(*state, "every 50ms lose frame");
    assert_int_equal(st.when.every_ns, 50000000);
    assert_int_equal(st.when.at_ns, 50000000);
    st = statement(*state, "every 50ms from 1s to 2s short wkc at 1 for 3ms");
    assert_int_equal(st.when.at_ns, 1000000000);
    assert_int_equal(st.when.to_ns, 2000000000);
    assert_int_equal(st.action.lasts_ns, 3000000);
    st = statement(*state, "frame 17 unplug after 2");
    assert_int_equal(st.when.frame, 17);
}

static void frames_are_picked_in_five_ways(void **state)
{
    static const struct {
        const char *text;
        enum fault_pick pick;
        uint64_t number;
    } rows[] = {
        { "at 1s lose", FAULT_PICK_NEXT, 0 },
        { "at 1s lose frame", FAULT_PICK_NEXT, 1 },
        { "at 1s lose frame 17", FAULT_PICK_NUMBER, 17 },
        { "at 1s lose 1 frame", FAULT_PICK_COUNT, 1 },
        { "at 1s lose 3 frames", FAULT_PICK_COUNT, 3 },
        { "at 1s lose frames", FAULT_PICK_ALL, 0 },
        { "at 1s lose 1% frames", FAULT_PICK_SHARE, 10000 },
        { "at 1s lose 0.0001% frames", FAULT_PICK_SHARE, 1 },
        { "at 1s lose 100% frames", FAULT_PICK_SHARE, 1000000 },
    };
    struct fault_statement st;

    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        st = statement(*state, rows[i].text);
        assert_int_equal(st.action.pick, rows[i].pick);
        assert_int_equal(st.action.pick_number, rows[i].number);
        assert_false(st.action.seeded);
        assert_int_equal(st.action.given, 0);
    }
    st = statement(*state, "at 1s lose 1% frames seed 0x2a back");
    assert_true(st.action.seeded);
    assert_int_equal(st.action.seed, 42);
    assert_int_equal(st.action.given, 1);
    st = statement(*state, "frame 4 damage after 2");
    assert_int_equal(st.action.pick, FAULT_PICK_NEXT);
    assert_int_equal(st.action.place, 2);
    st = statement(*state, "frame 4 delay by 1.5ms");
    assert_int_equal(st.action.time_ns, 1500000);
}

static void arguments_are_taken_as_written(void **state)
{
    struct fault_action a = statement(*state, "at 1s drop 3 to SAFEOP code 0x001B").action;

    assert_int_equal(a.place, 3);
    assert_int_equal(a.al_state, AL_SAFEOP);
    assert_int_equal(a.code, 0x1b);
    a = statement(*state, "at 1s drop 2 to INIT").action;
    assert_int_equal(a.al_state, AL_INIT);
    assert_int_equal(a.code, 0);
    a = statement(*state, "at 1s mailbox 1 abort 0x06090011").action;
    assert_int_equal(a.code, 0x06090011);
    assert_int_equal(a.index, 0);
    a = statement(*state, "at 1s mailbox 1 abort 0x06090011 object 0x6060").action;
    assert_int_equal(a.index, 0x6060);
    assert_int_equal(a.subindex, -1);
    a = statement(*state, "at 1s mailbox 1 abort 5 object 0x1c12:3 for 1s").action;
    assert_int_equal(a.index, 0x1c12);
    assert_int_equal(a.subindex, 3);
    a = statement(*state, "at 1s drive 3 fault 0x3210").action;
    assert_int_equal(a.axis, 1);
    assert_int_equal(a.code, 0x3210);
    a = statement(*state, "at 1s input 2.7 value 1").action;
    assert_int_equal(a.place, 2);
    assert_int_equal(a.channel, 7);
    assert_int_equal(a.value, 1);
    a = statement(*state, "at 1s input 4.0 stuck at -5").action;
    assert_int_equal(a.value, -5);
    a = statement(*state, "at 1s input 4.0 noise 100 seed 3").action;
    assert_int_equal(a.value, 100);
    assert_int_equal(a.seed, 3);
    a = statement(*state, "at 1s dc 1 drift -12.5 ppm").action;
    assert_int_equal(a.value, -12500);
    a = statement(*state, "at 1s dc 1 drift +50").action;
    assert_int_equal(a.value, 50000);
    a = statement(*state, "at 1s dc 1 jitter 200ns").action;
    assert_int_equal(a.time_ns, 200);
    assert_string_equal(a.text, "dc 1 jitter 200ns");
}

static void comments_blank_lines_and_line_ends_of_all_kinds_are_fine(void **state)
{
    static const char text[] = "# a bad day\n\n  \t\r\nat 1s unplug after 2 # pulled\r\n"
                               "\tat   2s\tplug after 2#plugged\nat 3s mend";
    struct fault_statement rows[4];
    struct rig *rig = *state;
    char why[FAULTS_WHY];
    size_t count;

    assert_int_equal(
        fault_script_read(text, sizeof text - 1, "t", &rig->segment, rows, &count, why), 0);
    assert_int_equal(count, 3);
    assert_string_equal(rows[0].action.text, "unplug after 2");
    assert_string_equal(rows[1].action.text, "plug after 2");
    assert_int_equal(rows[1].when.at_ns, 2000000000);
    assert_string_equal(rows[2].action.text, "mend");
}

#define VERBS                                                                                      \
    "lose, delay, duplicate, damage, short, unplug, plug, power, drop, mailbox, eeprom, drive, "   \
    "input, dc, watchdog or mend"

static const struct {
    const char *text, *why;
} damaged[] = {
    { "unplug after 2", "f:1:1: unexpected 'unplug'; expected at, from, every or frame" },
    { "at 1s", "f:1:6: the line ends here; expected " VERBS },
    { "at 1s unplgu after 2",
      "f:1:7: unknown fault 'unplgu' (did you mean 'unplug'?); expected " VERBS },
    { "at 1s qwertyuiop", "f:1:7: unknown fault 'qwertyuiop'; expected " VERBS },
    { "at 1s unplug 2", "f:1:14: unexpected '2'; expected 'after'" },
    { "at 1s unplug after 9", "f:1:20: there is no slave 9; expected a slave from 0 to 3" },
    { "at 1s unplug after 4",
      "f:1:20: no cable leads away from the last slave; expected a slave from 0 to 3" },
    { "at 1s unplug after two", "f:1:20: unexpected 'two'; expected a slave from 0 to 3" },
    { "at 1s unplug after 2 for", "f:1:25: the line ends here; expected a time such as 250ms" },
    { "at 1s unplug after 2 for 3", "f:1:26: unexpected '3'; expected a time such as 250ms" },
    { "at 1s unplug after 2 now",
      "f:1:22: unexpected 'now'; expected 'for' or the end of the line" },
    { "at 1s plug after 2 for 3s", "f:1:20: unexpected 'for'; expected the end of the line" },
    { "at 250 mend", "f:1:4: unexpected '250'; expected a time such as 250ms" },
    { "at -1s mend", "f:1:4: unexpected '-1s'; expected a time such as 250ms" },
    { "at 1.2345ns mend", "f:1:4: unexpected '1.2345ns'; expected a time such as 250ms" },
    { "at 99999999999s mend", "f:1:4: unexpected '99999999999s'; expected a time such as 250ms" },
    { "at 1min mend", "f:1:4: unexpected '1min'; expected a time such as 250ms" },
    { "from 2s to 1s lose frames",
      "f:1:12: the end is not behind the begin; expected a later time" },
    { "from 1s lose frames", "f:1:9: unexpected 'lose'; expected 'to'" },
    { "from 1s to 2s lose",
      "f:1:15: which frames; expected 'frame', 'frames', 'N frames' or 'P% frames'" },
    { "from 1s to 2s plug after 1",
      "f:1:15: this is over at once; expected 'at' and a time in front of it" },
    { "from 1s to 2s power cycle 1",
      "f:1:15: this lasts by itself; expected 'at' and a time in front of it" },
    { "from 1s to 2s lose frames for 1s",
      "f:1:15: this lasts by itself; expected 'at' and a time in front of it" },
    { "at 1s lose for 1s",
      "f:1:7: which frames; expected 'frame', 'frames', 'N frames' or 'P% frames'" },
    { "at 1s lose 0 frames", "f:1:12: unexpected '0'; expected 'frame', 'frames', 'N frames', 'P% "
                             "frames', 'back', 'for' or the end of the line" },
    { "at 1s lose 3", "f:1:13: the line ends here; expected 'frames'" },
    { "at 1s lose 0% frames",
      "f:1:12: unexpected '0%'; expected a share such as 0.5%, up to 100%" },
    { "at 1s lose 101% frames",
      "f:1:12: unexpected '101%'; expected a share such as 0.5%, up to 100%" },
    { "at 1s lose 1% frames seed", "f:1:26: the line ends here; expected a seed such as 7" },
    { "at 1s lose 1% frames seed x", "f:1:27: unexpected 'x'; expected a seed such as 7" },
    { "at 1s lose frame 0",
      "f:1:18: unexpected '0'; expected a frame's number, 'back', 'for' or the end of the line" },
    { "at 1s delay 3 frames", "f:1:21: the line ends here; expected 'by'" },
    { "at 1s delay 3 frames by 0s", "f:1:25: unexpected '0s'; expected a time such as 250ms" },
    { "every 1s unplug after 1",
      "f:1:10: how long each time is open; expected 'for' and a time at the end of the line" },
    { "every 1s unplug after 1 for 1s",
      "f:1:10: this lasts until it begins again; expected a shorter time" },
    { "every 0s lose frame", "f:1:7: unexpected '0s'; expected a time such as 250ms" },
    { "every 1s lose frame 17", "f:1:10: two times for one fault; expected 'N frames'" },
    { "every 1s from 2s lose frame", "f:1:18: unexpected 'lose'; expected 'to'" },
    { "frame 0 mend", "f:1:7: unexpected '0'; expected a frame's number, from 1" },
    { "frame 17 lose frame 18", "f:1:10: two times for one fault; expected 'N frames'" },
    { "at 1s short wkc at 0", "f:1:20: there is no slave 0; expected a slave from 1 to 4" },
    { "at 1s short 2", "f:1:13: unexpected '2'; expected 'wkc'" },
    { "at 1s power up 2", "f:1:13: unexpected 'up'; expected 'off', 'on' or 'cycle'" },
    { "at 1s power off 5", "f:1:17: there is no slave 5; expected a slave from 1 to 4" },
    { "at 1s drop 1 to OP", "f:1:17: unexpected 'OP'; expected INIT, PREOP or SAFEOP" },
    { "at 1s drop 2 to SAFEOP code 0x1B", "f:1:12: slave 2 (dio-8x8) cannot have this fault; "
                                          "expected a slave whose processor gives AL codes" },
    { "at 1s drop 1 to SAFEOP code 0", "f:1:29: unexpected '0'; expected a code such as 0x001B" },
    { "at 1s drop 1 to SAFEOP code 0x10000",
      "f:1:29: unexpected '0x10000'; expected a code such as 0x001B" },
    { "at 1s mailbox 1 mute",
      "f:1:17: unexpected 'mute'; expected 'silent', 'malformed' or 'abort'" },
    { "at 1s mailbox 2 silent",
      "f:1:15: slave 2 (dio-8x8) cannot have this fault; expected a slave with a CoE mailbox" },
    { "at 1s mailbox 1 abort",
      "f:1:22: the line ends here; expected an abort code such as 0x06090011" },
    { "at 1s mailbox 1 abort 0x06090011 object",
      "f:1:40: the line ends here; expected an object such as 0x6060 or 0x6060:0" },
    { "at 1s mailbox 1 abort 0x06090011 object 0x6060:x",
      "f:1:41: unexpected '0x6060:x'; expected an object such as 0x6060 or 0x6060:0" },
    { "at 1s mailbox 1 abort 0x06090011 object 0x6060:256",
      "f:1:41: unexpected '0x6060:256'; expected an object such as 0x6060 or 0x6060:0" },
    { "at 1s eeprom 1 lazy", "f:1:16: unexpected 'lazy'; expected 'busy' or 'nack'" },
    { "at 1s drive 2 fault 0x3210",
      "f:1:13: slave 2 (dio-8x8) cannot have this fault; expected a drive" },
    { "at 1s drive 1 axis 2 fault 0x3210",
      "f:1:13: slave 1 (drive-cia402) cannot have this fault; expected an axis that it has" },
    { "at 1s drive 1 axis 0 fault 0x3210", "f:1:20: unexpected '0'; expected an axis from 1 to 8" },
    { "at 1s drive 1 fault", "f:1:20: the line ends here; expected a code such as 0x001B" },
    { "at 1s drive 1 fault 0", "f:1:21: unexpected '0'; expected a code such as 0x001B" },
    { "at 1s input 2 stuck",
      "f:1:13: unexpected '2'; expected an input such as 2.0: slave, channel from 0" },
    { "at 1s input 2.x stuck",
      "f:1:13: unexpected '2.x'; expected an input such as 2.0: slave, channel from 0" },
    { "at 1s input 7.0 stuck",
      "f:1:13: there is no slave 7; expected an input such as 2.0: slave, channel from 0" },
    { "at 1s input 2.8 stuck",
      "f:1:13: slave 2 (dio-8x8) cannot have this fault; expected an input that it has" },
    { "at 1s input 2.0 loose", "f:1:17: unexpected 'loose'; expected 'stuck', 'noise' or 'value'" },
    { "at 1s input 2.0 noise 0", "f:1:23: unexpected '0'; expected an amplitude such as 100" },
    { "at 1s input 2.0 value",
      "f:1:22: the line ends here; expected a number such as 12, -5 or 0x1f" },
    { "at 1s dc 2 drift 5", "f:1:10: slave 2 (dio-8x8) cannot have this fault; expected a slave "
                            "with a distributed clock" },
    { "at 1s dc 1 drift 1001", "f:1:18: unexpected '1001'; expected ppm from -1000 to 1000" },
    { "at 1s dc 1 drift 1.0001", "f:1:18: unexpected '1.0001'; expected ppm from -1000 to 1000" },
    { "at 1s dc 1 jitter 5", "f:1:19: unexpected '5'; expected a time such as 250ms" },
    { "at 1s dc 1 jitter 2ms",
      "f:1:10: slave 1 (drive-cia402) cannot have this fault; expected jitter up to 1ms" },
    { "at 1s watchdog 1 bark", "f:1:18: unexpected 'bark'; expected 'expire'" },
    { "at 1s mend 5", "f:1:12: there is no slave 5; expected a slave from 1 to 4" },
    { "at 1s mend all", "f:1:12: unexpected 'all'; expected a slave from 1 to 4" },
};

static void a_damaged_line_is_told_with_its_place_and_what_was_expected(void **state)
{
    struct rig *rig = *state;
    char why[FAULTS_WHY];
    struct faults *faults;

    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        const char *text = damaged[i].text;

        assert_int_equal(faults_open(&faults, text, strlen(text), "f", &rig->segment, 1, why),
                         -EINVAL);
        assert_null(faults);
        if (strcmp(why, damaged[i].why) != 0)
            print_error("%s\n", text);
        assert_string_equal(why, damaged[i].why);
    }
}

static void the_line_of_a_script_is_counted(void **state)
{
    static const char text[] = "# one\n\nat 1s mend\r\n  at 2s menda\n";
    struct rig *rig = *state;
    char why[FAULTS_WHY];
    struct faults *faults;

    assert_int_equal(
        faults_open(&faults, text, sizeof text - 1, "dir/x.faults", &rig->segment, 1, why),
        -EINVAL);
    assert_memory_equal(why, "dir/x.faults:4:9: unknown fault 'menda' (did you mean 'mend'?)", 62);
}

static void words_of_other_worlds_are_shown_printable(void **state)
{
    static const char text[] = "at 1s \x1b[31m\0\xff";
    struct rig *rig = *state;
    char why[FAULTS_WHY], long_text[600];
    struct faults *faults;

    assert_int_equal(faults_open(&faults, text, sizeof text - 1, "f", &rig->segment, 1, why),
                     -EINVAL);
    assert_memory_equal(why, "f:1:7: unknown fault '?[31m?\?'; ", 32);
    memset(long_text, 'a', sizeof long_text);
    assert_int_equal(faults_open(&faults, long_text, sizeof long_text, "f", &rig->segment, 1, why),
                     -EINVAL);
    assert_string_equal(why, "f:1:1: unexpected 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa...'; "
                             "expected at, from, every or frame");
    for (size_t i = 1; i < sizeof long_text; i += 2)
        long_text[i] = ' ';
    assert_int_equal(faults_open(&faults, long_text, sizeof long_text, "f", &rig->segment, 1, why),
                     -EINVAL);
    assert_string_equal(why,
                        "f:1:65: more words than any statement has; expected the end of the line");
}

static void a_script_has_an_end(void **state)
{
    struct rig *rig = *state;
    char *text = malloc(FAULTS_STATEMENTS * 11 + 12);
    char why[FAULTS_WHY];
    struct faults *faults;

    assert_non_null(text);
    for (size_t i = 0; i <= FAULTS_STATEMENTS; i++)
        memcpy(text + i * 11, "at 1s mend\n", 11);
    assert_int_equal(faults_open(&faults, text, FAULTS_STATEMENTS * 11, "f", &rig->segment, 1, why),
                     0);
    faults_close(faults);
    assert_int_equal(
        faults_open(&faults, text, FAULTS_STATEMENTS * 11 + 11, "f", &rig->segment, 1, why),
        -EINVAL);
    assert_string_equal(why, "f:1001:1: too many statements; expected 1000 at most");
    free(text);
}

static void a_ring_has_one_more_cable(void **state)
{
    struct rig *rig = *state;

    segment_close_ring(&rig->segment, true, 0);
    assert_int_equal(statement(rig, "at 1s unplug after 4").action.place, 4);
}

static void a_command_is_an_action_alone(void **state)
{
    static const struct {
        const char *text, *why;
    } bad[] = {
        { "", "column 1: the line ends here; expected " VERBS },
        { "at 1s mend", "column 1: unknown fault 'at'; expected " VERBS },
        { "unplug after 7", "column 14: there is no slave 7; expected a slave from 0 to 3" },
        { "lose 3 frames x",
          "column 15: unexpected 'x'; expected 'back', 'for' or the end of the line" },
    };
    struct rig *rig = *state;
    struct fault_action action;
    char why[FAULTS_WHY];

    assert_int_equal(fault_parse(&action, "unplug after 2 for 20ms", &rig->segment, why), 0);
    assert_int_equal(action.place, 2);
    assert_int_equal(action.lasts_ns, 20000000);
    assert_string_equal(action.verb->name, "unplug");
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_equal(fault_parse(&action, bad[i].text, &rig->segment, why), -EINVAL);
        assert_string_equal(why, bad[i].why);
    }
}

static void every_verb_has_an_example_that_reads(void **state)
{
    struct fault_verb_text verb;

    for (size_t i = 0; fault_verb_text(i, &verb); i++) {
        struct fault_statement st = statement(*state, verb.example);

        assert_string_equal(st.action.verb->name, verb.name);
        assert_string_equal(st.action.verb->grammar, verb.grammar);
    }
}

/* docs/faults.md is what people read: every form, what it does, and the example. */
static void the_manual_has_every_verb(void **state)
{
    struct fault_verb_text verb;
    char form[128], *manual;
    size_t size;
    FILE *file = fopen("docs/faults.md", "r");

    (void)state;
    assert_non_null(file);
    manual = calloc(1, 65536);
    assert_non_null(manual);
    size = fread(manual, 1, 65535, file);
    fclose(file);
    assert_in_range(size, 1000, 65534);
    for (size_t i = 0; fault_verb_text(i, &verb); i++) {
        snprintf(form, sizeof form, "`%s %s`", verb.name, verb.grammar);
        if (!strstr(manual, form) || !strstr(manual, verb.help) || !strstr(manual, verb.example))
            print_error("docs/faults.md: | %s | %s | `%s` |\n", form, verb.help, verb.example);
        assert_non_null(strstr(manual, form));
        assert_non_null(strstr(manual, verb.help));
        assert_non_null(strstr(manual, verb.example));
    }
    free(manual);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(times_are_exact_in_every_unit),
        T(a_statement_happens_when_it_says),
        T(frames_are_picked_in_five_ways),
        T(arguments_are_taken_as_written),
        T(comments_blank_lines_and_line_ends_of_all_kinds_are_fine),
        T(a_damaged_line_is_told_with_its_place_and_what_was_expected),
        T(the_line_of_a_script_is_counted),
        T(words_of_other_worlds_are_shown_printable),
        T(a_script_has_an_end),
        T(a_ring_has_one_more_cable),
        T(a_command_is_an_action_alone),
        T(every_verb_has_an_example_that_reads),
        T(the_manual_has_every_verb),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
