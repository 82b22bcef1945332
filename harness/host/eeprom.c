/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * The EEPROM area of TGM_System (R22). What is stored lies in the host and comes from a file, which
 * the parent writes when something was saved.
 */
#include "host/host_parts.h"

#include <string.h>

#define EEPROM_NS 10000000 /* what loading or saving takes */
#define OLD_SIZE  512      /* MAIN.Size_EEPROM_Memory 0 */

_Static_assert(sizeof(((EEPROM *)0)->Data) == EVIDENCE_EEPROM, "size of the area");

static size_t size(const struct host *host)
{
    const uint32_t announced = host->system->Main.Size_EEPROM_Memory;
    if (announced == 0)
        return OLD_SIZE;
    return announced < EVIDENCE_EEPROM ? announced : EVIDENCE_EEPROM;
}

static int eeprom_open(struct host *host, char why[HOST_WHY])
{
    struct evidence_eeprom *stored = &host->evidence->eeprom;
    (void)why;
    if (host->config.eeprom == NULL)
        return 0;
    const size_t given = host->config.eeprom_size;
    stored->size = (uint32_t)(given < sizeof stored->data ? given : sizeof stored->data);
    memcpy(stored->data, host->config.eeprom, stored->size);
    return 0;
}

/* False when there is nothing that could be loaded. */
static bool load(struct host *host)
{
    const struct evidence_eeprom *stored = &host->evidence->eeprom;
    if (stored->size == 0)
        return false;
    memcpy(host->system->Eeprom.Data, stored->data, size(host));
    return true;
}

static bool save(struct host *host)
{
    struct evidence_eeprom *stored = &host->evidence->eeprom;
    const size_t count = size(host);
    memcpy(stored->data, host->system->Eeprom.Data, count);
    if (stored->size < count)
        stored->size = (uint32_t)count;
    stored->saved = true;
    return true;
}

static void finish(struct host *host, EEPROM_CONTROL *ctrl)
{
    const bool loading = host->eeprom_control == EEPROM_CONTROL_CONTROL_LOAD;
    const bool good = loading                                               ? load(host)
                      : host->eeprom_control == EEPROM_CONTROL_CONTROL_SAVE ? save(host)
                                                                            : false;
    console_log(host, TGM_LOG_MAIN, CONSOLE_EEPROM, good ? CONSOLE_INFO : CONSOLE_ERROR, "%s %s",
                loading ? "load" : "save", good ? "done" : "failed");
    host->eeprom_control = 0;
    ctrl->Status = good ? EEPROM_CONTROL_STATUS_READY : EEPROM_CONTROL_STATUS_ERROR;
    ctrl->Control = 0;
}

static void eeprom_cycle(struct host *host)
{
    EEPROM_CONTROL *ctrl = &host->system->Eeprom.ctrl;
    if (host->eeprom_control != 0) {
        if (host->now_ns >= host->eeprom_due_ns)
            finish(host, ctrl);
        return;
    }
    if (ctrl->Control == 0)
        return;
    host->eeprom_control = ctrl->Control;
    host->eeprom_due_ns = host->now_ns + EEPROM_NS;
    ctrl->Status = EEPROM_CONTROL_STATUS_BUSY;
}

const struct host_part host_eeprom = { .name = "eeprom",
                                       .open = eeprom_open,
                                       .cycle = eeprom_cycle };
