/* SPDX-License-Identifier: GPL-2.0-or-later */
#include "host/osc.h"

#include <string.h>

static const uint8_t widths[] = {
    [OSC_I32] = 4,     [OSC_I32_HEX] = 4,  [OSC_I32_BIN] = 4,  [OSC_U32] = 4,      [OSC_I64] = 8,
    [OSC_I64_HEX] = 8, [OSC_I64_BIN] = 8,  [OSC_U64] = 8,      [OSC_F64] = 8,      [OSC_F32] = 4,
    [OSC_STRING8] = 0, [OSC_STRING16] = 0, [OSC_I32_BITS] = 4, [OSC_I64_BITS] = 8,
};

uint32_t osc_width(uint32_t type)
{
    return type < sizeof widths ? widths[type] : 0;
}

double osc_value(const struct osc_source *source)
{
    int32_t i32;
    uint32_t u32;
    int64_t i64;
    uint64_t u64;
    double f64;
    float f32;

    switch (source->type) {
    case OSC_U32:
        memcpy(&u32, source->at, sizeof u32);
        return u32;
    case OSC_I64:
    case OSC_I64_HEX:
    case OSC_I64_BIN:
    case OSC_I64_BITS:
        memcpy(&i64, source->at, sizeof i64);
        return (double)i64;
    case OSC_U64:
        memcpy(&u64, source->at, sizeof u64);
        return (double)u64;
    case OSC_F64:
        memcpy(&f64, source->at, sizeof f64);
        return f64;
    case OSC_F32:
        memcpy(&f32, source->at, sizeof f32);
        return f32;
    default:
        memcpy(&i32, source->at, sizeof i32);
        return i32;
    }
}

/* One block a channel, in their order, all with the same number of samples. Starts are multiples of
 * 8, so that every value lies where its type wants it (O3). */
static uint64_t blocks_end(struct osc *osc, uint64_t samples)
{
    uint64_t at = 0;

    for (uint32_t i = 0; i < osc->setup.channel_count; i++) {
        at = (at + 7) & ~UINT64_C(7);
        osc->offset[i] = (uint32_t)at;
        at += samples * osc->width[i];
    }
    return at;
}

static void lay_out_blocks(struct osc *osc, uint32_t sum)
{
    uint64_t samples = osc->setup.bytes / sum;

    while (samples > 0 && blocks_end(osc, samples) > osc->setup.bytes)
        samples--;
    osc->samples = (uint32_t)samples;
    osc->stride = 0;
}

/* One record a sample; offsets are those inside a record. */
static void lay_out_records(struct osc *osc, uint32_t sum)
{
    uint32_t at = 0;

    for (uint32_t i = 0; i < osc->setup.channel_count; i++) {
        osc->offset[i] = at;
        at += osc->width[i];
    }
    osc->stride = sum;
    osc->samples = (uint32_t)(osc->setup.bytes / sum);
}

bool osc_start(struct osc *osc, const struct osc_setup *setup)
{
    uint32_t sum = 0;

    memset(osc, 0, sizeof *osc);
    osc->setup = *setup;
    for (uint32_t i = 0; i < setup->channel_count; i++) {
        osc->width[i] = osc_width(setup->channels[i].type);
        if (!osc->width[i])
            return false;
        sum += osc->width[i];
    }
    for (uint32_t i = 0; i < setup->trigger_count; i++)
        if (!osc_width(setup->triggers[i].source.type))
            return false;
    if (!sum || setup->bytes > UINT32_MAX || !setup->every)
        return false;
    if (setup->packed)
        lay_out_records(osc, sum);
    else
        lay_out_blocks(osc, sum);
    if (!osc->samples)
        return false;
    if (osc->setup.pretrigger >= osc->samples)
        osc->setup.pretrigger = osc->samples - 1;
    osc->state = setup->trigger_count ? OSC_WAITING : OSC_RECORDING;
    /* The first cycle is sampled, then every `every`th. */
    osc->since = setup->every - 1;
    return true;
}

void osc_stop(struct osc *osc)
{
    osc->state = OSC_IDLE;
}

/* A channel may show the oscilloscope's own memory, even the place that it is stored to. */
static void store(struct osc *osc)
{
    for (uint32_t i = 0; i < osc->setup.channel_count; i++) {
        size_t step = osc->stride ? osc->stride : osc->width[i];

        memmove(osc->setup.memory + osc->offset[i] + (size_t)osc->next * step,
                osc->setup.channels[i].at, osc->width[i]);
    }
    osc->next = osc->next + 1 == osc->samples ? 0 : osc->next + 1;
}

static bool due(struct osc *osc)
{
    if (++osc->since < osc->setup.every)
        return false;
    osc->since = 0;
    return true;
}

/* The register is taken as continuous: it has passed every value between two readings. The first
 * reading only says where it is (O1). */
static void judge(struct osc *osc, uint32_t i)
{
    const struct osc_trigger *t = &osc->setup.triggers[i];
    double now = osc_value(&t->source), before = osc->trigger[i].last;

    if (osc->trigger[i].seen) {
        if (t->edge == OSC_RISING && before < t->level && now >= t->level)
            osc->trigger[i].fired = true;
        if (t->edge == OSC_FALLING && before > t->level && now <= t->level)
            osc->trigger[i].fired = true;
    }
    osc->trigger[i].seen = true;
    osc->trigger[i].last = now;
}

static bool triggered(struct osc *osc)
{
    uint32_t fired = 0;

    for (uint32_t i = 0; i < osc->setup.trigger_count; i++) {
        judge(osc, i);
        fired += osc->trigger[i].fired;
    }
    return osc->setup.all ? fired == osc->setup.trigger_count : fired > 0;
}

/* Before the trigger the memory is a ring; what it keeps of it becomes the beginning. */
static void keep(struct osc *osc)
{
    if (!osc->setup.pretrigger || !due(osc))
        return;
    store(osc);
    if (osc->kept < osc->setup.pretrigger)
        osc->kept++;
}

static void begin(struct osc *osc)
{
    osc->state = OSC_RECORDING;
    osc->start =
        osc->next >= osc->kept ? osc->next - osc->kept : osc->samples - (osc->kept - osc->next);
    osc->recorded = osc->kept;
    /* The cycle that triggers is sampled (O2); samples that are kept already stay in step with what
     * follows (O5). */
    if (!osc->kept)
        osc->since = osc->setup.every - 1;
    osc->lag = osc->setup.every - 1 - osc->since;
}

static void record(struct osc *osc)
{
    if (!due(osc))
        return;
    store(osc);
    osc->recorded++;
    if (osc->setup.endless) {
        if (osc->recorded > osc->samples)
            osc->start = osc->next;
    } else if (osc->recorded >= osc->samples) {
        osc->state = OSC_IDLE;
    }
}

bool osc_cycle(struct osc *osc)
{
    if (osc->state == OSC_IDLE)
        return false;
    if (osc->state == OSC_WAITING) {
        if (triggered(osc))
            begin(osc);
        else
            keep(osc);
    }
    if (osc->state == OSC_RECORDING)
        record(osc);
    return osc->state != OSC_IDLE;
}
