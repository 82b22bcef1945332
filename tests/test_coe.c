/* SPDX-License-Identifier: GPL-2.0-or-later */
/* SDO server and object dictionary, message by message. */
#include "bus_rig.h"
#include "bus/drive_device.h"

#define DRIVE 0x1001

static const char *const types[] = { "drive-cia402" };

static uint8_t counter;

static int setup(void **state)
{
    struct rig *rig = rig_new(types, 1);

    *state = rig;
    counter = 0;
    rig_address(rig);
    drive_preop(rig, DRIVE);
    return 0;
}

static int teardown(void **state)
{
    rig_free(*state);
    return 0;
}

/* Body of a reply: CoE header and what follows. */
struct reply {
    uint16_t length;
    uint8_t type;
    uint8_t body[122];
};

static bool receive(struct rig *rig, struct reply *reply)
{
    uint8_t box[128] = { 0 };

    if (exchange(rig, FPRD, AT(DRIVE, 0x1080), box, 128) != 1)
        return false;
    reply->length = get_u16(box);
    reply->type = box[5] & 0x0f;
    memcpy(reply->body, box + 6, sizeof reply->body);
    return true;
}

static void send(struct rig *rig, const void *body, size_t length)
{
    uint8_t box[128] = { 0 };

    counter = (uint8_t)(counter % 7 + 1);
    put_u16(box, (uint32_t)length);
    box[5] = (uint8_t)(3 | counter << 4);
    memcpy(box + 6, body, length);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    rig_wait(rig, SLAVE_MAILBOX_NS);
}

static struct reply sdo(struct rig *rig, uint8_t command, uint16_t index, uint8_t subindex,
                        const void *data, size_t length)
{
    uint8_t body[122] = { 0x00, 0x20, command };
    struct reply reply = { 0 };

    put_u16(body + 3, index);
    body[5] = subindex;
    if (data)
        memcpy(body + 6, data, length);
    send(rig, body, 6 + (length < 4 ? 4 : length));
    assert_true(receive(rig, &reply));
    assert_int_equal(reply.type, MAILBOX_COE);
    return reply;
}

static struct reply sdo_segment(struct rig *rig, uint8_t command, const void *data, size_t length)
{
    uint8_t body[122] = { 0x00, 0x20, command };
    struct reply reply = { 0 };

    if (data)
        memcpy(body + 3, data, length);
    send(rig, body, 3 + (length < 7 ? 7 : length));
    assert_true(receive(rig, &reply));
    return reply;
}

static uint32_t write_value(struct rig *rig, uint16_t index, uint8_t subindex, uint32_t value,
                            unsigned size)
{
    uint8_t data[4];
    struct reply r;

    put_u32(data, value);
    r = sdo(rig, (uint8_t)(0x23 | (4 - size) << 2), index, subindex, data, 4);
    return r.body[2] == 0x80 ? get_u32(r.body + 6) : 0;
}

static uint32_t read_abort(struct rig *rig, uint16_t index, uint8_t subindex)
{
    struct reply r = sdo(rig, 0x40, index, subindex, NULL, 0);

    return r.body[2] == 0x80 ? get_u32(r.body + 6) : 0;
}

static uint32_t read_value(struct rig *rig, uint16_t index, uint8_t subindex)
{
    struct reply r = sdo(rig, 0x40, index, subindex, NULL, 0);

    assert_int_equal(r.body[2] & 0xe3, 0x43);
    return get_u32(r.body + 6);
}

static void expedited_uploads_say_their_size(void **state)
{
    static const struct {
        uint16_t index;
        uint8_t command;
        uint32_t value;
    } rows[] = {
        { 0x1001, 0x4f, 0 },
        { 0x6066, 0x4b, 10 },
        { 0x1000, 0x43, 0x00020192 },
    };

    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct reply r = sdo(*state, 0x40, rows[i].index, 0, NULL, 0);

        assert_int_equal(r.length, 10);
        assert_int_equal(get_u16(r.body), 0x3000);
        assert_int_equal(r.body[2], rows[i].command);
        assert_int_equal(get_u16(r.body + 3), rows[i].index);
        assert_int_equal(get_u32(r.body + 6), rows[i].value);
    }
}

