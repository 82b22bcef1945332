/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Device files: the example of the manual, what damaged ones are told, and the way back. */
#include "bus_rig.h"

#include <stdio.h>
#include <unistd.h>

#include "bus/bus.h"
#include "bus/description.h"
#include "bus/library.h"

#define MS 1000000u

#define T(f) cmocka_unit_test(f)

static const char example[] = "tests/devices/pressure.device";

static char *contents(const char *path)
{
    char why[SCAN_WHY];
    size_t length;
    int error;
    char *text = scan_read_file(path, SCAN_FILE, &length, &error, why);

    assert_non_null(text);
    text[length] = '\0'; /* scan_read_file() has room for one byte more than it may return */
    return text;
}

static void the_example_of_the_manual_is_the_file_that_is_tested(void **state)
{
    char *manual = contents("docs/device-files.md"), *file = contents(example);
    char *block = strstr(manual, "```\n# A pressure"), *end;

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

static void the_example_becomes_the_type_it_describes(void **state)
{
    struct bus_library *library;
    char why[LIBRARY_WHY];
    const struct device_type *type;
    const struct od_entry *e;

    (void)state;
    assert_int_equal(library_open(&library), 0);
    if (library_load(library, example, why))
        fail_msg("%s", why);
    type = library_find(library, "pressure");
    assert_non_null(type);
    assert_string_equal(type->description, "pressure sensor with a valve");
    assert_int_equal(type->sii->product, 0x00500001);
    assert_int_equal(type->sii->revision, 0x00010002);
    assert_string_equal(type->sii->name, "Pressure sensor P1");
    assert_string_equal(type->sii->order, "P1-400");
    assert_string_equal(type->sii->group, "Sensors");
    assert_int_equal(type->sii->pdi_control, 0x0c08);
    assert_int_equal(type->sii->dc_assign, 0x0300);
    assert_int_equal(type->sii->ports, 0x0011);
    assert_int_equal(type->sii->coe_details, 0x27);
    assert_int_equal(type->sii->protocols, 4);
    assert_int_equal(type->sii->mailbox.in_start, 0x1080);
    assert_int_equal(type->sii->sm[2].control, 0x64);
    assert_int_equal(type->sii->fmmu[2], 3);
    assert_int_equal(type->sii->tx[0].entries[3].bits, 32);
    assert_int_equal(type->sii->tx[0].entries[2].index, 0);
    assert_int_equal(type->input_count, 2);
    assert_true(type->dc && !type->dc_delay_only && !type->al_emulation);
    assert_string_equal(od_entry(od_find(type->od, 0x100a), 0)->text, "1.2");
    assert_string_equal(od_entry(od_find(type->od, 0x1008), 0)->text, "Pressure sensor P1");
    e = od_entry(od_find(type->od, 0x8000), 2);
    assert_int_equal(e->access, OD_RW_PREOP);
    assert_int_equal(e->initial, -3);
    assert_int_equal(od_entry(od_find(type->od, 0x8000), 0)->initial, 2);
    assert_int_equal(od_entry(od_find(type->od, 0x1a00), 4)->initial, 0x60001120);
    assert_int_equal(od_entry(od_find(type->od, 0x1c00), 4)->initial, SII_SM_INPUTS);
    library_close(library);
}

static void the_example_works_under_soem(void **state)
{
    static const struct bus_device devices[] = { { .type = "pressure" } };
    struct bus_library *library;
    struct bus_config config = { .devices = devices, .device_count = 1, .cycle_ns = MS };
    struct bus *bus;
    char why[LIBRARY_WHY];
    uint64_t now;
    uint8_t open = 9;
    size_t size = 1;

    (void)state;
    assert_int_equal(library_open(&library), 0);
    assert_int_equal(library_load(library, example, why), 0);
    config.library = library;
    if (bus_open(&bus, &config, why))
        fail_msg("%s", why);
    assert_string_equal(bus_slave(bus, 0)->name, "Pressure sensor P1");
    assert_int_equal(bus_sdo_read(bus, 0, 0x7000, 1, &open, &size, NULL), 0);
    assert_int_equal(open, 1); /* its safe value */
    assert_int_equal(bus_set_input(bus, 0, 0, -98765), 0);
    assert_int_equal(bus_set_input(bus, 0, 1, 1), 0);
    bus_entry_set(bus_find(bus, 0, BUS_OUTPUT, 0x7000, 1), 0);
    bus_request_op(bus);
    now = bus_now(bus);
    for (unsigned i = 0; i < 50; i++) {
        bus_send(bus, now += MS);
        bus_receive(bus, now += MS);
        bus_poll_states(bus);
    }
    assert_int_equal(bus_slave(bus, 0)->al_state, AL_OP);
    assert_int_equal(bus_entry_sign(bus_find(bus, 0, BUS_INPUT, 0x6000, 0x11)), -98765);
    assert_int_equal(bus_entry_get(bus_find(bus, 0, BUS_INPUT, 0x6000, 2)), 1);
    assert_int_equal(bus_entry_get(bus_find(bus, 0, BUS_INPUT, 0x6000, 1)), 0);
    bus_sdo_read(bus, 0, 0x7000, 1, &open, &size, NULL);
    assert_int_equal(open, 0);
    bus_close(bus);
    library_close(library);
}

static void outputs_are_safe_after_power_on(void **state)
{
    struct bus_library *library;
    struct slave *slave = calloc(1, sizeof *slave);
    struct slave_setup setup = { .serial = 77 };
    char why[LIBRARY_WHY];
    uint8_t bytes[4];
    size_t size = 4;

    (void)state;
    assert_int_equal(library_open(&library), 0);
    assert_int_equal(library_load(library, example, why), 0);
    setup.type = library_find(library, "pressure");
    setup.device = calloc(1, setup.type->size);
    assert_int_equal(slave_init(slave, &setup), 0);
    slave_power_on(slave, 5);
    assert_int_equal(od_read(setup.type->od, setup.device, AL_PREOP, 0x7000, 1, bytes, &size), 0);
    assert_int_equal(bytes[0], 1);
    size = 4;
    assert_int_equal(od_read(setup.type->od, setup.device, AL_PREOP, 0x1018, 4, bytes, &size), 0);
    assert_int_equal(get_u32(bytes), 77);
    free(setup.device);
    free(slave);
    library_close(library);
}

static int read_text(const char *text, char why[SCAN_WHY])
{
    struct description *d = description_new("x.device");
    struct terminal_type *type = NULL;
    int error;

    assert_non_null(d);
    error = device_file_read(d, text, strlen(text), why);
    if (!error)
        error = description_build(d, &type, why);
    free(type);
    free(d);
    return error;
}

#define HEAD   "device \"a\" \"b\"\nvendor 1 product 2\n"
#define BOX    "sm 0 0x1000 128 mailbox-out\nsm 1 0x1080 128 mailbox-in\n"
#define COE    HEAD "coe\n" BOX "sm 2 0x1100 0 outputs\nsm 3 0x1180 2 inputs\n"
#define TX     "pdo tx 0x1A00 sm 3 \"T\"\n  entry 0x6000:01 i16 \"V\"\n"
#define OBJECT "object 0x6000 \"O\"\n  entry 0x6000:01 i16 ro 0 \"V\"\n"

static const struct {
    const char *text, *why;
} damaged[] = {
    { "", "x.device:1:1: the file describes nothing; expected device \"name\" \"description\"" },
    { "vendor 1\n", "x.device:1:1: \"vendor\" comes first; expected \"device\" as the first "
                    "statement" },
    { "device \"a\"\n", "x.device:1:11: the line ends here; expected a description" },
    { "device a \"b\"\n", "x.device:1:8: \"a\" is not in quotes; expected a type name in quotes" },
    { "device \"a \"b\"\n", "x.device:1:12: something sticks to a text; expected a blank behind "
                            "the closing \"" },
    { "device \"a\" \"b\n", "x.device:1:12: this text does not end; expected a closing \"" },
    { HEAD "vendr 5\n", "x.device:3:1: unknown word \"vendr\" (did you mean \"vendor\"?); expected "
                        "a statement" },
    { HEAD "device \"c\" \"d\"\n", "x.device:3:1: a second \"device\"; expected one" },
    { "device \"a\" \"b\"\nvendor x\n", "x.device:2:8: \"x\" is not a number; expected an id, 0 to "
                                        "0xFFFFFFFF" },
    { "device \"a\" \"b\"\nvendor 0x100000000\n", "x.device:2:8: 0x100000000 is out of range; "
                                                  "expected an id, 0 to 0xFFFFFFFF" },
    { "device \"a\" \"b\"\n", "x.device:1:1: no identity; expected a vendor and a product other "
                              "than 0" },
    { HEAD "emulation now\n", "x.device:3:11: \"now\" is too much; expected the end of the line" },
    { HEAD "dc fall\n", "x.device:3:4: unknown word \"fall\" (did you mean \"full\"?); expected "
                        "none, delay or full" },
    { HEAD "sm 1 0x1000 1 inputs\n", "x.device:3:4: sync manager 1; expected 0, in ascending "
                                     "order" },
    { HEAD "sm 0 0x0800 1 inputs\n",
      "x.device:3:1: sync manager 0 covers 0x0800 to 0x0800; expected to stay in the memory 0x0F00 "
      "to 0x2FFF (process data, three buffers)" },
    { HEAD "sm 0 0x1000 128 mailbox-out\n", "x.device:3:1: half a mailbox; expected both "
                                            "mailbox-out and mailbox-in" },
    { HEAD "sm 0 0x1000 8 mailbox-out\n", "x.device:3:1: a mailbox of 8 bytes; expected 16 to "
                                          "1024" },
    { HEAD "sm 0 0x1000 128 mailbox-in\n", "x.device:3:1: mailbox-in is sync manager 0; expected "
                                           "1" },
    { HEAD "sm 0 0x1000 128 mailbox-out\nsm 1 0x1040 128 mailbox-in\n",
      "x.device:4:1: sync managers 0 and 1 overlap: 0x1000 + 128 and 0x1040 + 128 bytes (process "
      "data counts three times); expected apart" },
    { HEAD "emulation\n" BOX, "x.device:4:1: a mailbox without a processor to serve it; expected "
                              "no mailbox beside \"emulation\"" },
    { HEAD "coe\n", "x.device:3:1: CoE without a mailbox; expected sync managers mailbox-out and "
                    "mailbox-in" },
    { HEAD "sm 0 0x1000 0 inputs\nsm 1 0x1100 0 inputs\n",
      "x.device:4:1: sync manager 1 is a second one for inputs; expected one of each" },
    { HEAD "sm 0 0x1000 1 inputs\npdo tx 0x1A00 \"T\"\n",
      "x.device:4:1: PDO 0x1A00 is in no sync manager; expected \"sm N\" (only CoE can assign it "
      "later)" },
    { HEAD "sm 0 0x1000 1 inputs\npdo rx 0x1600 sm 0 \"R\"\n",
      "x.device:4:1: PDO 0x1600 is in sync manager 0; expected one of type outputs" },
    { HEAD "sm 0 0x1000 1 inputs\npdo tx 0x1600 sm 0 \"R\"\n",
      "x.device:4:1: tx PDO 0x1600; expected 0x1A00 to 0x1BFF" },
    { COE TX TX OBJECT, "x.device:10:1: PDO 0x1A00 stands in line 8 already; expected each once" },
    { COE "pdo tx 0x1A01 \"U\"\n" TX OBJECT, "x.device:9:1: PDO 0x1A00 behind 0x1A01; expected "
                                             "ascending indices" },
    { COE TX, "x.device:9:3: 0x6000:01 is not in the object dictionary; expected an object with "
              "this entry" },
    { COE TX "object 0x6000 \"O\"\n  entry 0x6000:01 u8 ro \"V\"\n",
      "x.device:9:3: 0x6000:01 has 16 bits here and 8 in the object dictionary; expected the same "
      "type" },
    { COE TX OBJECT "object 0x5000 \"P\"\n  entry 0x5000:00 u8 ro \"V\"\n",
      "x.device:12:1: object 0x5000 behind 0x6000; expected ascending indices" },
    { COE TX OBJECT "object 0x7000 \"P\"\n", "x.device:12:1: object 0x7000 is empty; expected "
                                             "entries" },
    { COE TX OBJECT "  entry 0x6001:01 u8 ro \"V\"\n", "x.device:12:9: an entry of 0x6001; "
                                                       "expected one of object 0x6000" },
    { COE TX OBJECT "  entry 0x6000:01 u8 ro \"V\"\n", "x.device:12:3: subindex 1 behind 1; "
                                                       "expected ascending subindices" },
    { COE TX OBJECT "  entry 0x6000:02 u8 ro 256 \"V\"\n",
      "x.device:12:3: the initial value 256; expected 0 to 255" },
    { COE TX OBJECT "  entry 0x6000:02 u8 ro 5 range 6..9 \"V\"\n",
      "x.device:12:3: the initial value 5; expected 6 to 9" },
    { COE TX OBJECT "  entry 0x6000:02 u8 ro 5 range 0..300 \"V\"\n",
      "x.device:12:3: the range 0..300; expected within 0..255 of u8" },
    { COE TX OBJECT "  entry 0x6000:02 u8 ro 5 range 9..6 \"V\"\n",
      "x.device:12:33: 9..6 is empty; expected the smaller number first" },
    { COE TX OBJECT "  entry 0x6000:02 string rw \"T\" \"V\"\n",
      "x.device:12:3: a string that can be written; expected ro" },
    { COE TX "object 0x1018 \"I\"\n",
      "x.device:10:1: object 0x1018 follows from identity, PDOs and "
      "sync managers; expected another one" },
    { HEAD OBJECT, "x.device:3:1: objects of a device without CoE; expected a \"coe\" line" },
    { COE TX OBJECT "input 0x6000:02\n", "x.device:12:7: 0x6000:02 is in no tx PDO; expected an "
                                         "entry" },
    { COE TX OBJECT "input 0x6000:01\ninput 0x6000:01\n",
      "x.device:13:7: 0x6000:01 is channel 0 already; expected each once" },
    { COE TX OBJECT "input 0x6000:01 over 0x6000:01\n",
      "x.device:12:22: 0x6000:01 has 16 bits; expected 1" },
    { COE TX OBJECT "input 6000\n", "x.device:12:7: \"6000\" names no object; expected an entry of "
                                    "a tx PDO like 0x6000:01" },
    { COE "entry 0x6000:01 u8 \"V\"\n", "x.device:8:1: an entry of nothing; expected it behind "
                                        "\"pdo\" or \"object\"" },
    { COE "gap 3\n", "x.device:8:1: a gap outside of a PDO; expected it behind \"pdo\"" },
    { COE "pdo tx 0x1A00 sm 3 \"T\"\n  entry 0x6000:01 u61 \"V\"\n",
      "x.device:9:19: unknown word \"u61\" (did you mean \"u64\"?); expected a data type" },
    { COE "pdo tx 0x1A00 sm 3 \"T\"\n  entry 0x6000:01 string \"V\"\n",
      "x.device:9:3: a string in a PDO; expected a type of fixed size" },
    { HEAD "a\001b\n", "x.device:3:2: byte 0x01; expected text" },
    { HEAD "ports mii mii mii mii mii\n", "x.device:3:23: \"mii\" is too much; expected the end of "
                                          "the line" },
};

static void damaged_files_are_told_line_column_and_expectation(void **state)
{
    char why[SCAN_WHY];

    (void)state;
    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        why[0] = '\0';
        assert_int_equal(read_text(damaged[i].text, why), -22);
        assert_string_equal(why, damaged[i].why);
    }
}

