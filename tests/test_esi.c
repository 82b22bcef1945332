/* SPDX-License-Identifier: GPL-2.0-or-later */
/* ESI: what becomes of it, and what damaged files are told. The files are ours, no vendor's. */
#include "bus_rig.h"

#include <stdio.h>
#include <unistd.h>

#include "bus/bus.h"
#include "bus/description.h"
#include "bus/library.h"

#define MS 1000000u

#define T(f) cmocka_unit_test(f)

static const char example[] = "tests/devices/example.xml";

static struct bus_library *loaded(const char *path)
{
    struct bus_library *library;
    char why[LIBRARY_WHY];

    assert_int_equal(library_open(&library), 0);
    if (library_load(library, path, why))
        fail_msg("%s", why);
    return library;
}

static void every_device_becomes_a_type_and_the_newest_has_the_name(void **state)
{
    struct bus_library *library = loaded(example);
    const struct device_type *type = library_find(library, "XD 4@0x00100000");

    (void)state;
    assert_int_equal(library_file_types(library), 3);
    assert_int_equal(library_find(library, "XD 4")->sii->revision, 0x00110000);
    assert_non_null(type);
    assert_int_equal(type->sii->vendor, 0x5447534d);
    assert_int_equal(type->sii->product, 0x00e10004);
    assert_string_equal(type->sii->name, "Digital input & more");
    assert_string_equal(type->sii->order, "XD 4");
    assert_string_equal(type->sii->group, "Digital");
    assert_int_equal(type->sii->ports, 0x0033);
    assert_int_equal(type->sii->pdi_control, 0x0104);
    assert_int_equal(type->sii->pdi_config_ext, 0x000f);
    assert_int_equal(type->sii->sm[0].start, 0x1000);
    assert_int_equal(type->sii->sm[0].control, 0);
    assert_int_equal(type->sii->fmmu[0], 2);
    assert_int_equal(type->sii->tx_count, 2);
    assert_int_equal(type->sii->tx[1].flags, 0x11);
    assert_int_equal(type->sii->tx[1].entries[0].index, 0x6010);
    assert_int_equal(type->sii->tx[1].entries[1].bits, 6);
    assert_int_equal(type->input_count, 2);
    assert_true(type->al_emulation && !type->dc && !type->od);
    library_close(library);
}

static void dictionaries_come_with_their_defaults(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t subindex, type;
        uint16_t access;
        int64_t initial;
    } rows[] = {
        { 0x1000, 0, OD_U32, OD_RO, 0x1389 },
        { 0x8000, 0, OD_U8, OD_RO, 2 },
        { 0x8000, 1, OD_U16, OD_RW, 0x1234 },
        { 0x8000, 2, OD_U8, OD_RW, 9 },
        { 0x8010, 1, OD_I16, OD_RW, 5 },
        { 0x8010, 2, OD_I16, OD_RW, -2 },
        { 0x8010, 3, OD_I16, OD_RW, 7 },
        { 0x6000, 1, OD_BIT1 + 1, OD_RO | OD_TX_MAP, 0 },
        { 0x6000, 17, OD_I16, OD_RO | OD_TX_MAP, 0 },
    };
    struct bus_library *library = loaded("tests/devices/example.xml#0x00E20001");
    const struct device_type *type = library_find(library, "XA-1");

    (void)state;
    assert_int_equal(library_file_types(library), 1);
    assert_non_null(type);
    assert_true(type->dc && !type->dc_delay_only && !type->al_emulation);
    assert_int_equal(type->sii->dc_assign, 0x0300);
    assert_int_equal(type->sii->coe_details, 0x27);
    assert_int_equal(type->sii->pdi_control, 0x0c05);
    assert_int_equal(type->sii->mailbox.out_size, 128);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct od_object *object = od_find(type->od, rows[i].index);
        const struct od_entry *e = object ? od_entry(object, rows[i].subindex) : NULL;

        assert_non_null(e);
        assert_int_equal(e->type, rows[i].type);
        assert_int_equal(e->access, rows[i].access);
        assert_int_equal(e->initial, rows[i].initial);
    }
    assert_string_equal(od_entry(od_find(type->od, 0x100a), 0)->text, "07");
    library_close(library);
}

