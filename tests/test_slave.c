/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The slave controller: SII, sync managers, mailbox transport, AL states, watchdog, clock. */
#include "bus_rig.h"

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

/* --- SII --- */

static void crc_gives_the_published_vectors(void **state)
{
    static const struct {
        uint16_t word[7];
        uint8_t crc;
    } vectors[] = {
        { { 0 }, 0x30 },
        { { 0x0d00 }, 0x46 },
        { { 0x0104 }, 0x39 },
        { { 0x0104, 0, 0, 0x000f }, 0xd8 },
        { { 0x0104, 0, 0, 0x00ff }, 0xe2 },
        { { 0x0c08 }, 0xef },
        { { 0x0c08, 0, 0, 0, 1 }, 0xc6 },
        { { 0x0c80 }, 0x0b },
    };

    (void)state;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++) {
        uint8_t bytes[14];

        for (unsigned w = 0; w < 7; w++)
            put_u16(bytes + 2 * w, vectors[i].word[w]);
        assert_int_equal(sii_crc(bytes, sizeof bytes), vectors[i].crc);
    }
}

static void every_device_has_a_well_formed_image(void **state)
{
    const struct device_type *type;

    (void)state;
    for (size_t i = 0; (type = device_type(i)); i++) {
        uint8_t image[SII_SIZE];
        size_t used = sii_build(type->sii, 5, 0x1234, image), at = 0x80;
        unsigned seen = 0;

        assert_in_range(used, 0x82, SII_SIZE);
        assert_int_equal(image[14], sii_crc(image, 14));
        assert_int_equal(get_u16(image + 8), 0x1234);
        assert_int_equal(get_u32(image + 0x10), type->sii->vendor);
        assert_int_equal(get_u32(image + 0x1c), 5);
        for (; get_u16(image + at) != 0xffff; at += 4 + 2u * get_u16(image + at + 2)) {
            assert_in_range(at, 0x80, used - 2);
            seen |= get_u16(image + at) == 10 ? 1u : get_u16(image + at) == 30 ? 2u : 0u;
        }
        assert_int_equal(at + 2, used);
        assert_int_equal(seen, 3);
    }
}

static void sii_read_is_busy_and_then_gives_eight_bytes(void **state)
{
    struct rig *rig = *state;
    uint8_t data[8] = { 0 };

    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x0040);
    assert_int_equal(sii_command(rig, DRIVE, 0x0100, 8), 1);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x8140);
    assert_int_equal(sii_command(rig, DRIVE, 0x0100, 0), 0);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x0040);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, REG_EEPROM_DATA), data, 8), 1);
    assert_int_equal(get_u32(data), rig->slaves[0].type->sii->vendor);
    assert_int_equal(get_u32(data + 4), rig->slaves[0].type->sii->product);
}

static void sii_read_beyond_the_end_gives_ff(void **state)
{
    struct rig *rig = *state;

    sii_command(rig, DRIVE, 0x0100, 0x00010000);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u32(rig, DRIVE, REG_EEPROM_DATA), 0xffffffff);
    sii_command(rig, DRIVE, 0x0100, 0xffffffff);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u32(rig, DRIVE, REG_EEPROM_DATA), 0xffffffff);
}

static void sii_write_needs_the_enable_bit(void **state)
{
    struct rig *rig = *state;

    write_u16(rig, DRIVE, REG_EEPROM_DATA, 0xbeef);
    sii_command(rig, DRIVE, 0x0200, 4);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL) & 0x4000, 0x4000);
    sii_command(rig, DRIVE, 0x0201, 4);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL) & 0x8000, 0x8000);
    rig_wait(rig, SLAVE_SII_WRITE_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL), 0x0040);
    assert_int_equal(get_u16(rig->slaves[0].image + 8), 0xbeef);
}

static void sii_belongs_to_the_pdi_until_the_master_forces_it(void **state)
{
    struct rig *rig = *state;

    write_u8(rig, DRIVE, REG_EEPROM_OWNER, 1);
    assert_int_equal(sii_command(rig, DRIVE, 0x0100, 8), 0);
    write_u8(rig, DRIVE, REG_EEPROM_OWNER, 2);
    write_u8(rig, DRIVE, REG_EEPROM_OWNER, 0);
    assert_int_equal(sii_command(rig, DRIVE, 0x0100, 8), 1);
}