static void an_image_larger_than_the_memory_is_refused(void **state)
{
    char text[8192] = HEAD "sm 0 0x2F00 0 inputs\npdo tx 0x1A00 sm 0 \"T\"\n", why[SCAN_WHY];

    (void)state;
    for (unsigned i = 0; i < 85; i++)
        snprintf(text + strlen(text), 64, "  entry 0x6000:%02X u8 \"V\"\n", i);
    assert_int_equal(read_text(text, why), 0);
    strcat(text, "  entry 0x6000:55 u8 \"V\"\n");
    assert_int_equal(read_text(text, why), -22);
    assert_string_equal(why, "x.device:3:1: sync manager 0 covers 0x2F00 to 0x3001; expected to "
                             "stay in the memory 0x0F00 to 0x2FFF (process data, three buffers)");
}

static void more_than_an_sii_holds_is_refused(void **state)
{
    static char text[65536];
    char why[SCAN_WHY];

    (void)state;
    strcpy(text, HEAD "sm 0 0x1000 0 inputs\npdo tx 0x1A00 sm 0 \"T\"\n");
    for (unsigned i = 0; i < 240; i++)
        snprintf(text + strlen(text), 64, "  entry 0x6000:%02X bool \"V\"\n", i);
    assert_int_equal(read_text(text, why), -22);
    assert_string_equal(why, "x.device:1:1: names and PDOs do not fit into the SII; expected at "
                             "most 2048 bytes");
}