static void a_string_comes_as_a_normal_upload(void **state)
{
    static const char name[] = "Simulated servo drive CiA 402";
    struct reply r = sdo(*state, 0x40, 0x1008, 0, NULL, 0);

    assert_int_equal(r.body[2], 0x41);
    assert_int_equal(get_u32(r.body + 6), sizeof name - 1);
    assert_int_equal(r.length, 10 + sizeof name - 1);
    assert_memory_equal(r.body + 10, name, sizeof name - 1);
}

static void expedited_and_normal_downloads_write_the_same(void **state)
{
    struct rig *rig = *state;
    uint8_t data[8] = { 4, 0, 0, 0, 0x78, 0x56, 0x34, 0x12 };
    struct reply r;

    assert_int_equal(write_value(rig, 0x607a, 0, 0x11223344, 4), 0);
    assert_int_equal(read_value(rig, 0x607a, 0), 0x11223344);
    r = sdo(rig, 0x21, 0x607a, 0, data, 8);
    assert_int_equal(r.body[2], 0x60);
    assert_int_equal(get_u16(r.body + 3), 0x607a);
    assert_int_equal(read_value(rig, 0x607a, 0), 0x12345678);
}

static void aborts_tell_the_reason(void **state)
{
    static const struct {
        bool write;
        uint16_t index;
        uint8_t subindex, size;
        uint32_t value, abort;
    } rows[] = {
        { false, 0x5000, 0, 0, 0, SDO_NO_OBJECT },
        { false, 0x1018, 9, 0, 0, SDO_NO_SUBINDEX },
        { true, 0x1000, 0, 4, 1, SDO_READ_ONLY },
        { true, 0x607a, 0, 2, 1, SDO_TOO_SHORT },
        { true, 0x6060, 0, 2, 1, SDO_TOO_LONG },
        { true, 0x6060, 0, 1, 2, SDO_RANGE },
        { true, 0x605a, 0, 2, 4, SDO_RANGE },
        { true, 0x6072, 0, 2, 3001, SDO_RANGE },
        { true, 0x6098, 0, 1, 33, SDO_RANGE },
        { true, 0x1600, 1, 4, 0x60400010, SDO_SUB0_NOT_ZERO },
        { true, 0x1c12, 1, 2, 0x1601, SDO_SUB0_NOT_ZERO },
        { true, 0x1c12, 0, 1, 5, SDO_RANGE },
    };

    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint32_t abort = rows[i].write ? write_value(*state, rows[i].index, rows[i].subindex,
                                                     rows[i].value, rows[i].size)
                                       : read_abort(*state, rows[i].index, rows[i].subindex);

        assert_int_equal(abort, rows[i].abort);
    }
}

static void unknown_command_specifier_is_aborted(void **state)
{
    struct reply r = sdo(*state, 0xe0, 0x1000, 0, NULL, 0);

    assert_int_equal(r.body[2], 0x80);
    assert_int_equal(get_u32(r.body + 6), SDO_COMMAND);
}

static void complete_access_pads_subindex_0_to_16_bits(void **state)
{
    static const uint8_t managers[] = { 4, 0, 1, 2, 3, 4 };
    struct reply r = sdo(*state, 0x50, 0x1c00, 0, NULL, 0);

    assert_int_equal(r.body[2], 0x51);
    assert_int_equal(get_u32(r.body + 6), sizeof managers);
    assert_int_equal(r.length, 10 + sizeof managers);
    assert_memory_equal(r.body + 10, managers, sizeof managers);
    r = sdo(*state, 0x50, 0x1c12, 0, NULL, 0);
    assert_int_equal(r.body[2], 0x53);
    assert_int_equal(get_u32(r.body + 6), 0x16000001);
    r = sdo(*state, 0x50, 0x1000, 0, NULL, 0);
    assert_int_equal(get_u32(r.body + 6), SDO_NO_COMPLETE_ACCESS);
}

static void complete_access_from_subindex_1_leaves_the_count_out(void **state)
{
    struct reply r = sdo(*state, 0x50, 0x1c00, 1, NULL, 0);

    assert_int_equal(r.body[2], 0x53);
    assert_int_equal(get_u32(r.body + 6), 0x04030201);
}

static void complete_access_download_sets_a_whole_list(void **state)
{
    struct rig *rig = *state;
    uint8_t data[] = { 4, 0, 0, 0, 1, 0, 0x01, 0x16 };
    struct reply r = sdo(rig, 0x31, 0x1c12, 0, data, sizeof data);

    assert_int_equal(r.body[2], 0x70);
    assert_int_equal(read_value(rig, 0x1c12, 0) & 0xff, 1);
    assert_int_equal(read_value(rig, 0x1c12, 1) & 0xffff, 0x1601);
}

