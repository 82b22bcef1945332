/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A module for scenarios: it shows its inputs at its outputs, enables its servo, and counts the
 * cycles in which input 0 was on at byte 0 of TGM_Data. */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define SERVO_OF(pData) ((SERVO *)(pData)->PServo_Memory)
#define DIO_OF(pData)   ((DIO *)(pData)->PDio_Memory)
#define DATA_OF(pData)  ((uint32_t *)(pData)->PData_Memory)
#define INPUTS(dio)     ((dio)->In0)
#define OUTPUTS(dio)    ((dio)->Out0)
#else
#define SERVO_OF(pData) ((pData)->pServo_Memory)
#define DIO_OF(pData)   ((pData)->pDio_Memory)
#define DATA_OF(pData)  ((uint32_t *)(pData)->pData_Memory)
#define INPUTS(dio)     ((dio)->In[0])
#define OUTPUTS(dio)    ((dio)->Out[0])
#endif

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
IDLE(Program_05)

long Program_04(PLC_DATA *pData)
{
    DIO *dio = DIO_OF(pData);
    SERVO *servo = SERVO_OF(pData);
    servo->Mode = 1;
    servo->WritePosition = servo->Position;
    OUTPUTS(dio) = INPUTS(dio);
    DATA_OF(pData)[0] += INPUTS(dio) & 1u;
    return 1;
}