static void counts_and_lengths_have_their_limits(void **state)
{
    static char text[200000];
    char why[SCAN_WHY];

    (void)state;
    strcpy(text, HEAD "# ");
    memset(text + strlen(text), 'x', 1100);
    assert_int_equal(read_text(text, why), -22);
    assert_string_equal(why, "x.device:3:1025: this line is too long; expected at most 1024 "
                             "characters");
    memset(text, 0, sizeof text);
    strcpy(text, HEAD);
    for (unsigned i = 0; i < 65; i++)
        snprintf(text + strlen(text), 64, "pdo tx 0x%04X \"T\"\n", 0x1a00 + i);
    assert_int_equal(read_text(text, why), -22);
    assert_string_equal(why, "x.device:67:1: too many PDOs; expected at most 64");
    strcpy(text, HEAD);
    for (unsigned i = 0; i < 65; i++)
        strcat(text, "x ");
    assert_int_equal(read_text(text, why), -22);
    assert_string_equal(why, "x.device:3:129: too many words; expected at most 64 in a line");
}

static void every_file_cut_anywhere_is_read_or_refused(void **state)
{
    char *text = contents(example), why[SCAN_WHY];
    size_t length = strlen(text);

    (void)state;
    while (length--) {
        text[length] = '\0';
        why[0] = '\0';
        if (read_text(text, why))
            assert_int_equal(strncmp(why, "x.device:", 9), 0);
    }
    free(text);
}

