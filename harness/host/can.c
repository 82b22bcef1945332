/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/can.h"

#include <string.h>

#define BUFFER_MAX (sizeof((struct can *)0)->sent_ns[0] / sizeof(uint64_t))

static uint64_t frame_ns(const struct can *can, unsigned channel, const struct can_frame *frame)
{
    const uint64_t bits = 47u + (frame->remote ? 0u : 8u * frame->length);
    return bits * 1000000 / can->kbit[channel];
}

static void add_pending(struct can *can, unsigned channel, const struct can_frame *frame,
                        uint64_t at_ns)
{
    if (can->pending_count == CAN_PENDING) {
        can->lost++;
        return;
    }
    can->pending[can->pending_count++] = (struct can_pending){
        .at_ns = at_ns, .order = can->order++, .channel = channel, .frame = *frame
    };
}

unsigned can_waiting(struct can *can, unsigned channel, uint64_t now_ns)
{
    unsigned left = 0;
    for (unsigned i = 0; i < can->waiting[channel]; i++)
        if (can->sent_ns[channel][i] > now_ns)
            can->sent_ns[channel][left++] = can->sent_ns[channel][i];
    can->waiting[channel] = left;
    return left;
}

/* Telegrams leave one after the other. */
static uint64_t buffer(struct can *can, unsigned channel, const struct can_frame *frame,
                       uint64_t now_ns)
{
    const unsigned waiting = can->waiting[channel];
    const uint64_t begin = waiting > 0 ? can->sent_ns[channel][waiting - 1] : now_ns;
    const uint64_t end = begin + frame_ns(can, channel, frame);
    can->sent_ns[channel][can->waiting[channel]++] = end;
    return end;
}

bool can_transmit(struct can *can, unsigned channel, const struct can_frame *frame, uint64_t now_ns)
{
    if (channel >= CAN_CHANNELS || frame->id >= CAN_IDS || frame->length > sizeof frame->data)
        return false;
    const unsigned waiting = can_waiting(can, channel, now_ns);
    if (waiting >= can->buffer || waiting >= BUFFER_MAX)
        return false;
    const uint64_t sent = buffer(can, channel, frame, now_ns);
    if (can->loopback[channel] && !frame->remote)
        add_pending(can, channel, frame, sent);
    for (size_t i = 0; i < can->rule_count; i++) {
        const struct can_rule *rule = &can->rules[i];
        if (rule->kind == CAN_REPLY && rule->channel == channel && rule->on_id == frame->id &&
            rule->on_remote == frame->remote)
            add_pending(can, channel, &rule->frame,
                        sent + rule->period_ns + frame_ns(can, channel, &rule->frame));
    }
    return true;
}

/* What the script sends by itself, up to now. */
static void let_rules_send(struct can *can, uint64_t now_ns)
{
    for (size_t i = 0; i < can->rule_count; i++) {
        struct can_rule *rule = &can->rules[i];
        while (rule->kind != CAN_REPLY && rule->next_ns <= now_ns &&
               can->pending_count < CAN_PENDING) {
            add_pending(can, rule->channel, &rule->frame,
                        rule->next_ns + frame_ns(can, rule->channel, &rule->frame));
            rule->next_ns = rule->kind == CAN_EVERY ? rule->next_ns + rule->period_ns : UINT64_MAX;
        }
    }
}

static bool before(const struct can_pending *a, const struct can_pending *b)
{
    return a->at_ns != b->at_ns ? a->at_ns < b->at_ns : a->order < b->order;
}

bool can_receive(struct can *can, uint64_t now_ns, unsigned *channel, struct can_frame *frame)
{
    const struct can_pending *first = NULL;
    let_rules_send(can, now_ns);
    for (size_t i = 0; i < can->pending_count; i++)
        if (first == NULL || before(&can->pending[i], first))
            first = &can->pending[i];
    if (first == NULL || first->at_ns > now_ns)
        return false;
    *channel = first->channel;
    *frame = first->frame;
    can->pending[first - can->pending] = can->pending[--can->pending_count];
    return true;
}
