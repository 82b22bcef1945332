/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The object dictionaries of the generic drives, with one and two axes, and their default PDOs. */
#include "bus/drive_rows.h"

#define COMMUNICATION(name_)                                                                       \
    OBJECT(0x1000, OD_U32, OD_RO, OD_CONST, 0x00020192, "device type"),                            \
        OBJECT(0x1001, OD_U8, OD_RO, AT(error_register), 0, "error register"), HISTORY(8),         \
        TEXT(0x1008, name_, "device name"), TEXT(0x1009, DRIVE_HARDWARE, "hardware version"),      \
        TEXT(0x100a, "1", "software version"), IDENTITY

#define RX_MAPS(index_, first_)                                                                    \
    MAP(index_, rx[first_], OD_RW_PREOP), MAP((index_) + 1, rx[(first_) + 1], OD_RW_PREOP),        \
        MAP((index_) + 2, rx[(first_) + 2], OD_RW_PREOP),                                          \
        MAP((index_) + 3, rx[(first_) + 3], OD_RW_PREOP)
#define TX_MAPS(index_, first_)                                                                    \
    MAP(index_, tx[first_], OD_RW_PREOP), MAP((index_) + 1, tx[(first_) + 1], OD_RW_PREOP)

#define LIMIT_REACTION(index_, axis_)                                                              \
    OBJECT(index_, OD_U8, OD_RW, AT(axis[axis_].o.limit_reaction), 0, "limit switch reaction")

static const struct od_object one_axis[] = {
    COMMUNICATION(DRIVE_NAME), RX_MAPS(0x1600, 0),     TX_MAPS(0x1a00, 0),        MANAGERS,
    ASSIGN(0x1c12, PDO_RX),    ASSIGN(0x1c13, PDO_TX), LIMIT_REACTION(0x2001, 0),
#define AXIS_NUMBER 0
#include "bus/drive_axis.def"
#undef AXIS_NUMBER
};

static const struct od_object two_axes[] = {
    COMMUNICATION(DRIVE_NAME_X2), RX_MAPS(0x1600, 0),     RX_MAPS(0x1610, 4),
    TX_MAPS(0x1a00, 0),           TX_MAPS(0x1a10, 2),     MANAGERS,
    ASSIGN(0x1c12, PDO_RX),       ASSIGN(0x1c13, PDO_TX), LIMIT_REACTION(0x2001, 0),
    LIMIT_REACTION(0x2801, 1),
#define AXIS_NUMBER 0
#include "bus/drive_axis.def"
#undef AXIS_NUMBER
#define AXIS_NUMBER 1
#include "bus/drive_axis.def"
#undef AXIS_NUMBER
};

/* Default mappings. The first of each axis and direction is assigned. */
#define ON(index_, axis_) ((index_) + 0x800 * (axis_))
#define COMMAND(n)        { ON(0x6040, n), 0, OD_U16, 16 }, { ON(0x6060, n), 0, OD_I8, 8 }, GAP(8)
#define RX_PDOS(index_, n)                                                                         \
    { index_, 2, 0x02, ENTRIES(COMMAND(n), { ON(0x607a, n), 0, OD_I32, 32 }) },                    \
        { (index_) + 1, 0xff, 0, ENTRIES(COMMAND(n), { ON(0x60ff, n), 0, OD_I32, 32 }) },          \
        { (index_) + 2, 0xff, 0, ENTRIES(COMMAND(n), { ON(0x6071, n), 0, OD_I16, 16 }) },          \
    {                                                                                              \
        (index_) + 3, 0xff, 0,                                                                     \
            ENTRIES(COMMAND(n), { ON(0x607a, n), 0, OD_I32, 32 },                                  \
                    { ON(0x60ff, n), 0, OD_I32, 32 }, { ON(0x6071, n), 0, OD_I16, 16 })            \
    }
#define TX_PDOS(index_, n)                                                                         \
    { index_, 3, 0x02,                                                                             \
      ENTRIES({ ON(0x6041, n), 0, OD_U16, 16 }, { ON(0x6061, n), 0, OD_I8, 8 }, GAP(8),            \
              { ON(0x6064, n), 0, OD_I32, 32 }, { ON(0x606c, n), 0, OD_I32, 32 },                  \
              { ON(0x60f4, n), 0, OD_I32, 32 }, { ON(0x60fd, n), 0, OD_U32, 32 }) },               \
    {                                                                                              \
        (index_) + 1, 0xff, 0,                                                                     \
            ENTRIES({ ON(0x603f, n), 0, OD_U16, 16 }, { ON(0x6077, n), 0, OD_I16, 16 })            \
    }

const struct sii_pdo drive_rx_pdos[DRIVE_RX_MAPS] = { RX_PDOS(0x1600, 0), RX_PDOS(0x1610, 1) };
const struct sii_pdo drive_tx_pdos[DRIVE_TX_MAPS] = { TX_PDOS(0x1a00, 0), TX_PDOS(0x1a10, 1) };

static const uint16_t rx_indices[] = { 0x1600, 0x1601, 0x1602, 0x1603,
                                       0x1610, 0x1611, 0x1612, 0x1613 };
static const uint16_t tx_indices[] = { 0x1a00, 0x1a01, 0x1a10, 0x1a11 };

#define DICTIONARY(objects_, axes_)                                                                  \
    {                                                                                                \
        .objects = objects_,                                                                       \
        .count = sizeof objects_ / sizeof *objects_,                                               \
        .pdo = {                                                                                   \
            [PDO_RX] = { .assign_index = 0x1c12,                                                   \
                         .map_list = rx_indices,                                                   \
                         .map_count = DRIVE_RX_MAPS / DRIVE_AXES * (axes_),                        \
                         .assign_offset = AT(assign[PDO_RX]),                                      \
                         .map_offset = AT(rx),                                                     \
                         .image_offset = AT(image[PDO_RX]),                                        \
                         .max_bytes = DRIVE_IMAGE_MAX,                                             \
                         .mappable = OD_RX_MAP },                                                  \
            [PDO_TX] = { .assign_index = 0x1c13,                                                   \
                         .map_list = tx_indices,                                                   \
                         .map_count = DRIVE_TX_MAPS / DRIVE_AXES * (axes_),                        \
                         .assign_offset = AT(assign[PDO_TX]),                                      \
                         .map_offset = AT(tx),                                                     \
                         .image_offset = AT(image[PDO_TX]),                                        \
                         .max_bytes = DRIVE_IMAGE_MAX,                                             \
                         .mappable = OD_TX_MAP },                                                  \
        },                                                                                         \
        .check = drive_device_check,                                                               \
        .refresh = drive_device_refresh,                                                           \
        .written = drive_device_written, \
    }

const struct od drive_od = DICTIONARY(one_axis, 1);
const struct od drive_od_x2 = DICTIONARY(two_axes, 2);