static char *written(const struct description *d)
{
    char *text = NULL;
    size_t length;
    FILE *stream = open_memstream(&text, &length);

    assert_non_null(stream);
    device_file_write(d, stream);
    fclose(stream);
    return text;
}

static void what_is_written_reads_back_the_same(void **state)
{
    static const char *const names[] = { "dio-8x8", "ek1100", "di-8", "di-16",   "do-8",
                                         "do-16",   "ai-2",   "ao-2", "strain-1" };

    (void)state;
    for (size_t i = 0; i <= sizeof names / sizeof *names; i++) {
        bool last = i == sizeof names / sizeof *names;
        char *text = last ? contents(example) : strdup(device_text(names[i]));
        struct description *a = description_new("a"), *b = description_new("b");
        char why[SCAN_WHY], *first, *second;

        assert_int_equal(device_file_read(a, text, strlen(text), why), 0);
        first = written(a);
        if (device_file_read(b, first, strlen(first), why))
            fail_msg("%s", why);
        second = written(b);
        assert_string_equal(first, second);
        assert_int_equal(a->row_count, b->row_count);
        assert_int_equal(a->entry_count, b->entry_count);
        assert_memory_equal(a->fmmu, b->fmmu, sizeof a->fmmu);
        free(first);
        free(second);
        free(text);
        free(a);
        free(b);
    }
}

