/* SPDX-License-Identifier: GPL-2.0-or-later */
/* drive_rows.h - object dictionary rows over struct drive_device, for the dictionaries of drives.
 */
#ifndef HARNESS_BUS_DRIVE_ROWS_H
#define HARNESS_BUS_DRIVE_ROWS_H

#include "bus/drive_device.h"

#define AT(field) ((uint32_t)offsetof(struct drive_device, field))
/* A field of struct drive_objects, of the axis whose rows are being written. */
#define AXIS(field) AT(axis[AXIS_NUMBER].o.field)
/* Profile objects of axis n stand 0x800 * n behind those of the first. */
#define ON_AXIS(index_) ((index_) + 0x800 * AXIS_NUMBER)

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
/* Two values of one 32-bit type, side by side. */
#define PAIR(index_, type_, access_, offset_, one_, two_, name_, name1_, name2_)                   \
    PAIR_AT(index_, type_, access_, offset_, (offset_) + sizeof(uint32_t), one_, two_, name_,      \
            name1_, name2_)
#define PAIR_AT(index_, type_, access_, offset1_, offset2_, one_, two_, name_, name1_, name2_)     \
    {                                                                                              \
        index_, OD_RECORD, type_, 3,                                                               \
            (const struct od_entry[]){                                                             \
                COUNT(2),                                                                          \
                { 1, 1, type_, access_, offset1_, one_, name1_, NULL },                            \
                { 2, 2, type_, access_, offset2_, two_, name2_, NULL },                            \
            },                                                                                     \
            name_                                                                                  \
    }
#define PERIOD(index_)                                                                             \
    {                                                                                              \
        index_, OD_RECORD, OD_U8, 3,                                                               \
            (const struct od_entry[]){                                                             \
                COUNT(2),                                                                          \
                { 1, 1, OD_U8, OD_RW, AXIS(period_value), 1, "value", NULL },                      \
                { 2, 2, OD_I8, OD_RW, AXIS(period_exponent), -3, "exponent", NULL },               \
            },                                                                                     \
            "interpolation time period"                                                            \
    }
#define HISTORY(depth_)                                                                            \
    {                                                                                              \
        0x1003, OD_ARRAY, OD_U32, 2,                                                               \
            (const struct od_entry[]){                                                             \
                { 0, 0, OD_U8, OD_RW, AT(history_count), 0, "number of errors", NULL },            \
                { 1, depth_, OD_U32, OD_RO, AT(history), 0, "error", NULL },                       \
            },                                                                                     \
            "error history"                                                                        \
    }
#define IDENTITY                                                                                   \
    {                                                                                              \
        0x1018, OD_RECORD, OD_IDENTITY, 5,                                                         \
            (const struct od_entry[]){                                                             \
                COUNT(4),                                                                          \
                { 1, 1, OD_U32, OD_RO, AT(identity[0]), 0, "vendor id", NULL },                    \
                { 2, 2, OD_U32, OD_RO, AT(identity[1]), 0, "product code", NULL },                 \
                { 3, 3, OD_U32, OD_RO, AT(identity[2]), 0, "revision", NULL },                     \
                { 4, 4, OD_U32, OD_RO, AT(identity[3]), 0, "serial number", NULL },                \
            },                                                                                     \
            "identity"                                                                             \
    }
#define MANAGERS                                                                                   \
    {                                                                                              \
        0x1c00, OD_ARRAY, OD_U8, 5,                                                                \
            (const struct od_entry[]){                                                             \
                COUNT(4),                                                                          \
                { 1, 1, OD_U8, OD_RO, OD_CONST, SII_SM_MBX_OUT, "SM0", NULL },                     \
                { 2, 2, OD_U8, OD_RO, OD_CONST, SII_SM_MBX_IN, "SM1", NULL },                      \
                { 3, 3, OD_U8, OD_RO, OD_CONST, SII_SM_OUTPUTS, "SM2", NULL },                     \
                { 4, 4, OD_U8, OD_RO, OD_CONST, SII_SM_INPUTS, "SM3", NULL },                      \
            },                                                                                     \
            "sync manager type"                                                                    \
    }
#define MAP(index_, map_, access_)                                                                 \
    {                                                                                              \
        index_, OD_RECORD, OD_PDO_MAPPING, 2,                                                      \
            (const struct od_entry[]){                                                             \
                { 0, 0, OD_U8, access_, AT(map_.count), 0, "number of entries", NULL },            \
                { 1, PDO_MAX_ENTRIES, OD_U32, access_, AT(map_.entry), 0, "entry", NULL },         \
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

/* Entries of a struct sii_pdo. */
#define ENTRIES(...)                                                                               \
    .entries = (const struct sii_entry[]){ __VA_ARGS__ },                                          \
    .entry_count = sizeof((const struct sii_entry[]){ __VA_ARGS__ }) / sizeof(struct sii_entry)
#define GAP(bits_)                                                                                 \
    {                                                                                              \
        0, 0, 0, bits_                                                                             \
    }

#endif
