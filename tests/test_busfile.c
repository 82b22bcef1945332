/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Bus files: the example of the manual, and what damaged ones are told. */
#include "bus_rig.h"

#include <stdio.h>
#include <unistd.h>

#include "bus/busfile.h"
#include "bus/scan.h"

#define MS 1000000u

#define T(f) cmocka_unit_test(f)

static const char example[] = "tests/devices/example.bus";

static char *contents(const char *path)
{
    char why[SCAN_WHY];
    size_t length;
    int error;
    char *text = scan_read_file(path, SCAN_FILE, &length, &error, why);

    assert_non_null(text);
    text[length] = '\0';
    return text;
}

static void the_example_of_the_manual_is_the_file_that_is_tested(void **state)
{
    char *manual = contents("docs/bus-files.md"), *file = contents(example);
    char *block = strstr(manual, "```\nuse"), *end;

    (void)state;
    assert_non_null(block);
    block += 4;
    end = strstr(block, "```");
    assert_non_null(end);
    *end = '\0';
    assert_string_equal(strchr(file, '\n') + 1, block);
    free(manual);
    free(file);
}

static struct busfile *opened(void)
{
    struct busfile *file;
    char why[LIBRARY_WHY];

    if (busfile_read(&file, example, why))
        fail_msg("%s", why);
    return file;
}

static void the_example_says_what_is_wired(void **state)
{
    static const char *const types[] = { "drive-cia402", "ek1100", "di-8", "ai-2", "pressure" };
    struct busfile *file = opened();
    const struct bus_stimulus *s;

    (void)state;
    assert_true(file->redundant);
    assert_int_equal(file->device_count, 5);
    for (size_t i = 0; i < 5; i++)
        assert_string_equal(file->devices[i].type, types[i]);
    assert_int_equal(file->devices[0].alias, 5);
    assert_int_equal(file->devices[3].identity.vendor, 0x1234);
    assert_int_equal(file->devices[3].identity.product, 0x5678);
    assert_int_equal(file->devices[3].identity.revision, 3);
    s = file->devices[2].stimuli;
    assert_int_equal(file->devices[2].stimulus_count, 1);
    assert_int_equal(s->kind, BUS_SQUARE);
    assert_int_equal(s->period_ns, 400 * MS);
    assert_int_equal(s->phase_ns, 100 * MS);
    s = file->devices[3].stimuli;
    assert_int_equal(file->devices[3].stimulus_count, 3);
    assert_int_equal(s[0].kind, BUS_TRIANGLE);
    assert_int_equal(s[0].amplitude, 16000);
    assert_int_equal(s[1].kind, BUS_CONSTANT);
    assert_int_equal(s[1].offset, 500);
    assert_int_equal(s[2].kind, BUS_NOISE);
    assert_int_equal(s[2].bit, 1);
    assert_int_equal(file->devices[4].stimuli[0].offset, 101325);
    busfile_close(file);
}

static void the_example_reaches_op_with_its_signals(void **state)
{
    struct busfile *file = opened();
    struct bus_config config = { .devices = file->devices,
                                 .device_count = file->device_count,
                                 .cycle_ns = MS,
                                 .seed = 3,
                                 .library = file->library };
    struct bus *bus;
    char why[BUS_WHY];
    uint64_t now;

    (void)state;
    if (bus_open(&bus, &config, why))
        fail_msg("%s", why);
    assert_int_equal(bus_slave(bus, 3)->vendor, 0x1234);
    bus_request_op(bus);
    now = bus_now(bus);
    for (unsigned i = 0; i < 100; i++) {
        bus_send(bus, now += MS);
        bus_receive(bus, now += MS);
        bus_poll_states(bus);
    }
    for (size_t i = 0; i < file->device_count; i++) {
        assert_int_equal(bus_slave(bus, i)->al_state, AL_OP);
    }
    assert_int_equal(bus_entry_get(bus_bits(bus, 2, BUS_INPUT, 0, 8)), 1);
    assert_in_range(bus_entry_sign(bus_find(bus, 3, BUS_INPUT, 0x3102, 2)), 480, 520);
    assert_in_range(bus_entry_sign(bus_find(bus, 4, BUS_INPUT, 0x6000, 0x11)), 101325, 103325);
    bus_close(bus);
    busfile_close(file);
}