static void a_bad_checksum_shows_in_status_and_dl_status(void **state)
{
    struct rig *rig = *state;

    rig->slaves[0].image[2] ^= 1;
    sii_command(rig, DRIVE, 0x0400, 0);
    rig_wait(rig, SLAVE_SII_READ_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_EEPROM_CONTROL) & 0x1800, 0x1800);
    assert_int_equal(read_u16(rig, DRIVE, REG_DL_STATUS) & 1, 0);
}

/* --- sync managers --- */

static void mailbox_is_written_once_until_the_slave_has_taken_it(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 1 };

    drive_mailbox(rig, DRIVE);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    assert_int_equal(rig->slaves[0].memory[REG_SM + SM_STATUS] & SM_STATUS_FULL, SM_STATUS_FULL);
    box[0] = 2;
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 0);
    assert_int_equal(rig->slaves[0].memory[0x1000], 1);
}

static void empty_mailbox_and_wrong_directions_give_no_working_counter(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 0 };

    drive_mailbox(rig, DRIVE);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1080), box, 128), 0);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1000), box, 128), 0);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1080), box, 128), 0);
}

static void mailbox_fills_with_the_last_byte_even_in_pieces(void **state)
{
    struct rig *rig = *state;
    uint8_t head[16] = { 0x0a }, tail[1] = { 0 };
    const uint8_t *status = rig->slaves[0].memory + REG_SM + SM_STATUS;

    drive_mailbox(rig, DRIVE);
    /* The last byte alone does not open the area. */
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x107f), tail, 1), 0);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), head, 16), 1);
    assert_int_equal(*status & SM_STATUS_FULL, 0);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x107f), tail, 1), 1);
    assert_int_equal(*status & SM_STATUS_FULL, SM_STATUS_FULL);
}

static void sm_status_and_pdi_control_are_not_the_masters(void **state)
{
    struct rig *rig = *state;
    uint8_t sm[8] = { 0x00, 0x18, 0x10, 0x00, 0x24, 0xff, 0x01, 0xff };

    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_SM + 32), sm, 8), 1);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, REG_SM + 32), sm, 8), 1);
    assert_int_equal(sm[5], 0x30); /* no buffer written yet */
    assert_int_equal(sm[7], 0);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, REG_SM + 32 + SM_STATUS), sm, 1), 0);
}

static void buffered_outputs_take_effect_with_their_last_byte(void **state)
{
    struct rig *rig = *state;
    uint8_t data[8] = { 1, 2, 3, 4, 5, 6, 7, 8 };

    write_sm(rig, DRIVE, 2, 0x1800, 8, 0x24, 1);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1800), data, 8), 1);
    assert_memory_equal(syncman_device_read(&rig->slaves[0], 2), data, 8);
    data[0] = 0x99;
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1800), data, 4), 1);
    assert_int_equal(syncman_device_read(&rig->slaves[0], 2)[0], 1);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1804), data + 4, 4), 1);
    assert_int_equal(syncman_device_read(&rig->slaves[0], 2)[0], 0x99);
}

static void buffered_inputs_stay_whole_while_they_are_read(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4];
    struct slave *s = &rig->slaves[0];

    write_sm(rig, DRIVE, 2, 0x1800, 4, 0x20, 1);
    /* Nothing written yet: nothing to read. */
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1800), data, 4), 0);
    memset(syncman_device_fill(s, 2), 0xaa, 4);
    syncman_device_done(s, 2);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1800), data, 2), 1);
    for (unsigned i = 0; i < 5; i++) {
        memset(syncman_device_fill(s, 2), 0xb7 + (int)i, 4);
        syncman_device_done(s, 2);
    }
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1802), data + 2, 2), 1);
    assert_int_equal(get_u32(data), 0xaaaaaaaa);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1800), data, 4), 1);
    assert_int_equal(get_u32(data), 0xbbbbbbbb);
}

static void memory_behind_a_buffered_area_is_reserved(void **state)
{
    struct rig *rig = *state;
    uint8_t data[4] = { 0 };

    write_sm(rig, DRIVE, 2, 0x1800, 4, 0x24, 1);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1804), data, 4), 0);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x180c), data, 4), 1);
}