static void an_imported_device_works_under_soem(void **state)
{
    static const struct bus_device devices[] = { { .type = "XD 4@0x00100000" },
                                                 { .type = "XA-1" } };
    struct bus_library *library = loaded(example);
    struct bus_config config = {
        .devices = devices, .device_count = 2, .cycle_ns = MS, .library = library
    };
    struct bus *bus;
    char why[BUS_WHY];
    uint64_t now;

    (void)state;
    if (bus_open(&bus, &config, why))
        fail_msg("%s", why);
    bus_set_input(bus, 0, 1, 1);
    bus_set_input(bus, 1, 0, 2);
    bus_set_input(bus, 1, 1, -77);
    now = bus_now(bus);
    bus_request_op(bus);
    for (unsigned i = 0; i < 50; i++) {
        bus_send(bus, now += MS);
        bus_receive(bus, now += MS);
        bus_poll_states(bus);
    }
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(bus_slave(bus, i)->al_state, AL_OP);
    }
    assert_int_equal(bus_entry_get(bus_bits(bus, 0, BUS_INPUT, 0, 8)), 2);
    assert_int_equal(bus_entry_get(bus_find(bus, 1, BUS_INPUT, 0x6000, 1)), 2);
    assert_int_equal(bus_entry_sign(bus_find(bus, 1, BUS_INPUT, 0x6000, 0x11)), -77);
    bus_close(bus);
    library_close(library);
}

static void converted_esi_is_a_device_file_of_the_same_device(void **state)
{
    char path[] = "/tmp/tgm-esi-XXXXXX", why[LIBRARY_WHY];
    int fd = mkstemp(path);
    FILE *stream = fdopen(fd, "w");
    struct bus_library *library, *original = loaded("tests/devices/example.xml#XA-1");
    const struct device_type *a = library_find(original, "XA-1"), *b;
    uint8_t image[2][SII_SIZE];

    (void)state;
    assert_non_null(stream);
    assert_int_equal(library_convert("tests/devices/example.xml#XA-1", stream, why), 0);
    fclose(stream);
    library = loaded(path);
    unlink(path);
    b = library_find(library, "XA-1");
    assert_int_equal(sii_build(a->sii, 1, 0, image[0]), sii_build(b->sii, 1, 0, image[1]));
    assert_memory_equal(image[0], image[1], SII_SIZE);
    assert_int_equal(a->od->count, b->od->count);
    assert_int_equal(a->size, b->size);
    library_close(library);
    library_close(original);
}

static void one_device_is_chosen_by_type_product_or_revision(void **state)
{
    static const struct {
        const char *select;
        uint32_t revision;
    } rows[] = { { "tests/devices/example.xml#XD 4", 0x00110000 },
                 { "tests/devices/example.xml##x00E10004", 0x00110000 },
                 { "tests/devices/example.xml#XD 4@0x00100000", 0x00100000 } };
    struct library_entry entry;

    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct bus_library *library = loaded(rows[i].select);

        assert_int_equal(library_file_types(library), 1);
        assert_true(library_get(library, 0, &entry));
        assert_int_equal(entry.revision, rows[i].revision);
        library_close(library);
    }
}

static void conversion_takes_one_device(void **state)
{
    char why[LIBRARY_WHY], *text = NULL;
    size_t length;
    FILE *stream = open_memstream(&text, &length);

    (void)state;
    assert_int_equal(library_convert(example, stream, why), -22);
    assert_string_equal(why,
                        "tests/devices/example.xml:31: \"XD 4\" is a second device beside \"XD "
                        "4@0x00100000\"; expected one: tests/devices/example.xml#XD "
                        "4@0x00100000");
    fclose(stream);
    free(text);
}

