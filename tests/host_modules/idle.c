/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A module that starts and then does nothing: what moves is TG Motion. */
#include <tgm_plc.h>

long Program_Ini(PLC_DATA *pData)
{
    return pData != 0;
}

#define IDLE(name)                                                                                 \
    long name(PLC_DATA *pData)                                                                     \
    {                                                                                              \
        return pData != 0;                                                                         \
    }

IDLE(Program_01)
IDLE(Program_02)
IDLE(Program_03)
IDLE(Program_04)
IDLE(Program_05)
