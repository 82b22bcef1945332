/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * terminal.h - the one engine behind all terminals: channels whose values travel in PDO entries of
 * any number of bits, with or without an object dictionary around them.
 *
 * A terminal type is data made once (description.h) and never changed afterwards; it holds its own
 * device type, SII content and dictionary. Every PDO entry has a cell in the instance, where SDOs
 * and process data meet.
 */
#ifndef HARNESS_BUS_TERMINAL_H
#define HARNESS_BUS_TERMINAL_H

#include "bus/device.h"

#define TERMINAL_NO_CELL 0u /* no value lies at offset 0 of an instance */

/* One entry of a PDO, in wire order. */
struct terminal_entry {
    uint32_t cell; /* offset in the instance; TERMINAL_NO_CELL: a gap */
    uint8_t bits, bytes;
};

struct terminal_pdo {
    uint16_t index;
    bool assigned; /* by default */
    const struct terminal_entry *entries;
    unsigned count;
};

/* Status bits of an analog input, as cells of PDO entries; TERMINAL_NO_CELL: has none. */
enum terminal_flag {
    TERMINAL_STATUS, /* one byte: bit 0 underrange, 1 overrange, 6 error */
    TERMINAL_UNDER,
    TERMINAL_OVER,
    TERMINAL_ERROR,
    TERMINAL_FLAGS
};

struct terminal_channel {
    uint32_t cell;
    uint8_t bytes;
    bool digital;
    int64_t least, most; /* an input saturates there */
    int64_t safe;        /* output: value while the terminal is not driven */
    uint32_t flag[TERMINAL_FLAGS];
};

struct terminal_range {
    uint16_t index;
    uint8_t subindex;
    int64_t least, most;
};

struct terminal_direction {
    const struct terminal_pdo *pdos;
    unsigned pdo_count, entry_count;
    uint16_t max_bytes; /* room in the sync manager's memory */
    uint16_t assign_index;
    uint32_t assign_count; /* cell of subindex 0; TERMINAL_NO_CELL: the assignment is fixed */
    uint32_t assign_pdos;  /* cells of the others, two bytes each */
    uint32_t moves;        /* struct terminal_move [entry_count] in the instance */
};

struct terminal_type {
    struct device_type type;
    struct sii_info sii;
    struct od od;
    struct terminal_direction direction[2]; /* by enum pdo_direction */
    const struct terminal_channel *inputs, *outputs;
    unsigned input_count, output_count;
    const struct terminal_range *ranges;
    unsigned range_count;
    uint32_t identity; /* cells of 0x1018:1 to :4, four bytes each; TERMINAL_NO_CELL: none */
    uint32_t held;     /* struct terminal_input [input_count] in the instance */
    uint32_t image;    /* the input image in the instance, direction[PDO_TX].max_bytes */
    bool hold;         /* outputs keep their values when the watchdog expires or OP is left */
};

struct terminal_move {
    uint32_t cell;
    uint16_t bit;
    uint8_t bits, bytes;
};

struct terminal_input {
    int64_t value; /* as the outside world has it, before saturation */
    bool held;     /* bus_set_input overrules the stimuli */
};

/* An instance; cells, moves, inputs and image follow at the offsets of the type. */
struct terminal {
    const struct terminal_type *type;
    struct bus_identity identity;
    uint32_t serial;
    uint64_t seed;
    const struct bus_stimulus *stimuli;
    size_t stimulus_count;
    uint64_t next_ns; /* earliest change of a stimulus */
    bool stale;       /* cells of the inputs, or the input image, are behind */
    uint16_t move_count[2];
    struct pdo_image mapped[2]; /* of which only `bits` is used */
};

/* Fills in the callbacks of type->type and type->od. */
void terminal_type_wire(struct terminal_type *type);
bool terminal_is(const struct device_type *type);
/* The input whose value begins in bit `bit` of the input image: its channel; -1: there is none. */
int terminal_input_at(const void *device, unsigned bit);

#endif
