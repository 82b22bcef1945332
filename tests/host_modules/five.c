/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A module as TGMcontroller and TGZ+Motion want it: without Program_05. It says hello. */
#include <tgm_plc.h>

long Program_Ini(PLC_DATA *pData)
{
#if TGM_GENERATION == 5
#ifdef TGM_TEXT8
    static const tgm_char hello[] = "hello, \xC5\x99\x65\xC5\xA5";
#else
    static const tgm_char hello[] = { 'h', 'e', 'l', 'l', 'o', 0 };
#endif
    pData->functions.pRtWprintf_String_Severity(0, hello);
#endif
    return pData != 0;
}

#define FIVE(name)                                                                                 \
    long name(PLC_DATA *pData)                                                                     \
    {                                                                                              \
        return pData != 0;                                                                         \
    }

FIVE(Program_01)
FIVE(Program_02)
FIVE(Program_03)
FIVE(Program_04)
