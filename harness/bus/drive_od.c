/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The drive's object dictionary, its default PDOs, and what may be written. */
#include "bus/drive.h"
#include "bus/identity.h"

#include <string.h>

#define AT(field)   ((uint32_t)offsetof(struct drive_device, field))
#define AXIS(field) AT(axis.o.field)

#define ROWS(rows) (sizeof(rows) / sizeof *(rows)), (rows)

/* One-entry objects and the rows of the others. */
#define VAR(type_, access_, offset_, initial_, name_)                                              \
    (const struct od_entry[])                                                                      \
    {                                                                                              \
        {                                                                                          \
            0, 0, type_, access_, offset_, initial_, name_, NULL                                   \
        }                                                                                          \
    }
#define OBJECT(index_, type_, access_, offset_, initial_, name_)                                   \
    {                                                                                              \
        index_, OD_VAR, type_, 1, VAR(type_, access_, offset_, initial_, name_), name_             \
    }
#define TEXT(index_, text_, name_)                                                                 \
    {                                                                                              \
        index_, OD_VAR, OD_STRING, 1,                                                              \
            (const struct od_entry[]){ { 0, 0, OD_STRING, OD_RO, 0, 0, name_, text_ } }, name_     \
    }
#define COUNT(n)                                                                                   \
    {                                                                                              \
        0, 0, OD_U8, OD_RO, OD_CONST, n, "number of entries", NULL                                 \
    }
#define PAIR(index_, type_, access_, offset_, one_, two_, name_, name1_, name2_)                   \
    {                                                                                              \
        index_, OD_RECORD, type_, 3,                                                               \
            (const struct od_entry[]){                                                             \
                COUNT(2),                                                                          \
                { 1, 1, type_, access_, offset_, one_, name1_, NULL },                             \
                { 2, 2, type_, access_, (offset_) + sizeof(uint32_t), two_, name2_, NULL },        \
            },                                                                                     \
            name_                                                                                  \
    }
#define MAP(index_, map_)                                                                          \
    {                                                                                              \
        index_, OD_RECORD, OD_PDO_MAPPING, 2,                                                      \
            (const struct od_entry[]){                                                             \
                { 0, 0, OD_U8, OD_RW_PREOP, AT(map_.count), 0, "number of entries", NULL },        \
                { 1, PDO_MAX_ENTRIES, OD_U32, OD_RW_PREOP, AT(map_.entry), 0, "entry", NULL },     \
            },                                                                                     \
            "PDO mapping"                                                                          \
    }
#define ASSIGN(index_, n_)                                                                         \
    {                                                                                              \
        index_, OD_ARRAY, OD_U16, 2,                                                               \
            (const struct od_entry[]){                                                             \
                { 0, 0, OD_U8, OD_RW_PREOP, AT(assign[n_].count), 0, "number of PDOs", NULL },     \
                { 1, PDO_MAX_ASSIGN, OD_U16, OD_RW_PREOP, AT(assign[n_].pdo), 0, "PDO", NULL },    \
            },                                                                                     \
            "PDO assignment"                                                                       \
    }

static const struct od_entry identity_rows[] = {
    COUNT(4),
    { 1, 1, OD_U32, OD_RO, OD_CONST, BUS_VENDOR, "vendor id", NULL },
    { 2, 2, OD_U32, OD_RO, OD_CONST, BUS_PRODUCT_DRIVE, "product code", NULL },
    { 3, 3, OD_U32, OD_RO, OD_CONST, BUS_REVISION, "revision", NULL },
    { 4, 4, OD_U32, OD_RO, AT(serial), 0, "serial number", NULL },
};

static const struct od_entry manager_rows[] = {
    COUNT(4),
    { 1, 1, OD_U8, OD_RO, OD_CONST, SII_SM_MBX_OUT, "SM0", NULL },
    { 2, 2, OD_U8, OD_RO, OD_CONST, SII_SM_MBX_IN, "SM1", NULL },
    { 3, 3, OD_U8, OD_RO, OD_CONST, SII_SM_OUTPUTS, "SM2", NULL },
    { 4, 4, OD_U8, OD_RO, OD_CONST, SII_SM_INPUTS, "SM3", NULL },
};

