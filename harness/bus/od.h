/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * od.h - object dictionaries as const tables over the fields of a device instance, and the PDO
 * assignment and mapping that live in them.
 */
#ifndef HARNESS_BUS_OD_H
#define HARNESS_BUS_OD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum od_type {
    OD_BOOL = 0x01,
    OD_I8 = 0x02,
    OD_I16 = 0x03,
    OD_I32 = 0x04,
    OD_U8 = 0x05,
    OD_U16 = 0x06,
    OD_U32 = 0x07,
    OD_REAL32 = 0x08,
    OD_STRING = 0x09,
    OD_REAL64 = 0x11,
    OD_I64 = 0x15,
    OD_U64 = 0x1b,
    OD_PDO_MAPPING = 0x21, /* of objects only */
    OD_IDENTITY = 0x23,    /* of objects only */
    OD_BIT1 = 0x30,        /* and so on up to OD_BIT8 */
    OD_BIT8 = 0x37,
};

enum od_code { OD_VAR = 7, OD_ARRAY = 8, OD_RECORD = 9 };

/* Access word of the SDO information service. */
enum {
    OD_RD_PREOP = 0x01,
    OD_RD_SAFEOP = 0x02,
    OD_RD_OP = 0x04,
    OD_WR_PREOP = 0x08,
    OD_WR_SAFEOP = 0x10,
    OD_WR_OP = 0x20,
    OD_RX_MAP = 0x40,
    OD_TX_MAP = 0x80,

    OD_RO = OD_RD_PREOP | OD_RD_SAFEOP | OD_RD_OP,
    OD_RW = OD_RO | OD_WR_PREOP | OD_WR_SAFEOP | OD_WR_OP,
    OD_RW_PREOP = OD_RO | OD_WR_PREOP,
};

/* SDO abort codes in use. */
enum od_abort {
    SDO_OK = 0,
    SDO_TOGGLE = 0x05030000,
    SDO_COMMAND = 0x05040001,
    SDO_MEMORY = 0x05040005,
    SDO_UNSUPPORTED = 0x06010000,
    SDO_WRITE_ONLY = 0x06010001,
    SDO_READ_ONLY = 0x06010002,
    SDO_SUB0_NOT_ZERO = 0x06010003,
    SDO_NO_COMPLETE_ACCESS = 0x06010004,
    SDO_MAILBOX_LENGTH = 0x06010005,
    SDO_NO_OBJECT = 0x06020000,
    SDO_NOT_MAPPABLE = 0x06040041,
    SDO_PDO_LENGTH = 0x06040042,
    SDO_LENGTH = 0x06070010,
    SDO_TOO_LONG = 0x06070012,
    SDO_TOO_SHORT = 0x06070013,
    SDO_NO_SUBINDEX = 0x06090011,
    SDO_RANGE = 0x06090030,
    SDO_DEVICE_STATE = 0x08000022,
};
#define SDO_GENERAL 0x08000000u

#define OD_CONST UINT32_MAX

/* One row: subindices first..last of one type, values side by side from `offset` in the device
 * instance. With offset OD_CONST the value is `initial` for good. Strings take their text from the
 * row and are read-only. */
struct od_entry {
    uint8_t first, last;
    uint8_t type; /* enum od_type */
    uint16_t access;
    uint32_t offset;
    int64_t initial;
    const char *name;
    const char *text; /* OD_STRING */
};

struct od_object {
    uint16_t index;
    uint8_t code; /* enum od_code */
    uint8_t type; /* data type shown for the object */
    uint8_t count;
    const struct od_entry *entries;
    const char *name;
};

/* PDO assignment and mapping of one direction, in the device instance. */
#define PDO_MAX_ASSIGN  4
#define PDO_MAX_ENTRIES 16
#define PDO_MAX_COPIES  (PDO_MAX_ASSIGN * PDO_MAX_ENTRIES)

struct pdo_map {
    uint8_t count;
    uint32_t entry[PDO_MAX_ENTRIES]; /* index << 16 | subindex << 8 | bits */
};