static void the_same_configuration_again_does_not_empty_a_running_mailbox(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 0 };

    drive_mailbox(rig, DRIVE);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    drive_mailbox(rig, DRIVE);
    assert_int_equal(rig->slaves[0].memory[REG_SM + SM_STATUS] & SM_STATUS_FULL, SM_STATUS_FULL);
    write_sm(rig, DRIVE, 0, 0x1000, 128, 0x26, 0);
    drive_mailbox(rig, DRIVE);
    assert_int_equal(rig->slaves[0].memory[REG_SM + SM_STATUS] & SM_STATUS_FULL, 0);
}

/* --- mailbox transport --- */

static void an_unknown_protocol_gets_a_mailbox_error(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 2, 0, 0, 0, 0, 0x14 };

    drive_preop(rig, DRIVE);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    assert_true(mailbox_receive(rig, DRIVE, box));
    assert_int_equal(get_u16(box), 4);
    assert_int_equal(box[5] & 0x0f, 0);
    assert_int_equal(get_u16(box + 6), 1);
    assert_int_equal(get_u16(box + 8), MAILBOX_PROTOCOL);
}

static void a_length_beyond_the_mailbox_gets_a_mailbox_error(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128];

    drive_preop(rig, DRIVE);
    sdo_read_request(box, 1, 0x1000);
    put_u16(box, 123);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_true(mailbox_receive(rig, DRIVE, box));
    assert_int_equal(get_u16(box + 8), MAILBOX_SIZE);
}

static void a_repeated_request_counter_is_not_executed_twice(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128];

    drive_preop(rig, DRIVE);
    sdo_read_request(box, 3, 0x1000);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_true(mailbox_receive(rig, DRIVE, box));
    sdo_read_request(box, 3, 0x1000);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_false(mailbox_receive(rig, DRIVE, box));
    sdo_read_request(box, 4, 0x1000);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_true(mailbox_receive(rig, DRIVE, box));
}

static void a_lost_reply_comes_again_on_a_repeat_request(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128], again[128];

    drive_preop(rig, DRIVE);
    sdo_read_request(box, 1, 0x1000);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_true(mailbox_receive(rig, DRIVE, box));
    write_u8(rig, DRIVE, REG_SM + SM_SIZE + SM_ACTIVATE, 3);
    assert_int_equal(read_u16(rig, DRIVE, REG_SM + SM_SIZE + SM_ACTIVATE) >> 8 & 2, 2);
    assert_true(mailbox_receive(rig, DRIVE, again));
    assert_memory_equal(box, again, 128);
    write_u8(rig, DRIVE, REG_SM + SM_SIZE + SM_ACTIVATE, 1);
    assert_int_equal(read_u16(rig, DRIVE, REG_SM + SM_SIZE + SM_ACTIVATE) >> 8 & 2, 0);
    assert_true(mailbox_receive(rig, DRIVE, again));
    assert_memory_equal(box, again, 128);
}

static void what_was_in_the_mailbox_before_preop_is_forgotten(void **state)
{
    struct rig *rig = *state;
    uint8_t box[128] = { 0 };

    drive_mailbox(rig, DRIVE);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_int_equal(al_request(rig, DRIVE, AL_PREOP), AL_PREOP);
    sdo_read_request(box, 1, 0x1000);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    assert_true(mailbox_receive(rig, DRIVE, box));
}

static void a_newer_reply_waits_behind_a_repeated_one(void **state)
{
    struct rig *rig = *state;
    uint8_t first[128], second[128], box[128];

    drive_preop(rig, DRIVE);
    sdo_read_request(box, 1, 0x1000);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    assert_true(mailbox_receive(rig, DRIVE, first));
    sdo_read_request(box, 2, 0x1001);
    exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
    rig_wait(rig, SLAVE_MAILBOX_NS);
    read_u16(rig, DRIVE, REG_TYPE);
    write_u8(rig, DRIVE, REG_SM + SM_SIZE + SM_ACTIVATE, 3);
    assert_true(mailbox_receive(rig, DRIVE, box));
    assert_memory_equal(box, first, 128);
    assert_true(mailbox_receive(rig, DRIVE, second));
    assert_int_equal(get_u16(second + 9), 0x1001);
    assert_false(mailbox_receive(rig, DRIVE, box));
}

/* --- AL states --- */

struct step {
    uint16_t request, status, code;
};

static void run_steps(struct rig *rig, uint16_t station, const struct step *steps, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(al_request(rig, station, steps[i].request), steps[i].status);
        assert_int_equal(al_code(rig, station), steps[i].code);
    }
}

