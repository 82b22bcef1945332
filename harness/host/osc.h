/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * osc.h - the recorder inside TG Motion's oscilloscope: channels, triggers, memory. Knows no
 * registers (scope.c) and no cycle: it is told when a cycle is over.
 *
 * What the documents leave open is decided in docs/decisions.md, O1 to O9.
 */
#ifndef HARNESS_HOST_OSC_H
#define HARNESS_HOST_OSC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSC_CHANNELS 32
#define OSC_TRIGGERS 4 /* the one of OSC and the three of OSC_EX */

/* Type_Value and Type_Trigger: the codes of OSC_DATA_TYPE_... */
enum osc_type {
    OSC_I32 = 0,
    OSC_I32_HEX,
    OSC_I32_BIN,
    OSC_U32,
    OSC_I64,
    OSC_I64_HEX,
    OSC_I64_BIN,
    OSC_U64,
    OSC_F64,
    OSC_F32,
    OSC_STRING8,
    OSC_STRING16,
    OSC_I32_BITS,
    OSC_I64_BITS,
};

enum osc_edge { OSC_NO_EDGE, OSC_RISING, OSC_FALLING };

struct osc_source {
    const void *at; /* in a shared memory */
    uint32_t type;  /* enum osc_type */
};

struct osc_trigger {
    struct osc_source source;
    uint32_t edge; /* enum osc_edge; others never fire */
    double level;
};

/* What a recording is made of. Sources have been checked to lie inside their memories. */
struct osc_setup {
    struct osc_source channels[OSC_CHANNELS];
    uint32_t channel_count; /* 1..OSC_CHANNELS */
    uint32_t every;         /* cycles from one sample to the next, at least 1 */
    struct osc_trigger triggers[OSC_TRIGGERS];
    uint32_t trigger_count; /* 0: begins at once */
    bool all;               /* every trigger must have fired, else any */
    bool endless, packed;
    uint32_t pretrigger; /* samples kept from before the trigger */
    uint8_t *memory;
    size_t bytes;
};

enum osc_state { OSC_IDLE, OSC_RECORDING, OSC_WAITING };

struct osc {
    struct osc_setup setup;
    enum osc_state state;
    uint32_t width[OSC_CHANNELS];
    uint32_t offset[OSC_CHANNELS]; /* Channel[].Offset */
    uint32_t stride;               /* bytes from one packed sample to the next, 0 when not packed */
    uint32_t samples;              /* Number_Samples */
    uint32_t recorded;             /* Actual_Samples */
    uint32_t start;                /* Trigger_Start_Position: index of the oldest sample */
    uint32_t next;                 /* index of the next sample */
    uint32_t since;                /* cycles since the last sample */
    uint32_t kept;                 /* samples in the ring before the trigger */
    uint32_t lag;                  /* cycles from the trigger to the first sample after it */
    struct {
        bool seen, fired;
        double last;
    } trigger[OSC_TRIGGERS];
};

/* Bytes of a recorded value, 0 for types that cannot be recorded. */
uint32_t osc_width(uint32_t type);
double osc_value(const struct osc_source *source);

/* Lays the memory out and begins, or waits for the trigger. False: not one sample fits, or a type
 * cannot be recorded; the recorder is idle. */
bool osc_start(struct osc *osc, const struct osc_setup *setup);
void osc_stop(struct osc *osc);
/* A cycle is over: judges triggers, takes a sample when it is time. True while it records or waits;
 * false when the memory is full or nothing was started. */
bool osc_cycle(struct osc *osc);

#endif