/* The same drive with replies of at most 32 bytes. */
static void use_small_mailbox(struct rig *rig)
{
    static struct sii_info sii;
    static struct device_type type;

    type = *rig->slaves[0].type;
    sii = *type.sii;
    sii.mailbox.in_size = 32;
    type.sii = &sii;
    rig->slaves[0].type = &type;
}

static void segmented_upload_carries_what_the_mailbox_cannot(void **state)
{
    struct rig *rig = *state;
    struct drive_device *drive = rig->devices[0];
    uint8_t all[2 + 4 * PDO_MAX_ENTRIES];
    size_t at;
    struct reply r;
    uint8_t toggle = 0;

    use_small_mailbox(rig);
    drive->rx[0].count = PDO_MAX_ENTRIES;
    for (unsigned i = 0; i < PDO_MAX_ENTRIES; i++)
        drive->rx[0].entry[i] = 0xa0b0c000u + i;
    r = sdo(rig, 0x50, 0x1600, 0, NULL, 0);
    assert_int_equal(r.body[2], 0x51);
    assert_int_equal(get_u32(r.body + 6), 2 + 4 * PDO_MAX_ENTRIES);
    at = r.length - 10u;
    assert_int_equal(at, 32 - 6 - 10);
    memcpy(all, r.body + 10, at);
    do {
        r = sdo_segment(rig, (uint8_t)(0x60 | toggle), NULL, 0);
        assert_int_equal(r.body[2] & 0xf0, toggle);
        size_t n = r.length - 3u - (r.body[2] >> 1 & 7u);
        memcpy(all + at, r.body + 3, n);
        at += n;
        toggle ^= 0x10;
    } while (!(r.body[2] & 1));
    assert_int_equal(at, 2 + 4 * PDO_MAX_ENTRIES);
    assert_int_equal(get_u32(all + 2 + 44), 0xa0b0c00bu);
}

static void segmented_download_collects_and_checks_the_toggle(void **state)
{
    struct rig *rig = *state;
    uint8_t size[4] = { 4, 0, 0, 0 }, data[7] = { 0xef, 0xcd, 0xab, 0x09 };
    struct reply r = sdo(rig, 0x21, 0x607a, 0, size, 4);

    assert_int_equal(r.body[2], 0x60);
    assert_int_equal(read_value(rig, 0x607a, 0), 0);
    r = sdo(rig, 0x21, 0x607a, 0, size, 4);
    r = sdo_segment(rig, 0x10 | 3 << 1 | 1, data, 7);
    assert_int_equal(r.body[2], 0x80);
    assert_int_equal(get_u32(r.body + 6), SDO_TOGGLE);
    r = sdo(rig, 0x21, 0x607a, 0, size, 4);
    r = sdo_segment(rig, 3 << 1 | 1, data, 7);
    assert_int_equal(r.body[2], 0x20);
    assert_int_equal(read_value(rig, 0x607a, 0), 0x09abcdef);
}

static void downloads_beyond_what_was_announced_or_fits_are_aborted(void **state)
{
    struct rig *rig = *state;
    uint8_t size[4] = { 4, 0, 0, 0 }, data[100] = { 0 };
    struct reply r = sdo(rig, 0x21, 0x607a, 0, size, 4);

    r = sdo_segment(rig, 1, data, 5);
    assert_int_equal(r.body[2], 0x80);
    assert_int_equal(get_u32(r.body + 6), SDO_TOO_LONG);
    put_u32(size, COE_TRANSFER + 1);
    r = sdo(rig, 0x21, 0x607a, 0, size, 4);
    assert_int_equal(get_u32(r.body + 6), SDO_MEMORY);
    put_u32(size, 300);
    r = sdo(rig, 0x21, 0x607a, 0, size, 4);
    assert_int_equal(r.body[2], 0x60);
    for (unsigned i = 0; i < 3; i++) {
        r = sdo_segment(rig, (uint8_t)(i % 2 ? 0x10 : 0), data, 100);
        assert_int_equal(r.body[2], i % 2 ? 0x30 : 0x20);
    }
    r = sdo_segment(rig, 0x10, data, 7);
    assert_int_equal(get_u32(r.body + 6), SDO_TOO_LONG);
}

static void a_segment_without_a_transfer_is_aborted(void **state)
{
    struct reply r = sdo_segment(*state, 0x60, NULL, 0);

    assert_int_equal(r.body[2], 0x80);
    assert_int_equal(get_u32(r.body + 6), SDO_COMMAND);
}

