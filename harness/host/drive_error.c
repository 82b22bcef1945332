/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/drive_error.h"

#include <stddef.h>

/* A code belongs to the first row that it agrees with in the bits of the mask. */
static const struct row {
    uint16_t code, mask;
    uint32_t bit;
} rows[] = {
    { 0x7305, 0xFFFF, 0x00000001 }, /* incremental sensor 1 */
    { 0x7306, 0xFFFF, 0x00000002 }, /* incremental sensor 2 */
    { 0x7300, 0xFF00, 0x00000001 }, /* sensor */
    { 0x3120, 0xFFF0, 0x00000004 }, /* mains undervoltage */
    { 0x3220, 0xFFF0, 0x00000004 }, /* DC link undervoltage */
    { 0x3110, 0xFFF0, 0x00000008 }, /* mains overvoltage */
    { 0x3210, 0xFFF0, 0x00000008 }, /* DC link overvoltage */
    { 0x3130, 0xFFF0, 0x00000010 }, /* phase failure */
    { 0x7110, 0xFFFF, 0x00000020 }, /* brake chopper */
    { 0x7111, 0xFFFF, 0x00000020 }, { 0x7112, 0xFFFF, 0x00000020 }, { 0x7113, 0xFFFF, 0x00000020 },
    { 0x4300, 0xFF00, 0x00000040 }, /* temperature of the drive, which is the motor's */
    { 0x4000, 0xF000, 0x00000080 }, /* temperature of the device */
    { 0x7122, 0xFFFF, 0x00000100 }, /* motor error or commutation malfunction */
    { 0x5400, 0xFF00, 0x00040000 }, /* power section */
    { 0x5000, 0xF000, 0x00000200 }, /* device hardware */
    { 0x7500, 0xFF00, 0x00000400 }, /* communication */
    { 0x8100, 0xFF00, 0x00000400 }, { 0x8200, 0xFF00, 0x00000400 }, /* protocol */
    { 0x8700, 0xFF00, 0x00000400 },                                 /* synchronisation */
    { 0x2350, 0xFFF0, 0x00000800 },                                 /* load level, I2t */
    { 0x2310, 0xFFF0, 0x00001000 },                                 /* continuous over current */
    { 0x7120, 0xFFFE, 0x00002000 },                                 /* motor blocked */
    { 0x2130, 0xFFF0, 0x00004000 },                                 /* short circuit */
    { 0x2340, 0xFFF0, 0x00004000 }, { 0x3330, 0xFFF0, 0x00008000 }, /* field circuit interrupted */
    { 0x8611, 0xFFFF, 0x00010000 },                                 /* following error */
    { 0x8612, 0xFFFF, 0x00020000 },                                 /* reference limit */
    { 0x2300, 0xFF00, 0x00040000 },                                 /* current on the output side */
    { 0x6000, 0xF000, 0x00080000 },                                 /* device software */
};

uint32_t drive_error_bit(uint16_t code)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if ((code & rows[i].mask) == rows[i].code)
            return rows[i].bit;
    return DRIVE_ERROR_OTHER;
}