static const struct {
    const char *text, *why;
} damaged[] = {
    { "", "1:1: the file names no device; expected one a line" },
    { "ring\n", "1:1: the file names no device; expected one a line" },
    { "di-9\n",
      "1:1: no device type \"di-9\" (did you mean \"di-8\"?); expected a device type, use, "
      "ring or input" },
    { "somethingelse\n",
      "1:1: no device type \"somethingelse\"; expected a device type (tgm device "
      "lists them), use, ring or input" },
    { "di-8 alais 5\n", "1:6: unknown word \"alais\" (did you mean \"alias\"?); expected vendor, "
                        "product, revision, alias or input" },
    { "di-8 alias 65536\n", "1:12: 65536 is out of range; expected alias, 1 to 0xFFFF" },
    { "di-8 vendor 0\n", "1:13: 0 is out of range; expected vendor, 1 to 0xFFFFFFFF" },
    { "di-8 input 8 square 1s\n", "1:12: 8 is out of range; expected the number of an input, 0 to "
                                  "7" },
    { "do-8 input 0 square 1s\n", "1:6: \"do-8\" has no inputs; expected a device with inputs" },
    { "input 0 square 1s\n", "1:1: an input of nothing; expected a device before it" },
    { "di-8 input 0 squere 1s\n", "1:14: unknown word \"squere\" (did you mean \"square\"?); "
                                  "expected the kind of signal" },
    { "di-8 input 0 square\n", "1:20: the line ends here; expected a period" },
    { "di-8 input 0 square 5\n",
      "1:21: \"5\" is no time; expected a period like 400ms, 2s, 250us or "
      "10ns" },
    { "di-8 input 0 square 0s\n", "1:21: a period of nothing; expected more than 0" },
    { "di-8 input 0 square 4000s\n",
      "1:21: 4000s is too long; expected a period of at most 3600s" },
    { "ai-2 input 0 sine 1s amplitude 3000000000\n",
      "1:32: 3000000000 is out of range; expected amplitude, -2147483648 to 2147483648" },
    { "di-8\nring now\n", "2:6: \"now\" is too much; expected the end of the line" },
    { "use pressure.device\n", "1:5: \"pressure.device\" is not in quotes; expected the path of a "
                               "device file or ESI file in quotes" },
};

static void damaged_files_are_told_line_column_and_expectation(void **state)
{
    char path[] = "/tmp/tgm-bus-XXXXXX", why[LIBRARY_WHY], expected[LIBRARY_WHY];
    struct busfile *file;

    (void)state;
    close(mkstemp(path));
    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        FILE *stream = fopen(path, "w");

        assert_non_null(stream);
        fputs(damaged[i].text, stream);
        fclose(stream);
        assert_int_equal(busfile_read(&file, path, why), -22);
        assert_null(file);
        snprintf(expected, sizeof expected, "%s:%s", path, damaged[i].why);
        assert_string_equal(why, expected);
    }
    unlink(path);
    assert_int_equal(busfile_read(&file, path, why), -2);
}

static void what_is_wrong_in_a_used_file_is_told_with_both_places(void **state)
{
    char folder[] = "/tmp/tgm-bus-XXXXXX", device[64], path[64], why[LIBRARY_WHY];
    char expected[LIBRARY_WHY];
    struct busfile *file;
    FILE *stream;

    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(device, sizeof device, "%s/a.device", folder);
    snprintf(path, sizeof path, "%s/a.bus", folder);
    stream = fopen(device, "w");
    fputs("device \"a\"\n", stream);
    fclose(stream);
    stream = fopen(path, "w");
    fputs("\nuse \"a.device\"\n", stream);
    fclose(stream);
    assert_int_equal(busfile_read(&file, path, why), -22);
    snprintf(expected, sizeof expected,
             "%s:2:5: %s:1:11: the line ends here; expected a description", path, device);
    assert_string_equal(why, expected);
    unlink(device);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(the_example_of_the_manual_is_the_file_that_is_tested),
        T(the_example_says_what_is_wired),
        T(the_example_reaches_op_with_its_signals),
        T(damaged_files_are_told_line_column_and_expectation),
        T(what_is_wrong_in_a_used_file_is_told_with_both_places),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
