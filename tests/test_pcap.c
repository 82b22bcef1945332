/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Captures: their bytes, their order, and a file with one of everything for tests/captures.sh. */
#include <errno.h>
#include <stdio.h>
#include <sys/stat.h>

#include "bus_rig.h"
#include "bus/bus.h"
#include "bus/drive_device.h"
#include "bus/pcap.h"
#include "bus/wire.h"

#define DRIVE 0x1001

/* Everything the sink was given. */
struct tape {
    uint8_t bytes[1 << 20];
    size_t used;
    unsigned calls;
    int error;
};

static struct tape tape;
static struct pcap pcap;

static int to_tape(void *argument, const void *data, size_t size)
{
    struct tape *t = argument;

    t->calls++;
    if (t->error)
        return t->error;
    assert_true(t->used + size <= sizeof t->bytes);
    memcpy(t->bytes + t->used, data, size);
    t->used += size;
    return 0;
}

static int begin(void **state)
{
    (void)state;
    memset(&tape, 0, sizeof tape);
    pcap_open(&pcap, PCAP_FILE, to_tape, &tape, 0);
    return 0;
}

/* Time and frame number n (from 0) of the tape; NULL past the end. */
static const uint8_t *frame_of(unsigned n, uint64_t *at_ns, uint32_t *length)
{
    size_t at = PCAP_FILE_HEADER;

    while (at < tape.used) {
        const uint8_t *r = tape.bytes + at;

        *length = get_u32(r + 8);
        *at_ns = get_u32(r) * UINT64_C(1000000000) + get_u32(r + 4);
        assert_int_equal(get_u32(r + 12), *length);
        if (n-- == 0)
            return r + PCAP_RECORD_HEADER;
        at += PCAP_RECORD_HEADER + *length;
    }
    assert_int_equal(at, tape.used);
    return NULL;
}

static void a_file_begins_with_nanosecond_magic_version_and_ethernet(void **state)
{
    static const uint8_t header[PCAP_FILE_HEADER] = { 0x4d, 0x3c, 0xb2, 0xa1, 2,    0,    4, 0,
                                                      0,    0,    0,    0,    0,    0,    0, 0,
                                                      0xff, 0xff, 0,    0,    0x01, 0x00, 0, 0 };

    (void)state;
    assert_int_equal(pcap_close(&pcap), 0);
    assert_int_equal(tape.used, sizeof header);
    assert_memory_equal(tape.bytes, header, sizeof header);
}

static void a_short_frame_is_padded_with_zeros_to_60_bytes(void **state)
{
    uint8_t frame[20];
    uint64_t at;
    uint32_t length;

    (void)state;
    memset(frame, 0xaa, sizeof frame);
    pcap_frame(&pcap, UINT64_C(3000000007), frame, sizeof frame);
    assert_int_equal(pcap_close(&pcap), 0);
    const uint8_t *back = frame_of(0, &at, &length);
    assert_int_equal(at, UINT64_C(3000000007));
    assert_int_equal(length, 60);
    assert_memory_equal(back, frame, 20);
    for (unsigned i = 20; i < 60; i++)
        assert_int_equal(back[i], 0);
}

static void times_count_from_the_epoch(void **state)
{
    uint8_t frame[60] = { 0 };
    uint64_t at;
    uint32_t length;

    (void)state;
    pcap_open(&pcap, PCAP_FILE, to_tape, &tape, UINT64_C(1700000000999999999));
    pcap_frame(&pcap, 2, frame, sizeof frame);
    pcap_close(&pcap);
    frame_of(0, &at, &length);
    assert_int_equal(at, UINT64_C(1700000001000000001));
}

