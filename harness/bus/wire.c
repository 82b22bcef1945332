/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/wire.h"

bool wire_transfer(struct wire *wire, enum segment_port *port, uint8_t *frame, size_t length,
                   uint64_t now_ns, uint64_t *back_ns)
{
    return segment_transfer(wire->segment, port, frame, length, now_ns, back_ns);
}