static void pdo_objects_are_read_only_above_preop(void **state)
{
    struct rig *rig = *state;

    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, DRIVE, 3, 0x1200, 20, 0x20, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_SAFEOP);
    assert_int_equal(write_value(rig, 0x1c12, 0, 0, 1), SDO_DEVICE_STATE);
    assert_int_equal(write_value(rig, 0x6065, 0, 1000, 4), 0);
}

static void another_assignment_changes_the_process_image(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_value(rig, 0x1c12, 0, 0, 1), 0);
    assert_int_equal(write_value(rig, 0x1c12, 1, 0x1777, 2), SDO_RANGE);
    assert_int_equal(write_value(rig, 0x1c12, 1, 0x1603, 2), 0);
    assert_int_equal(write_value(rig, 0x1c12, 0, 1, 1), 0);
    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, DRIVE, 3, 0x1200, 20, 0x20, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_OUTPUT_CONFIG);
    write_sm(rig, DRIVE, 2, 0x1100, 14, 0x64, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP | AL_ERROR), AL_SAFEOP);
}

static void a_mapping_of_ones_own_is_checked_entry_by_entry(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_value(rig, 0x1a00, 0, 0, 1), 0);
    assert_int_equal(write_value(rig, 0x1a00, 1, 0x50000010, 4), SDO_NO_OBJECT);
    assert_int_equal(write_value(rig, 0x1a00, 1, 0x60410110, 4), SDO_NO_SUBINDEX);
    assert_int_equal(write_value(rig, 0x1a00, 1, 0x60400010, 4), SDO_NOT_MAPPABLE);
    assert_int_equal(write_value(rig, 0x1a00, 1, 0x60410008, 4), SDO_PDO_LENGTH);
    assert_int_equal(write_value(rig, 0x1a00, 1, 0x60640020, 4), 0);
    assert_int_equal(write_value(rig, 0x1a00, 2, 0x60410010, 4), 0);
    assert_int_equal(write_value(rig, 0x1a00, 0, 2, 1), 0);
    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, DRIVE, 3, 0x1200, 6, 0x20, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_SAFEOP);
    {
        struct drive_device *drive = rig->devices[0];
        uint8_t data[6];

        assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1200), data, 6), 1);
        assert_int_equal((int32_t)get_u32(data), drive->axis->o.position_actual);
        assert_int_equal(get_u16(data + 4), drive->axis->o.statusword);
    }
}

static void a_mapping_with_a_hole_in_it_is_refused_at_safeop(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(write_value(rig, 0x1600, 0, 0, 1), 0);
    assert_int_equal(write_value(rig, 0x1600, 0, 12, 1), 0); /* entries 5..12 are 0: gaps of 0 */
    write_sm(rig, DRIVE, 2, 0x1100, 8, 0x64, 1);
    write_sm(rig, DRIVE, 3, 0x1200, 20, 0x20, 1);
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_SAFEOP);
    assert_int_equal(al_request(rig, DRIVE, AL_PREOP), AL_PREOP);
    assert_int_equal(write_value(rig, 0x1c12, 0, 2, 1), 0); /* second PDO is index 0 */
    assert_int_equal(al_request(rig, DRIVE, AL_SAFEOP), AL_PREOP | AL_ERROR);
    assert_int_equal(al_code(rig, DRIVE), AL_CODE_OUTPUT_MAPPING);
}

/* --- SDO information --- */

static struct reply info(struct rig *rig, uint8_t opcode, const uint8_t *data, size_t length)
{
    uint8_t body[16] = { 0x00, 0x80, opcode };
    struct reply reply = { 0 };

    memcpy(body + 6, data, length);
    send(rig, body, 6 + length);
    assert_true(receive(rig, &reply));
    assert_int_equal(get_u16(reply.body), 0x8000);
    return reply;
}

static void the_object_list_comes_in_fragments_and_is_complete(void **state)
{
    struct rig *rig = *state;
    uint8_t all[2] = { 1, 0 };
    const struct od *od = &drive_od;
    size_t n = 0;
    unsigned at = 8;
    struct reply r;

    use_small_mailbox(rig);
    r = info(rig, 1, all, 2);
    assert_int_equal(get_u16(r.body + 6), 1);
    assert_true(get_u16(r.body + 4) > 0);
    for (;;) {
        unsigned left = get_u16(r.body + 4);

        assert_int_equal(r.body[2], left ? 0x82 : 0x02);
        for (; at < r.length; at += 2)
            assert_int_equal(get_u16(r.body + at), od->objects[n++].index);
        if (!left)
            break;
        at = 6;
        assert_true(receive(rig, &r));
        assert_int_equal(get_u16(r.body + 4), left - 1);
    }
    assert_int_equal(n, od->count);
    assert_false(receive(rig, &r));
}