static int take(void *argument, const struct description *d, char why[LIBRARY_WHY])
{
    struct terminal_type *type;
    int error = description_build(d, &type, why);

    (void)argument;
    if (!error)
        free(type);
    return error;
}

static int read_text(const char *text, char why[LIBRARY_WHY])
{
    return esi_read("x.xml", text, strlen(text), NULL, take, NULL, why);
}

#define BEGIN    "<EtherCATInfo>\n<Vendor><Id>2</Id></Vendor>\n<Descriptions><Devices>\n<Device>\n"
#define END      "</Device></Devices></Descriptions></EtherCATInfo>"
#define TYPE     "<Type ProductCode=\"#x5\">T</Type>"
#define SM       "<Sm StartAddress=\"#x1000\">Inputs</Sm>"
#define ENTRY(s) "<Entry><Index>#x6000</Index><SubIndex>1</SubIndex>" s "</Entry>"

static const struct {
    const char *text, *why;
} damaged[] = {
    { "<EtherCATInfo>\n<Vendor>", "x.xml:2:9: Premature end of data in tag Vendor line 2; expected "
                                  "well-formed XML" },
    { "hello", "x.xml:1:1: Start tag expected, '<' not found; expected well-formed XML" },
    { "<Other/>", "x.xml:1: <Other>; expected <EtherCATInfo>" },
    { "<EtherCATInfo>\n</EtherCATInfo>", "x.xml:1: no <Vendor>; expected it with an <Id>" },
    { "<EtherCATInfo>\n<Vendor/>\n</EtherCATInfo>", "x.xml:2: <Vendor> without <Id>; expected the "
                                                    "vendor id" },
    { "<EtherCATInfo>\n<Vendor>\n<Id>two</Id></Vendor></EtherCATInfo>",
      "x.xml:3: \"two\" is not a number; expected the vendor id, #x and hexadecimal digits" },
    { "<EtherCATInfo>\n<Vendor><Id>2</Id></Vendor>\n</EtherCATInfo>",
      "x.xml:1: no devices; expected <Descriptions>, <Devices>, <Device>" },
    { "<!DOCTYPE a [<!ENTITY b SYSTEM \"file:///etc/passwd\">]>\n<EtherCATInfo/>",
      "x.xml: a document type definition; expected none in ESI" },
    { BEGIN END, "x.xml:4: <Device> without <Type>; expected ProductCode and RevisionNo" },
    { BEGIN "<Type>T</Type>" END, "x.xml:5: \"\" is not a number; expected a product code, #x and "
                                  "hexadecimal digits" },
    { BEGIN "<Type ProductCode=\"#x5\"/>" END,
      "x.xml:4: a type name of 0 characters; expected 1 to "
      "63" },
    { BEGIN TYPE "\n<Sm>Input</Sm>" END, "x.xml:6: <Sm> is \"Input\"; expected MBoxOut, MBoxIn, "
                                         "Outputs or Inputs" },
    { BEGIN TYPE "\n<Sm StartAddress=\"x\">Inputs</Sm>" END,
      "x.xml:6: \"x\" is not a number; expected an address, #x and hexadecimal digits" },
    { BEGIN TYPE "\n<Fmmu>Input</Fmmu>" END, "x.xml:6: <Fmmu> is \"Input\"; expected Outputs, "
                                             "Inputs or MBoxState" },
    { BEGIN TYPE SM "\n<TxPdo Sm=\"0\"><Name>N</Name></TxPdo>" END,
      "x.xml:6: <TxPdo> without <Index>; expected the index of the PDO" },
    { BEGIN TYPE SM "<TxPdo Sm=\"0\"><Index>#x1A00</Index>\n" ENTRY("") "</TxPdo>" END,
      "x.xml:6: <Entry> without <BitLen>; expected a length in bits" },
    { BEGIN TYPE SM
      "<TxPdo Sm=\"0\"><Index>#x1A00</Index>\n" ENTRY("<BitLen>24</BitLen>") "</TxPdo>" END,
      "x.xml:6: an entry of 24 bits; expected 1 to 8, 16, 32 or 64" },
    { BEGIN TYPE SM
      "<TxPdo Sm=\"0\"><Index>#x1A00</Index>\n" ENTRY("<BitLen>999</BitLen>") "</TxPdo>" END,
      "x.xml:6: 999 is out of range; expected a length in bits up to 0xFF" },
    { BEGIN TYPE SM "\n<TxPdo><Index>#x1A00</Index></TxPdo>" END,
      "x.xml:6: PDO 0x1A00 is in no sync manager; expected \"sm N\" (only CoE can assign it "
      "later)" },
    { BEGIN TYPE SM "\n" SM END, "x.xml:6: sync manager 1 is a second one for inputs; expected one "
                                 "of each" },
    { BEGIN TYPE "\n<Eeprom><ConfigData>0G</ConfigData></Eeprom>" END,
      "x.xml:6: <ConfigData> is \"0G\"; expected 2 to 32 bytes in hexadecimal" },
};

