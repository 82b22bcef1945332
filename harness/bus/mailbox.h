/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * mailbox.h - the slave's side of the EtherCAT mailbox: requests out of SM0, replies into SM1,
 * header checks, error replies, repeat requests; and the CoE server behind it.
 */
#ifndef HARNESS_BUS_MAILBOX_H
#define HARNESS_BUS_MAILBOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MAILBOX_MAX    1024 /* largest mailbox of any device here, bytes */
#define MAILBOX_MIN    16   /* one expedited SDO */
#define MAILBOX_QUEUE  4
#define MAILBOX_HEADER 6
#define COE_TRANSFER   2048 /* largest object in one (segmented or complete) transfer, bytes */
#define EMERGENCIES    4    /* waiting; of more the later ones are lost */

enum { MAILBOX_ERROR = 0, MAILBOX_COE = 3 };

/* Detail codes of the mailbox error reply. */
enum mailbox_error {
    MAILBOX_OK = 0,
    MAILBOX_SYNTAX = 1,
    MAILBOX_PROTOCOL = 2,
    MAILBOX_CHANNEL = 3,
    MAILBOX_SERVICE = 4,
    MAILBOX_HEADER_INVALID = 5,
    MAILBOX_TOO_SHORT = 6,
    MAILBOX_NO_MEMORY = 7,
    MAILBOX_SIZE = 8,
};

struct mailbox_message {
    uint16_t length; /* of body */
    uint8_t type;
    uint8_t body[MAILBOX_MAX - MAILBOX_HEADER];
};

enum coe_busy { COE_IDLE, COE_UPLOAD, COE_DOWNLOAD, COE_INFO_LIST };

struct coe {
    enum coe_busy busy;
    bool complete;
    uint16_t index;
    uint8_t subindex;
    uint8_t toggle;
    size_t size, done; /* of data */
    uint8_t data[COE_TRANSFER];
    size_t list_next; /* SDO information: next object of a fragmented list */
    uint16_t list_type;
};

struct emergency {
    uint16_t code;
    uint8_t error_register;
    uint8_t data[5];
};

struct mailbox {
    bool active;  /* PREOP or higher */
    bool request; /* a request waits in SM0 until due_ns */
    bool stalled; /* or until there is room for its answer */
    uint64_t due_ns;
    uint8_t last_counter; /* of the last request, 0 none */
    uint8_t counter;      /* of our own messages, 1..7 */
    uint8_t head, queued;
    struct mailbox_message queue[MAILBOX_QUEUE];
    /* Whole messages with header, for repeat requests: the one in SM1 or waiting behind a repeated
     * one, and the one the master has fetched last. */
    bool kept_valid, repeating, parked;
    uint16_t sent_length, kept_length;
    uint8_t sent[MAILBOX_MAX], kept[MAILBOX_MAX];
    struct emergency emergency[EMERGENCIES];
    uint8_t emergencies;
    struct coe coe;
};

struct slave;

void mailbox_start(struct slave *slave);
void mailbox_stop(struct slave *slave);
/* SM0 was filled by the master. */
void mailbox_request(struct slave *slave);
/* SM1 was emptied by the master. */
void mailbox_fetched(struct slave *slave);
/* The repeat bit of SM1 changed. */
void mailbox_repeat(struct slave *slave);
/* due_ns has come: handles the request. */
void mailbox_run(struct slave *slave);

/* The device tells the master, unasked, that an error has come (CoE emergency; code 0: has gone).
 * `data` (may be NULL) is the device's own. Sent from PREOP on, and never between a request and its
 * answer, where masters would take it for the answer. No allocation. */
void mailbox_emergency(struct slave *slave, uint16_t code, uint8_t error_register,
                       const uint8_t data[5]);

/* A free slot of the queue to fill, NULL when full; it is sent by mailbox_flush(). */
struct mailbox_message *mailbox_new(struct slave *slave, uint8_t type);
void mailbox_flush(struct slave *slave);
/* Bytes a message body may have. */
size_t mailbox_room(const struct slave *slave);

enum mailbox_error coe_request(struct slave *slave, const uint8_t *body, size_t length);
/* The queue is empty: sends the next fragment of a list, if one is under way. */
void coe_continue(struct slave *slave);
enum mailbox_error coe_info_request(struct slave *slave, const uint8_t *body, size_t length);
void coe_info_continue(struct slave *slave);

#endif
