/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The object dictionary of the TGZ and its fixed PDO maps. */
#include "bus/drive_rows.h"
#include "bus/tgz.h"

#define TGZ(field) ((uint32_t)offsetof(struct tgz_device, field))
/* A register of the axis whose rows are being written: groups of registers come in pairs. */
#define REG(field)       TGZ(reg[AXIS_NUMBER].field)
#define REGISTER(index_) ((index_) + 0x100 * AXIS_NUMBER)

/* One value of each axis. */
#define BOTH(index_, type_, access_, field_, name_)                                                \
    PAIR_AT(index_, type_, access_, TGZ(reg[0].field_), TGZ(reg[1].field_), 0, 0, name_, "axis 1", \
            "axis 2")

#define METHOD(n_, method_)                                                                        \
    {                                                                                              \
        n_, n_, OD_I8, OD_RO, OD_CONST, method_, "method", NULL                                    \
    }
static const struct od_entry homing_rows[] = {
    COUNT(10),     METHOD(1, 1),  METHOD(2, 2),  METHOD(3, 3),  METHOD(4, 5),   METHOD(5, 17),
    METHOD(6, 18), METHOD(7, 19), METHOD(8, 21), METHOD(9, 35), METHOD(10, 37),
};

static const struct od_object objects[] = {
    OBJECT(0x1000, OD_U32, OD_RO, OD_CONST, 0x00020192, "device type"),
    OBJECT(0x1001, OD_U8, OD_RO, AT(error_register), 0, "error register"),
    HISTORY(DRIVE_HISTORY),
    IDENTITY,
    MAP(0x1701, rx[0], OD_RO),
    MAP(0x1702, rx[1], OD_RO),
    MAP(0x1703, rx[2], OD_RO),
    MAP(0x1721, rx[3], OD_RO),
    MAP(0x1b01, tx[0], OD_RO),
    MAP(0x1b21, tx[1], OD_RO),
    MANAGERS,
    ASSIGN(0x1c12, PDO_RX),
    ASSIGN(0x1c13, PDO_TX),
    OBJECT(0x200d, OD_U32, OD_RO, TGZ(node_id), 0, "C-ID"),
    OBJECT(0x200e, OD_U32, OD_RO, TGZ(sync_us), 0, "C-SyncTime"),
    OBJECT(0x2010, OD_U32, OD_RW, TGZ(cycle_us), 1000, "C-SetCycleTime"),
#define AXIS_NUMBER 0
#include "bus/tgz_motor.def"
#undef AXIS_NUMBER
#define AXIS_NUMBER 1
#include "bus/tgz_motor.def"
#undef AXIS_NUMBER
#define AXIS_NUMBER 0
#include "bus/tgz_drive.def"
#undef AXIS_NUMBER
#define AXIS_NUMBER 1
#include "bus/tgz_drive.def"
#undef AXIS_NUMBER
    OBJECT(0x310d, OD_U32, OD_RW, TGZ(reg[0].guard_reset), 0, "ResetGuarding"),
    OBJECT(0x320d, OD_U32, OD_RW, TGZ(reg[1].guard_reset), 0, "ResetGuarding"),
#define AXIS_NUMBER 0
#include "bus/tgz_monitor.def"
#undef AXIS_NUMBER
    OBJECT(0x3330, OD_U32, OD_RO, TGZ(shown_inputs), 0, "inputs"),
    OBJECT(0x333c, OD_U32, OD_RO, TGZ(shown_outputs), 0, "outputs"),
    OBJECT(0x333e, OD_I32, OD_RO | OD_TX_MAP, TGZ(external), 0, "external encoder"),
    OBJECT(0x3340, OD_U32, OD_RO, TGZ(packet_us), 0, "C-PackeTime"),
#define AXIS_NUMBER 1
#include "bus/tgz_monitor.def"
#undef AXIS_NUMBER
    OBJECT(0x4000, OD_U8, OD_RO, TGZ(inputs), 0, "inputs"),
    OBJECT(0x4001, OD_U8, OD_RO, TGZ(outputs), 0, "outputs"),
    BOTH(0x4002, OD_U16, OD_RO | OD_TX_MAP, analog, "analog inputs"),
    BOTH(0x4003, OD_U16, OD_RO | OD_TX_MAP, status_low, "drive status"),
    BOTH(0x4010, OD_I16, OD_RO | OD_RX_MAP, set_current, "set point current"),
    BOTH(0x4011, OD_U16, OD_RO | OD_RX_MAP, current_limit, "current limit"),
    BOTH(0x4012, OD_I16, OD_RO | OD_TX_MAP, current, "Iq"),
#define AXIS_NUMBER 0
#include "bus/tgz_profile.def"
#undef AXIS_NUMBER
#define AXIS_NUMBER 1
#include "bus/tgz_profile.def"
#undef AXIS_NUMBER
};

#define ON(index_, axis_) ((index_) + 0x800 * (axis_))
#define WORDS(n)                                                                                   \
    { ON(0x6040, n), 0, OD_U16, 16 }, { ON(0x6071, n), 0, OD_I16, 16 },                            \
        { 0x4011, (n) + 1, OD_U16, 16 }, GAP(16)
#define POSITION(n)                                                                                \
    {                                                                                              \
        ON(0x607a, n), 0, OD_I32, 32                                                               \
    }
#define VELOCITY(n)                                                                                \
    {                                                                                              \
        ON(0x60ff, n), 0, OD_I32, 32                                                               \
    }
