/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The slave controller against its register map: what masters seldom touch, and what they write in
 * ways of their own. */
#include "bus_rig.h"
#include "bus/identity.h"

#define DRIVE 0x1001
#define DIO   0x1002

static const char *const types[] = { "drive-cia402", "dio-8x8", "drive-cia402" };

static int setup(void **state)
{
    *state = rig_new(types, 3);
    rig_address(*state);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

/* --- what the register map asks for --- */

/* Write enable holds for the frame it comes in, and for that slave. */
static void protected_registers_open_for_one_frame(void **state)
{
    struct rig *rig = *state;
    uint8_t protect[1] = { 1 };
    size_t first, second;

    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_WRITE_PROTECTION), protect, 1), 1);
    assert_int_equal(write_u16(rig, DRIVE, REG_WD_SM, 500), 0);
    assert_int_equal(write_u8(rig, DRIVE, REG_DIGITAL_OUT, 5), 0);
    assert_int_equal(write_u8(rig, DRIVE, 0x1f00, 5), 1); /* memory is not a register */
    frame_begin(rig);
    first = frame_add(rig, FPWR, AT(DRIVE, REG_WRITE_ENABLE), NULL, 1);
    second = frame_add(rig, FPWR, AT(DRIVE, REG_WD_SM), "\xf4\x01", 2);
    assert_true(frame_send(rig));
    assert_int_equal(frame_wkc(rig, first), 1);
    assert_int_equal(frame_wkc(rig, second), 1);
    assert_int_equal(read_u16(rig, DRIVE, REG_WD_SM), 500);
    assert_int_equal(write_u16(rig, DRIVE, REG_WD_SM, 501), 0);
    /* Protection itself is protected. */
    assert_int_equal(write_u8(rig, DRIVE, REG_WRITE_PROTECTION, 0), 0);
    frame_begin(rig);
    frame_add(rig, FPWR, AT(DRIVE, REG_WRITE_ENABLE), NULL, 1);
    frame_add(rig, FPWR, AT(DRIVE, REG_WRITE_PROTECTION), NULL, 1);
    assert_true(frame_send(rig));
    assert_int_equal(write_u16(rig, DRIVE, REG_WD_SM, 501), 1);
}

static void a_protected_controller_takes_nothing_at_all(void **state)
{
    struct rig *rig = *state;
    size_t at;

    write_u8(rig, DRIVE, REG_ESC_WRITE_PROTECTION, 1);
    assert_int_equal(write_u8(rig, DRIVE, 0x1f00, 5), 0);
    assert_int_equal(write_u16(rig, DRIVE, REG_WD_SM, 500), 0);
    write_u8(rig, DRIVE, REG_WRITE_ENABLE, 1); /* of the other protection */
    assert_int_equal(write_u8(rig, DRIVE, 0x1f00, 5), 0);
    frame_begin(rig);
    frame_add(rig, FPWR, AT(DRIVE, REG_ESC_WRITE_ENABLE), NULL, 1);
    at = frame_add(rig, FPWR, AT(DRIVE, 0x1f00), "\x05", 1);
    assert_true(frame_send(rig));
    assert_int_equal(frame_wkc(rig, at), 1);
}

static void read_write_commands_write_at_the_physical_offset(void **state)
{
    struct rig *rig = *state;
    uint8_t data[2] = { 0x34, 0x12 };

    put_u16(rig->slaves[0].memory + 0x1e00, 0xaaaa);
    write_u16(rig, DRIVE, REG_PHYSICAL_OFFSET, 0x100);
    assert_int_equal(exchange(rig, FPRW, AT(DRIVE, 0x1e00), data, 2), 3);
    assert_int_equal(get_u16(data), 0xaaaa);
    assert_int_equal(read_u16(rig, DRIVE, 0x1f00), 0x1234);
    assert_int_equal(read_u16(rig, DRIVE, 0x1e00), 0xaaaa);
}

static void led_overrides_are_the_applications(void **state)
{
    assert_int_equal(write_u16(*state, DRIVE, 0x0138, 1), 0);
    assert_int_equal(read_u16(*state, DRIVE, 0x0138), 0);
}