static void frames_known_ahead_are_written_in_the_order_of_their_times(void **state)
{
    static const uint64_t ahead[] = { 500, 100, 900, 300, 300 };
    static const struct {
        uint64_t at;
        uint8_t mark;
    } expected[] = { { 50, 9 },  { 100, 1 }, { 300, 3 }, { 300, 4 },
                     { 400, 8 }, { 500, 0 }, { 900, 2 } };
    uint8_t frame[60] = { 0 };
    uint64_t at;
    uint32_t length;

    (void)state;
    for (uint8_t i = 0; i < 5; i++) {
        frame[0] = i;
        pcap_frame_at(&pcap, ahead[i], frame, sizeof frame);
    }
    frame[0] = 9;
    pcap_frame(&pcap, 50, frame, sizeof frame);
    frame[0] = 8;
    pcap_frame(&pcap, 400, frame, sizeof frame);
    assert_int_equal(pcap_close(&pcap), 0);
    for (unsigned i = 0; i < sizeof expected / sizeof *expected; i++) {
        assert_int_equal(frame_of(i, &at, &length)[0], expected[i].mark);
        assert_int_equal(at, expected[i].at);
    }
    assert_null(frame_of(7, &at, &length));
}

static void more_frames_ahead_than_there_is_room_for_are_not_lost(void **state)
{
    uint8_t frame[60] = { 0 };
    uint64_t at, before = 0;
    uint32_t length;

    (void)state;
    for (unsigned i = 0; i < 5 * PCAP_AHEAD; i++)
        pcap_frame_at(&pcap, 1000 + i, frame, sizeof frame);
    pcap_close(&pcap);
    assert_int_equal(pcap.frames, 5 * PCAP_AHEAD);
    for (unsigned i = 0; i < 5 * PCAP_AHEAD; i++, before = at) {
        assert_non_null(frame_of(i, &at, &length));
        assert_true(at > before);
    }
}

static void the_sink_is_called_with_whole_records_and_seldom(void **state)
{
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 };
    uint64_t at;
    uint32_t length;

    (void)state;
    for (unsigned i = 0; i < 400; i++)
        pcap_frame(&pcap, i, frame, 60 + i * 3);
    pcap_close(&pcap);
    assert_in_range(tape.calls, 400u * 676 / PCAP_BUFFER, 2 * 400u * 676 / PCAP_BUFFER);
    for (unsigned i = 0; i < 400; i++) {
        assert_non_null(frame_of(i, &at, &length));
        assert_int_equal(length, 60 + i * 3);
    }
    assert_null(frame_of(400, &at, &length));
}

static void the_first_write_error_is_told_at_the_end_and_nothing_follows_it(void **state)
{
    uint8_t frame[SEGMENT_FRAME_MAX] = { 0 };

    (void)state;
    tape.error = -ENOSPC;
    for (unsigned i = 0; i < 100; i++)
        pcap_frame(&pcap, i, frame, sizeof frame);
    tape.error = 0;
    pcap_frame(&pcap, 100, frame, sizeof frame);
    assert_int_equal(tape.calls, 1);
    assert_int_equal(pcap_close(&pcap), -ENOSPC);
    assert_int_equal(tape.used, 0);
}

/* What pcap_append() makes of two good records with one byte changed. */
static int append_with(size_t offset, uint8_t value)
{
    static struct pcap from;
    static struct tape records;
    uint8_t frame[64] = { 1, 2, 3 };

    memset(&records, 0, sizeof records);
    pcap_open(&from, PCAP_RECORDS, to_tape, &records, 0);
    pcap_frame(&from, 5, frame, sizeof frame);
    pcap_frame(&from, 6, frame, sizeof frame);
    pcap_close(&from);
    assert_int_equal(records.used, 2 * (PCAP_RECORD_HEADER + 64));
    records.bytes[offset] = value;
    begin(NULL);
    int error = pcap_append(&pcap, records.bytes, records.used);
    assert_int_equal(pcap_close(&pcap), error);
    return error;
}

static void records_of_another_capture_are_taken_as_they_are(void **state)
{
    uint64_t at;
    uint32_t length;

    (void)state;
    assert_int_equal(append_with(16, 1), 0);
    assert_int_equal(pcap.frames, 2);
    assert_int_equal(frame_of(1, &at, &length)[2], 3);
    assert_int_equal(at, 6);
    assert_int_equal(length, 64);
}

