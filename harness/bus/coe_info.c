/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The SDO information service: object list, object descriptions, entry descriptions. */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    HEADER = 6, /* CoE header, opcode, reserved, fragments left */
    SERVICE_INFO = 8,
    LIST_REQUEST = 1,
    LIST_RESPONSE,
    OBJECT_REQUEST,
    OBJECT_RESPONSE,
    ENTRY_REQUEST,
    ENTRY_RESPONSE,
    INFO_ERROR,
    INCOMPLETE = 0x80,
    LIST_LENGTHS = 0,
    LIST_ALL,
    LIST_RX,
    LIST_TX,
    LIST_LAST = 5, /* 4 backup, 5 start-up: none of ours */
    NAME_MAX = 40,
};

static struct mailbox_message *answer(struct slave *slave, uint8_t opcode, unsigned left)
{
    struct mailbox_message *m = mailbox_new(slave, MAILBOX_COE);

    if (!m)
        return NULL;
    put_u16(m->body, SERVICE_INFO << 12);
    m->body[2] = (uint8_t)(opcode | (left ? INCOMPLETE : 0));
    put_u16(m->body + 4, left);
    m->length = HEADER;
    return m;
}

static void answer_error(struct slave *slave, uint32_t code)
{
    struct mailbox_message *m = answer(slave, INFO_ERROR, 0);

    if (!m)
        return;
    put_u32(m->body + HEADER, code);
    m->length = HEADER + 4;
}

/* An answer with `size` bytes behind the header; mailboxes of the smallest size hold none. */
static struct mailbox_message *answer_sized(struct slave *slave, uint8_t opcode, unsigned size)
{
    if (HEADER + size <= mailbox_room(slave))
        return answer(slave, opcode, 0);
    answer_error(slave, SDO_MAILBOX_LENGTH);
    return NULL;
}

static bool listed(const struct od_object *object, unsigned list)
{
    uint16_t wanted = list == LIST_RX ? OD_RX_MAP : list == LIST_TX ? OD_TX_MAP : 0;

    if (list == LIST_ALL)
        return true;
    for (unsigned i = 0; i < object->count; i++) {
        if (object->entries[i].access & wanted)
            return true;
    }
    return false;
}

static unsigned count_from(const struct od *od, size_t first, unsigned list)
{
    unsigned count = 0;

    for (size_t i = first; i < od->count; i++)
        count += listed(&od->objects[i], list);
    return count;
}

static void list_lengths(struct slave *slave)
{
    struct mailbox_message *m = answer_sized(slave, LIST_RESPONSE, 2 + 2 * LIST_LAST);

    if (!m)
        return;
    put_u16(m->body + HEADER, LIST_LENGTHS);
    for (unsigned list = LIST_ALL; list <= LIST_LAST; list++)
        put_u16(m->body + HEADER + 2 * list, count_from(slave->type->od, 0, list));
    m->length = HEADER + 2 + 2 * LIST_LAST;
}

/* One fragment of a list; the first repeats the list type in front of the indices. */
void coe_info_continue(struct slave *slave)
{
    const struct od *od = slave->type->od;
    struct coe *coe = &slave->mailbox.coe;
    unsigned room = (unsigned)(mailbox_room(slave) - HEADER) / 2;
    unsigned here = room - (coe->done == 0 ? 1u : 0u);
    unsigned remaining = count_from(od, coe->list_next, coe->list_type);
    unsigned left = remaining > here ? (remaining - here + room - 1) / room : 0;
    struct mailbox_message *m = answer(slave, LIST_RESPONSE, left);

    if (!m)
        return;
    if (coe->done == 0) {
        put_u16(m->body + m->length, coe->list_type);
        m->length = (uint16_t)(m->length + 2);
    }
    for (; here && coe->list_next < od->count; coe->list_next++) {
        const struct od_object *object = &od->objects[coe->list_next];

        if (!listed(object, coe->list_type))
            continue;
        put_u16(m->body + m->length, object->index);
        m->length = (uint16_t)(m->length + 2);
        here--;
    }
    coe->done++;
    coe->busy = left ? COE_INFO_LIST : COE_IDLE;
}

static void start_list(struct slave *slave, unsigned list)
{
    struct coe *coe = &slave->mailbox.coe;

    if (list > LIST_LAST) {
        answer_error(slave, SDO_UNSUPPORTED);
        return;
    }
    if (list == LIST_LENGTHS) {
        list_lengths(slave);
        return;
    }
    coe->list_type = (uint16_t)list;
    coe->list_next = 0;
    coe->done = 0;
    coe_info_continue(slave);
}

static void append_name(struct slave *slave, struct mailbox_message *m, const char *name)
{
    size_t length = strlen(name), room = mailbox_room(slave) - m->length;

    if (length > NAME_MAX)
        length = NAME_MAX;
    if (length > room)
        length = room;
    memcpy(m->body + m->length, name, length);
    m->length = (uint16_t)(m->length + length);
}

static void describe_object(struct slave *slave, uint16_t index)
{
    const struct od_object *object = od_find(slave->type->od, index);
    struct mailbox_message *m;

    if (!object) {
        answer_error(slave, SDO_NO_OBJECT);
        return;
    }
    m = answer_sized(slave, OBJECT_RESPONSE, 6);
    if (!m)
        return;
    put_u16(m->body + HEADER, index);
    put_u16(m->body + HEADER + 2, object->type);
    m->body[HEADER + 4] = od_max_subindex(object);
    m->body[HEADER + 5] = object->code;
    m->length = HEADER + 6;
    append_name(slave, m, object->name);
}

static void describe_entry(struct slave *slave, uint16_t index, uint8_t subindex)
{
    const struct od_object *object = od_find(slave->type->od, index);
    const struct od_entry *e = object ? od_entry(object, subindex) : NULL;
    struct mailbox_message *m;
    unsigned bits;

    if (!e) {
        answer_error(slave, object ? SDO_NO_SUBINDEX : SDO_NO_OBJECT);
        return;
    }
    m = answer_sized(slave, ENTRY_RESPONSE, 10);
    if (!m)
        return;
    bits = e->type == OD_STRING ? (unsigned)strlen(e->text) * 8 : od_type_bits(e->type);
    put_u16(m->body + HEADER, index);
    m->body[HEADER + 2] = subindex;
    m->body[HEADER + 3] = 0; /* no unit, default, minimum, maximum follow */
    put_u16(m->body + HEADER + 4, e->type);
    put_u16(m->body + HEADER + 6, bits);
    put_u16(m->body + HEADER + 8, e->access);
    m->length = HEADER + 10;
    append_name(slave, m, e->name);
}

enum mailbox_error coe_info_request(struct slave *slave, const uint8_t *body, size_t length)
{
    const uint8_t *arguments = body + 4;

    slave->mailbox.coe.busy = COE_IDLE;
    if (length < 6)
        return MAILBOX_TOO_SHORT;
    switch (body[0] & ~INCOMPLETE) {
    case LIST_REQUEST:
        start_list(slave, get_u16(arguments));
        break;
    case OBJECT_REQUEST:
        describe_object(slave, get_u16(arguments));
        break;
    case ENTRY_REQUEST:
        if (length < 7)
            return MAILBOX_TOO_SHORT;
        describe_entry(slave, get_u16(arguments), arguments[2]);
        break;
    default:
        answer_error(slave, SDO_UNSUPPORTED);
    }
    return MAILBOX_OK;
}