static void error_counters_are_cleared_group_by_group(void **state)
{
    struct rig *rig = *state;
    uint8_t *m = rig->slaves[0].memory;

    memset(m + REG_RX_ERRORS, 7, 0x14);
    assert_int_equal(write_u8(rig, DRIVE, REG_FORWARDED_ERRORS + 2, 0x55), 1);
    for (unsigned i = 0; i < 12; i++)
        assert_int_equal(m[REG_RX_ERRORS + i], 0);
    assert_int_equal(m[REG_PU_ERRORS], 7);
    assert_int_equal(write_u8(rig, DRIVE, REG_PU_ERRORS, 0x55), 1);
    assert_int_equal(m[REG_PU_ERRORS], 0);
    assert_int_equal(m[REG_PDI_ERRORS], 7);
    assert_int_equal(m[REG_LOST_LINK], 7);
}

static void the_port_descriptor_follows_the_sii(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(rig->slaves[0].type->sii->ports, 0x0011);
    assert_int_equal(rig->slaves[0].memory[REG_PORTS], 0x0f);
}

/* AL control unread, a request in SM0 (which has the AL interrupt on) untaken. */
static void al_events_tell_what_the_application_has_not_seen(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 0 };

    drive_mailbox(rig, DRIVE);
    assert_int_equal(read_u32(rig, DRIVE, REG_AL_EVENT), 0);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    write_u16(rig, DRIVE, REG_AL_CONTROL, AL_PREOP);
    assert_int_equal(read_u32(rig, DRIVE, REG_AL_EVENT), AL_EVENT_CONTROL | AL_EVENT_SM0);
    rig_wait(rig, SLAVE_AL_NS);
    assert_int_equal(read_u32(rig, DRIVE, REG_AL_EVENT), 0);
}

/* The bit follows the status of sync managers whose master interrupt is on. */
static void sync_manager_events_reach_irq_only_when_switched_on(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 0 };

    write_u16(rig, DRIVE, REG_ECAT_EVENT_MASK, 0x0ff0);
    for (unsigned on = 0; on < 2; on++) {
        write_sm(rig, DRIVE, 2, 0x1800, 4, on ? 0x30 : 0x20, 1);
        syncman_device_fill(&rig->slaves[0], 2);
        syncman_device_done(&rig->slaves[0], 2);
        exchange(rig, BRD, AT(0, 0), data, 2);
        assert_int_equal(get_u16(rig->frame + 24), on ? EVENT_SM0 << 2 : 0);
        exchange(rig, FPRD, AT(DRIVE, 0x1800), data, 4);
        exchange(rig, BRD, AT(0, 0), data, 2);
        assert_int_equal(get_u16(rig->frame + 24), 0);
    }
}

static void a_buffer_half_written_or_read_shows(void **state)
{
    struct rig *rig = *state;
    const uint8_t *status = rig->slaves[0].memory + REG_SM + 2 * SM_SIZE + SM_STATUS;
    uint8_t data[4] = { 0 };

    write_sm(rig, DRIVE, 2, 0x1800, 4, 0x24, 1);
    exchange(rig, FPWR, AT(DRIVE, 0x1800), data, 2);
    assert_int_equal(*status & 0xc0, SM_STATUS_WRITING);
    exchange(rig, FPWR, AT(DRIVE, 0x1802), data, 2);
    assert_int_equal(*status & 0xc0, 0);
    write_sm(rig, DRIVE, 2, 0x1800, 4, 0x20, 1);
    syncman_device_fill(&rig->slaves[0], 2);
    syncman_device_done(&rig->slaves[0], 2);
    exchange(rig, FPRD, AT(DRIVE, 0x1800), data, 2);
    assert_int_equal(*status & 0xc0, SM_STATUS_READING);
    exchange(rig, FPRD, AT(DRIVE, 0x1802), data, 2);
    assert_int_equal(*status & 0xc0, 0);
}

/* TwinCAT's way: 68 bytes at the start and the last byte, in one frame. */
static void a_mailbox_written_as_head_and_last_byte_is_full(void **state)
{
    struct rig *rig = *state;
    size_t head, tail;

    drive_mailbox(rig, DRIVE);
    frame_begin(rig);
    head = frame_add(rig, FPWR, AT(DRIVE, 0x1000), NULL, 68);
    tail = frame_add(rig, FPWR, AT(DRIVE, 0x107f), NULL, 1);
    assert_true(frame_send(rig));
    assert_int_equal(frame_wkc(rig, head), 1);
    assert_int_equal(frame_wkc(rig, tail), 1);
    assert_int_equal(rig->slaves[0].memory[REG_SM + SM_STATUS] & SM_STATUS_FULL, SM_STATUS_FULL);
}