static const struct od_entry period_rows[] = {
    COUNT(2),
    { 1, 1, OD_U8, OD_RW, AXIS(period_value), 1, "value", NULL },
    { 2, 2, OD_I8, OD_RW, AXIS(period_exponent), -3, "exponent", NULL },
};

static const struct od_object objects[] = {
    OBJECT(0x1000, OD_U32, OD_RO, OD_CONST, 0x00020192, "device type"),
    OBJECT(0x1001, OD_U8, OD_RO, AT(error_register), 0, "error register"),
    TEXT(0x1008, DRIVE_NAME, "device name"),
    TEXT(0x1009, DRIVE_HARDWARE, "hardware version"),
    TEXT(0x100a, "1", "software version"),
    { 0x1018, OD_RECORD, OD_IDENTITY, ROWS(identity_rows), "identity" },
    MAP(0x1600, rx[0]),
    MAP(0x1601, rx[1]),
    MAP(0x1602, rx[2]),
    MAP(0x1603, rx[3]),
    MAP(0x1a00, tx[0]),
    MAP(0x1a01, tx[1]),
    { 0x1c00, OD_ARRAY, OD_U8, ROWS(manager_rows), "sync manager type" },
    ASSIGN(0x1c12, PDO_RX),
    ASSIGN(0x1c13, PDO_TX),
    OBJECT(0x603f, OD_U16, OD_RO | OD_TX_MAP, AXIS(error_code), 0, "error code"),
    OBJECT(0x6040, OD_U16, OD_RW | OD_RX_MAP, AXIS(controlword), 0, "controlword"),
    OBJECT(0x6041, OD_U16, OD_RO | OD_TX_MAP, AXIS(statusword), 0, "statusword"),
    OBJECT(0x605a, OD_I16, OD_RW, AXIS(options.quick_stop), 2, "quick stop option"),
    OBJECT(0x605b, OD_I16, OD_RW, AXIS(options.shutdown), 0, "shutdown option"),
    OBJECT(0x605c, OD_I16, OD_RW, AXIS(options.disable), 1, "disable operation option"),
    OBJECT(0x605e, OD_I16, OD_RW, AXIS(options.fault_reaction), 2, "fault reaction option"),
    OBJECT(0x6060, OD_I8, OD_RW | OD_RX_MAP, AXIS(mode), DRIVE_CSP, "mode of operation"),
    OBJECT(0x6061, OD_I8, OD_RO | OD_TX_MAP, AXIS(mode_display), 0, "mode of operation display"),
    OBJECT(0x6062, OD_I32, OD_RO | OD_TX_MAP, AXIS(position_demand), 0, "position demand"),
    OBJECT(0x6064, OD_I32, OD_RO | OD_TX_MAP, AXIS(position_actual), 0, "position actual"),
    OBJECT(0x6065, OD_U32, OD_RW, AXIS(following_window), 262144, "following error window"),
    OBJECT(0x6066, OD_U16, OD_RW, AXIS(following_time), 10, "following error time-out"),
    OBJECT(0x6067, OD_U32, OD_RW, AXIS(position_window), 512, "position window"),
    OBJECT(0x606b, OD_I32, OD_RO | OD_TX_MAP, AXIS(velocity_demand), 0, "velocity demand"),
    OBJECT(0x606c, OD_I32, OD_RO | OD_TX_MAP, AXIS(velocity_actual), 0, "velocity actual"),
    OBJECT(0x6071, OD_I16, OD_RW | OD_RX_MAP, AXIS(target_torque), 0, "target torque"),
    OBJECT(0x6072, OD_U16, OD_RW | OD_RX_MAP, AXIS(max_torque), 3000, "maximum torque"),
    OBJECT(0x6077, OD_I16, OD_RO | OD_TX_MAP, AXIS(torque_actual), 0, "torque actual"),
    OBJECT(0x607a, OD_I32, OD_RW | OD_RX_MAP, AXIS(target_position), 0, "target position"),
    OBJECT(0x607c, OD_I32, OD_RW, AXIS(home_offset), 0, "home offset"),
    OBJECT(0x6081, OD_U32, OD_RW | OD_RX_MAP, AXIS(profile_velocity), 5 << 20, "profile velocity"),
    OBJECT(0x6083, OD_U32, OD_RW | OD_RX_MAP, AXIS(acceleration), 50 << 20, "profile acceleration"),
    OBJECT(0x6084, OD_U32, OD_RW | OD_RX_MAP, AXIS(deceleration), 50 << 20, "profile deceleration"),
    OBJECT(0x6085, OD_U32, OD_RW, AXIS(quick_deceleration), 400 << 20, "quick stop deceleration"),
    PAIR(0x608f, OD_U32, OD_RO, AXIS(encoder), 1 << 20, 1, "encoder resolution", "increments",
         "motor revolutions"),
    OBJECT(0x6098, OD_I8, OD_RW, AXIS(homing_method), 21, "homing method"),
    PAIR(0x6099, OD_U32, OD_RW, AXIS(homing_speed), 2 << 20, 1 << 17, "homing speeds",
         "to the switch", "to its edge"),
    OBJECT(0x609a, OD_U32, OD_RW, AXIS(homing_acceleration), 50 << 20, "homing acceleration"),
    { 0x60c2, OD_RECORD, OD_U8, ROWS(period_rows), "interpolation time period" },
    OBJECT(0x60f4, OD_I32, OD_RO | OD_TX_MAP, AXIS(following_error), 0, "following error"),
    OBJECT(0x60fd, OD_U32, OD_RO | OD_TX_MAP, AXIS(digital_inputs), 0, "digital inputs"),
    OBJECT(0x60ff, OD_I32, OD_RW | OD_RX_MAP, AXIS(target_velocity), 0, "target velocity"),
    OBJECT(0x6502, OD_U32, OD_RO, OD_CONST,
           1 << (DRIVE_PP - 1) | 1 << (DRIVE_PV - 1) | 1 << (DRIVE_HM - 1) | 1 << (DRIVE_CSP - 1) |
               1 << (DRIVE_CSV - 1) | 1 << (DRIVE_CST - 1),
           "supported drive modes"),
};

