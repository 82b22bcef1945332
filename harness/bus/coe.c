/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SDO server: uploads and downloads, expedited, normal, segmented, complete access. */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    COE_HEADER = 2,
    SDO_HEADER = 8, /* command, index, subindex, four bytes */
    SEGMENT_HEADER = 1,
    SEGMENT_MIN = 7, /* data field of the smallest segment */
    BODY_MIN = COE_HEADER + SDO_HEADER,

    SERVICE_REQUEST = 2,
    SERVICE_RESPONSE = 3,
    SERVICE_INFO = 8,

    CCS_DOWNLOAD_SEGMENT = 0,
    CCS_DOWNLOAD = 1,
    CCS_UPLOAD = 2,
    CCS_UPLOAD_SEGMENT = 3,
    CCS_ABORT = 4,

    COMPLETE = 0x10,
    EXPEDITED = 0x02,
    SIZED = 0x01,
    TOGGLE = 0x10,
    LAST = 0x01,
};

static struct mailbox_message *respond(struct slave *slave, uint8_t command)
{
    struct mailbox_message *m = mailbox_new(slave, MAILBOX_COE);
    const struct coe *coe = &slave->mailbox.coe;

    if (!m)
        return NULL;
    put_u16(m->body, SERVICE_RESPONSE << 12);
    m->body[2] = command;
    put_u16(m->body + 3, coe->index);
    m->body[5] = coe->subindex;
    m->length = BODY_MIN;
    return m;
}

static void abort_transfer(struct slave *slave, uint32_t code)
{
    struct mailbox_message *m = respond(slave, CCS_ABORT << 5);

    slave->mailbox.coe.busy = COE_IDLE;
    if (!m)
        return;
    put_u16(m->body, SERVICE_REQUEST << 12); /* where ETG.1000 puts aborts, and stacks too */
    put_u32(m->body + 6, code);
}

static uint32_t gather_one(struct slave *slave, unsigned sub)
{
    struct coe *coe = &slave->mailbox.coe;
    size_t room = sizeof coe->data - coe->size;
    uint32_t abort = od_read(slave->type->od, slave->device, slave->state, coe->index, (uint8_t)sub,
                             coe->data + coe->size, &room);

    if (!abort)
        coe->size += room;
    return abort == SDO_NO_SUBINDEX ? SDO_OK : abort;
}

/* Complete access: subindex 0 takes 16 bits, everything behind it is byte aligned. Subindex 0 says
 * how much of a list is meant. */
static uint32_t gather(struct slave *slave, const struct od_object *object)
{
    struct coe *coe = &slave->mailbox.coe;
    unsigned last;
    uint32_t abort;

    coe->size = 0;
    abort = gather_one(slave, 0);
    last = coe->data[0] < od_max_subindex(object) ? coe->data[0] : od_max_subindex(object);
    if (coe->subindex == 0)
        coe->data[coe->size++] = 0;
    else
        coe->size = 0;
    for (unsigned sub = 1; !abort && sub <= last; sub++)
        abort = gather_one(slave, sub);
    return abort;
}

static uint32_t fetch(struct slave *slave)
{
    struct coe *coe = &slave->mailbox.coe;
    const struct od_object *object = od_find(slave->type->od, coe->index);

    if (!object)
        return SDO_NO_OBJECT;
    if (!coe->complete) {
        coe->size = sizeof coe->data;
        return od_read(slave->type->od, slave->device, slave->state, coe->index, coe->subindex,
                       coe->data, &coe->size);
    }
    if (object->code == OD_VAR || coe->subindex > 1)
        return SDO_NO_COMPLETE_ACCESS;
    return gather(slave, object);
}

static void upload(struct slave *slave)
{
    struct coe *coe = &slave->mailbox.coe;
    uint8_t command = (uint8_t)(CCS_UPLOAD << 5 | (coe->complete ? COMPLETE : 0) | SIZED);
    uint32_t abort = fetch(slave);
    struct mailbox_message *m;
    size_t room;

    if (abort) {
        abort_transfer(slave, abort);
        return;
    }
    if (coe->size >= 1 && coe->size <= 4) {
        m = respond(slave, (uint8_t)(command | EXPEDITED | (4 - coe->size) << 2));
        if (m)
            memcpy(m->body + 6, coe->data, coe->size);
        return;
    }
    m = respond(slave, command);
    if (!m)
        return;
    room = mailbox_room(slave) - BODY_MIN;
    coe->done = coe->size < room ? coe->size : room;
    put_u32(m->body + 6, (uint32_t)coe->size);
    memcpy(m->body + BODY_MIN, coe->data, coe->done);
    m->length = (uint16_t)(BODY_MIN + coe->done);
    if (coe->done < coe->size) {
        coe->busy = COE_UPLOAD;
        coe->toggle = 0;
    }
}