/* The whole area moves while fresh outputs lie in the old one. */
static void outputs_are_forgotten_when_their_sync_manager_moves(void **state)
{
    struct rig *rig = *state;
    uint8_t sm[8] = { 0x00, 0x18, 0x01, 0x00, 0x44, 0, 1, 0 };

    rig->slaves[1].memory[0x1800] = 0x33;

    write_sm(rig, DIO, 0, 0x0f00, 1, 0x44, 9);
    al_request(rig, DIO, AL_OP);
    frame_begin(rig);
    frame_add(rig, FPWR, AT(DIO, REG_DIGITAL_OUT), "\xa5", 1);
    frame_add(rig, FPWR, AT(DIO, REG_SM), sm, 8);
    assert_true(frame_send(rig));
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0);
}

/* SOEM starts a read with six bytes, IgH with four and bit 7 set. */
static void sii_reads_start_as_masters_write_them(void **state)
{
    static const uint8_t soem[6] = { 0x00, 0x01, 0x0a, 0x00, 0x00, 0x00 };
    static const uint8_t igh[4] = { 0x80, 0x01, 0x0a, 0x00 };
    struct rig *rig = *state;
    uint8_t data[10];

    memcpy(data, soem, sizeof soem);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_EEPROM_CONTROL), data, sizeof soem), 1);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u32(rig, DRIVE, REG_EEPROM_DATA), BUS_PRODUCT_DRIVE);
    memcpy(data, igh, sizeof igh);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_EEPROM_CONTROL), data, sizeof igh), 1);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, REG_EEPROM_CONTROL), data, 10), 1);
    assert_int_equal(get_u16(data), 0x0040);
    assert_int_equal(get_u32(data + 2), 0x0a);
    assert_int_equal(get_u32(data + 6), BUS_PRODUCT_DRIVE);
}

/* IgH: command, address and data in one write of eight bytes. */
static void sii_takes_command_address_and_data_in_one_write(void **state)
{
    struct rig *rig = *state;
    uint8_t data[8] = { 0x01, 0x02, 0x04, 0x00, 0x00, 0x00, 0xcd, 0xab };

    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_EEPROM_CONTROL), data, 8), 1);
    rig_wait(rig, SLAVE_SII_WRITE_NS);
    assert_int_equal(get_u16(rig->slaves[0].image + 8), 0xabcd);
}

static void an_unknown_sii_command_is_an_error_until_the_next(void **state)
{
    struct rig *rig = *state;

    sii_command(rig, DRIVE, 0x0300, 0);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x2040);
    sii_command(rig, DRIVE, 0x0000, 0);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x0040);
}

static void not_loaded_stays_true_until_a_load_succeeds(void **state)
{
    struct rig *rig = *state;

    rig->slaves[0].image[2] ^= 1;
    sii_command(rig, DRIVE, 0x0400, 0);
    rig_wait(rig, SLAVE_SII_READ_NS);
    sii_command(rig, DRIVE, 0x0000, 0);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL) & 0x1800, 0x1000);
    rig->slaves[0].image[2] ^= 1;
    sii_command(rig, DRIVE, 0x0400, 0);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL) & 0x1800, 0);
    assert_int_equal(read_u16(rig, DRIVE, REG_DL_STATUS) & 1, 1);
}

static void the_alias_is_loaded_at_power_on_only(void **state)
{
    struct rig *rig = *state;

    put_u16(rig->slaves[0].image + 8, 0x0777);
    put_u16(rig->slaves[0].image + 14, sii_crc(rig->slaves[0].image, 14));
    sii_command(rig, DRIVE, 0x0400, 0);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_STATION_ALIAS), 0);
    slave_power_on(&rig->slaves[0], rig->now);
    assert_int_equal(get_u16(rig->slaves[0].memory + REG_STATION_ALIAS), 0x0777);
}

/* --- device identification --- */

static void a_device_tells_its_alias_while_it_is_asked_to(void **state)
{
    struct rig *rig = *state;

    put_u16(rig->slaves[0].memory + REG_STATION_ALIAS, 0x0123);
    assert_int_equal(al_request(rig, DRIVE, AL_INIT | AL_DEVICE_ID), AL_INIT | AL_DEVICE_ID);
    assert_int_equal(al_code(rig, DRIVE), 0x0123);
    assert_int_equal(al_request(rig, DRIVE, AL_INIT), AL_INIT);
    assert_int_equal(al_code(rig, DRIVE), 0);
    /* A refusal has the code for itself. */
    assert_int_equal(al_request(rig, DRIVE, AL_PREOP | AL_DEVICE_ID), AL_INIT | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_MAILBOX_CONFIG);
}

