/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module that sends CAN telegrams and looks at what comes: TGM_Data has
 *   0 result of the telegram 0x200 in the first cycle, 4 that of the next at once,
 *   8 NewData of 0x201, 12 its length, 16 its first byte, 20 result of the identifier 0x800
 */
#include <tgm_plc.h>

struct entry {
    uint8_t data[8];
    uint32_t length, fresh;
};

#if TGM_GENERATION == 4
#define WORDS(data)    ((int32_t *)(data)->PData_Memory)
#define RECEIVED(data) ((const struct entry *)(data)->PReciveDataCan1)
#else
#define WORDS(data)    ((int32_t *)(data)->pData_Memory)
#define RECEIVED(data) ((const struct entry *)(const void *)(data)->pReciveDataCan1)
#endif

long Program_Ini(PLC_DATA *pData)
{
    return pData != 0;
}

long Program_04(PLC_DATA *pData)
{
    const struct entry *received = RECEIVED(pData);
    int32_t *words = WORDS(pData);
    uint8_t bytes[8] = { 1, 2, 3, 4, 5, 6, 7, 8 };
    if (words[6]++ == 0) {
        words[0] = pData->functions.pCAN_Transmit(1, 0x200, 8, bytes);
        words[1] = pData->functions.pCAN_Transmit(1, 0x300, 8, bytes);
        words[5] = pData->functions.pCAN_Transmit(1, 0x800, 0, bytes);
    }
    if (received == 0)
        return 1;
    words[2] = (int32_t)received[0x201].fresh;
    words[3] = (int32_t)received[0x201].length;
    words[4] = received[0x201].data[0];
    return 1;
}

#define IDLE(name)                                                                                 \
    long name(PLC_DATA *pData)                                                                     \
    {                                                                                              \
        return pData != 0;                                                                         \
    }

IDLE(Program_01)
IDLE(Program_02)
IDLE(Program_03)
IDLE(Program_05)
