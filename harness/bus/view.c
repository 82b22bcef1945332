/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "bus/view.h"
#include "bus/bytes.h"
#include "bus/slave.h"

#include <string.h>

#include "osal.h"
#include "oshw.h"
#include "ethercattype.h"
#include "ethercatmain.h"
#include "ethercatprint.h"

enum { POSITION_ACTUAL = 0x6064, AXIS_DISTANCE = 0x800 };

static const char *state_text(unsigned status)
{
    static const char *const names[16][2] = {
        [AL_INIT] = { "INIT", "INIT+ERR" }, [AL_PREOP] = { "PREOP", "PREOP+ERR" },
        [AL_BOOT] = { "BOOT", "BOOT+ERR" }, [AL_SAFEOP] = { "SAFEOP", "SAFEOP+ERR" },
        [AL_OP] = { "OP", "OP+ERR" },
    };
    const char *name = names[status & AL_STATE & 0xf][status & AL_ERROR ? 1 : 0];

    return name ? name : "no state";
}

static void take_axes(const struct slave *slave, struct view *view)
{
    const struct od *od = slave->type->od;
    uint16_t index = POSITION_ACTUAL;

    if (od->refresh)
        od->refresh(slave->device);
    for (; od_find(od, index); index = (uint16_t)(index + AXIS_DISTANCE)) {
        uint8_t data[4] = { 0 };
        size_t size = sizeof data;

        if (view->axes < VIEW_AXES &&
            od_read(od, slave->device, slave->state, index, 0, data, &size) == SDO_OK)
            view->position[view->axes] = (int32_t)get_u32(data);
        view->axes++;
    }
}

static void take_inputs(const struct slave *slave, struct view *view)
{
    size_t length = slave->input_sm < 0 ? 0 : slave->sm[slave->input_sm].length;

    if (!length || length > VIEW_BYTES || !slave->type->inputs)
        return;
    view->input_bytes = length;
    slave->type->inputs(slave->device, view->input, length);
}

static void take_pins(const struct slave *slave, struct view *view)
{
    size_t length = slave->output_sm < 0 ? 0 : slave->sm[slave->output_sm].length;

    put_u32(view->pins, slave->type->pins(slave->device));
    view->pin_bytes = length < sizeof view->pins ? length : sizeof view->pins;
}

void view_take(const struct slave *slave, struct view *view)
{
    const uint8_t *m = slave->memory;

    memset(view, 0, sizeof *view);
    view->name = slave->type->sii->name;
    view->station = get_u16(m + REG_STATION_ADDRESS);
    view->al_state = get_u16(m + REG_AL_STATUS) & (AL_STATE | AL_ERROR);
    view->al_code = get_u16(m + REG_AL_STATUS_CODE);
    view->state = state_text(view->al_state);
    view->code = view->al_code ? ec_ALstatuscode2string(view->al_code) : "";
    if (slave->type->od)
        take_axes(slave, view);
    if (!view->axes)
        take_inputs(slave, view);
    if (slave->type->pins)
        take_pins(slave, view);
}