static void list_lengths_agree_with_the_lists(void **state)
{
    uint8_t lengths[2] = { 0, 0 };
    struct reply r = info(*state, 1, lengths, 2);

    assert_int_equal(r.length, 6 + 2 + 10);
    assert_int_equal(get_u16(r.body + 8), drive_od.count);
    assert_int_equal(get_u16(r.body + 14), 0);
}

static void objects_and_entries_describe_themselves(void **state)
{
    uint8_t object[2] = { 0x7a, 0x60 }, entry[4] = { 0x7a, 0x60, 0, 0 };
    struct reply r = info(*state, 3, object, 2);

    assert_int_equal(r.body[2], 4);
    assert_int_equal(get_u16(r.body + 6), 0x607a);
    assert_int_equal(get_u16(r.body + 8), OD_I32);
    assert_int_equal(r.body[11], OD_VAR);
    assert_memory_equal(r.body + 12, "target position", 15);
    r = info(*state, 5, entry, 4);
    assert_int_equal(r.body[2], 6);
    assert_int_equal(get_u16(r.body + 10), OD_I32);
    assert_int_equal(get_u16(r.body + 12), 32);
    assert_int_equal(get_u16(r.body + 14), OD_RW | OD_RX_MAP);
    object[0] = 0;
    r = info(*state, 3, object, 2);
    assert_int_equal(r.body[2], 7);
    assert_int_equal(get_u32(r.body + 6), SDO_NO_OBJECT);
}

static void the_dictionary_is_sorted_and_its_entries_lie_inside_the_device(void **state)
{
    (void)state;
    for (size_t i = 0; i < drive_od.count; i++) {
        const struct od_object *object = &drive_od.objects[i];

        if (i)
            assert_true(object->index > drive_od.objects[i - 1].index);
        for (unsigned k = 0; k < object->count; k++) {
            const struct od_entry *e = &object->entries[k];

            if (e->type == OD_STRING || e->offset == OD_CONST)
                continue;
            assert_true(e->offset + (e->last - e->first + 1u) * od_type_bits(e->type) / 8 <=
                        sizeof(struct drive_device));
        }
    }
}

static void random_mailboxes_are_survived(void **state)
{
    struct rig *rig = *state;
    uint32_t random = 12345;

    for (unsigned round = 0; round < 20000; round++) {
        uint8_t box[128];

        for (size_t i = 0; i < sizeof box; i++) {
            random = random * 1664525u + 1013904223u;
            box[i] = (uint8_t)(random >> 24);
        }
        put_u16(box, random % (round % 4 ? 40 : 140));
        box[4] = 0;
        box[5] = (uint8_t)(3 | (round % 7 + 1) << 4);
        put_u16(box + 6, round % 3 ? 0x2000 : 0x8000);
        if (round % 3 == 0)
            box[8] = (uint8_t)(random >> 8 & 7);
        if (round % 2)
            put_u16(box + 9, drive_od.objects[(random >> 16) % drive_od.count].index);
        exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128);
        rig_wait(rig, SLAVE_MAILBOX_NS);
        exchange(rig, FPRD, AT(DRIVE, 0x1080), box, 128);
    }
    while (exchange(rig, FPRD, AT(DRIVE, 0x1080), (uint8_t[128]){ 0 }, 128) == 1)
        ;
    counter = 3; /* not the last one used above: that would be a repetition */
    assert_int_equal(al_code(rig, DRIVE), 0);
    assert_int_equal(read_value(rig, 0x1000, 0), 0x00020192);
}

/* --- captured exchanges --- */

