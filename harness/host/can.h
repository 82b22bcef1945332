/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * can.h - the CAN buses that a PLC may use, and what stands on their other end (R9).
 *
 * The other end is a script, a statement a line, # begins a comment:
 *
 *   baud 500                                speed in kbit/s, 500 unless said
 *   loopback                                what the PLC sends, it receives
 *   channel 2                               what follows is about CAN 2
 *   at 10ms send 0x123 01 02 03             once; times count from the first cycle
 *   every 5ms send 0x124 AA                 first after one period
 *   every 5ms from 2ms send 0x124 AA
 *   on 0x200 reply 0x201 01 02              to a telegram of the PLC
 *   on 0x200 remote after 2ms reply 0x201   to a remote telegram, some time later
 *
 * Identifiers have 11 bits, data up to eight bytes in hexadecimal. A telegram takes its time on the
 * bus: 47 bits and 8 more for each byte, without stuff bits. The bus is free whenever the other end
 * wants to send.
 */
#ifndef HARNESS_HOST_CAN_H
#define HARNESS_HOST_CAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CAN_CHANNELS 2
#define CAN_RULES    64
#define CAN_PENDING  128
#define CAN_WHY      256
#define CAN_IDS      2048

struct can_frame {
    uint32_t id;
    bool remote;
    uint8_t length;
    uint8_t data[8];
};

enum can_rule_kind { CAN_ONCE, CAN_EVERY, CAN_REPLY };

struct can_rule {
    enum can_rule_kind kind;
    unsigned channel;   /* from 0 */
    uint64_t next_ns;   /* once, every; UINT64_MAX: no more */
    uint64_t period_ns; /* every; reply: how much later */
    uint32_t on_id;     /* reply */
    bool on_remote;
    struct can_frame frame;
};

/* A telegram that will have gone over the bus at that time. */
struct can_pending {
    uint64_t at_ns, order; /* equal times: as they were made */
    unsigned channel;
    struct can_frame frame;
};

struct can {
    struct can_rule rules[CAN_RULES];
    size_t rule_count;
    bool loopback[CAN_CHANNELS];
    uint32_t kbit[CAN_CHANNELS];
    unsigned buffer; /* telegrams that wait or are being sent, at most; a channel each */

    struct can_pending pending[CAN_PENDING];
    size_t pending_count;
    uint64_t order, lost;               /* lost: had no room in `pending` */
    uint64_t sent_ns[CAN_CHANNELS][64]; /* when those in the transmit buffer will be gone */
    unsigned waiting[CAN_CHANNELS];
};

/* Reads a script. 0, or -EINVAL with "name:line: what is wrong". */
int can_open(struct can *can, const char *script, const char *name, unsigned buffer,
             char why[CAN_WHY]);

/* The PLC sends. False: channel, identifier or length that there is not, or the buffer is full. */
bool can_transmit(struct can *can, unsigned channel, const struct can_frame *frame,
                  uint64_t now_ns);

/* The next telegram that the PLC has received up to now, in the order of their times. False: no
 * more. */
bool can_receive(struct can *can, uint64_t now_ns, unsigned *channel, struct can_frame *frame);

/* Telegrams of the PLC that are not gone yet. */
unsigned can_waiting(struct can *can, unsigned channel, uint64_t now_ns);

#endif
