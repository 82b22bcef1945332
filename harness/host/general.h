/* SPDX-License-Identifier: GPL-2.0-or-later */
/* general.h - what the host keeps of a GENERAL_DEVICE of generation 5. */
#ifndef HARNESS_HOST_GENERAL_H
#define HARNESS_HOST_GENERAL_H

#include "host/channel.h"

#define GENERAL_DEVICES  16
#define GENERAL_PDO_MAX  256 /* bytes of one direction */
#define GENERAL_SDO_MAX  128
#define GENERAL_DATA_MAX 256 /* bytes of the register block */

/* Where the mailboxes of a slave are, as its sync managers say. */
struct general_mailboxes {
    uint16_t out, out_size, in, in_size;
    bool known;
};

struct general {
    size_t slave;
    size_t output_bytes, input_bytes; /* of the slave's process data */
    uint8_t *outputs, *inputs;        /* their places in the process image */
    struct channel sdo, block;
    struct bus_job managers; /* reads the sync managers, once */
    struct general_mailboxes mailboxes;
};

#endif