static void damaged_files_are_told_line_and_expectation(void **state)
{
    char why[LIBRARY_WHY];

    (void)state;
    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        assert_int_equal(read_text(damaged[i].text, why), -22);
        assert_string_equal(why, damaged[i].why);
    }
}

static void a_file_with_one_bad_device_adds_none(void **state)
{
    char path[] = "/tmp/tgm-esi-XXXXXX.xml", why[LIBRARY_WHY];
    FILE *stream = fdopen(mkstemps(path, 4), "w");
    struct bus_library *library = loaded("tests/devices/example.xml#XA-1");

    (void)state;
    assert_non_null(stream);
    fputs(BEGIN TYPE "</Device>\n<Device>" END, stream);
    fclose(stream);
    assert_int_equal(library_load(library, path, why), -22);
    unlink(path);
    assert_int_equal(library_file_types(library), 1);
    assert_null(library_find(library, "T"));
    assert_non_null(library_find(library, "XA-1"));
    library_close(library);
}

/* Two devices of one type and revision: the first one counts, and the second has another name. */
static int collect(void *argument, const struct description *d, char why[LIBRARY_WHY])
{
    (void)why;
    strcat(strcat(argument, d->type), " ");
    return 0;
}

static void of_equal_revisions_the_first_has_the_name(void **state)
{
    static const char text[] = BEGIN TYPE "</Device><Device>" TYPE END;
    char why[LIBRARY_WHY], names[64] = "";

    (void)state;
    assert_int_equal(esi_read("x.xml", text, strlen(text), NULL, collect, names, why), 0);
    assert_string_equal(names, "T T@0x00000000 ");
}

static void a_file_cut_anywhere_is_refused(void **state)
{
    char why[LIBRARY_WHY], *text;
    size_t length;
    int error;

    (void)state;
    text = scan_read_file(example, SCAN_FILE, &length, &error, why);
    assert_non_null(text);
    for (size_t cut = 0; cut + 2 < length; cut += 7) {
        assert_int_equal(esi_read("x.xml", text, cut, NULL, take, NULL, why), -22);
        assert_int_equal(strncmp(why, "x.xml:", 6), 0);
    }
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(every_device_becomes_a_type_and_the_newest_has_the_name),
        T(dictionaries_come_with_their_defaults),
        T(an_imported_device_works_under_soem),
        T(converted_esi_is_a_device_file_of_the_same_device),
        T(one_device_is_chosen_by_type_product_or_revision),
        T(conversion_takes_one_device),
        T(damaged_files_are_told_line_and_expectation),
        T(a_file_with_one_bad_device_adds_none),
        T(of_equal_revisions_the_first_has_the_name),
        T(a_file_cut_anywhere_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