static void al_refuses_what_the_standard_forbids_and_waits_for_the_acknowledge(void **state)
{
    static const struct step steps[] = {
        { AL_INIT, AL_INIT, 0 },
        { AL_SAFEOP, AL_INIT | AL_ERROR, AL_CODE_INVALID_CHANGE },
        { AL_PREOP, AL_INIT | AL_ERROR, AL_CODE_INVALID_CHANGE }, /* not acknowledged: ignored */
        { AL_INIT | AL_ERROR, AL_INIT, 0 },
        { AL_OP, AL_INIT | AL_ERROR, AL_CODE_INVALID_CHANGE },
        { AL_INIT, AL_INIT, 0 }, /* INIT acknowledges by itself */
        { AL_BOOT, AL_INIT | AL_ERROR, AL_CODE_NO_BOOT },
        { AL_PREOP | AL_ERROR, AL_PREOP, 0 },
        { 7, AL_PREOP | AL_ERROR, AL_CODE_UNKNOWN_STATE },
        { AL_PREOP | AL_ERROR, AL_PREOP, 0 },
        { AL_OP, AL_PREOP | AL_ERROR, AL_CODE_INVALID_CHANGE },
        { AL_INIT, AL_INIT, 0 },
    };
    struct rig *rig = *state;

    drive_mailbox(rig, DRIVE);
    run_steps(rig, DRIVE, steps, sizeof steps / sizeof *steps);
}

static void preop_needs_the_mailbox_of_the_sii(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(al_request(rig, DRIVE, AL_PREOP), AL_INIT | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_MAILBOX_CONFIG);
    write_sm(rig, DRIVE, 0, 0x1000, 128, 0x26, 1);
    write_sm(rig, DRIVE, 1, 0x1080, 64, 0x22, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_PREOP | AL_ERROR), AL_INIT | AL_ERROR);
    drive_mailbox(rig, DRIVE);
    assert_int_equal(al_request(rig, DRIVE, AL_PREOP | AL_ERROR), AL_PREOP);
}

static void safeop_needs_sync_managers_as_long_as_the_mapping(void **state)
{
    static const struct {
        uint16_t out, in;
        uint16_t status, code;
    } rows[] = {
        { 9, 20, AL_PREOP | AL_ERROR, AL_CODE_OUTPUT_CONFIG },
        { 8, 19, AL_PREOP | AL_ERROR, AL_CODE_INPUT_CONFIG },
        { 8, 20, AL_SAFEOP, 0 },
    };
    struct rig *rig = *state;

    drive_preop(rig, DRIVE);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        write_sm(rig, DRIVE, 2, 0x1100, rows[i].out, 0x64, 1);
        write_sm(rig, DRIVE, 3, 0x1200, rows[i].in, 0x20, 1);
        assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP | AL_ERROR), rows[i].status);
        assert_int_equal(al_code(rig, DRIVE), rows[i].code);
    }
}

static void safeop_refuses_cyclic_sync_without_a_period(void **state)
{
    struct rig *rig = *state;

    drive_preop(rig, DRIVE);
    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, DRIVE, 3, 0x1200, 20, 0x20, 1);
    write_u8(rig, DRIVE, REG_DC_ACTIVATION, 3);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_DC_CONFIG);
}

static void al_control_is_locked_until_the_application_has_read_it(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_u16(rig, DRIVE, REG_AL_CONTROL, AL_INIT), 1);
    assert_int_equal(write_u16(rig, DRIVE, REG_AL_CONTROL, AL_INIT), 0);
    rig_wait(rig, SLAVE_AL_NS);
    assert_int_equal(write_u16(rig, DRIVE, REG_AL_CONTROL, AL_INIT), 1);
}

static unsigned exchange_outputs(struct rig *rig, uint32_t logical)
{
    uint8_t data[28] = { 0 };

    return exchange(rig, LRW, logical, data, sizeof data);
}

static void op_waits_for_outputs(void **state)
{
    struct rig *rig = *state;

    drive_safeop(rig, DRIVE, 0);
    assert_int_equal(al_request(rig, DRIVE, AL_OP), AL_SAFEOP);
    assert_int_equal(exchange_outputs(rig, 0), 3);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_OP);
}

