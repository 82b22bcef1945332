/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The slave controller: SII, sync managers, mailbox transport, AL states, watchdog, clock. */
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

static uint16_t sii_command(struct rig *rig, uint16_t station, uint16_t command, uint32_t address)
{
    uint8_t request[6];

    put_u16(request, command);
    put_u32(request + 2, address);
    return (uint16_t)exchange(rig, FPWR, AT(station, REG_EEPROM_CONTROL), request, 6);
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

static bool mailbox_receive(struct rig *rig, uint16_t station, uint8_t box[128])
{
    rig_wait(rig, SLAVE_MAILBOX_NS);
    return exchange(rig, FPRD, AT(station, 0x1080), box, 128) == 1;
}

static void sdo_read_request(uint8_t box[128], uint8_t counter, uint16_t index)
{
    memset(box, 0, 128);
    put_u16(box, 10);
    box[5] = (uint8_t)(3 | counter << 4);
    put_u16(box + 6, 0x2000);
    box[8] = 0x40;
    put_u16(box + 9, index);
}

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
    uint8_t sm[8] = { 0xf0, 0xff, 0x07, 0x30, 0x44, 0, 1, 0 };

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
        T(a_processor_without_dictionary_checks_its_sync_managers_against_the_sii),
        T(requests_wait_when_their_answers_would_not_fit),
        T(mailbox_errors_are_not_answered),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