static void what_is_no_record_is_refused_and_ends_the_file_before_it(void **state)
{
    static const struct {
        size_t offset;
        uint8_t value;
    } damage[] = { { 80 + 7, 0xff }, /* nanoseconds */
                   { 80 + 8, 65 },
                   { 80 + 12, 65 }, /* lengths that disagree */
                   { 80 + 9, 0x40 },
                   { 80 + 11, 0xff } };

    (void)state;
    for (size_t i = 0; i < sizeof damage / sizeof *damage; i++) {
        assert_int_equal(append_with(damage[i].offset, damage[i].value), -EBADMSG);
        assert_int_equal(pcap.frames, 1);
        assert_int_equal(tape.used, PCAP_FILE_HEADER + PCAP_RECORD_HEADER + 64);
    }
    uint8_t cut[PCAP_RECORD_HEADER + 59] = { 0 };
    cut[8] = cut[12] = 60;
    begin(NULL);
    assert_int_equal(pcap_append(&pcap, cut, sizeof cut), -EBADMSG);
    assert_int_equal(pcap.frames, 0);
    cut[8] = cut[12] = 59;
    begin(NULL);
    assert_int_equal(pcap_append(&pcap, cut, sizeof cut), -EBADMSG);
}

/* --- on the wire --------------------------------------------------------------------------------
 */

static bool send_captured(struct rig *rig, uint64_t *back_ns)
{
    struct wire wire = { .segment = &rig->segment, .capture = &pcap };
    enum segment_port port = SEGMENT_PORT_A;
    size_t length = rig->used < SEGMENT_FRAME_MIN ? SEGMENT_FRAME_MIN : rig->used;

    rig->now += 100000;
    return wire_transfer(&wire, &port, rig->frame, length, rig->now, back_ns);
}

static unsigned exchange_captured(struct rig *rig, uint8_t command, uint32_t address, void *data,
                                  size_t length)
{
    frame_begin(rig);
    size_t at = frame_add(rig, command, address, data, length);
    assert_true(send_captured(rig, NULL));
    memcpy(data, frame_data(rig, at), length);
    return frame_wkc(rig, at);
}

static void a_frame_is_seen_as_sent_and_as_it_came_back(void **state)
{
    static const char *const types[] = { "drive-cia402", "dio-8x8" };
    struct rig *rig = rig_new(types, 2);
    uint64_t at, back;
    uint32_t length;

    (void)state;
    frame_begin(rig);
    frame_add(rig, BRD, AT(0, 0), NULL, 2);
    assert_true(send_captured(rig, &back));
    pcap_close(&pcap);
    const uint8_t *sent = frame_of(0, &at, &length);
    assert_int_equal(at, rig->now);
    assert_int_equal(sent[6], 0x10);
    assert_int_equal(get_u16(sent + 16 + 2), 0);
    assert_int_equal(get_u16(sent + 16 + 12), 0);
    const uint8_t *came = frame_of(1, &at, &length);
    assert_int_equal(at, back);
    assert_int_equal(came[6], 0x12);
    assert_int_equal(get_u16(came + 16 + 2), 2);
    assert_int_equal(get_u16(came + 16 + 12), 2);
    assert_null(frame_of(2, &at, &length));
    rig_free(rig);
}

static void a_frame_that_stays_away_is_seen_once(void **state)
{
    static const char *const types[] = { "dio-8x8" };
    struct rig *rig = rig_new(types, 1);
    uint64_t at;
    uint32_t length;

    (void)state;
    segment_cable(&rig->segment, 0, false, 0);
    frame_begin(rig);
    frame_add(rig, BRD, AT(0, 0), NULL, 2);
    assert_false(send_captured(rig, NULL));
    pcap_close(&pcap);
    assert_non_null(frame_of(0, &at, &length));
    assert_null(frame_of(1, &at, &length));
    rig_free(rig);
}

