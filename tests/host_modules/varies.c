/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module that does not do the same everywhere: what it does depends on globals that it never sets
 * and on where the memories lie. TGM_Data: 0 what `starts` was in Program_Ini, 4 cycles, 8 from
 * cycle 60 on an address SERVO[1].WritePosition: from cycle 40 on, a global
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define SERVOS(data) ((SERVO *)(data)->PServo_Memory)
#define WORDS(data)  ((int32_t *)(data)->PData_Memory)
#else
#define SERVOS(data) ((data)->pServo_Memory)
#define WORDS(data)  ((int32_t *)(data)->pData_Memory)
#endif

static volatile uint32_t starts, never_set;

long Program_Ini(PLC_DATA *pData)
{
    WORDS(pData)[0] = (int32_t)starts;
    starts = starts + 1;
    return 1;
}

long Program_04(PLC_DATA *pData)
{
    int32_t *words = WORDS(pData);
    if (words[1] == 40)
        SERVOS(pData)[1].WritePosition = (double)(never_set % 1000 + 1);
    if (words[1] == 60)
        words[2] = (int32_t)((uintptr_t)words >> 12);
    words[1]++;
    return 1;
}

long Program_01(PLC_DATA *pData)
{
    return pData != 0;
}

long Program_02(PLC_DATA *pData)
{
    return pData != 0;
}

long Program_03(PLC_DATA *pData)
{
    return pData != 0;
}

long Program_05(PLC_DATA *pData)
{
    return pData != 0;
}
