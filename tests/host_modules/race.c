/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module with a race: Program_01 writes 64 bits in halves, Program_04 reads them whole. The
 * halves are equal, so that a torn value shows.
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define DATA_OF(pData) ((pData)->PData_Memory)
#else
#define DATA_OF(pData) ((pData)->pData_Memory)
#endif

/* At offset 0 of TGM_Data. */
struct race {
    volatile uint32_t low, high;
    uint32_t torn, read;
    uint32_t higher; /* calls of Program_02 and Program_03 */
};

static uint32_t turn;

long Program_Ini(PLC_DATA *pData)
{
    turn = 0;
    return pData != 0;
}

long Program_01(PLC_DATA *pData)
{
    struct race *race = DATA_OF(pData);

    turn++;
    race->low = turn;
    race->high = turn;
    return 1;
}

long Program_02(PLC_DATA *pData)
{
    ((struct race *)DATA_OF(pData))->higher++;
    return 1;
}

long Program_03(PLC_DATA *pData)
{
    ((struct race *)DATA_OF(pData))->higher++;
    return 1;
}

long Program_04(PLC_DATA *pData)
{
    struct race *race = DATA_OF(pData);

    race->read++;
    race->torn += race->low != race->high;
    return 1;
}

long Program_05(PLC_DATA *pData)
{
    return pData != 0;
}
