/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module under PLC control: says how often what was called, drives an output and an axis, and
 * remembers in a memory that the Run sequence leaves alone.
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define DATA_OF(pData)  ((pData)->PData_Memory)
#define CAM_OF(pData)   ((pData)->PCam_Memory)
#define SERVO_OF(pData) ((SERVO *)(pData)->PServo_Memory)
#define DIO_OF(pData)   ((DIO *)(pData)->PDio_Memory)
#define OUTPUTS(dio)    ((dio)->Out0)
#else
#define DATA_OF(pData)  ((pData)->pData_Memory)
#define CAM_OF(pData)   ((void *)(pData)->pCam_Memory)
#define SERVO_OF(pData) ((pData)->pServo_Memory)
#define DIO_OF(pData)   ((pData)->pDio_Memory)
#define OUTPUTS(dio)    ((dio)->Out[0])
#endif

/* At offset 0 of TGM_Data. */
struct report {
    uint32_t calls[6];
    uint32_t found; /* what a variable without a value held at the start */
};

/* At offset 0 of TGM_Cam_Profile. */
struct memory {
    uint32_t starts;
    uint32_t refuse; /* Program_Ini returns 0 */
    uint32_t fault;  /* Program_04 reads where nothing is */
};

static volatile uint32_t without_value;

long Program_Ini(PLC_DATA *pData)
{
    struct report *report = DATA_OF(pData);
    struct memory *memory = CAM_OF(pData);

    memory->starts++;
    report->calls[0]++;
    report->found = without_value;
    without_value = 0;
    return memory->refuse == 0;
}

#define COUNT(name, number)                                                                        \
    long name(PLC_DATA *pData)                                                                     \
    {                                                                                              \
        ((struct report *)DATA_OF(pData))->calls[number]++;                                        \
        without_value++;                                                                           \
        return 1;                                                                                  \
    }

COUNT(Program_01, 1)
COUNT(Program_02, 2)
COUNT(Program_03, 3)
COUNT(Program_05, 5)

long Program_04(PLC_DATA *pData)
{
    ((struct report *)DATA_OF(pData))->calls[4]++;
    OUTPUTS(DIO_OF(pData)) = 0x5A;
    SERVO_OF(pData)->WritePosition = SERVO_OF(pData)->Position;
    SERVO_OF(pData)->Mode = 1;
    if (((struct memory *)CAM_OF(pData))->fault)
        return *(volatile long *)0;
    return 1;
}