static void a_file_that_is_not_there_and_a_name_that_is_taken(void **state)
{
    struct bus_library *library;
    char why[LIBRARY_WHY];

    (void)state;
    assert_int_equal(library_open(&library), 0);
    assert_int_equal(library_load(library, "tests/devices/none.device", why), -2);
    assert_string_equal(why, "tests/devices/none.device: No such file or directory");
    assert_int_equal(library_load(library, example, why), 0);
    assert_int_equal(library_load(library, example, why), -22);
    assert_string_equal(why, "tests/devices/pressure.device:3:1: the type \"pressure\" is defined "
                             "already, by tests/devices/pressure.device; expected another name");
    assert_int_equal(library_file_types(library), 1);
    library_close(library);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(the_example_of_the_manual_is_the_file_that_is_tested),
        T(the_example_becomes_the_type_it_describes),
        T(the_example_works_under_soem),
        T(outputs_are_safe_after_power_on),
        T(damaged_files_are_told_line_column_and_expectation),
        T(an_image_larger_than_the_memory_is_refused),
        T(more_than_an_sii_holds_is_refused),
        T(counts_and_lengths_have_their_limits),
        T(every_file_cut_anywhere_is_read_or_refused),
        T(what_is_written_reads_back_the_same),
        T(a_file_that_is_not_there_and_a_name_that_is_taken),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