/* SOEM asking a servo drive, as seen on a wire: mailbox header, CoE header, SDO. */
static void an_upload_answers_as_captured_drives_do(void **state)
{
    static const uint8_t request[] = { 0x0a, 0x00, 0x00, 0x00, 0x00, 0x13, 0x00, 0x20,
                                       0x40, 0x00, 0x1c, 0x00, 0x00, 0x00, 0x00, 0x00 };
    static const uint8_t answer[] = { 0x0a, 0x00, 0x00, 0x00, 0x00, 0x13, 0x00, 0x30,
                                      0x4f, 0x00, 0x1c, 0x00, 0x04, 0x00, 0x00, 0x00 };
    struct rig *rig = *state;
    uint8_t box[128] = { 0 };

    memcpy(box, request, sizeof request);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    rig_wait(rig, SLAVE_MAILBOX_NS);
    assert_int_equal(exchange(rig, FPRD, AT(DRIVE, 0x1080), box, 128), 1);
    assert_memory_equal(box, answer, sizeof answer);
}

static void a_mapping_reads_as_captured(void **state)
{
    static const uint8_t first[] = { 0x43, 0x00, 0x16, 0x01, 0x10, 0x00, 0x40, 0x60 };
    static const uint8_t assigned[] = { 0x4b, 0x12, 0x1c, 0x01, 0x00, 0x16, 0x00, 0x00 };
    struct reply r = sdo(*state, 0x40, 0x1600, 1, NULL, 0);

    assert_memory_equal(r.body + 2, first, sizeof first);
    r = sdo(*state, 0x40, 0x1c12, 1, NULL, 0);
    assert_memory_equal(r.body + 2, assigned, sizeof assigned);
}

/* --- emergencies --- */

static void an_emergency_comes_unasked(void **state)
{
    static const uint8_t own[5] = { 1, 2, 3, 4, 5 };
    struct rig *rig = *state;
    struct reply r;

    assert_false(receive(rig, &r));
    mailbox_emergency(&rig->slaves[0], 0x8611, 0x21, own);
    assert_int_equal(rig->slaves[0].memory[REG_SM + SM_SIZE + SM_STATUS] & SM_STATUS_FULL,
                     SM_STATUS_FULL);
    assert_true(receive(rig, &r));
    assert_int_equal(r.type, MAILBOX_COE);
    assert_int_equal(r.length, 10);
    assert_int_equal(get_u16(r.body), 0x1000);
    assert_int_equal(get_u16(r.body + 2), 0x8611);
    assert_int_equal(r.body[4], 0x21);
    assert_memory_equal(r.body + 5, own, 5);
    assert_false(receive(rig, &r));
}

/* Devices reach it through their set-up. */
static struct device_emergency sender;

static void note_setup(void *device, const struct device_setup *setup)
{
    (void)device;
    sender = setup->emergency;
}

static void devices_are_given_a_way_to_send_emergencies(void **state)
{
    static struct device_type type;
    struct rig *rig = *state;
    struct slave_setup one = { .type = &type, .device = rig->devices[0], .seed = 1 };
    struct reply r;

    type = *rig->slaves[0].type;
    type.init = note_setup;
    assert_int_equal(slave_init(&rig->slaves[0], &one), 0);
    segment_init(&rig->segment, rig->slaves, 1);
    rig_address(rig);
    sender.send(sender.to, 0x1234, 1, NULL); /* in INIT there is no mailbox: lost */
    drive_preop(rig, DRIVE);
    assert_false(receive(rig, &r));
    sender.send(sender.to, 0x7500, 0x11, NULL);
    assert_true(receive(rig, &r));
    assert_int_equal(get_u16(r.body + 2), 0x7500);
}