#define OUTPUTS                                                                                    \
    {                                                                                              \
        0x60fe, 1, OD_U32, 32                                                                      \
    }
#define NATIVE(n)                                                                                  \
    { 0x332b + 0x100 * (n), 0, OD_U32, 32 }, { 0x332c + 0x100 * (n), 0, OD_I32, 32 },              \
        { 0x332d + 0x100 * (n), 0, OD_U32, 32 }, { 0x4010, (n) + 1, OD_I16, 16 },                  \
    {                                                                                              \
        0x4011, (n) + 1, OD_U16, 16                                                                \
    }

#define RX_PDOS(coe_sm, native_sm)                                                                 \
    { TGZ_RX_CSP, coe_sm, 0x10,                                                                    \
      ENTRIES(POSITION(0), VELOCITY(0), OUTPUTS, WORDS(0), POSITION(1), VELOCITY(1), GAP(32),      \
              WORDS(1)) },                                                                         \
        { TGZ_RX_CSV, 0xff, 0x10,                                                                  \
          ENTRIES(GAP(32), VELOCITY(0), OUTPUTS, WORDS(0), GAP(32), VELOCITY(1), GAP(32),          \
                  WORDS(1)) },                                                                     \
        { TGZ_RX_CST, 0xff, 0x10,                                                                  \
          ENTRIES(GAP(32), GAP(32), OUTPUTS, WORDS(0), GAP(32), GAP(32), GAP(32), WORDS(1)) },     \
    {                                                                                              \
        TGZ_RX_NATIVE, native_sm, 0x10, ENTRIES(NATIVE(0), NATIVE(1), GAP(32), GAP(32), GAP(32))   \
    }

#define VALUES(n)                                                                                  \
    { ON(0x6041, n), 0, OD_U16, 16 }, { ON(0x6077, n), 0, OD_I16, 16 },                            \
        { 0x4002, (n) + 1, OD_U16, 16 },                                                           \
    {                                                                                              \
        0x4003, (n) + 1, OD_U16, 16                                                                \
    }
#define ACTUAL(n)                                                                                  \
    { ON(0x6064, n), 0, OD_I32, 32 },                                                              \
    {                                                                                              \
        ON(0x606c, n), 0, OD_I32, 32                                                               \
    }
/* The two registers that the drive can be told to show at the end of 0x1b21 are not modelled. */
#define TX_PDOS(coe_sm, native_sm)                                                                 \
    { TGZ_TX_COE, coe_sm, 0x10,                                                                    \
      ENTRIES(ACTUAL(0), { 0x60fd, 0, OD_U32, 32 }, VALUES(0), ACTUAL(1),                          \
              { 0x333e, 0, OD_I32, 32 }, VALUES(1)) },                                             \
    {                                                                                              \
        TGZ_TX_NATIVE, native_sm, 0x10,                                                            \
            ENTRIES(                                                                               \
                { 0x3310, 0, OD_U32, 32 }, { 0x3311, 0, OD_I32, 32 }, { 0x3410, 0, OD_U32, 32 },   \
                { 0x3411, 0, OD_I32, 32 }, { 0x333e, 0, OD_I32, 32 }, { 0x3325, 0, OD_U32, 32 },   \
                { 0x3425, 0, OD_U32, 32 }, { 0x4002, 1, OD_U16, 16 }, { 0x4002, 2, OD_U16, 16 },   \
                { 0x4012, 1, OD_I16, 16 }, { 0x4012, 2, OD_I16, 16 }, GAP(32), GAP(32))            \
    }

const struct sii_pdo tgz_rx_coe[TGZ_RX_MAPS] = { RX_PDOS(2, 0xff) };
const struct sii_pdo tgz_rx_native[TGZ_RX_MAPS] = { RX_PDOS(0xff, 2) };
const struct sii_pdo tgz_tx_coe[TGZ_TX_MAPS] = { TX_PDOS(3, 0xff) };
const struct sii_pdo tgz_tx_native[TGZ_TX_MAPS] = { TX_PDOS(0xff, 3) };

static const uint16_t rx_indices[] = { TGZ_RX_CSP, TGZ_RX_CSV, TGZ_RX_CST, TGZ_RX_NATIVE };
static const uint16_t tx_indices[] = { TGZ_TX_COE, TGZ_TX_NATIVE };

const struct od tgz_od = {
    .objects = objects,
    .count = sizeof objects / sizeof *objects,
    .pdo = {
        [PDO_RX] = { .assign_index = 0x1c12,
                     .map_list = rx_indices,
                     .map_count = TGZ_RX_MAPS,
                     .assign_offset = AT(assign[PDO_RX]),
                     .map_offset = AT(rx),
                     .image_offset = AT(image[PDO_RX]),
                     .max_bytes = TGZ_NATIVE_BYTES,
                     .mappable = OD_RX_MAP },
        [PDO_TX] = { .assign_index = 0x1c13,
                     .map_list = tx_indices,
                     .map_count = TGZ_TX_MAPS,
                     .assign_offset = AT(assign[PDO_TX]),
                     .map_offset = AT(tx),
                     .image_offset = AT(image[PDO_TX]),
                     .max_bytes = TGZ_NATIVE_BYTES,
                     .mappable = OD_TX_MAP },
    },
    .check = tgz_check,
    .refresh = tgz_refresh,
    .written = tgz_written,
};
