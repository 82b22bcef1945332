/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module that reads and writes objects of the first drive by SERVO.Sdo, as the manual has it:
 * parameters, then Control, then wait for Control 0. What came of it goes to TGM_Data:
 *   0 steps done, 4 what 0x608F:1 was, 8 Status of reading what is not there, 12 its code,
 *   16 what 0x6083 was after 12345 had been written to it
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define SERVOS(data) ((SERVO *)(data)->PServo_Memory)
#define WORDS(data)  ((int32_t *)(data)->PData_Memory)
#else
#define SERVOS(data) ((data)->pServo_Memory)
#define WORDS(data)  ((int32_t *)(data)->pData_Memory)
#endif

static void ask(volatile SDO *sdo, uint32_t control, uint32_t index, uint32_t subindex,
                int32_t value)
{
    sdo->NumberByte = 4;
    sdo->Index = index;
    sdo->SubIndex = subindex;
    sdo->Data = value;
    sdo->Control = control;
}

long Program_Ini(PLC_DATA *pData)
{
    return pData != 0;
}

long Program_04(PLC_DATA *pData)
{
    volatile SDO *sdo = &SERVOS(pData)[0].Sdo;
    int32_t *words = WORDS(pData);
    if (SERVOS(pData)[0].EtherCATState != 8 || sdo->Control != 0)
        return 1;
    switch (words[0]) {
    case 0:
        ask(sdo, SDO_CONTROL_READ, 0x608F, 1, 0);
        break;
    case 1:
        words[1] = sdo->Status == 0 ? sdo->Data : -1;
        ask(sdo, SDO_CONTROL_READ, 0x5FFF, 7, 0);
        break;
    case 2:
        words[2] = sdo->Status;
        words[3] = sdo->Data;
        ask(sdo, SDO_CONTROL_WRITE, 0x6083, 0, 12345);
        break;
    case 3:
        ask(sdo, SDO_CONTROL_READ, 0x6083, 0, 0);
        break;
    case 4:
        words[4] = sdo->Status == 0 ? sdo->Data : -1;
        break;
    default:
        return 1;
    }
    words[0]++;
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