static void op_is_refused_when_no_outputs_come(void **state)
{
    struct rig *rig = *state;

    drive_safeop(rig, DRIVE, 0);
    assert_int_equal(al_request(rig, DRIVE, AL_OP), AL_SAFEOP);
    rig_wait(rig, SLAVE_FIRST_OUTPUT_NS);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_SAFEOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_NO_OUTPUTS);
}

static void drive_op(struct rig *rig, uint16_t station)
{
    drive_safeop(rig, station, 0);
    exchange_outputs(rig, 0);
    assert_int_equal(al_request(rig, station, AL_OP), AL_OP);
}

static void a_sync_manager_taken_away_in_op_drops_the_slave(void **state)
{
    struct rig *rig = *state;

    drive_op(rig, DRIVE);
    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 0);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_OUTPUT_CONFIG);
}

static void watchdog_drops_a_drive_to_safeop_after_100_ms(void **state)
{
    struct rig *rig = *state;
    uint8_t count[1];

    drive_op(rig, DRIVE);
    exchange_outputs(rig, 0);
    rig_wait(rig, 99900000);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_OP);
    assert_int_equal(read_u16(rig, DRIVE, REG_WD_STATUS), 1);
    rig_wait(rig, 100000);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_SAFEOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_WATCHDOG);
    assert_int_equal(read_u16(rig, DRIVE, REG_WD_STATUS), 0);
    exchange(rig, FPRD, AT(DRIVE, REG_WD_COUNT), count, 1);
    assert_int_equal(count[0], 1);
    assert_int_equal(al_request(rig, DRIVE, AL_OP), AL_SAFEOP | AL_ERROR);
    exchange_outputs(rig, 0);
    assert_int_equal(al_request(rig, DRIVE, AL_OP | AL_ERROR), AL_OP);
    assert_int_equal(read_u16(rig, DRIVE, REG_WD_STATUS), 1);
}

static void watchdog_time_can_be_set_and_switched_off(void **state)
{
    struct rig *rig = *state;

    write_u16(rig, DRIVE, REG_WD_SM, 20); /* 2 ms */
    drive_op(rig, DRIVE);
    exchange_outputs(rig, 0);
    rig_wait(rig, 2000000);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_SAFEOP | AL_ERROR);
    write_u16(rig, DRIVE, REG_WD_SM, 0);
    exchange_outputs(rig, 0);
    assert_int_equal(al_request(rig, DRIVE, AL_OP | AL_ERROR), AL_OP);
    rig_wait(rig, 10000000000);
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_OP);
}

/* --- terminal --- */

static void a_terminal_copies_al_control_with_its_error_bit(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(al_request(rig, DIO, AL_INIT | AL_ERROR), AL_INIT | AL_ERROR);
    assert_int_equal(al_request(rig, DIO, AL_OP), AL_OP);
    assert_int_equal(al_code(rig, DIO), 0);
}

static void terminal_outputs_reach_the_pins_in_op_and_drop_with_the_watchdog(void **state)
{
    struct rig *rig = *state;
    uint8_t value[1];

    write_sm(rig, DIO, 0, 0x0f00, 1, 0x44, 9);
    write_u8(rig, DIO, REG_DIGITAL_OUT, 0xa5);
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0);
    al_request(rig, DIO, AL_OP);
    write_u8(rig, DIO, REG_DIGITAL_OUT, 0xa5);
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0xa5);
    rig_wait(rig, 100000000);
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0);
    assert_int_equal(read_u16(rig, DIO, REG_AL_STATUS), AL_OP);
    exchange(rig, FPRD, AT(DIO, REG_DIGITAL_OUT), value, 1);
    assert_int_equal(value[0], 0xa5);
    write_u8(rig, DIO, REG_DIGITAL_OUT, 0x5a);
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0x5a);
    al_request(rig, DIO, AL_SAFEOP);
    assert_int_equal(read_u32(rig, DIO, REG_GPO), 0);
}

/* --- distributed clock --- */

