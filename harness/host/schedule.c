/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/schedule.h"

#define S0 (SLOT_RECEIVE | SLOT_PROGRAM_05)
#define S1 (SLOT_SEND | SLOT_PROGRAM_05)
#define S2 (SLOT_PROFILE | SLOT_PROGRAM_05)
#define S3 (SLOT_PROGRAM_05 | SLOT_PROGRAM_04 | SLOT_OSCILLOSCOPE)
#define S4 (SLOT_PROGRAM_05)

static const struct slot slots_250[] = {
    { 0, S0 }, { 50, S1 }, { 100, S2 }, { 150, S3 }, { 200, S4 }
};
static const struct slot slots_500[] = {
    { 0, S0 }, { 100, S1 }, { 200, S2 }, { 300, S3 }, { 400, S4 }
};
static const struct slot slots_1000[] = { { 0, S0 },   { 100, S1 }, { 200, S2 }, { 300, S3 },
                                          { 400, S4 }, { 500, S4 }, { 600, S4 }, { 700, S4 },
                                          { 800, S4 }, { 900, S4 } };

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const struct schedule schedules[] = {
    { 250, COUNT(slots_250), slots_250 },
    { 500, COUNT(slots_500), slots_500 },
    { 1000, COUNT(slots_1000), slots_1000 },
};

const struct schedule *schedule_find(uint32_t cycle_us)
{
    for (size_t i = 0; i < COUNT(schedules); i++)
        if (schedules[i].cycle_us == cycle_us)
            return &schedules[i];
    return NULL;
}
