/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/wire.h"
#include "bus/faults.h"
#include "bus/pcap.h"

#include <string.h>

static void copy_extra(struct wire *wire, enum segment_port port, const uint8_t *frame,
                       size_t length)
{
    wire->extra.port = port;
    wire->extra.length = length;
    memcpy(wire->extra.bytes, frame, length);
}

/* The same frame a second time, right behind the first: the slaves have seen that one already. */
static void pass_again(struct wire *wire, uint64_t now_ns)
{
    struct wire_frame *extra = &wire->extra;

    wire->has_extra = segment_transfer(wire->segment, &extra->port, extra->bytes, extra->length,
                                       now_ns, &extra->back_ns);
}

static bool pass_disturbed(struct wire *wire, const struct fault_fate *fate,
                           enum segment_port *port, uint8_t *frame, size_t length, uint64_t now_ns,
                           uint64_t *back_ns)
{
    bool back;

    if (fate->lose)
        return false;
    if (fate->duplicate)
        copy_extra(wire, *port, frame, length);
    if (fate->damage)
        segment_damage_next(wire->segment, fate->damage_behind);
    back = segment_transfer(wire->segment, port, frame, length, now_ns, back_ns);
    *back_ns += fate->delay_ns;
    if (fate->duplicate) {
        pass_again(wire, now_ns);
        wire->extra.back_ns += fate->delay_ns;
    } else if (fate->duplicate_back && back) {
        copy_extra(wire, *port, frame, length);
        wire->extra.back_ns = *back_ns;
        wire->has_extra = true;
    }
    return back && !fate->lose_back;
}

static bool pass(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                 uint64_t now_ns, uint64_t *back_ns)
{
    struct fault_fate fate;
    uint64_t back = now_ns;
    bool returned;

    if (!wire->faults)
        return segment_transfer(wire->segment, port, frame, length, now_ns, back_ns);
    wire->has_extra = false;
    faults_advance(wire->faults, now_ns);
    if (!faults_frame(wire->faults, now_ns, &fate) || length > SEGMENT_FRAME_MAX)
        return segment_transfer(wire->segment, port, frame, length, now_ns, back_ns);
    returned = pass_disturbed(wire, &fate, port, frame, length, now_ns, &back);
    if (back_ns)
        *back_ns = back;
    return returned;
}

/* A frame that does not come back is seen once, one that comes back twice three times. */
static bool pass_captured(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                          uint64_t now_ns, uint64_t *back_ns)
{
    bool back;

    if (length > PCAP_FRAME_MAX)
        return false;
    pcap_frame(wire->capture, now_ns, frame, length);
    back = pass(wire, port, frame, length, now_ns, back_ns);
    if (back)
        pcap_frame_at(wire->capture, *back_ns, frame, length);
    if (wire->has_extra)
        pcap_frame_at(wire->capture, wire->extra.back_ns, wire->extra.bytes, wire->extra.length);
    return back;
}

bool wire_transfer(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                   uint64_t now_ns, uint64_t *back_ns)
{
    uint64_t back = now_ns;

    if (!wire->capture)
        return pass(wire, port, frame, length, now_ns, back_ns);
    return pass_captured(wire, port, frame, length, now_ns, back_ns ? back_ns : &back);
}

const struct wire_frame *wire_extra(struct wire *wire)
{
    bool has = wire->has_extra;

    wire->has_extra = false;
    return has ? &wire->extra : NULL;
}