static void upload_segment(struct slave *slave, uint8_t command)
{
    struct coe *coe = &slave->mailbox.coe;
    size_t room = mailbox_room(slave) - COE_HEADER - SEGMENT_HEADER;
    size_t left = coe->size - coe->done;
    struct mailbox_message *m;
    size_t n, field;

    if (coe->busy != COE_UPLOAD || (command & TOGGLE) != coe->toggle) {
        abort_transfer(slave, coe->busy == COE_UPLOAD ? SDO_TOGGLE : SDO_COMMAND);
        return;
    }
    n = left < room ? left : room;
    field = n < SEGMENT_MIN ? SEGMENT_MIN : n;
    m = respond(slave, 0);
    if (!m)
        return;
    m->body[2] = (uint8_t)(coe->toggle | (field - n) << 1 | (n == left ? LAST : 0));
    memset(m->body + 3, 0, SEGMENT_MIN);
    memcpy(m->body + 3, coe->data + coe->done, n);
    m->length = (uint16_t)(COE_HEADER + SEGMENT_HEADER + field);
    coe->done += n;
    coe->toggle ^= TOGGLE;
    if (n == left)
        coe->busy = COE_IDLE;
}

/* A list is closed, filled and opened again in one go; see pdo_check(). */
static uint32_t scatter(struct slave *slave, const struct od_object *object)
{
    const struct coe *coe = &slave->mailbox.coe;
    const struct od_entry *count = od_entry(object, 0);
    size_t at = coe->subindex == 0 ? 2 : 0;
    bool list = count && (count->access & OD_WR_PREOP) && coe->subindex == 0;
    static const uint8_t zero = 0;
    uint32_t abort = SDO_OK;

    if (coe->subindex == 0 && coe->size < 2)
        return SDO_TOO_SHORT;
    if (list)
        abort = od_write(slave->type->od, slave->device, slave->state, coe->index, 0, &zero, 1);
    for (unsigned sub = 1; !abort && sub <= od_max_subindex(object) && at < coe->size; sub++) {
        const struct od_entry *e = od_entry(object, (uint8_t)sub);
        size_t n = e ? od_type_bytes(e->type) : 0;

        if (!n)
            continue;
        if (n > coe->size - at)
            return SDO_TOO_SHORT;
        abort = od_write(slave->type->od, slave->device, slave->state, coe->index, (uint8_t)sub,
                         coe->data + at, n);
        at += n;
    }
    if (!abort && at < coe->size)
        abort = SDO_TOO_LONG;
    if (!abort && list)
        abort = od_write(slave->type->od, slave->device, slave->state, coe->index, 0, coe->data, 1);
    return abort;
}

static uint32_t commit(struct slave *slave)
{
    struct coe *coe = &slave->mailbox.coe;
    const struct od_object *object = od_find(slave->type->od, coe->index);

    coe->busy = COE_IDLE;
    if (!object)
        return SDO_NO_OBJECT;
    if (!coe->complete)
        return od_write(slave->type->od, slave->device, slave->state, coe->index, coe->subindex,
                        coe->data, coe->size);
    if (object->code == OD_VAR || coe->subindex > 1)
        return SDO_NO_COMPLETE_ACCESS;
    return scatter(slave, object);
}

static void finish_download(struct slave *slave, uint8_t command)
{
    uint32_t abort = commit(slave);

    if (abort)
        abort_transfer(slave, abort);
    else
        respond(slave, command);
}