static void the_clock_of_a_slave_is_drawn_to_the_reference(void **state)
{
    struct rig *rig = *state;
    struct slave *last = &rig->slaves[2];
    uint8_t bytes[8];
    int64_t away;

    /* Offsets as a master sets them: every clock shows the time since now. */
    exchange(rig, BWR, AT(0, REG_DC_PORT_TIME), bytes, 4);
    for (unsigned i = 0; i < 3; i += 2) {
        put_u64(bytes, (uint64_t) - (int64_t)get_u64(rig->slaves[i].memory + REG_DC_RECEIVE_TIME));
        exchange(rig, FPWR, AT(0x1001 + i, REG_DC_OFFSET), bytes, 8);
    }
    put_u32(bytes, 2 * SEGMENT_HOP_NS);
    exchange(rig, FPWR, AT(0x1003, REG_DC_DELAY), bytes, 4);
    put_u16(bytes, 0x1000);
    exchange(rig, BWR, AT(0, REG_DC_SPEED_START), bytes, 2);
    for (unsigned i = 0; i < 4000; i++) {
        rig_wait(rig, 990000);
        memset(bytes, 0, 8);
        assert_int_equal(exchange(rig, FRMW, AT(0x1001, REG_DC_SYSTEM_TIME), bytes, 8), 2);
    }
    away = (int32_t)(read_u32(rig, 0x1003, REG_DC_DIFFERENCE) & 0x7fffffff);
    assert_in_range(away, 0, 20);
    assert_int_not_equal(last->dc.trim_ppb, 0);
}

static void register_reset_sequence_needs_all_three_letters(void **state)
{
    struct rig *rig = *state;

    drive_preop(rig, DRIVE);
    write_u8(rig, DRIVE, REG_ECAT_RESET, 'R');
    write_u8(rig, DRIVE, REG_ECAT_RESET, 'E');
    write_u8(rig, DRIVE, REG_ECAT_RESET, 'R');
    assert_int_equal(read_u16(rig, DRIVE, REG_AL_STATUS), AL_PREOP);
    write_u8(rig, DRIVE, REG_ECAT_RESET, 'E');
    write_u8(rig, DRIVE, REG_ECAT_RESET, 'S');
    assert_int_equal(rig->slaves[0].state, AL_INIT);
    assert_int_equal(get_u16(rig->slaves[0].memory + REG_STATION_ADDRESS), 0);
    assert_int_equal(get_u16(rig->slaves[0].memory + REG_DL_STATUS), 0x5a33);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(crc_gives_the_published_vectors),
        T(every_device_has_a_well_formed_image),
        T(sii_read_is_busy_and_then_gives_eight_bytes),
        T(sii_read_beyond_the_end_gives_ff),
        T(sii_write_needs_the_enable_bit),
        T(sii_belongs_to_the_pdi_until_the_master_forces_it),
        T(a_bad_checksum_shows_in_status_and_dl_status),
        T(mailbox_is_written_once_until_the_slave_has_taken_it),
        T(empty_mailbox_and_wrong_directions_give_no_working_counter),
        T(mailbox_fills_with_the_last_byte_even_in_pieces),
        T(sm_status_and_pdi_control_are_not_the_masters),
        T(buffered_outputs_take_effect_with_their_last_byte),
        T(buffered_inputs_stay_whole_while_they_are_read),
        T(memory_behind_a_buffered_area_is_reserved),
        T(the_same_configuration_again_does_not_empty_a_running_mailbox),
        T(an_unknown_protocol_gets_a_mailbox_error),
        T(a_length_beyond_the_mailbox_gets_a_mailbox_error),
        T(a_repeated_request_counter_is_not_executed_twice),
        T(a_lost_reply_comes_again_on_a_repeat_request),
        T(what_was_in_the_mailbox_before_preop_is_forgotten),
        T(a_newer_reply_waits_behind_a_repeated_one),
        T(al_refuses_what_the_standard_forbids_and_waits_for_the_acknowledge),
        T(preop_needs_the_mailbox_of_the_sii),
        T(safeop_needs_sync_managers_as_long_as_the_mapping),
        T(safeop_refuses_cyclic_sync_without_a_period),
        T(al_control_is_locked_until_the_application_has_read_it),
        T(op_waits_for_outputs),
        T(op_is_refused_when_no_outputs_come),
        T(a_sync_manager_taken_away_in_op_drops_the_slave),
        T(watchdog_drops_a_drive_to_safeop_after_100_ms),
        T(watchdog_time_can_be_set_and_switched_off),
        T(a_terminal_copies_al_control_with_its_error_bit),
        T(terminal_outputs_reach_the_pins_in_op_and_drop_with_the_watchdog),
        T(the_clock_of_a_slave_is_drawn_to_the_reference),
        T(register_reset_sequence_needs_all_three_letters),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
