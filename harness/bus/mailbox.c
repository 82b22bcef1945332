/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/slave_parts.h"

#include <string.h>

enum {
    SM_OUT = 0,
    SM_IN = 1,
    COUNTER_SHIFT = 4,
    COUNTER_MASK = 7,
    TYPE_MASK = 0x0f,
    SERVICE_EMERGENCY = 1
};

void mailbox_start(struct slave *slave)
{
    memset(&slave->mailbox, 0, sizeof slave->mailbox);
    slave->mailbox.active = true;
    /* What the master put there in INIT was never meant for anybody. */
    syncman_device_clear(slave, SM_OUT);
    syncman_device_clear(slave, SM_IN);
}

void mailbox_stop(struct slave *slave)
{
    slave->mailbox.active = false;
    slave->mailbox.request = false;
    slave->mailbox.stalled = false;
}

size_t mailbox_room(const struct slave *slave)
{
    size_t size = slave->type->sii->mailbox.in_size;

    return (size < MAILBOX_MAX ? size : MAILBOX_MAX) - MAILBOX_HEADER;
}

struct mailbox_message *mailbox_new(struct slave *slave, uint8_t type)
{
    struct mailbox *mbx = &slave->mailbox;
    struct mailbox_message *message;

    if (mbx->queued == MAILBOX_QUEUE)
        return NULL;
    message = &mbx->queue[(mbx->head + mbx->queued++) % MAILBOX_QUEUE];
    memset(message, 0, sizeof *message);
    message->type = type;
    return message;
}

static void invert(uint8_t *bytes, size_t count)
{
    while (count--)
        *bytes++ ^= 0xff;
}

/* A request is open from when it lies in SM0 until the last message of its answer, or of the
 * transfer it belongs to, is on its way. */
static void take_emergency(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;
    const struct emergency *e = &mbx->emergency[0];
    struct mailbox_message *m;

    if (!mbx->emergencies || mbx->queued || slave->sm[SM_OUT].full || mbx->coe.busy != COE_IDLE)
        return;
    m = mailbox_new(slave, MAILBOX_COE);
    put_u16(m->body, SERVICE_EMERGENCY << 12);
    put_u16(m->body + 2, e->code);
    m->body[4] = e->error_register;
    memcpy(m->body + 5, e->data, sizeof e->data);
    m->length = 10;
    mbx->emergencies--;
    memmove(mbx->emergency, mbx->emergency + 1, mbx->emergencies * sizeof *e);
}

void mailbox_emergency(struct slave *slave, uint16_t code, uint8_t error_register,
                       const uint8_t data[5])
{
    struct mailbox *mbx = &slave->mailbox;
    struct emergency *e = &mbx->emergency[mbx->emergencies];

    if (!mbx->active || mbx->emergencies == EMERGENCIES)
        return;
    *e = (struct emergency){ .code = code, .error_register = error_register };
    if (data)
        memcpy(e->data, data, sizeof e->data);
    mbx->emergencies++;
    mailbox_flush(slave);
}

void mailbox_flush(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;
    struct mailbox_message *message;

    if (mbx->parked || slave->sm[SM_IN].full)
        return;
    take_emergency(slave);
    if (!mbx->queued)
        return;
    message = &mbx->queue[mbx->head];
    mbx->counter = (uint8_t)(mbx->counter % COUNTER_MASK + 1);
    memset(mbx->sent, 0, MAILBOX_HEADER);
    put_u16(mbx->sent, message->length);
    mbx->sent[5] = (uint8_t)(message->type | mbx->counter << COUNTER_SHIFT);
    memcpy(mbx->sent + MAILBOX_HEADER, message->body, message->length);
    mbx->sent_length = (uint16_t)(MAILBOX_HEADER + message->length);
    if (slave->faults.mailbox_malformed)
        invert(mbx->sent + MAILBOX_HEADER, message->length);
    if (!syncman_device_put(slave, SM_IN, mbx->sent, mbx->sent_length))
        return;
    mbx->head = (uint8_t)((mbx->head + 1) % MAILBOX_QUEUE);
    mbx->queued--;
}

void mailbox_fetched(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;

    if (!mbx->active)
        return;
    if (!mbx->repeating) {
        memcpy(mbx->kept, mbx->sent, mbx->sent_length);
        mbx->kept_length = mbx->sent_length;
        mbx->kept_valid = true;
    }
    mbx->repeating = false;
    if (mbx->parked) {
        mbx->parked = false;
        syncman_device_put(slave, SM_IN, mbx->sent, mbx->sent_length);
        return;
    }
    if (!mbx->queued)
        coe_continue(slave);
    mailbox_flush(slave);
    if (mbx->stalled) {
        mbx->stalled = false;
        mailbox_request(slave);
    }
}

/* The master did not get the message it fetched last: it is put back. A newer one that already
 * stands in the box waits behind it. */
void mailbox_repeat(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;

    if (mbx->active && mbx->kept_valid && !mbx->repeating) {
        mbx->parked = slave->sm[SM_IN].full;
        mbx->repeating = true;
        syncman_device_clear(slave, SM_IN);
        syncman_device_put(slave, SM_IN, mbx->kept, mbx->kept_length);
    }
    syncman_repeat_done(slave);
}

void mailbox_request(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;

    if (!mbx->active)
        return;
    mbx->request = true;
    mbx->due_ns = slave->now_ns + SLAVE_MAILBOX_NS;
    if (mbx->due_ns < slave->due_ns)
        slave->due_ns = mbx->due_ns;
}

static void reply_error(struct slave *slave, enum mailbox_error detail)
{
    struct mailbox_message *message = mailbox_new(slave, MAILBOX_ERROR);

    if (!message)
        return;
    message->length = 4;
    put_u16(message->body, 0x0001);
    put_u16(message->body + 2, detail);
}

static enum mailbox_error handle(struct slave *slave, const uint8_t *data, size_t size)
{
    size_t length = get_u16(data);
    uint8_t type = data[5] & TYPE_MASK;

    if (length + MAILBOX_HEADER > size)
        return MAILBOX_SIZE;
    if (data[4] & 0x3f)
        return MAILBOX_CHANNEL;
    /* Errors are not answered, or two sides would never stop telling each other. */
    if (type == MAILBOX_ERROR)
        return MAILBOX_OK;
    if (type == MAILBOX_COE && slave->type->od)
        return coe_request(slave, data + MAILBOX_HEADER, length);
    return MAILBOX_PROTOCOL;
}

void mailbox_run(struct slave *slave)
{
    struct mailbox *mbx = &slave->mailbox;
    uint8_t data[MAILBOX_MAX];
    enum mailbox_error error;
    uint8_t counter;
    size_t size;

    mbx->request = false;
    /* No room for an answer: the request stays where it is, and the master sees SM0 full. */
    if (mbx->queued == MAILBOX_QUEUE) {
        mbx->stalled = true;
        return;
    }
    if (!syncman_device_take(slave, SM_OUT, data, sizeof data, &size))
        return;
    if (slave->faults.mailbox_silent)
        return;
    /* The same counter again is the same request again, sent because its acknowledge got lost. */
    counter = data[5] >> COUNTER_SHIFT & COUNTER_MASK;
    if (counter && counter == mbx->last_counter)
        return;
    mbx->last_counter = counter;
    error = handle(slave, data, size);
    if (error)
        reply_error(slave, error);
    mailbox_flush(slave);
}