/* Also while the way to OP waits for outputs. */
static void an_identification_ends_with_the_next_request(void **state)
{
    struct rig *rig = *state;

    drive_safeop(rig, DRIVE, 0);
    put_u16(rig->slaves[0].memory + REG_STATION_ALIAS, 0x0123);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP | AL_DEVICE_ID), AL_SAFEOP | AL_DEVICE_ID);
    assert_int_equal(al_request(rig, DRIVE, AL_OP), AL_SAFEOP);
    assert_int_equal(al_code(rig, DRIVE), 0);
}

static void a_processor_without_dictionary_checks_its_sync_managers_against_the_sii(void **state)
{
    static struct sii_info sii;
    static struct device_type type;
    struct rig *rig = *state;

    type = *rig->slaves[1].type;
    sii = *type.sii;
    type.al_emulation = false;
    type.sii = &sii;
    rig->slaves[1].type = &type;
    assert_int_equal(al_request(rig, DIO, AL_PREOP), AL_PREOP);
    assert_int_equal(al_request(rig, DIO, AL_SAFEOP), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DIO), AL_CODE_OUTPUT_CONFIG);
    write_sm(rig, DIO, 0, 0x0f00, 1, 0x44, 9);
    assert_int_equal(al_request(rig, DIO, AL_SAFEOP | AL_ERROR), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DIO), AL_CODE_INPUT_CONFIG);
    write_sm(rig, DIO, 1, 0x1000, 1, 0x00, 1);
    assert_int_equal(al_request(rig, DIO, AL_SAFEOP | AL_ERROR), AL_SAFEOP);
    write_sm(rig, DIO, 1, 0x1000, 2, 0x00, 1);
    assert_int_equal(read_u16(rig, DIO, REG_AL_STATUS), AL_PREOP | AL_ERROR);
}

/* --- what stalls --- */

/* Nobody fetches the answers: the fifth request stays in SM0, and is answered later. */
static void requests_wait_when_their_answers_would_not_fit(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128], n;

    drive_preop(rig, DRIVE);
    for (n = 1; n <= 6; n++) {
        sdo_read_request(box, n, 0x1000);
        assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
        rig_wait(rig, SLAVE_MAILBOX_NS);
        read_u16(rig, DRIVE, REG_TYPE);
    }
    sdo_read_request(box, n, 0x1000);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 0);
    for (n = 1; n <= 6; n++)
        assert_true(mailbox_receive(rig, DRIVE, box));
    assert_false(mailbox_receive(rig, DRIVE, box));
}

static void mailbox_errors_are_not_answered(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 4, 0, 0, 0, 0, 0x10, 1, 0, 2 };

    drive_preop(rig, DRIVE);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    assert_false(mailbox_receive(rig, DRIVE, box));
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(protected_registers_open_for_one_frame),
        T(a_protected_controller_takes_nothing_at_all),
        T(read_write_commands_write_at_the_physical_offset),
        T(led_overrides_are_the_applications),
        T(error_counters_are_cleared_group_by_group),
        T(the_port_descriptor_follows_the_sii),
        T(al_events_tell_what_the_application_has_not_seen),
        T(sync_manager_events_reach_irq_only_when_switched_on),
        T(a_buffer_half_written_or_read_shows),
        T(a_mailbox_written_as_head_and_last_byte_is_full),
        T(outputs_are_forgotten_when_their_sync_manager_moves),
        T(sii_reads_start_as_masters_write_them),
        T(sii_takes_command_address_and_data_in_one_write),
        T(an_unknown_sii_command_is_an_error_until_the_next),
        T(not_loaded_stays_true_until_a_load_succeeds),
        T(the_alias_is_loaded_at_power_on_only),
        T(a_device_tells_its_alias_while_it_is_asked_to),
        T(an_identification_ends_with_the_next_request),
        T(a_processor_without_dictionary_checks_its_sync_managers_against_the_sii),
        T(requests_wait_when_their_answers_would_not_fit),
        T(mailbox_errors_are_not_answered),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