/* ethercrab takes the next message for its answer, whatever it is. */
static void an_emergency_waits_until_the_open_request_is_answered(void **state)
{
    struct rig *rig = *state;
    uint8_t body[10] = { 0x00, 0x20, 0x40, 0x00, 0x10 };
    uint8_t box[128] = { 0 };
    struct reply r;

    counter = (uint8_t)(counter % 7 + 1);
    put_u16(box, sizeof body);
    box[5] = (uint8_t)(3 | counter << 4);
    memcpy(box + 6, body, sizeof body);
    assert_int_equal(exchange(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    mailbox_emergency(&rig->slaves[0], 0x8611, 0x21, NULL);
    assert_false(receive(rig, &r));
    rig_wait(rig, SLAVE_MAILBOX_NS);
    assert_true(receive(rig, &r));
    assert_int_equal(get_u16(r.body), 0x3000);
    assert_true(receive(rig, &r));
    assert_int_equal(get_u16(r.body), 0x1000);
}

static void an_emergency_does_not_part_the_fragments_of_a_list(void **state)
{
    struct rig *rig = *state;
    uint8_t body[8] = { 0x00, 0x80, 1, 0, 0, 0, 1, 0 };
    struct reply r;
    unsigned left;

    use_small_mailbox(rig);
    send(rig, body, sizeof body);
    assert_true(receive(rig, &r));
    mailbox_emergency(&rig->slaves[0], 0x8611, 0x21, NULL);
    for (left = get_u16(r.body + 4); left; left--) {
        assert_true(receive(rig, &r));
        assert_int_equal(get_u16(r.body), 0x8000);
        assert_int_equal(get_u16(r.body + 4), left - 1);
    }
    assert_true(receive(rig, &r));
    assert_int_equal(get_u16(r.body), 0x1000);
}

static void an_emergency_does_not_part_the_segments_of_a_transfer(void **state)
{
    struct rig *rig = *state;
    uint8_t size[4] = { 4, 0, 0, 0 }, data[7] = { 0xef, 0xcd, 0xab, 0x09 };
    struct reply r = sdo(rig, 0x21, 0x607a, 0, size, 4);

    assert_int_equal(r.body[2], 0x60);
    mailbox_emergency(&rig->slaves[0], 0x8611, 0x21, NULL);
    assert_false(receive(rig, &r));
    r = sdo_segment(rig, 3 << 1 | 1, data, 7);
    assert_int_equal(r.body[2], 0x20);
    assert_true(receive(rig, &r));
    assert_int_equal(get_u16(r.body), 0x1000);
}

static void of_many_emergencies_the_first_are_kept_in_order(void **state)
{
    struct rig *rig = *state;
    struct reply r;

    for (unsigned i = 0; i < 20; i++)
        mailbox_emergency(&rig->slaves[0], (uint16_t)(0x8000 + i), 1, NULL);
    for (unsigned i = 0; i < EMERGENCIES + 1; i++) { /* one in the box, the others waiting */
        assert_true(receive(rig, &r));
        assert_int_equal(get_u16(r.body + 2), 0x8000 + i);
    }
    assert_false(receive(rig, &r));
    assert_int_equal(read_value(rig, 0x1000, 0), 0x00020192);
}

/* --- sizes --- */

/* As the smallest servo drives have it: one expedited SDO fits, nothing more. */
static void a_mailbox_of_16_bytes_carries_sdos_and_no_information(void **state)
{
    static const char name[] = "Simulated servo drive CiA 402";
    static struct sii_info sii;
    static struct device_type type;
    struct rig *rig = *state;
    uint8_t list[4] = { 0, 0, 0, 0 }, toggle = 0;
    char text[64] = { 0 };
    size_t at = 0;
    struct reply r;

    type = *rig->slaves[0].type;
    sii = *type.sii;
    sii.mailbox.in_size = 16;
    type.sii = &sii;
    rig->slaves[0].type = &type;
    assert_int_equal(read_value(rig, 0x1000, 0), 0x00020192);
    assert_int_equal(write_value(rig, 0x607a, 0, 77, 4), 0);
    r = sdo(rig, 0x40, 0x1008, 0, NULL, 0);
    assert_int_equal(r.length, 10);
    assert_int_equal(get_u32(r.body + 6), sizeof name - 1);
    do {
        size_t n;

        r = sdo_segment(rig, (uint8_t)(0x60 | toggle), NULL, 0);
        n = 7u - (r.body[2] >> 1 & 7u);
        memcpy(text + at, r.body + 3, n);
        at += n;
        toggle ^= 0x10;
    } while (!(r.body[2] & 1) && at < sizeof text - 7);
    assert_string_equal(text, name);
    for (uint8_t opcode = 1; opcode <= 5; opcode = (uint8_t)(opcode + 2)) {
        put_u16(list, opcode == 1 ? 0 : 0x1000);
        r = info(rig, opcode, list, 4);
        assert_int_equal(r.body[2], 7);
        assert_int_equal(get_u32(r.body + 6), SDO_MAILBOX_LENGTH);
    }
    assert_int_equal(read_value(rig, 0x607a, 0), 77);
}

/* The largest object there can be: 255 values of 32 bits. */
static struct {
    uint8_t count;
    uint32_t value[255];
} big;

static const struct od_entry big_entries[] = {
    { .first = 0, .last = 0, .type = OD_U8, .access = OD_RO, .name = "count" },
    { .first = 1, .last = 255, .type = OD_U32, .access = OD_RW, .offset = 4, .name = "value" },
};
static const struct od_object big_object = { 0x2000, OD_ARRAY, OD_U32, 2, big_entries, "big" };
static const struct od big_od = { .objects = &big_object, .count = 1 };

static void use_big(struct rig *rig)
{
    static struct device_type type;

    type = *rig->slaves[0].type;
    type.od = &big_od;
    rig->slaves[0].type = &type;
    rig->slaves[0].device = &big;
    type.step = NULL;
    big.count = 255;
    for (unsigned i = 0; i < 255; i++)
        big.value[i] = 0x01000193u * (i + 1);
}

static void the_largest_object_goes_up_in_segments(void **state)
{
    struct rig *rig = *state;
    static uint8_t all[1200];
    uint8_t toggle = 0;
    size_t at;
    struct reply r;

    use_big(rig);
    r = sdo(rig, 0x50, 0x2000, 0, NULL, 0);
    assert_int_equal(get_u32(r.body + 6), 2 + 255 * 4);
    at = r.length - 10u;
    memcpy(all, r.body + 10, at);
    do {
        size_t n;

        r = sdo_segment(rig, (uint8_t)(0x60 | toggle), NULL, 0);
        n = r.length - 3u - (r.body[2] >> 1 & 7u);
        memcpy(all + at, r.body + 3, n);
        at += n;
        toggle ^= 0x10;
    } while (!(r.body[2] & 1));
    assert_int_equal(at, 2 + 255 * 4);
    assert_int_equal(get_u16(all), 255);
    for (unsigned i = 0; i < 255; i++)
        assert_int_equal(get_u32(all + 2 + 4 * i), 0x01000193u * (i + 1));
}

static void the_largest_object_comes_down_in_segments(void **state)
{
    struct rig *rig = *state;
    static uint8_t all[4 + 255 * 4];
    uint8_t toggle = 0;
    size_t at = 108, left;
    struct reply r;

    use_big(rig);
    put_u32(all, 255 * 4);
    for (unsigned i = 0; i < 255; i++)
        put_u32(all + 4 + 4 * i, i * 3);
    r = sdo(rig, 0x31, 0x2000, 1, all, 112);
    assert_int_equal(r.body[2], 0x70);
    while ((left = 255 * 4 - at)) {
        size_t n = left < 112 ? left : 112;

        r = sdo_segment(rig, (uint8_t)(toggle | (n == left)), all + 4 + at, n);
        assert_int_equal(r.body[2], 0x20 | toggle);
        toggle ^= 0x10;
        at += n;
    }
    for (unsigned i = 0; i < 255; i++)
        assert_int_equal(big.value[i], i * 3);
}

#define T(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(expedited_uploads_say_their_size),
        T(a_string_comes_as_a_normal_upload),
        T(expedited_and_normal_downloads_write_the_same),
        T(aborts_tell_the_reason),
        T(unknown_command_specifier_is_aborted),
        T(complete_access_pads_subindex_0_to_16_bits),
        T(complete_access_from_subindex_1_leaves_the_count_out),
        T(complete_access_download_sets_a_whole_list),
        T(segmented_upload_carries_what_the_mailbox_cannot),
        T(segmented_download_collects_and_checks_the_toggle),
        T(downloads_beyond_what_was_announced_or_fits_are_aborted),
        T(a_segment_without_a_transfer_is_aborted),
        T(pdo_objects_are_read_only_above_preop),
        T(another_assignment_changes_the_process_image),
        T(a_mapping_of_ones_own_is_checked_entry_by_entry),
        T(a_mapping_with_a_hole_in_it_is_refused_at_safeop),
        T(the_object_list_comes_in_fragments_and_is_complete),
        T(list_lengths_agree_with_the_lists),
        T(objects_and_entries_describe_themselves),
        T(the_dictionary_is_sorted_and_its_entries_lie_inside_the_device),
        T(random_mailboxes_are_survived),
        T(an_upload_answers_as_captured_drives_do),
        T(a_mapping_reads_as_captured),
        T(an_emergency_comes_unasked),
        T(devices_are_given_a_way_to_send_emergencies),
        T(an_emergency_waits_until_the_open_request_is_answered),
        T(an_emergency_does_not_part_the_fragments_of_a_list),
        T(an_emergency_does_not_part_the_segments_of_a_transfer),
        T(of_many_emergencies_the_first_are_kept_in_order),
        T(a_mailbox_of_16_bytes_carries_sdos_and_no_information),
        T(the_largest_object_goes_up_in_segments),
        T(the_largest_object_comes_down_in_segments),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