struct pdo_assign {
    uint8_t count;
    uint16_t pdo[PDO_MAX_ASSIGN];
};

/* A mapping resolved into moves between instance and process image, sorted by size. */
struct pdo_image {
    uint16_t bits;
    uint8_t count;
    uint8_t fours, twos; /* moves up to the last of four and of two bytes */
    struct pdo_copy {
        uint16_t image, object; /* byte offsets */
        uint8_t bytes;
    } copy[PDO_MAX_COPIES];
};

enum pdo_direction { PDO_RX, PDO_TX }; /* outputs, inputs */

/* Where the PDO objects of a device live. All zero but for `resolve` and `image_offset` when the
 * device resolves its mapping itself. */
struct od_pdo {
    uint16_t assign_index;    /* 0x1C12 or 0x1C13 */
    uint16_t map_first;       /* index of maps[0]; the others follow */
    const uint16_t *map_list; /* instead: the indices of all; NULL: map_first */
    uint8_t map_count;
    uint32_t assign_offset; /* struct pdo_assign */
    uint32_t map_offset;    /* struct pdo_map [map_count] */
    uint32_t image_offset;  /* struct pdo_image */
    uint16_t max_bytes;     /* room in the sync manager's memory */
    uint16_t mappable;      /* OD_RX_MAP or OD_TX_MAP */
    /* Resolves in place of pdo_resolve(), for mappings that are not made of bytes; fills `bits` of
     * the image. NULL: pdo_resolve() does it. */
    uint16_t (*resolve)(void *device, enum pdo_direction direction);
};

struct od {
    const struct od_object *objects; /* ascending index */
    size_t count;
    struct od_pdo pdo[2];
    /* Beyond type and access: may this value be written? SDO_OK or an abort code. May be NULL. */
    uint32_t (*check)(void *device, uint16_t index, uint8_t subindex, int64_t value);
    /* Values are about to be read by SDO: brings them up to date. May be NULL. */
    void (*refresh)(void *device);
    /* The value has been written by SDO. May be NULL. */
    void (*written)(void *device, uint16_t index, uint8_t subindex);
};

const struct od_object *od_find(const struct od *od, uint16_t index);
const struct od_entry *od_entry(const struct od_object *object, uint8_t subindex);
uint8_t od_max_subindex(const struct od_object *object);
unsigned od_type_bits(uint8_t type);  /* as mapped; 0 for strings */
unsigned od_type_bytes(uint8_t type); /* in an SDO and in the instance; 0 for strings */
bool od_type_signed(uint8_t type);
/* Values in the instance, 1, 2, 4 or 8 bytes in the host's order. */
uint64_t od_load(const uint8_t *at, unsigned bytes);
void od_store(uint8_t *at, unsigned bytes, uint64_t value);

/* Loads every `initial`. */
void od_reset(const struct od *od, void *device);

/* Reads or writes one entry as it travels in an SDO. `state` is the AL state. *size: room in, bytes
 * out. */
uint32_t od_read(const struct od *od, void *device, unsigned state, uint16_t index,
                 uint8_t subindex, uint8_t *data, size_t *size);
uint32_t od_write(const struct od *od, void *device, unsigned state, uint16_t index,
                  uint8_t subindex, const uint8_t *data, size_t size);

/* Resolves assignment and mapping into the image. 0, or the AL status code of the refusal: mapped
 * objects missing, not byte aligned, or more than the sync manager holds. */
uint16_t pdo_resolve(const struct od *od, void *device, enum pdo_direction direction);
const struct pdo_image *pdo_image(const struct od *od, const void *device,
                                  enum pdo_direction direction);
void pdo_outputs_to_objects(const struct od *od, void *device, const uint8_t *data);
void pdo_objects_to_inputs(const struct od *od, const void *device, uint8_t *data);
/* Write rules of the PDO objects themselves; SDO_OK for other objects. */
uint32_t pdo_check(const struct od *od, void *device, uint16_t index, uint8_t subindex,
                   int64_t value);

#endif
