/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * A module that sleeps as it is told: for each of its functions how long and how often in a call is
 * in TGM_Data, and so is what it has seen around its sleep.
 */
#include <tgm_plc.h>

#if TGM_GENERATION == 4
#define DATA_OF(pData)   ((pData)->PData_Memory)
#define SYSTEM_OF(pData) ((SYSTEM *)(pData)->PSystem_Memory)
typedef TGM_LARGE_INTEGER interval;
#else
#define DATA_OF(pData)   ((pData)->pData_Memory)
#define SYSTEM_OF(pData) ((pData)->pSystem_Memory)
typedef PLC_LARGE_INTEGER interval;
#endif

enum { FUNCTIONS = 6, INI = 0 };

/* At offset 0 of TGM_Data. */
struct report {
    int64_t units[FUNCTIONS];  /* wanted; from 0 */
    uint32_t times[FUNCTIONS]; /* wanted in each call; 48 */
    uint32_t begun[FUNCTIONS]; /* calls; 72 */
    uint32_t ended[FUNCTIONS]; /* 96 */
    struct seen {
        uint32_t tick, begun_04, begun_02;
        uint32_t wrong;                    /* what was kept over the sleep and is not what it was */
    } before[FUNCTIONS], after[FUNCTIONS]; /* the latest sleep; 120, 216 */
};

static void look(PLC_DATA *pData, struct seen *seen)
{
    const struct report *report = DATA_OF(pData);
    seen->tick = SYSTEM_OF(pData)->Main.Servo_Tick;
    seen->begun_04 = report->begun[4];
    seen->begun_02 = report->begun[2];
}

static void sleep_once(PLC_DATA *pData, unsigned number)
{
    struct report *report = DATA_OF(pData);
    interval pause;
    volatile double kept = 1.0 / (number + 3);
    uint32_t words[64];
    pause.QuadPart = report->units[number];
    for (uint32_t i = 0; i < 64; i++)
        words[i] = i * 2654435761u + number;
    look(pData, &report->before[number]);
    pData->functions.pSleepFt(&pause);
    look(pData, &report->after[number]);
    for (uint32_t i = 0; i < 64; i++)
        report->after[number].wrong += words[i] != i * 2654435761u + number;
    report->after[number].wrong += kept != 1.0 / (number + 3);
}

static long call(PLC_DATA *pData, unsigned number)
{
    struct report *report = DATA_OF(pData);
    report->begun[number]++;
    for (uint32_t i = 0; i < report->times[number]; i++)
        sleep_once(pData, number);
    report->ended[number]++;
    return 1;
}

long Program_Ini(PLC_DATA *pData)
{
    return call(pData, INI);
}

#define SLEEPER(number)                                                                            \
    long Program_0##number(PLC_DATA *pData)                                                        \
    {                                                                                              \
        return call(pData, number);                                                                \
    }

SLEEPER(1)
SLEEPER(2)
SLEEPER(3)
SLEEPER(4)
SLEEPER(5)