static void download(struct slave *slave, uint8_t command, const uint8_t *data, size_t length)
{
    struct coe *coe = &slave->mailbox.coe;
    uint8_t answer = (uint8_t)(CCS_UPLOAD_SEGMENT << 5 | (coe->complete ? COMPLETE : 0));

    if (command & EXPEDITED) {
        coe->size = command & SIZED ? 4u - (command >> 2 & 3u) : 4u;
        memcpy(coe->data, data, coe->size);
        finish_download(slave, answer);
        return;
    }
    coe->size = get_u32(data);
    coe->done = length - 4;
    if (coe->size > sizeof coe->data) {
        abort_transfer(slave, SDO_MEMORY);
        return;
    }
    /* Small values leave unused bytes behind them in the mailbox. */
    if (coe->done > coe->size)
        coe->done = coe->size;
    memcpy(coe->data, data + 4, coe->done);
    if (coe->done == coe->size) {
        finish_download(slave, answer);
        return;
    }
    coe->busy = COE_DOWNLOAD;
    coe->toggle = 0;
    respond(slave, answer);
}

static void download_segment(struct slave *slave, uint8_t command, const uint8_t *data,
                             size_t length)
{
    struct coe *coe = &slave->mailbox.coe;
    uint8_t answer = (uint8_t)(CCS_DOWNLOAD << 5 | coe->toggle);
    size_t unused = length == SEGMENT_MIN ? command >> 1 & 7u : 0;

    if (coe->busy != COE_DOWNLOAD || (command & TOGGLE) != coe->toggle) {
        abort_transfer(slave, coe->busy == COE_DOWNLOAD ? SDO_TOGGLE : SDO_COMMAND);
        return;
    }
    length -= unused;
    if (length > coe->size - coe->done) {
        abort_transfer(slave, SDO_TOO_LONG);
        return;
    }
    memcpy(coe->data + coe->done, data, length);
    coe->done += length;
    coe->toggle ^= TOGGLE;
    if (!(command & LAST)) {
        respond(slave, answer);
        return;
    }
    if (coe->done < coe->size)
        abort_transfer(slave, SDO_TOO_SHORT);
    else
        finish_download(slave, answer);
}

static uint32_t fault_abort(const struct slave *slave)
{
    const struct coe *coe = &slave->mailbox.coe;

    for (unsigned i = 0; i < slave->faults.abort_count; i++) {
        const struct slave_abort *a = &slave->faults.aborts[i];

        if ((!a->index || a->index == coe->index) &&
            (a->subindex < 0 || a->subindex == coe->subindex))
            return a->code;
    }
    return SDO_OK;
}

static enum mailbox_error sdo_request(struct slave *slave, const uint8_t *sdo, size_t length)
{
    struct coe *coe = &slave->mailbox.coe;
    uint8_t command = sdo[0];
    unsigned specifier = command >> 5;
    uint32_t refused;

    if (length < SDO_HEADER)
        return MAILBOX_TOO_SHORT;
    /* Segments carry data where the others carry index and subindex. */
    if (specifier == CCS_DOWNLOAD_SEGMENT) {
        download_segment(slave, command, sdo + 1, length - 1);
        return MAILBOX_OK;
    }
    if (specifier == CCS_UPLOAD_SEGMENT) {
        upload_segment(slave, command);
        return MAILBOX_OK;
    }
    coe->busy = COE_IDLE;
    coe->complete = command & COMPLETE;
    coe->index = get_u16(sdo + 1);
    coe->subindex = sdo[3];
    refused = specifier == CCS_ABORT ? SDO_OK : fault_abort(slave);
    if (refused)
        abort_transfer(slave, refused);
    else if (specifier == CCS_UPLOAD)
        upload(slave);
    else if (specifier == CCS_DOWNLOAD)
        download(slave, command, sdo + 4, length - 4);
    else if (specifier != CCS_ABORT)
        abort_transfer(slave, SDO_COMMAND);
    return MAILBOX_OK;
}

enum mailbox_error coe_request(struct slave *slave, const uint8_t *body, size_t length)
{
    if (length < COE_HEADER + 1)
        return MAILBOX_TOO_SHORT;
    switch (get_u16(body) >> 12) {
    case SERVICE_REQUEST:
        return sdo_request(slave, body + COE_HEADER, length - COE_HEADER);
    case SERVICE_INFO:
        return coe_info_request(slave, body + COE_HEADER, length - COE_HEADER);
    default:
        return MAILBOX_SERVICE;
    }
}

void coe_continue(struct slave *slave)
{
    if (slave->mailbox.coe.busy == COE_INFO_LIST)
        coe_info_continue(slave);
}
