/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Which slave is behind a servo, and which map it shall have: known before there is a bus. */
#include <string.h>

#include "host/servo_wire.h"

#define CSP 8 /* cyclic synchronous position, 0x6060 */

/* Maps of the TGZ: what is assigned to 0x1C12 and 0x1C13. */
enum { RX_COE = 0x1701, TX_COE = 0x1B01, RX_NATIVE = 0x1721, TX_NATIVE = 0x1B21 };

/* Drives whose map can be chosen; both axes are in it even if there is only one. */
static const struct tgz {
    const char *type;
    unsigned axes;
    bool native; /* as it comes */
} tgz[] = {
    { "tgz-1", 1, false },
    { "tgz-2", 2, false },
    { "tgz-1-native", 1, true },
    { "tgz-2-native", 2, true },
};

static const struct tgz *tgz_of(const struct plant *plant, size_t slave)
{
    if (slave >= plant->device_count)
        return NULL;
    for (size_t i = 0; i < sizeof tgz / sizeof *tgz; i++)
        if (strcmp(tgz[i].type, plant->devices[slave].type) == 0)
            return &tgz[i];
    return NULL;
}

unsigned wire_tgz_axes(const struct plant *plant, size_t slave)
{
    const struct tgz *drive = tgz_of(plant, slave);
    return drive != NULL ? drive->axes : 0;
}

bool wire_is_internal(uint32_t type)
{
    return type == 91 || type == 92 || type == 94 || type == 95;
}

static bool is_drive(const char *type)
{
    return strncmp(type, "drive-", 6) == 0 || strncmp(type, "tgz-", 4) == 0;
}

size_t wire_slave(const struct plant *plant, const struct host_servo *servo)
{
    for (size_t i = 0; i < plant->device_count; i++)
        if (wire_is_internal(servo->type)
                ? is_drive(plant->devices[i].type)
                : servo->node != 0 && plant->devices[i].alias == servo->node)
            return i;
    if (wire_is_internal(servo->type) || servo->node == 0 || servo->node > plant->device_count)
        return NO_SLAVE;
    return servo->node - 1;
}

/* The map that the list of servos asks for; as it comes when it does not say. */
static bool is_native(const struct host_config *config, size_t slave, const struct tgz *drive)
{
    for (unsigned i = 0; config->servos != NULL && i < config->servo_count; i++) {
        const struct host_servo *servo = &config->servos[i];
        if (servo->type != 0 && wire_slave(config->plant, servo) == slave)
            return servo->type != 99;
    }
    return drive->native;
}

size_t wire_startup(const struct host_config *config, struct bus_startup *out, size_t room)
{
    size_t count = 0;
    for (size_t slave = 0; slave < config->plant->device_count; slave++) {
        const struct tgz *drive = tgz_of(config->plant, slave);
        if (drive == NULL || count + WIRE_STARTUP > room)
            continue;
        const bool native = is_native(config, slave, drive);
        const struct bus_startup rows[WIRE_STARTUP] = {
            { slave, 0x1C12, 0, 1, 0 },
            { slave, 0x1C12, 1, 2, native ? RX_NATIVE : RX_COE },
            { slave, 0x1C12, 0, 1, 1 },
            { slave, 0x1C13, 0, 1, 0 },
            { slave, 0x1C13, 1, 2, native ? TX_NATIVE : TX_COE },
            { slave, 0x1C13, 0, 1, 1 },
            /* The mode is in none of its maps. */
            { slave, 0x6060, 0, 1, CSP },
            { slave, 0x6860, 0, 1, CSP },
        };
        const size_t wanted = WIRE_STARTUP - (native ? 2 : drive->axes == 1 ? 1 : 0);
        memcpy(out + count, rows, wanted * sizeof *rows);
        count += wanted;
    }
    return count;
}
