/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The oscilloscope's registers: OSC, and in 5.02 OSC_EX and the upper bits of Control. */
#include "host/host_parts.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
#define EXTENDED           1
#define FLAG(name)         OSC_CONTROL_##name##_BIT
#define IS_WANTED(control) (((control)&OSC_CONTROL_START_RECORDING_BIT) != 0)
#else
#define EXTENDED           0
#define FLAG(name)         0u
#define IS_WANTED(control) ((int32_t)(control) > 0)
#endif

/* OSC.Status; the constants' names differ between the layouts. */
enum { IDLE = 0, RECORDING = 1, WAITING = 2 };

static const struct catalogue_memory *memory_numbered(const struct host *host, uint32_t number,
                                                      size_t *index)
{
    const struct catalogue_memory *memory;
    for (size_t i = 0; (memory = catalogue_memory(host->catalogue, i)) != NULL; i++)
        if (memory->number == number) {
            *index = i;
            return memory;
        }
    return NULL;
}

/* False: no such memory, or the value does not lie inside it. */
static bool find(const struct host *host, uint32_t number, uint32_t offset, uint32_t type,
                 struct osc_source *source)
{
    size_t index;
    const struct catalogue_memory *memory = memory_numbered(host, number, &index);
    const uint32_t width = osc_width(type);
    if (memory == NULL || width == 0 || offset > host->memory_bytes[index] ||
        host->memory_bytes[index] - offset < width)
        return false;
    *source = (struct osc_source){ (const char *)host->memory[index] + offset, type };
    return true;
}

static bool add_trigger(const struct host *host, struct osc_setup *setup, uint32_t memory,
                        uint32_t offset, uint32_t mode, uint32_t type, double level)
{
    struct osc_trigger *trigger = &setup->triggers[setup->trigger_count];
    if (mode == OSC_NO_EDGE)
        return true;
    if (mode > OSC_FALLING || !find(host, memory, offset, type, &trigger->source))
        return false;
    trigger->edge = mode;
    trigger->level = level;
    setup->trigger_count++;
    return true;
}

#if EXTENDED
/* The three triggers add to that of OSC (O6). */
static bool add_extended(const struct host *host, struct osc_setup *setup)
{
    const OSC_EX *ex = &host->system->Osc_Ex;
    bool good = true;
    for (int i = 0; i < OSC_EX_OSC_EX_TRIGGER_COUNT; i++) {
        const OSC_EX_TRIGGER *t = &ex->Trigger[i];
        good =
            good && add_trigger(host, setup, t->Memory_Type, t->Offset, t->Mode, t->Type, t->Level);
    }
    setup->all = ex->Function == OSC_EX_TRIGGER_FUNCTION_LOGICAL_AND;
    return good;
}
#else
static bool add_extended(const struct host *host, struct osc_setup *setup)
{
    (void)host, (void)setup;
    return true;
}
#endif

static bool read_setup(const struct host *host, uint32_t control, struct osc_setup *setup)
{
    const OSC *reg = &host->system->Osc;
    size_t index;
    memset(setup, 0, sizeof *setup);
    if (reg->Number_Chanels < 1 || reg->Number_Chanels > OSC_CHANNELS ||
        memory_numbered(host, SHARED_MEMORY_OSCILLOSCOPE, &index) == NULL)
        return false;
    setup->channel_count = reg->Number_Chanels;
    for (uint32_t i = 0; i < setup->channel_count; i++)
        if (!find(host, (uint32_t)reg->Channel[i].Memory_Type_Value,
                  (uint32_t)reg->Channel[i].Offset_Value, (uint32_t)reg->Channel[i].Type_Value,
                  &setup->channels[i]))
            return false;
    setup->every = reg->Number_Periods != 0 ? (uint32_t)reg->Number_Periods : 1;
    setup->endless = (control & FLAG(INFINITE_RECORDING)) != 0;
    setup->packed = (control & FLAG(STORE_PACKED_DATA)) != 0;
    setup->memory = host->memory[index];
    setup->bytes = host->memory_bytes[index];
    if (!add_trigger(host, setup, (uint32_t)reg->Memory_Type_Trigger, (uint32_t)reg->Offset_Trigger,
                     (uint32_t)reg->Mode_Trigger, (uint32_t)reg->Type_Trigger,
                     reg->Level_Trigger) ||
        !add_extended(host, setup))
        return false;
#if EXTENDED
    if (setup->trigger_count > 0)
        setup->pretrigger = control >> OSC_CONTROL_PRETRIGGER_SHIFT;
#endif
    return true;
}

#if EXTENDED
/* The options as the recording has them: those of Control count when it starts (O5). */
static uint32_t options(const struct osc_setup *setup)
{
    return (setup->endless ? OSC_STATUS_INFINITE_RECORDING_BIT : 0u) |
           (setup->packed ? OSC_STATUS_STORE_PACKED_DATA_BIT : 0u) |
           (setup->pretrigger << OSC_CONTROL_PRETRIGGER_SHIFT);
}
#endif

static void publish(struct host *host, uint32_t control)
{
    OSC *reg = &host->system->Osc;
    const struct osc *osc = &host->osc;
    uint32_t status = osc->state == OSC_RECORDING ? RECORDING
                      : osc->state == OSC_WAITING ? WAITING
                                                  : IDLE;
#if EXTENDED
    if (osc->state != OSC_IDLE) {
        if ((control & OSC_CONTROL_PAUSE_RECORDING_BIT) != 0)
            status = OSC_STATUS_PAUSE_04;
        status |= options(&osc->setup);
    }
    reg->Trigger_Start_Position = osc->start;
#else
    (void)control;
#endif
    reg->Status = (typeof(reg->Status))status;
    reg->Actual_Samples = osc->recorded;
}