/* --- one of everything, for tests/captures.sh ----------------------------------------------------
 */

static int to_file(void *argument, const void *data, size_t size)
{
    return fwrite(data, 1, size, argument) == size ? 0 : -EIO;
}

static FILE *open_capture(const char *name)
{
    char path[256];

    mkdir(TEST_CAPTURES_DIR, 0777);
    snprintf(path, sizeof path, "%s/%s.pcap", TEST_CAPTURES_DIR, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    pcap_open(&pcap, PCAP_FILE, to_file, file, 0);
    return file;
}

static void close_capture(FILE *file)
{
    assert_int_equal(pcap_close(&pcap), 0);
    assert_int_equal(fclose(file), 0);
}

/* One mailbox message there and all that answer it. Returns the body of the last. */
static const uint8_t *converse(struct rig *rig, const void *body, size_t length)
{
    static uint8_t counter, box[128];
    uint8_t again[128];

    memset(box, 0, sizeof box);
    counter = (uint8_t)(counter % 7 + 1);
    put_u16(box, (uint32_t)length);
    box[5] = (uint8_t)(3 | counter << 4);
    memcpy(box + 6, body, length);
    assert_int_equal(exchange_captured(rig, FPWR, AT(DRIVE, 0x1000), box, 128), 1);
    rig_wait(rig, SLAVE_MAILBOX_NS);
    assert_int_equal(exchange_captured(rig, FPRD, AT(DRIVE, 0x1080), box, 128), 1);
    while (exchange_captured(rig, FPRD, AT(DRIVE, 0x1080), again, 128) == 1)
        memcpy(box, again, sizeof box);
    return box + 6;
}

/* Replies of 32 bytes: the object list and the mappings need several. */
static void shrink_mailbox(struct rig *rig)
{
    static struct sii_info sii;
    static struct device_type type;

    type = *rig->slaves[0].type;
    sii = *type.sii;
    sii.mailbox.in_size = 32;
    type.sii = &sii;
    rig->slaves[0].type = &type;
}

static void mailbox_services_are_captured_for_dissection(void **state)
{
    static const char *const types[] = { "drive-cia402" };
    static const uint8_t read_name[] = { 0, 0x20, 0x40, 0x08, 0x10, 0, 0, 0, 0, 0 };
    static const uint8_t next[2][10] = { { 0, 0x20, 0x60 }, { 0, 0x20, 0x70 } };
    static const uint8_t write_map[] = { 0, 0x20, 0x31, 0, 0x16, 0,    10,   0, 0,    0,
                                         2, 0,    0x10, 0, 0x40, 0x60, 0x20, 0, 0x7a, 0x60 };
    static const uint8_t clear[] = { 0, 0x20, 0x2f, 0x12, 0x1c, 0, 0, 0, 0, 0 };
    static const uint8_t begin_write[] = { 0, 0x20, 0x21, 0x7a, 0x60, 0, 4, 0, 0, 0 };
    static const uint8_t segment[] = { 0, 0x20, 3 << 1 | 1, 0xef, 0xcd, 0xab, 9, 0, 0, 0 };
    static const uint8_t list[] = { 0, 0x80, 1, 0, 0, 0, 1, 0 };
    static const uint8_t describe[] = { 0, 0x80, 3, 0, 0, 0, 0x18, 0x10 };
    static const uint8_t entry[] = { 0, 0x80, 5, 0, 0, 0, 0x18, 0x10, 1, 1 };
    static const uint8_t missing[] = { 0, 0x20, 0x40, 0xff, 0xff, 0, 0, 0, 0, 0 };
    struct rig *rig = rig_new(types, 1);
    FILE *file = open_capture("mailbox");
    const uint8_t *body;
    unsigned segments = 0;

    (void)state;
    rig_address(rig);
    drive_preop(rig, DRIVE);
    body = converse(rig, clear, sizeof clear);
    assert_int_equal(body[2], 0x60);
    body = converse(rig, write_map, sizeof write_map);
    assert_int_equal(body[2], 0x70);
    body = converse(rig, begin_write, sizeof begin_write);
    assert_int_equal(body[2], 0x60);
    body = converse(rig, segment, sizeof segment);
    assert_int_equal(body[2], 0x20);
    body = converse(rig, missing, sizeof missing);
    assert_int_equal(body[2], 0x80);
    body = converse(rig, describe, sizeof describe);
    assert_int_equal(body[2], 0x04);
    body = converse(rig, entry, sizeof entry);
    assert_int_equal(body[2], 0x06);
    body = converse(rig, list, sizeof list);
    assert_int_equal(body[2], 0x02);
    shrink_mailbox(rig);
    body = converse(rig, list, sizeof list);
    assert_int_equal(body[2], 0x02);
    assert_int_equal(get_u16(body + 4), 0);
    body = converse(rig, read_name, sizeof read_name);
    assert_int_equal(get_u32(body + 6), sizeof DRIVE_NAME - 1);
    do
        body = converse(rig, next[segments++ % 2], sizeof next[0]);
    while (!(body[2] & 1));
    assert_int_equal(segments, 1);
    close_capture(file);
    rig_free(rig);
}

static void a_run_of_soem_is_captured_for_dissection(void **state)
{
    static const struct bus_device devices[] = { { .type = "drive-cia402" },
                                                 { .type = "dio-8x8" } };
    struct bus_config config = {
        .devices = devices, .device_count = 2, .cycle_ns = 1000000, .seed = 3, .capture = &pcap
    };
    FILE *file = open_capture("soem");
    char why[BUS_WHY], name[64];
    struct bus *bus;
    uint64_t sent, at_ns, before = 0;
    size_t size = sizeof name;

    (void)state;
    assert_int_equal(bus_open(&bus, &config, why), 0);
    bus_request_op(bus);
    for (unsigned i = 0; i < 100; i++) {
        bus_send(bus, bus_now(bus) + 800000);
        bus_poll_states(bus);
        assert_int_equal(bus_receive(bus, bus_now(bus) + 200000), bus_expected_wkc(bus));
    }
    assert_int_equal(bus_slave(bus, 0)->al_state, 8);
    assert_int_equal(bus_sdo_read(bus, 0, 0x1008, 0, name, &size, NULL), 0);
    bus_close(bus);
    sent = pcap.frames;
    assert_true(sent > 2 * 100);
    close_capture(file);

    /* In order, though two frames were under way at once. */
    file = fopen(TEST_CAPTURES_DIR "/soem.pcap", "rb");
    tape.used = fread(tape.bytes, 1, sizeof tape.bytes, file);
    fclose(file);
    uint32_t length;
    for (unsigned i = 0; i < sent; i++, before = at_ns) {
        assert_non_null(frame_of(i, &at_ns, &length));
        assert_true(at_ns >= before);
    }
}

#define T(name) cmocka_unit_test_setup(name, begin)

int main(void)
{
    static const struct CMUnitTest tests[] = {
        T(a_file_begins_with_nanosecond_magic_version_and_ethernet),
        T(a_short_frame_is_padded_with_zeros_to_60_bytes),
        T(times_count_from_the_epoch),
        T(frames_known_ahead_are_written_in_the_order_of_their_times),
        T(more_frames_ahead_than_there_is_room_for_are_not_lost),
        T(the_sink_is_called_with_whole_records_and_seldom),
        T(the_first_write_error_is_told_at_the_end_and_nothing_follows_it),
        T(records_of_another_capture_are_taken_as_they_are),
        T(what_is_no_record_is_refused_and_ends_the_file_before_it),
        T(a_frame_is_seen_as_sent_and_as_it_came_back),
        T(a_frame_that_stays_away_is_seen_once),
        T(mailbox_services_are_captured_for_dissection),
        T(a_run_of_soem_is_captured_for_dissection),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