/* Default mappings. The first of each direction is assigned. */
#define COMMAND                                                                                    \
    { 0x6040, 0, OD_U16, 16 }, { 0x6060, 0, OD_I8, 8 },                                            \
    {                                                                                              \
        0, 0, 0, 8                                                                                 \
    }
#define ENTRIES(...)                                                                               \
    .entries = (const struct sii_entry[]){ __VA_ARGS__ },                                          \
    .entry_count = sizeof((const struct sii_entry[]){ __VA_ARGS__ }) / sizeof(struct sii_entry)

const struct sii_pdo drive_rx_pdos[DRIVE_RX_MAPS] = {
    { 0x1600, 2, 0x02, ENTRIES(COMMAND, { 0x607a, 0, OD_I32, 32 }) },
    { 0x1601, 0xff, 0, ENTRIES(COMMAND, { 0x60ff, 0, OD_I32, 32 }) },
    { 0x1602, 0xff, 0, ENTRIES(COMMAND, { 0x6071, 0, OD_I16, 16 }) },
    { 0x1603, 0xff, 0,
      ENTRIES(COMMAND, { 0x607a, 0, OD_I32, 32 }, { 0x60ff, 0, OD_I32, 32 },
              { 0x6071, 0, OD_I16, 16 }) },
};

const struct sii_pdo drive_tx_pdos[DRIVE_TX_MAPS] = {
    { 0x1a00, 3, 0x02,
      ENTRIES({ 0x6041, 0, OD_U16, 16 }, { 0x6061, 0, OD_I8, 8 }, { 0, 0, 0, 8 },
              { 0x6064, 0, OD_I32, 32 }, { 0x606c, 0, OD_I32, 32 }, { 0x60f4, 0, OD_I32, 32 },
              { 0x60fd, 0, OD_U32, 32 }) },
    { 0x1a01, 0xff, 0, ENTRIES({ 0x603f, 0, OD_U16, 16 }, { 0x6077, 0, OD_I16, 16 }) },
};