/* A set-up that cannot be recorded ends at once, as a full memory does, with no sample (O7). */
static void start(struct host *host, uint32_t control)
{
    OSC *reg = &host->system->Osc;
    struct osc_setup setup;
    if (!read_setup(host, control, &setup) || !osc_start(&host->osc, &setup)) {
        memset(&host->osc, 0, sizeof host->osc);
        reg->Number_Samples = 0;
        reg->Control = 0;
        publish(host, 0);
        return;
    }
    for (uint32_t i = 0; i < setup.channel_count; i++)
        reg->Channel[i].Offset = host->osc.offset[i];
    reg->Number_Samples = host->osc.samples;
    reg->Sample_Time = setup.every * host->config.cycle_us;
}

static void scope_sample(struct host *host)
{
    OSC *reg = &host->system->Osc;
    const uint32_t control = (uint32_t)reg->Control;
    struct osc *osc = &host->osc;
    if (osc->state == OSC_IDLE && !IS_WANTED(control))
        return;
    if (osc->state == OSC_IDLE)
        start(host, control);
    else if (!IS_WANTED(control))
        osc_stop(osc);
    if (osc->state == OSC_IDLE) {
        publish(host, 0);
        return;
    }
    if ((control & FLAG(PAUSE_RECORDING)) == 0 && !osc_cycle(osc))
        reg->Control = 0;
    publish(host, control);
}

static int scope_open(struct host *host, char why[HOST_WHY])
{
    (void)why;
#if EXTENDED
    host->system->Main.Implemented_Features |= FEATURE_NEW_OSCILLOSCOPE;
#else
    (void)host;
#endif
    return 0;
}

static bool type_of(enum scalar scalar, uint32_t *type)
{
    static const int8_t types[] = {
        [I8] = -1,       [U8] = -1,       [I16] = -1,      [U16] = -1,
        [I32] = OSC_I32, [U32] = OSC_U32, [I64] = OSC_I64, [U64] = OSC_U64,
        [F32] = OSC_F32, [F64] = OSC_F64, [STRUCT] = -1,
    };
    *type = (uint32_t)types[scalar];
    return types[scalar] >= 0;
}

static int refuse(char why[HOST_WHY], const struct catalogue_register *reg)
{
    snprintf(why, HOST_WHY, "the oscilloscope does not record registers of type %s",
             scalar_name(reg->type));
    return -EINVAL;
}

int scope_arm(struct host *host, const struct host_osc *wanted, char why[HOST_WHY])
{
    OSC *reg = &host->system->Osc;
    uint32_t type, control = 1;
    if (wanted->count < 1 || wanted->count > OSC_CHANNELS) {
        snprintf(why, HOST_WHY, "the oscilloscope has 1 to %d channels, not %zu", OSC_CHANNELS,
                 wanted->count);
        return -EINVAL;
    }
    for (size_t i = 0; i < wanted->count; i++) {
        const struct catalogue_register *channel = &wanted->channels[i];
        if (!type_of(channel->type, &type))
            return refuse(why, channel);
        reg->Channel[i].Memory_Type_Value = channel->memory->number;
        reg->Channel[i].Offset_Value = (uint32_t)channel->offset;
        reg->Channel[i].Type_Value = type;
    }
    if (wanted->triggered && !type_of(wanted->trigger.type, &type))
        return refuse(why, &wanted->trigger);
    if (wanted->triggered) {
        reg->Memory_Type_Trigger = wanted->trigger.memory->number;
        reg->Offset_Trigger = (uint32_t)wanted->trigger.offset;
        reg->Type_Trigger = type;
        reg->Level_Trigger = wanted->level;
    }
    reg->Mode_Trigger = wanted->triggered ? (wanted->falling ? OSC_FALLING : OSC_RISING) : 0;
    if (wanted->pretrigger != 0 && (!EXTENDED || !wanted->triggered)) {
        snprintf(why, HOST_WHY, "samples before the trigger need TG Motion 5.02 and a trigger");
        return -EINVAL;
    }
#if EXTENDED
    control |= wanted->pretrigger << OSC_CONTROL_PRETRIGGER_SHIFT;
#endif
    reg->Number_Chanels = (uint32_t)wanted->count;
    reg->Number_Periods = wanted->every;
    reg->Control = (typeof(reg->Control))control;
    return 0;
}

size_t scope_samples(const struct host *host)
{
    const struct osc *osc = &host->osc;
    return osc->recorded < osc->samples ? osc->recorded : osc->samples;
}

/* Read back from TGM_Oscilloscope, as any program would. */
void scope_row(const struct host *host, size_t index, double *row)
{
    const struct osc *osc = &host->osc;
    const size_t place = (osc->start + index) % osc->samples;
    *row++ = (((double)index - osc->kept) * osc->setup.every + osc->lag) * host_cycle_seconds(host);
    for (uint32_t i = 0; i < osc->setup.channel_count; i++) {
        const size_t step = osc->stride != 0 ? osc->stride : osc->width[i];
        const struct osc_source stored = { osc->setup.memory + osc->offset[i] + place * step,
                                           osc->setup.channels[i].type };
        *row++ = osc_value(&stored);
    }
}

const struct host_part host_scope = { .name = "oscilloscope",
                                      .open = scope_open,
                                      .sample = scope_sample };
