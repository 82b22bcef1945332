/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/schedule.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* The PC: five or ten slots, of which the first four have work of their own. */
#define S0 (SLOT_RECEIVE | SLOT_PROGRAM_05)
#define S1 (SLOT_SEND | SLOT_PROGRAM_05)
#define S2 (SLOT_PROFILE | SLOT_PROGRAM_05)
#define S3 (SLOT_PROGRAM_05 | SLOT_PROGRAM_04 | SLOT_OSCILLOSCOPE)
#define S4 (SLOT_PROGRAM_05)

static const struct slot pc_250[] = {
    { 0, S0 }, { 50, S1 }, { 100, S2 }, { 150, S3 }, { 200, S4 }
};
static const struct slot pc_500[] = {
    { 0, S0 }, { 100, S1 }, { 200, S2 }, { 300, S3 }, { 400, S4 }
};
static const struct slot pc_1000[] = { { 0, S0 },   { 100, S1 }, { 200, S2 }, { 300, S3 },
                                       { 400, S4 }, { 500, S4 }, { 600, S4 }, { 700, S4 },
                                       { 800, S4 }, { 900, S4 } };

static const struct schedule pc[] = {
    { 250, 50, COUNT(pc_250), pc_250 },
    { 500, 100, COUNT(pc_500), pc_500 },
    { 1000, 100, COUNT(pc_1000), pc_1000 },
};

/* The controllers: everything at the beginning, and the outputs leave at half of Cycle_Time, which
 * is what Program_04 may take there (R5). */
#define WORK (SLOT_RECEIVE | SLOT_PROFILE | SLOT_PROGRAM_05 | SLOT_PROGRAM_04 | SLOT_OSCILLOSCOPE)
#define CONTROLLER(cycle_us_)                                                                      \
    {                                                                                              \
        cycle_us_, cycle_us_, 2, (const struct slot[2])                                            \
        {                                                                                          \
            { 0, WORK },                                                                           \
            {                                                                                      \
                (cycle_us_) / 2, SLOT_SEND                                                         \
            }                                                                                      \
        }                                                                                          \
    }

static const struct schedule controller[] = {
    CONTROLLER(100),  CONTROLLER(200),  CONTROLLER(250),  CONTROLLER(500),   CONTROLLER(1000),
    CONTROLLER(2000), CONTROLLER(3000), CONTROLLER(4000), CONTROLLER(5000),  CONTROLLER(6000),
    CONTROLLER(7000), CONTROLLER(8000), CONTROLLER(9000), CONTROLLER(10000),
};

static const struct {
    const struct schedule *tables;
    size_t count;
} kinds[] = {
    [SCHEDULE_PC] = { pc, COUNT(pc) },
    [SCHEDULE_CONTROLLER] = { controller, COUNT(controller) },
};

const struct schedule *schedule_find(enum schedule_kind kind, uint32_t cycle_us)
{
    for (size_t i = 0; i < kinds[kind].count; i++)
        if (kinds[kind].tables[i].cycle_us == cycle_us)
            return &kinds[kind].tables[i];
    return NULL;
}

static uint64_t next_multiple(uint64_t step_ns, uint64_t after_ns)
{
    return (after_ns / step_ns + 1) * step_ns;
}

uint64_t schedule_due(const struct product *product, uint32_t period_us, uint64_t ended_ns)
{
    const uint64_t tick = product->tick_us * UINT64_C(1000);
    const uint64_t period = period_us * UINT64_C(1000);
    if (period == 0)
        return tick != 0 ? next_multiple(tick, ended_ns) : NEVER_DUE;
    const uint64_t due = next_multiple(period, ended_ns);
    return due - ended_ns < product->margin_us * UINT64_C(1000) ? due + tick : due;
}