static void load(struct pdo_map *map, const struct sii_pdo *pdo)
{
    map->count = pdo->entry_count;
    for (unsigned i = 0; i < pdo->entry_count; i++)
        map->entry[i] = (uint32_t)pdo->entries[i].index << 16 |
                        (uint32_t)pdo->entries[i].subindex << 8 | pdo->entries[i].bits;
}

void drive_od_defaults(struct drive_device *device)
{
    for (unsigned i = 0; i < DRIVE_RX_MAPS; i++)
        load(&device->rx[i], &drive_rx_pdos[i]);
    for (unsigned i = 0; i < DRIVE_TX_MAPS; i++)
        load(&device->tx[i], &drive_tx_pdos[i]);
    device->assign[PDO_RX] = (struct pdo_assign){ 1, { 0x1600 } };
    device->assign[PDO_TX] = (struct pdo_assign){ 1, { 0x1a00 } };
}

/* Ranges beyond the type. */
static const struct range {
    uint16_t index;
    uint8_t subindex;
    int64_t low, high;
} ranges[] = {
    { 0x605b, 0, 0, 1 },          { 0x605c, 0, 0, 1 },          { 0x605e, 0, 0, 2 },
    { 0x6072, 0, 0, 3000 },       { 0x6083, 0, 1, UINT32_MAX }, { 0x6084, 0, 1, UINT32_MAX },
    { 0x6085, 0, 1, UINT32_MAX }, { 0x609a, 0, 1, UINT32_MAX }, { 0x60c2, 1, 1, 255 },
    { 0x60c2, 2, -6, -2 },
};

static bool quick_stop_option(int64_t value)
{
    return (value >= 0 && value <= 2) || value == 5 || value == 6;
}

uint32_t drive_check(void *device, uint16_t index, uint8_t subindex, int64_t value)
{
    (void)device;
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        const struct range *r = &ranges[i];

        if (r->index == index && r->subindex == subindex && (value < r->low || value > r->high))
            return SDO_RANGE;
    }
    if (index == 0x605a && !quick_stop_option(value))
        return SDO_RANGE;
    if (index == 0x6060 && value && !drive_mode_supported((int)value))
        return SDO_RANGE;
    if (index == 0x6098 && !drive_homing_supported((int)value))
        return SDO_RANGE;
    return SDO_OK;
}

const struct od drive_od = {
    .objects = objects,
    .count = sizeof objects / sizeof *objects,
    .pdo = {
        [PDO_RX] = { .assign_index = 0x1c12,
                     .map_first = 0x1600,
                     .map_count = DRIVE_RX_MAPS,
                     .assign_offset = AT(assign[PDO_RX]),
                     .map_offset = AT(rx),
                     .image_offset = AT(image[PDO_RX]),
                     .max_bytes = DRIVE_IMAGE_MAX,
                     .mappable = OD_RX_MAP },
        [PDO_TX] = { .assign_index = 0x1c13,
                     .map_first = 0x1a00,
                     .map_count = DRIVE_TX_MAPS,
                     .assign_offset = AT(assign[PDO_TX]),
                     .map_offset = AT(tx),
                     .image_offset = AT(image[PDO_TX]),
                     .max_bytes = DRIVE_IMAGE_MAX,
                     .mappable = OD_TX_MAP },
    },
    .check = drive_check,
    .refresh = drive_refresh,
    .written = drive_written,
};
