/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/wire.h"
#include "bus/pcap.h"

/* A frame that does not come back is seen once. */
static bool transfer_captured(struct wire *wire, enum segment_port *port, uint8_t *frame,
                              size_t length, uint64_t now_ns, uint64_t *back_ns)
{
    if (length > PCAP_FRAME_MAX)
        return false;
    pcap_frame(wire->capture, now_ns, frame, length);
    if (!segment_transfer(wire->segment, port, frame, length, now_ns, back_ns))
        return false;
    pcap_frame_at(wire->capture, *back_ns, frame, length);
    return true;
}

bool wire_transfer(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                   uint64_t now_ns, uint64_t *back_ns)
{
    uint64_t back;

    if (wire->capture)
        return transfer_captured(wire, port, frame, length, now_ns, back_ns ? back_ns : &back);
    return segment_transfer(wire->segment, port, frame, length, now_ns, back_ns);
}
